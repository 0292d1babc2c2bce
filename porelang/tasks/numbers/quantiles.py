"""The offset that gives a porosity: a quantile of the field's values within a solid."""

from __future__ import annotations

import math

import numpy as np

from porelang.analysis.bounds import box_test
from porelang.analysis.enclose import EXACT
from porelang.data import Reduced
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.tasks.numbers.integrals import ACCURACY, MOST_VALUES, Values, more_strata, sampled
from porelang.tasks.numbers.region import Region, finer_throughout, region


def offset_for(field: Formula, phi: float, within: Formula, accuracy: float = ACCURACY) -> Reduced:
    """The offset d for which {root <= d} fills 1 - phi of a solid.

    The error is that of the offset; the porosity it gives is within `accuracy` (three standard deviations) of phi.
    Errors: E094 where the field is level in so much of the solid that no offset gives the porosity.
    """
    where = finer_throughout(within, region(within, "the region `within`"))
    m = 1
    while True:
        both, inside = sampled(field, within, where, m)
        values = np.sort(both[inside])
        d = float(np.quantile(values, 1 - phi))
        rest = np.where(inside, (both <= d) - (1 - phi), 0.0)
        error = 3 * math.sqrt(max(float(np.sum((rest[0] - rest[1]) ** 2)), 9.0)) / len(values)
        more = more_strata(m, error, accuracy, len(where.cells), MOST_VALUES)
        if more is None:
            break
        m = more
    below, upto = (float(np.searchsorted(values, d, side)) / len(values) for side in ("left", "right"))
    if upto - below > 2 * accuracy:
        raise fail(
            "E094",
            f"a porosity of {phi:g} cannot be reached: the field is {d:g} in {upto - below:.1%} of the region",
            hint=f"{_reach(1 - upto, 1 - below)}; or offset a field that varies everywhere",
        )
    low, high = _at(field, where, values, 1 - phi - error), _at(field, where, values, 1 - phi + error)
    return Reduced(d, max(high - d, d - low))


def _reach(least: float, most: float) -> str:
    """What porosities an offset just above and just below the level gives."""
    if least < 1e-3:
        return f"ask for more than {most:.1%}"
    less = f"ask for less than {least:.1%}"
    return less if most > 1 - 1e-3 else f"{less} or more than {most:.1%}"


def _at(field: Formula, where: Region, values: Values, share: float) -> float:
    """The quantile of values (sorted); beyond the first and the last sample, what the field is proven to keep to."""
    if 0 < share < 1:
        return float(np.quantile(values, share))
    lows, highs = box_test(field, EXACT)(where.cells, where.cells + where.size)
    return float(lows.min() if share <= 0 else highs.max())
