"""A study, solved: the part as elements, its stresses and displacements, and the numbers that it comes to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced, SampledField
from porelang.diagnostics import PoreError
from porelang.fea import Force, Problem, Resultant, Solution, Where, refined_sizes, solve
from porelang.fea.covered import covered
from porelang.fea.means import mean_length
from porelang.fea.nodes import Nodes
from porelang.fea.stress import energy_density
from porelang.fea.surface import surface
from porelang.formula import Formula
from porelang.ir import X, Y, Z, node
from porelang.progress import activity
from porelang.solid import Solid
from porelang.tasks.readers.cells import Cells
from porelang.tasks.readers.raster import gridded, spacing_of
from porelang.tasks.study.asked import DENSITY, POISSON, YOUNG, Question, solid_of, valued
from porelang.tasks.study.elements import meshed
from porelang.tasks.study.ends import OnPart, Setting, setting
from porelang.tasks.study.greatest import greatest
from porelang.tasks.study.interfaces import interfaces
from porelang.tasks.study.missed import Missed, missed
from porelang.tasks.study.numbers import Measured, numbers_of
from porelang.tasks.study.samples import NODES
from porelang.tasks.study.sized import Sized, sized
from porelang.tet.gap import Gap
from porelang.tet.gaps import closed_gap, spanned
from porelang.tet.tetmesh import TetMesh, volumes

Floats = NDArray[np.float64]
MESHING, SOLVING, COMPARING = "making elements", "solving for stresses", "comparing elements with the part"
#: A step of refinement is to bring the error to this share of what it was.
_REFINED = 0.5
#: Where elements missed the part, those of a refined study have between these shares of their size: as walls ask for.
_LOST_SIZES = 0.25, 0.5
#: By which factors sizes become smaller where the mesher makes no sound mesh.
_SMALLER = 0.93, 0.93
#: The mesher's cubes hold twelve tetrahedra each: their edge for that of a regular tetrahedron of the same volume.
_CUBE = 2.0 ** (1 / 6)
#: Elements of a graded mesh that may be finer, or coarser, than the sizes that are said of it.
_FEW = 0.05


@dataclass(frozen=True, slots=True)
class Fields:
    """What a study finds at the corners of its elements: `displacement` (p, 3) mm, `stress` (p, 6) MPa in VTK's order,
    `strain` (p, 6) likewise (shear is half of the engineers'), `von_mises` (p,) MPa, `energy` (p,) N/mm2. Where the
    material jumps a vertex has a place for each side: `mesh` has these places as its vertices."""

    mesh: TetMesh
    displacement: Floats
    stress: Floats
    strain: Floats
    von_mises: Floats
    energy: Floats


@dataclass(frozen=True, slots=True)
class Solved:
    """A study in elements: `fields` at their corners, by which share stresses err in the energy of each (m,), the
    numbers of `porelang.ops.studies` by name, with their errors; what `supports` and `loads` found and come to.

    `missed` is what elements miss of the part, `shared` by which share of the energy the material within elements is
    open, most of all in the element round `seam`; `gap` is what they close of it.

    `young` (m,) MPa is that of each element; `solution` what the solver found, before a platen got its force; `lost`
    the share of the part in `pieces` that are left out. Displacements are counted from where the part rests.
    """

    asked: Question
    mesh: TetMesh
    young: Floats
    fields: Fields
    errors: Floats
    solution: Solution
    sized: Sized
    numbers: Mapping[str, Reduced]
    supports: tuple[Resultant, ...]
    loads: tuple[Resultant, ...]
    missed: Missed
    shared: float
    seam: tuple[float, float, float]
    gap: Gap | None
    unknowns: int
    iterations: int
    residual: float
    lost: float
    pieces: int
    rests: tuple[str, ...]

    @property
    def reactions(self) -> Mapping[str, Floats]:
        """The forces (3,) N of supports by name, and of those loads in balance that stand for them (`rests`): the outer
        pads of what is bent by three points."""
        return {r.name: r.force for r in (*self.supports, *(load for load in self.loads if load.name in self.rests))}


def solved(asked: Question, begun: Callable[[Sized], None] | None = None) -> Solved:
    """Elements, made as fine as the study asks for, and what is solved on them; `begun` is told of their size and about
    how many there are, before they are made.

    Errors: those of the part (E091, E092), of its elements (E160-), of what holds and loads it (E170-, E185-E189).
    """
    part = solid_of(asked)
    with activity(MESHING):
        found = sized(part, asked.size, asked.order)
        if begun is not None:
            begun(found)
        mesh, found, lost, pieces = meshed(part, found.size, found)
    return on(asked, part, mesh, found, lost, pieces)


def on(asked: Question, part: Solid, mesh: TetMesh, found: Sized, lost: float, pieces: int) -> Solved:
    """What is solved on a mesh. Errors: those of `solved` but for the mesh's."""
    acting = setting(asked, mesh, found.size)
    middles = mesh.vertices[mesh.tets].mean(axis=1)
    young, poisson, density = (
        valued(field, middles, *words)
        for field, words in ((asked.young, YOUNG), (asked.poisson, POISSON), (asked.density, DENSITY))
    )
    problem = Problem(mesh, young, poisson, density, acting.supports, acting.loads, 1 if asked.order == 1 else 2,
                      acting.balanced)  # fmt: skip
    with activity(SOLVING):
        solution = solve(problem)
    factor, stiffness, work = _scaled(asked, acting, solution)
    moved = factor * solution.displacement
    if acting.rests:
        moved = moved - _ridden(moved, solution.nodes, acting.rests)
    fields = _fields(solution, factor, moved, mesh)
    with activity(COMPARING):
        lacks, gap = missed(part, mesh, found.size), closed_gap(spanned(part, mesh))
        if gap is not None:  # narrower than the grid on which is counted what elements hold beyond the part
            lacks = replace(lacks, beyond=max(lacks.beyond, gap.volume))
    between = interfaces(mesh, asked.young, asked.poisson)
    energy = energy_density(solution.stress_of_tets, young, poisson) * volumes(mesh)
    open_ = energy * between.gap / max(float(energy.sum()), 1e-300)
    x, y, z = (float(c) for c in middles[np.argmax(open_)])
    measured = Measured(
        most=greatest(solution.nodes, moved, OnPart(part, found.size).nearest),
        mean=mean_length(solution.nodes, moved),
        von_mises=fields.von_mises,
        largest=float(np.abs(fields.stress).max()),
        work=work,
        stiffness=stiffness,
        error=solution.error.relative,
        unsure=solution.unsure,
        errors=(errors := _errors(solution, fields)),
        missed=lacks,
        shared=float(open_.sum()),
        jumps=_at_vertices(mesh, between.spread)[solution.sites.vertex],
    )
    return Solved(
        asked=asked,
        mesh=mesh,
        young=young,
        fields=fields,
        errors=errors,
        solution=solution,
        sized=found,
        numbers=numbers_of(fields.mesh, density, measured),
        supports=tuple(r.scaled(factor) for r in solution.reactions),
        loads=tuple(r.scaled(factor) for r in solution.loads),
        missed=lacks,
        shared=measured.shared,
        seam=(x, y, z),
        gap=gap,
        unknowns=solution.unknowns,
        iterations=solution.iterations,
        residual=solution.residual,
        lost=lost,
        pieces=pieces,
        rests=tuple(a.name for a in acting.loads if isinstance(a, Force) and a.where in acting.rests),
    )


def _at_vertices(mesh: TetMesh, values: Floats) -> Floats:
    """The greatest value (n,) of the elements round each vertex, of values (m,)."""
    out = np.zeros(len(mesh.vertices))
    np.maximum.at(out, mesh.tets.ravel(), np.repeat(values, 4))
    return out


def _scaled(asked: Question, acting: Setting, solution: Solution) -> tuple[float, float | None, float]:
    """By what a solution is to be multiplied; the stiffness, and the work of what moves the part (N mm).

    A platen that was moved by 1 mm gets the force that is asked for. Stiffness is force over the way that it goes, or
    torque over the angle: the square of a load over its work.
    """
    if acting.reached is not None:
        which, axis, force = acting.reached
        stiffness = abs(float(solution.reactions[which].force[axis]))
        return force / stiffness, stiffness, force**2 / stiffness
    work = float(solution.compliance)
    moving = [a for a in asked.acts if a.name != "held"]
    if len(moving) > 1 or work <= 0:
        return 1.0, None, work
    (act,) = moving
    match act.name:
        case "force" | "torque":
            return 1.0, float(np.dot(act.numbers, act.numbers)) / work, work
        case "bend" | "twist_load":
            return 1.0, act.numbers[0] ** 2 / work, work
        case "moved":
            by = np.array(act.numbers[3:]) * np.array(act.numbers[:3])
            return 1.0, work / float(by @ by), work
    return 1.0, None, work


def _fields(solution: Solution, factor: float, moved: Floats, mesh: TetMesh) -> Fields:
    sites = solution.sites
    apart = TetMesh(mesh.vertices[sites.vertex], sites.corners, mesh.phase, mesh.phases)
    return Fields(
        mesh=apart,
        displacement=moved[sites.vertex],
        stress=factor * solution.stress,
        strain=factor * solution.strain,
        von_mises=abs(factor) * solution.von_mises,
        energy=factor**2 * solution.energy_density,
    )


def _ridden(displacement: Floats, nodes: Nodes, rests: tuple[Where, ...]) -> Floats:
    """The rigid motion (k, 3) of nodes that is the nearest to what the area on supports does, in the mean over it: what
    lies there does not move with them."""
    boundary = surface(nodes)
    on = [covered(where, nodes, boundary, "a pad") for where in rests]
    at = np.concatenate([patch.points.reshape(-1, 3) for patch in on])
    moved = np.concatenate([patch.of_nodes(nodes, displacement).reshape(-1, 3) for patch in on])
    areas = np.concatenate([patch.areas.ravel() for patch in on])
    centre = np.average(at, axis=0, weights=areas)

    def motions(points: Floats) -> Floats:
        x, y, z = (points - centre).T
        zero, one = np.zeros_like(x), np.ones_like(x)
        rows = ([one, zero, zero, zero, z, -y], [zero, one, zero, -z, zero, x], [zero, zero, one, y, -x, zero])
        return np.stack([np.stack(row, -1) for row in rows], axis=1)

    weights = np.repeat(np.sqrt(areas), 3)
    fit = weights[:, None] * motions(at).reshape(-1, 6)
    motion = np.linalg.lstsq(fit, weights * moved.reshape(-1), rcond=None)[0]
    return np.asarray(motions(nodes.points) @ motion)


def _errors(solution: Solution, fields: Fields) -> Floats:
    """By which share the stress of each element errs, in energy; of one that has little, against the mean of all."""
    energy = fields.energy[fields.mesh.tets].mean(axis=1) * volumes(fields.mesh)
    share = energy / max(float(energy.sum()), 1e-300)
    return np.asarray(solution.error.of_tets / np.sqrt(np.maximum(share, 1 / len(share))))


def refined(found: Solved) -> Solved:
    """The study solved again with elements of sizes that halve its error with the fewest of them, by the estimate; and
    half as large, or less, where the first missed the part."""
    sizes = _CUBE * refined_sizes(found.solution, _REFINED * max(found.solution.error.relative, 1e-9))
    cells = Cells(found.mesh.vertices, found.mesh.tets.astype(np.int64), sizes[:, None], False, found.mesh.vertices,
                  sizes[:, None], len(found.mesh.tets), 0, 0, True)  # fmt: skip
    samples = gridded(cells, spacing_of(cells, NODES)).samples
    samples = _finer_at(samples, found.missed.lost, _size_where_lost(found.sized), found.sized.size)
    part = solid_of(found.asked)
    with activity(MESHING):
        mesh, made, lost, pieces = _meshed_to(part, samples, found.sized)
    # of a uniform mesh twelve tetrahedra fill a cube of its size
    finest, coarsest = np.quantile(np.cbrt(12 * volumes(mesh)), (_FEW, 1 - _FEW))
    graded = replace(made, size=float(coarsest), finest=float(finest))
    return on(found.asked, part, mesh, graded, lost, pieces)


def _meshed_to(part: Solid, sizes: SampledField, sized: Sized) -> tuple[TetMesh, Sized, float, int]:
    """Elements of sizes (mm) that are sampled: where the mesher makes no sound mesh of these, of somewhat smaller ones.
    Errors: those of `meshed`."""
    for smaller in (*_SMALLER, None):
        grid = node("bound", value=(sizes.digest,))
        wanted = Formula((node("lookup", grid, X, Y, Z, value=(0, 0, 0, 0)),), {grid: sizes})
        try:
            return meshed(part, wanted, sized)
        except PoreError as error:
            if smaller is None or [d.code for d in error.diagnostics] != ["E162"]:
                raise
            sizes = SampledField.from_array(smaller * sizes.values, sizes.origin, sizes.spacing)
    raise AssertionError  # the last one returned, or raised


def _size_where_lost(sized: Sized) -> float:
    least, most = _LOST_SIZES
    return float(np.clip(sized.wanted, least * sized.size, most * sized.size))


def _finer_at(samples: SampledField, places: Floats, size: float, reach: float) -> SampledField:
    """Samples of sizes that are no larger than one size (mm) within a reach (mm) of some places (n, 3)."""
    if not len(places):
        return samples
    from scipy.spatial import cKDTree

    axes = [o + s * np.arange(n) for o, s, n in zip(samples.origin, samples.spacing, samples.shape, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    near = cKDTree(places).query(nodes, distance_upper_bound=reach)[0] <= reach
    values = samples.values[..., 0].copy()
    values.reshape(-1)[near] = np.minimum(values.reshape(-1)[near], size)
    return SampledField.from_array(values, samples.origin, samples.spacing)
