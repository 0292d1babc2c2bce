"""Linear elasticity on tetrahedra: from loads and supports to displacements and stresses, with an estimate of the error.

Pure functions of arrays: nothing here knows of programs or fields.
"""

from __future__ import annotations

from porelang.fea.problem import BodyForce, Force, Load, Moment, Pressure, Problem, Support, Weight, Where
from porelang.fea.solution import Reaction, Solution
from porelang.fea.solve import solve

__all__ = [
    "BodyForce", "Force", "Load", "Moment", "Pressure", "Problem", "Reaction", "Solution", "Support", "Weight",
    "Where", "solve",
]  # fmt: skip
