"""A field averaged by a Gaussian: sampled over the box of a solid and beyond it, so far that no average ends there.

The weights are symmetric and their sum is 1, and samples reach four standard deviations beyond the box: what is linear
stays as it is, everywhere in the box, and no values are made up at its faces.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.parallel import parallel_for, workers
from porelang.progress import tell
from porelang.tasks.bake import MARGIN, bake

Array = NDArray[Any]
#: Of a part of an array the first and last row and column.
_Piece = tuple[int, int, int, int]
#: Standard deviations to which a Gaussian reaches: 6e-5 of it lie beyond.
REACH = 4.0
#: Numbers that one thread averages between two looks at whether they are still wanted.
_AT_ONCE = 1 << 18


def blurred(fields: Formula, sigma: float, voxel: float, within: Formula) -> SampledField:
    """One field, or several as components, averaged with the standard deviation `sigma` (mm), every `voxel` mm.

    The grid is that of samples. Errors: E156 for a voxel that is wider than sigma, and those of `bake`.
    """
    if not sigma > 0:
        raise fail("E156", f"a field cannot be blurred by {sigma:g} mm", hint="`sigma` is a length above 0, as in 2mm")
    if not voxel <= sigma:
        text = f"samples every {voxel:g} mm do not tell what is averaged over {sigma:g} mm"
        raise fail("E156", text, hint=f"take a voxel of {sigma / 2:.3g} mm, or leave it out")
    weights = gaussian(sigma / voxel)
    samples = bake(fields, voxel, within, MARGIN + len(weights) // 2)
    values = averaged(samples.values, weights)
    values.setflags(write=False)
    shift = voxel * (len(weights) // 2)
    x, y, z = (o + shift for o in samples.origin)
    return replace(samples, values=values, origin=(x, y, z))


def gaussian(sigma: float) -> Array:
    """The weights of a Gaussian at whole numbers, to REACH standard deviations; their sum is 1."""
    radius = math.ceil(REACH * sigma)
    weights = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    return np.asarray(weights / weights.sum())


def averaged(values: Array, weights: Array) -> Array:
    """Values (nx, ny, nz, k) averaged along each axis by the same symmetric weights, where all of these meet values."""
    from porelang.tasks.blur_loops import average

    lost = len(weights) - 1
    threads = workers()
    half = np.ascontiguousarray(weights[len(weights) // 2 :], values.dtype)
    for done, axis in enumerate((2, 1, 0)):
        shape = values.shape
        before, inner = math.prod(shape[:axis]), math.prod(shape[axis + 1 :])
        source = values.reshape(before, shape[axis] * inner)
        out = np.empty((before, (shape[axis] - lost) * inner), values.dtype)
        pieces = _pieces(*out.shape)

        def work(
            piece: tuple[int, int, int, int], source: Array = source, out: Array = out, inner: int = inner
        ) -> None:
            average(source, out, half, inner, *piece)

        for i in range(0, len(pieces), 8 * threads):
            tell(done * len(pieces) + i, 3 * len(pieces))
            parallel_for(work, pieces[i : i + 8 * threads], threads)
        values = out.reshape(*shape[:axis], shape[axis] - lost, *shape[axis + 1 :])
    return values


def _pieces(rows: int, columns: int) -> list[_Piece]:
    """Parts of an array, each some rows or a part of one."""
    high = max(1, _AT_ONCE // columns)
    wide = min(columns, _AT_ONCE)
    places = [(a, q) for a in range(0, rows, high) for q in range(0, columns, wide)]
    return [(a, min(a + high, rows), q, min(q + wide, columns)) for a, q in places]
