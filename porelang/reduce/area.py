"""The area of a solid's surface, from meshes on two grids: marching cubes errs by h^2, which the pair lets us take
away."""

from __future__ import annotations

from collections.abc import Mapping

from porelang.backends.numpy import NumpyField, workers
from porelang.ir import Node
from porelang.mesh import Grid, extract
from porelang.passes.bounds import box_test
from porelang.passes.box import Box
from porelang.passes.enclose import F32
from porelang.reduce.integrals import Reduced, region

_COARSE, _FINE = 96, 160  # voxels along the longest side


def area(root: Node, params: Mapping[str, float]) -> Reduced:
    """The area in mm^2. The error is half the difference of the two grids: sharp rims err by h, not h^2."""
    box = region(root, params, "the solid").box
    coarse, fine = (_meshed(root, params, box, n) for n in (_COARSE, _FINE))
    better = fine + (fine - coarse) / ((_FINE / _COARSE) ** 2 - 1)
    return Reduced(better, max(abs(fine - coarse), abs(better - fine)))


def _meshed(root: Node, params: Mapping[str, float], box: Box, resolution: int) -> float:
    h = max(box.size) / resolution
    lo = (box.lo[0] - h, box.lo[1] - h, box.lo[2] - h)
    hi = (box.hi[0] + h, box.hi[1] + h, box.hi[2] + h)
    grid = Grid.cover(lo, hi, spacing=h)
    sampled = NumpyField(root, params, "f32", threads=1).on_grid(grid.axes())
    return extract(grid, (lo, hi), sampled.block, box_test(root, params, F32), threads=workers(None)).area
