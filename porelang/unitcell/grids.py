"""The grids that a cell is solved on: four, whose voxels are the same share larger along every axis.

Only then is one number the size of a voxel, and what four grids tend to can be told. So the finest grid has a multiple
of eight voxels along each side, and the others 3/8, 1/2 and 3/4 of them. An axis along which nothing varies has two
voxels on every grid, which is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail

Floats = NDArray[np.float64]
Counts = tuple[int, int, int]
#: The voxels of each grid along a side, in eighths of those of the finest.
EIGHTHS = (3, 4, 6, 8)
#: Voxels along an axis that nothing varies along; the fewest of the finest grid along the shortest side that something
#: varies along (or as many as are asked for along the longest); the most in all, but for a cube of what is asked for.
ALIKE, FEWEST, MOST = 2, 24, 128**3
#: Samples along the longest side at least; where walls are thinner than TO_A_WALL of them as many more as these ask
#: for, but no more than so many.
SAMPLES, TO_A_WALL, MOST_SAMPLES = 192, 6.0, 384


@dataclass(frozen=True, slots=True)
class Grids:
    """The voxels of each grid along x, y and z, the coarsest first, and the samples that all are made from: a whole
    number of them along every voxel."""

    voxels: tuple[Counts, ...]
    samples: Counts

    @property
    def finest(self) -> Counts:
        """The voxels of the finest grid."""
        return self.voxels[-1]


def sizes_of(count: int = len(EIGHTHS)) -> Floats:
    """How large the voxels of the grids are, the coarsest first, those of the finest being 1."""
    return 8 / np.array(EIGHTHS[-count:], np.float64)


def grids(sides: Floats, varies: tuple[bool, bool, bool], finest: int, wall: float | None = None) -> Grids:
    """The grids of a cell of the sides (3,) in which something `varies` along some axes, with `finest` voxels along the
    longest of these: rounded up to eights, and more where the shortest has less than 24 then. `wall` is how thick the
    thinnest walls are, in the unit of the sides.

    Errors: E180 where that are too many.

    >>> grids(np.array([10.0, 10, 15]), (True, True, True), 64).voxels
    ((15, 15, 24), (20, 20, 32), (30, 30, 48), (40, 40, 64))
    >>> grids(np.array([10.0, 10, 150]), (True, True, False), 64).finest
    (64, 64, 2)
    """
    counted = sides[np.array(varies)]
    if not len(counted):
        return Grids((_three([ALIKE] * 3),) * len(EIGHTHS), _three([ALIKE] * 3))
    finest = 8 * -(-finest // 8)
    voxel = min(counted.max() / finest, counted.min() / min(FEWEST, finest))
    eights = [max(1, round(float(side) / voxel / 8)) if on else 0 for side, on in zip(sides, varies, strict=True)]
    if np.prod([8.0 * e or ALIKE for e in eights]) > max(MOST, finest**3):
        told = " x ".join(f"{s:g}" for s in sides)
        raise fail("E180", f"a cell of {told} mm is too long for its width: {' x '.join(str(8 * e) for e in eights)} "
                   "voxels are too many", hint="take a shorter period, or a lower --resolution")  # fmt: skip
    asked = min(float(MOST_SAMPLES), TO_A_WALL * counted.max() / wall) if wall else 0.0
    more = int(np.ceil(max(SAMPLES, asked) / (24 * max(eights))))
    return Grids(
        tuple(_three([e * part or ALIKE for e in eights]) for part in EIGHTHS),
        _three([24 * more * e or ALIKE for e in eights]),
    )


def _three(counts: list[int]) -> Counts:
    x, y, z = counts
    return x, y, z
