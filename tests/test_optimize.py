"""The loop on voxels: its solver against closed forms, its gains against a study by other code, and what it promises.

The study (voxels, a gyroid sheet of mean density .5 within .2-.8, compliance over that of the uniform lattice) was made
with assembled matrices and another solver, before this code: beam .564 by von Mises .5, .596 by 2, 2.76 by -1, .555 by
energy, .554 by optimality criteria; cylinder under a patch load .709, 2.04 (-1), .588; between bonded platens .995 by
von Mises, .805 by optimality criteria; frictionless 1, .770 from a biased start.
"""

from __future__ import annotations

import json
import re
from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from porelang.diagnostics import PoreError, fail
from porelang.optimize import elasticity, element, history, laws, loop, multigrid
from porelang.optimize.grid import Force, Grid, Platen, Problem, Support, Where
from porelang.optimize.record import Step
from porelang.optimize.rules import Answer, Energy, Frame, Optimum, Rule, VonMises
from porelang.optimize.spread import averaged, restored
from porelang.progress import watching
from porelang.unitcell.law import Law, power
from porelang.unitcell.moduli import young

Array = NDArray[np.float64]
TINY = 1e-6
STEEL = element.isotropic(200e3, 0.3)[None]
#: A gyroid sheet homogenised on 32^3 voxels: density, c11, c12, c44 for a solid of 1 MPa and nu .3.
SHEET = np.array([
    (0.2, 0.10126, 0.04664, 0.03055), (0.3, 0.16406, 0.07206, 0.05244), (0.4, 0.23787, 0.09903, 0.07931),
    (0.5, 0.32789, 0.13049, 0.11185), (0.6, 0.44237, 0.17048, 0.15122), (0.7, 0.58559, 0.22296, 0.19656),
    (0.8, 0.77041, 0.29764, 0.24982),
])  # fmt: skip
FOUND = Law(SHEET[:, 0], SHEET[:, 1:], np.zeros((7, 3)), 0.3)
LAW = laws.Lattice(FOUND, 1000.0)


def near(axis: int, at: float) -> Where:
    return lambda p: np.abs(p[:, axis] - at) < TINY


def both(*conditions: Where) -> Where:
    return lambda p: np.all([c(p) for c in conditions], axis=0)


def block(cells: tuple[int, int, int], size: float) -> Grid:
    return Grid(np.ones(cells), (0.0, 0.0, 0.0), (size, size, size))


def bar(platen: bool, fill: float = 1.0) -> Problem:
    """10 x 5 x 20 mm under 1 kN along z, free to spread."""
    grid = Grid(np.full((4, 2, 8), fill), (0.0, 0.0, 0.0), (2.5, 2.5, 2.5))
    held = (
        Support(near(2, 0), (False, False, True)),
        Support(near(0, 0), (True, False, False)),
        Support(near(1, 0), (False, True, False)),
    )
    load = Platen(near(2, 20), -1000.0) if platen else Force(near(2, 20), (0, 0, -1000.0))
    return Problem(grid, held, (load,))


def cantilever(across: int, length: float = 96.0, height: float = 12.0) -> Problem:
    size = height / across
    grid = block((round(length / size), max(2, across // 2), across), size)
    return Problem(grid, (Support(near(0, 0)),), (Force(near(0, length), (0, 0, -100.0)),))


def beam(across: int = 8) -> Problem:
    """The beam on three supports: 240 x 40 x 40 mm, pressed over 10 mm in the middle."""
    size = 40 / across
    grid = block((round(240 / size), across, across), size)
    held = (
        Support(both(near(2, 0), lambda p: p[:, 0] < 5 + TINY), (False, False, True)),
        Support(both(near(2, 0), lambda p: p[:, 0] > 235 - TINY), (False, False, True)),
        Support(both(near(2, 0), near(0, 0)), (True, True, True)),
    )
    return Problem(grid, held, (Force(both(near(2, 40), lambda p: np.abs(p[:, 0] - 120) < 5 + TINY), (0, 0, -1000.0)),))


def cylinder(kind: str, across: int = 8) -> Problem:
    """The specimen, r 75 mm and h 300 mm, on a fixed base; 10 kN on a patch of 25 mm, or by a platen."""
    size = 150 / across
    inside = lambda p: np.maximum(np.hypot(p[:, 0], p[:, 1]) - 75, np.abs(p[:, 2]) - 150)  # noqa: E731
    grid = Grid.of(inside, (-75, -75, -150), (75, 75, 150), size)
    base, top = near(2, -150), near(2, 150)
    if kind == "patch":
        patch = both(top, lambda p: np.hypot(p[:, 0], p[:, 1]) < 25)
        return Problem(grid, (Support(base),), (Force(patch, (0, 0, -1e4)),))
    if kind == "bonded":
        return Problem(grid, (Support(base),), (Platen(top, -1e4, bonded=True),))
    held = (
        Support(base, (False, False, True)),
        Support(both(base, near(0, 0), near(1, 0)), (True, True, False)),
        Support(both(base, near(0, size), near(1, 0)), (False, True, False)),
    )
    return Problem(grid, held, (Platen(top, -1e4),))


def run(
    problem: Problem, rule: Rule, most: int, start: Array | None = None, cell: float = 5.0, until: float = 1e-4
) -> loop.Outcome:
    return loop.iterate(loop.Homogenised(problem, LAW), rule, loop.Plan(0.5, 0.2, 0.8, cell, until, most), start)


def solved(problem: Problem, bases: Array = STEEL, tolerance: float = 1e-10) -> elasticity.Solution:
    model = elasticity.prepare(problem)
    return elasticity.solve(model, np.ones((len(problem.grid.weights), len(bases))), bases, tolerance=tolerance)


# the solver


@pytest.mark.parametrize("platen", [False, True])
def test_a_bar_under_a_force_is_exact(platen: bool) -> None:
    found = solved(bar(platen))
    shortened = 1000 * 20 / (200e3 * 50)
    assert found.compliance == pytest.approx(1000 * shortened, rel=1e-8)
    assert found.stress[:, 2] == pytest.approx(-20, rel=1e-7)
    assert found.von_mises == pytest.approx(20, rel=1e-7)
    assert found.energy == pytest.approx(20**2 / 2 / 200e3, rel=1e-7)
    assert found.displacement[-1, 0, -1] == pytest.approx([0.3 * 10 * 1e-4, 0, -shortened], abs=1e-10)
    assert found.reaction == pytest.approx([0, 0, 1000] if not platen else [0, 0, 0], abs=1e-4)
    assert found.noise < 1e-6


def test_a_partly_filled_voxel_counts_by_its_share() -> None:
    assert solved(bar(True, 0.5)).compliance == pytest.approx(2 * solved(bar(True)).compliance, rel=1e-7)
    assert bar(True, 0.5).grid.volume == 500


def test_an_emptier_voxel_takes_less_of_a_force() -> None:
    """Shares that differ across a bar change nothing of its stress, if the force is spread as they are."""
    grid = bar(False).grid
    fill = np.ones(grid.shape)
    fill[0] = 0.25
    problem = Problem(Grid(fill, grid.origin, grid.spacing), bar(False).supports, bar(False).loads)
    area = 50 * (3 + 0.25) / 4
    assert solved(problem).stress[:, 2] == pytest.approx(-1000 / area, rel=1e-7)


def test_a_step_of_the_density_saves_what_it_says() -> None:
    """Against two solutions, for a law of three constants, a force and a platen."""
    for problem in (cantilever(4), bar(True)):
        analysis = loop.Homogenised(problem, LAW, 1e-11)
        rng = np.random.default_rng(11)
        density = rng.uniform(0.3, 0.7, len(problem.grid.weights))
        step = 1e-4 * rng.uniform(-1, 1, len(density))
        answer = analysis.solve(density, None)
        less, more = (analysis.solve(density + s * step, None).compliance for s in (-1, 1))
        assert (more - less) / 2 == pytest.approx(-(answer.saved * step) @ problem.grid.weights, rel=1e-4)
        assert (answer.energy @ problem.grid.weights) * 2 == pytest.approx(answer.compliance, rel=1e-8)


def test_what_rules_look_at() -> None:
    """Of numbers that need no solution; what all rules agree on is stationary."""
    frame = Frame(0.5, 0.2, 0.8, np.ones(2), lambda values: values)
    density = np.array([0.4, 0.6])
    answer = Answer(1.0, 1.0, np.array([4.0, 6.0]), np.array([7.0, 7.0]), np.array([3.0, 1.0]), 0.0)
    assert Energy().driver(density, answer, frame).tolist() == [10, 10]
    assert Energy().next(density, answer, frame) == pytest.approx(density)
    assert Optimum().next(density, answer, frame) == pytest.approx(density)
    assert VonMises(0.2).next(density, answer, frame) == pytest.approx([0.6, 0.4])
    keen = Answer(1.0, 1.0, np.array([0.4, 2.4]), np.array([1.0, 9.0]), np.ones(2), 0.0)  # u = 1, 4
    assert Energy(0.5).next(density, keen, frame) == pytest.approx([0.25, 0.75])  # .4 : .6 * 2
    assert Optimum(move=0.05).next(density, keen, frame) == pytest.approx([0.35, 0.65])


def test_three_constants_make_the_same_as_one_tensor() -> None:
    c11, c12, c44 = STEEL[0][0, 0], STEEL[0][0, 1], STEEL[0][3, 3]
    model = elasticity.prepare(cantilever(4))
    count = len(model.problem.grid.weights)
    apart = elasticity.solve(model, np.tile([c11, c12, c44], (count, 1)), LAW.bases, tolerance=1e-10)
    assert apart.compliance == pytest.approx(solved(cantilever(4)).compliance, rel=1e-8)
    assert apart.shares @ [c11, c12, c44] / 2 == pytest.approx(apart.energy, rel=1e-9)


def test_a_cantilever_bends_as_timoshenko_says() -> None:
    """Bricks are too stiff by about the square of their size: two sizes show the rate, and together the value."""
    force, length, height = 100.0, 96.0, 12.0
    found = []  # with nu = 0, as a clamp would hold the sides too
    for across in (4, 8):
        problem = cantilever(across)
        width = problem.grid.shape[1] * problem.grid.spacing[1]
        bent = force * length**3 / (3 * 200e3 * width * height**3 / 12)
        sheared = force * length / (5 / 6 * 200e3 / 2 * width * height)
        found.append(solved(problem, element.isotropic(200e3, 0.0)[None]).compliance / (force * (bent + sheared)))
    assert 0.93 < found[0] < found[1] < 1
    assert found[1] + (found[1] - found[0]) / 3 == pytest.approx(1, abs=0.002)


def test_the_solver_agrees_with_a_factorisation() -> None:
    """Of an uneven grid with voids and densities, solved directly from matrices that are put together here."""
    rng = np.random.default_rng(3)
    fill = np.ones((13, 6, 9))
    fill[4:9, 2:4, 2:6] = 0
    fill[12] = 0.3
    grid = Grid(fill, (1.0, 2.0, 3.0), (1.0, 1.5, 0.75))
    problem = Problem(grid, (Support(near(0, 1.0)),), (Force(near(0, 14.0), (3.0, -2.0, 5.0)),))
    model = elasticity.prepare(problem)
    weights = rng.uniform(0.1, 2, (len(grid.weights), 1))
    found = elasticity.solve(model, weights, STEEL, tolerance=1e-11)

    count = 14 * 7 * 10
    whole = np.zeros((3 * count, 3 * count))
    one = element.stiffness(STEEL[0], np.array(grid.spacing))
    for (i, j, k), w in zip(np.argwhere(grid.mask), weights[:, 0] * fill[grid.mask], strict=True):
        nodes = [((i + a) * 7 + j + b) * 10 + k + c for a, b, c in element.CORNERS]
        dofs = (3 * np.array(nodes)[:, None] + np.arange(3)).ravel()
        whole[np.ix_(dofs, dofs)] += w * one
    forces = np.zeros((14, 7, 10, 3))
    for j in range(6):
        for k in range(9):
            forces[13, j : j + 2, k : k + 2] += np.array([3.0, -2.0, 5.0]) / 54 / 4
    forces[0] = 0
    free = (np.diag(whole) > 0) & (np.arange(3 * count) >= 3 * 70)
    direct = np.zeros(3 * count)
    direct[free] = np.linalg.solve(whole[np.ix_(free, free)], forces.ravel()[free])
    assert np.abs(found.displacement.ravel() - direct).max() < 1e-8 * np.abs(direct).max()
    assert found.iterations < 32
    assert found.reaction == pytest.approx([-3, 2, -5], abs=1e-7)
    assert multigrid.halvings(model.cells) > 0


def test_a_solution_goes_on_from_another() -> None:
    model = elasticity.prepare(beam())
    weights = np.ones((len(model.problem.grid.weights), 1))
    cold = elasticity.solve(model, weights, STEEL)
    assert cold.iterations < 12
    assert elasticity.solve(model, 1.01 * weights, STEEL, cold.state).iterations < cold.iterations


@pytest.mark.parametrize(
    ("supports", "motion"),
    [
        ((), "move along x"),
        ((Support(near(2, 0), (False, False, True)),), "move along x, move along y and turn about z"),
        ((Support(both(near(0, 0), near(1, 0), near(2, 0))),), "turn about"),
    ],
)
def test_what_can_move_is_named(supports: tuple[Support, ...], motion: str) -> None:
    with pytest.raises(PoreError, match="E190") as caught:
        elasticity.prepare(Problem(block((4, 2, 2), 1.0), supports, (Force(near(0, 4), (1, 0, 0)),)))
    assert motion in str(caught.value)


def test_a_loose_piece_is_named() -> None:
    fill = np.ones((5, 2, 2))
    fill[3] = 0
    problem = Problem(Grid(fill, (0, 0, 0), (1, 1, 1)), (Support(near(0, 0)),), (Force(near(0, 5), (1, 0, 0)),))
    with pytest.raises(PoreError, match=r"E190.*a piece of the part round \(4.5, 1, 1\)"):
        elasticity.prepare(problem)


def test_what_selects_nothing_is_named() -> None:
    grid, held = block((4, 2, 2), 1.0), (Support(near(0, 0)),)
    for problem in (
        Problem(grid, (Support(near(0, -3), name="the clamp"),), (Force(near(0, 4), (1, 0, 0)),)),
        Problem(grid, held, (Force(near(0, 9), (1, 0, 0)),)),
        Problem(grid, held, (Force(near(0, 4), (0, 0, 0)),)),
        Problem(grid, held, (Platen(near(0, 4), 1.0, 0), Force(near(0, 4), (1, 0, 0)))),
        Problem(Grid(np.zeros((2, 2, 2)), (0, 0, 0), (1, 1, 1)), held, ()),
    ):
        with pytest.raises(PoreError, match="E191"):
            elasticity.prepare(problem)


def test_what_does_not_converge_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multigrid, "MOST_ITERATIONS", 2)
    with pytest.raises(PoreError, match="E194"):
        solved(cantilever(8))


# laws, averages, means


def test_a_law_passes_through_its_constants_and_knows_its_slope() -> None:
    at = SHEET[:, 0]
    assert LAW.weights(at) == pytest.approx(1000 * SHEET[:, 1:], rel=1e-9)
    for law in (LAW, laws.Power(STEEL[0], 0.754, 1.49)):
        middle = np.linspace(0.21, 0.79, 31)
        step = (law.weights(middle + 1e-6) - law.weights(middle - 1e-6)) / 2e-6
        assert law.slopes(middle) == pytest.approx(step, rel=1e-4)


def test_the_fit_of_a_range_says_its_error() -> None:
    """The figures of the study: .754 rho^1.49 over .2-.8; on .2-.5 alone it is a quarter low at .8."""
    stiff = FOUND.young(SHEET[:, 0])
    fit = power(SHEET[:, 0], stiff)
    assert (fit.factor, fit.exponent) == (pytest.approx(0.754, rel=0.05), pytest.approx(1.49, abs=0.05))
    assert 0.05 < fit.miss < 0.15
    fit = power(SHEET[:4, 0], stiff[:4])
    assert fit.factor * 0.8**fit.exponent / stiff[-1] == pytest.approx(0.75, abs=0.1)


def test_laws_that_are_none() -> None:
    for constants in (SHEET[::-1, 1:] * [1, 5, 1], SHEET[:, 1:] * [1, 1, 0]):
        with pytest.raises(PoreError, match="E192"):
            laws.Lattice(Law(SHEET[:, 0], constants, np.zeros((7, 3)), 0.3), 1.0)
    with pytest.raises(PoreError, match=r"E192.*does not rise"):
        laws.Thickness(np.array([0.1, 0.5, 0.4]), np.array([0.1, 0.2, 0.3]))


def test_a_law_knows_its_solid_and_its_turn() -> None:
    """The modulus along z of a lattice that is turned is that along what came there; a stiffer solid, a stiffer law."""
    stiff = 1000 * FOUND.stiffness(0.5)
    axis = np.array([1.0, 1.0, 1.0]) / 3**0.5
    across = np.array([1.0, -1.0, 0.0]) / 2**0.5
    turn = np.stack([across, np.cross(axis, across), axis])  # 111 comes to lie along z
    law = laws.Lattice(FOUND, np.array([1000.0, 2000.0]), turn)
    first, second = np.einsum("mk,kij->mij", law.weights(np.full(2, 0.5)), law.bases)
    assert young(first, [0, 0, 1]) == pytest.approx(young(stiff, [1, 1, 1]))
    assert young(first, turn @ [0, 0, 1]) == pytest.approx(young(stiff, [0, 0, 1]))
    assert second == pytest.approx(2 * first)


def test_thickness_and_density_are_inverse() -> None:
    law = laws.Thickness(np.array([0.2, 0.3, 0.5, 0.8]), np.array([0.31, 0.46, 0.77, 1.2]))
    density = np.linspace(0.2, 0.8, 61)
    assert law.density(law.thickness(density)) == pytest.approx(density, abs=1e-12)
    assert law.thickness(np.array([0.3])) == pytest.approx(0.46)


def test_an_average_is_that_of_its_surroundings() -> None:
    """Against the sums themselves; a constant stays, and the void has no weight."""
    rng = np.random.default_rng(5)
    fill = rng.uniform(0.2, 1, (6, 5, 4))
    fill[2, 1:3] = 0
    grid = Grid(fill, (0, 0, 0), (1.0, 1.2, 0.9))
    values = rng.uniform(0, 1, len(grid.weights))
    apart = np.linalg.norm(grid.centres[:, None] - grid.centres, axis=2)
    weights = np.maximum(0, 1 - apart / 2.5) * grid.weights
    average = averaged(grid, 2.5)
    assert average(values) == pytest.approx(weights @ values / weights.sum(1), rel=1e-10)
    assert average(np.full_like(values, 3.0)) == pytest.approx(3.0, rel=1e-14)
    assert averaged(grid, 0.8)(values) is values


def test_the_mean_is_restored_to_rounding() -> None:
    rng = np.random.default_rng(7)
    wanted, weights = rng.uniform(-2, 3, 500), rng.uniform(0.1, 1, 500)
    low, high = np.full(500, 0.2), np.full(500, 0.8)
    density = restored(lambda s: wanted + s, low, high, weights, 0.45)
    assert np.average(density, weights=weights) == pytest.approx(0.45, abs=1e-14)
    assert density.min() >= 0.2
    assert density.max() <= 0.8
    with pytest.raises(PoreError, match=r"E192.*0.2 to 0.8"):
        restored(lambda s: wanted + s, low, high, weights, 0.9)


# the loop


def test_bending_gains_what_the_study_found() -> None:
    problem = beam()
    assert run(problem, VonMises(0.5), 1).gain == pytest.approx(0.564, abs=0.02)
    assert run(problem, Energy(), 3).gain == pytest.approx(0.555, abs=0.02)
    assert run(problem, Optimum(), 4).gain == pytest.approx(0.554, abs=0.02)
    strong = run(problem, VonMises(2.0), 1)
    assert strong.gain == pytest.approx(0.596, abs=0.03)
    assert strong.gain > run(problem, VonMises(0.5), 1).gain


def test_the_reversed_sign_is_worse_and_not_kept() -> None:
    found = run(beam(), VonMises(-1.0), 1)
    assert found.steps[1].compliance / found.steps[0].compliance == pytest.approx(2.76, abs=0.15)
    assert found.best == 0
    assert np.ptp(found.density) == 0


def test_stress_per_density_falls_while_the_peak_rises() -> None:
    """In bending the macroscopic peak rises 10-20 %, and stress per density falls 30 %."""
    found = run(beam(), Energy(), 3)
    first, best = found.steps[0], found.steps[found.best]
    assert 1.02 < best.max_von_mises / first.max_von_mises < 1.3
    assert best.stress_per_density / first.stress_per_density == pytest.approx(0.7, abs=0.08)
    assert all(step.porosity == pytest.approx(0.5, abs=1e-13) for step in found.steps)
    assert 0.2 <= found.density.min() < 0.21
    assert 0.79 < found.density.max() <= 0.8


def test_a_patch_load_gains_what_the_study_found() -> None:
    """The study does not say how large its patch was: 25 of 75 mm gives its figures by von Mises to .01."""
    problem = cylinder("patch")
    assert run(problem, VonMises(0.5), 1, cell=20).gain == pytest.approx(0.709, abs=0.02)
    assert run(problem, Optimum(), 15, cell=20).gain == pytest.approx(0.59, abs=0.04)
    reversed_ = run(problem, VonMises(-1.0), 1, cell=20)
    assert reversed_.steps[1].compliance / reversed_.steps[0].compliance == pytest.approx(2.04, abs=0.15)


def test_between_bonded_platens_stress_gains_nothing_and_the_optimum_does() -> None:
    problem = cylinder("bonded")
    assert run(problem, VonMises(0.5), 1, cell=20).gain == pytest.approx(0.995, abs=0.01)
    assert run(problem, Optimum(), 20, cell=20).gain == pytest.approx(0.805, abs=0.02)
    core = run(problem, Optimum(), 4, start=_core(problem.grid), cell=20)
    assert core.gain < 1
    assert core.steps[core.best].compliance < 0.83 * run(problem, Optimum(), 0, cell=20).steps[0].compliance


def test_where_the_stress_is_uniform_it_says_so_and_stops() -> None:
    problem = cylinder("free")
    for rule in (VonMises(), Energy(), Optimum()):
        found = run(problem, rule, 15, cell=20)
        assert found.reason == "uniform"
        assert len(found.steps) == 1
        assert found.steps[0].spread < 1e-4
    uniform = found.steps[0].compliance
    biased = run(problem, Optimum(), 6, start=_core(problem.grid), cell=20)
    assert biased.steps[biased.best].compliance / uniform == pytest.approx(0.77, abs=0.03)


def _core(grid: Grid) -> Array:
    """Dense in the middle of the cylinder, light at its skin."""
    return 0.5 + 0.01 * (53 - np.hypot(*grid.centres[:, :2].T))


def test_it_ends_where_it_settles_and_keeps_the_best() -> None:
    found = run(cantilever(8), Energy(), 15, until=0.005)
    assert found.reason == "settled"
    assert len(found.steps) <= 8
    assert found.best == min(range(len(found.steps)), key=lambda i: found.steps[i].compliance)
    last = found.steps[-1]
    assert last.change is not None
    assert abs(last.change) < 0.005


class Sour(loop.Homogenised):
    """A part that gets worse at every step but the first."""

    calls = 0

    def solve(self, density: Array, state: Array | None) -> loop.Answer:
        answer = super().solve(density, state)
        self.calls += 1
        factor = 1.0 if self.calls == 1 else 2.0**self.calls
        return loop.Answer(
            factor * answer.compliance, answer.largest, answer.energy, answer.saved, answer.von_mises, 0.0
        )


def test_it_ends_where_it_rises_twice() -> None:
    found = loop.iterate(Sour(cantilever(4), LAW), Energy(), loop.Plan(0.5, 0.2, 0.8, 3.0))
    assert (found.reason, found.best, len(found.steps)) == ("rising", 0, 3)


def test_a_damped_step_is_a_part_of_one() -> None:
    whole = run(cantilever(4), VonMises(0.3), 1, cell=3)
    analysis = loop.Homogenised(cantilever(4), LAW)
    half = loop.iterate(analysis, VonMises(0.3), loop.Plan(0.5, 0.2, 0.8, 3.0, 1e-4, 1, damping=0.5))
    assert half.density - 0.5 == pytest.approx((whole.density - 0.5) / 2, abs=1e-12)


@pytest.mark.parametrize(
    "plan",
    [
        loop.Plan(0.9, 0.2, 0.8, 5.0), loop.Plan(0.5, 0.8, 0.2, 5.0), loop.Plan(0.5, 0.0, 0.8, 5.0),
        loop.Plan(0.5, 0.2, 0.8, 5.0, damping=0.0), loop.Plan(0.5, 0.2, 0.8, 5.0, most=-1),
        loop.Plan(0.5, 0.2, 0.8, 5.0, until=-1.0), loop.Plan(0.5, 0.2, 0.8, 5.0, until=float("nan")),
    ],
)  # fmt: skip
def test_plans_that_cannot_be(plan: loop.Plan) -> None:
    with pytest.raises(PoreError, match="E192"):
        loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), plan)


# the record

PLAN = loop.Plan(0.5, 0.2, 0.8, 3.0, 1e-9, 4)


def test_a_run_gone_on_with_is_equal_to_the_bit(tmp_path: Path) -> None:
    whole = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), PLAN, folder=tmp_path / "whole")
    for stop in (1, 3):
        folder, seen = tmp_path / f"cut {stop}", []
        with pytest.raises(CancelledError), watching(cancel=lambda seen=seen, stop=stop: len(seen) >= stop):  # type: ignore[misc]
            loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), PLAN, folder=folder, told=seen.append)
        assert len(seen) == stop
        again = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), PLAN, folder=folder, resume=True)
        assert again.steps == whole.steps
        assert np.array_equal(again.density, whole.density)
        assert {p.name: p.read_bytes() for p in folder.iterdir()} == {
            p.name: p.read_bytes() for p in (tmp_path / "whole").iterdir()
        }
    finished = loop.iterate(
        loop.Homogenised(cantilever(4), LAW), Energy(), PLAN, folder=tmp_path / "whole", resume=True
    )
    assert finished.steps == whole.steps
    assert np.array_equal(finished.density, whole.density)
    assert sorted(p.name for p in (tmp_path / "whole").glob("state*")) == ["state-004.npz"]


def test_a_record_can_be_replayed(tmp_path: Path) -> None:
    """Each density on record has, solved alone, the compliance that stands beside it."""
    analysis = loop.Homogenised(cantilever(4), LAW)
    loop.iterate(analysis, Energy(), PLAN, folder=tmp_path)
    head, *lines = [json.loads(line) for line in (tmp_path / "loop.jsonl").read_text().splitlines()]
    assert head["rule"] == "energy, exponent 0.5"
    for line in lines:
        with np.load(tmp_path / line["step"]["file"]) as file:
            assert analysis.solve(file["density"], None).compliance == pytest.approx(line["compliance"], rel=1e-6)


def test_a_record_is_gone_on_with_only_as_it_was_begun(tmp_path: Path) -> None:
    begun = loop.Homogenised(cantilever(4), LAW)
    loop.iterate(begun, Energy(), loop.Plan(0.5, 0.2, 0.8, 3.0, 1e-9, 1), folder=tmp_path)
    with pytest.raises(PoreError, match=r"E195.*holds the record"):
        loop.iterate(begun, Energy(), PLAN, folder=tmp_path)
    with pytest.raises(PoreError, match=r"E195.*rule was different"):
        loop.iterate(begun, VonMises(), PLAN, folder=tmp_path, resume=True)
    other = loop.Homogenised(cantilever(4), laws.Power(STEEL[0], 0.754, 1.49))
    with pytest.raises(PoreError, match=r"E195.*its law was different"):
        loop.iterate(other, Energy(), PLAN, folder=tmp_path, resume=True)
    assert len(loop.iterate(begun, Energy(), PLAN, folder=tmp_path, resume=True).steps) == 5  # more steps are welcome
    (tmp_path / "loop.jsonl").write_bytes(b"?")
    with pytest.raises(PoreError, match=r"(?s)E195.*cannot go on.*begin anew"):
        loop.iterate(begun, Energy(), PLAN, folder=tmp_path, resume=True)


@pytest.mark.parametrize("how", ["cut", "gone", "line"])
def test_a_damaged_record_is_gone_on_with_from_the_last_step_that_is_whole(tmp_path: Path, how: str) -> None:
    begun = loop.Homogenised(cantilever(4), LAW)
    whole = loop.iterate(begun, Energy(), PLAN, folder=tmp_path)
    step, lines = tmp_path / "step-002.npz", (tmp_path / "loop.jsonl").read_text().splitlines(True)
    kept = [p.read_bytes() for p in (tmp_path / "step-000.npz", tmp_path / "step-001.npz")]
    (tmp_path / "mine.npz").write_bytes(b"mine")
    if how == "cut":
        step.write_bytes(step.read_bytes()[:100])
    elif how == "gone":
        step.unlink()
    else:
        (tmp_path / "loop.jsonl").write_text("".join(lines[:3]) + lines[3][:50])
    seen: list[Step] = []
    again = loop.iterate(begun, Energy(), PLAN, folder=tmp_path, resume=True, told=seen.append)
    assert [s.number for s in seen] == [2, 3, 4]
    assert ("line 4" if how == "line" else "step-002.npz") in again.missed
    assert "from step 2 on" in again.missed
    assert [s.compliance for s in again.steps] == pytest.approx([s.compliance for s in whole.steps], rel=1e-6)
    assert kept == [p.read_bytes() for p in (tmp_path / "step-000.npz", tmp_path / "step-001.npz")]
    assert loop.iterate(begun, Energy(), PLAN, folder=tmp_path, resume=True).missed == ""
    assert (tmp_path / "mine.npz").exists()


def test_a_state_that_is_lost_costs_time_and_no_step(tmp_path: Path) -> None:
    begun = loop.Homogenised(cantilever(4), LAW)
    loop.iterate(begun, Energy(), PLAN, folder=tmp_path)
    (tmp_path / "state-004.npz").write_bytes(b"?")
    found = loop.iterate(begun, Energy(), replace(PLAN, most=5), folder=tmp_path, resume=True)
    assert (len(found.steps), found.missed) == (6, "state-004.npz is not what was written")


def test_a_loop_begins_anew_and_removes_its_own_files_alone(tmp_path: Path) -> None:
    begun = loop.Homogenised(cantilever(4), LAW)
    loop.iterate(begun, Energy(), PLAN, folder=tmp_path)
    (tmp_path / "step-one.npz").write_bytes(b"mine")
    other = loop.Homogenised(cantilever(4), laws.Power(STEEL[0], 0.754, 1.49))
    found = loop.iterate(other, Energy(), replace(PLAN, most=1), folder=tmp_path, anew=True)
    assert len(found.steps) == 2
    assert {p.name for p in tmp_path.iterdir()} == {
        "loop.jsonl", "step-000.npz", "step-001.npz", "state-001.npz", "step-one.npz",
    }  # fmt: skip

    class Failing(loop.Homogenised):
        def solve(self, density: Array, state: Array | None) -> loop.Answer:
            raise fail("E194", "no")

    with pytest.raises(PoreError, match="E194"):  # nothing to put in its place
        loop.iterate(Failing(cantilever(4), LAW), Energy(), PLAN, folder=tmp_path, anew=True)
    assert len((tmp_path / "loop.jsonl").read_text().splitlines()) == 3


class Pulled(loop.Homogenised):
    """A cantilever whose end is moved by 1 mm: the work is the stiffness, in N mm."""

    def solve(self, density: Array, state: Array | None) -> loop.Answer:
        answer = super().solve(density, state)
        return replace(answer, compliance=1e6 / answer.compliance, under="displacements")


def test_under_displacements_more_work_is_stiffer() -> None:
    """The same part under a force and under the displacement of its end is the same design."""
    plan = loop.Plan(0.5, 0.2, 0.8, 3.0, 0.005, 15)
    pushed = loop.iterate(loop.Homogenised(cantilever(8), LAW), Energy(), plan)
    pulled = loop.iterate(Pulled(cantilever(8), LAW), Energy(), plan)
    assert (pulled.reason, pulled.best) == (pushed.reason, pushed.best)
    assert pulled.best > 0
    assert pulled.gain == pytest.approx(pushed.gain)
    assert np.array_equal(pulled.density, pushed.density)
    assert pulled.steps[pulled.best].compliance == max(s.compliance for s in pulled.steps)
    assert "more is stiffer" in history.table(pulled.steps, pulled.best)


class Known(loop.Homogenised):
    """What a mesh of the real lattice would state: an error of the compliance, the noise of its energies, and what
    another mesh may differ by."""

    error, noise, apart = 0.3, 0.02, 0.02

    def solve(self, density: Array, state: Array | None) -> loop.Answer:
        return replace(super().solve(density, state), error=self.error, noise=self.noise, apart=self.apart)


def test_what_varies_within_the_noise_is_uniform_whatever_the_error_of_the_stiffness() -> None:
    """What all of a mesh errs by does not tell its cells apart, nor two steps."""
    start = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), replace(PLAN, most=0)).steps[0]
    assert start.spread > 0.3
    analysis = Known(cantilever(4), LAW)
    analysis.noise = start.spread + 0.01
    assert loop.iterate(analysis, Energy(), PLAN).reason == "uniform"
    analysis.noise, analysis.error = 1e-3, start.spread + 1.0
    found = loop.iterate(analysis, Energy(), PLAN)
    assert len(found.steps) > 1
    assert found.best > 0


def test_a_gain_within_the_noise_is_none() -> None:
    analysis = Known(cantilever(4), LAW)
    plan = replace(PLAN, damping=0.01, most=2)
    small = loop.iterate(analysis, Energy(), plan)
    assert 1 - min(s.compliance for s in small.steps) / small.steps[0].compliance == pytest.approx(0.01, abs=0.0099)
    assert small.best == 0
    analysis.apart = 1e-5
    found = loop.iterate(analysis, Energy(), plan)
    assert found.best == 2
    assert loop.ratio_error(found.steps[0], found.steps[2]) == pytest.approx(2**0.5 * 1e-5)  # each strays by itself


def test_a_record_without_what_meshes_differ_by_is_gone_on_with(tmp_path: Path) -> None:
    begun = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), replace(PLAN, most=1), folder=tmp_path)
    path = tmp_path / "loop.jsonl"
    path.write_text(path.read_text().replace(', "apart": null', ""))
    again = loop.iterate(
        loop.Homogenised(cantilever(4), LAW), Energy(), replace(PLAN, most=1), folder=tmp_path, resume=True
    )
    assert again.steps == begun.steps
    assert not again.missed


def test_a_later_step_that_fails_keeps_the_best_so_far(tmp_path: Path) -> None:
    class Brittle(loop.Homogenised):
        calls = 0

        def solve(self, density: Array, state: Array | None) -> loop.Answer:
            self.calls += 1
            if self.calls == 3:
                raise fail("E188", "it fell apart")
            return super().solve(density, state)

    found = loop.iterate(Brittle(cantilever(4), LAW), Energy(), PLAN, folder=tmp_path)
    assert (found.reason, len(found.steps), found.best) == ("failed", 2, 1)
    assert [d.code for d in found.failed] == ["E188"]
    whole = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), PLAN)
    again = loop.iterate(loop.Homogenised(cantilever(4), LAW), Energy(), PLAN, folder=tmp_path, resume=True)
    assert [s.compliance for s in again.steps] == [s.compliance for s in whole.steps]


def test_python_of_its_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parent.parent / "docs" / "optimize.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(code, {})
    assert "settled" in capsys.readouterr().out
    assert (tmp_path / "loop" / "history.png").stat().st_size > 5000


def test_the_history_is_a_table_and_a_picture() -> None:
    found = run(cantilever(4), Energy(), 2, cell=3)
    lines = history.table(found.steps, found.best).splitlines()
    assert len(lines) == 2 + len(found.steps)
    assert [line.count("|") for line in lines] == [11] * len(lines)
    assert sum("*" in line for line in lines) == 1
    picture = np.asarray(history.plot(found.steps, found.best))
    assert picture.shape == (720, 1200, 3)
    assert all((picture == colour).all(-1).sum() > 500 for _, _, colour in history._CURVES[:1])
