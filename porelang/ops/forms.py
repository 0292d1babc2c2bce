"""NumPy forms of the operations that are more than one ufunc, with `out=` as their first scratch buffer."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Values = Any  # an array or a NumPy scalar of the working type


def mod(a: Values, b: Values, out: Values = None) -> Values:
    """a - b floor(a / b): the sign of the divisor, as GLSL's mod."""
    q = np.divide(a, b, out=out)
    q = np.floor(q, out=out)
    q = np.multiply(b, q, out=out)
    return np.subtract(a, q, out=out)


def hypot(a: Values, b: Values, out: Values = None) -> Values:
    """sqrt(a a + b b), several times faster than np.hypot, which also guards against overflow."""
    s = np.add(np.square(a), np.square(b), out=out)
    return np.sqrt(s, out=out)


def direction(a: Values, r: Values, out: Values = None) -> Values:
    """a / r, and 0 where r is 0."""
    q = np.divide(a, r, out=out)
    if out is None:
        return np.where(np.equal(r, 0), np.zeros_like(q), q)[()]
    np.copyto(q, 0, where=np.equal(r, 0))
    return q


def reduced(u: Values, out: Values = None) -> Values:
    """u turns in radians, less whole turns, which are taken off before the multiplication by tau: exactly."""
    r = np.subtract(u, np.rint(u, out=out), out=out)
    return np.multiply(r, r.dtype.type(math.tau), out=out)


def sin_turns(u: Values, out: Values = None) -> Values:
    """Sine of u turns."""
    return np.sin(reduced(u, out), out=out)


def cos_turns(u: Values, out: Values = None) -> Values:
    """Cosine of u turns."""
    return np.cos(reduced(u, out), out=out)


def select(c: Values, a: Values, b: Values, out: Values = None) -> Values:
    if out is None:
        return np.asarray(np.where(c, a, b))[()]
    np.copyto(out, b)
    np.copyto(out, a, where=c)
    return out
