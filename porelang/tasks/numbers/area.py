"""The area of a solid's surface, from where random lines along the axes cross it.

A surface element dA with unit normal n shows |n_i| dA to a line along axis i, and n.n = 1. So the area is the sum over
the axes of the integral, over lines, of |n_i| at their crossings (after Cauchy and Crofton, whose lines run anywhere):
weights between 0 and 1 that vanish where the line touches, so that no silhouette, rim or thin wall is special. Lines
are stratified in pairs, as points are for volumes; the error is four standard deviations.
"""

from __future__ import annotations

import math

import numpy as np

from porelang.analysis.bounds import Points
from porelang.data import Reduced
from porelang.formula import Formula
from porelang.tasks.numbers.region import finer, region
from porelang.tasks.numbers.rods import Count, Crossings, Rods, Values, along

#: Four standard deviations, relative to the area; three times that where it would take many lines, as in lattices.
ACCURACY = 1e-3
#: Pairs of lines differ little or by a whole crossing: their spread has longer tails than that of points.
_DEVIATIONS = 4
_CHEAP, _MOST = 300_000, 1_500_000  # pieces of lines; beyond the most, the error says what was reached
#: Where the field jumps the surface has no normal: |n_x| + |n_y| + |n_z| lies between 1 and sqrt(3), and the
#: crossings along all axes together count between 1 / sqrt(3) and 1 each.
_NO_NORMAL, _DOUBT = (1 + 1 / math.sqrt(3)) / 2, (1 - 1 / math.sqrt(3)) / 2


def area(solid: Formula, accuracy: float = ACCURACY) -> Reduced:
    """The area in mm^2, of walls of any thinness."""
    where = finer(solid, region(solid, "the solid", apart=True))
    if not len(where.undecided):
        return Reduced(0.0, 0.0)
    rods = Rods(solid)
    sure = rods.rising(where.undecided, where.size)
    m = 1
    while True:
        found = [along(rods, where, sure, axis, m, _shown(rods, axis)) for axis in range(3)]
        without = sum(f.uncounted for f in found)
        value, doubt = sum(f.total for f in found) + _NO_NORMAL * without, _DOUBT * without
        spread = _DEVIATIONS * math.sqrt(sum(f.variance for f in found))
        pieces = 6 * len(where.undecided)
        most = max(1, int(math.sqrt(_MOST / pieces)))
        wanted = math.ceil(1.1 * m * math.sqrt(spread / (accuracy * value))) if value > 0 else most
        enough = accuracy if pieces * wanted**2 <= _CHEAP else 3 * accuracy
        if spread <= enough * value or m >= most:
            return Reduced(value, spread + doubt)
        m = min(max(m + 1, math.ceil(1.1 * m * math.sqrt(spread / (enough * value))) if value > 0 else most), most)


def _shown(rods: Rods, axis: int) -> Count:
    """Of each crossing how much of the surface the line along an axis sees."""

    def count(met: Crossings, starts: Points) -> tuple[Values, Values]:
        return np.zeros(len(starts)), np.abs(rods.normals(met.points)[:, axis])

    return count
