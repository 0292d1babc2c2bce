"""The sizes that a finer mesh should have, from the estimate of the error: one step of refinement."""

from __future__ import annotations

import numpy as np

from porelang.diagnostics import fail
from porelang.fea.problem import Floats
from porelang.fea.solution import Solution


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
