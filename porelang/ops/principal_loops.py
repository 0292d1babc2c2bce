"""The loop that finds principal values and directions, compiled: Jacobi's rotations, in the type of the components.

Each step is written as shaders/lib/pore_principal.glsl has it. Closed forms by the angle of a cosine lose half of the
digits where two values are nearly one, and their directions all; rotations keep directions at right angles whatever
the values are, and err by a few epsilons of the largest component (J. Kopp, Efficient numerical diagonalization of
hermitian 3 x 3 matrices, Int. J. Mod. Phys. C 19, 2008, table 3, where they are the slowest and the most accurate).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled

Values = NDArray[Any]
#: Times that all three pairs of axes are turned: what is left then is below the epsilon of float64.
SWEEPS = 6


@compiled
def _turn(a: Values, v: Values, p: int, q: int, r: int, least: Any) -> bool:
    """Turn the axes p and q of the tensor a (3, 3) so that a[p, q] is 0, and the directions v with them."""
    one = a.dtype.type(1.0)
    g = a[p, q] + a[p, q]
    if not abs(g) > least:
        return False
    h = a[q, q] - a[p, p]
    root = np.sqrt(h * h + g * g)
    t = g / (h + root) if h >= 0 else g / (h - root)
    c = one / np.sqrt(t * t + one)
    s = t * c
    shift = t * a[p, q]
    a[p, p] = a[p, p] - shift
    a[q, q] = a[q, q] + shift
    a[p, q] = a.dtype.type(0.0)
    i, j = min(r, p), max(r, p)
    k, m = min(r, q), max(r, q)
    rp, rq = a[i, j], a[k, m]
    a[i, j] = c * rp - s * rq
    a[k, m] = s * rp + c * rq
    for n in range(3):
        vp, vq = v[n, p], v[n, q]
        v[n, p] = c * vp - s * vq
        v[n, q] = s * vp + c * vq
    return True


@compiled
def _exchange(a: Values, v: Values, p: int, q: int) -> None:
    """Put the axis of the larger value first; of equal ones nothing is exchanged."""
    if a[p, p] < a[q, q]:
        a[p, p], a[q, q] = a[q, q], a[p, p]
        for n in range(3):
            v[n, p], v[n, q] = v[n, q], v[n, p]


@compiled
def principal(parts: Values, least: Any, normal: Any, out: Values) -> None:
    """Values and directions of tensors, parts (6, n) as xx, yy, zz, xy, yz, xz, into out (12, n): three values, the
    largest first, then the directions of each. Not a number where a component is none, or infinite.

    Of components within 1 what is not above `least` counts as 0, and a tensor below `normal` has none within 1.
    """
    real = parts.dtype.type
    nought, one = real(0.0), real(1.0)
    a = np.empty((3, 3), parts.dtype)
    v = np.empty((3, 3), parts.dtype)
    for k in range(parts.shape[1]):
        size = nought
        total = nought
        for n in range(6):
            size = max(size, abs(parts[n, k]))
            total = total + parts[n, k] * nought
        if total != nought:  # not a number, or infinite
            for n in range(12):
                out[n, k] = real(np.nan)
            continue
        scale = size if size >= normal else one
        a[0, 0], a[1, 1], a[2, 2] = parts[0, k] / scale, parts[1, k] / scale, parts[2, k] / scale
        a[0, 1], a[1, 2], a[0, 2] = parts[3, k] / scale, parts[4, k] / scale, parts[5, k] / scale
        for i in range(3):
            for j in range(3):
                v[i, j] = one if i == j else nought
        for _ in range(SWEEPS):
            first = _turn(a, v, 0, 1, 2, least)
            second = _turn(a, v, 0, 2, 1, least)
            third = _turn(a, v, 1, 2, 0, least)
            if not (first or second or third):
                break
        _exchange(a, v, 0, 1)
        _exchange(a, v, 1, 2)
        _exchange(a, v, 0, 1)
        for i in range(2):
            if (real(9.0) * v[0, i] + real(3.0) * v[1, i]) + v[2, i] < nought:
                for n in range(3):
                    v[n, i] = -v[n, i]
        for i in range(3):
            out[i, k] = a[i, i] * scale
        for i in range(2):
            for n in range(3):
                out[3 + 3 * i + n, k] = v[n, i]
        out[9, k] = v[1, 0] * v[2, 1] - v[2, 0] * v[1, 1]
        out[10, k] = v[2, 0] * v[0, 1] - v[0, 0] * v[2, 1]
        out[11, k] = v[0, 0] * v[1, 1] - v[1, 0] * v[0, 1]
