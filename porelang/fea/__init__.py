"""Linear elasticity on tetrahedra: from loads and supports to displacements and stresses, with an estimate of the
error.

Pure functions of arrays: nothing here knows of programs or fields.
"""

from __future__ import annotations

from porelang.fea.error import Error
from porelang.fea.problem import (
    BodyForce,
    Facing,
    Force,
    Load,
    Moment,
    OnSurface,
    Pressure,
    Problem,
    Support,
    Weight,
    Where,
)
from porelang.fea.refine import refined_sizes
from porelang.fea.resultants import Resultant
from porelang.fea.solution import Solution
from porelang.fea.solve import solve
from porelang.fea.write import write

__all__ = [
    "BodyForce", "Error", "Facing", "Force", "Load", "Moment", "OnSurface", "Pressure", "Problem", "Resultant",
    "Solution", "Support", "Weight", "Where", "refined_sizes", "solve", "write",
]  # fmt: skip
