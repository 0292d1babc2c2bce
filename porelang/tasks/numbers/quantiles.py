"""The offset that gives a porosity: a quantile of the field's values within a solid.

A porosity near 0 or 1 is one of the few least or greatest values: of a shell of a ten-thousandth of a part, samples
anywhere hardly hit any. They are drawn again where enclosures let such values be, which is near a surface.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from porelang.analysis.bounds import box_test
from porelang.analysis.enclose import EXACT
from porelang.data import Reduced
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.ir import node
from porelang.tasks.numbers.integrals import ACCURACY, MOST_VALUES, Values, envelope, more_strata, sampled
from porelang.tasks.numbers.region import Region, finer_throughout, halves, region

#: What is known of a share, relative to itself, where few values decide it.
_RELATIVE = 0.01
_ENOUGH = 30_000  # cells in which there are such
_LEAST = 1e-6  # of a box: the side of a cell
_FEW = 100  # values that decide, to begin with


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
    found = Reduced(d, max(high - d, d - low))
    share = min(phi, 1 - phi)
    if error <= _RELATIVE * share:
        return found
    sides = (field, high) if phi > 0.5 else (field.with_roots(node("neg", field.root)), -low)
    closer = _extreme(*sides, share, within, where)
    if closer is None or closer.error >= found.error:
        return found
    return closer if phi > 0.5 else replace(closer, value=-closer.value)


def _extreme(field: Formula, most: float, share: float, within: Formula, where: Region) -> Reduced | None:
    """The value below which a field is in a small share of a solid, and which is `most` for certain, from samples in
    the cells where it can be so small; None if there are none."""
    low, size = where.cells, where.size
    while len(low):
        low = low[
            (box_test(field, EXACT)(low, low + size)[0] <= most) & (box_test(within, EXACT)(low, low + size)[0] < 0)
        ]
        if len(low) > _ENOUGH or size.min() < _LEAST * max(where.box.size):
            break
        low, size = halves(low, size), size / 2
    if not len(low):
        return None
    whole = envelope(within, ACCURACY / 2)[1]
    part = share * whole.value / (len(low) * float(np.prod(size)))
    near = replace(where, size=size, inside=low, undecided=low[:0])
    most_strata = max(1, int((MOST_VALUES / 2 / len(low)) ** (1 / 3)))
    m = min(most_strata, math.ceil((_FEW / (2 * len(low) * part)) ** (1 / 3)))
    while True:
        both, inside = sampled(field, within, near, m)
        values = np.where(inside, both, np.inf)
        few = np.sort(values[values <= most])
        place = part * values.size
        if not 1 <= place < len(few):
            return None
        d = float(few[int(place)])
        rest = (values <= d) - part
        error = 3 * math.sqrt(max(float(np.sum((rest[0] - rest[1]) ** 2)), 9.0)) / values.size
        more = more_strata(m, error, _RELATIVE * part, len(low), MOST_VALUES)
        if more is None:
            break
        m = more
    error += part * whole.error / whole.value
    least = float(box_test(field, EXACT)(low, low + size)[0].min())
    start, end = math.floor((part - error) * values.size) - 1, math.ceil((part + error) * values.size) + 1
    first = float(few[start]) if start >= 0 else least
    last = float(few[end]) if end < len(few) else most
    return Reduced(d, max(last - d, d - first))


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
