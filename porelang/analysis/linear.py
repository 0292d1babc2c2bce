"""What a field is over boxes, up to a remainder of second order: linear forms, carried through a formula.

Each value is c + a.e + d over a box, with e in -1..1 along each axis, the slopes a for half the box, and |d| <= r.
An interval forgets of which coordinates a value was made: in f @ (p - s n), s and n found at p, its width grows at
each step by as much as all slopes allow, where the true value hardly changes; the distance `metric` was enclosed a
hundred times too widely. Linear forms keep that to first order, and what they forget falls with the square of the box
(affine arithmetic: L. H. de Figueiredo and J. Stolfi, Affine arithmetic: concepts and applications, Numerical
Algorithms 37, 2004; here the noise of all operations is one number, r, and each rule has a slope and a remainder by the
mean value theorem). Beside it the range of every value is kept, each tightened by the other.

Nothing is asked of a derivative of the formula: an operation that may jump, or that has no rule here, is known by its
range alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang import interval as iv
from porelang.analysis.enclose import NOWHERE, Enclosure, enclosed_leaf, enclosed_operation
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.interval import INF, Array, Interval, interval
from porelang.ir import Stage
from porelang.ops import TABLE, grid
from porelang.tape import AXES, PICK, Tape

#: What rounding in float64 adds to a form, of its magnitude, with room for what its own slopes lose.
_ROUNDING = 2.0**-49


#: c, a and r of a form.
Parts = tuple[Array, "Array | None", Array]
_MINUS = np.array(-1.0)


@dataclass(frozen=True, slots=True)
class Form:
    """c + a.e + d, |d| <= r, over n boxes: `c`, `r` and `reach` (the most that it is from c) of shape (n,) or (), `a`
    of shape (k, n), k of the axes, those along which boxes are wide, or None where all slopes are 0; and what is known
    without: the range, in which it lies as well, and where it may jump."""

    c: Array
    a: Array | None
    r: Array
    reach: Array
    known: Enclosure

    @property
    def range(self) -> Interval:
        return self.known.range


#: Operations: of what is shorter the centred form is as close, and plain ranges over smaller boxes are cheaper.
SHORT = 80


def has_rules(tape: Tape) -> bool:
    """Whether each operation that runs at points has a rule here, or one value over most boxes."""
    known = {*_RULES, *_LEVEL, _CUBIC}
    return all(tape.ops[i] in known or tape.kinds[i] == "bool" for i in tape.field)


def linear(formula: Formula, box: Sequence[Interval]) -> list[Enclosure]:
    """Ranges of a formula's roots over boxes as `enclose` gives them, exact up to float64, each met with what its
    linear form says."""
    tape = formula.tape
    wide = [k for k, r in enumerate(box) if bool(np.any(r.hi > r.lo))]  # slopes along the others are of no use
    known: dict[int, Any] = {}
    found: dict[int, Enclosure] = {}
    slopes: _Slopes = {}
    roots = frozenset(tape.roots)
    with np.errstate(all="ignore"):
        for i, op in enumerate(tape.ops):
            inputs = [known[a] for a in tape.inputs[i]]
            if op in TABLE or op == PICK:
                own = {a: _plain(k) for a, k in zip(tape.inputs[i], inputs, strict=True)}
                made = enclosed_operation(tape, i, own)
            else:
                made = enclosed_leaf(formula, i, box)
            if tape.kinds[i] == "real" and isinstance(made, Enclosure):
                rule = _RULES.get(op) if tape.stages[i] is Stage.FIELD else None
                parts = None if rule is None else rule(made.range, *inputs)
                if op == _CUBIC and tape.stages[i] is Stage.FIELD and inputs[0] is not None:
                    parts = _cubic(slopes, tape.inputs[i], tape.values[i], *inputs)
                made = _made(parts, made)
                if op in AXES and AXES[op] in wide:
                    made = _coordinate(wide.index(AXES[op]), len(wide), made.range)
            known[i] = made
            if i in roots:
                found[i] = _plain(made)
            for a in tape.dying[i]:
                if tape.stages[a] is Stage.FIELD:
                    del known[a]
    return [found[r] for r in tape.roots]


def _plain(known: Any) -> Any:
    return known.known if isinstance(known, Form) else known


def _coordinate(axis: int, count: int, r: Interval) -> Form:
    half = (r.hi - r.lo) / 2
    a = np.zeros((count, *half.shape))
    a[axis] = half
    slack = _ROUNDING * (np.abs(r.lo) + np.abs(r.hi))
    return Form((r.lo + r.hi) / 2, a, slack, half + slack, Enclosure(r, NOWHERE))


def _made(parts: Parts | None, known: Enclosure) -> Form:
    """A form of its parts, and of what was found for it without; where they are no numbers, of the range alone."""
    r = known.range
    middle, half = (r.lo + r.hi) / 2, (r.hi - r.lo) / 2
    usable = np.isfinite(half)
    if parts is None:
        c = np.where(usable, middle, 0.0)
        half = np.where(usable, half + _ROUNDING * np.abs(middle), INF)
        return Form(c, None, half, half, known)
    c, a, rest = parts
    reach = rest if a is None else np.abs(a).sum(axis=0) + rest
    slack = _ROUNDING * (np.abs(c) + reach)
    rest, reach = rest + slack, reach + slack
    bad = ~np.isfinite(c + reach)
    if bad.any():
        flat = np.where(usable, half + _ROUNDING * np.abs(middle), INF)
        c = np.where(bad, np.where(usable, middle, 0.0), c)
        rest, reach = np.where(bad, flat, rest), np.where(bad, flat, reach)
        a = None if a is None else np.where(bad, 0.0, a)
    low, high = np.maximum(r.lo, c - reach), np.minimum(r.hi, c + reach)
    crossed = low > high  # by rounding alone: both hold
    low, high = np.where(crossed, r.lo, low), np.where(crossed, r.hi, high)
    reach = np.minimum(reach, np.maximum(high - c, c - low))
    return Form(c, a, rest, reach, Enclosure(Interval(low, high, r.nan), known.jumps))


def _sum(p: Array | None, q: Array | None) -> Array | None:
    return q if p is None else p if q is None else p + q


def _times(k: Array, a: Array | None) -> Array | None:
    return None if a is None else k * a


def _sloped(u: Form, value: Array, least: Array, most: Array) -> Parts:
    """`value` at u.c of a function whose difference quotients from there lie between `least` and `most`."""
    m, w = (least + most) / 2, (most - least) / 2
    return value, _times(m, u.a), np.abs(m) * u.r + w * u.reach


def _neg(_: Interval, u: Form) -> Parts:
    return -u.c, _times(_MINUS, u.a), u.r


def _add(_: Interval, u: Form, v: Form) -> Parts:
    return u.c + v.c, _sum(u.a, v.a), u.r + v.r


def _sub(_: Interval, u: Form, v: Form) -> Parts:
    return u.c - v.c, _sum(u.a, _times(_MINUS, v.a)), u.r + v.r


def _mul(_: Interval, u: Form, v: Form) -> Parts:
    a = _sum(_times(v.c, u.a), _times(u.c, v.a))
    return u.c * v.c, a, np.abs(u.c) * v.r + np.abs(v.c) * u.r + u.reach * v.reach


def _square(_: Interval, u: Form) -> Parts:
    half = u.reach * u.reach / 2  # the square of what is beyond c: 0 to twice that
    return u.c * u.c + half, _times(2 * u.c, u.a), 2 * np.abs(u.c) * u.r + half


def _div(_: Interval, u: Form, v: Form) -> Parts | None:
    q = u.c / v.c
    # u / v - q = (du - q dv) / v: what both have in common is gone
    a = _sum(u.a, _times(-q, v.a))
    r = u.r + np.abs(q) * v.r
    one, other = 1 / v.range.lo, 1 / v.range.hi
    safe = (v.range.lo > 0) | (v.range.hi < 0)
    m, w = (one + other) / 2, np.where(safe, np.abs(one - other) / 2, INF)
    reach = r if a is None else np.abs(a).sum(axis=0) + r
    return q, _times(m, a), np.abs(m) * r + w * reach


def _sqrt(_: Interval, u: Form) -> Parts:
    root = np.sqrt(u.c)
    low, high = np.sqrt(np.maximum(u.range.lo, 0.0)), np.sqrt(u.range.hi)
    return _sloped(u, root, 1 / (root + high), 1 / (root + low))


def _hypot(f: Interval, u: Form, v: Form) -> Parts:
    # the difference from c is (du (u + u.c) + dv (v + v.c)) / (f + f.c): quotients between -1 and 1
    length = np.hypot(u.c, v.c)
    total: Parts = (length, None, np.zeros(()))
    for one in (u, v):
        s = iv.div(iv.add(one.range, interval(one.c)), iv.add(f, interval(length)))
        a, r = _sloped(one, length, np.maximum(s.lo, -1.0), np.minimum(s.hi, 1.0))[1:]
        total = (length, _sum(total[1], a), total[2] + r)
    return total


def _wave(function: Callable[[Array], Array], slope: Callable[[Array], Array], rate: float) -> Callable[..., Parts]:
    """The rule of a sine, with its slope at c; what is left is at most half of rate^2 times the square."""

    def rule(_: Interval, u: Form) -> Parts:
        m = rate * slope(u.c)
        return function(u.c), _times(m, u.a), np.abs(m) * u.r + (rate * rate / 2) * u.reach * u.reach

    return rule


def _folded(u: Form) -> Parts:
    """|u|: as u where its sign is known, else between 0 and the chord over its range."""
    lo, hi = u.range.lo, u.range.hi
    decided = (lo >= 0) | (hi <= 0)
    width = np.where(decided, 1.0, hi - lo)
    m = np.where(lo >= 0, 1.0, np.where(hi <= 0, -1.0, (hi + lo) / width))
    half = np.where(decided, 0.0, -lo * hi / width)  # |u| - m u lies between 0 and twice that
    return m * u.c + half, _times(m, u.a), np.abs(m) * u.r + half


def _abs(_: Interval, u: Form) -> Parts:
    return _folded(u)


def _lesser(u: Form, v: Form, way: float) -> Parts:
    """min (way -1) or max (way 1), (u + v +- |u - v|) / 2: decided by what both have in common, too."""
    apart = iv.sub(u.range, v.range)
    difference = _made(_sub(apart, u, v), Enclosure(apart, NOWHERE))
    c, a, r = _folded(difference)
    both = (u.c + v.c + way * c) / 2
    slopes = _sum(_sum(u.a, v.a), _times(np.array(way), a))
    # where one of the two is decided for, it is that one as it is
    m = np.where(difference.range.lo >= 0, 1.0, np.where(difference.range.hi <= 0, -1.0, 0.0)) * way
    rest = np.where(m > 0, u.r, np.where(m < 0, v.r, (u.r + v.r + r) / 2))
    value = np.where(m > 0, u.c, np.where(m < 0, v.c, both))
    if slopes is None:
        return value, None, rest
    none = np.zeros((1, 1))
    of_u, of_v = (none if f.a is None else f.a for f in (u, v))
    return value, np.where(m > 0, of_u, np.where(m < 0, of_v, slopes / 2)), rest


def _min(_: Interval, u: Form, v: Form) -> Parts:
    return _lesser(u, v, -1.0)


def _max(_: Interval, u: Form, v: Form) -> Parts:
    return _lesser(u, v, 1.0)


def _atan2(_: Interval, y: Form, x: Form) -> Parts:
    # between c and any place the slopes are those over both
    ys, xs = (Interval(np.minimum(f.c, f.range.lo), np.maximum(f.c, f.range.hi), f.range.nan) for f in (y, x))
    far = iv.add(iv.square(xs), iv.square(ys))
    cut = (xs.lo <= 0) & ys.contains(0.0)
    angle = np.where(cut, np.nan, np.arctan2(y.c, x.c))
    total: Parts = (angle, None, np.zeros(()))
    for one, slope in ((y, iv.div(xs, far)), (x, iv.neg(iv.div(ys, far)))):
        a, r = _sloped(one, angle, slope.lo, slope.hi)[1:]
        total = (angle, _sum(total[1], a), total[2] + r)
    return total


def _exp(_: Interval, u: Form) -> Parts:
    low, high = np.minimum(u.c, u.range.lo), np.maximum(u.c, u.range.hi)
    return _sloped(u, np.exp(u.c), np.exp(low), np.exp(high))


def _log(_: Interval, u: Form) -> Parts:
    low, high = np.minimum(u.c, u.range.lo), np.maximum(u.c, u.range.hi)
    return _sloped(u, np.log(u.c), 1 / high, np.where(low > 0, 1 / low, INF))


def _select(_: Interval, condition: Enclosure, u: Form, v: Form) -> Parts:
    """The branch that is taken all over a box; where both are, the range alone."""
    yes, no = condition.range.lo >= 1, condition.range.hi <= 0
    c = np.where(yes, u.c, np.where(no, v.c, np.nan))
    none = np.zeros((1, 1))
    of_u, of_v = (none if f.a is None else f.a for f in (u, v))
    return c, np.where(yes, of_u, of_v), np.where(yes, u.r, v.r)


#: What was found of derivatives of lookups, by where they look and the payload: a lookup and its neighbours share them.
_Slopes = dict[tuple[tuple[int, ...], grid.Payload], Interval]
_CUBIC = "lookup_cubic"
#: Of derivatives beyond this order in all the range is as close: they are used times what is small.
_ORDER = 2


def _cubic(
    slopes: _Slopes, at: tuple[int, ...], payload: Any, data: SampledField, x: Form, y: Form, z: Form
) -> Parts | None:
    """A lookup with a smooth gradient, by its slopes from c to any place of the box; where it may jump, the range."""
    if sum(payload[1:]) > _ORDER:
        return None
    px, py, pz = (Interval(np.minimum(f.c, f.range.lo), np.maximum(f.c, f.range.hi), f.range.nan) for f in (x, y, z))
    there = grid.enclose(data, interval(x.c), interval(y.c), interval(z.c), payload, True)
    value = np.where(grid.jumps(data, px, py, pz, payload, True), np.nan, (there.lo + there.hi) / 2)
    total: Parts = (value, None, (there.hi - there.lo) / 2)
    component, i, j, k = payload
    for one, orders in ((x, (i + 1, j, k)), (y, (i, j + 1, k)), (z, (i, j, k + 1))):
        key = (at, (component, *orders))
        if key not in slopes:
            slopes[key] = grid.enclose(data, px, py, pz, key[1], True)
        a, r = _sloped(one, value, slopes[key].lo, slopes[key].hi)[1:]
        total = (value, _sum(total[1], a), total[2] + r)
    return total


_TAU = math.tau
_RULES: dict[str, Callable[..., Parts | None]] = {
    "neg": _neg,
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "square": _square,
    "div": _div,
    "direction": _div,
    "sqrt": _sqrt,
    "hypot": _hypot,
    "exp": _exp,
    "log": _log,
    "atan2": _atan2,
    "select": _select,
    "abs": _abs,
    "min": _min,
    "max": _max,
    "sin": _wave(np.sin, np.cos, 1.0),
    "cos": _wave(np.cos, lambda u: -np.sin(u), 1.0),
    "sin_turns": _wave(lambda u: np.sin(_TAU * (u - np.rint(u))), lambda u: np.cos(_TAU * (u - np.rint(u))), _TAU),
    "cos_turns": _wave(lambda u: np.cos(_TAU * (u - np.rint(u))), lambda u: -np.sin(_TAU * (u - np.rint(u))), _TAU),
}
#: What is one value over most boxes, so that its range is all there is to know.
_LEVEL = frozenset({"floor", "round", "sign"})
