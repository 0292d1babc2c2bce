"""Equilibrium: the displacement at which stresses answer all loads, as nearly as is asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.fea import iterate, rigid
from porelang.fea.assemble import Blocks, stiffness
from porelang.fea.means import weighed
from porelang.fea.nodes import EDGES
from porelang.fea.problem import Floats
from porelang.fea.surface import place
from porelang.fea.system import System

#: So often iterations go on with a smaller aim, where forces turn out smaller than those that displacements call up.
_ROUNDS = 4
#: A support's force counts as no less than this share of the forces on its nodes, which may answer each other.
_LEAST = 1e-3
#: Where rounding ends iterations early, a displacement whose own error is less than this in energy stands, if its work
#: is sure to that share, and forces balance to that one; it is said. Of what is slender forces in elements are larger
#: than those that act by the square of its ratio, and so is their rounding.
_STANDS, _SURE, _BALANCES = 1e-6, 1e-2, 1e-3
#: Moduli that differ by more, Poisson's ratios above, tetrahedra as much flatter than long: what a system that does
#: not converge is said to suffer from.
_APART, _FULL, _FLAT = 1e4, 0.49, 0.02


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """`displacement` and `rest` (k, 3), which is what supports hold with; `residual` what iterations left, over the
    forces that act; `compliance` N mm twice the strain energy. `unsure` is by which share that, and displacements, may
    be off for the residual."""

    displacement: Floats
    rest: Floats
    compliance: float
    residual: float
    iterations: int
    unsure: float


def equilibrium(system: System, tolerance: float) -> Equilibrium:
    """Solve until what is left of forces on free nodes is `tolerance` of those that act, and so are its resultants: the
    reactions answer the loads to that.

    Those that act are loads, and where supports move the part, reactions: displacements call up forces in the elements
    next to them that are larger by orders. Errors: E176, CancelledError.
    """
    right = (system.forces - system.resistance(system.held.displacement)) * ~system.still
    precondition = _preconditioner(system)
    aim = tolerance * float(np.linalg.norm(right))
    outcome = iterate.gradients(system.matrix, right, precondition, aim)
    iterations = outcome.iterations
    weights = weighed(system.nodes, system.free.fields)
    found = _seen(system, weights, outcome, iterations)
    for _ in range(_ROUNDS):
        if found.residual <= tolerance or outcome.left > 1.5 * aim:
            break
        aim *= 0.5 * tolerance / found.residual
        outcome = iterate.gradients(system.matrix, right, precondition, aim, outcome.x)
        iterations += outcome.iterations
        found = _seen(system, weights, outcome, iterations)
    if found.residual <= tolerance:
        return replace(found, unsure=0.0)
    sure = found.residual <= _BALANCES and found.unsure <= _SURE
    if not sure or outcome.off > _STANDS**2 * found.compliance:
        raise _stuck(system, found, tolerance)
    return found


def _preconditioner(system: System) -> Callable[[Floats], Floats]:
    nodes = system.nodes
    vertices = nodes.points[: nodes.vertices]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    modes = rigid.motions(vertices, (low + high) / 2, float(np.linalg.norm(high - low)) / 2)
    corners = system.still[: nodes.vertices]
    if nodes.order == 1:
        return iterate.aggregated(system.matrix, modes * ~corners[..., None])
    small = stiffness(nodes, system.constants, order=1)
    _hold_middles(system, small)
    small.hold(corners)
    coarse = iterate.aggregated(small, modes * ~corners[..., None])
    return iterate.nested(system.matrix, nodes, system.still, coarse)


def _hold_middles(system: System, small: Blocks) -> None:
    """Add to the stiffness of vertices what resists that held middles of edges move, which are the means of both ends.

    Else a support whose nodes are middles but for one or two leaves vertices free to turn: the matrix that
    preconditions is then singular where the system is not, and the iterations make no progress.
    """
    nodes = system.nodes
    held = system.still[nodes.vertices :]
    edges = np.flatnonzero(held.any(axis=1))
    ends = nodes.edges[edges]
    blocks = system.matrix.diagonal(edges + nodes.vertices)
    share = np.einsum("nii->ni", blocks) * held[edges] / 4
    for one in range(2):
        for other in range(2):
            small.add(ends[:, one], ends[:, other], share)


def _seen(system: System, weights: Floats, outcome: iterate.Outcome, iterations: int) -> Equilibrium:
    """What iterations have come to: free motions taken out, as of the mean over the volume, for which nodes count by
    `weights` (r, k, 3); and what is left of forces over those that act."""
    displacement = outcome.x + system.held.displacement
    fields = system.free.fields
    if len(fields):
        inner = np.einsum("rkd,skd->rs", weights, fields)
        share = np.linalg.solve(inner, np.einsum("rkd,kd->r", weights, displacement))
        displacement -= np.einsum("r,rkd->kd", share, fields)
    resisted = system.resistance(displacement)
    rest = resisted - system.forces
    held, moves = system.held.components, bool(system.held.displacement.any())
    reactions = rest * held
    acting = float(np.linalg.norm(system.forces))
    if moves:
        acting = max(acting, float(np.linalg.norm(reactions)))
    left = [outcome.left / acting] if acting > 0 else [0.0]
    points = system.nodes.points
    centre, size = points.mean(axis=0), float(np.ptp(points, axis=0).max()) / 2
    loose = rest * ~system.still
    unanswered = np.concatenate([loose.sum(axis=0), np.cross(points - centre, loose).sum(axis=0) / size])
    resultants = [f.sum(axis=0) for f in (*(load.forces for load in system.loads),
                                          *(reactions[chosen] for chosen in system.held.nodes))]  # fmt: skip
    whole = max([_LEAST * float(np.abs(np.where(held, rest, system.forces)).sum()),
                 *(float(np.linalg.norm(f)) for f in resultants)])  # fmt: skip
    left.append(float(np.abs(unanswered).max()) / whole if whole > 0 else 0.0)
    compliance = float(np.vdot(resisted, displacement))
    # forces f and what is left r of them: f (u - u') = u r, which is no more than the product of their norms
    product = float(np.linalg.norm(displacement)) * max(outcome.left, float(np.linalg.norm(loose)))
    return Equilibrium(displacement, rest, compliance, max(left), iterations, product / max(compliance, 1e-300))


def _stuck(system: System, found: Equilibrium, tolerance: float) -> PoreError:
    """E176, with what of this system is likely to be the reason."""
    young, poisson, nodes = system.young, system.poisson, system.nodes
    middles = nodes.points[nodes.corners].mean(axis=1)
    edges = nodes.points[nodes.corners[:, EDGES]]
    longest = np.linalg.norm(edges[:, :, 1] - edges[:, :, 0], axis=2).max(axis=1)
    flat = nodes.volumes / longest**3 * 6 * np.sqrt(2)  # 1 of a regular tetrahedron
    ways = []
    if young.max() > _APART * young.min():
        ways.append(
            f"leave out of the part what is softest, {young.min():.3g} MPa at {place(middles[np.argmin(young)])}, or "
            f"give it {young.max() / _APART:.2g} MPa or more: the stiffest is {young.max():.3g} MPa"
        )
    if poisson.max() > _FULL:
        ways.append(f"take a Poisson's ratio of {_FULL} instead of {poisson.max():.5g}")
    if flat.min() < _FLAT:
        ways.append(f"mesh the part with other sizes: a tetrahedron at {place(middles[np.argmin(flat)])} is flat")
    return fail(
        "E176",
        f"the iterations came no further than a residual of {found.residual:.3g} of the forces, where {tolerance:.3g} "
        f"is wanted",
        hint="; ".join(ways) or "mesh the part with other sizes, or hold it on more of its surface",
    )
