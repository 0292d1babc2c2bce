"""`measure` against closed forms: volumes, topology and openness of parts that are known by heart."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang import pieces
from porelang.cli import main
from porelang.cli.measuring import _text as told
from porelang.data import figures
from porelang.diagnostics import PoreError
from porelang.ir import node
from porelang.measure import CUT, INTERSECTED, envelope_of, measure
from porelang.mesh.made import make
from porelang.mesh.part import grid_of, surface_of
from porelang.pieces import MOST_NODES
from porelang.program import Design
from porelang.refusals import refusals
from porelang.walls import takes


def report(text: str, **more: object) -> dict[str, object]:
    return measure(porelang.compile(text).design(), **{"resolution": 64, **more})  # type: ignore[arg-type]


def enveloped(text: str) -> tuple[str, float]:
    """What a part is measured relative to, and its volume: the rest of a report takes ten times as long."""
    design = porelang.compile(text).design()
    envelope, called = envelope_of(design, design.of(), None, design.bounds())
    return called, design.number(node("volume", envelope)).value


def porosity(text: str) -> float:
    """The porosity of a part in its envelope."""
    design = porelang.compile(text).design()
    envelope, _ = envelope_of(design, design.of(), None, design.bounds())
    return design.number(node("porosity", design.of().root, envelope)).value


@pytest.mark.usefixtures("roughly")
@pytest.mark.parametrize(
    ("text", "solids", "voids", "euler"), [("box([100, 100, 0.5])", 1, 0, 2), ("sphere(5) \\ sphere(4.9)", 1, 1, 4)]
)
def test_counts_are_taken_at_a_voxel_that_holds_the_walls(text: str, solids: int, voids: int, euler: int) -> None:
    """Without a voxel they were not known of a plate and of a thin shell, at 1/128 of the longest side."""
    found = report(text, resolution=None)
    assert [found[k] for k in ("solid_components", "void_components", "euler")] == [solids, voids, euler]
    assert [found["error"][k] for k in ("solid_components", "void_components", "euler")] == [0, 0, 0]


def test_an_error_of_the_whole_tells_nothing_of_a_share() -> None:
    """Of a shell far thinner than the voxel it was told that 0 +- 2 of the void is open."""
    found = report("sphere(5) \\ sphere(4.9)", voxel=0.078, resolution=None)
    error = found["error"]["open_void_fraction"]
    assert error < 1 or math.isinf(error)


def test_a_hollow_ball() -> None:
    found = report("sphere(10) \\ sphere(6)")
    error = found["error"]
    exact = 4 / 3 * math.pi * (1000 - 216)
    assert abs(found["volume"] - exact) <= error["volume"] < 2e-3 * exact  # type: ignore[operator, index]
    assert abs(found["porosity"] - 0.216) <= error["porosity"] < 1e-3  # type: ignore[operator, index]
    assert abs(found["area"] - 4 * math.pi * 136) <= error["area"] < 3e-3 * found["area"]  # type: ignore[operator, index]
    assert (found["solid_components"], found["void_components"], found["euler"]) == (1, 1, 4)
    assert found["open_void_fraction"] == 0.0


@pytest.mark.slow
def test_walls_that_samples_miss_are_measured_but_not_counted() -> None:
    """A wall of an eighth of a voxel: volume and area come from the field, the counts say that they know nothing."""
    found = measure(porelang.compile("shell(sphere(50), 0.4) | sphere(8)").design(), resolution=32)
    error = found["error"]
    exact = 4 / 3 * math.pi * (50.2**3 - 49.8**3 + 512)
    assert abs(found["volume"] - exact) <= error["volume"] < 5e-3 * exact  # type: ignore[operator, index]
    assert abs(found["area"] - 4 * math.pi * (50.2**2 + 49.8**2 + 64)) <= error["area"]  # type: ignore[operator, index]
    assert {error[k] for k in ("solid_components", "void_components", "euler")} == {math.inf}  # type: ignore[index]


@pytest.mark.parametrize("resolution", [48, 64, 83, 100])
def test_the_share_of_open_void_errs_by_no_more_than_is_stated(resolution: int) -> None:
    text = "let e = sphere(12)\n(sphere(10) \\ sphere(6)) & e"
    found = measure(porelang.compile(text).design(), within="e", resolution=resolution)
    exact = (12**3 - 10**3) / (12**3 - 10**3 + 6**3)
    assert abs(found["open_void_fraction"] - exact) <= found["error"]["open_void_fraction"] < 0.01
    assert (found["void_components"], found["error"]["void_components"]) == (2, 0)


def test_a_ring_in_its_box() -> None:
    found = report("torus(20, 5)")
    assert (found["solid_components"], found["euler"]) == (1, 0)
    assert found["envelope_volume"] == pytest.approx(50 * 50 * 10, rel=1e-3)
    assert found["open_void_fraction"] == 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("roughly")
def test_a_shell_of_schwarz_p_has_two_voids() -> None:
    """The paper: shelling separates the volume "into two interwoven but unconnected voids"."""
    found = report("shell(schwarz_p(30), 0.4) & box([58, 58, 58])")
    assert found["void_components"] == 2
    assert found["solid_components"] == 1


@pytest.mark.usefixtures("roughly")
def test_the_euler_number_is_that_of_the_part_and_not_of_its_crumbs() -> None:
    """A ball cuts the sheet at sharp angles, where sampling leaves specks: 27 of them here, each of which counts 2."""
    design = porelang.compile("shell(gyroid(10), 0.6) & sphere(15)").design()
    raw = surface_of(design, None, grid_of(design, resolution=100))
    found = measure(design, resolution=100)
    mesh = make(design, resolution=100)
    assert len(raw.pieces.volume) > 1 == mesh.facts["components"]
    assert found["euler"] == mesh.surface.euler != raw.euler
    assert abs(found["euler"] + 230) <= 10 + found["error"]["euler"] < 30


@pytest.mark.usefixtures("roughly")
@pytest.mark.parametrize("resolution", [41, 64])
def test_the_euler_number_of_a_sheet_of_schwarz_p(resolution: int) -> None:
    """One side in two periods a side is 8 balls joined by 12 bars (2 * (8 - 12)), whose 24 further bars end at the box:
    so the sheet between the sides has -8 - 24, and the wall, on both of its faces, twice that."""
    found = report("schwarz_p(10) |> shell(0.6) & cube(20)", resolution=resolution)
    assert (found["euler"], found["error"]["euler"]) == (-64, 0)


@pytest.mark.slow
@pytest.mark.usefixtures("roughly")
def test_voids_beyond_those_that_are_described_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert pieces.MOST_DESCRIBED == 100
    monkeypatch.setattr(pieces, "MOST_DESCRIBED", 5)
    text = "cube(12) \\ repeat(sphere(1), 5, counts=[2, 2, 2])"
    path = tmp_path / "holes.pore"
    path.write_text(text)
    assert main(["measure", str(path), "--resolution", "40", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["closed_voids"], found["void_components"], len(found["voids"])) == (8, 8, 5)
    assert "and 3 yet smaller ones that are only counted" in told(str(path), found)


def test_a_voxel_that_is_too_fine_is_refused_before_anything_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Design, "number", lambda *_: pytest.fail("a number was found first"))
    with pytest.raises(PoreError, match=r"asks for 8e\+12 samples"):
        report("sphere(10)", resolution=None, voxel=0.001)


def test_pieces_and_envelopes() -> None:
    text = "let b = box([40, 10, 10])\nlet balls = sphere(3) | (sphere(3) |> translate([12, 0, 0]))\nballs & b"
    found = report(text, within="b")
    assert found["solid_components"] == 2
    assert abs(found["porosity"] - (1 - 2 * 4 / 3 * math.pi * 27 / 4000)) <= found["error"]["porosity"]  # type: ignore[operator, index]


def test_a_lattice_in_its_skin_with_holes_is_no_envelope_of_itself() -> None:
    """Its porosity was that of the holes alone, 2 %: the shape that they are cut out of is the part."""
    text = 'let b = cube(20)\n((shell(b, 2, side="inside") | gyroid(10) & b) \\ cylinder(2, 30)) '
    assert enveloped(text)[0] == "the bounds"
    void = 16**3 / 2 + math.pi * 4 * (2 * 2 + 16 / 2)  # half of what the skin holds, and of the hole what was solid
    assert porosity(text) == pytest.approx(void / 8000, abs=2e-3)


@pytest.mark.parametrize(
    ("text", "called", "volume"),
    [
        # a block with holes has its block, however many holes
        ("cube(20) \\ (cylinder(1, 30) | translate(cylinder(1, 30), [5, 0, 0]))", CUT, 8000),
        ("cylinder(5, 10) \\ cylinder(4, 10)", CUT, math.pi * 250),
        # several bodies with holes are the part: as a union, blended, offset, moved, in a row
        ("(box([10, 10, 1]) | translate(box([10, 10, 1]), [0, 0, 9])) \\ cylinder(1, 30)", "the bounds", 1000),
        ("offset(box([8, 8, 1]) | translate(box([8, 8, 1]), [0, 0, 7]), 1) \\ cylinder(1, 30)", "the bounds", 1000),
        ("smooth_union(cube(10), translate(cube(10), [10, 0, 0]), 0.1) \\ cylinder(1, 30)", "the bounds", 2000),
        ("repeat(cube(2), [8, 8, 8], counts=[2, 2, 2]) \\ cylinder(1, 30)", "the bounds", 1000),
        ("(box([10, 10, 1]) | box([1, 1, 10])) & plane([0, 0, 1], 5)", "the bounds", 1000),
        # infill within something: that is the envelope, of one body or of several
        ("gyroid(5) & (cube(10) | translate(cube(10), [9, 0, 0]))", INTERSECTED, 1900),
        ("(gyroid(5) | shell(sphere(9), 1)) & cube(20)", INTERSECTED, 8000),
        ("cube(20) \\ cylinder(2, 30) & gyroid(5)", INTERSECTED, 8000),
        ("repeat(sphere(2), [6, 6, 6], counts=[3, 3, 3]) & cube(18)", INTERSECTED, 5832),
    ],
)  # fmt: skip
def test_what_a_designer_takes_for_the_envelope(text: str, called: str, volume: float) -> None:
    """Of `(front | walls | back) \\ holes` it was the union itself: an acoustic panel came with a porosity of 0.3 %."""
    design = porelang.compile(text).design()
    root, found = envelope_of(design, design.of(None), None, design.bounds(None))
    assert found == called
    assert design.number(node("volume", root)).value == pytest.approx(volume, rel=2e-2)


def test_a_voxel_is_proposed_for_what_is_not_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ball.pore"
    path.write_text("shell(sphere(9mm), 0.4mm)")
    assert main(["measure", str(path), "--voxel", "0.5mm"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    proposed = re.search(r"use --voxel (\S+)mm", last)
    assert proposed is not None, last
    assert float(proposed[1]) == pytest.approx(0.4 / 2.5, rel=0.15)
    assert main(["measure", str(path), "--voxel", f"{proposed[1]}mm"]) == 0
    told = capsys.readouterr().out
    assert "not known" not in told
    assert "use --voxel" not in told
    assert re.search(r"pieces of void +2\n", told)


def test_what_a_voxel_takes_is_said_of_many_samples() -> None:
    assert takes(np.array([80.0, 80, 80]), 0.2) == ""  # 64 million
    assert takes(np.array([80.0, 80, 80]), 0.1) == "that takes some 520 million samples"
    assert "take a part of it, with --bounds" in takes(np.array([80.0, 80, 80]), 0.05)
    assert "take a part of it, with --bounds" in takes(np.array([80.0, 80, 80]), 0.1, MOST_NODES)


def test_bounds_cut_the_part_and_its_envelope() -> None:
    found = report("sphere(10)", bounds=(0, -10, -10, 10, 10, 10))
    assert found["volume"] == pytest.approx(2 / 3 * math.pi * 1000, rel=2e-3)


def test_an_unknown_envelope_is_named() -> None:
    with pytest.raises(porelang.PoreError) as caught:
        report("let cyl = cylinder(5, 5)\ncyl", within="cil")
    assert "did you mean `cyl`?" in str(caught.value)


@pytest.mark.slow
def test_the_command_prints_the_keys_of_the_contract(capsys: pytest.CaptureFixture[str], tmp_path: object) -> None:
    path = f"{tmp_path}/part.pore"
    with open(path, "w") as file:
        file.write('let c = cylinder(8, 8)\nlet g = gyroid(8)\ncheck porosity(g, c) > 60%, "too dense"\ng & c\n')
    assert main(["measure", path, "--json", "--resolution", "30"]) == 1
    found = json.loads(capsys.readouterr().out)
    keys = {
        "bounds",
        "voxel",
        "volume",
        "envelope_volume",
        "porosity",
        "area",
        "solid_components",
        "void_components",
        "open_void_fraction",
        "euler",
        "error",
    }
    assert keys <= found.keys()
    assert [d["code"] for d in found["failed_checks"]] == ["E068"]
    assert abs(found["porosity"] - 0.5) < 0.02
    assert main(["check", path, "-q"]) == 0
    assert main(["check", path, "-q", "--measure"]) == 1


@pytest.mark.slow
def test_from_python() -> None:
    found = porelang.compile("param r = 5 in 1..9\nlet b = box([20, 20, 20])\nsphere(r) & b").measure(
        "part", within="b", r=6
    )
    assert abs(found["porosity"] - (1 - 4 / 3 * math.pi * 216 / 8000)) <= found["error"]["porosity"]


@pytest.mark.parametrize(
    "text",
    [
        "(gyroid(8) & cylinder(20, 40)) \\ cylinder(5, 50)",
        "gyroid(8) & (cylinder(20, 40) \\ cylinder(5, 50))",
        "gyroid(8) \\ cylinder(5, 50) & cylinder(20, 40)",
        "gyroid(8) & cylinder(20, 40) \\ cylinder(5, 50) & sphere(100)",
    ],
)
@pytest.mark.slow
def test_the_envelope_does_not_depend_on_how_a_part_is_written(text: str) -> None:
    cylinder = math.pi * 400 * 40
    assert enveloped(text)[1] == pytest.approx(cylinder, rel=1e-3)


@pytest.mark.slow
def test_the_porosity_is_that_of_the_envelope() -> None:
    found = report("gyroid(8) & (cylinder(10, 8) \\ cylinder(2.5, 10))", resolution=24)
    cylinder = math.pi * 100 * 8
    assert found["envelope_volume"] == pytest.approx(cylinder, rel=1e-3)
    assert found["porosity"] == pytest.approx(1 - found["volume"] / cylinder, abs=1e-3)  # type: ignore[operator]


@pytest.mark.slow
def test_a_shape_of_planes_is_an_envelope_and_a_lattice_cut_by_planes_is_none() -> None:
    _, volume = enveloped("(gyroid(8) & tetrahedron(20)) \\ sphere(3)")
    assert volume == pytest.approx(8 * math.sqrt(3) * 20**3, rel=2e-3)
    sides = " & ".join(f"plane({n}, 10)" for n in ("[1,0,0]", "[-1,0,0]", "[0,1,0]", "[0,-1,0]", "[0,0,1]", "[0,0,-1]"))
    called, volume = enveloped(f"(gyroid(8) & {sides}) \\ sphere(3)")
    assert called == "the bounds"
    assert volume == pytest.approx(20**3, rel=1e-2)


@pytest.mark.parametrize("voxel", [1e-5, 1e-7, 1e-300])
def test_a_voxel_that_is_too_fine_is_refused_before_anything_is_allocated(voxel: float) -> None:
    with pytest.raises(porelang.PoreError, match="E114"):
        report("torus(20, 5)", voxel=voxel)


def test_a_check_that_its_error_does_not_decide_is_said(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "part.pore"
    rule = 'check abs(porosity(gyroid(8), c) - 0.5) < 0.0002, "half"'
    path.write_text(f"let c = cylinder(20, 40)\n{rule}\ngyroid(8) & c\n")
    assert main(["check", str(path), "--measure"]) == 0
    assert "W203" in capsys.readouterr().err
    path.write_text(path.read_text().replace("0.0002", "0.01"))
    assert main(["check", str(path), "--measure"]) == 0
    assert "W203" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("limit", "status", "code"), [("0.2999", 0, "W203"), ("0.3001", 0, "W203"), ("0.31", 1, "E068"), ("0.29", 0, "")]
)
def test_a_check_is_open_on_either_side_of_its_limit(
    limit: str, status: int, code: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A ball of 10 mm has 0.3 mm2 of surface to a mm3; neither its area nor its volume is known exactly."""
    path = tmp_path / "part.pore"
    path.write_text(f'let body = sphere(10)\ncheck area(body) / volume(body) > {limit} / 1mm, "too little"\nbody\n')
    assert main(["check", str(path), "--measure"]) == status
    said = capsys.readouterr().err
    assert set(re.findall(r"(?:W|E)\d{3}", said)) == ({code} if code else set())
    assert main(["mesh", str(path), "-o", str(tmp_path / "a.stl"), "--resolution", "40"]) == status
    assert (tmp_path / "a.stl").exists() == (status == 0)
    if code:  # what is compared, and not only its parts
        assert code in capsys.readouterr().err
        value, error = map(float, re.findall(r"`area\(body\) / volume\(body\)` is ([\d.]+) \+- ([\d.e-]+)", said)[0])
        assert abs(value - 0.3) <= error < 0.003
    if code == "W203":
        assert abs(value - float(limit)) <= error


def test_a_number_that_a_program_computes_is_asked_for_by_name() -> None:
    """The hydraulic diameter 4 V / A of a ball is 4/3 of its radius."""
    program = porelang.compile("param r = 3mm in 1mm..9mm\nlet _d = 4 * volume(sphere(r)) / area(sphere(r))\nsphere(r)")
    for asked, r in ((program, 3), (program.design(r=6), 6)):
        found = asked.number("_d")
        assert abs(found.value - 4 * r / 3) <= found.error < 0.01 * r
    found = program.number("_d", r=np.array(7.0))
    assert abs(found.value - 28 / 3) <= found.error < 0.07
    exact = porelang.compile("param r = 3mm in 1mm..9mm\nlet k = 2 * r\nsphere(k)").number("k", settings={"r": "4mm"})
    assert (exact.value, exact.error) == (8, 0)
    for name in ("part", "q"):
        with pytest.raises(porelang.PoreError, match="E100"):
            program.number(name)
    halved = porelang.compile("let d = volume(sphere(3)) / 2\nsphere(d / 1mm^2 / 10)")
    told = halved.measure(resolution=16)["numbers"]["d"]
    assert abs(told["value"] - 18 * np.pi) <= told["error"]


def test_numbers_of_one_text_are_told_apart(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A def that asks for a number is one text and, called twice, two numbers; a check shows its own."""
    path = tmp_path / "part.pore"
    rules = 'check por(gyroid(8)) > 60%, "a"\ncheck por(sphere(5)) > 45%, "b"'
    path.write_text(f"let c = cylinder(20, 40)\ndef por(f) = porosity(f, c)\n{rules}\ngyroid(8) & c\n")
    found = porelang.compile(path=str(path)).reduced()
    exact = {0.5, 1 - 4 / 3 * math.pi * 125 / (math.pi * 400 * 40)}
    assert len(found) == 2
    assert all(any(abs(n.value - e) <= 2 * n.error for n in found.values()) for e in exact)
    assert main(["check", str(path), "--measure"]) == 1
    said = capsys.readouterr().err
    assert "is 0.49" in said or "is 0.5" in said
    assert "is 0.98" not in said


def test_a_lattice_that_ends_is_not_its_own_envelope() -> None:
    """Walls that are thinner far out have an end of their own, and are no less the infill."""
    text = "gyroid(8) |> shell(0.6) |> thicken(length(p) / 40 - 0.3, 1) & cylinder(18, 36)"
    assert enveloped(text)[1] == pytest.approx(math.pi * 18**2 * 36, rel=1e-3)
    assert 0.8 < porosity(text) < 0.9


def test_what_another_output_asks_is_not_found() -> None:
    text = "out part = sphere(3)\nout hole = sphere(3) - solve(t => porosity(sphere(t), sphere(4)), 2, 1..3)"
    assert porelang.compile(text).measure("part", voxel=1.0)["reduced"] == {}


def test_a_part_that_no_sample_meets_is_measured_without_counts() -> None:
    """A ring of wire an eighth of a voxel thick: 2 pi^2 R r^2 and 4 pi^2 R r, and no count is known."""
    found = report("torus(10, 0.05)", resolution=32)
    error = found["error"]
    assert abs(found["volume"] - 2 * math.pi**2 * 10 * 0.05**2) <= error["volume"] < 0.01 * found["volume"]  # type: ignore[operator, index]
    assert abs(found["area"] - 4 * math.pi**2 * 10 * 0.05) <= error["area"] < 0.05 * found["area"]  # type: ignore[operator, index]
    assert {error[k] for k in ("solid_components", "void_components", "open_void_fraction", "euler")} == {math.inf}  # type: ignore[index]


def test_a_field_that_is_infinite_everywhere_is_told(recwarn: pytest.WarningsRecorder) -> None:
    """Division by zero leaves a sign, and nothing else to measure; NumPy is not heard of."""
    program = porelang.compile("sphere(5) / 0")
    with pytest.raises(porelang.PoreError, match=r"E110.*infinite"):
        program.measure()
    with pytest.raises(porelang.PoreError, match=r"E093.*infinite"):
        porelang.compile('check volume(sphere(5) / 0) > 1, "a"\nsphere(1)').reduced()
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]
    (told,) = (d for d in refusals(program.design()) if "infinite nearly everywhere" in d.message)
    assert told.code in {"E110", "W211"}
    assert not refusals(porelang.compile("exp(x^2 + y^2 + z^2) - 100").design())


@pytest.mark.parametrize(
    ("text", "solids"),
    [
        ("cylinder(50, 200) | cylinder(58, 120) \\ cylinder(50.5, 130)", 2),  # half a millimetre between them
        ("torus(15, 1) | cylinder(13.95, 1)", 2),
        ("box([10, 10, 10]) | translate(box([10, 10, 10]), [10.02, 0, 0])", 2),
        ("gyroid(4) & torus(4, 0.6)", 2),  # of three in the samples two are joined by less than a voxel
    ],
)
@pytest.mark.usefixtures("roughly")
def test_a_gap_that_no_sample_meets_leaves_counts_open(text: str, solids: int) -> None:
    """No two voxels that are both wider than a gap show it, however they differ."""
    found = report(text)
    error = found["error"]["solid_components"]
    assert error > 0
    assert abs(found["solid_components"] - solids) <= error
    assert not any(piece["certain"] for piece in found["pieces"])


@pytest.mark.parametrize(
    ("text", "solids", "euler"),
    [
        ("sphere(10) \\ union([for i in range(6): translate(cylinder(0.8, 30), [3*i - 7.5, 0, 0])])", 1, 2 - 2 * 6),
        ("gyroid(4) & cylinder(10, 20)", 1, None),
        ("sphere(10) | translate(sphere(10), [19, 0, 0])", 1, 2),  # a narrow groove round the neck
        ("sphere(10) | translate(sphere(5), [20, 0, 0])", 2, 4),
    ],
)
@pytest.mark.usefixtures("roughly")
def test_what_samples_show_is_certain(text: str, solids: int, euler: int | None) -> None:
    found = report(text)
    assert found["solid_components"] == solids
    assert found["error"]["solid_components"] == 0
    assert euler is None or (found["euler"], found["error"]["euler"]) == (euler, 0)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (5593.2, 21.4, "5593 +- 21"),
        (371.7, 104.0, "370 +- 100"),
        (523.5987, 0.0423, "523.599 +- 0.042"),
        (0.5, 1.2e-4, "0.50000 +- 0.00012"),
        (0.4187, 0.4, "0.42 +- 0.40"),
        (1.674, 17.3, "1.7 +- 17"),  # known to less than its order: a value of its own all the same
        (-0.0312, 4.0, "-0.031 +- 4.0"),
        (3e-12, 1e-15, "3e-12 +- 1e-15"),
        (7.0, 0.0, "7 +- 0"),
    ],
)
def test_numbers_are_shown_to_the_place_of_their_error(value: float, error: float, text: str) -> None:
    assert figures(value, error) == text
