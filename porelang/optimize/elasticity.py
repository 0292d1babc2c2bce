"""The homogenised problem solved: displacements of the grid, and what each voxel bears."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from porelang.diagnostics import fail
from porelang.optimize import element, loops, multigrid
from porelang.optimize.grid import AXES, Force, Grid, Moment, Platen, Problem, Support

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
TOLERANCE = 1e-7


@dataclass(frozen=True, eq=False)
class Model:
    """A problem made ready: what is fixed, what is pushed, and by what forces; the density is still open."""

    problem: Problem
    cells: tuple[int, int, int]
    index: NDArray[np.int64]
    fixed: Flags
    forces: Array
    pushed: tuple[NDArray[np.int64], int, float] | None


@dataclass(frozen=True, eq=False)
class Solution:
    """What a grid does under its load, all of it of the homogenised material.

    `displacement` (nx+1, ny+1, nz+1, 3) mm. For each voxel that counts: `energy` (m,) MPa, the mean of its strain
    energy density; `shares` (m, k) MPa, u K_k u over its volume for each base tensor, by which a change of its weight
    changes the compliance; `stress` (m, 6) MPa in its middle (xx, yy, zz, yz, xz, xy). `compliance` N mm is force times
    displacement, `noise` the root mean square by which the energy in the middles differs from that mean, relative to
    it: how well voxels of this size resolve it.
    """

    displacement: Array
    energy: Array
    shares: Array
    stress: Array
    compliance: float
    largest: float
    reaction: Array
    noise: float
    residual: float
    iterations: int
    state: Array

    @property
    def von_mises(self) -> Array:
        """(m,) MPa."""
        return von_mises(self.stress)


def von_mises(stress: Array) -> Array:
    """Von Mises' equivalent (m,) of stresses (m, 6).

    >>> von_mises(np.array([[0, 0, -3.0, 0, 0, 0], [0, 0, 0, 0, 0, 1.0]])).round(3).tolist()
    [3.0, 1.732]
    """
    xx, yy, zz, yz, xz, xy = stress.T
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    out: Array = np.sqrt(normal + 3 * (yz**2 + xz**2 + xy**2))
    return out


def prepare(problem: Problem) -> Model:
    """Look at a problem before it is solved.

    Errors: E190 where something of it can move freely, with the motion; E191 for selections of nothing, for forces
    beside a platen, and for none at all.
    """
    grid = problem.grid
    if not grid.mask.any():
        raise fail(
            "E191", "no voxel lies in the part", hint="use a smaller voxel, or look where the part lies: `pore measure`"
        )
    cells = multigrid.padded(grid.shape)
    count = int(np.prod([n + 1 for n in cells]))
    fixed = np.zeros((count, 3), bool)
    forces = np.zeros((count, 3))
    for support in problem.supports:
        nodes = grid.surface_nodes(support.where, support.name)
        fixed[np.ix_(_moved(nodes, grid.shape, cells), np.flatnonzero(support.axes))] = True
    platens = [load for load in problem.loads if isinstance(load, Platen)]
    pushed = None
    if platens and len(problem.loads) > 1:
        raise fail("E191", "a platen stands beside another load", hint="load by one platen alone, or by forces")
    for load in problem.loads:
        if isinstance(load, Platen):
            nodes = _moved(grid.surface_nodes(load.where, load.name), grid.shape, cells)
            fixed[nodes] |= np.array([load.bonded or a == load.axis for a in range(3)])
            pushed = nodes, load.axis, load.force
        else:
            faces, areas = grid.surface_faces(load.where, load.name)
            corners = np.stack([_moved(faces[:, c], grid.shape, cells) for c in range(4)], axis=1)
            push = _pushed(load, grid, faces, areas / areas.sum() / 4)
            np.add.at(forces, corners.ravel(), push.reshape(-1, 3))
    if not (pushed and pushed[2]) and not forces.any():
        raise fail("E191", "nothing loads the part: all forces are 0 N", hint="give a force that is not zero")
    _held(grid, cells, fixed)
    return Model(problem, cells, np.argwhere(grid.mask), fixed, forces, pushed)


def solve(
    model: Model, weights: Array, bases: Array, start: Array | None = None, tolerance: float = TOLERANCE
) -> Solution:
    """Solve with the stiffness sum_k weights[e, k] bases[k] (6, 6) MPa in the voxel e (m of them, as `grid.weights`).

    `start` is the `state` of a solution of the same model, from which it begins. Errors: E194.
    """
    grid = model.problem.grid
    spacing = np.array(grid.spacing)
    fill = grid.fill[grid.mask]
    matrices = np.array([element.stiffness(base, spacing) for base in bases])
    filled = np.ascontiguousarray(weights * fill[:, None])
    cycle, _ = multigrid.cycle(model.cells, model.index, filled, matrices, model.fixed)
    first, offsets = multigrid.numbering(model.cells, model.index)
    product = np.empty_like(model.forces)
    given = np.zeros_like(model.forces)
    right = model.forces
    if model.pushed is not None:
        nodes, axis, force = model.pushed
        given[nodes, axis] = np.copysign(1.0, force)
        loops.weighted(first, offsets, filled, matrices, given, product)
        right = -product
    found = multigrid.solve(cycle, right, start, tolerance)
    u = found.u + given
    loops.weighted(first, offsets, filled, matrices, u, product)
    if model.pushed is not None:  # any displacement of the platen will do: what it takes is known now
        scale = abs(force) / abs(float(product[nodes, axis].sum()))
        u *= scale
        product *= scale
        compliance = abs(force) * scale
    else:
        compliance = float(np.vdot(model.forces, u))
    volumes = grid.weights
    shares = np.empty((len(volumes), len(bases)))
    loops.energies(first, offsets, matrices, u, shares)
    shares /= spacing.prod()  # of the material: an emptier voxel has less of both
    energy = (shares * weights).sum(1) / 2
    corners = first[:, None] + offsets
    strain = u[corners].reshape(-1, 24) @ element.strains(np.full(3, 0.5), spacing).T
    stress = np.einsum("mk,kij,mj->mi", weights, bases, strain)
    middle = np.einsum("mi,mi->m", stress, strain) / 2
    mean = np.average(energy, weights=volumes)
    noise = float(np.sqrt(np.average((energy - middle) ** 2, weights=volumes)) / mean)
    nx, ny, nz = (n + 1 for n in model.cells)
    sx, sy, sz = (n + 1 for n in grid.shape)
    shown = u.reshape(nx, ny, nz, 3)[:sx, :sy, :sz]
    held = product * model.fixed - model.forces * model.fixed
    return Solution(shown, energy, shares, stress, compliance, float(np.linalg.norm(u[corners], axis=-1).max()),
                    held.sum(0), noise, found.residual, found.iterations, found.u)  # fmt: skip


def _pushed(load: Force | Moment, grid: Grid, faces: NDArray[np.intp], share: Array) -> Array:
    """The forces (f, 4, 3) N of a load on the nodes of faces (f, 4), each of which has so much of the area (f,)."""
    if isinstance(load, Force):
        return np.broadcast_to(share[:, None, None] * np.array(load.total), (*faces.shape, 3))
    # forces a x r of places r about their middle are a couple J a and no net force
    place = grid.node_places(faces.ravel()).reshape(*faces.shape, 3)
    arm = place - np.einsum("f,fcd->d", share, place)
    inertia = np.einsum("f,fcd,fcd->", share, arm, arm) * np.eye(3) - np.einsum("f,fcd,fce->de", share, arm, arm)
    turning = np.linalg.lstsq(inertia, np.array(load.total), rcond=1e-9)[0]
    return np.asarray(share[:, None, None] * np.cross(turning, arm))


def _moved(nodes: NDArray[np.intp], shape: tuple[int, int, int], cells: tuple[int, int, int]) -> NDArray[np.int64]:
    """The numbers of nodes of a grid in the larger one that can be halved."""
    at = np.unravel_index(nodes, tuple(n + 1 for n in shape))
    return np.asarray(np.ravel_multi_index(at, tuple(n + 1 for n in cells)), np.int64)


def _held(grid: Grid, cells: tuple[int, int, int], fixed: Flags) -> None:
    """E190 where a piece, its voxels joined by faces, has a rigid motion that no support resists."""
    pieces, count = label(grid.mask)
    for piece in range(1, count + 1):
        index = np.argwhere(pieces == piece)
        first, offsets = multigrid.numbering(cells, index)
        nodes = np.unique(first[:, None] + offsets)
        place = np.stack(np.unravel_index(nodes, tuple(n + 1 for n in cells)), -1) * np.array(grid.spacing)
        centre = place.mean(0)
        arm = (place - centre) / max(float(np.abs(place - centre).max()), 1e-300)
        modes = np.zeros((len(nodes), 3, 6))
        modes[:, range(3), range(3)] = 1
        for axis in range(3):
            modes[:, :, 3 + axis] = np.cross(np.eye(3)[axis], arm)
        held = modes[fixed[nodes]]
        _, sizes, motions = np.linalg.svd(held.T @ held) if len(held) else (None, np.zeros(6), np.eye(6))
        free = motions[sizes < 1e-8 * max(1.0, float(sizes.max()))]
        if len(free):
            where = ", ".join(f"{v:.4g}" for v in np.array(grid.origin) + centre)
            raise fail("E190", f"{'a piece of ' if count > 1 else ''}the part round ({where}) mm can {_motion(free)}: "
                       "no support resists that",
                       hint="hold it along more axes, or at more places; voxels are joined by their faces")  # fmt: skip


def _motion(free: Array) -> str:
    """Rigid motions in words."""
    words = [f"move along {AXES[a]}" for a in range(3)] + [f"turn about {AXES[a]}" for a in range(3)]
    # what lies wholly in the free motions is named; a mix, such as a turn about a corner, by its largest part
    reach = np.sqrt((free**2).sum(0))
    named = [word for word, r in zip(words, reach, strict=True) if r > 0.99] or [words[int(reach.argmax())]]
    return named[0] if len(named) == 1 else ", ".join(named[:-1]) + f" and {named[-1]}"


__all__ = ["Model", "Solution", "Support", "prepare", "solve", "von_mises"]
