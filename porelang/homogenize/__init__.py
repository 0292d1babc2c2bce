"""What a lattice does as a material: a period of a design as voxels, and numbers as a report.

The work on arrays is in `porelang.unitcell`.
"""

from __future__ import annotations

from porelang.homogenize.found import Homogenized, Level
from porelang.homogenize.sweep import Swept, sweep
from porelang.homogenize.whole import RESOLUTION, homogenize, material

__all__ = ["RESOLUTION", "Homogenized", "Level", "Swept", "homogenize", "material", "sweep"]
