"""How the solid of a period hangs together with its own repetitions: which ways a piece leads through, and islands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of the periodic solid: its `share` of all of it, a place in it (an index of the array), and along which
    of x, y, z it leads from a cell into the next and on: none of an island."""

    share: float
    at: tuple[int, int, int]
    leads: tuple[bool, bool, bool]

    @property
    def axes(self) -> list[str]:
        """The names of the axes along which it leads on."""
        return [name for name, on in zip("xyz", self.leads, strict=True) if on]


def pieces_of(solid: NDArray[Any], corners: bool = False) -> list[Piece]:
    """The pieces of a periodic array, of what is not 0 in it; the largest first, by the sum of what it holds.

    What has a common face is one, with `corners` also what has a common edge or corner: as voxels hang together that
    are elements with common nodes.
    """
    from scipy import ndimage

    shape = np.array(solid.shape)
    around = np.pad(solid, 1, mode="wrap")
    labels, count = ndimage.label(around != 0, np.ones((3, 3, 3)) if corners else None)
    inner = labels[1:-1, 1:-1, 1:-1]
    sizes = np.bincount(inner.ravel(), np.asarray(solid, np.float64).ravel(), count + 1)
    first = np.zeros(count + 1, np.int64)  # where each is found first: of what is written twice the last stays
    first[inner.ravel()[::-1]] = np.arange(inner.size)[::-1]
    joined: list[list[tuple[int, Any]]] = [[] for _ in range(count + 1)]
    for label, home, step in _through_faces(labels, shape):
        joined[label].append((home, step))
        joined[home].append((label, -step))
    moved: list[Any] = [None] * (count + 1)
    out = []
    for start in range(1, count + 1):
        if moved[start] is not None:
            continue
        moved[start] = np.zeros(3, int)
        members, turns = [start], []
        for member in members:  # grows while it is walked
            for other, step in joined[member]:
                there = moved[member] + step
                if moved[other] is None:
                    moved[other] = there
                    members.append(other)
                elif (there != moved[other]).any():
                    turns.append(there - moved[other])
        leads = np.any(np.array(turns).reshape(-1, 3) != 0, axis=0)
        largest = max(members, key=lambda m: sizes[m])
        at = np.unravel_index(first[largest], inner.shape)
        share = float(sizes[members].sum() / sizes[1:].sum())
        place, along = (int(at[0]), int(at[1]), int(at[2])), (bool(leads[0]), bool(leads[1]), bool(leads[2]))
        out.append(Piece(share, place, along))
    return sorted(out, key=lambda piece: -piece.share)


def _through_faces(labels: NDArray[Any], shape: NDArray[Any]) -> list[tuple[int, int, Any]]:
    """What is the same across the faces of a period: the label of a place just beyond them, the label of that place in
    the period, and how many periods lie between (3,)."""
    found = []
    for axis in range(3):
        for end in (0, shape[axis] + 1):
            face = [np.arange(n + 2) for n in shape]
            face[axis] = np.array([end])
            index = np.stack(np.meshgrid(*face, indexing="ij"), -1).reshape(-1, 3)
            step = (index - 1) // shape
            home = index - step * shape
            there = labels[tuple(index.T)]
            kept = there > 0
            found.append(np.column_stack([there, labels[tuple(home.T)], step])[kept])
    return [(int(row[0]), int(row[1]), row[2:]) for row in np.unique(np.concatenate(found), axis=0)]
