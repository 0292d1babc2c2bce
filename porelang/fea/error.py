"""What a solution is worth: the estimate of Zienkiewicz and Zhu, and the sizes that a finer mesh should have.

The recovered stresses are nearer to the truth than those of the elements; the energy of their difference stands for the
error's (1987, 1992). It is an estimate, no bound: `effectivity` on problems with known solutions is in
docs/decisions/0016.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from porelang.diagnostics import fail
from porelang.fea.assemble import over_rows
from porelang.fea.elements import tet_rule
from porelang.fea.nodes import Nodes
from porelang.fea.patches import Fitted, Sites, misfit
from porelang.fea.problem import Floats

if TYPE_CHECKING:
    from porelang.fea.solution import Solution


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


def refined_sizes(solution: Solution, target: float, least: float = 0.25, most: float = 2.0) -> Floats:
    """The size (n,) mm that elements should have at the mesh's vertices so that the relative error becomes `target`.

    The mesh with the fewest elements has sizes h (c / error_of_tet)^(2 / (2 p + 3)), p the order (P. Diez and A.
    Huerta, A unified approach to
    remeshing strategies for finite element h-adaptivity, Comput. Methods Appl. Mech. Engng 176, 1999). h is the edge
    of the regular tetrahedron of the same volume. A step
    changes sizes by no more than `least` to `most`: where the error is singular the rate is not that of smooth
    solutions, and a second step follows. Errors: E173 for
    a target that is not between 0 and 1.
    """
    if not 0 < target < 1:
        raise fail("E173", f"{target!r} is no error to aim at", hint="give a share: 0.05 for 5 %")
    nodes, error = solution.nodes, solution.error.of_tets
    power = 2 / (2 * nodes.order + 3)
    floor = np.maximum(error, 1e-6 * max(float(error.max()), 1e-300))
    shares = floor**2 * floor ** (-2 * nodes.order * power)
    scale = (target**2 / shares.sum()) ** (1 / (2 * nodes.order))
    ratio = np.clip(scale * floor**-power, least, most)
    size = np.log((6 * np.sqrt(2) * nodes.volumes) ** (1 / 3) * ratio)
    weights = np.bincount(nodes.corners.ravel(), np.repeat(nodes.volumes, 4), nodes.vertices)
    sums = np.bincount(nodes.corners.ravel(), np.repeat(nodes.volumes * size, 4), nodes.vertices)
    return np.exp(sums / weights)
