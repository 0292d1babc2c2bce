"""The solve: from a problem to displacements in equilibrium with its loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from porelang.diagnostics import fail
from porelang.fea import checks, doubts, iterate, loads, patches, rigid, supports
from porelang.fea.assemble import internal, lame, stiffness
from porelang.fea.elements import TET_1, TET_4, slopes_at, terms
from porelang.fea.error import estimate
from porelang.fea.nodes import Nodes, number
from porelang.fea.problem import Floats, Ints, Mask, Problem
from porelang.fea.solution import Reaction, Solution
from porelang.fea.stress import strains, stresses
from porelang.fea.surface import place, surface, vector
from porelang.progress import activity, checkpoint

#: Loads that drive a free motion with less than this of their size are taken to do no work on it.
_BALANCED = 1e-6


def solve(problem: Problem, tolerance: float = 1e-8) -> Solution:
    """Displacements, stresses and reactions of a part under its loads, with what is known of their error.

    `tolerance` is the residual of the iterations over the loads. Errors: E170 where a support or a load selects
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
        vertices, tets = checks.checked_mesh(problem.mesh.vertices, problem.mesh.tets)
        nodes = number(vertices, tets, 1 if problem.order == 1 else 2)
        checks.checked_volumes(vertices, tets, nodes.volumes)
        young, poisson, density = checks.materials(problem, vertices[tets].mean(axis=1))
        constants = lame(young, poisson)
        held = supports.hold_all(problem.supports, nodes)
        boundary = surface(nodes)
        applied = np.zeros(nodes.points.shape)
        for index, load in enumerate(problem.loads):
            applied += loads.forces(load, index, nodes, boundary, density)
        checks.loaded(problem, applied, held.displacement)
        parts = rigid.pieces(nodes)
        free = rigid.free(nodes, parts, held.components)
        components = _held_still(problem, nodes, parts, free, applied, held.components)
        checkpoint()
        matrix = stiffness(nodes, constants)
        matrix.hold(components)
        right = (applied - resistance(nodes, constants, held.displacement)) * ~components
        checkpoint()
    with activity("solving"):
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        modes = rigid.motions(vertices, (low + high) / 2, float(np.linalg.norm(high - low)) / 2)
        corners = components[: nodes.vertices]
        small = matrix
        if nodes.order == 2:
            small = stiffness(nodes, constants, order=1)
            small.hold(corners)
        precondition = iterate.aggregated(small, modes * ~corners[..., None])
        if nodes.order == 2:
            precondition = iterate.nested(matrix, nodes, components, precondition)
        outcome = iterate.gradients(matrix, right, precondition, tolerance)
    displacement = outcome.x + held.displacement
    for field in free.fields:
        displacement -= field * np.vdot(field, displacement)
    resisted = resistance(nodes, constants, displacement)
    rest = resisted - applied
    reactions = tuple(
        Reaction(support.name, *_resultant(rest, held.components, chosen, support.axes, nodes))
        for support, chosen in zip(problem.supports, held.nodes, strict=True)
    )
    with activity("recovering stresses"):
        region = patches.regions(nodes, young, poisson)
        where = patches.sites(nodes, region, young)
        stress = stresses(strains(nodes, displacement), young[:, None], poisson[:, None])
        fitted = patches.fit(nodes, where, stress)
        compliance = float(np.vdot(resisted, displacement))
        error = estimate(nodes, where, fitted, stress, young, poisson, compliance)
    at_sites = patches.means(where, nodes.volumes, np.stack([young, poisson], axis=1))
    found = Solution(
        problem, nodes, young, poisson, density, displacement, reactions, held.nodes, applied, compliance,
        outcome.residual, outcome.iterations, 3 * len(nodes.points) - int(components.sum()),
        where, at_sites[:, 0], at_sites[:, 1],
        fitted.factors[:, 0].copy(), stress.mean(axis=1), error, (),
    )  # fmt: skip
    return replace(found, doubts=doubts.of(found, parts.bodies))


def resistance(nodes: Nodes, constants: Floats, displacement: Floats) -> Floats:
    """The forces (k, 3) N with which stresses resist a displacement (k, 3) mm, from the stresses themselves."""
    out = np.zeros_like(displacement)
    rule = TET_1 if nodes.order == 1 else TET_4
    internal(nodes.elements, nodes.gradients, nodes.volumes, constants, terms(nodes.order)[0],
             slopes_at(rule, nodes.order), displacement, out)  # fmt: skip
    return out


def _held_still(
    problem: Problem, nodes: Nodes, parts: rigid.Pieces, free: rigid.Free, applied: Floats, held: Mask
) -> Mask:
    """The components to be held: also those that keep motions still which are free and not driven. Errors: E171,
    E178."""
    if not free.words:
        return held
    alone = rigid.unheld(nodes, parts, held)
    if alone:
        raise fail(
            "E178",
            f"the mesh is in {parts.bodies} pieces that do not touch, and {alone}",
            hint="keep the largest piece alone, or support each of them",
        )
    if not problem.balanced:
        raise fail(
            "E171",
            f"nothing holds the part against {_listed(free.words)}",
            hint="add a support there; or say `balanced=true` if the loads do not drive it, as between frictionless "
            "platens",
        )
    works = np.einsum("rkd,kd->r", free.fields, applied) / np.abs(free.fields).max(axis=(1, 2))
    if (np.abs(works) > _BALANCED * np.abs(applied).sum()).any():
        centre = (nodes.points.min(axis=0) + nodes.points.max(axis=0)) / 2
        force, moment = applied.sum(axis=0), np.cross(nodes.points - centre, applied).sum(axis=0)
        raise fail(
            "E171",
            f"the loads drive a motion that nothing holds ({_listed(free.words)}): they add up to "
            f"{vector(force)} N and {vector(moment)} N mm about {place(centre)}",
            hint="add a support against it, or a load that balances it",
        )
    still = held.copy()
    still.reshape(-1)[supports.hold_still(free.fields, nodes.vertices)] = True
    return still


def _listed(words: tuple[str, ...]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def _resultant(
    rest: Floats, held: Mask, chosen: Ints, axes: tuple[bool, bool, bool], nodes: Nodes
) -> tuple[Floats, Floats]:
    """The force and the moment about the origin of what a support holds with."""
    forces = rest[chosen] * held[chosen] * np.asarray(axes)
    return forces.sum(axis=0), np.cross(nodes.points[chosen], forces).sum(axis=0)
