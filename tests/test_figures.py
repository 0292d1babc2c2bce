"""The figures of the paper: programs that keep the law on both backends, samples that are half void, their pictures."""

from __future__ import annotations

import importlib.util
import json
import math
import re
import sys
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import porelang
from porelang.backends.error import judge
from porelang.checks import failed_checks
from porelang.cli import main
from porelang.ir import order
from porelang.notation import steps

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "examples" / "figures"
FIGURES = {path.stem: porelang.compile(path=path) for path in sorted(FOLDER.glob("*.pore"))}
OUTPUTS = [(name, output) for name, program in FIGURES.items() for output in program.outputs]
#: Those that the paper gives half of their volume, and how far they reach.
CUBES = [name for name in FIGURES if name.startswith("fig04")]
CYLINDERS = [name for name in FIGURES if re.match(r"fig(08|09|10)", name)]
#: What section 2.3 writes for what a figure shows. A shell's (O,T), offset and thickness, are one constant of ours.
NOTATION = {
    "fig01g_tpms": "(F)(C)(D)(F)",
    "fig04a_regular": "(F)(C)(W)(F)",
    "fig04b_polar": "(F)(V)(S)(F)",
    "fig04c_wavelength": "(F)(F)(W)(F)",
    "fig04d_thickness": "(F_A)(F_B)(D)(F)",
    "fig04e_blend": "(F_A, F_B)(F_C)(R)(F_R)",
    "fig04f_diamond": "(F)(C)(T)(F)",
    "fig04g_shell": "(F)(C)(D)(F)",
    "fig07a_regular": "(F)(C)(W)(F)",
    "fig07d_aligned": "(F)(V)(S)(F)",
    "fig08a_regular": "(F)(C)(W)(F)",
    "fig08b_shell": "(F)(C)(D)(F)",
    "fig08c_polar": "(F)(V)(S)(F)",
    "fig09a_blend": "(F_A, F_B)(F_C)(R)(F_R)",
    "fig09b_polar_diamond": "(F)(V)(S)(F)",
    "fig09c_turned_diamond": "(F)(L)(S)(F)",
    "fig10b_thickness": "(F_A)(F_B)(D)(F)",
    "fig10c_wavelength": "(F)(F)(W)(F)",
    "fig11_grid_search": "(F)(C)(W)(F)",
}
Points = NDArray[np.float64]


def cube(count: int, side: float = 120.0, seed: int = 1) -> Points:
    """Random points in a cube, with coordinates that are float32 numbers."""
    points = np.random.default_rng(seed).uniform(-side / 2, side / 2, (count, 3))
    return points.astype(np.float32).astype(np.float64)


def cylinder(count: int, seed: int = 1) -> Points:
    """Random points in the paper's specimen: about pi/4 of `count`."""
    points = np.random.default_rng(seed).uniform([-75, -75, -150], [75, 75, 150], (count, 3))
    inside: Points = points[np.hypot(points[:, 0], points[:, 1]) < 75]
    return inside


@cache
def void(name: str) -> tuple[float, float]:
    """The share of void among random points, and its standard deviation: an estimate that knows nothing of ours."""
    points = cube(400_000) if name in CUBES else cylinder(500_000)
    outside = FIGURES[name].field()(points) > 0
    return float(np.mean(outside)), 0.5 / math.sqrt(len(points))


def gyroid(points: Points, w: float = 30.0) -> Points:
    x, y, z = (points * (math.tau / w)).T
    value: Points = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return value


def polar(points: Points, turn: float) -> Points:
    x, y, z = points.T
    return np.stack([np.hypot(x, y), np.arctan2(y, x) / math.tau * turn, z], axis=1)


def test_every_figure_is_there() -> None:
    letters = {
        "fig01": "g",
        "fig04": "abcdefg",
        "fig05": "abcdef",
        "fig07": "abcd",
        "fig08": "abc",
        "fig09": "abc",
        "fig10": "bc",
    }
    wanted = {number + letter for number, all_of_it in letters.items() for letter in all_of_it}
    assert {name.partition("_")[0] for name in FIGURES} == wanted | {"fig06", "fig11"}


@pytest.mark.parametrize("name", FIGURES)
def test_figure_is_explained_and_every_param_matters(name: str) -> None:
    program = FIGURES[name]
    sheared = {"W239"} if name == "fig07d_aligned" else set()  # as the paper draws it
    assert {d.code for d in program.warnings} == sheared
    number, letter = re.match(r"fig0?(\d+)([a-z]?)_", name).groups()  # type: ignore[union-attr]
    assert program.source.text.startswith(f"# Figure {number} ({letter})" if letter else f"# Figure {number}:")
    assert all(info.doc for info in program.params.values())
    read = {str(n.value) for n in order(program.graph.roots) if n.op == "param"}
    assert set(program.params) <= read


@pytest.mark.parametrize(("name", "output"), OUTPUTS)
def test_both_backends_keep_the_law(name: str, output: str, engine: Any) -> None:
    program = FIGURES[name]
    design = program.design()
    points = cube(3000)
    values = design.field(output, backend=engine, dtype="f32")(points)
    verdict = judge(design.of(output), points, values)
    assert not verdict.broken.any()
    # the law allows either side of a jump; nearly all points lie off any
    off = np.abs(values - verdict.reference) / (1 + np.abs(verdict.reference))
    assert np.quantile(off, 0.99) < 1e-3


@pytest.mark.parametrize("name", [*CUBES, *CYLINDERS])
@pytest.mark.slow
def test_sample_is_half_void(name: str) -> None:
    assert failed_checks(FIGURES[name].design()) == []
    porosity, deviation = void(name)
    assert deviation < 1e-3
    assert porosity == pytest.approx(0.5, abs=0.005)


@pytest.mark.parametrize("name", CYLINDERS)
def test_cylinder_is_the_papers(name: str) -> None:
    """Section 2.3: d 150 mm, h 300 mm, 5.3 dm3, of which 2.65 are solid."""
    assert FIGURES[name].bounds().size == pytest.approx((150, 150, 300), rel=1e-3)
    envelope = math.pi * 0.75**2 * 3  # dm3
    assert envelope == pytest.approx(5.3, abs=0.05)
    assert envelope * (1 - void(name)[0]) == pytest.approx(2.65, abs=0.03)


@pytest.mark.parametrize("name", [n for n in FIGURES if re.match(r"fig(01|04|08|09|10)", n)])
@pytest.mark.slow
def test_the_check_of_a_sample_can_fail(name: str) -> None:
    """With two thirds of the material offset away, a check that measures has to complain."""
    text = FIGURES[name].source.text
    if "check" not in text:
        assert name == "fig01g_tpms"
        return
    broken = re.sub(r"^check abs\(porosity\(infill, ", "check abs(porosity(infill + 0.5, ", text, flags=re.MULTILINE)
    assert broken != text
    broken = broken.replace('"fig06_field.pore"', f'"{(FOLDER / "fig06_field.pore").as_posix()}"')
    assert failed_checks(porelang.compile(broken).design()) != []


@pytest.mark.parametrize("name", NOTATION)
def test_notation_is_the_papers(name: str) -> None:
    assert NOTATION[name] in [step.notation for step in steps(FIGURES[name])]


@pytest.mark.parametrize("name", FIGURES)
def test_notation_in_the_comment_is_what_the_program_does(name: str) -> None:
    found = re.search(r"^# Notation: ([^;\n]*)", FIGURES[name].source.text, re.MULTILINE)
    written = re.findall(r"(?:\([^)]*\)){4}", found[1]) if found else []
    assert set(written) <= {step.notation for step in steps(FIGURES[name])}
    assert written or name not in NOTATION


def test_thickness_follows_the_distance_to_the_edge() -> None:
    points = cube(200_000)
    solid = FIGURES["fig04d_thickness"].field()(points) <= 0
    edge = np.hypot(points[:, 0] - 60, points[:, 2] - 60)
    shares = [solid[(edge >= lo) & (edge < lo + 40)].mean() for lo in (0, 40, 80, 120)]
    assert all(b < a - 0.1 for a, b in pairwise(shares))


@pytest.mark.slow
def test_transition_has_schwarz_p_at_the_bottom_and_the_gyroid_at_the_top() -> None:
    program = FIGURES["fig04e_blend"]
    (shift,) = (r.value for text, r in program.reduced().items() if text.startswith("to_porosity"))
    points = cube(20_000, side=119)
    values = program.field()(points)
    bottom, top = points[:, 2] < -30, points[:, 2] > 30
    p = np.cos(points[bottom] * (math.tau / 30)).sum(axis=1)
    inside = np.abs(points).max(axis=1) - 60  # the cube's own distance is below the lattice's nearly everywhere
    assert values[bottom] == pytest.approx(np.maximum(p - shift, inside[bottom]), abs=1e-9)
    assert values[top] == pytest.approx(np.maximum(gyroid(points[top]) - shift, inside[top]), abs=1e-9)


@pytest.mark.slow
def test_shell_has_the_thickness_that_the_paper_found() -> None:
    for name in ("fig04g_shell", "fig08b_shell"):
        (t,) = (r for text, r in FIGURES[name].reduced().items() if text.startswith("shell_to_porosity"))
        assert t.value == pytest.approx(1.53, abs=0.005 + t.error)


def test_turned_diamond_repeats_along_the_normal() -> None:
    """Moved by a period along n = (0, -1, 1) the lattice is the same; by as much along y or z it is not."""
    points = cylinder(20_000) * 0.4
    field = FIGURES["fig09c_turned_diamond"].field()
    steps_along = 30 / math.sqrt(2) * np.array([[0, -1, 1], [0, math.sqrt(2), 0], [0, 0, math.sqrt(2)]])
    normal, y, z = (np.abs(field(points + step) - field(points)).max() for step in steps_along)
    assert normal < 1e-9
    assert min(y, z) > 0.5


def figure6(points: Points) -> Points:
    """Eq 8 for the torus and the two spheres of Figure 6, in NumPy."""
    x, y, z = points.T
    ring = np.hypot(np.hypot(x, y) - 200, z) - 110
    a, b = (np.sqrt(x * x + y * y + (z - at) ** 2) - 80 for at in (180, -180))
    ends = np.minimum(a, b) - np.maximum(40 - np.abs(a - b), 0) ** 2 / 160
    field: Points = (ring - ends) / (ring + ends)
    return field


def diamond(points: Points, w: float = 30.0) -> Points:
    (sx, cx), (sy, cy), (sz, cz) = ((np.sin(v), np.cos(v)) for v in (points * (math.tau / w)).T)
    value: Points = sx * sy * sz + sx * cy * cz + cx * sy * cz + cx * cy * sz
    return value


def stress(points: Points) -> Points:
    return np.clip(1 - np.abs(figure6(points)), 0, 1)


def blended(points: Points) -> Points:
    """Cartesian up to 30 mm from the axis, polar from 60 mm on (Eq 7)."""
    f = np.clip((np.hypot(points[:, 0], points[:, 1]) - 45) / 30 + 0.5, 0, 1)
    return (1 - f) * gyroid(points) + f * gyroid(polar(points, 360))


def turned(points: Points) -> Points:
    """In a frame whose third axis is n = (0, -1, 1)."""
    frame = np.array([[1, 0, 0], [0, math.sqrt(0.5), math.sqrt(0.5)], [0, -math.sqrt(0.5), math.sqrt(0.5)]])
    return diamond(points @ frame.T)


def chirped(points: Points) -> Points:
    w = 36 - 10 * stress(points)
    x, y, z = (points * (math.tau / w)[:, None]).T
    value: Points = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return value


#: The lattices of the specimens before anything is added to bring them to one half.
LATTICES: dict[str, Callable[[Points], Points]] = {
    "fig08a_regular": gyroid,
    "fig08b_shell": lambda p: np.abs(gyroid(p)),
    "fig08c_polar": lambda p: gyroid(polar(p, 360)),
    "fig09a_blend": blended,
    "fig09b_polar_diamond": lambda p: diamond(polar(p, 360)),
    "fig09c_turned_diamond": turned,
    "fig10b_thickness": lambda p: gyroid(p) - 1.8 * stress(p),
    "fig10c_wavelength": chirped,
}


@pytest.mark.parametrize("name", CYLINDERS)
@pytest.mark.slow
def test_specimen_is_half_void_by_formulas_written_here(name: str) -> None:
    """The lattice, what was found to be added to it, and the envelope, in float64 NumPy that knows nothing of ours."""
    added = [r.value for text, r in FIGURES[name].reduced().items() if re.match(r"(shell_)?to_porosity", text)]
    shift = (added[0] / 2 if "shell" in name else added[0]) if added else 0.0
    points = cylinder(500_000)
    lattice = LATTICES[name](points) - shift
    deviation = 0.5 / math.sqrt(len(points))
    assert abs(np.mean(lattice > 0) - 0.5) < 4 * deviation + 0.0005 < 0.005
    few = slice(0, 20_000)
    envelope = np.maximum(np.hypot(points[:, 0], points[:, 1]) - 75, np.abs(points[:, 2]) - 150)
    assert FIGURES[name].field()(points[few]) == pytest.approx(np.maximum(lattice, envelope)[few], abs=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("roughly")
def test_the_command_measures_the_porosity_within_the_specimen(capsys: pytest.CaptureFixture[str]) -> None:
    path = FOLDER / "fig08a_regular.pore"
    assert main(["measure", str(path), "--within", "specimen", "--resolution", "24", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    porosity, deviation = void("fig08a_regular")
    assert found["porosity"] == pytest.approx(0.5, abs=0.005)
    assert abs(found["porosity"] - porosity) < found["error"]["porosity"] + 4 * deviation
    assert found["envelope_volume"] == pytest.approx(math.pi * 75**2 * 300, rel=1e-3)


def test_field_of_figure_6_is_equation_8_and_has_no_pole() -> None:
    points = cylinder(100_000)
    values = FIGURES["fig06_field"].field("modifier")(points)
    assert values == pytest.approx(figure6(points), abs=1e-12)
    assert np.abs(values).max() < 3
    assert failed_checks(FIGURES["fig06_field"].design()) == []


def test_the_x_of_figure_6_runs_from_the_centre_to_the_flanks() -> None:
    field = FIGURES["fig06_field"].field("modifier")
    assert field([[0, 0, 0]]) == pytest.approx(0, abs=1e-12)
    # above the arm the spheres are nearer, below it the torus is
    rho = np.array([20.0, 40.0, 60.0, 75.0])
    above = np.stack([rho, 0 * rho, 1.5 * rho], axis=1)
    below = np.stack([rho, 0 * rho, 0.6 * rho], axis=1)
    assert (field(above) > 0).all()
    assert (field(below) < 0).all()
    assert (field(below * [1, 1, -1]) < 0).all()


def test_material_gathers_where_the_stress_is_high() -> None:
    points = cylinder(300_000)
    high = stress(points)
    solid = FIGURES["fig10b_thickness"].field()(points) <= 0
    shares = [solid[(high >= lo) & (high <= lo + 0.25)].mean() for lo in (0, 0.25, 0.5, 0.75)]
    assert all(b > a + 0.1 for a, b in pairwise(shares))


def test_figures_5_are_the_fields_they_are_named_after() -> None:
    points = cube(5000, side=100)
    x, y, z = points.T
    tilt = math.radians(35)
    along = x * math.sin(tilt) + z * math.cos(tilt)
    rho = np.hypot(x, y)
    outside = np.hypot(np.maximum(rho - 25, 0), np.maximum(np.abs(z) - 35, 0))
    expected = {
        "fig05a_plane": along,
        "fig05b_cylinder": outside + np.minimum(np.maximum(rho - 25, np.abs(z) - 35), 0),
        "fig05c_sphere": np.linalg.norm(points, axis=1) - 30,
        "fig05d_sine_wave": 50 / math.tau * np.sin(math.tau * along / 50),
        "fig05e_torus": np.hypot(rho - 30, z) - 10,
        "fig05f_schwarz_p": np.cos(points * (math.tau / 100)).sum(axis=1),
    }
    assert set(expected) == {name for name in FIGURES if name.startswith("fig05")}
    for name, values in expected.items():
        assert FIGURES[name].field()(points) == pytest.approx(values, abs=1e-9), name


def test_local_frames_turn_the_lattice_with_the_curve() -> None:
    """At the crest of the curve its normal is the y axis: there the cells are the plain lattice's, turned upright."""
    field, away = (FIGURES["fig07d_aligned"].field(name) for name in ("lattice", "distance"))
    y = np.linspace(50, 70, 100)  # on the outside of the bend, where the crest is nearest
    points = np.stack([0 * y, y, 5 + 0 * y], axis=1)
    crest = 60 * (1 - math.cos(math.radians(40)))
    assert away(points) == pytest.approx(y - crest - 1, abs=1e-6)
    level = math.cos(math.tau * 5 / 28)
    assert field(points) == pytest.approx(np.cos(math.tau * y / 28) + 1 + level, abs=1e-6)


def test_the_squares_of_figure_7_stand_upright_to_the_curve() -> None:
    """The middles of their sides lie along the gradient of the distance, by the differences of Eq 9, and across it."""
    squares, away = FIGURES["fig07c_frames"].field("part"), FIGURES["fig07b_distance"].field("distance")
    centres = 4.0 * np.random.default_rng(3).integers(-14, 15, (300, 2))
    centres = np.column_stack([centres, np.zeros(len(centres))])
    step = 1e-4 * np.eye(3)
    g = np.stack([away(centres + s) - away(centres - s) for s in step], axis=1) / 2e-4
    plain = np.abs(np.linalg.norm(g, axis=1) - 1) < 1e-3  # not on a ridge
    assert plain.sum() > 250
    half = 0.6 * 4 / 2
    for way in (g, -g, np.column_stack([-g[:, 1], g[:, 0], g[:, 2]])):
        assert squares(centres + 0.5 * half * way)[plain] == pytest.approx(-0.5 * half, abs=1e-4)
        assert squares(centres + 1.2 * half * way)[plain] == pytest.approx(0.2 * half, abs=1e-4)


def script(name: str) -> ModuleType:
    """One of the Python files beside the figures."""
    spec = importlib.util.spec_from_file_location(f"{name}_figures", FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_grid_search_has_the_papers_samples() -> None:
    program = FIGURES["fig11_grid_search"]
    steps_of = script("draw").steps_of
    assert steps_of(program, "w") == [10, 15, 20, 25, 30, 35, 40]
    assert steps_of(program, "d") == pytest.approx([-0.7, -0.3, 0.1, 0.5, 0.9])
    points = cube(20_000, side=40)
    for w in (10, 40):
        shares = [np.mean(program.field(w=w, d=d)(points) > 0) for d in steps_of(program, "d")]
        assert all(b > a + 0.05 for a, b in pairwise(shares))


@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
def test_a_figure_is_drawn(tmp_path: Path) -> None:
    script("draw").main(tmp_path, "fig05c*")
    (path,) = tmp_path.glob("*.png")
    pixels = np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 20


def test_the_page_shows_every_figure_with_its_measure() -> None:
    page = (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")
    for name in FIGURES:
        assert f"figures/{name}.png" in page
        assert f"../examples/figures/{name}.pore" in page
        assert (ROOT / "docs" / "figures" / f"{name}.png").stat().st_size < 150_000
    measured = dict(re.findall(r"^\|.*?figures/(\w+)\.png.*\| (0\.\d+ ± 0\.\d+)", page, re.MULTILINE))
    assert set(measured) == {*CUBES, *CYLINDERS}
    for name, text in measured.items():
        value, error = (float(v) for v in text.split(" ± "))
        porosity, deviation = void(name)
        assert abs(value - porosity) < error + 4 * deviation, name


def test_the_comparison_is_what_was_solved() -> None:
    compare = script("compare")
    assert compare.page() == (ROOT / "docs" / "comparison.md").read_text(encoding="utf-8")
    rows = [json.loads(line) for line in compare.KEPT.read_text(encoding="utf-8").splitlines()]
    assert len(rows) == 6 * 8 + 2 * 8 + 4
    solid = compare.DENSITY * math.pi * compare.RADIUS**2 * compare.HEIGHT / 1e6  # kg
    for row in rows:
        assert row["mass"] == pytest.approx(solid * (1 - row["porosity"]), rel=1e-9)
        assert row["mean"] < row["max"]
