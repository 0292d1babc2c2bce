"""Whether a box of a field is a period of it: what opposite faces have in common, and what lies whole periods away."""

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
#: Points of the part, of each of two ways to spread them, that are compared with those in the cell.
_SCATTERED = 1 << 14


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


@dataclass(frozen=True, slots=True)
class Strayed:
    """That a field is not the same whole periods away: the share of points of the part where one is solid and the
    other void, and the point (mm) of these that is nearest to the cell, the one that it is in the cell, and both
    values."""

    share: float
    at: tuple[float, float, float]
    within: tuple[float, float, float]
    here: float
    home: float


def strayed(
    field: Callable[[Floats], Floats], envelope: Callable[[Floats], Floats] | None, low: Floats, cell: Floats,
    lo: Floats, hi: Floats,
) -> Strayed | None:  # fmt: skip
    """Where a field of points (n, 3) in the box from `lo` to `hi`, as far as an `envelope` reaches, is not what it is
    in the cell of the sides `cell` at the corner `low`, whole numbers of sides away; None where it is everywhere.

    Half of the points are spread evenly, and half lie as often twice as far as half as far from the cell: a lattice may
    be graded near its middle, or only at the end of a long part.
    """
    random = np.random.default_rng(0)
    middle = low + cell / 2
    far = np.where(random.random((_SCATTERED, 3)) < 0.5, lo - middle, hi - middle)
    near = np.minimum(np.abs(far), cell / 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.sign(far) * near * np.where(near > 0, np.abs(far) / near, 1.0) ** random.random(far.shape)
    even = lo + random.random(far.shape) * (hi - lo)
    points = np.concatenate([even, middle + np.where(np.isfinite(log), log, 0.0)])
    points = points[((points >= lo) & (points <= hi)).all(axis=1)]
    if envelope is not None:
        points = points[envelope(points) < 0]
    turns = np.floor((points - low) / cell)
    kept = np.any(turns != 0, axis=1)
    points, home = points[kept], (points - turns * cell)[kept]
    there, here = field(points), field(home)
    told = np.isfinite(there) & np.isfinite(here)
    odd = told & ((there < 0) != (here < 0))
    if not odd.any():
        return None
    away = np.max(np.abs(points - middle) / cell, axis=1)
    first = int(np.argmin(np.where(odd, away, np.inf)))
    (x, y, z), (a, b, c) = points[first].tolist(), home[first].tolist()
    share = float(odd.sum() / told.sum())
    return Strayed(share, (x, y, z), (a, b, c), float(there[first]), float(here[first]))


def middles(low: Floats, cell: Floats, counts: tuple[int, int, int]) -> list[Floats]:
    """The coordinates (mm) along each axis of the middles of counts equal parts of a box."""
    return [lo + (np.arange(n) + 0.5) * side / n for lo, side, n in zip(low, cell, counts, strict=True)]
