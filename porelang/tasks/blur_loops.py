"""The loop of blurring, compiled: weighted sums along an axis, in a fixed order.

Rows are views that begin at 0: indices that may be negative would keep the compiler from taking several at a time.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from porelang.compiled import compiled

Array = NDArray[Any]
#: Numbers that are summed up at a time: they stay in the nearest cache.
_BLOCK = 2048


@compiled
def average(source: Array, out: Array, half: Array, step: int, a0: int, a1: int, q0: int, q1: int) -> None:
    """`out[a, q] = sum over m of w[m] source[a, q + m step]`, the weights being `half`, from their middle outward.

    An axis of a grid is one of rows that are `step` numbers apart, one after the other.
    """
    radius = len(half) - 1
    middle = radius * step
    for a in range(a0, a1):
        for start in range(q0, q1, _BLOCK):
            stop = min(start + _BLOCK, q1)
            row = out[a, start:stop]
            here = source[a, start + middle : stop + middle]
            w = half[0]
            for q in range(len(row)):
                row[q] = w * here[q]
            for m in range(1, radius, 2):  # two at a time, in the same order: fewer ways to memory and back
                w, v = half[m], half[m + 1]
                left, right = middle - m * step, middle + m * step
                one, other = source[a, start + left : stop + left], source[a, start + right : stop + right]
                left, right = left - step, right + step
                next_, last = source[a, start + left : stop + left], source[a, start + right : stop + right]
                for q in range(len(row)):
                    row[q] = row[q] + w * (one[q] + other[q]) + v * (next_[q] + last[q])
            if radius % 2:
                w, left, right = half[radius], 0, 2 * middle
                one, other = source[a, start + left : stop + left], source[a, start + right : stop + right]
                for q in range(len(row)):
                    row[q] += w * (one[q] + other[q])
