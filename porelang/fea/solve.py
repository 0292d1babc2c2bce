"""The solve: from a problem to displacements in equilibrium with its loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.fea import doubts, patches
from porelang.fea.equilibrium import Equilibrium, equilibrium
from porelang.fea.error import estimate
from porelang.fea.narrow import narrow
from porelang.fea.problem import Problem
from porelang.fea.resultants import of_load, of_supports
from porelang.fea.solution import Solution
from porelang.fea.stress import strains, stresses
from porelang.fea.system import System, assembled
from porelang.progress import activity


def solve(problem: Problem, tolerance: float = 1e-8) -> Solution:
    """Displacements, stresses and reactions of a part under its loads, with what is known of their error.

    `tolerance` is what the iterations may leave of the forces that act, loads and what moved supports press with; the
    reactions answer the loads to that. Errors: E170 where a support or a load selects
    nothing, E171 for a motion that
    no support holds, E172 for materials that there are not, E173 where nothing loads the part, E174 for fields that
    give no numbers, E175 for a mesh
    that is none, E176 where the iterations do not converge, E177 for supports that contradict each other, E178 for a
    piece
    that is held nowhere, CancelledError.

    >>> import numpy as np
    >>> from types import SimpleNamespace
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> mesh = SimpleNamespace(vertices=corners, tets=np.array([[0, 1, 2, 3]], np.int32))
    >>> from porelang.fea import Problem, Support, Weight, solve
    >>> held = Support(lambda p: p[:, 2] < 1e-9)
    >>> found = solve(Problem(mesh, young=2000.0, poisson=0.3, supports=(held,), loads=(Weight((0, 0, -9810)),)))
    >>> bool(found.displacement[3, 2] < 0)
    True
    """
    with activity("assembling"):
        system = assembled(problem)
    with activity("solving"):
        found = equilibrium(system, tolerance)
    with activity("recovering stresses"):
        solution = _recovered(problem, system, found)
        return replace(solution, doubts=doubts.of(solution, system, tolerance))


def _too_narrow(system: System, found: Equilibrium) -> float:
    """By which share displacements and compliance may be too small for loads on less than a face of an element."""
    return sum(load.work for load in narrow(system)) / max(abs(found.compliance), 1e-300)


def _recovered(problem: Problem, system: System, found: Equilibrium) -> Solution:
    """The stresses of a displacement, their error, and what supports and loads come to."""
    nodes, young, poisson = system.nodes, system.young, system.poisson
    where = patches.sites(nodes, patches.regions(nodes, young, poisson), young)
    stress = stresses(strains(nodes, found.displacement), young[:, None], poisson[:, None])
    fitted = patches.fit(nodes, where, stress)
    at_sites = patches.means(where, nodes.volumes, np.stack([young, poisson], axis=1))
    names = tuple(support.name for support in problem.supports)
    return Solution(
        problem=problem,
        nodes=nodes,
        young=young,
        poisson=poisson,
        density=system.density,
        displacement=found.displacement,
        reactions=of_supports(names, system.held, found.rest, nodes),
        loads=tuple(
            of_load(load.name, acting.forces, acting.on, nodes)
            for load, acting in zip(problem.loads, system.loads, strict=True)
        ),
        held=system.held.nodes,
        applied=system.forces,
        compliance=found.compliance,
        residual=found.residual,
        unsure=found.unsure + (0.0 if system.rest is None else system.rest.share) + _too_narrow(system, found),
        iterations=found.iterations,
        unknowns=3 * len(nodes.points) - int(system.still.sum()),
        sites=where,
        site_young=at_sites[:, 0],
        site_poisson=at_sites[:, 1],
        stress=fitted.factors[:, 0].copy(),
        stress_of_tets=stress.mean(axis=1),
        error=estimate(nodes, where, fitted, stress, young, poisson, found.compliance),
        doubts=(),
    )
