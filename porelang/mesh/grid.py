"""Where a field is sampled: the nodes of a uniform grid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import FARTHEST, coordinates
from porelang.diagnostics import fail

Index = tuple[int, int, int]
Point = tuple[float, float, float]

# A lattice whose period is a whole number of voxels, laid from a corner of the box, has whole planes of nodes on its
# surface. A grid that starts this fraction of a voxel outside the box avoids the commonest such coincidences.
OFFSET = 0.37
#: More nodes than this are a slip of the voxel, not a wish.
MOST_NODES = 20_000_000_000


@dataclass(frozen=True, slots=True)
class Grid:
    """`shape` nodes at `origin + index * spacing`, in mm."""

    origin: Point
    spacing: float
    shape: Index

    @classmethod
    def cover(cls, lo: Point, hi: Point, spacing: float | None = None, resolution: int | None = None) -> Grid:
        """A grid over the box `lo..hi` (mm) with a layer of nodes outside it on every side.

        Give either `spacing` (mm) or `resolution`, the number of voxels along the longest side. E114 if the box is
        empty or not finite, the voxel is not a positive length, or there would be more nodes than can be visited.
        """
        size = [b - a for a, b in zip(lo, hi, strict=True)]
        if not all(math.isfinite(s) and s > 0 for s in size):
            raise fail(
                "E114",
                f"the bounds from {place(lo)} to {place(hi)} hold no volume",
                hint="give the lower corner first, and three finite sides longer than zero",
            )
        spacing = chosen_voxel(max(size), spacing, resolution)
        counts = [s / spacing + OFFSET for s in size]
        if math.prod(c + 2 for c in counts) > MOST_NODES:
            nodes = math.prod(c + 2 for c in counts)
            enough = 1.1 * spacing * (nodes / MOST_NODES) ** (1 / 3)
            raise fail(
                "E114",
                f"a voxel of {spacing:g} mm asks for {nodes:.2g} samples of a box of "
                f"{size[0]:g} x {size[1]:g} x {size[2]:g} mm",
                hint=f"a voxel of {enough:.2g} mm would do; or take a part of it, with --bounds",
            )
        nx, ny, nz = (math.floor(c) + 2 for c in counts)
        ox, oy, oz = (a - OFFSET * spacing for a in lo)
        return cls((ox, oy, oz), spacing, (nx, ny, nz))

    def axes(
        self, dtype: Any = np.float64, lo: Index = (0, 0, 0), hi: Index | None = None
    ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """The coordinates (mm) of the nodes `lo..hi` (half-open) along x, y and z, rounded once, to `dtype`."""
        ends = self.shape if hi is None else hi
        x, y, z = (
            (o + np.arange(a, b, dtype=np.float64) * self.spacing).astype(dtype)
            for o, a, b in zip(self.origin, lo, ends, strict=True)
        )
        return x, y, z

    def points(self, dtype: Any = np.float64, lo: Index = (0, 0, 0), hi: Index | None = None) -> NDArray[Any]:
        """The nodes `lo..hi` (half-open) as points, (n, 3) in mm; z runs fastest."""
        axes = self.axes(dtype, lo, hi)
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def chosen_voxel(side: float, voxel: float | None, resolution: int | None) -> float:
    """The spacing of samples (mm): `voxel`, or so that `resolution` of them lie along a side. Errors: E114."""
    if (voxel is None) == (resolution is None):
        raise fail(
            "E114", "give either a voxel or a resolution", hint="a voxel in mm, or how many along the longest side"
        )
    for what, given in (("voxel", voxel), ("resolution", resolution)):
        if isinstance(given, bool) or not isinstance(given, int | float | np.number | None):
            hint = "in Python lengths are in mm: voxel=0.5" if what == "voxel" else "give a whole number, as in 128"
            raise fail("E114", f"{given!r} is no {what}", hint=hint)
    if resolution is not None and not (1 <= resolution < math.inf and resolution == int(resolution)):
        raise fail("E114", f"a resolution of {resolution} is no whole number above 0", hint="give one, as in 128")
    found = float(voxel) if voxel is not None else side / resolution  # type: ignore[operator]  # one of them is given
    if not (math.isfinite(found) and found > 0):
        raise fail("E114", f"a voxel of {found:g} mm is not a positive length")
    if found > FARTHEST:
        raise fail("E114", f"a voxel of {found:g} mm is larger than any part", hint="it is in mm")
    return found


def place(point: Any) -> str:
    """A point as it stands in messages: `(1.5, 0, -20) mm`."""
    return f"({coordinates(point, 6)}) mm"
