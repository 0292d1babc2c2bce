"""From a field to its closed surface in a box: bricks over threads, welded as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.mesh.bricks import Brick, Enclose, Plan, split
from porelang.mesh.contour import Patch, contour
from porelang.mesh.grid import Grid, Point, place
from porelang.mesh.kinks import MARGIN, Around, At
from porelang.mesh.layers import Layers, Sample, clip
from porelang.mesh.surface import Surface
from porelang.mesh.weld import IN_MEMORY, Weld
from porelang.progress import tell

# Once it has freed a block this large, glibc keeps what bricks free instead of giving it back to be zeroed anew, which
# is a quarter of the time (measured). Elsewhere it does nothing.
np.empty((1 << 25) - (1 << 16), np.uint8)

BRICK = 64  # cells a side: smaller ones rule more out, larger ones cost less each (measured: 56 to 72 is fastest)
COARSE = 4  # samples across: what is empty with fewer says nothing of the part
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What one brick gave: its triangles, whether all its samples are solid, the range of the field in it, and, where
    the field keeps its sign, the place where it comes closest to zero."""

    patch: Patch | None
    solid: bool
    low: float
    high: float
    nearest: Point | None


def extract(
    grid: Grid,
    box: tuple[Point, Point],
    sample: Sample,
    enclose: Enclose | None = None,
    *,
    field: At | None = None,
    threads: int = 1,
    brick: int = BRICK,
    memory: int = 2 * IN_MEMORY,
    folder: Path | None = None,
) -> Surface:
    """The closed surface of the solid (where the field is negative) inside `box`, capped flat at the box.

    `grid` covers the box (mm). `sample(lo, hi)` gives the field at the half-open range of the grid's nodes, float32 or
    float64 of shape `hi - lo`; it is called from `threads` threads. `enclose` (see `bricks.split`) rules parts out.
    `field`, at points (n, 3), mends crossings that the samples misplace (see `kinks`); a smooth field needs none.
    A surface of more than `memory` bytes is kept in files without names in `folder` (the system's own if None).
    The surface does not depend on `brick`, the cells a side of a piece, `threads` or `enclose` (its order does).
    Errors: E110 the field is not a number somewhere; E111 no surface in the box; E113 the disk is full.
    """
    layers = clip(grid, *box)
    plan = split(layers, brick, enclose)
    bricks = sorted(plan.bricks, key=lambda b: b.lo)
    weld = Weld(memory // 2, folder)
    found: list[Found] = []
    for one in _over(bricks, lambda b: _visit(layers, sample, b, field), threads):
        if one.patch is not None:
            try:
                weld.add(one.patch)
            except OSError as error:
                raise _no_room(folder, error) from error
        found.append(replace(one, patch=None))
        tell(len(found), len(bricks))
    if not plan.void and all(f.solid for f in found):
        _reject(layers, sample, plan, found, solid=True)
    if not weld.faces.count:
        _reject(layers, sample, plan, found, solid=False)
    return weld.surface()


def _over(bricks: list[Brick], visit: Callable[[Brick], Found], threads: int) -> Iterator[Found]:
    """What the bricks give, in their order, with no more than a few of them in work at a time."""
    if threads <= 1:
        yield from map(visit, bricks)
        return
    pool = ThreadPoolExecutor(threads)
    flying: deque[Future[Found]] = deque()
    try:
        for b in bricks:
            flying.append(pool.submit(visit, b))
            if len(flying) > 2 * threads:
                yield flying.popleft().result()
        while flying:
            yield flying.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


def _no_room(folder: Path | None, error: OSError) -> PoreError:
    """Why a surface that outgrew the memory could not be kept on disk either."""
    return fail(
        "E113",
        f"cannot write to {folder or 'the temporary folder'}: {(error.strerror or str(error)).lower()}; a surface "
        "larger than the memory is kept there while it is made",
        hint="write the mesh to a folder on a disk with more room, or use a larger voxel",
    )


def _visit(layers: Layers, sample: Sample, brick: Brick, field: At | None = None) -> Found:
    margin = 0 if field is None else MARGIN
    begin, end = layers.wider(brick.lo, brick.hi, margin)
    around, samples = layers.read(sample, begin, end)
    x, y, z = (slice(a - s, b - s) for a, b, s in zip(brick.lo, brick.hi, begin, strict=True))
    values = around[x, y, z]
    crossed = values.min() < 0 <= values.max()
    patch = contour(Around(around, begin, brick.lo), layers, values.shape, field) if crossed else None
    part = layers.inner(brick.lo, brick.hi)
    inner = values[part]
    low, high = float(inner.min()), float(inner.max())
    if low < 0 <= high:
        return Found(patch, False, low, high, None)
    at = np.unravel_index(np.abs(inner).argmin(), inner.shape)
    i, j, k = (int(i) + p.start + b for i, p, b in zip(at, part, brick.lo, strict=True))
    # A part that ends exactly at its bounds is solid up to them, but not on the nodes beyond.
    return Found(patch, high < 0 and bool((samples < 0).all()), low, high, layers.point((i, j, k)))


def _reject(layers: Layers, sample: Sample, plan: Plan, found: list[Found], solid: bool) -> NoReturn:
    """Say why there is no surface: the range of the field, and where it came closest to one."""
    if plan.nearest is not None:
        found = [*found, _visit(layers, sample, plan.nearest)]
    low, high = min(f.low for f in found), max(f.high for f in found)
    nearest = min(found, key=lambda f: min(abs(f.low), abs(f.high)))
    closest = nearest.high if solid else nearest.low
    where = f"its values there run from {low:.4g} to {high:.4g}; the nearest to 0 is {closest:.4g}"
    if low == high:
        where = f"it is {low:.4g} at all of them"
    elif nearest.nearest is not None:
        where += f", at {place(nearest.nearest)}"
    x, y, z = (f"{axis.lo:.6g}..{axis.hi:.6g}" for axis in layers.axes)
    if solid:
        raise fail(
            "E111",
            f"the part has no surface: the field is negative, solid, everywhere in x {x}, y {y}, z {z} mm ({where})",
            hint="intersect it with a shape (`& cylinder(75, 300)`), or make the addend or the offset smaller",
        )
    across = min(layers.shape) - 4  # without the layers at the bounds
    if across < COARSE:
        raise fail(
            "E111",
            f"a voxel of {layers.grid.spacing:g} mm is too coarse: {max(across, 0)} samples across met nothing",
            hint="use a smaller --voxel: a few to the thinnest wall",
        )
    raise fail(
        "E111",
        f"the part is empty: the field is {'positive' if low > 0 else 'nowhere negative'}, void, at every sample in "
        f"x {x}, y {y}, z {z} mm ({where})",
        hint=f"solid is negative: grown by more than {closest:.4g} (`offset(part, d)`; a shell's thickness by twice as "
        "much) it would not be empty; or else its walls are thinner than the voxel, or the bounds miss it",
    )
