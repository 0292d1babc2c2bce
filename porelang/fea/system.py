"""A problem as the system of equations that it is: nodes, the stiffness between them, what is held, what loads them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.diagnostics import fail
from porelang.fea import balance, checks, loads, rigid, supports
from porelang.fea.assemble import Blocks, internal, lame, stiffness
from porelang.fea.elements import TET_1, TET_4, slopes_at, terms
from porelang.fea.loads import Applied
from porelang.fea.nodes import Nodes, number
from porelang.fea.problem import Floats, Mask, Problem
from porelang.fea.supports import Held
from porelang.fea.surface import Surface, surface
from porelang.progress import checkpoint


@dataclass(frozen=True, slots=True)
class System:
    """A problem assembled. `young`, `poisson`, `density` (m,) are of its tetrahedra, `constants` (m, 2) Lame's.

    `still` (k, 3) are the components of nodes that are held: by supports (`held`), and as many more as keep those
    motions still which are `free` and which loads do not drive. `matrix` has them taken out, `forces` (k, 3) N are
    those of all `loads`, and those that take what is left of these where they are to balance (`rest`).
    """

    nodes: Nodes
    boundary: Surface
    young: Floats
    poisson: Floats
    density: Floats
    constants: Floats
    held: Held
    loads: tuple[Applied, ...]
    forces: Floats
    bodies: int
    free: rigid.Free
    rest: balance.Rest | None
    still: Mask
    matrix: Blocks

    def resistance(self, displacement: Floats) -> Floats:
        """The forces (k, 3) N with which stresses resist a displacement (k, 3) mm, from the stresses themselves."""
        out = np.zeros_like(displacement)
        nodes, order = self.nodes, self.nodes.order
        internal(nodes.elements, nodes.gradients, nodes.volumes, self.constants, terms(order)[0],
                 slopes_at(TET_1 if order == 1 else TET_4, order), displacement, out)  # fmt: skip
        return out


def assembled(problem: Problem) -> System:
    """The system of a problem. Errors: E170-E175, E177, E178."""
    vertices, tets = checks.checked_mesh(problem.mesh.vertices, problem.mesh.tets)
    nodes = number(vertices, tets, 1 if problem.order == 1 else 2)
    checks.checked_volumes(vertices, tets, nodes.volumes)
    young, poisson, density = checks.materials(problem, vertices[tets].mean(axis=1))
    constants = lame(young, poisson)
    held = supports.hold_all(problem.supports, nodes)
    boundary = surface(nodes)
    acting = tuple(loads.applied(load, i, nodes, boundary, density) for i, load in enumerate(problem.loads))
    checks.loaded(problem, acting, held, nodes.points)
    forces = np.sum([load.forces for load in acting], axis=0) if acting else np.zeros(nodes.points.shape)
    pieces = rigid.pieces(nodes)
    free = rigid.free(nodes, pieces, held.components)
    _held_enough(problem, nodes, pieces, free, held.components)
    rest = balance.rest_of(problem.loads, acting, nodes, free) if free.words else None
    if rest is not None:
        forces = forces + rest.forces
    still = held.components.copy()
    if free.words:
        still.reshape(-1)[supports.hold_still(free.fields, nodes.vertices)] = True
    checkpoint()
    matrix = stiffness(nodes, constants)
    matrix.hold(still)
    return System(
        nodes=nodes, boundary=boundary, young=young, poisson=poisson, density=density, constants=constants, held=held,
        loads=acting, forces=forces, bodies=pieces.bodies, free=free, rest=rest, still=still, matrix=matrix,
    )  # fmt: skip


def _held_enough(problem: Problem, nodes: Nodes, pieces: rigid.Pieces, free: rigid.Free, held: Mask) -> None:
    """Errors: E171 for free motions, unless loads are said not to drive them; E178."""
    if not free.words:
        return
    alone = rigid.unheld(nodes, pieces, held)
    if alone:
        raise fail(
            "E178",
            f"the mesh is in {pieces.bodies} pieces that do not touch, and {alone}",
            hint="keep the largest piece alone, or support each of them",
        )
    if not problem.balanced:
        raise fail(
            "E171",
            f"nothing holds the part against {balance.listed(free.words)}",
            hint="add a support there; or say `balanced=true` if the loads do not drive it, as between frictionless "
            "platens",
        )
