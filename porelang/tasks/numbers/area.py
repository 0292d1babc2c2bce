"""The area of a solid's surface, from where random lines along the axes cross it.

A surface element dA with unit normal n shows |n_i| dA to a line along axis i, and n.n = 1. So the area is the sum over
the axes of the integral, over lines, of |n_i| at their crossings (after Cauchy and Crofton, whose lines run anywhere):
weights between 0 and 1 that vanish where the line touches, so that no silhouette, rim or thin wall is special. Lines
are stratified in pairs, as points are for volumes; the error is four standard deviations.

Where the field jumps, its slope is not the normal of the surface, and all that is known is how much of it each axis
sees, A_i, the integral of |n_i| dA. The area lies between the length of the vector A, which it is where all of that
surface faces one way, and the sum of its components.
"""

from __future__ import annotations

import math

import numpy as np

from porelang.analysis.bounds import Points
from porelang.data import Reduced
from porelang.formula import Formula
from porelang.tasks.numbers.region import finer, region
from porelang.tasks.numbers.rods import Count, Counted, Crossings, Field, Rods, along

#: Four standard deviations, relative to the area; three times that where it would take many lines, as in lattices.
ACCURACY = 1e-3
#: Pairs of lines differ little or by a whole crossing: their spread has longer tails than that of points.
_DEVIATIONS = 4
_CHEAP, _MOST = 300_000, 1_500_000  # pieces of lines; beyond the most, the error says what was reached
_MOST_WORK = 200_000_000  # operations enclosed by linear forms: about 20 s of a processor


def area(solid: Formula, accuracy: float = ACCURACY) -> Reduced:
    """The area in mm^2, of walls of any thinness."""
    where = finer(solid, region(solid, "the solid", apart=True))
    if not len(where.undecided):
        return Reduced(0.0, 0.0)
    field = Field.of(solid, where)
    m = 1
    while True:
        found = [along(field, axis, m, _shown(axis)) for axis in range(3)]
        least, most = math.hypot(*(f.uncounted for f in found)), sum(f.uncounted for f in found)
        value, doubt = sum(f.total for f in found) + (least + most) / 2, (most - least) / 2
        doubt += 2 * sum(f.touches for f in found)  # a touch may be a wall, whose two sides count 1 each at most
        spread = _DEVIATIONS * math.sqrt(sum(f.variance for f in found))
        pieces = 6 * len(where.undecided)
        # what lines of this formula take is known when some have been followed
        work = sum(f.work for f in found)
        finest = max(1, int(min(math.sqrt(_MOST / pieces), m * math.sqrt(_MOST_WORK / max(work, 1)))))
        wanted = math.ceil(1.1 * m * math.sqrt(spread / (accuracy * value))) if value > 0 else finest
        enough = accuracy if pieces * wanted**2 <= _CHEAP else 3 * accuracy
        if spread <= enough * value or m >= finest:
            return Reduced(value, spread + doubt)
        m = min(max(m + 1, math.ceil(1.1 * m * math.sqrt(spread / (enough * value))) if value > 0 else finest), finest)


def _shown(axis: int) -> Count:
    """Of each crossing how much of the surface the line along an axis sees."""

    def count(rods: Rods, met: Crossings, starts: Points, random: np.random.Generator) -> Counted:
        shown = np.abs(rods.normals(met.points)[:, axis])
        return Counted(np.zeros(len(starts)), np.where(met.jumps, np.nan, shown))

    return count
