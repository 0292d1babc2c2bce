"""How much of each voxel is solid, from samples of a field: the surface is a plane in each cell that it may pass.

A cell of a sample has the sample in its middle and the field's slope from its neighbours; the share of a cube below a
plane is a closed form (inclusion and exclusion over the corners). The sum errs by the square of the spacing, without
the noise that counting signs has, so that finer grids can be extrapolated.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Floats = NDArray[np.float64]
#: A slope along an axis is taken as at least this share of all three: the closed form divides by each.
_FLATTEST = 1e-3
#: A field that bends down by more than this share of its slope from sample to sample has an edge there.
_BENT = 0.25


def fractions(values: Floats, fine: int) -> Floats:
    """The share of solid (nx, ny, nz) of voxels of `fine`^3 samples each; `values` (fine nx, fine ny, fine nz) are the
    field (negative in the solid) in the middle of equal cells of a period, which repeats beyond its ends.

    >>> x = (np.arange(8) + 0.5) / 8 - 0.4
    >>> float(fractions(np.broadcast_to(x[:, None, None], (8, 8, 8)).copy(), 8)[0, 0, 0].round(6))
    0.4
    """
    nx, ny, nz = (n // fine for n in values.shape)
    return averaged(shares(np.concatenate([values[-1:], values, values[:1]])), (nx, ny, nz))


def shares(values: Floats) -> Floats:
    """The share of solid (n, ny, nz) of the cells of samples (n + 2, ny, nz), of which the first and the last layer
    along x are only neighbours; along y and z the samples repeat."""
    n, ny, nz = values.shape
    out = np.empty((n - 2, ny, nz))
    _shares(values, out)
    return out


def averaged(share: Floats, voxels: tuple[int, int, int]) -> Floats:
    """The means (nx, ny, nz) of equal blocks of shares: so many voxels along each axis."""
    nx, ny, nz = voxels
    x, y, z = (n // v for n, v in zip(share.shape, voxels, strict=True))
    return np.asarray(share.reshape(nx, x, ny, y, nz, z).mean(axis=(1, 3, 5)))


def creases(values: Floats) -> tuple[int, int, int]:
    """How many cells of samples (n + 2, ny, nz), laid out as those of `shares`, the surface passes; in how many of
    them it has an edge that leads into the solid, as where two struts meet; and in how many it lies with the voxels.

    There the field bends down from a sample to the next by a share of its slope that does not fall with the spacing: by
    more than a quarter, as at edges of some 30 degrees and more, or at rounded ones of less than four samples.

    >>> x = np.abs(np.arange(16) - 7.4) - 4
    >>> creases(np.broadcast_to(x[:, None, None], (16, 8, 8)).copy())[1]  # plates: flat
    0
    >>> creases(np.minimum(x[:, None, None], x[None, :, None]) + np.zeros((16, 16, 8)))[1] > 0  # a cross of two
    True
    """
    cut, creased, flat = _creases(values, _BENT)
    return int(cut), int(creased), int(flat)


@compiled
def _creases(values: Any, bent: float) -> tuple[int, int, int]:
    n, ny, nz = values.shape
    cut, creased, flat = 0, 0, 0
    for i in range(1, n - 1):
        for j in range(ny):
            below, above = (j - 1) % ny, (j + 1) % ny
            for k in range(nz):
                left, right = (k - 1) % nz, (k + 1) % nz
                value = values[i, j, k]
                a, b = values[i - 1, j, k], values[i + 1, j, k]
                c, d = values[i, below, k], values[i, above, k]
                e, f = values[i, j, left], values[i, j, right]
                slope = (abs(b - a) + abs(d - c) + abs(f - e)) / 2
                if abs(value) < slope / 2:
                    cut += 1
                    if min(a + b, c + d, e + f) - 2 * value < -bent * slope:
                        creased += 1
                    if max(abs(b - a), abs(d - c), abs(f - e)) > 1.98 * slope:
                        flat += 1
    return cut, creased, flat


@compiled
def _shares(values: Any, out: Any) -> None:
    n, ny, nz = out.shape
    for i in range(n):
        for j in range(ny):
            below, above = (j - 1) % ny, (j + 1) % ny
            for k in range(nz):
                value = values[i + 1, j, k]
                a = abs(values[i + 2, j, k] - values[i, j, k]) / 2
                b = abs(values[i + 1, above, k] - values[i + 1, below, k]) / 2
                c = abs(values[i + 1, j, (k + 1) % nz] - values[i + 1, j, (k - 1) % nz]) / 2
                total = a + b + c
                if total < np.inf and abs(value) < total / 2:
                    out[i, j, k] = _below(value, a, b, c)
                else:
                    out[i, j, k] = 1.0 if value < 0 else 0.0


@compiled
def _below(value: float, a: float, b: float, c: float) -> float:
    """The share of a unit cube where value + (a, b, c) . x < 0 for x within half a side of the middle."""
    least = _FLATTEST * (a + b + c)
    a, b, c = max(a, least), max(b, least), max(c, least)
    reach = (a + b + c) / 2 - value
    total = 0.0
    for corner in range(8):
        left, sign = reach, 1.0
        if corner & 1:
            left, sign = left - a, -sign
        if corner & 2:
            left, sign = left - b, -sign
        if corner & 4:
            left, sign = left - c, -sign
        if left > 0:
            total += sign * left * left * left
    return min(1.0, max(0.0, total / (6 * a * b * c)))
