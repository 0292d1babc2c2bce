"""The root of a function that rises or falls throughout a range, found from few evaluations."""

from __future__ import annotations

from collections.abc import Callable

from porelang.diagnostics import fail
from porelang.reduce.integrals import Reduced

_STEPS = 60


def root_of(function: Callable[[float], Reduced], target: float, low: float, high: float) -> Reduced:
    """The t in `low..high` with function(t) = target, by the Illinois form of the secant method within a bracket.

    Errors: E095 for an empty range, E094 for a target out of reach, which says what is in reach.
    """
    if not low < high:
        raise fail("E095", f"`solve` looks in an empty range: {low:g}..{high:g}", hint="the lower end comes first")
    a, b = low, high
    at_a, at_b = function(a), function(b)
    fa, fb = at_a.value - target, at_b.value - target
    if fa * fb > 0 and min(abs(fa), abs(fb)) > max(at_a.error, at_b.error):
        least, most = sorted((at_a.value, at_b.value))
        raise fail(
            "E094",
            f"{target:g} cannot be reached: from {low:g} to {high:g} it goes from {at_a.value:.4g} to {at_b.value:.4g}",
            hint=f"ask for something between {least:.4g} and {most:.4g}, or widen the range",
        )
    if fa * fb > 0:
        return Reduced(a, 0.0) if abs(fa) < abs(fb) else Reduced(b, 0.0)
    slope = (fb - fa) / (b - a) or 1.0
    t, error = a, at_a.error
    side = 0
    for _ in range(_STEPS):
        t = (fa * b - fb * a) / (fa - fb) if fa != fb else (a + b) / 2
        if not min(a, b) <= t <= max(a, b):
            t = (a + b) / 2
        now = function(t)
        ft, error = now.value - target, now.error
        if ft == 0 or abs(b - a) <= 1e-9 * (high - low) or abs(ft) <= 0.02 * error:
            break
        if ft * fb > 0:
            b, fb = t, ft
            fa = fa / 2 if side == -1 else fa
            side = -1
        else:
            a, fa = t, ft
            fb = fb / 2 if side == 1 else fb
            side = 1
    return Reduced(t, abs(error / slope) + 1e-9 * (high - low))
