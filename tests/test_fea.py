"""Elasticity against closed forms, manufactured solutions and independent assembly."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from boxes import Floats, box, cylinder, octant

from porelang.fea import (
    BodyForce,
    Facing,
    Force,
    Moment,
    Pressure,
    Problem,
    Solution,
    Support,
    Weight,
    refined_sizes,
    solve,
)
from porelang.fea.assemble import lame, stiffness
from porelang.fea.covered import covered
from porelang.fea.elements import shape_values, slopes_at, terms, tet_rule
from porelang.fea.loads import applied
from porelang.fea.means import mean_length
from porelang.fea.nodes import EDGES, number
from porelang.fea.shares import percentile, share_below
from porelang.fea.stress import TWICE, strains_at, stresses, von_mises
from porelang.fea.surface import surface

YOUNG, POISSON = 100.0, 0.3


def everywhere(points: Floats) -> np.ndarray:
    return np.ones(len(points), bool)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("seed", [0, 1])
def test_patch(order: int, seed: int) -> None:
    """A linear displacement of the boundary is that of the whole, and its stress is uniform."""
    slope = np.random.default_rng(seed).normal(size=(3, 3)) / 100
    held = Support(everywhere, displacement=lambda p: p @ slope.T)
    mesh = box((3, 2, 3), (1.0, 2.0, 1.5), jitter=0.2)
    found = solve(Problem(mesh, YOUNG, POISSON, supports=(held,), order=order), 1e-13)
    np.testing.assert_allclose(found.displacement, found.nodes.points @ slope.T, atol=1e-10 * np.abs(slope).max())
    strain = (slope + slope.T) / 2
    mu, lam = YOUNG / 2 / (1 + POISSON), YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    true = 2 * mu * strain + lam * np.trace(strain) * np.eye(3)
    rows = true[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    np.testing.assert_allclose(found.stress, np.broadcast_to(rows, found.stress.shape), atol=1e-9)
    np.testing.assert_allclose(found.strain[:, 3], strain[0, 1], atol=1e-11)
    assert found.error.relative < 1e-9
    assert found.compliance == pytest.approx(float((true * strain).sum()) * 3.0, rel=1e-10)


@pytest.mark.parametrize("order", [1, 2])
def test_cylinder_between_frictionless_platens(order: int) -> None:
    """u = F L / (E A), and the sides move out by nu; whatever the free motions, the answer has none of them."""
    mesh = cylinder(5.0, 20.0, 4, 6)
    problem = Problem(
        mesh, 2000.0, 0.35, supports=(Support(lambda p: p[:, 2] < 1e-9, (False, False, True)),),
        loads=(Force(lambda p: p[:, 2] > 20 - 1e-9, (0.0, 0.0, -1000.0)),), order=order, balanced=True,
    )  # fmt: skip
    found = solve(problem, 1e-13)
    area = found.nodes.volumes.sum() / 20
    shift = -1000 * 20 / (2000 * area)
    top = mesh.vertices[:, 2] > 20 - 1e-9
    np.testing.assert_allclose(found.at_vertices[top, 2], shift, rtol=1e-10)
    wide = -0.35 * shift / 20 * mesh.vertices[:, :2]
    np.testing.assert_allclose(found.at_vertices[:, :2], wide, atol=1e-10 * abs(shift))  # its axis is that of the mesh
    np.testing.assert_allclose(found.von_mises, 1000 / area, rtol=1e-8)
    assert found.percentile(found.von_mises, 99) == pytest.approx(1000 / area)
    assert found.reactions[0].force == pytest.approx([0, 0, 1000], abs=1e-6)
    assert found.compliance == pytest.approx(-1000 * shift, rel=1e-10)


@pytest.mark.parametrize("order", [1, 2])
def test_free_motions_have_no_mean_over_the_volume(order: int) -> None:
    """A bar that is pulled becomes thinner about its own axis, wherever elements are small."""
    mesh = box((2, 4, 4), (4.0, 1.0, 1.0))
    mesh = replace(mesh, vertices=mesh.vertices ** [1, 2, 3])  # finer towards one edge
    found = solve(Problem(
        mesh, YOUNG, POISSON, supports=(Support(lambda p: p[:, 0] < 1e-9, (True, False, False)),),
        loads=(Force(lambda p: p[:, 0] > 4 - 1e-9, (2.0, 0.0, 0.0)),), order=order, balanced=True,
    ), 1e-12)  # fmt: skip
    thinner = -POISSON * 2.0 / YOUNG * (mesh.vertices[:, 1:] - 0.5)
    np.testing.assert_allclose(found.at_vertices[:, 1:], thinner, atol=1e-9)


def test_cantilever() -> None:
    """Timoshenko's beam, with the shear coefficient of Cowper (J. Appl. Mech. 33, 1966), for P2."""
    length, load = 12.0, 0.01
    mesh = box((18, 2, 2), (length, 1.0, 1.0))
    supports = (  # a section that stays plane, and is free to become narrower where it is pulled
        Support(lambda p: p[:, 0] < 1e-9, (True, False, False)),
        Support(lambda p: (p[:, 0] < 1e-9) & (np.abs(p[:, 2] - 0.5) < 1e-9), (False, False, True)),
        Support(lambda p: (p[:, 0] < 1e-9) & (np.abs(p[:, 1] - 0.5) < 1e-9), (False, True, False)),
    )
    end = Force(lambda p: p[:, 0] > length - 1e-9, (0.0, 0.0, load))
    found = solve(Problem(mesh, YOUNG, POISSON, supports=supports, loads=(end,)))
    shear = 10 * (1 + POISSON) / (12 + 11 * POISSON) * YOUNG / 2 / (1 + POISSON)
    true = load * length**3 / (3 * YOUNG / 12) + load * length / shear
    tip = mesh.vertices[:, 0] > length - 1e-9
    assert found.at_vertices[tip, 2].mean() == pytest.approx(true, rel=0.005)
    one = solve(Problem(mesh, YOUNG, POISSON, supports=supports, loads=(end,), order=1))
    assert one.at_vertices[tip, 2].mean() < 0.9 * true  # why P2 is the default


def test_torsion() -> None:
    """A round bar turns by T L / (G J), J that of the prism's own polygon to the order of the mesh."""
    mesh = cylinder(2.0, 10.0, 8, 4)
    problem = Problem(
        mesh, YOUNG, POISSON, supports=(Support(lambda p: p[:, 2] < 1e-9),),
        loads=(Moment(lambda p: p[:, 2] > 10 - 1e-9, (0.0, 0.0, 50.0)),),
    )  # fmt: skip
    found = solve(problem)
    rim = (mesh.vertices[:, 2] > 10 - 1e-9) & (np.hypot(*mesh.vertices[:, :2].T) > 1.99)
    x, y, _ = mesh.vertices[rim].T
    turn = ((x * found.at_vertices[rim, 1] - y * found.at_vertices[rim, 0]) / (x**2 + y**2)).mean()
    true = 50 * 10 / (YOUNG / 2 / 1.3 * np.pi * 2**4 / 2)
    assert turn == pytest.approx(true, rel=0.04)
    assert found.reactions[0].moment == pytest.approx([0, 0, -50], abs=1e-5)


def planes() -> tuple[Support, ...]:
    """Symmetry about x = 0, y = 0, z = 0."""

    def plane(axis: int) -> Support:
        return Support(lambda p: p[:, axis] < 1e-9, tuple(i == axis for i in range(3)), name="xyz"[axis])  # type: ignore[arg-type]

    return plane(0), plane(1), plane(2)


def test_spherical_cavity_concentrates_stress() -> None:
    """Goodier (1933): (27 - 15 nu) / (2 (7 - 5 nu)) of the tension far away, at the cavity's equator."""
    far = 10.0

    def away(p: Floats) -> Floats:
        return p * np.array([-POISSON, -POISSON, 1.0]) / YOUNG

    factors = []
    for across, along in ((2, 6), (4, 18)):
        mesh = octant(1.0, far, across, along)
        outer = Support(lambda p: np.linalg.norm(p, axis=1) > 0.8 * far, displacement=away)
        found = solve(Problem(mesh, YOUNG, POISSON, supports=(*planes(), outer)))
        equator = (np.linalg.norm(mesh.vertices, axis=1) < 1 + 1e-9) & (mesh.vertices[:, 2] < 1e-9)
        factors.append(found.stress[: len(mesh.vertices)][equator, 2].mean())
    true = (27 - 15 * POISSON) / (2 * (7 - 5 * POISSON))
    errors = np.abs(np.array(factors) / true - 1)
    assert errors[1] < 0.015
    assert errors[1] < 0.3 * errors[0]


def test_sphere_under_pressure() -> None:
    """Lame's thick sphere: displacement and hoop stress at the inner face."""
    a, b, p = 1.0, 2.0, 3.0
    mesh = octant(a, b, 4, 4)
    inside = Pressure(lambda q: np.linalg.norm(q, axis=1) < 1.1 * a, p)
    found = solve(Problem(mesh, YOUNG, POISSON, supports=planes(), loads=(inside,)))
    inner = np.linalg.norm(mesh.vertices, axis=1) < a + 1e-9
    k = p * a**3 / (b**3 - a**3)
    true = k * a / YOUNG * ((1 - 2 * POISSON) + (1 + POISSON) * b**3 / (2 * a**3))
    shift = np.linalg.norm(found.at_vertices[inner], axis=1)
    np.testing.assert_allclose(shift, true, rtol=0.03)
    hoop = k * (1 + b**3 / (2 * a**3))
    assert found.principal()[0][: len(inner)][inner, 0].mean() == pytest.approx(hoop, rel=0.06)
    assert (shift > 0).all()


WAVES = np.array([[2.0, 1.0, 0.5], [1.0, -0.5, 2.0], [0.7, 1.5, -1.0]])
PHASES = np.array([0.3, 1.0, -0.4])


def waves(p: Floats) -> Floats:
    """A displacement with all derivatives: u_i = sin(k_i . p + c_i) / 10."""
    return np.sin(p @ WAVES.T + PHASES) / 10


def stress_of_waves(p: Floats) -> Floats:
    slope = (np.cos(p @ WAVES.T + PHASES) / 10)[..., None] * WAVES
    strain = (slope + np.swapaxes(slope, -1, -2)) / 2
    return stresses(strain[..., [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]], np.array(YOUNG), np.array(POISSON))


def force_of_waves(p: Floats) -> Floats:
    """What holds it: -div sigma = -((lambda + mu) grad div u + mu lap u)."""
    mu, lam = YOUNG / 2 / (1 + POISSON), YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    bend = -np.sin(p @ WAVES.T + PHASES) / 10
    divergence = np.einsum("...j,jj,ji->...i", bend, WAVES, WAVES)
    return -((lam + mu) * divergence + mu * bend * (WAVES**2).sum(axis=1))


def norms(found: Solution) -> tuple[float, float, float]:
    """The errors in energy (relative) and in L2, and the estimate over the first."""
    rule, weights = tet_rule(6)
    nodes = found.nodes
    points = np.einsum("qk,mkd->mqd", rule, nodes.points[nodes.corners])
    shapes = shape_values(rule, EDGES if nodes.order == 2 else None)
    gap = waves(points) - np.einsum("qw,mwd->mqd", shapes, found.displacement[nodes.elements])
    strain = np.empty((len(nodes.elements), len(rule), 6))
    strains_at(nodes.elements, nodes.gradients, terms(nodes.order)[0], slopes_at(rule, nodes.order),
               found.displacement, strain)  # fmt: skip
    true = stress_of_waves(points)

    def energy(s: Floats) -> float:
        squares = (1 + POISSON) * (s**2 * TWICE).sum(axis=-1) - POISSON * s[..., :3].sum(axis=-1) ** 2
        return float(np.einsum("m,q,mq->", nodes.volumes, weights, squares / YOUNG))

    error = np.sqrt(energy(true - stresses(strain, np.array(YOUNG), np.array(POISSON))) / energy(true))
    square = float(np.einsum("m,q,mqd->", nodes.volumes, weights, gap**2))
    return float(error), float(np.sqrt(square)), found.error.relative / float(error)


@pytest.fixture(scope="module")
def manufactured() -> dict[int, list[Solution]]:
    held = Support(everywhere, displacement=waves)
    return {
        order: [
            solve(Problem(box((n, n, n), jitter=0.15), YOUNG, POISSON, supports=(held,),
                          loads=(BodyForce(force_of_waves),), order=order), 1e-10)
            for n in cells
        ]
        for order, cells in ((1, (4, 8)), (2, (3, 6)))
    }  # fmt: skip


@pytest.mark.parametrize("order", [1, 2])
def test_rates(order: int, manufactured: dict[int, list[Solution]]) -> None:
    """The errors fall with h^p in energy and with h^(p+1) in L2."""
    measured = [norms(found) for found in manufactured[order]]
    for coarse, fine in pairwise(measured):
        assert np.log2(coarse[0] / fine[0]) == pytest.approx(order, abs=0.2)
        assert np.log2(coarse[1] / fine[1]) == pytest.approx(order + 1, abs=0.3)


@pytest.mark.parametrize("order", [1, 2])
def test_estimate_is_near_the_error(order: int, manufactured: dict[int, list[Solution]]) -> None:
    """The effectivity of the estimate, and recovered stresses that are nearer than those of elements."""
    found = manufactured[order][-1]
    assert norms(found)[2] == pytest.approx(1.0, abs=0.15)
    rows = found.error.of_tets
    assert np.sqrt((rows**2).sum()) == pytest.approx(found.error.relative)
    true = stress_of_waves(found.nodes.points[found.sites.vertex])
    inner = (np.abs(found.nodes.points[found.sites.vertex] - 0.5) < 0.45).all(axis=1)
    nearest = np.abs(found.stress - true)[inner].mean()
    of_elements = stresses(_corner_strains(found), found.young[:, None], found.poisson[:, None])
    raw = np.abs(of_elements - true[found.sites.corners]).mean()
    assert nearest < 0.5 * raw


def _corner_strains(found: Solution) -> Floats:
    out = np.empty((len(found.nodes.elements), 4, 6))
    order = found.nodes.order
    strains_at(found.nodes.elements, found.nodes.gradients, terms(order)[0], slopes_at(np.eye(4), order),
               found.displacement, out)  # fmt: skip
    return out


def test_refinement_follows_the_error(manufactured: dict[int, list[Solution]]) -> None:
    """For half of the error elements of order p are smaller by 2^(1/p); smallest where the error is large."""
    for order, (found, *_) in manufactured.items():
        sizes = refined_sizes(found, found.error.relative / 2)
        now = (6 * np.sqrt(2) * found.nodes.volumes) ** (1 / 3)
        assert np.median(sizes) / np.median(now) == pytest.approx(0.5 ** (1 / order), rel=0.1)
    mesh = box((8, 2, 2), (8.0, 1.0, 1.0))
    bent = solve(Problem(mesh, YOUNG, POISSON, supports=(Support(lambda p: p[:, 0] < 1e-9),),
                         loads=(Force(lambda p: p[:, 0] > 7.9, (0.0, 0.0, 0.1)),)))  # fmt: skip
    sizes = refined_sizes(bent, 0.01)
    assert sizes[mesh.vertices[:, 0] < 0.1].mean() < 0.6 * sizes[mesh.vertices[:, 0] > 6].mean()


def test_forces_balance() -> None:
    """Reactions answer all loads, in force and in moment, to 1e-8."""
    mesh = cylinder(5.0, 20.0, 4, 5)
    loads = (
        Force(lambda p: p[:, 2] > 19.9, (3.0, -2.0, 1.0)),
        Pressure(lambda p: np.hypot(p[:, 0], p[:, 1]) > 4.7, 0.2),
        Moment(lambda p: (p[:, 2] > 19.9) & (p[:, 0] > 0), (10.0, 20.0, -5.0)),
        Weight((0.0, 100.0, -9810.0)),
    )
    supports = (
        Support(lambda p: (p[:, 2] < 0.1) & (p[:, 0] < 0), name="left"),
        Support(lambda p: (p[:, 2] < 0.1) & (p[:, 0] > 1), (False, True, True), (0.0, 0.0, 0.01), name="right"),
    )
    found = solve(Problem(mesh, 2000.0, 0.3, 7.8, supports, loads), 1e-11)
    force = sum(r.force for r in found.reactions) + found.applied.sum(axis=0)
    moment = sum(r.moment for r in found.reactions) + np.cross(found.nodes.points, found.applied).sum(axis=0)
    scale = np.abs(found.applied).sum()
    assert np.abs(force).max() < 1e-8 * scale
    assert np.abs(moment).max() < 1e-8 * scale * 20
    weight = found.mass / 1e6 * np.array([0, 100.0, -9810.0])  # g mm/s2 are 1e-6 N
    pressed = solve(Problem(mesh, 2000.0, 0.3, 7.8, supports, loads[1:2])).applied.sum(axis=0)
    assert found.applied.sum(axis=0) == pytest.approx(np.array([3.0, -2.0, 1.0]) + weight + pressed, abs=1e-9)


def test_matrix_is_symmetric_and_reciprocal() -> None:
    """Betti: the work of one load on the displacement of another is mutual."""
    mesh = box((3, 2, 2), (3.0, 1.0, 1.0), jitter=0.2)
    nodes = number(mesh.vertices, mesh.tets, 2)
    matrix = stiffness(nodes, lame(np.full(len(mesh.tets), YOUNG), np.full(len(mesh.tets), POISSON))).to_scipy()
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    held = (Support(lambda p: p[:, 0] < 1e-9),)
    a, b = (solve(Problem(mesh, YOUNG, POISSON, supports=held, loads=(load,)), 1e-12) for load in (
        Force(lambda p: p[:, 0] > 2.9, (0.0, 1.0, 0.5)), Pressure(lambda p: p[:, 2] > 0.9, 0.3)))  # fmt: skip
    assert np.vdot(a.applied, b.displacement) == pytest.approx(np.vdot(b.applied, a.displacement), rel=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_matrix_is_that_of_scikit_fem(order: int) -> None:
    """The energy of a field that elements do not contain, with moduli that vary: as another assembly has it."""
    import skfem
    from skfem.models.elasticity import linear_elasticity

    mesh = box((3, 2, 2), (1.0, 2.0, 1.5), jitter=0.2)
    nodes = number(mesh.vertices, mesh.tets, order)
    young = np.random.default_rng(0).uniform(1.0, 5.0, len(mesh.tets))
    constants = lame(young, np.full(len(young), POISSON))
    field = waves(nodes.points)
    ours = float(np.vdot(field, stiffness(nodes, constants) @ field))
    element = skfem.ElementVector(skfem.ElementTetP1() if order == 1 else skfem.ElementTetP2())
    basis = skfem.Basis(skfem.MeshTet(mesh.vertices.T, mesh.tets.T), element, intorder=4)
    theirs = linear_elasticity(*(c[:, None] for c in constants.T)).assemble(basis)
    x = np.empty(basis.N)
    for i in range(3):
        dofs = np.unique(np.concatenate([basis.nodal_dofs[i], *([basis.edge_dofs[i]] if order == 2 else [])]))
        x[dofs] = waves(basis.doflocs[:, dofs].T)[:, i]
    assert ours == pytest.approx(x @ theirs @ x, rel=1e-10)


def test_stress_jumps_with_the_material() -> None:
    """Bars side by side, stretched alike: each has its own modulus times the strain, also where they meet."""
    mesh = box((4, 2, 2), (2.0, 1.0, 1.0))
    stiff = mesh.vertices[mesh.tets].mean(axis=1)[:, 1] > 0.5
    young = np.where(stiff, 300.0, 100.0)
    ends = Support(lambda p: (p[:, 0] < 1e-9) | (p[:, 0] > 2 - 1e-9), (True, False, False), lambda p: p * 0.01)
    found = solve(Problem(mesh, young, 0.0, supports=(ends,), balanced=True), 1e-12)
    seam = np.abs(mesh.vertices[:, 1] - 0.5) < 1e-9
    assert len(found.stress) == len(mesh.vertices) + seam.sum()
    np.testing.assert_array_equal(found.sites.vertex[: len(seam)], np.arange(len(seam)))
    np.testing.assert_array_equal(found.sites.vertex[found.sites.corners], mesh.tets)
    np.testing.assert_allclose(found.stress[found.sites.corners[stiff], 0], 3.0, rtol=1e-8)
    np.testing.assert_allclose(found.stress[found.sites.corners[~stiff], 0], 1.0, rtol=1e-8)
    np.testing.assert_allclose(found.stress[: len(seam)][seam, 0], 3.0, rtol=1e-8)
    assert found.error.relative < 1e-7
    graded = np.exp(mesh.vertices[mesh.tets].mean(axis=1)[:, 1] * 0.4)
    assert len(solve(Problem(mesh, graded, 0.0, supports=(ends,), balanced=True)).stress) == len(mesh.vertices)


def test_results_scale_and_agree() -> None:
    mesh = box((3, 3, 3), jitter=0.2)
    held = (Support(lambda p: p[:, 2] < 1e-9), Support(lambda p: p[:, 2] > 1 - 1e-9, displacement=(0.0, 0.0, 0.01)))
    found = solve(Problem(mesh, YOUNG, POISSON, 2.0, supports=held))
    twice = found.scaled(2.0)
    np.testing.assert_allclose(twice.von_mises, 2 * found.von_mises)
    assert twice.compliance == pytest.approx(4 * found.compliance)
    assert twice.reactions[1].force == pytest.approx(2 * found.reactions[1].force)
    assert found.compliance == pytest.approx(found.reactions[1].force[2] * 0.01, rel=1e-6)
    assert found.mass == pytest.approx(0.002)
    values, axes = found.principal()
    full = found.stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    np.testing.assert_allclose(
        np.einsum("nij,nkj->nik", full, axes), np.swapaxes(axes * values[..., None], 1, 2), atol=1e-12
    )
    assert (np.diff(values, axis=1) <= 1e-12).all()
    np.testing.assert_allclose(found.energy_density, (found.stress * found.strain * TWICE).sum(axis=1) / 2)
    assert von_mises(np.array([0, 0, 0, 1.0, 0, 0])) == pytest.approx(np.sqrt(3))
    assert found.max_displacement >= 0.01
    assert 0.003 < found.mean_displacement < 0.007


def test_mean_displacement_is_that_of_lengths_within_elements() -> None:
    """Of a block that is stretched, u = e (-nu x, -nu y, z): its mean length by Gauss's rule in the block."""
    mesh = box((2, 2, 2), (20.0, 20.0, 20.0))
    ends = Support(lambda p: p[:, 2] > 20 - 1e-9, (False, False, True), (0.0, 0.0, 0.2))
    found = solve(Problem(mesh, YOUNG, POISSON, supports=(*planes(), ends)), 1e-12)
    at, weight = np.polynomial.legendre.leggauss(60)
    x, y, z = np.meshgrid(*[10 * (at + 1)] * 3, indexing="ij")
    lengths = 0.01 * np.sqrt((POISSON * x) ** 2 + (POISSON * y) ** 2 + z**2)
    true = float(np.einsum("ijk,i,j,k->", lengths, weight, weight, weight)) / 8
    assert found.mean_displacement == pytest.approx(true, rel=2e-4)
    mean, off = mean_length(found.nodes, found.displacement)
    assert abs(mean - true) <= off < 1e-3 * true
    one = solve(Problem(mesh, YOUNG, POISSON, supports=(*planes(), ends), order=1), 1e-12)
    assert one.mean_displacement == pytest.approx(true, rel=2e-4)


def test_what_several_supports_hold_they_share() -> None:
    """Supports that overlap come to the load together, in force and in moment."""
    mesh = box((6, 2, 2), (3.0, 1.0, 1.0))
    supports = (
        Support(lambda p: p[:, 0] < 1e-9, name="end"),
        Support(lambda p: p[:, 0] < 1e-9, (False, False, True), name="the end again"),
        Support(lambda p: (p[:, 0] < 0.6) & (p[:, 2] < 1e-9), name="below"),
    )
    push = Force(lambda p: p[:, 0] > 3 - 1e-9, (0.0, 2.0, -1.0), name="push")
    found = solve(Problem(mesh, YOUNG, POISSON, supports=supports, loads=(push,)), 1e-11)
    (load,) = found.loads
    assert sum(r.force for r in found.reactions) == pytest.approx([0, -2, 1], abs=1e-9)
    assert sum(r.moment for r in found.reactions) == pytest.approx(-load.moment, abs=1e-9)
    assert load.force == pytest.approx([0, 2, -1])
    assert (load.area, load.centre[0]) == pytest.approx((1.0, 3.0))
    assert [r.area for r in found.reactions] == pytest.approx([1.0, 1.0, 0.5])
    alone = solve(Problem(mesh, YOUNG, POISSON, supports=supports[:1], loads=(push,)), 1e-11)
    assert alone.reactions[0].couple == pytest.approx([0.0, -3.0, -6.0], abs=1e-8)


@pytest.mark.parametrize("toward", [0, 2])
def test_moved_platens_balance(toward: int) -> None:
    """What moved supports call up in the elements next to them is larger than what they press with, by orders: the
    reactions balance to 1e-8 of themselves."""
    mesh = cylinder(1.0, 24.0, 3, 24)
    by = [0.0, 0.0, 0.0]
    by[toward] = 1.0
    moved = Support(lambda p: p[:, 2] > 24 - 1e-9, displacement=(by[0], by[1], by[2]))
    found = solve(Problem(mesh, 2000.0, 0.3, supports=(Support(lambda p: p[:, 2] < 1e-9), moved)))
    one, other = found.reactions
    size = float(np.linalg.norm(one.force))
    assert np.abs(one.force + other.force).max() < 1e-8 * size
    assert np.abs(one.moment + other.moment).max() < 1e-8 * size * 24
    assert found.residual <= 1e-8


def test_the_share_of_a_tetrahedron_below_a_level_is_that_of_points_in_it() -> None:
    values = np.random.default_rng(1).random((6, 4))
    values[0, 1] = values[0, 0]
    values[1] = 0.5, 0.5, 0.5, 0.9
    values[2] = 0.4, 0.4, 0.6, 0.6
    points = np.random.default_rng(2).dirichlet([1.0] * 4, 100_000)  # even in a tetrahedron
    for level in (0.2, 0.4, 0.55, 0.8):
        counted = (points @ values.T < level).mean(axis=0)
        np.testing.assert_allclose(share_below(values, level), counted, atol=0.006)
    assert percentile(np.arange(4.0), np.array([[0, 1, 2, 3]]), np.array([2.0]), 100) == pytest.approx(3, rel=1e-4)


@pytest.mark.parametrize("order", [1, 2])
def test_a_selection_covers_what_it_says_of_triangles_that_it_cuts(order: int) -> None:
    """Areas of strips, half spaces and a disk on a block of 10 x 8 x 4, none of whose edges lie where they end; the
    middle of a part of a side; and forces on nodes that are consistent, in force and moment."""
    mesh = box((7, 5, 3), (10.0, 8.0, 4.0))
    nodes = number(mesh.vertices, mesh.tets, order)
    boundary = surface(nodes)

    def area(where: object) -> float:
        return covered(where, nodes, boundary, "it").area  # type: ignore[arg-type]

    assert area(lambda p: np.abs(p[:, 0] - 3.1) < 0.4) == pytest.approx(0.8 * 24, rel=1e-6)
    assert area(lambda p: np.abs(p[:, 0] - 3.1) < 0.1) == pytest.approx(0.2 * 24, rel=1e-6)  # a seventh of a triangle
    assert area(lambda p: p[:, 0] + p[:, 1] + p[:, 2] < 3) == pytest.approx(3 * 4.5, rel=1e-6)
    assert area(lambda p: np.hypot(p[:, 0] - 5, p[:, 1] - 4) < 2) == pytest.approx(8 * np.pi, rel=2e-3)
    assert area(lambda p: np.hypot(p[:, 0] - 5, p[:, 1] - 4) > 9) == 0
    top = Facing(lambda p: (np.abs(p[:, 0] - 3.1) < 1.1) & (p[:, 2] > 3.9), (0, 0, 1))
    assert covered(top, nodes, boundary, "it").centre == pytest.approx([3.1, 4, 4], rel=1e-6)
    assert area(top) == pytest.approx(2.2 * 8, rel=1e-6)
    load = applied(Force(top, (0.0, 0.0, -6.0)), 0, nodes, boundary, np.ones(len(mesh.tets)))
    assert load.forces.sum(axis=0) == pytest.approx([0, 0, -6], abs=1e-12)
    assert np.cross(nodes.points, load.forces).sum(axis=0) == pytest.approx([-24, 18.6, 0], rel=1e-6)


def test_an_end_is_its_face_without_a_strip_of_the_sides() -> None:
    """What is near the end of a bar is that end; what is on the sides by itself, or much of them, is meant."""
    mesh = box((2, 2, 8), (2.0, 2.0, 8.0))
    nodes = number(mesh.vertices, mesh.tets, 2)
    boundary = surface(nodes)
    for where, true in (
        (lambda p: p[:, 2] > 7.9, 4.0),
        (lambda p: p[:, 2] > 7.0, 4.0 + 8.0),
        (lambda p: np.abs(p[:, 2] - 7.8) < 0.1, 8 * 0.2),
        (lambda p: (p[:, 2] > 7.9) | ((p[:, 0] > 1.6) & (np.abs(p[:, 2] - 4) < 0.2)), 4.0 + 0.8 + 0.32),
        (lambda p: (p[:, 2] > 7.9) & (p[:, 0] > 1.0), 2.0 + 4 * 0.1),
    ):
        assert covered(where, nodes, boundary, "it").area == pytest.approx(true, rel=2e-3)
