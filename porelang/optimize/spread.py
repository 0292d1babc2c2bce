"""Values of voxels averaged over a cell's surroundings, and a density brought back to its mean."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from porelang.diagnostics import fail
from porelang.optimize.grid import Grid

Array = NDArray[np.float64]


def averaged(grid: Grid, radius: float) -> Callable[[Array], Array]:
    """What averages values (m,) of the voxels that count, by a cone of a radius in mm (Bruns and Tortorelli, 2001).

    Weights are the volumes: what is outside of the part has none. A radius below a voxel changes nothing.
    """
    spacing = np.array(grid.spacing)
    reach = np.floor(radius / spacing + 1e-9).astype(int)
    if not reach.any():
        return lambda values: values
    axes = [np.arange(-r, r + 1) * s for r, s in zip(reach, spacing, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    cone = np.maximum(0.0, 1 - np.sqrt(x**2 + y**2 + z**2) / radius)
    whole = fftconvolve(grid.fill, cone, mode="same")[grid.mask]

    def average(values: Array) -> Array:
        spread = np.zeros(grid.shape)
        spread[grid.mask] = values * grid.fill[grid.mask]
        out: Array = fftconvolve(spread, cone, mode="same")[grid.mask] / whole
        # the transform's rounding may leave what no average can be
        return np.clip(out, values.min(), values.max())

    return average


def restored(wanted: Callable[[float], Array], low: Array, high: Array, weights: Array, mean: float) -> Array:
    """The density (m,) within low..high whose weighted mean is `mean`: `wanted(s)` for the s where that is so.

    `wanted` rises with s, from below all limits to above them. By bisection, to rounding. Errors: E192 where the limits
    leave no room for the mean.
    """
    share = weights / weights.sum()
    least, most = float(share @ low), float(share @ high)
    if not least - 1e-12 <= mean <= most + 1e-12:
        raise fail("E192", f"no density within the limits has the mean {mean:.4g}: it can be {least:.4g} to {most:.4g}",
                   hint="widen the limits, or ask for a porosity between")  # fmt: skip

    def at(s: float) -> Array:
        return np.clip(wanted(s), low, high)

    a, b = -60.0, 60.0
    for _ in range(200):
        middle = (a + b) / 2
        if middle in (a, b):
            break
        if float(share @ at(middle)) < mean:
            a = middle
        else:
            b = middle
    return at(b)
