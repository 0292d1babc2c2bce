"""The conformance law: how far a backend may be from the exact value, propagated through the graph, point by point.

The bound is the enclosure of the graph over single points, each operation widened by its tolerance: a jump within the
error of its argument counts with both sides, a NaN is allowed only where some value within the error makes one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F32, Precision, at_points, enclose
from porelang.backends.numpy import NumpyField
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ops import kind


@dataclass(frozen=True, slots=True)
class Verdict:
    """How values compare with the law: which break it, and how much of the bound each uses (1 is all of it)."""

    broken: NDArray[np.bool_]
    use: NDArray[np.float64]
    reference: NDArray[np.float64]
    allowed: Interval

    @property
    def worst(self) -> float:
        """The largest use of the bound."""
        return float(self.use.max(initial=0.0))


def allowed(formula: Formula, points: NDArray[np.float64], precision: Precision) -> Interval:
    """What a backend of this precision may return at points (n, 3)."""
    r = enclose(formula, at_points(points, precision), precision)[0].range
    n = len(points)
    return Interval(np.broadcast_to(r.lo, n), np.broadcast_to(r.hi, n), np.broadcast_to(r.nan, n))


def judge(
    formula: Formula,
    points: NDArray[np.float64],
    values: NDArray[np.generic],
    precision: Precision = F32,
) -> Verdict:
    """Values that a backend returned at points (n, 3), against the float64 reference and the propagated bound."""
    reference = NumpyField(formula, "f64").at(points).astype(np.float64)
    bound = allowed(formula, points, precision)
    got = values.astype(np.float64)
    nan = np.isnan(got)
    with np.errstate(all="ignore"):
        inside = (bound.lo <= got) & (got <= bound.hi)
        broken = np.where(nan, ~bound.nan, ~inside)
        room = np.where(got > reference, bound.hi - reference, reference - bound.lo)
        use = np.abs(got - reference) / room
        use = np.where(nan | np.isnan(reference) | (got == reference) | np.isinf(room), 0.0, use)
        use = np.where(np.isnan(use), np.inf, use)
    if kind(formula.root) == "bool":
        use = np.where(broken, np.inf, 0.0)
    return Verdict(broken, use, reference, bound)
