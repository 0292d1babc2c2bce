"""Whether a box of a field is a period of it: samples of the box, and what opposite faces have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: Points along a side of a face that are compared, and how far inside of the box they lie, as a share of its side: so
#: near that no surface that crosses the face passes between, so far that a box that cuts the part does not hide it.
_ALONG, _INSIDE = 96, 1e-7
#: Faces that differ at this share of their points belong to no period; below it they nearly do.
DIFFERENT = 1e-3


@dataclass(frozen=True, slots=True)
class Mismatch:
    """That opposite faces across an axis are not alike: the share of points where one is solid and the other void, and
    the point (mm, on the lower face) where the field differs most, with its values there and opposite."""

    axis: int
    share: float
    at: tuple[float, float, float]
    below: float
    above: float


def mismatches(field: Callable[[Floats], Floats], low: Floats, cell: Floats) -> list[Mismatch]:
    """Where the faces of the box of the sides `cell` at the corner `low` (mm) differ in a field of points (n, 3); by
    axis, of those that differ anywhere."""
    out = []
    # places at odds with every period, so that no plane of symmetry falls on them
    along = (np.arange(_ALONG) + 0.382) / _ALONG
    for axis in range(3):
        a, b = ((axis + 1) % 3, (axis + 2) % 3)
        grid = np.empty((_ALONG, _ALONG, 3))
        grid[..., a] = low[a] + along[:, None] * cell[a]
        grid[..., b] = low[b] + along[None, :] * cell[b]
        grid[..., axis] = low[axis] + _INSIDE * cell[axis]
        points = grid.reshape(-1, 3)
        opposite = points.copy()
        opposite[:, axis] = low[axis] + (1 - _INSIDE) * cell[axis]
        below, above = field(points), field(opposite)
        odd = (below < 0) != (above < 0)
        if odd.any():
            with np.errstate(invalid="ignore"):
                most = int(np.argmax(np.where(odd, np.nan_to_num(np.abs(below - above), posinf=1e300), -1.0)))
            x, y, z = (float(v) for v in points[most])
            out.append(Mismatch(axis, float(odd.mean()), (x, y, z), float(below[most]), float(above[most])))
    return out


def middles(low: Floats, cell: Floats, counts: tuple[int, int, int]) -> list[Floats]:
    """The coordinates (mm) along each axis of the middles of counts equal parts of a box."""
    return [lo + (np.arange(n) + 0.5) * side / n for lo, side, n in zip(low, cell, counts, strict=True)]


def voxels_of(cell: Floats, finest: int) -> tuple[int, int, int]:
    """As many voxels along each side of a cell as make them nearly cubes, `finest` along the longest; 4 at least."""
    x, y, z = (max(4, round(finest * side / cell.max())) for side in cell)
    return x, y, z
