"""The command line as its users meet it: what is printed where, the exit status, and no traceback for any input."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from porelang.cli import main
from porelang.cli.arguments import COMMANDS
from porelang.error_codes import CODES
from porelang.mesh import Surface

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "examples"
SPECIMEN = str(EXAMPLES / "specimen.pore")


class Pore:
    """Runs commands in a folder of their own and remembers what they said."""

    def __init__(self, capsys: pytest.CaptureFixture[str], folder: Path) -> None:
        self.capsys, self.folder = capsys, folder
        self.out = self.err = ""

    def __call__(self, *words: str | Path) -> int:
        status = main([str(w) for w in words])
        self.out, self.err = self.capsys.readouterr()
        assert "Traceback" not in self.err
        return status

    def write(self, text: str, name: str = "part.pore") -> Path:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def pore(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pore:
    monkeypatch.chdir(tmp_path)
    # that loops are compiled is told once after an installation: which test meets it depends on their order
    monkeypatch.setattr("porelang.cli.commands.on_compiling", lambda say: None)
    return Pore(capsys, tmp_path)


def process(*words: str, **more: Any) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **more.pop("env", {})}
    return subprocess.run(
        [sys.executable, "-m", "porelang", *words], capture_output=True, text=True, env=environment, check=False, **more
    )


# ---- check


def test_check_of_a_sound_program_says_so_on_standard_error(pore: Pore) -> None:
    assert pore("check", SPECIMEN) == 0
    assert (pore.out, pore.err) == ("", f"{SPECIMEN}: no errors, no warnings\n")
    assert pore("check", SPECIMEN, "-q") == 0
    assert (pore.out, pore.err) == ("", "")


def test_check_reports_errors_and_counts_them(pore: Pore) -> None:
    assert pore("check", pore.write("let a = gyrod(30)\nlet b = 5mm + 3deg\na & b")) == 1
    assert "error[E030]" in pore.err
    assert "error[E062]" in pore.err
    assert pore.err.endswith("part.pore: 2 errors, no warnings\n")


def test_check_json_is_a_list_of_diagnostics(pore: Pore) -> None:
    path = pore.write("gyrod(30) & sphere(20)")
    assert pore("check", path, "--json") == 1
    (found,) = pore.json()
    assert found["code"] == "E030"
    assert found["severity"] == "error"
    assert (found["line"], found["column"], found["end_line"], found["end_column"]) == (1, 1, 1, 6)
    assert found["file"] == str(path)
    assert "gyroid" in found["hint"]
    assert pore("check", SPECIMEN, "--json") == 0
    assert pore.json() == []


def test_check_evaluates_checks_with_the_settings(pore: Pore) -> None:
    path = pore.write('param t = 3mm in 1mm..5mm\ncheck t > 2mm, "too thin to print"\nshell(sphere(20), t)')
    assert pore("check", path) == 0
    assert pore("check", path, "--set", "t=1.5mm", "--json") == 1
    (found,) = pore.json()
    assert (found["code"], found["message"]) == ("E068", "too thin to print")
    assert "t = 1.5mm" in found["label"]
    assert pore("mesh", path, "--set", "t=1.5mm", "-o", "a.stl") == 1
    assert "too thin to print" in pore.err
    assert not Path("a.stl").exists()


def test_check_measures_what_a_rule_speaks_of(pore: Pore) -> None:
    text = 'let all = cylinder(30mm, 30mm)\ncheck porosity(gyroid(20), all) > 60%, "too dense"\ngyroid(20) & all'
    assert pore("check", pore.write(text), "--measure", "--json") == 1
    (found,) = pore.json()
    assert (found["code"], found["message"], found["line"]) == ("E068", "too dense", 2)
    said = re.fullmatch(r"porosity\(gyroid\(20\), all\) is (0\.\d+) \+- (0\.\d+)", found["label"])
    assert said is not None
    assert abs(float(said[1]) - 0.5) <= float(said[2]) < 1e-3
    assert pore("check", pore.write(text.replace("60%", "40%")), "--measure") == 0


def test_warnings_are_no_errors(pore: Pore) -> None:
    path = pore.write("gyroid(x) & sphere(20)")
    assert pore("check", path) == 0
    assert "warning[W201]" in pore.err
    assert pore.err.endswith("no errors, 1 warning\n")
    assert pore("check", path, "-q") == 0
    assert pore.err == ""


# ---- mesh


def test_mesh_writes_the_surface_and_reports_it(pore: Pore) -> None:
    path = pore.write("sphere(10)")
    assert pore("mesh", path, "-o", "part.stl", "--voxel", "0.5mm", "--json") == 0
    found = pore.json()
    assert found["volume"] == pytest.approx(4 / 3 * np.pi * 1000, rel=5e-3)
    assert found["area"] == pytest.approx(4 * np.pi * 100, rel=5e-3)
    np.testing.assert_allclose(found["bounds"], [[-10] * 3, [10] * 3], atol=0.05)
    assert found["components"] == 1
    assert found["output"] == "part"
    # 80 bytes of header, the number of triangles, 50 bytes for each
    assert Path("part.stl").stat().st_size == 84 + 50 * found["triangles"]
    assert pore.err == ""


def test_mesh_report_is_text_for_people(pore: Pore) -> None:
    assert pore("mesh", pore.write("sphere(10)"), "-o", "part.ply", "--resolution", "20") == 0
    assert pore.out.startswith("part.ply\n")
    assert "triangles" in pore.out
    assert "mm3" in pore.out
    assert pore("mesh", pore.write("sphere(10)"), "-o", "part.ply", "--resolution", "20", "-q") == 0
    assert pore.out == ""


def test_settings_with_units_change_the_mesh(pore: Pore) -> None:
    path = pore.write("param r = 10mm in 1mm..30mm\nsphere(r)")
    volumes = []
    for setting in ("r=10", "r=2cm"):
        assert pore("mesh", path, "-o", "a.ply", "--resolution", "40", "--json", "--set", setting) == 0
        volumes.append(pore.json()["volume"])
    assert volumes[1] / volumes[0] == pytest.approx(8, rel=1e-3)


def test_bounds_cut_the_part_flat(pore: Pore) -> None:
    assert pore("mesh", pore.write("sphere(10)"), "-o", "a.ply", "--bounds", "-20,-20,-20,20,20,0", "--json") == 0
    found = pore.json()
    assert found["volume"] == pytest.approx(2 / 3 * np.pi * 1000, rel=5e-3)
    assert found["bounds"][1][2] == pytest.approx(0, abs=1e-9)


@pytest.mark.usefixtures("gpu")
def test_glsl_makes_the_same_mesh(pore: Pore) -> None:
    volumes = []
    for backend in ("numpy", "glsl"):
        assert pore("mesh", SPECIMEN, "-o", "a.ply", "--resolution", "64", "--backend", backend, "--json") == 0
        found = pore.json()
        assert found["backend"] == backend
        volumes.append(found["volume"])
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-5)


def test_components_are_counted() -> None:
    tetrahedron = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]], np.int32)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    many = [Surface(corners + 3 * i, tetrahedron) for i in range(17)]
    joined = Surface(
        np.concatenate([s.vertices for s in many]), np.concatenate([s.faces + 4 * i for i, s in enumerate(many)])
    )
    assert many[0].components == 1
    assert joined.components == 17
    # a long ring of triangles is one, however its vertices are numbered
    names = np.random.default_rng(3).permutation(1000)
    ring = np.stack([names, np.roll(names, 1), np.roll(names, 2)], axis=1).astype(np.int32)
    assert Surface(np.zeros((1000, 3)), ring).components == 1


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--voxel", "0"], "E108", "above 0"),
        (["--voxel", "-1mm"], "E108", "above 0"),
        (["--voxel", "nan"], "E108", "no length"),
        (["--voxel", "3deg"], "E108", "no length"),
        (["--resolution", "0"], "E108", "whole number above 0"),
        (["--resolution", "1e99"], "E108", "whole number above 0"),
        (["--voxel", "1", "--resolution", "3"], "E108", "twice"),
        (["--voxel", "1um"], "E114", "would do"),
        (["--bounds", "1,1,1,0,2,2"], "E108", "empty along x"),
        (["--bounds", "0,0,0,1,1,inf"], "E108", "six numbers"),
        (["--bounds", "-5,-5"], "E108", "six numbers"),
        (["--set", "w"], "E108", "NAME=VALUE"),
        (["--set", "v=3"], "E083", "the params are w, t"),
        (["--set", "w=nan"], "E084", "cannot be"),
        (["--set", "w=inf"], "E084", "cannot be"),
        (["--set", "w=1e999"], "E084", "cannot be"),
        (["--set", "w=3deg"], "E084", "an angle"),
        (["--set", "w=9999"], "E085", "outside its range"),
        (["--out", "prt"], "E100", "did you mean `part`"),
        (["--backend", "numppy"], "E108", "did you mean `numpy`"),
        (["--backend", "glsl", "--dtype", "f64"], "E108", "f32"),
        (["--frobnicate"], "E108", "no option `--frobnicate`"),
        (["--voxle", "1"], "E108", "did you mean `--voxel`"),
        (["more.pore"], "E108", "one word too many"),
        (["--voxel"], "E108", "`--voxel` needs a value"),
        (["--smooth=3"], "E108", "`--smooth` takes no value"),
        (["--bounds", "a: b"], "E108", "`a: b` are no bounds"),
    ],
)
def test_wrong_usage_is_told_and_writes_nothing(pore: Pore, words: list[str], code: str, says: str) -> None:
    assert pore("mesh", SPECIMEN, "-o", "a.stl", *words) == 2
    assert f"error[{code}]" in pore.err
    assert says in pore.err
    assert pore.out == ""
    assert pore("mesh", SPECIMEN, "-o", "a.stl", "--json", *words) == 2
    assert pore.json()["errors"][0]["code"] == code
    assert not list(pore.folder.iterdir())


@pytest.mark.parametrize(
    ("output", "code"), [("part.stll", "E112"), ("part", "E112"), ("no/such/part.stl", "E113"), (".", "E113")]
)
def test_output_that_cannot_be_written_is_refused_before_the_work(pore: Pore, output: str, code: str) -> None:
    assert pore("mesh", SPECIMEN, "-o", output, "--voxel", "0.01mm") == 2
    assert f"error[{code}]" in pore.err


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("gyroid(10)", "E102"),
        ("sphere(5) & translate(sphere(5), [20, 0, 0])", "E103"),
        ("p", "E101"),
        ("x > 0", "E101"),
        ("", "E100"),
    ],
)
def test_part_without_a_surface_is_the_program_s_fault(pore: Pore, text: str, code: str) -> None:
    assert pore("mesh", pore.write(text), "-o", "a.stl") == 1
    assert f"error[{code}]" in pore.err
    assert not Path("a.stl").exists()


# ---- eval


def test_eval_prints_a_value_a_line(pore: Pore) -> None:
    pore.write("x,y,z\n0,0,0\n3,4,0\n0,0,20\n", "points.csv")
    assert pore("eval", pore.write("sphere(10)"), "--points", "points.csv") == 0
    assert pore.out == "-10.0\n-5.0\n10.0\n"
    assert pore.err == ""


@pytest.mark.parametrize(
    "text",
    ["1,2,2", "1, 2, 2\n", "1 2 2", "1;2;2", "a,z,x,y\n9,2,1,2", "# mm\nX,Y,Z\n1,2,2\n\n", "\ufeffx,y,z\r\n1,2,2\r\n"],
)
def test_csv_is_read_as_people_write_it(pore: Pore, text: str) -> None:
    pore.write(text, "points.csv")
    assert pore("eval", pore.write("x + 10 * y + 100 * z"), "--points", "points.csv") == 0
    assert pore.out == "221.0\n"


def test_eval_of_arrays(pore: Pore) -> None:
    points = np.random.default_rng(1).uniform(-10, 10, (70_000, 3))
    np.save("points.npy", points)
    path = pore.write("out part = sphere(10)\nout way = p * 2\nout inside = sphere(10) < 0")
    assert pore("eval", path, "--points", "points.npy", "--output", "values.npy") == 0
    np.testing.assert_allclose(np.load("values.npy"), np.linalg.norm(points, axis=1) - 10, atol=1e-13)
    assert pore("eval", path, "--points", "points.npy", "--out", "way") == 0
    rows = [[float(v) for v in line.split(",")] for line in pore.out.splitlines()]
    np.testing.assert_array_equal(rows, 2 * points)
    assert pore("eval", path, "--points", "points.npy", "--out", "inside", "--json") == 0
    assert pore.json()["points"] == 70_000


def test_eval_uses_the_numbers_asked_for(pore: Pore) -> None:
    pore.write("0.1,0,0", "points.csv")
    path = pore.write("x * 3")
    assert pore("eval", path, "--points", "points.csv", "--json") == 0
    assert pore.json()["values"] == [0.1 * 3]
    assert (pore.json()["backend"], pore.json()["dtype"]) == ("numpy", "f64")
    assert pore("eval", path, "--points", "points.csv", "--dtype", "f32", "--backend", "numpy", "--json") == 0
    assert pore.json()["values"] == [float(np.float32(0.1) * np.float32(3))]


@pytest.mark.usefixtures("gpu")
def test_f32_is_computed_by_the_graphics_driver_where_there_is_one(pore: Pore) -> None:
    pore.write("0.1,0,0", "points.csv")
    assert pore("eval", pore.write("x * 3"), "--points", "points.csv", "--dtype", "f32", "--json") == 0
    assert pore.json()["backend"] == "glsl"
    assert pore.json()["values"][0] == pytest.approx(0.3, rel=1e-6)


def test_points_from_standard_input() -> None:
    done = process("eval", SPECIMEN, "--points", "-", input="x,y,z\n0,0,0\n")
    assert (done.returncode, done.stdout, done.stderr) == (0, "-0.765\n", "")


def test_the_program_from_standard_input(tmp_path: Path) -> None:
    done = process("check", "-", input="sphere(5) & y9\n")
    assert done.returncode == 1
    assert "--> <stdin>:1:13" in done.stderr
    assert "<stdin>: 1 error" in done.stderr
    for words in (
        ["measure", "-", "--resolution", "8"],
        ["mesh", "-", "-o", str(tmp_path / "a.obj"), "--voxel", "1mm"],
    ):
        assert process(*words, input="sphere(5)\n").returncode == 0
    assert "# program <stdin>" in (tmp_path / "a.obj").read_text(encoding="ascii")
    for twice in (["eval", "-", "--points", "-"], ["watch", "-", "--", "mesh", "-o", "a.stl"]):
        refused = process(*twice, input="sphere(5)\n")
        assert refused.returncode == 2
        assert "E108" in refused.stderr


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"1,2\n", "2 numbers"),
        (b"1,2,3\n4,5\n", "line 2"),
        (b"one,two,three\n", "line 1"),
        (b"1,2,nan\n", "no place"),
        (b"1,2,inf\n", "no place"),
        (b"\x93NUMPY garbage", "cannot be read"),
        (b"\xff\xfe\x00", "neither"),
    ],
)
def test_points_that_are_none(pore: Pore, content: bytes, says: str) -> None:
    Path("points.csv").write_bytes(content)
    assert pore("eval", SPECIMEN, "--points", "points.csv") == 2
    assert "error[E104]" in pore.err
    assert says in pore.err


def test_arrays_that_hold_no_points(pore: Pore) -> None:
    for name, array in {
        "flat": np.zeros((4, 2)),
        "words": np.array(["a"]),
        "complex": np.zeros((2, 3), complex),
    }.items():
        np.save(f"{name}.npy", array)
        assert pore("eval", SPECIMEN, "--points", f"{name}.npy") == 2
        assert "error[E104]" in pore.err
    np.save("objects.npy", np.array([{}], dtype=object), allow_pickle=True)
    assert pore("eval", SPECIMEN, "--points", "objects.npy") == 2
    assert pore("eval", SPECIMEN, "--points", "missing.npy") == 2
    assert "error[E105]" in pore.err


def test_no_points_have_no_values(pore: Pore) -> None:
    pore.write("x,y,z\n", "points.csv")
    assert pore("eval", SPECIMEN, "--points", "points.csv") == 0
    assert pore.out == ""


# ---- show, glsl, notation, explain


def test_show_prints_the_graph_after_a_pass(pore: Pore) -> None:
    path = pore.write("out a = sphere(10) + 0\nout b = (x + 1) @ [y, y, y]")
    assert pore("show", path, "--after", "lower", "--out", "b") == 0
    assert "at" in pore.out
    assert pore("show", path, "--after", "place", "--out", "b") == 0
    assert pore.out == "%0 = add y, 1.0\nb = %0\n"
    assert pore("show", path, "--out", "b", "--note", "axes") == 0
    assert "; y" in pore.out
    assert pore("show", path, "--note", "bounds", "--json") == 0
    assert any("within (-10, -10, -10) .. (10, 10, 10)" in line for line in pore.json()["lines"])
    assert pore("show", path, "--after", "bounds") == 2
    assert "--note bounds" in pore.err
    assert pore("show", path, "--after", "simplfy") == 2
    assert "did you mean `simplify`" in pore.err


def test_glsl_prints_a_shader(pore: Pore) -> None:
    assert pore("glsl", SPECIMEN) == 0
    assert pore.out.startswith("#version 430")
    assert "float field(vec3 p)" in pore.out
    assert pore("glsl", SPECIMEN, "--stage", "webgl") == 0
    assert pore.out.startswith("#version 300 es")
    assert pore("glsl", SPECIMEN, "--json") == 0
    assert "void main" in pore.json()["text"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("gyroid(30)", ["(F)(C)(W)(F)"]),
        ("gyroid([10, 20, 30])", ["(F)(C_X, C_Y, C_Z)(W)(F)"]),
        ("gyroid(10 + hypot(x, y))", ["(F)(F)(W)(F)"]),
        ("gyroid(phase=p / 10)", ["(F)(C)(W)(F)"]),
        ("param k = gyroid in {gyroid, diamond}\nk(10)", ["(F)(C)(T)(F)", "(F)(C)(W)(F)"]),
        ("let s = sphere(40) / 9\ngyroid(9) |> thicken(s, 0.3)", ["(F)(C)(W)(F)", "(F_A)(F_B)(D)(F)"]),
        ("gyroid(9) |> thicken(0.3)", ["(F)(C)(W)(F)", "(F)(C)(D)(F)"]),
        ("sphere(9) |> shell(1)", ["(F)(C)(D)(F)"]),
        ("sphere(9) |> shell(1 + abs(z) / 9)", ["(F)(F)(D)(F)"]),
        ("box([1, 2, 3]) |> rotate([0, 0, 1], 30deg)", ["(F)(L)(S)(F)"]),
        ("box([1, 2, 3]) |> polar(30)", ["(F)(V)(S)(F)"]),
        ("box([1, 2, 3]) |> twist(0.1)", ["(F)(C)(S)(F)"]),
        ("morph(sphere(5), cube(5), 0.5)", ["(F_A, F_B)(C)(R)(F_R)"]),
        ("blend(sphere(5), cube(5), along=z, r=3)", ["(F_A, F_B)(F_C)(R)(F_R)"]),
    ],
)
def test_notation_is_the_paper_s(pore: Pore, text: str, expected: list[str]) -> None:
    assert pore("notation", pore.write(text), "--json") == 0
    assert [step["notation"] for step in pore.json()] == expected


def test_explain_prints_a_page_or_the_list(pore: Pore) -> None:
    assert pore("explain", "e062") == 0
    assert pore.out.startswith("E062: units that do not fit")
    assert "Wrong:" in pore.out
    assert pore("explain") == 0
    assert [line.split()[0] for line in pore.out.splitlines()] == sorted(CODES)
    assert pore("explain", "E998") == 2
    assert pore("explain", "E062", "--json") == 0
    assert pore.json()["code"] == "E062"


# ---- the whole


def test_help_lists_every_command_and_no_other(pore: Pore) -> None:
    assert pore("--help") == 0
    assert all(f"\n    {name}" in pore.out for name in COMMANDS)
    for name in COMMANDS:
        assert pore(name, "--help") == 0
        assert COMMANDS[name].example in pore.out
    assert pore() == 2
    assert pore("--version") == 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["check"], "`pore check` needs FILE"),
        (["mesh"], "`pore mesh` needs FILE and --output"),
        (["slices", "a.pore", "-o", "layers"], "`pore slices` needs --step"),
        (["eval", "--json"], "`pore eval` needs FILE and --points"),
        (["mesh", "a.pore", "-o"], "`--output` needs a value"),
        (["mesh", "a.pore", "-o", "--json"], "`--output` needs a value"),
        (["mesh", "-"], "`pore mesh` needs --output"),
        (["-"], "no command `-`"),
        (["--json", "check"], "`pore` has no option `--json`"),
        (["glsl", "a.pore", "--stage", "compile"], "`--stage` cannot be `compile`"),
    ],
)
def test_what_is_missing_is_named(pore: Pore, words: list[str], says: str) -> None:
    """In words of ours: those of `argparse` differ from one Python to the next."""
    assert pore(*words) == 2
    assert "error[E108]" in pore.err
    assert says in pore.err
    assert "= hint: " in pore.err


def test_options_may_stand_before_the_file(pore: Pore) -> None:
    assert pore("check", "-q", SPECIMEN) == 0
    assert pore("explain", "--json", "E062") == 0
    assert pore.json()["code"] == "E062"


def test_unknown_commands_are_told(pore: Pore) -> None:
    assert pore("chek", SPECIMEN) == 2
    assert "did you mean `check`" in pore.err
    assert pore("part.pore") == 2
    assert "pore check part.pore" in pore.err
    assert pore("--loud") == 2
    assert "no option `--loud`" in pore.err


@pytest.mark.parametrize(
    ("content", "status"),
    [
        (b"", 1),
        (b"\x00" * 100, 1),
        (bytes(range(256)), 1),
        (b"\xef\xbb\xbfsphere(10)\r\n", 0),
        (b"(" * 100_000, 1),
        (b"(" * 100_000 + b"1" + b")" * 100_000, 1),
        (b"-" * 100_000 + b"1", 1),
        (b"let a = 1\n" * 1_000_000, 1),
        (b"sphere(1) |\n" * 20_000 + b"sphere(2)", 0),
        (b'"' * 9999, 1),
        ("sphere(10) # \U0001f9ff \u202e".encode(), 0),
    ],
    ids=["empty", "zeros", "bytes", "bom", "open", "nested", "minus", "10MB", "union", "quotes", "unicode"],
)
def test_whatever_the_file_holds_there_is_an_answer(pore: Pore, content: bytes, status: int) -> None:
    Path("part.pore").write_bytes(content)
    assert pore("check", "part.pore", "--json") == status
    assert all(found["code"] != "E199" for found in pore.json())


def test_files_that_cannot_be_read(pore: Pore) -> None:
    for file in (str(pore.folder), "missing.pore", "a" * 5000, "part.pore/x"):
        assert pore("check", file, "--json") == 2
        assert pore.json()[0]["code"] == "E105"


def test_near_file_name_is_proposed(pore: Pore) -> None:
    pore.write("sphere(1)", "Plate.pore")
    assert pore("check", "plate.pore") == 2
    assert "did you mean `Plate.pore`" in pore.err


def test_bug_is_told_kindly_and_traced_on_request(
    pore: Pore, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from porelang.cli import commands

    def broken(options: object) -> int:
        return int("no number")

    monkeypatch.setitem(commands.RUN, "show", broken)
    assert pore("show", SPECIMEN) == 1
    assert "error[E199]" in pore.err
    assert "report" in pore.err
    monkeypatch.setenv("PORELANG_DEBUG", "1")
    assert main(["show", SPECIMEN]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_reader_that_goes_away_is_no_error() -> None:
    source = f"{sys.executable} -m porelang show {SPECIMEN} --after lower | head -1; exit ${{PIPESTATUS[0]}}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(["bash", "-c", source], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode in (0, 141)
    assert done.stderr == ""


@pytest.mark.slow
def test_interruption_leaves_nothing_behind(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "porelang",
        "mesh",
        SPECIMEN,
        "-o",
        str(tmp_path / "a.stl"),
        "--resolution",
        "900",
        "-q",
    ]
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    time.sleep(1.5)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert (out, err) == ("", "")
    assert not list(tmp_path.iterdir())


def test_colour_only_where_it_is_seen(pore: Pore, monkeypatch: pytest.MonkeyPatch) -> None:
    path = pore.write("gyrod(30)")
    assert pore("check", path) == 1
    assert "\033" not in pore.err
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert pore("check", path) == 1
    assert "\033[" in pore.err
    monkeypatch.setenv("NO_COLOR", "1")
    assert pore("check", path) == 1
    assert "\033" not in pore.err


def test_python_m_porelang_is_pore() -> None:
    done = process("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("pore ")


@pytest.mark.slow
def test_no_opengl_is_a_missing_piece_named_with_its_remedy(tmp_path: Path) -> None:
    """NumPy stands in for OpenGL where nobody insists, and says so; who insists is told what to install."""
    mesh = ("mesh", SPECIMEN, "-o", str(tmp_path / "a.stl"), "--resolution", "64", "--dtype", "f32")
    without = {"PORELANG_GL": "none"}
    done = process(*mesh, env=without)
    assert done.returncode == 0
    assert "NumPy computes instead" in done.stderr
    assert "(numpy, f32)" in done.stdout
    done = process(*mesh, "--backend", "glsl", "--json", env=without)
    assert done.returncode == 3
    assert "error[E120]" in done.stderr
    assert "hint" in done.stderr
    assert json.loads(done.stdout)["errors"][0]["code"] == "E120"


def test_mesh_needs_no_opengl_unless_it_is_asked_for(pore: Pore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_GL", "none")
    assert pore("mesh", SPECIMEN, "-o", "a.stl", "--resolution", "64", "--json", "-q") == 0
    assert (pore.json()["backend"], pore.json()["dtype"], pore.err) == ("numpy", "f32", "")


def test_show_takes_settings(pore: Pore) -> None:
    """What is set is a value in the notes, what is not keeps its range."""
    path = pore.write("param r = 5mm in 1mm..9mm\nparam d = 1mm in 0mm..2mm\nsphere(r + d)")
    assert pore("show", path, "--note", "bounds") == 0
    assert "within (-6, -6, -6)" in pore.out
    assert "1 .. 11" in pore.out
    assert pore("show", path, "--note", "bounds", "--set", "r=0.8cm") == 0
    assert "within (-9, -9, -9)" in pore.out
    assert "8 .. 10" in pore.out
    assert pore("show", path, "--set", "q=3") == 2
    assert "E083" in pore.err


def test_show_with_bounds_tells_the_box_and_the_steepness(pore: Pore) -> None:
    Path("ball.pore").write_text("sphere(5) |> translate([10, 0, 0])\n")
    assert pore("show", "ball.pore", "--note", "bounds") == 0
    last = pore.out.strip().splitlines()[-1]
    assert "within (5, -5, -5) .. (15, 5, 5) mm" in last
    assert 1 <= float(last.split("<=")[1].split()[0]) < 2  # exactly 1: the enclosure may be loose, never less
    Path("raw.pore").write_text("gyroid(30)\n")
    assert pore("show", "raw.pore", "--note", "bounds") == 0
    assert "no end along x, y, z" in pore.out


@pytest.mark.slow
def test_a_run_that_is_ended_from_outside_leaves_nothing_behind(tmp_path: Path) -> None:
    """SIGTERM, as a job scheduler sends it, cleans up as Ctrl-C does."""
    command = [sys.executable, "-m", "porelang", "mesh", SPECIMEN, "--resolution", "300", "-o", str(tmp_path / "a.stl")]
    running = subprocess.Popen([*command, "-q"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not list(tmp_path.iterdir()) and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)  # until the file under its other name appears
    running.terminate()
    _, said = running.communicate(timeout=60)
    assert running.returncode == 143
    assert "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


def test_what_other_programs_call_an_option_is_known(pore: Pore) -> None:
    path = pore.write("sphere(3)")
    for theirs, ours in (("--section", "--cut"), ("--clip", "--cut")):
        assert pore("render", path, theirs, "a.png") == 2
        assert f"did you mean `{ours}`?" in pore.err
    assert pore("mesh", path, "-o", "a.stl", "--spacing", "1mm") == 2
    assert "did you mean `--voxel`?" in pore.err


def test_what_a_program_says_is_no_option(pore: Pore) -> None:
    path = pore.write("let b = cube(9mm)\nlet s = compress(b, 1kN, E=2GPa, nu=0.3)\nb")
    for command in ("fea", "optimize"):
        assert pore(command, path, "--size", "3mm") == 2
        assert "an argument of the study: `compress(part, 10kN, ..., size=3mm)`" in pore.err
    assert pore("fea", path, "--material", "PA12") == 2
    assert "--set" not in pore.err


def test_an_option_with_one_value_is_given_once(pore: Pore) -> None:
    path = pore.write('param w = 3 in 1..5\npreset "a": w = 2\npreset "b": w = 4\nsphere(w)')
    for twice in (["--preset", "a", "--preset", "b"], ["--preset=a", "--preset=b"]):
        assert pore("check", path, *twice) == 2
        assert "`--preset` is given twice" in pore.err
    assert pore("mesh", path, "-o", "a.stl", "--voxel", "1mm", "--voxel", "2mm") == 2
    assert "`--voxel` is given twice" in pore.err
    assert pore("check", path, "--set", "w=2", "--set", "w=4") == 2
    assert "`w` is set twice: 2 and 4" in pore.err
    assert pore("check", path, "--preset", "a", "--preset", "a", "--set", "w=4") == 0


def test_a_number_that_is_the_same_everywhere_has_no_least_place(pore: Pore) -> None:
    path = pore.write("let spots = [1, 2]\nout count = len(spots)\nout part = sphere(2)")
    assert pore("mesh", path, "--out", "count", "-o", "a.stl") == 1
    assert "it is the number 2 everywhere" in pore.err
    assert "samples" not in pore.err


def test_bounds_beyond_the_world_are_refused(pore: Pore) -> None:
    assert pore("mesh", SPECIMEN, "-o", "a.stl", "--bounds", "0,0,0,1e308,1e308,1e308") == 2
    assert "E117" in pore.err


def test_an_array_that_claims_more_than_it_holds_is_said_to(pore: Pore) -> None:
    path = pore.write("sphere(3)")
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }".ljust(117) + b"\n"
    (pore.folder / "points.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + b"0" * 99)
    assert pore("eval", path, "--points", "points.npy") == 2
    assert "E104" in pore.err
    assert "points.npy" in pore.err
