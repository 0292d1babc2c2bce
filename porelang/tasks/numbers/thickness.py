"""How thick the thinnest walls of a solid are, and where.

From points all over its surface a line goes inwards along the normal to where it leaves the solid; a wall is where it
meets a side that is parallel, so that edges, which run out to nothing, are none. The thinnest is what at least a
hundredth of the points stand on (`porelang.walls`). Two samplings, one after the other, are looked at: the error is
what they differ by, and how much the walls differ that count as the thinnest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.solid import Solid
from porelang.tasks.numbers.region import region
from porelang.walls import PARALLEL, SCAN, alike, on_surface

#: Samplings of the surface.
LOOKS = 2
#: What crossings along a line are found to, of the thickness.
CLOSE = 1e-6


@dataclass(frozen=True, slots=True)
class Wall:
    """The thinnest walls (mm), and a place in the middle of one (3,)."""

    thickness: Reduced
    at: NDArray[np.float64]


def min_wall(solid: Formula) -> Reduced:
    """The thickness of the thinnest walls of a solid, in mm. Errors: those of `thinnest_wall`."""
    return thinnest_wall(solid).thickness


def thinnest_wall(solid: Formula) -> Wall:
    """The thinnest walls of a solid, and where. Errors: E091 to E093 of a region, E139 where it has no walls."""
    box = region(solid, "the solid").box
    part = Solid(solid, (box.lo, box.hi))
    reach = float((part.hi - part.lo).max())
    found: list[NDArray[np.float64]] = []
    places: list[NDArray[np.float64]] = []
    for seed in range(LOOKS):
        at = on_surface(part, seed)
        thick, facing, _ = part.walls(at, reach, SCAN, False)
        some = facing < PARALLEL
        at, thick = at[some], thick[some]
        group = alike(np.sort(thick), len(facing))
        if group is None:
            raise fail("E139", "this solid has no walls that could be measured",
                       hint="a wall has two parallel sides, a hundredth of the surface at least")  # fmt: skip
        found.append(group)
        middle = int(np.abs(thick - np.median(group)).argmin())
        _, slope = part.slope(at[middle : middle + 1])
        places.append(at[middle] - slope[0] / np.linalg.norm(slope[0]) * thick[middle] / 2)
    medians = [float(np.median(group)) for group in found]
    thickness = min(medians)
    first = found[medians.index(thickness)]
    spread = max(thickness - float(first[0]), float(first[-1]) - thickness)
    error = max(abs(medians[0] - medians[1]), spread, CLOSE * thickness)
    return Wall(Reduced(thickness, error), places[medians.index(thickness)])
