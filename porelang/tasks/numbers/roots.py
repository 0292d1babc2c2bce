"""The number for which a function takes a value: one and only one, or it is said why not.

Of a formula all places are known (`places`). A function that asks for numbers found from fields is asked few times: it
is searched from the ends where it is proven to rise or to fall throughout (`trends`), else looked at in places between.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from porelang.data import Reduced
from porelang.diagnostics import PoreError, fail
from porelang.tasks.numbers.places import NARROW, Line, level, places, values_met

_STEPS = 60
#: Where nothing is proven of a function it is looked at in so many places between the ends. They lie unevenly, by the
#: golden ratio, so that no period of a function hides between them.
_PROBES = 9
_GOLDEN = (math.sqrt(5) - 1) / 2
#: What changes within the narrowest range by so much of all that was met is a jump.
_JUMP = 1e-6
#: A place as wide as this share of the range, where a function may turn, is no answer.
_WIDE = 1e-6
_NAMED = 4


def checked(target: float, low: float, high: float) -> None:
    """Errors: E093 where the target is not a number, E095 for an empty range."""
    if math.isnan(target):
        raise fail(
            "E093", "the target of `solve` is not a number", hint="look for a root or logarithm of a negative one"
        )
    if not low < high:
        raise fail("E095", f"`solve` looks in an empty range: {low:g}..{high:g}", hint="the lower end comes first")


def answer_of(line: Line, settled: Line, target: float, low: float, high: float) -> Reduced:
    """The t in `low..high` for which a formula is its target; the error is proven, rounding included.

    `line` has numbers that are not known exactly as ranges, `settled` at their values. Errors: E094 for a target out of
    reach, E098 where there are several answers, or may be, E099 where the function jumps over its target.
    """
    met = values_met(settled, low, high) + target
    if not len(met):
        raise _no_number(low, high)
    found = places(line, low, high)
    wide = [p for p in found if not p.one and p.high - p.low > _WIDE * (high - low)]
    if wide:
        raise fail(
            "E098",
            f"`solve` may have many answers: between {wide[0].low:.4g} and {wide[-1].high:.4g} the function cannot be "
            f"told from {target:g}, or turns there too often",
            hint="narrow the range to where it rises or falls throughout",
        )
    jumped = [p for p in found if p.jumps and p.met is None]
    found = [p for p in found if p not in jumped]
    if not found and any(p.certain for p in jumped):
        place = next(p for p in jumped if p.certain)
        sides = values_met(settled, place.low, place.high) + target
        raise _jumped(place.low, place.high, float(sides[0]), float(sides[-1]), target)
    if not any(p.certain for p in found):
        raise _out_of_reach(target, low, high, [float(v) for v in (met[0], met.min(), met.max(), met[-1])])
    if len(found) > 1:
        raise _several([(p.at, p.certain) for p in found], target, low, high)
    (place,) = found
    width = place.high - place.low
    if width > _WIDE * (high - low) and level(settled, place):
        raise fail(
            "E098",
            f"`solve` has any number of answers: it is {target:g} throughout {place.low:.4g}..{place.high:.4g}",
            hint="ask for another value, or for what varies there",
        )
    t = (place.low + place.high) / 2
    return Reduced(t, width / 2 + 2.0**-50 * max(abs(place.low), abs(place.high)))


def _no_number(*where: float) -> PoreError:
    there = f"{'from' if where[1:] else 'at'} {' to '.join(f'{t:g}' for t in where)}"
    return fail(
        "E093",
        f"the function of `solve` is not a number {there}",
        hint="narrow the range to where it is one: a root, a logarithm or a power of a negative number is none",
    )


def _several(
    answers: Sequence[tuple[float, bool]], target: float, low: float, high: float, figures: int = 6
) -> PoreError:
    """`answers` are places, and whether the target is taken there for certain; known to so many `figures`."""
    shown = [t for t, _ in answers[:_NAMED]]
    more = len(answers) - len(shown)
    told = ", ".join(f"{t:.{figures}g}" for t in (shown if more else shown[:-1]))
    told = f"{told} and {more} more" if more else f"{told} and {shown[-1]:.{figures}g}"
    near = "" if all(sure for _, sure in answers) else ", or too near it to tell,"
    edge, many = (shown[0] + shown[1]) / 2, "at least " if figures < 6 else ""
    told = f"near {told}" if figures < 6 else f"at {told}"
    return fail(
        "E098",
        f"`solve` has {many}{len(answers)} answers from {low:g} to {high:g}: it is {target:g}{near} {told}",
        hint=f"narrow the range to one of them: `{low:g}..{edge:.4g}` holds the first alone",
    )


def _jumped(a: float, b: float, at_a: float, at_b: float, target: float) -> PoreError:
    return fail(
        "E099",
        f"{target:g} is jumped over: at {(a + b) / 2:.6g} the function goes from {at_a:.4g} to {at_b:.4g} at once",
        hint="ask for what it takes beside the jump, or narrow the range to where it has none",
    )


def _out_of_reach(target: float, low: float, high: float, met: Sequence[float], looked: int = 0) -> PoreError:
    """`met` is what the function is at the lower end, at least, at most, and at the upper end; `looked` in how many
    places it was looked at, where no more is known of it."""
    at_low, least, most, at_high = met
    failed = f"was not met in {looked} places" if looked else "cannot be reached"
    return fail(
        "E094",
        f"{target:g} {failed}: from {low:g} to {high:g} it goes from {at_low:.4g} to {at_high:.4g}",
        hint=f"ask for something between {least:.4g} and {most:.4g}, or widen the range",
    )


@dataclass(slots=True)
class _Search:
    """A function less its target, with all that has been asked of it: (t, value, error)."""

    function: Callable[[float], Reduced]
    target: float
    seen: list[tuple[float, float, float]] = field(default_factory=list)

    def at(self, t: float) -> tuple[float, float]:
        found = self.function(t)
        if math.isnan(found.value):
            raise _no_number(t)
        self.seen.append((t, found.value - self.target, found.error))
        return found.value - self.target, found.error

    def sure(self, low: float, high: float, rising: bool) -> tuple[float, float]:
        """The narrowest range within `low..high` that the root certainly lies in: where the sign is beyond the error,
        it is known."""
        sign = 1 if rising else -1
        below = [t for t, f, e in self.seen if low <= t <= high and sign * f + e <= 0]
        above = [t for t, f, e in self.seen if low <= t <= high and sign * f - e >= 0]
        return max(below, default=low), min(above, default=high)

    def crossings(self) -> list[tuple[float, float]]:
        """Ranges between neighbours of which one is surely below the target and the other above."""
        signed = [(t, f > 0) for t, f, e in sorted(self.seen) if abs(f) > e]
        return [(a, b) for (a, up), (b, down) in pairwise(signed) if up != down]

    @property
    def turns(self) -> bool:
        """Whether the function was seen to rise and to fall, by more than its errors."""
        seen = sorted(self.seen)
        steps = [(g - f, e + d) for (_, f, e), (_, g, d) in pairwise(seen)]
        return any(s > e for s, e in steps) and any(s < -e for s, e in steps)


def root_of(
    function: Callable[[float], Reduced], target: float, low: float, high: float, one_way: bool = False
) -> Reduced:
    """The t in `low..high` with function(t) = target, by the Illinois form of the secant method within a bracket.

    `one_way` says that the function is proven to rise or to fall throughout; else it is looked at in places between the
    ends, and what is found where it turns is not told to be `sole`. The error is the distance to the nearest t on
    either side where the function is off its target by more than its own error. Errors: E094 for a target out of reach,
    which says what is in reach, E093 where the function is not a number, E098 where it is seen to pass its target more
    than once, E099 where it jumps over it.
    """
    search = _Search(function, target)
    a, b = low, high
    fa, ea = search.at(a)
    fb, eb = search.at(b)
    apart = fa * fb > 0 and abs(fa) > ea and abs(fb) > eb
    if not one_way:
        for i in range(1, _PROBES + 1):
            search.at(low + (high - low) * (i * _GOLDEN % 1))
    crossings = search.crossings()
    if len(crossings) > 1:
        raise _several([((p + q) / 2, True) for p, q in crossings], target, low, high, figures=2)
    if apart:
        met = [f + target for _, f, _ in sorted(search.seen)]
        looked = 0 if one_way else len(met)
        raise _out_of_reach(target, low, high, (met[0], min(met), max(met), met[-1]), looked)
    if crossings and not one_way:
        a, b = crossings[0]
        ((fa, ea),) = {(f, e) for t, f, e in search.seen if t == a}
        ((fb, eb),) = {(f, e) for t, f, e in search.seen if t == b}
    return _bracketed(search, (a, fa, ea), (b, fb, eb), NARROW * (high - low))


def _bracketed(
    search: _Search, at_a: tuple[float, float, float], at_b: tuple[float, float, float], narrow: float
) -> Reduced:
    (a, fa, ea), (b, fb, eb) = at_a, at_b
    low, high = a, b
    rising = fb > fa
    t, (ft, error) = (a, (fa, ea)) if abs(fa) < abs(fb) else (b, (fb, eb))
    side, known = 0, {a: (fa, ea), b: (fb, eb)}  # what the ends are, for the method halves what it goes by
    for _ in range(_STEPS):
        if fa * fb >= 0 or abs(ft) <= 0.1 * error or b - a <= narrow:
            break
        t = (fa * b - fb * a) / (fa - fb)
        if not a < t < b:
            t = (a + b) / 2
        ft, error = known[t] = search.at(t)
        if ft * fb > 0:
            b, fb = t, ft
            fa = fa / 2 if side == -1 else fa
            side = -1
        else:
            a, fa = t, ft
            fb = fb / 2 if side == 1 else fb
            side = 1
    _no_jump(search, (a, *known[a]), (b, *known[b]), narrow)
    sure_low, sure_high = _closed_in(search, t, rising, low, high)
    t = min(max(t, sure_low), sure_high)
    return Reduced(t, max(sure_high - t, t - sure_low) + narrow, not search.turns)


def _no_jump(
    search: _Search, at_a: tuple[float, float, float], at_b: tuple[float, float, float], narrow: float
) -> None:
    """Errors: E099 where a function is still off its target on both sides of the narrowest range."""
    (a, fa, ea), (b, fb, eb) = at_a, at_b
    span = max(f for _, f, _ in search.seen) - min(f for _, f, _ in search.seen)
    if fa * fb < 0 and b - a <= 4 * narrow and abs(fa) > ea and abs(fb) > eb and abs(fb - fa) > _JUMP * span:
        raise _jumped(a, b, fa + search.target, fb + search.target, search.target)


def _closed_in(search: _Search, t: float, rising: bool, low: float, high: float) -> tuple[float, float]:
    """The range that certainly holds the root, drawn in about t by steps to either side that double until they show."""
    for side, end in ((-1, low), (1, high)):
        step = _step(search, t, high - low)
        for _ in range(40):
            sure = search.sure(low, high, rising)[0 if side < 0 else 1]
            if abs(sure - t) <= 1.5 * step or t == end:
                break
            at = max(low, t - step) if side < 0 else min(high, t + step)
            search.at(at)
            step *= 2
    return search.sure(low, high, rising)


def _step(search: _Search, t: float, width: float) -> float:
    """How far from t the function should be off its target by 1.3 times its error, by the slope to its neighbours."""
    here = [(f, e) for u, f, e in search.seen if u == t]
    f, e = here[-1]
    near = sorted((abs(u - t), abs(g - f) / abs(u - t)) for u, g, _ in search.seen if abs(g - f) > e and u != t)
    if e == 0.0:
        return 1e-9 * width
    return max(1.3 * e / near[0][1], 1e-9 * width) if near and near[0][1] > 0 else width / 16
