"""Where implementations go wrong: the numbers that operations are swept over."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Float = type[np.float32] | type[np.float64]
#: Coordinates that stand for what no coordinate can be. The sweep replaces them inside the graph.
STAND_IN: dict[float, float] = {987654.25: np.inf, 987655.25: -np.inf, 987656.25: np.nan}
#: As far as the cheaper forms of operations promise to be right.
CALM = 1e9


def hard(dtype: Float) -> NDArray[Any]:
    """Zeros of both signs, denormals, neighbours of 1, of whole numbers, of halves, of multiples of pi, powers of two,
    the least and greatest numbers of the type, and stand-ins for infinities and NaN."""
    info = np.finfo(dtype)
    tiny, huge = info.smallest_normal, info.max
    plain = [0.0, 1 / 3, 0.1, 0.3, 0.7, 2 / 3, 1.1, 10.0, 88.0, 89.5, 104.5, 1e3, 12345.678, 1e5, 1e9, 1e19, 1e20, 1e30]
    powers = [
        2.0**k for k in (-120, -64, -64, -32, -24, -12, -6, -3, -2, -1, 0, 1, 2, 3, 5, 7, 12, 23, 24, 31, 63, 100)
    ]
    angles = [k * np.pi / 4 for k in (1, 2, 3, 4, 5, 6, 7, 8, 12, 100, 2000, 100000)]
    around = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.5, 7.0, 100.0, 1000.5, np.sqrt(2), np.sqrt(0.5), np.e]
    centres = np.array([*around, *angles], dtype=dtype)
    sides = [np.nextafter(centres, dtype(0)), centres, np.nextafter(centres, dtype(np.inf))]
    ends = [info.smallest_subnormal, tiny / 4, np.nextafter(tiny, dtype(0)), tiny, 2 * tiny, np.sqrt(tiny), huge / 4]
    extreme = [*ends, np.nextafter(huge, dtype(0)), huge, np.sqrt(huge)]
    positive = np.concatenate([np.array([*plain, *powers], dtype), *sides, np.array(extreme, dtype)])
    both = np.unique(np.concatenate([positive, -positive]))
    zeros = np.array([0.0, -0.0], dtype)
    return np.concatenate([both, zeros, np.array(list(STAND_IN), dtype)])


def rows(dtype: Float, arity: int, count: int, seed: int) -> NDArray[Any]:
    """Points (n, 3) whose first `arity` coordinates are hard numbers in all pairs, then `count` random ones.

    The random ones are of four sorts: uniform in -10..10, of any magnitude from 1e-30 to 1e30, near 1, and pairs that
    nearly agree.
    """
    rng = np.random.default_rng(seed)
    special = hard(dtype)
    if arity == 1:
        grid = np.repeat(special[:, None], 3, axis=1)
    else:
        a, b = np.meshgrid(special, special, indexing="ij")
        grid = np.stack([a.ravel(), b.ravel(), np.roll(b.ravel(), 7)], axis=1)
        if arity == 3:  # a condition and two numbers: the pairs with either answer
            grid = np.concatenate([grid[:, [2, 0, 1]], grid[:, [1, 2, 0]]])
    part = -(-count // 4)
    signs = rng.choice([-1.0, 1.0], (part, 3))
    linear = rng.uniform(-10, 10, (part, 3))
    wide = signs * 10.0 ** rng.uniform(-30, 30, (part, 3))
    near = 1 + signs * 10.0 ** rng.uniform(-7, 0, (part, 3))
    close = rng.uniform(-10, 10, (part, 1)) * (1 + rng.integers(-4, 5, (part, 3)) * float(np.finfo(dtype).eps))
    random = np.concatenate([linear, wide, near, close])[:count].astype(dtype)
    return np.concatenate([grid, random])
