"""The process that measures distances to a mesh.

`python -m porelang.tasks.shape.child ENDING ERROR MARGIN UNIT IN OUT`

libigl and the readers of mesh files are native code, or trust what a file claims: what they do to this process is no
harm to a program. IN and OUT are descriptors of files: the mesh, and an .npz of what was made of it. On standard output
stand lines `done total`. Standard input is a lifeline: when the parent ends, it closes.
"""

from __future__ import annotations

import io
import json
import os
import sys
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.tasks.shape.distance import DEFAULT, cell, distances
from porelang.tasks.shape.file import UnusableError
from porelang.tasks.shape.mend import ONE, distinct, merged
from porelang.tasks.shape.soup import Soup, soup
from porelang.tasks.shape.surface import SEAM, closed


def main(ending: str, error: float, margin: float, unit: float, source: int, target: int) -> None:
    try:
        with os.fdopen(source, "rb") as file:
            read = soup(io.BytesIO(file.read()), ending, unit, error)
        found = measured(read, error, margin)
    except UnusableError as reason:
        found = {"refused": np.array(json.dumps(reason.args))}
    with os.fdopen(target, "wb") as out:
        np.savez(out, allow_pickle=False, **found)


def measured(read: Soup, error: float, margin: float) -> dict[str, NDArray[Any]]:
    """The distances as arrays by name; `facts` are as `porelang.tasks.shape` tells them."""
    longest = float(np.ptp(read.vertices, axis=0).max())
    gap = SEAM * cell(longest, error, read.chord)
    mesh = closed(read.vertices, read.faces, gap)
    made = distances(mesh, error, margin, told, read.chord)
    first = mesh.holes[0][1] if mesh.holes else np.zeros(3)
    opened = sum(n for n, _ in mesh.holes)
    used = mesh.vertices[mesh.faces]
    box = [*used.min(axis=(0, 1)), *used.max(axis=(0, 1))]
    count = len(read.faces)
    repeated = count - len(distinct(merged(read.vertices, read.faces, ONE * gap)))
    facts = [
        count,
        opened,
        len(mesh.holes),
        *first,
        made.error,
        made.beyond,
        *box,
        made.lost,
        *made.lost_at,
        read.unit,
        repeated,
        error if np.isfinite(error) else longest / DEFAULT,
        mesh.sheets,
        mesh.within,
        mesh.loose,
    ]
    return {
        "values": made.values,
        "origin": made.origin,
        "spacing": np.array(made.spacing),
        "facts": np.array(facts, np.float64),
    }


def told(done: int, total: int) -> None:
    print(done, total, flush=True)


def hold_lifeline() -> None:
    """End this process when the parent closes its standard input, which it does when it ends in whatever way."""

    def wait() -> None:
        os.read(0, 1)
        os._exit(0)

    threading.Thread(target=wait, daemon=True).start()


if __name__ == "__main__":
    hold_lifeline()
    ending, *numbers, source, target = sys.argv[1:]
    error, margin, unit = map(float, numbers)
    main(ending, error, margin, unit, int(source), int(target))
