"""The layers of a box, and their samples: a few layers, or a band of one, in memory at a time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.diagnostics import fail
from porelang.field import Field

Format = Literal["png", "svg"]  # of a folder
#: Samples with the same y for a row; rows with the same x follow each other.
Band = NDArray[Any]
SMALLEST, LARGEST = 1e-9, 1e9  # mm: of a layer or a pixel, less than an atom and more than any part
MOST_LAYERS, MOST_PIXELS = 100_000, 1 << 28
#: Bounds that are found may reach beyond the part by this share of a step: that makes no layer.
SLACK = 0.01
AT_ONCE = 1 << 22  # samples: their values and what is computed on the way take some 100 MB


@dataclass(frozen=True, slots=True)
class Stack:
    """Layers across z: pixel middles along x and y, and the height at which each layer is looked at, all in mm.

    All layers are `step` thick but for the last, which ends with the box.
    """

    box: Box
    step: float
    pixel: float
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]

    @property
    def thickness(self) -> NDArray[np.float64]:
        """Of each layer in mm, as far as the box fills it."""
        filled = self.box.size[2] - self.step * np.arange(len(self.z))
        return np.asarray(np.minimum(self.step, filled), np.float64)


def check_lengths(step: float, pixel: float) -> None:
    """Errors: E114 where layers or pixels have no size that layers can have."""
    for name, length in (("step", step), ("pixel", pixel)):
        if not SMALLEST <= length <= LARGEST:
            hint = "it is in mm: use a larger one" if length < SMALLEST else "it is in mm: use a smaller one"
            raise fail("E114", f"a {name} of {length:g} mm makes no layers", hint=hint)


def stack_of(box: Box, step: float, pixel: float) -> Stack:
    """The layers of a box; the pixels cover it, the last row may reach beyond. Errors: E114.

    Each layer is looked at in its middle, and the last in the middle of what the box fills of it.
    """
    check_lengths(step, pixel)
    counts = [max(1, math.ceil(s / h - SLACK)) for s, h in zip(box.size, (pixel, pixel, step), strict=True)]
    if counts[2] > MOST_LAYERS or counts[0] * counts[1] > MOST_PIXELS:
        raise fail(
            "E114",
            f"{counts[2]:,} layers of {counts[0]:,} x {counts[1]:,} pixels are too many",
            hint="use a larger --step or --voxel",
        )
    x, y, z = (
        np.asarray(lo + (np.arange(n) + 0.5) * h, np.float64)
        for lo, n, h in zip(box.lo, counts, (pixel, pixel, step), strict=True)
    )
    z[-1] = (box.lo[2] + (len(z) - 1) * step + box.hi[2]) / 2
    return Stack(box, step, pixel, x, y, z)


def _framed(places: NDArray[np.float64], apart: float) -> NDArray[np.float64]:
    return np.concatenate([places[:1] - apart, places, places[-1:] + apart])


def layers(field: Field, stack: Stack, frame: bool = False) -> Iterator[tuple[int, Iterator[Band]]]:
    """The samples of each layer, lowest first, in bands (rows, len(y)) that follow each other along x.

    With a frame there is one sample more on every side.
    """
    wide, deep = (_framed(v, stack.pixel) if frame else v for v in (stack.x, stack.y))
    nx, ny, nz = len(wide), len(deep), len(stack.z)
    rows = max(1, min(nx, AT_ONCE // ny))
    several = max(1, min(nz, AT_ONCE // (nx * ny)))

    def block(x: slice, z: slice) -> NDArray[Any]:
        # a grid of its own: what depends on two axes alone is computed once for a grid, and kept
        axes = [wide[x], deep, stack.z[z]]
        return field.on_grid(axes).block((0, 0, 0), (len(axes[0]), ny, len(axes[2])))

    def bands(k: int) -> Iterator[Band]:
        for i in range(0, nx, rows):
            yield block(slice(i, i + rows), slice(k, k + 1))[:, :, 0]

    for start in range(0, nz, several):
        if rows < nx:
            yield start, bands(start)
            continue
        together = block(slice(None), slice(start, start + several))
        for k in range(together.shape[2]):
            yield start + k, iter((together[:, :, k],))
