"""What each operation of the table means, written a second time, apart from it and in a wider type.

The sweep compares the backends with these. Float32 is compared with float64, float64 with NumPy's long double (64 bits
of mantissa on x86, 112 on 64-bit ARM under Linux; on macOS, where it is no wider than float64, only gross errors of
the float64 backend show).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Wide = NDArray[Any]


def _pi(kind: Any) -> Any:
    """Pi in the type `kind`."""
    return 4 * np.arctan(kind(1))


def _mod(a: Wide, b: Wide) -> Wide:
    """The remainder with the sign of the divisor; C's fmod is exact."""
    r = np.fmod(a, b)
    r = np.where((r != 0) & ((r < 0) != (b < 0)), r + b, r)
    return np.where(np.isinf(b), np.nan, r)  # a - b floor(a / b) has no limit there


def _least(a: Wide, b: Wide) -> Wide:
    return np.where(np.isnan(a) | np.isnan(b), np.nan, np.where(a < b, a, b))


def _sign(a: Wide) -> Wide:
    return np.where(np.isnan(a), np.nan, np.where(a > 0, 1.0, 0.0) - np.where(a < 0, 1.0, 0.0))


def _round(a: Wide) -> Wide:
    """Halves go to the even number: floor(a + 1/2), less 1 where that was a half on the way to an odd one."""
    low = np.floor(a)
    part = a - low
    odd = np.fmod(low, 2) != 0
    return np.where(np.isinf(a) | np.isnan(a), a, low + ((part > 0.5) | ((part == 0.5) & odd)))


def _pow(a: Wide, b: Wide) -> Wide:
    """C's power; long doubles of infinities and even exponents beyond 2^62 go wrong in some C libraries."""
    return np.asarray(np.where(np.isinf(a), np.power(a.astype(np.float64), b.astype(np.float64)), np.power(a, b)))


def _hypot(a: Wide, b: Wide) -> Wide:
    """As the table means it: NaN is handed on even beside an infinity, which C's hypot does not do."""
    return np.asarray(np.where(np.isnan(a) | np.isnan(b), np.nan, np.hypot(a, b)))


def _sine(u: Wide, shift: int) -> Wide:
    """sin(tau u + shift pi / 2), the argument reduced to an eighth of a turn first."""
    r = u - np.rint(u)
    quarters = np.rint(4 * r)
    t = (r - quarters / 4) * (2 * _pi(u.dtype.type))
    k = np.where(np.isnan(quarters), 0, quarters).astype(np.int64) + shift
    value = np.where(k % 2 == 0, np.sin(t), np.cos(t))
    return np.asarray(np.where(k % 4 >= 2, -value, value))


#: The exact result of each operation, by its name in the table.
EXACT: dict[str, Callable[..., Wide]] = {
    "neg": lambda a: 0 - a,
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "square": lambda a: a * a,
    "div": lambda a, b: a / b,
    "mod": _mod,
    "pow": _pow,
    "min": _least,
    "max": lambda a, b: -_least(-a, -b),
    "abs": lambda a: np.where(a < 0, -a, a),
    "sign": _sign,
    "floor": np.floor,
    "round": _round,
    "sqrt": np.sqrt,
    "hypot": _hypot,
    "direction": lambda a, r: np.where(r == 0, 0.0, a / r),
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "reduced": lambda u: (u - np.rint(u)) * (2 * _pi(u.dtype.type)),
    "sin_turns": lambda u: _sine(u, 0),
    "cos_turns": lambda u: _sine(u, 1),
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan2": np.arctan2,
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
    "eq": lambda a, b: a == b,
    "and": lambda a, b: a & b,
    "or": lambda a, b: a | b,
    "not": lambda a: ~a,
    "select": np.where,
}


def exact(name: str, *arguments: Wide) -> Wide:
    """The result of an operation on arrays of a wide type (bool for conditions)."""
    with np.errstate(all="ignore"):
        return np.asarray(EXACT[name](*arguments))
