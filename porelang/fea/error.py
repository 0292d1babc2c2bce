"""What a solution is worth: the estimate of Zienkiewicz and Zhu.

The recovered stresses are nearer to the truth than those of the elements; the energy of their difference stands for the
error's (1987, 1992). It is an estimate, no bound: `effectivity` on problems with known solutions is in
docs/decisions/0016.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.fea.assemble import over_rows
from porelang.fea.elements import tet_rule
from porelang.fea.nodes import Nodes
from porelang.fea.patches import Fitted, Sites, misfit
from porelang.fea.problem import Floats


@dataclass(frozen=True, slots=True)
class Error:
    """`relative` is the error's energy norm over the solution's: stresses are wrong by about that share in the mean
    (root of squares), stiffness
    and compliance by its square. `of_tets` (m,) are its parts, whose squares sum to `relative` squared.
    """

    relative: float
    of_tets: Floats


def estimate(
    nodes: Nodes, where: Sites, fitted: Fitted, stress: Floats, young: Floats, poisson: Floats, energy: float
) -> Error:
    """The estimate for stresses (m, 4 or 1, 6) of tetrahedra; `energy` is twice the strain energy of the solution."""
    rule, weights = tet_rule(2 if nodes.order == 1 else 4)
    squares = np.empty(len(nodes.elements))
    centres = nodes.points[where.vertex]
    over_rows(
        len(squares),
        lambda r: misfit(
            r[0],
            r[1],
            where.corners,
            centres,
            fitted.scale,
            fitted.factors,
            nodes.points,
            nodes.elements,
            stress,
            rule,
            weights,
            young,
            poisson,
            nodes.volumes,
            squares,
        ),
    )
    whole = energy + squares.sum()
    if not whole > 0:
        return Error(0.0, np.zeros(len(squares)))
    return Error(float(np.sqrt(squares.sum() / whole)), np.sqrt(squares / whole))
