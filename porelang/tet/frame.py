"""Where a lattice lies: its cubes are as large as asked, and where a part ends flat across an axis they end there too.

A part that is cut at its box, or ends of itself in a plane across an axis, as a cylinder does, has rims there that a
lattice would chamfer. Where the lattice ends in that plane, its corners are on it, and what crosses the rim are edges
within the plane. The cubes are then a little longer or shorter along that axis, so that a whole number fits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: The field (n,) at points (n, 3) in mm.
Value = Callable[[Floats], Floats]

MARGIN = 1.5  # cubes beyond a part that ends of itself
MOST_RAYS = 128  # along a side of a face
FLAT = 1e-6  # cubes: what ends as near to a plane as that ends in it
STRETCHED = 8  # times what numbers of cubes are to be multiples of: with fewer cubes would be stretched for that
FEW = 8  # rays, half a cube apart: fewer that end in a plane are the top of a dome, or of a bar
BISECTIONS = 40


@dataclass(frozen=True, slots=True)
class Frame:
    """Cubes from `lo` (3,) mm on, `counts` (3,) of them, `edges` (3,) mm long; and which of the six ends, (3, 2), are
    planes in which the part ends, where `capped` it is cut off by them, not by itself."""

    lo: Floats
    edges: Floats
    counts: Ints
    ends: NDArray[np.bool_]
    capped: bool

    @property
    def hi(self) -> Floats:
        return self.lo + self.edges * self.counts

    def before_ends(self, points: Floats, depth: float) -> Floats:
        """Points (n, 3) mm, those beyond or on the planes in which the part ends moved so many cubes before them."""
        lo = np.where(self.ends[:, 0], self.lo + depth * self.edges, -np.inf)
        hi = np.where(self.ends[:, 1], self.hi - depth * self.edges, np.inf)
        return np.clip(points, lo, hi)

    def held(self, points: Floats) -> NDArray[np.uint8]:
        """In which of those planes points (n, 3) mm lie, by bits: two for each axis."""
        held = np.zeros(len(points), np.uint8)
        for axis in range(3):
            for end, place in enumerate((self.lo[axis], self.hi[axis])):
                if self.ends[axis, end]:
                    near = np.abs(points[:, axis] - place) <= 1e-9 * self.edges[axis]
                    held[near] |= np.uint8(1 << (2 * axis + end))
        return held


def framed(
    value: Value, lo: Floats, hi: Floats, size: float, slack: float, *, even: int = 1, whole: bool = False
) -> Frame:
    """The lattice with cubes of about `size` mm for the part of a field in a box (mm) that it may end up to `slack` mm
    before. The numbers of cubes along axes are multiples of `even` where that stretches them little. Where the `whole`
    box is wanted, part or not, all ends are planes.
    """
    found = (
        np.stack([lo, hi], axis=1)
        if whole
        else np.array([[_plane(value, lo, hi, size, slack, k, side) for side in (0, 1)] for k in range(3)])
    )
    flat = np.isfinite(found)
    capped = bool((flat & (found == np.stack([lo, hi], axis=1))).any())
    start, edges, counts = np.empty(3), np.full(3, float(size)), np.empty(3, np.int64)
    for k in range(3):
        a = found[k, 0] if flat[k, 0] else lo[k] - MARGIN * size
        b = found[k, 1] if flat[k, 1] else hi[k] + MARGIN * size
        exact = (b - a) / size
        if flat[k].all():
            step = even if exact >= STRETCHED * even else 1
            near = step * max(1.0, np.floor(exact / step)), step * max(1.0, np.ceil(exact / step))
            counts[k] = min(near, key=lambda n: abs(np.log(exact / n)))
            edges[k] = (b - a) / counts[k]
            start[k] = a
            continue
        counts[k] = max(1, int(np.ceil(exact / even - 1e-9))) * even
        start[k] = b - counts[k] * size if flat[k, 1] else a
    return Frame(start, edges, counts, flat, capped)


def _plane(value: Value, lo: Floats, hi: Floats, size: float, slack: float, axis: int, side: int) -> float:
    """The place along an axis of the plane in which the part ends at a side of its box; NaN if it ends in none."""
    others = [k for k in range(3) if k != axis]
    counts = [int(np.clip(2 * (hi[k] - lo[k]) / size, 3, MOST_RAYS)) for k in others]
    sides = [lo[k] + (hi[k] - lo[k]) * (np.arange(n) + 0.5) / n for k, n in zip(others, counts, strict=True)]
    at = np.empty((counts[0] * counts[1], 3))
    at[:, others[0]], at[:, others[1]] = (g.ravel() for g in np.meshgrid(*sides, indexing="ij"))
    end, way = (hi[axis], -1.0) if side else (lo[axis], 1.0)
    few = FEW * min(1.0, len(at) / (4 * FEW))

    def solid(depth: Floats | float, some: Ints | slice = slice(None)) -> NDArray[np.bool_]:
        points = at[some].copy()
        points[:, axis] = end + way * depth
        return np.asarray(value(points) < 0)

    if solid(-FLAT * size).sum() >= few:  # it goes on beyond its box
        return float(end)
    deep = slack + 1e-3 * size
    rays = np.flatnonzero(solid(deep))
    if len(rays) < few:
        return float("nan")
    outer, inner = np.full(len(rays), -FLAT * size), np.full(len(rays), deep)
    for _ in range(BISECTIONS):
        middle = (outer + inner) / 2
        within = solid(middle, rays)
        outer, inner = np.where(within, outer, middle), np.where(within, middle, inner)
    first = inner.min()
    flat = np.zeros(len(at), np.bool_)
    flat[rays[inner <= first + FLAT * size]] = True
    # a plane touches a cylinder in a line, which symmetric rays may lie beside, and a torus in a circle
    face = sliding_window_view(flat.reshape(counts), (3, 3)).all(axis=(2, 3)).any()
    if flat.sum() < few or not face:
        return float("nan")
    return float(end + way * first)
