"""Lattices with a phase as programs: measured on the zero crossings of the lattice itself, and what is said of them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from test_phase import PERIODS, cylinder, inner

import porelang
from porelang.cli import main
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic
from porelang.ir import order
from porelang.ops.grid import lookup_cubic
from porelang.program import Design

Values = NDArray[Any]
CYLINDER = "let part = cylinder(75mm, 300mm)\n"


def design(w: str, more: str = "") -> Design:
    asked = f"{CYLINDER}let u = phase({w}, part{more})\nout turns = u\n"
    return porelang.compile(f"{asked}out raw = gyroid(phase=u)\nout lattice = gyroid(phase=u) & part\n").design()


@cache
def along_z() -> Design:
    return design("25mm + z / 10")


@pytest.fixture(scope="module")
def random(tmp_path_factory: pytest.TempPathFactory) -> Design:
    """The random field of that study, as a file of samples every 5 mm."""
    folder = tmp_path_factory.mktemp("random")
    axes = [np.arange(-end, end + 1, 5.0) for end in (80, 80, 155)]
    values = PERIODS["random"](*np.meshgrid(*axes, indexing="ij"))
    np.savez(folder / "w.npz", w=values, origin=[a[0] for a in axes], spacing=5.0)
    return design(f'load("{folder / "w.npz"}", "w", smooth=true)')


def periods_of(design: Design, axis: int, count: int) -> tuple[Values, Values]:
    """How far two rises of a gyroid through 0 are apart, across the wave, and the middles of them (n, 3).

    It is looked at along curves on which its other two phases are whole turns: there it is the sine of the third alone.
    """
    turns, lattice = design.field("turns"), design.field("raw")
    points = inner(PERIODS["10..40 along z"], count).T
    others = [a for a in range(3) if a != axis]

    def onto(points: Values, wanted: Values) -> Values:
        for _ in range(4):
            slopes = np.stack([(turns(points + 0.01 * e) - turns(points - 0.01 * e)) / 0.02 for e in np.eye(3)], -1)
            off = wanted - turns(points)
            points = points + np.clip(np.linalg.solve(slopes, off[..., None])[..., 0], -8, 8)
        return points

    start = turns(points)
    start[:, others] = np.round(start[:, others])
    steps = np.linspace(-1.05, 1.05, 64)
    curve, here = [], points
    for step in steps:  # each from the one before
        wanted = start.copy()
        wanted[:, axis] += step
        here = onto(here, wanted)
        curve.append(here)
    line = np.stack(curve, 1)
    values = lattice(line.reshape(-1, 3)).reshape(line.shape[:2])
    chords, middles = [], []
    for value, path in zip(values, line, strict=True):
        up = np.flatnonzero((value[:-1] < 0) & (value[1:] >= 0))
        up = up[np.argsort(np.abs(up - 31.5), kind="stable")[:2]]  # about the middle
        up.sort()
        ends = [i + value[i] / (value[i] - value[i + 1]) for i in up]
        on = np.stack([np.interp(np.linspace(*ends, 40), np.arange(len(path)), path[:, a]) for a in range(3)], 1)
        chords.append(on[-1] - on[0])
        middles.append(on[20])
    middle = np.array(middles)
    normals = np.stack([turns(middle + 0.05 * e)[:, axis] - turns(middle - 0.05 * e)[:, axis] for e in np.eye(3)], 1)
    return (np.array(chords) * normals).sum(1) / np.linalg.norm(normals, axis=1), middle


def check_crossings(design: Design, period: Callable[..., Values], off: float) -> None:
    errors = []
    for axis in range(3):
        lengths, middles = periods_of(design, axis, 500)
        inside = cylinder(*middles.T) < -period(*middles.T)  # by one cell, as for that study
        assert inside.sum() > 200
        errors.append((lengths / period(*middles.T) - 1)[inside])
    assert np.quantile(np.abs(np.concatenate(errors)), 0.95) < off


def test_cells_of_the_lattice_are_as_long_as_asked_for() -> None:
    check_crossings(along_z(), PERIODS["10..40 along z"], 0.025)


def test_cells_of_a_random_period_from_a_file_are_as_long_as_asked_for(random: Design) -> None:
    check_crossings(random, PERIODS["random"], 0.12)


def test_jacobian_of_a_random_period_from_a_file(random: Design) -> None:
    turns, points = random.field("turns"), inner(PERIODS["random"], 2000).T
    slopes = np.stack([(turns(points + 0.05 * e) - turns(points - 0.05 * e)) / 0.1 for e in np.eye(3)], -1)
    assert np.quantile(np.abs(np.linalg.norm(slopes, axis=2) * PERIODS["random"](*points.T)[:, None] - 1), 0.95) < 0.12
    values = np.linalg.svd(slopes, compute_uv=False)
    assert np.quantile(values[:, 0] / values[:, 2], 0.95) < 1.2
    assert (np.linalg.det(slopes) > 0).all()


def test_it_says_what_it_got() -> None:
    (note,) = along_z().notes("lattice")
    told = r"phase: asked 10\.0\.\.40\.0 mm, got \d+\.\d\.\.\d+\.\d; stretch at most 1\.\d\d; "
    assert re.fullmatch(told + r"turned by up to \d\d degrees; no folds", note.message)
    assert note.span is not None
    assert note.span.text == "phase(25mm + z / 10, part)"


def test_backends_agree_on_it(gpu: object) -> None:
    points = inner(PERIODS["10..40 along z"], 2000).T
    exact = along_z().field("raw")(points)
    drawn = along_z().field("raw", backend="glsl")(points)
    assert np.abs(exact - drawn).max() < 1e-3


# ---- what may be asked for -------------------------------------------------------------------------------------------
def slopes_of(design: Design, points: Values) -> Values:
    turns = design.field("turns")
    return np.stack([(turns(points + 0.05 * e) - turns(points - 0.05 * e)) / 0.1 for e in np.eye(3)], -1)


def test_periods_that_vary_along_their_own_axes_are_integrals() -> None:
    """u = the integral of dz / (25 + z/10) = 10 ln(1 + z/250), and x/15: exact, with a jump too."""
    points = inner(PERIODS["10..40 along z"], 2000, 0.3).T
    u = design("[15mm, 20mm, 25mm + z / 10]").field("turns")(points)
    closed = np.stack([points[:, 0] / 15, points[:, 1] / 20, 10 * np.log1p(points[:, 2] / 250)], 1)
    assert np.abs(u - closed).max() < 1e-3  # of the cubic between samples: 0.01 mm
    jump = design("[15mm, 15mm, if z < 20 then 10mm else 30mm]").field("turns")(points)[:, 2]
    z = points[:, 2]
    away = np.abs(z - 20) > 15
    assert np.abs(jump - np.where(z < 20, z / 10, 2 + (z - 20) / 30))[away].max() < 0.02


def test_fixed_cells_do_not_turn_and_free_ones_do() -> None:
    points = inner(PERIODS["10..40 along z"], 2000).T
    turns = []
    for more in ("", ', orientation="fixed"'):
        u, _, v = np.linalg.svd(slopes_of(design("25mm + z / 10", more), points))
        turns.append(np.degrees(np.arccos(np.clip((np.trace(u @ v, axis1=1, axis2=2) - 1) / 2, -1, 1))).max())
    assert turns[0] > 15
    assert turns[1] < turns[0] / 2


def test_cells_stand_along_a_direction() -> None:
    """One that is the same everywhere is followed, by either sign; one that turns slowly nearly."""
    points = inner(PERIODS["10..40 along z"], 1000).T
    for way in ("[1, 2, 2]", "[-1, -2, -2]", "if x < 0 then [1, 2, 2] else [-1, -2, -2]"):
        slopes = slopes_of(design("20mm", f", orientation={way}"), points)
        assert np.abs(np.abs(20 * slopes[:, 0] @ [1, 2, 2]) / 3 - 1).max() < 1e-3
        assert np.abs(400 * slopes @ slopes.transpose(0, 2, 1) - np.eye(3)).max() < 2e-3
    bent = design("20mm", ", orientation=[1, z / 600, 0]")
    slopes = slopes_of(bent, points)
    first = slopes[:, 0] / np.linalg.norm(slopes[:, 0], axis=1)[:, None]
    wanted = np.stack([np.ones(len(points)), points[:, 2] / 600, np.zeros(len(points))], 1)
    wanted /= np.linalg.norm(wanted, axis=1)[:, None]
    askew = np.degrees(np.arccos(np.clip(np.abs((first * wanted).sum(1)), 0, 1)))
    assert np.quantile(askew, 0.95) < 6
    assert np.abs(np.degrees(np.arctan(points[:, 2] / 600))).max() > 11  # without it they would miss by so much
    assert "degrees of the direction given" in bent.notes("lattice")[0].message


def test_volume_is_kept_at_the_price_of_shape() -> None:
    points = inner(PERIODS["10..40 along z"], 3000).T
    w = "15mm + 15mm * hypot(x, y) / 75"  # which cannot be had
    shape, volume = (slopes_of(design(w, more), points) for more in ("", ', keep="volume"'))
    asked = 15 + 15 * np.hypot(points[:, 0], points[:, 1]) / 75
    cells = [np.abs(np.log(np.linalg.det(s) * asked**3)) for s in (shape, volume)]
    stretch = [(v := np.linalg.svd(s, compute_uv=False))[:, 0] / v[:, 2] for s in (shape, volume)]
    assert np.quantile(cells[1], 0.9) < 0.7 * np.quantile(cells[0], 0.9)
    assert np.quantile(stretch[1], 0.9) > np.quantile(stretch[0], 0.9)


@pytest.mark.parametrize("depth", [18, 21.4])
def test_volume_is_kept_of_a_deep_dip(depth: float) -> None:
    """From even cells the first step towards it folds, and they were what came out: off by half in the middle. Volumes
    are never farther off than of cells of the right shape, and those of the deepest dip cannot be nearer."""
    w = f"27.48mm - {depth}mm * exp(-square(dot(p - [-0.82, -7.34, 2.29], [0.365, -0.464, -0.807]) / 4.41))"
    points = np.random.default_rng(4).normal(size=(4000, 3))
    points *= (
        40 * np.random.default_rng(5).uniform(0, 1, (4000, 1)) ** (1 / 3) / np.linalg.norm(points, axis=1)[:, None]
    )
    across = (points - [-0.82, -7.34, 2.29]) @ [0.365, -0.464, -0.807]
    asked = 27.48 - depth * np.exp(-((across / 4.41) ** 2))
    off, notes = [], []
    for more in ("", ', keep="volume"'):
        d = porelang.compile(f"let part = sphere(40)\nout turns = phase({w}, part{more})\n").design()
        off.append(np.abs(1 / (np.linalg.det(slopes_of(d, points)) * asked**3) - 1))
        notes.append(d.notes("turns")[0].message)
    most = [np.quantile(o, 0.95) for o in off]
    assert most[1] <= (1 if depth > 21 else 0.85) * most[0]
    assert np.median(off[1]) <= (1 if depth > 21 else 0.85) * np.median(off[0]) < 0.16
    assert "volume" not in notes[0]
    told = re.search(r"; volume within (\d+) % \(95 %\); ", notes[1])
    assert told is not None
    assert float(told[1]) == pytest.approx(100 * np.quantile(off[1], 0.95), rel=0.1)


def test_three_periods_and_a_direction_go_together() -> None:
    points = inner(PERIODS["10..40 along z"], 1000).T
    slopes = slopes_of(design("[30mm, 20mm, 15mm]", ", orientation=[1, 1, 0]"), points)
    assert np.abs(np.linalg.norm(slopes, axis=2) * [30, 20, 15] - 1).max() < 2e-3
    assert np.abs(np.abs(slopes[:, 0] @ [1, 1, 0]) * 30 / np.sqrt(2) - 1).max() < 2e-3


@pytest.mark.parametrize(
    ("cells", "counts"),
    [("12", (None, None, 12)), ('"whole"', None), ("[7, 0, 13]", (7, None, 13))],
)
def test_a_whole_number_of_cells_fits(cells: str, counts: tuple[int | None, ...] | None) -> None:
    ends = np.array([[-75.0, 0, 0], [75, 0, 0], [0, -75, 0], [0, 75, 0], [0, 0, -150], [0, 0, 150]])
    plain, fitted = (design("25mm + z / 10", more).field("turns")(ends) for more in ("", f", cells={cells}"))
    (was, found) = (np.array([u[2 * a + 1, a] - u[2 * a, a] for a in range(3)]) for u in (plain, fitted))
    for axis in range(3):
        if counts is None or counts[axis] is not None:
            assert found[axis] == pytest.approx(round(was[axis]) if counts is None else counts[axis], abs=1e-9)
            assert fitted[2 * axis, axis] == pytest.approx(0, abs=1e-9)
    if cells == "12":  # one factor for all
        assert found / was == pytest.approx(np.full(3, 12 / was[2]), rel=1e-6)
    if cells == "[7, 0, 13]":
        assert found[1] == pytest.approx(was[1], rel=1e-6)


@pytest.mark.parametrize("by", ["", " * 1.5 + 1mm"])
def test_all_nodes_of_data_are_looked_at(tmp_path: Path, by: str) -> None:
    """One of 68921 samples is no period, and another is half the others: no grid of points would meet them."""
    values = np.full((41, 41, 41), 12.0)
    values[10, 30, 22] = 6
    for bad in (False, True):
        if bad:
            values[20, 17, 13] = -3
        np.savez(tmp_path / "w.npz", w=values, origin=[-40.0] * 3, spacing=2.0)
        loaded = f'load("{tmp_path / "w.npz"}", "w", unit=mm){by}'
        d = porelang.compile(f"let part = cube(60)\ngyroid(phase=phase({loaded}, part)) & part").design()
        if bad:
            with pytest.raises(porelang.PoreError, match="the period that is asked for is -"):
                d.notes()
        else:
            least = 10 if by else 6
            assert f"asked {least}.0.." in d.notes()[0].message


# ---- what is said ----------------------------------------------------------------------------------------------------
def test_what_is_far_from_what_was_asked_is_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.pore"
    file.write_text(f"{CYLINDER}gyroid(phase=phase(15mm + hypot(x, y) / 5, part)) & part\n")
    assert main(["check", str(file), "--measure", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(d["severity"], d["code"]) for d in told] == [("note", ""), ("warning", "W229")]
    assert "one cell in twenty misses its size by" in told[1]["message"]


def test_what_a_size_misses_is_part_of_what_is_asked_for() -> None:
    """18 cells into 70 mm, of w from 9 to 12 mm: all are as much smaller as 18 is more than the integral of 1 / w."""
    program = porelang.compile(
        "let part = box([70mm, 30mm, 30mm])\n"
        "gyroid(phase=phase([9mm + 3mm * ramp(x, -30, 30), 9, 9], part, cells=18)) & part\n"
    )
    (told,) = [d for d in program.design().told(*program.graph.outputs["part"]) if d.code == "W229"]
    said = re.match(r"one cell in twenty misses its size by (\d+) % or more;", told.message)  # and is said once
    assert said is not None
    fit = 5 / 9 + 5 / 12 + np.log(12 / 9) * 60 / 3
    assert int(said[1]) == pytest.approx(100 * (1 - fit / 18), abs=1)
    assert f"give {fit:.0f}, the number that fits best" in told.hint
    program = porelang.compile(
        "let part = box([60, 40, 30])\n"
        'gyroid(phase=phase([8 + x / 20, 6 + y / 20, 9 - z / 30], part, cells="whole")) & part'
    )
    _, told = program.design().told(*program.graph.outputs["part"])
    assert "change the length of that side, or leave it out" in told.hint  # no number is nearer


def test_cells_smaller_than_any_that_is_asked_for_are_doubted() -> None:
    """Of a size that is least in a plane: round it they are stretched across, and shortened."""
    program = porelang.compile(
        "let part = box([110, 40, 40])\nlet u = phase(8.43mm + 0.199 * abs(x + 1.82), part)\n"
        "out made = gyroid(phase=u) & part\nout turns = u\n"
    )
    d = program.design()
    (told,) = [d for d in d.told(*program.graph.outputs["made"]) if d.code == "W229"]
    said = re.search(r"cells of 8\.4 mm at least are asked for, and some are (\d\.\d) mm", told.message)
    assert said is not None
    points = np.random.default_rng(3).uniform(-1, 1, (20_000, 3)) * [55, 20, 20]
    least = 1 / np.linalg.norm(slopes_of(d, points), axis=2).max()
    assert least < 8.43 / 1.2
    assert float(said[1]) == pytest.approx(least, rel=0.03)


def test_what_is_stretched_in_a_narrow_place_is_doubted() -> None:
    """A dip of 8 mm in a rod of 300 mm: far less than one cell in twenty."""
    program = porelang.compile(
        "let part = cylinder(20mm, 300mm)\nlet u = phase(12mm - 8mm * exp(-square(z / 4)), part)\n"
        "out made = gyroid(phase=u) & part\nout turns = u\n"
    )
    d = program.design()
    (told,) = [d for d in d.told(*program.graph.outputs["made"]) if d.code == "W229"]
    said = re.fullmatch(
        r"one cell misses its size by (\d+) %; one is (\d\.\d\d) times as long as it should be against its width",
        told.message,
    )
    assert said is not None
    points = np.random.default_rng(3).uniform(-1, 1, (40_000, 3)) * [20, 20, 10]
    points = points[np.hypot(points[:, 0], points[:, 1]) < 20]
    slopes = slopes_of(d, points)
    values = np.linalg.svd(slopes, compute_uv=False)
    asked = 12 - 8 * np.exp(-np.square(points[:, 2] / 4))
    off = 100 * np.abs(1 / (np.linalg.norm(slopes, axis=2) * asked[:, None]) - 1)
    # it is looked at every 3 mm, and worst between
    assert 0.8 < float(said[1]) / off.max() < 1.03
    assert 0.8 < float(said[2]) / (values[:, 0] / values[:, 2]).max() < 1.03


def test_a_phase_is_no_wave_that_drifts(random: Design) -> None:
    for d in (random, along_z()):
        assert "W228" not in [t.code for t in d.told(*d.program.graph.outputs["lattice"])]


@pytest.mark.parametrize(
    ("text", "share"),
    [
        ("gyroid(phase=phase(8mm + z / 10, cube(40))) & cube(60)", 0.54),  # (60^3 - 45^3) / 60^3 = 0.58, most in pores
        ("gyroid(phase=phase(8mm + z / 10, cube(40))) & cube(44)", None),  # a sixteenth beyond is known
        ("gyroid(phase=phase(8mm + z / 10, cube(40))) & cube(40) | translate(cube(40), [60, 0, 0])", None),
        ("translate(gyroid(phase=phase(8mm + z / 10, cube(40))), [60, 0, 0]) & translate(cube(40), [60, 0, 0])", None),
        ("translate(gyroid(phase=phase(8mm + z / 10, cube(40))), [60, 0, 0]) & cube(80)", 0.96),  # all but a corner
        ("if x < 0 then gyroid(phase=phase(6mm, translate(cube(40), [-20, 0, 0]))) else gyroid(6)", None),
    ],
)
def test_a_part_that_reaches_beyond_its_phase_is_doubted(text: str, share: float | None) -> None:
    program = porelang.compile(text if text[0] != "i" else f"({text}) & box([80, 40, 40])")
    told = [d for d in program.design().told(*program.graph.outputs["part"]) if d.code == "W237"]
    assert len(told) == (share is not None)
    if share is not None:
        said = re.search(r"by (\d+) % of it", told[0].message)
        assert said is not None
        assert float(said[1]) == pytest.approx(100 * share, abs=6)


@pytest.mark.parametrize(
    "solid",
    [
        "g |> shell(shell_to_porosity(g, 0.8, cube(40))) & cube(60)",
        "sample(g, 2mm, cube(60)) |> shell(0.6) & cube(60)",
        "blur(g, 1mm, cube(60)) |> shell(0.6) & cube(60)",
    ],
)
def test_a_part_whose_numbers_are_searched_or_whose_lattice_is_sampled_is_doubted_too(solid: str) -> None:
    program = porelang.compile(f"let g = gyroid(phase=phase(8mm + z / 10, cube(40)))\n{solid}")
    with pytest.warns(porelang.PoreWarning, match="W237"):
        program.design().notes()


def test_samples_farther_out_than_the_part_are_no_matter() -> None:
    program = porelang.compile(
        "let g = gyroid(phase=phase(8mm + z / 10, cube(40)))\nsample(g, 2mm, cube(60)) |> shell(0.6) & cube(40)"
    )
    assert [d.code for d in program.design().told(*program.graph.outputs["part"])] == [""]


def test_a_period_that_tasks_find_is_looked_at_by_all_that_find_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.pore"
    file.write_text("let part = box([16, 8, 8])\ngyroid(sample(6mm + x / 3, 2mm, part)) |> shell(0.8) & part\n")
    out = str(tmp_path / "a.stl")
    for command in (
        ["mesh", str(file), "-o", out, "--voxel", "1mm", "--force"],
        ["slices", str(file), "-o", str(tmp_path / "layers"), "--step", "2mm", "--voxel", "1mm"],
    ):
        main(command)
        assert capsys.readouterr().err.count("warning[W228]") == 1
    with pytest.warns(porelang.PoreWarning, match="W228"):
        porelang.compile(path=file).mesh(voxel="1mm", force=True)


def test_hints_name_what_would_do(tmp_path: Path) -> None:
    tube = "let part = cylinder(35mm, 40mm) \\ cylinder(10mm, 50mm)\n"
    for text, hint in (
        (f"{tube}gyroid(phase=phase(10mm, part, orientation=[x, y, 0])) & part", "`cylinder_map`, `polar` or `wedges`"),
        (
            "gyroid(phase=phase(10mm, cube(60), cells=12)) & cube(60)",
            "`cells` makes them 2 times smaller than they are asked for: give 6, the number that fits best",
        ),
    ):
        program = porelang.compile(text)
        (told,) = [d for d in program.design().told(*program.graph.outputs["part"]) if d.code == "W229"]
        assert hint in told.hint


def test_a_period_that_jumps_is_told_what_to_write() -> None:
    with pytest.warns(porelang.PoreWarning) as told:
        porelang.compile("gyroid(if x > 30 then 12 else 6) & box([80, 40, 40])")
    (found,) = [w.message.diagnostic for w in told]  # type: ignore[union-attr]
    assert found.code == "W218"
    assert "write `phase=phase(if x > 30 then 12 else 6, ...)`" in found.hint


def test_cells_stand_in_a_frame() -> None:
    """Cells of 10 mm outward, r/2 round and 10 mm up, in the frame of a cylinder: the phase is r/10, 2 angle, z/10."""
    text = """
let part = box([30, 60, 20]) |> translate([35, 0, 0])
let r = hypot(x, y)
out part = gyroid(phase=phase([10mm, r / 2, 10mm], part, orientation=[[x, y, 0], [-y, x, 0]])) & part
"""
    program = porelang.compile(text)
    (note,) = program.design().told(*program.graph.outputs["part"])
    assert note.severity == "note"
    assert re.search(r"within 0 degrees of the frame given \(95 %\), [0-2] at most", note.message)
    (grid,) = [n for n in order(program.graph.roots) if n.op == "phase"]
    found = program.design().task(grid)
    assert isinstance(found, SampledField)
    x, y, z = np.random.default_rng(2).uniform([21, -29, -9], [49, 29, 9], (4000, 3)).T
    slopes = np.stack([[lookup_cubic(found, x, y, z, (k, *e)) for e in np.eye(3, dtype=int)] for k in range(3)])
    r = np.hypot(x, y)
    zero = np.zeros_like(x)
    wanted = np.array([[x / r / 10, y / r / 10, zero], [-2 * y / r**2, 2 * x / r**2, zero], [zero, zero, zero + 0.1]])
    signs = np.sign((slopes * wanted).sum(1))
    assert (signs == signs[:, :1]).all()  # no cell is turned against its neighbours
    off = np.abs(slopes * signs[:, None] - wanted).max((0, 1)) * 10
    assert np.quantile(off, 0.95) < 0.02


def test_a_frame_that_turns_is_not_followed_for_nothing() -> None:
    """Cells of one size cannot stand round an axis: the note says by how much they miss the frame."""
    text = "let part = box([30, 60, 20]) |> translate([35, 0, 0])\n"
    text += "gyroid(phase=phase(10mm, part, orientation=[[x, y, 0], [-y, x, 0]])) & part"
    program = porelang.compile(text)
    told = program.design().told(*program.graph.outputs["part"])
    assert any("degrees of the frame given" in d.message for d in told)
    assert any(d.code == "W229" for d in told)


@pytest.mark.parametrize(
    ("orientation", "words"),
    [
        ("[max(x, 0), 0, 0]", "the direction given is 0 in 50 % of the part"),
        ("[[1, 0, 0], [1, max(x, 0), 0]]", "the frame given is 0, or its two lie along each other, in 50 % of"),
        ("[[1, 0, 0], [2, 0, 0]]", "in 100 % of the part"),
    ],
)
def test_where_there_is_no_direction_is_told(orientation: str, words: str) -> None:
    program = porelang.compile(f"gyroid(phase=phase(10mm, cube(40), orientation={orientation})) & cube(40)")
    (told,) = [d for d in program.design().told(*program.graph.outputs["part"]) if d.code == "W229"]
    assert words in told.message
    assert "cells there stand as those beside them" in told.hint


@pytest.mark.parametrize("sign", ["1", "sign(sin(x / 3))"])
@pytest.mark.parametrize("other", [", [-y, x, 0]", ""])
def test_cells_follow_half_a_ring(sign: str, other: str) -> None:
    """From one end to the other the frame turns by 180 degrees. Cells are r/4 round it, whose number is 4 times the
    angle, to what a grid of 32 cells and the rim allow; which of two opposite directions is given does not matter."""
    ways = f"[{sign} * [x, y, 0]{other}]" if other else f"{sign} * [x, y, 0]"
    program = porelang.compile(f"""
let ring = (cylinder(40mm, 30mm) \\ cylinder(24mm, 40mm)) & -y
out part = gyroid(phase=phase([8mm, hypot(x, y) / 4, 8mm], ring, orientation={ways})) & ring
""")
    told = program.design().told(*program.graph.outputs["part"])
    assert [d.severity for d in told] == ["note"]
    (grid,) = [n for n in order(program.graph.roots) if n.op == "phase"]
    found = program.design().task(grid)
    assert isinstance(found, SampledField)
    angle, r = np.meshgrid(np.radians([8.0, 172.0]), [28.0, 32.0, 36.0], indexing="ij")
    round_it = lookup_cubic(found, r * np.cos(angle), r * np.sin(angle), 0 * r, (1, 0, 0, 0))
    np.testing.assert_allclose(np.abs(round_it[1] - round_it[0]), 4 * np.radians(164), rtol=0.03)


SECTOR = """
let body = cylinder(40mm, 20mm) \\ cylinder(20mm, 40mm) & (abs(atan2({c} * y - {s} * x, {c} * x + {s} * y)) - {half}deg)
let r = hypot(x, y)
out part = gyroid(phase=phase({periods}, body, orientation={frame})) & body
"""
ROUND = ("[10mm, r / 3, 10mm]", "[[x, y, 0], [-y, x, 0]]", 1)


@pytest.mark.parametrize("at", [0.0, 0.7, np.pi])
@pytest.mark.parametrize(
    ("angle", "periods", "frame", "component"),
    [
        (200, *ROUND),
        (200, "[10mm, 10mm, r / 3]", "[[0, 0, 1], [x, y, 0]]", 2),
        (200, "[10mm, r / 3, 10mm]", "[[-x, -y, 0], [-y, x, 0]]", 1),
        (200, "[10mm, r / 3, 10mm]", "[x, y, 0]", 1),
        (300, *ROUND),
    ],
)
def test_cells_follow_a_sector_however_it_lies_and_its_axes_are_named(
    at: float, angle: float, periods: str, frame: str, component: int
) -> None:
    """3 cells in a radian, whose middles are r/3 round it; a grid of 32 cells allows that to 2 %. What lies in the gap
    and the hole does not count: with all of the box weighed alike, cells of 200 degrees fold at the rim."""
    text = SECTOR.format(c=np.cos(at), s=np.sin(at), half=angle / 2, periods=periods, frame=frame)
    program = porelang.compile(text)
    (note,) = program.design().told(*program.graph.outputs["part"])
    said = re.search(r"within (\d+) degrees of the \w+ given \(95 %\), (\d+) at most", note.message)
    assert said is not None
    assert int(said[1]) <= 1
    assert int(said[2]) <= 6
    (grid,) = [n for n in order(program.graph.roots) if n.op == "phase"]
    found = program.design().task(grid)
    assert isinstance(found, SampledField)
    ends = at + np.radians([8 - angle / 2, angle / 2 - 8])
    around, r = np.meshgrid(ends, [24.0, 30.0, 36.0], indexing="ij")
    turns = lookup_cubic(found, r * np.cos(around), r * np.sin(around), 0 * r, (component, 0, 0, 0))
    np.testing.assert_allclose(np.abs(turns[1] - turns[0]), 3 * np.radians(angle - 16), rtol=0.01)


KIRSCH = """
let a = 10mm
let r = max(hypot(x, y), 5mm)
let c2 = (x^2 - y^2) / r^2
let s2 = 2 * x * y / r^2
let q = (a / r)^2
let srr = 0.5 * (1 - q) + 0.5 * (1 - 4 * q + 3 * q^2) * c2
let stt = 0.5 * (1 + q) - 0.5 * (1 + 3 * q^2) * c2
let srt = -0.5 * (1 + 2 * q - 3 * q^2) * s2
let c = x / r
let s = y / r
let T = tensor(xx=srr * c^2 + stt * s^2 - 2 * srt * c * s, yy=srr * s^2 + stt * c^2 + 2 * srt * c * s, zz=0 * x,
               xy=(srr - stt) * c * s + srt * (c^2 - s^2), yz=0 * x, xz=0 * x)
let v = principal(T, 1).direction
let body = box([80, 40, 12]) \\ cylinder(10mm, 20mm) & (-x) & (-y)
out part = schwarz_p(phase=phase([6mm, 6mm, 6mm], body, orientation={frame})) & body
"""


@pytest.mark.parametrize(
    ("frame", "upright"), [("[v, [0, 0, 1]]", 1), ("[v, cross([0, 0, 1], v)]", 2), ("[[0, 0, 1], v]", 0)]
)
def test_a_few_cells_that_fold_at_a_rim_do_not_bend_the_others(frame: str, upright: int) -> None:
    """G. Kirsch, 1898: a plate with a hole, pulled along x. Across the plate nothing turns, and a cell is 6 mm there;
    beside the hole, where the stress is 0, directions jump."""
    program = porelang.compile(KIRSCH.format(frame=frame))
    program.design().told(*program.graph.outputs["part"])
    (grid,) = [n for n in order(program.graph.roots) if n.op == "phase"]
    found = program.design().task(grid)
    assert isinstance(found, SampledField)
    x, y, z = np.random.default_rng(2).uniform([1, 1, -5], [39, 19, 5], (4000, 3)).T
    x, y, z = (w[np.hypot(x, y) > 11] for w in (x, y, z))
    slope = np.stack([lookup_cubic(found, x, y, z, (upright, *e)) for e in np.eye(3, dtype=int)])
    assert np.abs(np.abs(slope[2]) * 6 - 1).max() < 1e-3
    assert np.hypot(slope[0], slope[1]).max() < 1e-3


def test_where_there_is_no_direction_cells_stand_as_those_beside_them() -> None:
    """A place of 3 mm, a six-hundredth of the part, where v is 0: the others lie along y, with periods of 6, 9, 12."""
    program = porelang.compile("""
let body = box([60, 40, 30])
let v = if length(p) < 3 then [0, 0, 0] else [0, 1, 0]
out part = gyroid(phase=phase([6mm, 9mm, 12mm], body, orientation=[v, [-1, 0, 0]])) & body
""")
    (note,) = program.design().told(*program.graph.outputs["part"])
    assert "got 6.0..12.0; stretch at most 1.00; within 0 degrees of the frame given (95 %), 0 at most" in note.message


def test_the_greatest_angle_is_told() -> None:
    """Of a twist by 1 degree in a mm, which cells of one size cannot follow: of the layers' normals, and of the edges
    from one cell to the next, which is more where they are sheared."""
    program = porelang.compile("""
let body = box([30, 30, 60])
let u = phase(8mm, body, orientation=[[cos(z * 1deg / 1mm), sin(z * 1deg / 1mm), 0], [0, 0, 1]])
out part = gyroid(phase=u) & body
out turns = u
""")
    d = program.design()
    (note, *_) = d.told(*program.graph.outputs["part"])
    points = np.random.default_rng(3).uniform(-1, 1, (20_000, 3)) * [15, 15, 30]
    rows = slopes_of(d, points)
    edges = np.linalg.inv(rows).transpose(0, 2, 1)
    a, o = np.radians(points[:, 2]), 0 * points[:, 0]
    frame = np.stack(
        [np.stack(v, 1) for v in ((np.cos(a), np.sin(a), o), (o, o, o + 1), (np.sin(a), -np.cos(a), o))], 1
    )
    cosine = np.concatenate([np.abs((m * frame).sum(2) / np.linalg.norm(m, axis=2)) for m in (rows, edges)], 1).min(1)
    off = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    said = re.search(r"within (\d+) degrees of the frame given \(95 %\), (\d+) at most", note.message)
    assert said is not None
    assert int(said[1]) == pytest.approx(np.quantile(off, 0.95), abs=1)
    assert int(said[2]) == pytest.approx(off.max(), abs=2)
    assert np.quantile(off, 0.95) > 11


@pytest.mark.parametrize(
    ("orientation", "turn"),
    [
        ("[[x, y, 0], [-y, x, 0]]", "the frame turns by a whole turn round a line or a hole"),
        (
            "[cos(atan2(y, x) / 2), sin(atan2(y, x) / 2), 0]",
            "the direction turns by half a turn round a line or a hole",
        ),
        ("[[cos(z / 40mm * 1rad), sin(z / 40mm * 1rad), 0], [0, 0, 1]]", ""),
    ],
)
def test_a_turn_round_a_hole_is_named(orientation: str, turn: str) -> None:
    program = porelang.compile(f"""
let ring = cylinder(40mm, 60mm) \\ cylinder(20mm, 80mm)
out part = gyroid(phase=phase(10mm, ring, orientation={orientation})) & ring
""")

    def told() -> list[Diagnostic]:
        try:
            return [d for d in program.design().told(*program.graph.outputs["part"]) if d.code]
        except porelang.PoreError as error:
            return list(error.diagnostics)

    (found,) = told()
    assert found.code in ("W229", "E148")
    hint = found.hint
    assert hint.startswith(turn or "a frame that turns needs cells that differ")


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("orientation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]", "leave out the third"),
        ("orientation=[principal(T, 1), principal(T, 2)]", "`principal(T, 1).direction`"),
        ("orientation=principal(T, 1)", "`principal(T, 1).direction`"),
        ("orientation=[[1, 0, 0], [0, 1, 0]], cells=4", "cells in a frame have no whole number"),
    ],
)
def test_what_no_orientation_is(more: str, says: str) -> None:
    with pytest.raises(porelang.PoreError) as error:
        porelang.compile(f"""
let T = tensor(xx=x, yy=y, zz=z, xy=0 * x, yz=0 * x, xz=0 * x)
gyroid(phase=phase(10mm, cube(40), {more})) & cube(40)
""")
    (d,) = error.value.diagnostics
    assert says in d.message + d.hint
