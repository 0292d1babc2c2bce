"""Coordinates as compiled loops take them: flat memory with strides, so that nothing is copied or broadcast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

Values = NDArray[Any]
Shape = tuple[int, ...]
Triple = tuple[int, int, int]
#: Beyond this cells of size 1 are not told apart by float32 any more: there are no random numbers, and no sites.
FARTHEST = 2.0**23


class Strided(NamedTuple):
    """Elements of `memory` at the steps of three nested loops, counted in elements; 0 where it is broadcast."""

    memory: Values
    steps: Triple


class Points(NamedTuple):
    """Coordinates that broadcast to `shape`, and `loops`: the same shape as three nested loops."""

    x: Strided
    y: Strided
    z: Strided
    shape: Shape
    loops: Triple
    dtype: np.dtype[Any]


def points(x: object, y: object, z: object) -> Points:
    """Coordinates of one floating type (float64 where they are not floats) as loops take them."""
    arrays = [np.asarray(v) for v in (x, y, z)]
    dtype = np.result_type(*(a.dtype for a in arrays))
    if dtype not in (np.float32, np.float64):
        dtype = np.dtype(np.float64)
    shape = np.broadcast_shapes(*(a.shape for a in arrays))
    if len(shape) > 3:  # such shapes are rare, and their loops may be cut anywhere
        arrays = [np.broadcast_to(a, shape).reshape(-1) for a in arrays]
        loops: Triple = (1, 1, int(np.prod(shape)))
    else:
        padded = (1,) * (3 - len(shape)) + shape
        loops = (padded[0], padded[1], padded[2])
    columns = [strided(a.astype(dtype, copy=False), readonly=True) for a in arrays]
    return Points(columns[0], columns[1], columns[2], shape, loops, dtype)


def strided(a: Values, readonly: bool = False) -> Strided:
    """The memory of an array of three dimensions at most, from its first element on."""
    size = a.itemsize
    if not a.flags.aligned or any(s < 0 or s % size for s in a.strides):
        a = a.copy()
    steps: Sequence[int] = [0 if n == 1 else s // size for n, s in zip(a.shape, a.strides, strict=True)]
    if a.flags.c_contiguous:
        memory = a.reshape(-1)
    else:
        length = 1 + sum((n - 1) * s for n, s in zip(a.shape, steps, strict=True)) if a.size else 0
        memory = as_strided(a, (length,), (size,))
    if readonly and memory.flags.writeable:  # one type for the compiler, whether or not the caller may write
        memory = memory.view()
        memory.flags.writeable = False
    padded = (0,) * (3 - a.ndim) + tuple(steps)
    return Strided(memory, (padded[0], padded[1], padded[2]))


def room(at: Points, out: Values | None, dtype: Any = None) -> Values:
    """Where the results at the points go: `out`, or a new array. Errors: ValueError where `out` does not fit."""
    dtype = at.dtype if dtype is None else np.dtype(dtype)
    if out is None:
        return np.empty(at.shape, dtype)
    if out.shape != at.shape or out.dtype != dtype:
        raise ValueError(f"out is {out.dtype} {out.shape}, the result {dtype} {at.shape}")
    return out


def target(at: Points, out: Values) -> tuple[Strided, bool]:
    """The memory that a loop writes, and whether it is not that of `out`, which then needs a copy."""
    direct = out.ndim <= 3 and out.flags.aligned and all(s >= 0 and s % out.itemsize == 0 for s in out.strides)
    if direct:
        return strided(out), False
    return strided(np.empty(at.loops, out.dtype)), True


def places(*coordinates: object) -> tuple[Values, Shape]:
    """Numbers that broadcast, in their floating type (float64 where they are not floats), as rows, and their shape."""
    arrays = np.broadcast_arrays(*(np.asarray(v) for v in coordinates))
    dtype = np.result_type(*(a.dtype for a in arrays))
    if dtype not in (np.float32, np.float64):
        dtype = np.dtype(np.float64)
    return np.stack([a.reshape(-1) for a in arrays]).astype(dtype, copy=False), arrays[0].shape
