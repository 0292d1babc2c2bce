"""The root of a function that rises or falls throughout a range, found from few evaluations."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from porelang.data import Reduced
from porelang.diagnostics import PoreError, fail

_STEPS = 60
_PROBES = 3
#: The narrowest range of t that is looked at, relative to the whole.
_NARROW = 1e-12


@dataclass(slots=True)
class _Search:
    """A function less its target, with all that has been asked of it: (t, value, error)."""

    function: Callable[[float], Reduced]
    target: float
    seen: list[tuple[float, float, float]] = field(default_factory=list)

    def at(self, t: float) -> tuple[float, float]:
        found = self.function(t)
        if math.isnan(found.value):
            raise fail(
                "E093",
                f"the function of `solve` is not a number at {t:g}",
                hint="narrow the range to where it is one: a root, a logarithm or a power of a negative number is none",
            )
        self.seen.append((t, found.value - self.target, found.error))
        return found.value - self.target, found.error

    def sure(self, low: float, high: float, rising: bool) -> tuple[float, float]:
        """The narrowest range that the root certainly lies in: where the sign is beyond the error, it is known."""
        sign = 1 if rising else -1
        below = [t for t, f, e in self.seen if sign * f + e <= 0]
        above = [t for t, f, e in self.seen if sign * f - e >= 0]
        return max(below, default=low), min(above, default=high)


def root_of(function: Callable[[float], Reduced], target: float, low: float, high: float) -> Reduced:
    """The t in `low..high` with function(t) = target, by the Illinois form of the secant method within a bracket.

    The error is the distance to the nearest t on either side where the function is off its target by more than its own
    error: it holds for every function that rises or falls throughout, however steep or flat it is near the root.
    Errors: E095 for an empty range, E094 for a target out of reach, which says what is in reach, E093 where the target
    or the function is not a number.
    """
    if math.isnan(target):
        raise fail(
            "E093", "the target of `solve` is not a number", hint="look for a root or logarithm of a negative one"
        )
    if not low < high:
        raise fail("E095", f"`solve` looks in an empty range: {low:g}..{high:g}", hint="the lower end comes first")
    search = _Search(function, target)
    a, b = low, high
    fa, ea = search.at(a)
    fb, eb = search.at(b)
    if fa * fb > 0 and abs(fa) > ea and abs(fb) > eb:
        raise _out_of_reach(search, low, high)
    rising = fb > fa
    t, (ft, error) = (a, (fa, ea)) if abs(fa) < abs(fb) else (b, (fb, eb))
    side = 0
    for _ in range(_STEPS):
        if fa * fb >= 0 or abs(ft) <= 0.1 * error or b - a <= _NARROW * (high - low):
            break
        t = (fa * b - fb * a) / (fa - fb)
        if not a < t < b:
            t = (a + b) / 2
        ft, error = search.at(t)
        if ft * fb > 0:
            b, fb = t, ft
            fa = fa / 2 if side == -1 else fa
            side = -1
        else:
            a, fa = t, ft
            fb = fb / 2 if side == 1 else fb
            side = 1
    sure_low, sure_high = _closed_in(search, t, rising, low, high)
    t = min(max(t, sure_low), sure_high)
    return Reduced(t, max(sure_high - t, t - sure_low) + _NARROW * (high - low))


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


def _out_of_reach(search: _Search, low: float, high: float) -> PoreError:
    """What the function can be, from its ends and a few places between."""
    for i in range(1, _PROBES + 1):
        search.at(low + (high - low) * i / (_PROBES + 1))
    target = search.target
    seen = sorted(search.seen)
    least, most = min(f for _, f, _ in seen) + target, max(f for _, f, _ in seen) + target
    at_low, at_high = seen[0][1] + target, seen[-1][1] + target
    if least < target < most:
        i = next(i for i in range(len(seen) - 1) if seen[i][1] * seen[i + 1][1] <= 0)
        return fail(
            "E094",
            f"`solve` needs a function that rises or falls throughout {low:g}..{high:g}: this one does both",
            hint=f"narrow the range to {seen[i][0]:.4g}..{seen[i + 1][0]:.4g}, where it passes {target:g}",
        )
    return fail(
        "E094",
        f"{target:g} cannot be reached: from {low:g} to {high:g} it goes from {at_low:.4g} to {at_high:.4g}",
        hint=f"ask for something between {least:.4g} and {most:.4g}, or widen the range",
    )
