"""The loops of finding a phase, compiled: sums of four along an axis, and what is asked of many small matrices.

Matrices are columns of an array (3, 3, n), one matrix after the other along the last axis.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from porelang.compiled import compiled

Array = NDArray[Any]
#: A matrix of this determinant against the cube of its size is taken for flat: it has no nearest rotation.
_FLAT = 1e-6
#: Where Newton's step for a rotation moves it by less, the next one would move it by the square of that.
_STILL = 1e-5


@compiled
def fourfold(source: Array, nodes: Array, weights: Array, out: Array) -> None:
    """`out[a, m, q] = sum over k of weights[m, k] source[a, nodes[m, k], q]`, of four nodes along an axis."""
    for a in range(len(source)):
        for m in range(len(nodes)):
            one, two = source[a, nodes[m, 0]], source[a, nodes[m, 1]]
            three, four = source[a, nodes[m, 2]], source[a, nodes[m, 3]]
            u, v, w, t = weights[m, 0], weights[m, 1], weights[m, 2], weights[m, 3]
            row = out[a, m]
            for q in range(len(row)):
                row[q] = u * one[q] + v * two[q] + w * three[q] + t * four[q]


@compiled
def rotations(matrices: Array, out: Array) -> None:
    """The nearest rotations to matrices (3, 3, n): Newton's iteration for the polar factor, with scaling."""
    for n in range(matrices.shape[2]):
        a, b, c = matrices[0, 0, n], matrices[0, 1, n], matrices[0, 2, n]
        d, e, f = matrices[1, 0, n], matrices[1, 1, n], matrices[1, 2, n]
        g, h, i = matrices[2, 0, n], matrices[2, 1, n], matrices[2, 2, n]
        square = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
        volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        if not volume > _FLAT * square * math.sqrt(square):
            a, b, c, d, e, f, g, h, i = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
        for _ in range(30):
            # the inverse, transposed: the cofactors by the determinant
            A, B, C = e * i - f * h, f * g - d * i, d * h - e * g  # noqa: N806
            D, E, F = c * h - b * i, a * i - c * g, b * g - a * h  # noqa: N806
            G, H, I = b * f - c * e, c * d - a * f, a * e - b * d  # noqa: N806, E741
            by = 1 / (a * A + b * B + c * C)
            size = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + i * i
            other = (A * A + B * B + C * C + D * D + E * E + F * F + G * G + H * H + I * I) * by * by
            scale = math.sqrt(math.sqrt(other / size))
            p, q = 0.5 * scale, 0.5 / scale * by
            A, B, C = p * a + q * A, p * b + q * B, p * c + q * C  # noqa: N806
            D, E, F = p * d + q * D, p * e + q * E, p * f + q * F  # noqa: N806
            G, H, I = p * g + q * G, p * h + q * H, p * i + q * I  # noqa: N806, E741
            moved = max(abs(A - a), abs(B - b), abs(C - c), abs(D - d), abs(E - e), abs(F - f), abs(G - g),
                        abs(H - h), abs(I - i))  # fmt: skip
            a, b, c, d, e, f, g, h, i = A, B, C, D, E, F, G, H, I
            if moved < _STILL:
                break
        out[0, 0, n], out[0, 1, n], out[0, 2, n] = a, b, c
        out[1, 0, n], out[1, 1, n], out[1, 2, n] = d, e, f
        out[2, 0, n], out[2, 1, n], out[2, 2, n] = g, h, i


@compiled
def shapes(slopes: Array, asked: Array, numbers: Array, stretch: Array, flat: Array, volume: Array) -> None:
    """Of each Jacobian (3, 3, n): the length of its rows, how much longer than wide it is, how flat, and its volume.

    All but the first are of its rows times the periods `asked` (3, n): the largest by the smallest singular value, by
    the roots of a cubic as cosines; the determinant by the cube of the mean singular value (of squares); and the
    determinant, the cells in the volume that one was to have.
    """
    for n in range(slopes.shape[2]):
        a, b, c = slopes[0, 0, n], slopes[0, 1, n], slopes[0, 2, n]
        d, e, f = slopes[1, 0, n], slopes[1, 1, n], slopes[1, 2, n]
        g, h, i = slopes[2, 0, n], slopes[2, 1, n], slopes[2, 2, n]
        numbers[0, n] = math.sqrt(a * a + b * b + c * c)
        numbers[1, n] = math.sqrt(d * d + e * e + f * f)
        numbers[2, n] = math.sqrt(g * g + h * h + i * i)
        u, v, w = asked[0, n], asked[1, n], asked[2, n]
        a, b, c, d, e, f, g, h, i = a * u, b * u, c * u, d * v, e * v, f * v, g * w, h * w, i * w
        det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        xx, yy, zz = a * a + d * d + g * g, b * b + e * e + h * h, c * c + f * f + i * i
        xy, xz, yz = a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i
        mean = (xx + yy + zz) / 3
        flat[n] = det / (mean * math.sqrt(mean))
        volume[n] = det
        p, q, r = xx - mean, yy - mean, zz - mean
        size = math.sqrt((p * p + q * q + r * r + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
        cubic = p * (q * r - yz * yz) - xy * (xy * r - yz * xz) + xz * (xy * yz - q * xz)
        angle = math.acos(min(1.0, max(-1.0, cubic / max(2 * size**3, 1e-300)))) / 3
        largest = mean + 2 * size * math.cos(angle)
        middle = mean + 2 * size * math.cos(angle - 2 * math.pi / 3)
        # the smallest as a product: a difference would lose its figures
        stretch[n] = math.sqrt(largest / max(det * det / (largest * middle), 1e-300))
