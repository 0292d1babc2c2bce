"""The optimum in the command: a study posed on voxels against closed forms, the law of the lattice at hand, and both
together with the solution in tetrahedra."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.backends.numpy import NumpyField
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.optimize import adapting as adapted
from porelang.optimize import element, laws, loop, promise
from porelang.optimize.adapting import adapting
from porelang.optimize.grid import Force, Grid, Problem
from porelang.optimize.posed import posed
from porelang.optimize.rules import Answer, Energy, Given, Optimum
from porelang.tasks.study.asked import Question, question
from porelang.unitcell.hexahedron import isotropic
from porelang.unitcell.law import law, power

Array = NDArray[np.float64]

E, NU = 1000.0, 0.3
G = E / 2 / (1 + NU)
BEAM = "let part = box([120mm, 12mm, 12mm])\nlet s = {study}\npart"
PLAN = loop.Plan(0.5, 0.3, 0.7, 20.0)
#: A cantilever of three cells, in coarse elements.
TEXT = """param t: field = 0 "offset of the network"
let bar = box([60mm, 20mm, 20mm])
let lattice = gyroid(20mm) - t & bar
let s = study(lattice, fix=x < -29.9mm, load=force(x > 29.9mm, [0N, 0N, -10N]), E=1GPa, nu=0.3, size=3mm, order=1)
out part = lattice
"""


def asked(text: str) -> Question:
    design = porelang.compile(text).design()
    (task,) = design.program.studies.values()
    return question(design.formula(*task.args).taken)


def compliance(study: str, size: float = 2.0, low: tuple[float, ...] = (-60, -6, -6)) -> float:
    """Of a solid bar, on voxels."""
    found = asked(BEAM.format(study=study))
    field = NumpyField(found.part, "f64")
    grid = Grid.of(lambda p: np.asarray(field.at(p)), low, -np.array(low), size)
    solid = laws.Power(element.isotropic(E, NU))
    return loop.Homogenised(posed(found, grid), solid).solve(np.ones(len(grid.weights)), None).compliance


def test_a_bar_between_platens_that_let_it_slide_is_exact() -> None:
    assert compliance("compress(part, force=2kN, axis=x, E=1GPa, nu=0.3)") == pytest.approx(
        2000**2 * 120 / (E * 144), rel=1e-5
    )


def test_bonded_platens_hold_it() -> None:
    free, held = (
        compliance(f'compress(part, force=2kN, axis=x, platens="{p}", E=1GPa, nu=0.3)')
        for p in ("frictionless", "bonded")
    )
    assert 0.95 * free < held < 0.999 * free


INERTIA, SHEARED = 12**4 / 12, G * 144 * 5 / 6  # kappa 5/6 (Timoshenko, for a rectangle)


@pytest.mark.parametrize(
    ("study", "beam"),
    [
        (
            'bend(part, force=10N, axis=x, toward=-z, supports="cantilever", E=1GPa, nu=0.3)',
            10**2 * (120**3 / 3 / E / INERTIA + 120 / SHEARED),
        ),
        (
            "bend(part, force=10N, axis=x, toward=-z, span=108mm, pads=4mm, E=1GPa, nu=0.3, size=2mm)",
            10**2 * (108**3 / 48 / E / INERTIA + 108 / 4 / SHEARED),
        ),
        (
            "bend(part, force=10N, axis=x, toward=y, span=108mm, pads=4mm, E=1GPa, nu=0.3, size=2mm)",
            10**2 * (108**3 / 48 / E / INERTIA + 108 / 4 / SHEARED),
        ),
        (
            "shear(part, force=10N, axis=x, toward=y, E=1GPa, nu=0.3)",
            10**2 * (120**3 / 12 / E / INERTIA + 120 / SHEARED),
        ),
        # 0.1406 a^4 for a square (Timoshenko and Goodier, Theory of Elasticity, 1970, table 7)
        ("twist_load(part, torque=1N * 1m, axis=x, E=1GPa, nu=0.3)", 1000**2 * 120 / (G * 0.1406 * 12**4)),
        (
            "study(part, fix=x < -59.9mm, load=torque(x > 59.9mm, [1N * 1m, 0N * 1m, 0N * 1m]), E=1GPa, nu=0.3)",
            1000**2 * 120 / (G * 0.1406 * 12**4),
        ),
        (
            "study(part, fix=x < -59.9mm, load=force(x > 59.9mm, [0N, 0N, -10N]), E=1GPa, nu=0.3)",
            10**2 * (120**3 / 3 / E / INERTIA + 120 / SHEARED),
        ),
    ],
)  # fmt: skip
def test_a_beam_does_what_beams_do(study: str, beam: float) -> None:
    """Six bricks over the height are too stiff by some 3 % in bending; pads and held ends shift a little more."""
    assert compliance(study) == pytest.approx(beam, rel=0.06)


@pytest.mark.parametrize(
    ("load", "word"),
    [
        ("load=pressure(x > 59.9mm, 1MPa)", "walls of the lattice"),
        ("density=1, load=weight()", "changes with the density"),
        ("load=moved(x > 59.9mm, [1mm, 0mm, 0mm])", "as little as can be"),
    ],
)
def test_what_the_homogenised_part_has_not(load: str, word: str) -> None:
    with pytest.raises(PoreError, match="E193") as caught:
        compliance(f"study(part, fix=x < -59.9mm, {load}, E=1GPa, nu=0.3)")
    assert word in str(caught.value)
    assert caught.value.diagnostics[0].hint


def test_the_law_of_the_lattice_at_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the network: .911 rho^2.12 by another code, over .2 to .8; and of what is turned there is none."""
    monkeypatch.setattr(promise, "VOXELS", 16)
    monkeypatch.setattr(promise, "DENSITIES", 3)
    what = adapting(porelang.compile(TEXT).design())
    law, doubts = promise.law_of(what, *what.law(0.3, 0.7), 20.0, 0.3, 0.3, 0.7)
    fit = power(law.density, law.young(law.density))
    assert not doubts
    assert law.density == pytest.approx([0.3, 0.5, 0.7], abs=0.02)
    assert fit.factor * np.array([0.3, 0.5, 0.7]) ** fit.exponent == pytest.approx(
        0.911 * np.array([0.3, 0.5, 0.7]) ** 2.12, rel=0.1
    )
    turned = adapting(porelang.compile(TEXT.replace("gyroid(20mm)", "rotate(gyroid(20mm), [1, 0, 0], 20deg)")).design())
    with pytest.raises(PoreError, match=r"E181.*for the law of the lattice"):
        promise.law_of(turned, *turned.law(0.3, 0.7), 20.0, 0.3, 0.3, 0.7)


def test_a_law_is_of_densities_that_were_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lattice that is in pieces below .21, as a network of P: limits above that have a law, though the thickness goes
    on below; a limit below is refused, with others that are not. Whole cells may be denser than the part by `more`."""
    asked: list[float] = []
    more = 0.0

    def at(self: Any, density: float) -> Any:
        asked.append(density)
        stiffness = density**2 * isotropic(0.3) * (1 if density > 0.21 else -1)
        return SimpleNamespace(density=density + more, stiffness=stiffness, stiffness_error=0 * stiffness)

    monkeypatch.setattr(promise._Cells, "at", at)
    what = adapting(porelang.compile(TEXT).design())
    thickness = laws.Thickness(np.linspace(0.15, 0.9, 6), np.linspace(-2, 2, 6))
    with pytest.raises(PoreError, match=r"E192.*`part` is no material at the density 0\.2:") as caught:
        promise.law_of(what, thickness, 1, 20.0, 0.3, 0.2, 0.8)
    low, high = (float(x) for x in re.findall(r"limits[ =]\"?([\d.]+)\.\.([\d.]+)", str(caught.value))[0])
    assert (low, high) == (0.3, 0.8)
    for limit, off, beyond in ((low, 0.0, []), (0.22, 0.02, [0.15]), (low, -0.02, [0.9])):
        more = off
        asked.clear()
        law, _ = promise.law_of(what, thickness, 1, 20.0, 0.3, limit, high)
        assert asked == pytest.approx([*np.linspace(limit, high, promise.DENSITIES), *beyond])
        assert laws.is_material(law.constants).all()  # what lies below, in pieces, is left out
        assert law.range[1] >= high


def test_the_law_is_found_where_the_part_lies(monkeypatch: pytest.MonkeyPatch) -> None:
    """A phase is known round the part alone, and cells of it are as large as the param says."""
    monkeypatch.setattr(promise, "VOXELS", 8)
    monkeypatch.setattr(promise, "DENSITIES", 2)
    monkeypatch.setattr(adapted, "PLACES", 4000)
    there = "translate(box([60mm, 20mm, 20mm]), [200mm, 0mm, 0mm])"
    text = TEXT.replace("= 0 ", "= 10mm ").replace("box([60mm, 20mm, 20mm])", there)
    text = text.replace("gyroid(20mm) - t", "gyroid(phase=phase(t, bar)) |> shell(12mm / t)")
    what = adapting(porelang.compile(text.replace("-29.9mm", "170.1mm").replace("29.9mm", "229.9mm")).design())
    sizes = laws.Thickness(np.array([0.4, 0.6]), np.array([-12.0, -8.0]))
    law, doubts = promise.law_of(what, sizes, -1, 10.0, 0.3, 0.4, 0.6)
    assert not doubts
    # a sheet of raw half-thickness .5 and .75: shares of a cell on a grid of its own
    x, y, z = np.meshgrid(*[(np.arange(90) + 0.5) / 90 * 2 * np.pi] * 3, indexing="ij")
    wave = np.abs(np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x))
    assert law.density == pytest.approx([(wave < 0.5).mean(), (wave < 0.75).mean()], abs=0.02)


def test_what_is_not_cubic_is_doubted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(promise, "VOXELS", 10)
    monkeypatch.setattr(promise, "DENSITIES", 3)
    what = adapting(porelang.compile(TEXT.replace("gyroid(20mm)", "gyroid(phase=p / [10mm, 10mm, 20mm])")).design())
    _, doubts = promise.law_of(what, *what.law(0.4, 0.6), 20.0, 0.3, 0.4, 0.6)
    assert [d.code for d in doubts] == ["W271"]


def test_a_law_is_for_one_ratio() -> None:
    what = adapting(porelang.compile(TEXT.replace("nu=0.3", "nu=0.3 + x / 1m")).design())
    grid = Grid(np.ones((12, 4, 4)), (-30, -10, -10), (5, 5, 5))
    with pytest.raises(PoreError, match=r"E193.*ratio of the solid varies"):
        promise.promise(what, *what.law(0.3, 0.7), grid, 20.0, PLAN, Optimum())


def test_a_core_is_dense_in_the_middle_and_keeps_the_mean() -> None:
    grid = Grid(np.ones((8, 8, 12)), (0, 0, 0), (5, 5, 5))
    found = promise.core(grid, PLAN).reshape(8, 8, 12)
    assert found.mean() == pytest.approx(0.5)
    assert found[4, 4, 6] == pytest.approx(0.7)
    assert found[0].max() < 0.35


def test_few_cells_across_are_counted() -> None:
    """In a bar, a plate, a cylinder, a tube; and across a patch that is loaded."""
    bar = Grid(np.ones((24, 8, 8)), (0, 0, 0), (2.5, 2.5, 2.5))
    assert promise.cells_across(bar, 10.0) == pytest.approx(2)
    assert promise.cells_across(Grid(np.ones((24, 24, 4)), (0, 0, 0), (2.5, 2.5, 2.5)), 5.0) == pytest.approx(2)
    tube = Grid.of(lambda p: np.abs(np.hypot(p[:, 0], p[:, 1]) - 15) - 5, (-20, -20, 0), (20, 20, 40), 1.25)
    assert promise.cells_across(tube, 5.0) == pytest.approx(2, abs=0.5)
    assert promise.cells_across(tube, 5.0) < promise.cells_across(tube, 2.5)
    end = lambda p: p[:, 0] > 59.9  # noqa: E731
    face = Problem(bar, (), (Force(end, (0, 0, 1)),))
    patch = Problem(
        bar, (), (Force(end, (0, 0, 1)), Force(lambda p: end(p) & (p[:, 1] < 5) & (p[:, 2] < 5), (1, 0, 0)))
    )
    assert promise.loaded_across(face, 10.0) == pytest.approx(2)
    assert promise.loaded_across(patch, 10.0) == pytest.approx(0.5)


class Uniform:
    """Every density bears the same everywhere; the given one less."""

    key, cell = "uniform", 0.0
    grid = Grid(np.ones((4, 1, 1)), (0, 0, 0), (1, 1, 1))

    def solve(self, density: Any, state: Any) -> Answer:
        one = np.ones(4)
        return Answer(10.0 - np.ptp(density), 1.0, density * one, one, one, 0.0)


def test_a_given_density_is_step_one_even_where_stresses_are_uniform() -> None:
    density = np.array([0.4, 0.6, 0.6, 0.4])
    plan = loop.Plan(0.5, 0.3, 0.7, 0.0, most=1, least=1)
    found = loop.iterate(Uniform(), Given(density, "elsewhere"), plan)
    assert [s.compliance for s in found.steps] == pytest.approx([10, 9.8])
    assert found.density.tolist() == density.tolist()
    assert found.reason == "uniform"
    assert loop.iterate(Uniform(), Energy(), loop.Plan(0.5, 0.3, 0.7, 0.0)).best == 0
    assert Given(density, "elsewhere", Energy()).name == f"elsewhere, then {Energy().name}"


def promised_of(density: Array, errors: tuple[float, float]) -> promise.Promise:
    made = law([0.3, 0.7], [0.1 * isotropic(0.3), 0.4 * isotropic(0.3)], nu=0.3)
    return promise.Promise("x", made, density, 2.0, 1.5, errors, 3.0, 0.65 / 3, 4, (2.0, 1.5), (), 2.5)


def test_a_promise_states_the_error_of_its_ratio_or_that_it_is_not_known() -> None:
    known = promised_of(np.array([0.4, 0.6]), (0.274, 0.267))
    assert "from 2 +- 27.4% to 1.5 +- 26.7% N mm, 0.750 +- 0.16 of the uniform compliance" in str(known)
    unknown = str(promised_of(np.array([0.4, 0.6]), (np.inf, np.inf)))
    assert "inf" not in unknown
    assert "+-" not in unknown
    assert unknown.count("cannot be judged: what is held or loaded is too small for voxels of 5 mm") == 1
    even = str(promised_of(np.array([0.5, 0.5]), (0.274, 0.267)))
    assert "2 +- 27.4% N mm, and no density is stiffer than the uniform one; each error has 22%" in even


def test_an_optimum_that_is_uniform_is_not_solved_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    from porelang.optimize import run

    def uniform(what: Any, thickness: Any, sign: float, grid: Grid, *_: Any) -> promise.Promise:
        return promised_of(np.full(len(grid.weights), 0.5), (0.1, 0.1))

    def solve(self: Any, density: Array, state: Any) -> Answer:
        one = np.ones(len(density))
        return Answer(2.0, 1.0, density * np.linspace(1, 2, len(one)), one, one, 0.0, error=0.1, apart=0.01)

    monkeypatch.setattr(run, "promise", uniform)
    monkeypatch.setattr(run.Real, "solve", solve)
    found = porelang.compile(TEXT).iterate("part", rule="optimum", limits=(0.3, 0.7), porosity=0.5)
    assert len(found.steps) == 1
    assert "the optimum is the uniform density" in str(found)
    assert not found.told


@pytest.mark.slow
def test_the_optimum_is_made_real(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the command line, twice over one record: all that was found before is found again, to the bit."""
    monkeypatch.setattr(promise, "VOXELS", 12)
    monkeypatch.setattr(promise, "DENSITIES", 3)
    file, folder = tmp_path / "bar.pore", tmp_path / "loop"
    file.write_text(TEXT)
    words = ["optimize", str(file), "--limits", "0.3..0.7", "-o", str(folder), "--json", "-q", "--rule", "optimum"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    promised = found["promise"]
    assert len(found["steps"]) == 2
    assert found["gain"] < 0.9
    # a cantilever of rho^2 within .3 to .7: what another code found for a sheet and .2 to .8 is .56
    assert 0.6 < promised["gain"] < 0.8
    # the bar has one cell across: the homogenised one is a guess, but of its size, and says so
    assert promised["uniform"] == pytest.approx(found["steps"][0]["compliance"], rel=0.3)
    assert promised["cells_across"] == pytest.approx(1)
    assert promised["few_cells_error"] == pytest.approx(0.65)
    assert promised["gain_error"] == pytest.approx(0.65 * promised["gain"])
    assert abs(found["gain"] - promised["gain"]) < promised["gain_error"]
    assert 0 < promised["best_error"] - 0.65 < 0.2  # what voxels twice as large change, and cells of 12 voxels
    assert "the optimum is solved as a lattice" in (folder / "history.md").read_text()
    assert all(step["porosity"] == pytest.approx(0.5, abs=1e-3) for step in found["steps"])
    assert "homogenised" in (folder / "history.md").read_text()
    assert main([*words, "--resume"]) == 0
    assert json.loads(capsys.readouterr().out)["steps"] == found["steps"]

    early = [*words[:-1], "energy", "--early", "homogenised", "--max", "1"]
    early[early.index(str(folder))] = str(tmp_path / "early")
    assert main(early) == 0
    other = json.loads(capsys.readouterr().out)
    assert other["steps"][0]["compliance"] == found["steps"][0]["compliance"]
    assert other["steps"][1]["compliance"] < found["steps"][0]["compliance"]
    assert "then energy" in other["rule"]
