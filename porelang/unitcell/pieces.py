"""How the solid of a period hangs together with its own repetitions: which ways a piece leads through, and islands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of the periodic solid: its `share` of all solid samples, a place in it (index of a sample), and along
    which of x, y, z it leads from a cell into the next and on: none of an island."""

    share: float
    at: tuple[int, int, int]
    leads: tuple[bool, bool, bool]

    @property
    def axes(self) -> list[str]:
        """The names of the axes along which it leads on."""
        return [name for name, on in zip("xyz", self.leads, strict=True) if on]


def pieces_of(solid: NDArray[np.bool_]) -> list[Piece]:
    """The pieces of a periodic array, those with common faces being one; the largest first."""
    from scipy import ndimage

    labels, count = ndimage.label(solid)
    labels = labels - 1
    joined: list[list[tuple[int, tuple[int, int, int]]]] = [[] for _ in range(count)]
    for axis in range(3):
        last, first = np.take(labels, -1, axis), np.take(labels, 0, axis)
        both = (last >= 0) & (first >= 0)
        step = tuple(int(a == axis) for a in range(3))
        for a, b in np.unique(np.stack([last[both], first[both]], axis=1), axis=0):
            joined[a].append((int(b), step))
            joined[b].append((int(a), tuple(-s for s in step)))
    sizes = np.bincount(labels[labels >= 0], minlength=count)
    moved: list[Any] = [None] * count
    out = []
    for start in range(count):
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
        at = np.unravel_index(int(np.argmax(labels == largest)), labels.shape)
        share = float(sizes[members].sum() / sizes.sum())
        place, along = (int(at[0]), int(at[1]), int(at[2])), (bool(leads[0]), bool(leads[1]), bool(leads[2]))
        out.append(Piece(share, place, along))
    return sorted(out, key=lambda piece: -piece.share)
