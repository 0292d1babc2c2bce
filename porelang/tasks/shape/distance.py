"""The signed distance to the surface of a mesh at the nodes of a grid, and by how much it errs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from porelang.data import NEAREST
from porelang.tasks.shape.file import UnusableError
from porelang.tasks.shape.mend import Mask, Points
from porelang.tasks.shape.surface import PER_SQUARE, SEAM, Closed, boundary, cut, halved, slices

#: Trilinear interpolation of what changes by 1 mm a mm errs by half a cell's diagonal at most, where nodes are exact.
HALF_DIAGONAL = 0.75**0.5
#: Cells on both sides of the surface at whose nodes the distance is exact.
BAND = 3.0
#: Bits of triangles, no longer than a cell, at most: 1 GB.
MOST_BITS = 10_000_000
#: Cells that a triangle is long at most, where there are many.
LONG = 8
#: 512 MB of float32, and a few minutes.
MOST_NODES = 128_000_000
DEFAULT = 128  # errors that the longest side has room for, where none is given
#: Of a surface, squares of a cell for each node, at most: walls and gaps that samples tell apart are some cells thick.
DENSE = 0.4
CHECKED = 4000  # nodes beyond the band at which its error is measured

Told = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Sampled:
    """Distances (nx, ny, nz) in mm from a first node on, every `spacing` mm; a lookup near the surface errs by `error`
    at most. `beyond` is by how much nodes err that are farther away, measured at some of them.

    `lost` is the share of the surface about which all nodes are on one side: of walls and gaps that are thinner than
    cells. `lost_at` is a place of it.
    """

    values: NDArray[np.float32]
    origin: Points
    spacing: float
    error: float
    beyond: float
    lost: float
    lost_at: Points


def distances(mesh: Closed, error: float, margin: float, told: Told, chord: float = 0.0) -> Sampled:
    """Signed distances over the box of a mesh and `margin` mm more; NaN for what is not given. Errors: UnusableError.

    `chord` is the share of the error by which the triangles themselves may be off what they stand for.

    Within `BAND` cells of the surface nodes are exact. Farther off a node p takes the distance to the place f of the
    surface which is nearest to the nearest such node q: never too little. The way from p to the surface, d long, passes
    within half a diagonal of a node that is exact, and by `BAND` cells less half a diagonal away. So |p - q| is d less
    `BAND` cells and two halves at most, and |p - f| <= |p - q| + |q - f| is d and a diagonal at most: twice `error`.
    """
    corners = mesh.vertices[mesh.faces]
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    longest = float((hi - lo).max())
    if longest < NEAREST:
        raise UnusableError("E141", f"is {longest:g} mm long", "check the unit of the file, as in `unit=1m`")
    if np.isfinite(error) and error > 0.5 * longest:
        raise UnusableError("E143", f"is {longest:.4g} mm long, and an error of {error:g} mm takes in all of it",
                            f"`error={longest / DEFAULT:.2g}mm` is what is taken where none is given")  # fmt: skip
    error = error if np.isfinite(error) else longest / DEFAULT
    margin = margin if np.isfinite(margin) else longest / 16
    h = cell(longest, error, chord)
    margin = max(margin, 2 * h)
    nodes = [int(np.ceil((b - a + 2 * margin) / h)) + 1 for a, b in zip(lo, hi, strict=True)]
    if (total := float(np.prod(np.array(nodes, float)))) > MOST_NODES:
        enough = 1.05 * error * (total / MOST_NODES) ** (1 / 3)
        raise UnusableError("E143", f"takes {total:.2g} samples for an error of {error:g} mm",
                            f"`error={enough:.2g}mm` would do, {MOST_NODES:,} are the most")  # fmt: skip
    area = 0.5 * float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    )
    if (count := PER_SQUARE * area / h**2) > MOST_BITS:
        enough = 1.05 * error * (count / MOST_BITS) ** 0.5
        raise UnusableError("E143", f"has {area:.2g} mm2 of triangles, which are too many for an error of {error:g} mm",
                            f"`error={enough:.2g}mm` would do; does it cross itself everywhere?")  # fmt: skip
    if (dense := area / h**2 / total) > DENSE:
        enough = 0.95 * error * DENSE / dense
        raise UnusableError("E143", f"has {area:.2g} mm2 of triangles, too many to be told apart every {h:.2g} mm",
                            f"mend it if it crosses itself all over; else `error={enough:.2g}mm` would do")  # fmt: skip
    mesh = cut(mesh, LONG * h)
    surface, seam = boundary(mesh, h, told)
    if not len(surface):
        raise UnusableError("E142", "encloses nothing: it is a sheet, not a body", "close it, or give it a thickness")
    origin = 0.5 * (lo + hi) - 0.5 * h * (np.array(nodes) - 1)
    axes = [o + h * np.arange(n) for o, n in zip(origin, nodes, strict=True)]
    bits, _ = halved(surface, np.arange(len(surface)), h)
    values, beyond = _sampled(mesh, surface, bits.mean(axis=1), axes, h, told)
    lost, lost_at = _lost(bits, values, origin, h)
    return Sampled(values, origin, h, error + seam - SEAM * h, beyond, lost, lost_at)


def cell(longest: float, error: float, chord: float) -> float:
    """The size of cells, in mm, for a mesh that is `longest` mm long; the rest as `distances` takes it."""
    error = error if np.isfinite(error) else longest / DEFAULT
    return (1 - chord) * error / (HALF_DIAGONAL + SEAM)


def _sampled(
    mesh: Closed, surface: Points, middles: Points, axes: list[Points], h: float, told: Told
) -> tuple[NDArray[np.float32], float]:
    shape = tuple(map(len, axes))
    places = np.argwhere(_close_by(middles, axes, h))
    found, feet = _to_surface(surface, nodes_at(axes, places), told)
    exact = found <= BAND * h
    near = np.zeros(shape, np.bool_)
    near[tuple(places[exact].T)] = True
    index = distance_transform_edt(~near, return_distances=False, return_indices=True)
    number = np.zeros(shape, np.int32)
    number[tuple(places.T)] = np.arange(len(places))
    number = number[tuple(index)].reshape(-1)
    del index
    flat = np.empty(near.size)
    for some in slices(near.size):
        here = nodes_at(axes, np.stack(np.unravel_index(np.arange(some.start, some.stop), shape), axis=1))
        flat[some] = np.linalg.norm(here - feet[number[some]], axis=1)
        told(some.start, near.size)
    values = flat.reshape(shape)
    values[tuple(places.T)] = found
    near[tuple(places.T)] = True
    error = _checked(surface, axes, values, near, told)
    values[_inside(mesh, axes, values, h, told)] *= -1
    return values.astype(np.float32), error


def _to_surface(surface: Points, places: Points, told: Told) -> tuple[Points, Points]:
    """The distances of places (n, 3) to triangles (m, 3, 3), and the places there that are nearest."""
    corners = np.ascontiguousarray(surface.reshape(-1, 3))
    faces = np.arange(len(corners)).reshape(-1, 3)
    found, feet = np.zeros(len(places)), np.zeros((len(places), 3))
    for some in slices(len(places)):
        told(some.start, len(places))
        squares, _, feet[some] = igl.point_mesh_squared_distance(places[some], corners, faces)
        found[some] = np.sqrt(squares)
    return found, feet


def _inside(mesh: Closed, axes: list[Points], away: Points, h: float, told: Told) -> Mask:
    """Which nodes are inside, of all whose distances are known. Two beside each other, both more than half a cell away
    from the surface, lie on one side of it: of all that hang together so, one is asked."""
    close = away <= 0.5001 * h
    regions, count = label(~close)
    _, first = np.unique(regions, return_index=True)
    places = np.argwhere(close)
    asked = np.concatenate([places, np.stack(np.unravel_index(first, away.shape), axis=1)])
    within = mesh.winds_round(nodes_at(axes, asked), told)
    of_region = np.zeros(count + 1, np.bool_)
    of_region[regions.reshape(-1)[first]] = within[len(places) :]
    found: Mask = of_region[regions]
    found[close] = within[: len(places)]
    return found


def _close_by(middles: Points, axes: list[Points], h: float) -> Mask:
    """The nodes within BAND cells of a surface of triangles that are no longer than a cell, and some more."""
    touched = np.zeros(tuple(map(len, axes)), np.bool_)
    origin = np.array([a[0] for a in axes])
    touched[tuple(np.rint((middles - origin) / h).astype(int).T)] = True
    # A middle lies within h / sqrt(3) of all of its triangle, and its node within half a diagonal of it.
    return np.asarray(distance_transform_edt(~touched) <= BAND + HALF_DIAGONAL + 3**-0.5)


def _checked(surface: Points, axes: list[Points], values: Points, near: Mask, told: Told) -> float:
    """The largest error of the distances at some nodes beyond the band."""
    far = np.flatnonzero(~near)
    if not len(far):
        return 0.0
    some = np.random.default_rng(1).choice(far, min(CHECKED, len(far)), replace=False)
    here = nodes_at(axes, np.stack(np.unravel_index(some, near.shape), axis=1))
    return float(np.abs(values.reshape(-1)[some] - _to_surface(surface, here, told)[0]).max())


def _lost(bits: Points, values: NDArray[np.float32], origin: Points, h: float) -> tuple[float, Points]:
    """The share of a surface with nodes on one side alone in its cell and those beside it, and a place of it."""
    middles = bits.mean(axis=1)
    most = np.array(values.shape) - 1
    number = np.ravel_multi_index(np.floor((middles - origin) / h).astype(np.int64).T, values.shape)
    numbers, cell_of = np.unique(number, return_inverse=True)
    cells = np.stack(np.unravel_index(numbers, values.shape), axis=1)
    sides = np.zeros((2, len(cells)), np.bool_)
    for away in np.ndindex(4, 4, 4):
        i, j, k = np.clip(cells + np.array(away) - 1, 0, most).T
        inside = values[i, j, k] < 0
        sides[0] |= inside
        sides[1] |= ~inside
    lost = ~(sides[0] & sides[1])[cell_of]
    if not lost.any():
        return 0.0, np.zeros(3)
    area = np.linalg.norm(np.cross(bits[:, 1] - bits[:, 0], bits[:, 2] - bits[:, 0]), axis=1)
    return float(area[lost].sum() / area.sum()), middles[lost][int(area[lost].argmax())]


def nodes_at(axes: list[Points], index: NDArray[np.int64]) -> Points:
    return np.ascontiguousarray(np.stack([a[index[:, k]] for k, a in enumerate(axes)], axis=1))
