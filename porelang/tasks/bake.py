"""A field sampled on a grid over the box of a solid: evaluated once, read from the samples from then on."""

from __future__ import annotations

import math

import numpy as np

from porelang.analysis.box import Box, part_box, reach, unbounded_axes
from porelang.backends.numpy import GridField, NumpyField
from porelang.data import FARTHEST, LARGEST_VALUE, MOST_COUNTED, NEAREST, WORLD, SampledField, coordinates
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.parallel import parallel_for, workers
from porelang.progress import tell

#: More nodes than this are a slip of the voxel, not a wish: 2 GB for one component.
MOST_NODES = 256_000_000
#: Layers of nodes on each side beyond the box, so that a smooth lookup has neighbours at its border.
MARGIN = 1
AT_ONCE = 1 << 18  # nodes that a thread evaluates between two looks at whether it is still wanted


def bake(fields: Formula, voxel: float, within: Formula, margin: int = MARGIN) -> SampledField:
    """Samples of one field, or of several as components, `voxel` mm apart, in float64.

    The grid covers the box of the solid `within` and `margin` layers of nodes more on each side.
    Errors: E091 where the solid has no end, E092 where it is empty, E096 for a voxel that is none or makes too many
    samples, E097 where the field is not a finite number at a node, or one that float32 has no room for.
    """
    if not NEAREST <= voxel <= FARTHEST:
        hint = f"voxels go from a nanometre to {FARTHEST:,.0f} mm" if voxel > 0 else "give a length above 0, as in 1mm"
        raise fail("E096", f"a voxel of {voxel:g} mm cannot be sampled at", hint=hint)
    box = region(within, "these samples")
    counts = [math.ceil(size / voxel - 1e-9) + 1 + 2 * margin for size in box.size]
    if math.prod(counts) * len(fields.roots) > MOST_NODES or max(counts) > MOST_COUNTED:
        enough = voxel * max(
            (math.prod(counts) * len(fields.roots) / MOST_NODES) ** (1 / 3), max(counts) / MOST_COUNTED
        )
        raise fail("E096", f"a voxel of {voxel:g} mm makes {math.prod(counts):.2g} samples of this region",
                   hint=f"a voxel of {1.05 * enough:.2g} mm would do")  # fmt: skip
    origin = np.array(box.lo) - margin * voxel
    axes_of = [o + voxel * np.arange(n) for o, n in zip(origin, counts, strict=True)]
    values = np.empty((*counts, len(fields.roots)))
    threads = workers()
    slab = max(1, AT_ONCE // (counts[1] * counts[2]))
    starts = range(0, counts[0], slab)
    for k, root in enumerate(fields.roots):
        grid = NumpyField(fields.with_roots(root), "f64", 1).on_grid(axes_of)

        def fill(start: int, k: int = k, grid: GridField = grid) -> None:
            stop = min(start + slab, counts[0])
            values[start:stop, ..., k] = grid.block((start, 0, 0), (stop, counts[1], counts[2]))

        for i in range(0, len(starts), threads):
            tell(k * len(starts) + i, len(fields.roots) * len(starts))
            parallel_for(fill, starts[i : i + threads], threads)
    bad = ~(np.abs(values) <= LARGEST_VALUE)
    if bad.any():
        i, j, l_, k = (int(v) for v in np.argwhere(bad)[0])
        place = origin + voxel * np.array([i, j, l_])
        value = float(values[i, j, l_, k])
        beyond = f"{value:.3g}, beyond {LARGEST_VALUE:g}"
        what = "not a number" if math.isnan(value) else "infinite" if math.isinf(value) else beyond
        raise fail("E097", f"the field of these samples is {what} at ({coordinates(place)})",
                   hint="look for a division by zero, or a root or logarithm of a negative number there")  # fmt: skip
    return SampledField.from_array(values, origin.tolist(), voxel)


def region(within: Formula, what: str, called: str = "region `within`") -> Box:
    """The box of the solid that `what` is found within. Errors: E091 where it has no end, E092 where it is empty."""
    box = part_box(within)
    if (box is None or unbounded_axes(box)) and (end := reach(within)) is not None:
        raise fail("E091", f"the {called} of {what} lies more than 100 m from the origin, as far as "
                   f"{end:,.0f} mm", hint=WORLD)  # fmt: skip
    if box is None or min(box.size) <= 0:
        raise fail("E092", f"the {called} of {what} holds no material", hint="solid is negative: check its sign")
    if axes := unbounded_axes(box):
        raise fail("E091", f"the {called} of {what} has no end along {axes}",
                   hint="intersect it with a shape: `... & cylinder(75, 300)`")  # fmt: skip
    return box
