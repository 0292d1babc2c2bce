"""The hash pcg4d and random numbers of places, compiled. shaders/lib/pore_pcg4d.glsl has the same steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.ops.points import FARTHEST

Values = NDArray[Any]
Word = Any  # a whole number of 32 bits, held in 64
BITS = np.uint64(0xFFFFFFFF)
HALF = np.uint64(16)
FACTOR, ADDEND = np.uint64(1664525), np.uint64(1013904223)
#: Of a hash, what is left when its lower bits are dropped: 24 bits, which float32 holds exactly.
LOWER = np.uint64(8)
PART = 2.0**-24


@compiled
def pcg4d(x: Word, y: Word, z: Word, w: Word) -> tuple[Word, Word, Word, Word]:
    """Four words from four."""
    x, y = (x * FACTOR + ADDEND) & BITS, (y * FACTOR + ADDEND) & BITS
    z, w = (z * FACTOR + ADDEND) & BITS, (w * FACTOR + ADDEND) & BITS
    x = (x + y * w) & BITS
    y = (y + z * x) & BITS
    z = (z + x * y) & BITS
    w = (w + y * z) & BITS
    x, y, z, w = x ^ (x >> HALF), y ^ (y >> HALF), z ^ (z >> HALF), w ^ (w >> HALF)
    x = (x + y * w) & BITS
    y = (y + z * x) & BITS
    z = (z + x * y) & BITS
    w = (w + y * z) & BITS
    return x, y, z, w


@compiled
def word(whole: Any) -> Word:
    """The 32 bits of a whole number, in two's complement."""
    return np.uint64(np.int64(whole)) & BITS


@compiled
def random(at: Values, out: Values) -> None:
    """The four numbers of places and seeds at (4, n) into out (4, n)."""
    real = at.dtype.type
    part = real(PART)
    for n in range(at.shape[1]):
        good = True
        for a in range(4):
            good = good and abs(at[a, n]) < FARTHEST
        if not good:
            for a in range(4):
                out[a, n] = real(np.nan)
            continue
        x, y, z, w = pcg4d(
            word(np.floor(at[0, n])), word(np.floor(at[1, n])), word(np.floor(at[2, n])), word(np.floor(at[3, n]))
        )
        out[0, n], out[1, n] = real(x >> LOWER) * part, real(y >> LOWER) * part
        out[2, n], out[3, n] = real(z >> LOWER) * part, real(w >> LOWER) * part
