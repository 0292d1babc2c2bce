"""How much of each voxel is solid, from samples of a field: the surface is a plane in each cell that it may pass.

A cell of a sample has the sample in its middle and the field's slope from its neighbours; the share of a cube below a
plane is a closed form (inclusion and exclusion over the corners). The sum errs by the square of the spacing, without
the noise that counting signs has, so that finer grids can be extrapolated.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: A slope along an axis is taken as at least this share of all three: the closed form divides by each.
_FLATTEST = 1e-3


def fractions(values: Floats, fine: int) -> Floats:
    """The share of solid (nx, ny, nz) of voxels of `fine`^3 samples each; `values` (fine nx, fine ny, fine nz) are the
    field (negative in the solid) in the middle of equal cells of a period, which repeats beyond its ends.

    >>> x = (np.arange(8) + 0.5) / 8 - 0.4
    >>> float(fractions(np.broadcast_to(x[:, None, None], (8, 8, 8)).copy(), 8)[0, 0, 0].round(6))
    0.4
    """
    share = (values < 0).astype(np.float64)
    slopes = np.empty((3, *values.shape))
    with np.errstate(invalid="ignore", over="ignore"):
        for axis in range(3):
            slopes[axis] = np.abs(np.roll(values, -1, axis) - np.roll(values, 1, axis)) / 2
        cut = np.isfinite(slopes).all(axis=0) & (np.abs(values) < slopes.sum(axis=0) / 2)
    share[cut] = _below(values[cut], slopes[:, cut])
    nx, ny, nz = (n // fine for n in values.shape)
    return np.asarray(share.reshape(nx, fine, ny, fine, nz, fine).mean(axis=(1, 3, 5)))


def _below(value: Floats, slopes: Floats) -> Floats:
    """The share of unit cubes where value + slopes . x < 0 for x within half a side of the middle."""
    slopes = np.sort(slopes, axis=0)
    slopes = np.maximum(slopes, _FLATTEST * slopes.sum(axis=0))
    reach = -value + slopes.sum(axis=0) / 2
    out = np.zeros_like(value)
    for corner in product((0, 1), repeat=3):
        out += (-1) ** sum(corner) * np.maximum(0.0, reach - np.tensordot(corner, slopes, 1)) ** 3
    return np.asarray(np.clip(out / (6 * slopes.prod(axis=0)), 0.0, 1.0))
