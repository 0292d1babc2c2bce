"""Interval arithmetic on arrays: what an operation can return when its arguments are only known to lie in ranges.

An `Interval` holds three arrays: `lo`, `hi` and `nan` (the result may be NaN). A value that is certainly NaN has the
empty range `lo = +inf > hi = -inf`. The functions here are exact up to a rounding of float64; the caller widens
results by the tolerance of the operation, which covers that rounding too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
INF = math.inf


@dataclass(frozen=True, slots=True)
class Interval:
    """Ranges `lo..hi` of real numbers, or of truth values as 0 and 1; `nan` where the value may be NaN."""

    lo: Array
    hi: Array
    nan: Mask

    @property
    def empty(self) -> Mask:
        """Where no number is possible (the value is certainly NaN)."""
        return self.lo > self.hi

    def contains(self, value: float) -> Mask:
        """Where `value` is possible."""
        return (self.lo <= value) & (value <= self.hi)


def interval(lo: object, hi: object | None = None) -> Interval:
    """The interval `lo..hi` (or the single value `lo`) as float64 arrays; NaN ends become "may be NaN"."""
    low = np.asarray(lo, dtype=np.float64)
    high = low if hi is None else np.asarray(hi, dtype=np.float64)
    bad = np.isnan(low) | np.isnan(high)
    if bad.any():
        if hi is None:
            return Interval(np.where(bad, INF, low), np.where(bad, -INF, high), bad)
        return Interval(np.where(bad, -INF, low), np.where(bad, INF, high), bad)
    return Interval(low, high, np.zeros(np.broadcast(low, high).shape, dtype=np.bool_))


def truth(false: Mask, true: Mask) -> Interval:
    """The truth values that are possible."""
    return Interval(np.where(false, 0.0, 1.0), np.where(true, 1.0, 0.0), np.zeros(np.shape(false), np.bool_))


def _all_finite(lo: Array, hi: Array) -> bool:
    """Whether ends are numbers everywhere, so that nothing infinite, empty or undefined went into them."""
    return bool(np.isfinite(hi - lo).all())


def _made(lo: Array, hi: Array, nan: Mask, *arguments: Interval) -> Interval:
    """A result, with NaN ends opened to infinity and empty arguments handed on."""
    if not _all_finite(lo, hi):
        lo = np.where(np.isnan(lo), -INF, lo)
        hi = np.where(np.isnan(hi), INF, hi)
    for a in arguments:
        nan = nan | a.nan
        empty = a.empty
        if empty.any():
            lo, hi = np.where(empty, INF, lo), np.where(empty, -INF, hi)
    return Interval(lo, hi, nan)


def _infinite(a: Interval) -> Mask:
    return np.isinf(a.lo) | np.isinf(a.hi)


def neg(a: Interval) -> Interval:
    return Interval(-a.hi, -a.lo, a.nan)


def add(a: Interval, b: Interval) -> Interval:
    lo, hi = a.lo + b.lo, a.hi + b.hi
    if _all_finite(lo, hi):
        return Interval(lo, hi, a.nan | b.nan)
    nan = ((a.hi == INF) & (b.lo == -INF)) | ((a.lo == -INF) & (b.hi == INF))
    return _made(lo, hi, nan, a, b)


def sub(a: Interval, b: Interval) -> Interval:
    return add(a, neg(b))


def mul(a: Interval, b: Interval) -> Interval:
    one, two, three, four = a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi
    lo = np.minimum(np.minimum(one, two), np.minimum(three, four))
    hi = np.maximum(np.maximum(one, two), np.maximum(three, four))
    if _all_finite(lo, hi):
        return Interval(lo, hi, a.nan | b.nan)
    ends = [_product(p, q) for p in (a.lo, a.hi) for q in (b.lo, b.hi)]
    nan = (_infinite(a) & b.contains(0.0)) | (_infinite(b) & a.contains(0.0))
    return _made(np.minimum.reduce(ends), np.maximum.reduce(ends), nan, a, b)


def _product(p: Array, q: Array) -> Array:
    """Products of interval ends, where 0 * inf is 0: the bound is a limit, not a value."""
    out = p * q
    return np.where(np.isnan(out), 0.0, out)


def square(a: Interval) -> Interval:
    m = absolute(a)
    return _made(m.lo * m.lo, m.hi * m.hi, a.nan, a)


def div(a: Interval, b: Interval) -> Interval:
    zero = b.contains(0.0)
    if not (zero.any() or b.empty.any() or a.empty.any()):
        one, two, three, four = a.lo / b.lo, a.lo / b.hi, a.hi / b.lo, a.hi / b.hi
        lo = np.minimum(np.minimum(one, two), np.minimum(three, four))
        hi = np.maximum(np.maximum(one, two), np.maximum(three, four))
        if _all_finite(lo, hi):
            return Interval(lo, hi, a.nan | b.nan)
    safe_lo, safe_hi = np.where(zero, 1.0, b.lo), np.where(zero, 1.0, b.hi)
    ends = [_quotient(p, q) for p in (a.lo, a.hi) for q in (safe_lo, safe_hi)]
    lo, hi = np.minimum.reduce(ends), np.maximum.reduce(ends)
    # A divisor that only touches 0 (x / r with r >= 0) still bounds the quotient on one side; either sign of zero
    # may be meant, so that this holds only where the zero is not attained: it is attained, hence both infinities.
    lo, hi = np.where(zero, -INF, lo), np.where(zero, INF, hi)
    nan = (zero & a.contains(0.0)) | (_infinite(a) & _infinite(b))
    return _made(lo, hi, nan, a, b)


def _quotient(p: Array, q: Array) -> Array:
    out = p / q
    return np.where(np.isnan(out), 0.0, out)


def minimum(a: Interval, b: Interval) -> Interval:
    return _made(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), a.nan | b.nan, a, b)


def maximum(a: Interval, b: Interval) -> Interval:
    return _made(np.maximum(a.lo, b.lo), np.maximum(a.hi, b.hi), a.nan | b.nan, a, b)


def absolute(a: Interval) -> Interval:
    low = np.maximum(np.maximum(a.lo, -a.hi), 0.0)
    return _made(low, np.maximum(-a.lo, a.hi), a.nan, a)


def monotone(function: Callable[[Array], Array]) -> Callable[[Interval], Interval]:
    """The rule of a function that never falls."""

    def rule(a: Interval) -> Interval:
        return _made(function(a.lo), function(a.hi), a.nan, a)

    return rule


def on_domain(
    function: Callable[[Array], Array], least: float, most: float, rising: bool = True
) -> Callable[[Interval], Interval]:
    """The rule of a monotone function that is NaN outside `least..most`."""

    def rule(a: Interval) -> Interval:
        nan = (a.lo < least) | (a.hi > most)
        outside = (a.hi < least) | (a.lo > most)
        low, high = np.clip(a.lo, least, most), np.clip(a.hi, least, most)
        lo, hi = (function(low), function(high)) if rising else (function(high), function(low))
        return _made(np.where(outside, INF, lo), np.where(outside, -INF, hi), nan | a.nan, a)

    return rule


def sin_turns(u: Interval) -> Interval:
    """Sine of `u` turns: its crests lie at 1/4 + n, its troughs at 3/4 + n."""
    return _wave(u, u.lo, u.hi, 0.25, lambda v: np.sin(math.tau * (v - np.rint(v))))


def cos_turns(u: Interval) -> Interval:
    return _wave(u, u.lo, u.hi, 0.0, lambda v: np.cos(math.tau * (v - np.rint(v))))


def reduced(u: Interval) -> Interval:
    """`u` turns in radians, less whole turns: -pi to pi, or less where all of `u` lies nearest to one whole number."""
    low, high = np.rint(u.lo), np.rint(u.hi)
    one = (low == high) & np.isfinite(low)
    with np.errstate(invalid="ignore"):
        lo, hi = np.where(one, math.tau * (u.lo - low), -math.pi), np.where(one, math.tau * (u.hi - low), math.pi)
    return _made(lo, hi, _infinite(u), u)


def sin(a: Interval) -> Interval:
    """Sine of `a` radians."""
    return _wave(a, a.lo / math.tau, a.hi / math.tau, 0.25, np.sin)


def cos(a: Interval) -> Interval:
    return _wave(a, a.lo / math.tau, a.hi / math.tau, 0.0, np.cos)


def _wave(a: Interval, lo: Array, hi: Array, crest: float, function: Callable[[Array], Array]) -> Interval:
    """The rule of a sine of `a`, that is of lo..hi turns: crests lie at `crest` + n, troughs half a turn from them."""
    wide = ~(hi - lo < 1.0)  # infinite ones too
    slack = (np.maximum(np.abs(lo), np.abs(hi)) + 1.0) * 2.0**-51
    finite = _all_finite(a.lo, a.hi)
    with np.errstate(invalid="ignore"):
        ends = [function(v if finite else np.where(np.isinf(v), 0.0, v)) for v in (a.lo, a.hi)]
        top = wide | (np.floor(hi - crest + slack) >= np.ceil(lo - crest - slack))
        low_point = crest + 0.5
        bottom = wide | (np.floor(hi - low_point + slack) >= np.ceil(lo - low_point - slack))
    return _made(np.where(bottom, -1.0, np.minimum(*ends)), np.where(top, 1.0, np.maximum(*ends)), _infinite(a), a)


def atan2(y: Interval, x: Interval) -> Interval:
    """Angle of (x, y): extremes lie at the corners of the box, unless it holds the origin or crosses the cut."""
    ends = [np.arctan2(p, q) for p in (y.lo, y.hi) for q in (x.lo, x.hi)]
    cut = (x.lo <= 0.0) & y.contains(0.0)
    lo = np.where(cut, -math.pi, np.minimum.reduce(ends))
    hi = np.where(cut, math.pi, np.maximum.reduce(ends))
    return _made(lo, hi, np.zeros(lo.shape, np.bool_), y, x)


def power(a: Interval, b: Interval) -> Interval:
    """a ^ b with NumPy's rules; on a negative base only a single whole exponent gives a number."""
    base = Interval(np.maximum(a.lo, 0.0), np.maximum(a.hi, 0.0), a.nan)
    with np.errstate(all="ignore"):
        ends = [np.power(p, q) for p in (base.lo, base.hi) for q in (b.lo, b.hi)]
        lo, hi = np.asarray(np.minimum.reduce(ends)), np.asarray(np.maximum.reduce(ends))
        # x ^ q passes 1 where x = 1 or q = 0
        one = base.contains(1.0) | b.contains(0.0)
        lo, hi = np.where(one, np.minimum(lo, 1.0), lo), np.where(one, np.maximum(hi, 1.0), hi)
        single = b.lo == b.hi
        whole = single & (b.lo == np.rint(b.lo))
        even = whole & (np.fmod(b.lo, 2.0) == 0)
        # a zero may be the negative one, of which the odd negative powers are -infinity
        lo = np.where(a.contains(0.0) & (b.lo < 0) & ~even & (whole | ~single), -INF, lo)
        negative = a.lo < 0
        if not negative.any():
            return _power_of_nan(_made(lo, hi, np.zeros(np.shape(lo), np.bool_), a, b), a, b)
        sides = [np.power(v, np.where(whole, b.lo, 1.0)) for v in (a.lo, a.hi)]
        least, most = np.minimum(*sides), np.maximum(*sides)
        crosses = a.contains(0.0)
        least = np.where(crosses & even & (b.lo > 0), 0.0, least)
        pole = crosses & (b.lo < 0)
        least = np.where(pole & ~even, -INF, least)
        most = np.where(pole, INF, most)
        size = np.maximum.reduce([np.power(np.abs(p), q) for p in (a.lo, a.hi) for q in (b.lo, b.hi)])
        size = np.where(crosses & (b.lo < 0), INF, np.maximum(size, 1.0))
        lo = np.where(negative, np.where(whole, least, -size), lo)
        hi = np.where(negative, np.where(whole, most, size), hi)
    return _power_of_nan(_made(lo, hi, negative & ~whole, a, b), a, b)


def _power_of_nan(r: Interval, a: Interval, b: Interval) -> Interval:
    """The two powers of what is not a number that are one: x ^ 0 and 1 ^ x."""
    one = (a.nan & b.contains(0.0)) | (b.nan & a.contains(1.0))
    return Interval(np.where(one, np.minimum(r.lo, 1.0), r.lo), np.where(one, np.maximum(r.hi, 1.0), r.hi), r.nan)


def one_period(quotient: Interval, rounded: bool = True) -> Mask:
    """Where a quotient certainly has one and the same floor; `rounded` by a backend before its floor is taken, or as
    float64 has it: a whole multiple is one then."""
    slack, least = (2.0**-21, 1e-37) if rounded else (0.0, 0.0)
    low = np.floor(quotient.lo - np.abs(quotient.lo) * slack - least)
    high = np.floor(quotient.hi + np.abs(quotient.hi) * slack + least)
    return np.asarray((low == high) & np.isfinite(low))


def mod(a: Interval, b: Interval, rounded: bool = True) -> Interval:
    """a - b floor(a / b): inside 0..b, a - k b where the floor is k for certain, anything where a part may overflow."""
    quotient = div(a, b)
    certain = one_period(quotient, rounded)
    k = np.where(certain, np.floor(quotient.lo), 0.0)
    ends = [_product(k, b.lo), _product(k, b.hi)]
    beyond = np.zeros((), np.bool_)
    for part in (quotient, a, b):
        beyond = beyond | (part.lo < -1e37) | (part.hi > 1e37)
    lo = np.where(beyond, -INF, np.where(certain, a.lo - np.maximum(*ends), np.minimum(b.lo, 0.0)))
    hi = np.where(beyond, INF, np.where(certain, a.hi - np.minimum(*ends), np.maximum(b.hi, 0.0)))
    nan = b.contains(0.0) | _infinite(a) | _infinite(b) | quotient.nan | beyond
    return _made(lo, hi, nan, a, b)


def sign(a: Interval) -> Interval:
    return _made(np.asarray(np.sign(a.lo)), np.asarray(np.sign(a.hi)), a.nan, a)


def less(a: Interval, b: Interval) -> Interval:
    possible = ~a.empty & ~b.empty
    return truth((a.hi >= b.lo) | a.nan | b.nan | ~possible, possible & (a.lo < b.hi))


def less_equal(a: Interval, b: Interval) -> Interval:
    possible = ~a.empty & ~b.empty
    return truth((a.hi > b.lo) | a.nan | b.nan | ~possible, possible & (a.lo <= b.hi))


def equal(a: Interval, b: Interval) -> Interval:
    possible = ~a.empty & ~b.empty
    apart = np.asarray((a.hi < b.lo) | (b.hi < a.lo))
    same = (a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo)
    return truth(~same | a.nan | b.nan | ~possible, possible & ~apart)


def conjunction(a: Interval, b: Interval) -> Interval:
    return Interval(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), a.nan | b.nan)


def disjunction(a: Interval, b: Interval) -> Interval:
    return Interval(np.maximum(a.lo, b.lo), np.maximum(a.hi, b.hi), a.nan | b.nan)


def negation(a: Interval) -> Interval:
    return Interval(1.0 - a.hi, 1.0 - a.lo, a.nan)


def select(c: Interval, a: Interval, b: Interval) -> Interval:
    yes, no = c.hi > 0, c.lo < 1
    lo = np.minimum(np.where(yes, a.lo, INF), np.where(no, b.lo, INF))
    hi = np.maximum(np.where(yes, a.hi, -INF), np.where(no, b.hi, -INF))
    return Interval(lo, hi, (yes & a.nan) | (no & b.nan))


def meet(a: Interval, b: Interval) -> Interval:
    """What lies in both; empty (lo > hi) where nothing does."""
    return Interval(np.maximum(a.lo, b.lo), np.minimum(a.hi, b.hi), a.nan)


def up_to(w: Interval) -> Interval:
    """Numbers whose magnitude is at most the high end of `w`."""
    return Interval(-w.hi, w.hi, w.nan)


def at_most(w: Interval) -> Interval:
    return Interval(np.full_like(w.hi, -INF), w.hi, w.nan)


def at_least(w: Interval) -> Interval:
    return Interval(w.lo, np.full_like(w.lo, INF), w.nan)
