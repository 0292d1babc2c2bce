"""The Python API as a notebook uses it: what is offered and shown, lengths as texts, checks and warnings, pickles."""

from __future__ import annotations

import copy
import json
import os
import pickle
import pydoc
import re
import subprocess
import sys
import threading
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.diagnostics import Diagnostic, PoreError, PoreWarning

ROOT = Path(__file__).parent.parent
TEXT = """
param w = 12mm in 10mm..20mm step 1mm "unit cell"
param kind = gyroid in {gyroid, schwarz_p}
let heat = x / 10
let ball = sphere(8mm)
out part = kind(w) & ball
out cold = translate(ball, [30, 0, 0])
out way = grad(ball)
"""
FAILING = 'param r = 5mm in 1mm..9mm\ncheck r < 4mm, "too large"\nsphere(r)'
#: At eight samples along its side a ball lacks 4 % of its volume.
COARSE = 8


@pytest.fixture(scope="module")
def program() -> porelang.Program:
    return porelang.compile(TEXT, name="demo.pore")


# ---- what is offered ------------------------------------------------------------------------------------------------


def test_the_package_offers_its_names_and_no_others() -> None:
    shown = [name for name in dir(porelang) if not name.startswith("__")]
    assert shown == sorted(shown)
    assert {"compile", "PoreError", "PoreWarning", "Program", "Design", "Picture", "SampledField"} <= set(shown)
    assert not {"Any", "annotations", "TYPE_CHECKING", "_FROM"} & set(shown)
    assert all(hasattr(porelang, name) for name in porelang.__all__)
    assert "compile" in pydoc.plain(pydoc.render_doc(porelang))


def test_nothing_heavy_is_imported_for_a_look_at_the_names() -> None:
    code = (
        "import sys, porelang; dir(porelang); hasattr(porelang, 'nothing');"
        "print([m for m in ('numpy', 'trimesh', 'moderngl', 'numba', 'scipy', 'PIL') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_the_types_are_told_to_checkers() -> None:
    assert (Path(porelang.__file__).parent / "py.typed").exists()


def test_what_is_set_of_a_design_is_set_besides() -> None:
    program = porelang.compile(
        "param r = 5mm in 1mm..9mm\nparam h = 2mm in 1mm..9mm\nparam n = 1 in 1..3 step 1\n"
        'preset "wide": r = 8mm\nunion([for i in range(n): cylinder(r, h) |> translate([0, 20mm * i, 0])])'
    )
    design = program.design(r=6)
    assert design.design() is design
    assert design.bounds().hi == pytest.approx((6, 6, 1), abs=1e-6)
    assert design.bounds(h="4mm").hi == pytest.approx((6, 6, 2), abs=1e-6)
    assert design.bounds(preset="wide").hi == pytest.approx((8, 8, 1), abs=1e-6)
    assert design.design(n=3).design(h=4).settings == {"r": 6, "h": 4, "n": 3}
    assert program.design(n=3).bounds(n=1, r=6).hi == pytest.approx((6, 6, 1), abs=1e-6)
    assert program.design(n=3).bounds(r=6).hi == pytest.approx((6, 46, 1), abs=1e-6)
    with pytest.raises(PoreError, match="`m` is neither an option of what is asked nor a param"):
        design.mesh(m=3)


def test_options_are_named_as_python_has_them() -> None:
    """What is proposed can be pasted: it mends the mesh."""
    program = porelang.compile("gyroid(10) |> shell(0.3) & sphere(10)")
    with pytest.raises(PoreError) as caught:
        program.mesh(voxel=2)
    assert not re.search(r"--[a-z]", str(caught.value))
    assert "force=True" in str(caught.value)
    proposed = re.search(r'voxel="([\d.]+mm)"', str(caught.value))
    assert proposed is not None
    assert program.mesh(voxel=proposed[1]).is_watertight
    assert "--voxel" in caught.value.diagnostics[0].hint, "of what programs print it is told as commands have it"
    with pytest.warns(PoreWarning, match='simplify="20mm" is larger than the part'):
        porelang.compile("sphere(5)").mesh(simplify="20mm")


# ---- what is shown --------------------------------------------------------------------------------------------------


def test_what_python_shows_is_a_line(program: porelang.Program) -> None:
    design = program.design(w=15)
    shown: list[Any] = [
        program, design, *program.params.values(), *program.outputs.values(), design.field("part"),
        design.bounds("cold"), program.source, program.outputs["part"].span, design.of("part"), design.of("part").tape,
        porelang.SampledField.from_array(np.zeros((9, 9, 9)), (0, 0, 0), 1.0),
    ]  # fmt: skip
    with pytest.raises(PoreError) as caught:
        porelang.compile("sphere(r) + q")
    shown += [caught.value, *caught.value.diagnostics]
    for one in shown:
        text = repr(one)
        assert "\n" not in text
        assert len(text) < 200, text
    assert repr(program.params["w"]) == '<param w = 12mm in 10mm..20mm step 1mm "unit cell">'
    assert repr(program.params["kind"]) == "<param kind = gyroid in {gyroid, schwarz_p}>"
    assert repr(program.params).splitlines() == [repr(p) for p in program.params.values()]
    assert repr(program.outputs["cold"]).endswith(": translate(ball, [30, 0, 0])>")
    assert repr(caught.value.diagnostics[0]) == "<error E030 at <text>:1:8: unknown name `r`>"


def test_a_long_program_is_shown_in_a_line_too() -> None:
    choices = ", ".join(f"{k}mm" for k in range(1, 60))
    text = "\n".join(f'param width_number_{i} = 5mm in {{{choices}}} "{"long " * 40}"' for i in range(40))
    program = porelang.compile(
        f"{text}\nsphere(width_number_1 +\n  width_number_2 + {' + '.join('0mm' for _ in range(60))})"
    )
    for one in (program, program.design(), *program.params.values(), *program.outputs.values()):
        assert len(repr(one)) < 250
        assert "\n" not in repr(one)


def test_what_a_notebook_shows_is_a_table(program: porelang.Program) -> None:
    html = program._repr_html_()
    for text in ("demo.pore", "unit cell", "10mm..20mm step 1mm", "{gyroid, schwarz_p}", "a vector", "cold"):
        assert text in html
    assert "[30, 0, 0]" in program.outputs._repr_html_()  # type: ignore[attr-defined]  # they are `Listed`
    assert "15mm" in program.design(w=15)._repr_html_()
    sly = porelang.compile('param a = 1 in 0..2 "<script>alert(1)</script> & more"\nsphere(5 + a)')
    assert "<script>" not in sly._repr_html_()
    assert "&lt;script&gt;" in sly._repr_html_()


def test_ipython_finds_what_it_shows(program: porelang.Program) -> None:
    formatters = pytest.importorskip("IPython.core.formatters")
    formatter = formatters.DisplayFormatter()
    for one in (program, program.design(), program.params, program.outputs):
        found, _ = formatter.format(one)
        assert {"text/plain", "text/html"} <= set(found)


class Shell:
    """As much of IPython's shell as an extension needs."""

    def __init__(self) -> None:
        self.user_ns: dict[str, Any] = {}
        self.magics: dict[str, Any] = {}

    def register_magic_function(self, function: Any, kind: str, name: str) -> None:
        self.magics[name] = function


def test_a_cell_is_a_program() -> None:
    shell = Shell()
    porelang.load_ipython_extension(shell)  # type: ignore[attr-defined]  # for IPython, which asks for it by name
    shown = shell.magics["pore"]("ball", "sphere(10)\n")
    assert shown is shell.user_ns["ball"]
    assert shown.bounds().size == (20, 20, 20)
    assert shell.magics["pore"]("", "sphere(1)") is shell.user_ns["program"]
    with pytest.raises(PoreError, match="`my part` is no name"):
        shell.magics["pore"]("my part", "sphere(1)")


def test_ipython_loads_it(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    shell = pytest.importorskip("IPython.core.interactiveshell").InteractiveShell()
    assert shell.run_cell("%load_ext porelang").success
    assert shell.run_cell("%%pore ball\nsphere(10)").success
    assert shell.user_ns["ball"].output() == "part"


def test_a_report_is_a_dict_that_reads_well() -> None:
    report = porelang.compile("sphere(10)").measure(resolution=24)
    assert json.loads(json.dumps(report)) == report
    assert report["volume"] == pytest.approx(4000 / 3 * np.pi, rel=1e-3)
    assert "\n" not in repr(report)
    assert "volume" in repr(report)
    lines = str(report).splitlines()
    assert any(line.split()[0] == "volume" and "+-" in line and "mm3" in line for line in lines)
    gyroids = porelang.compile("gyroid(10) |> shell(0.5)").measure(bounds=(-5, -5, -5, 5, 5, 5), resolution=8)
    assert gyroids["error"]["solid_components"] > 0
    assert "not certain at this voxel" in next(s for s in str(gyroids).splitlines() if "solid_components" in s)
    assert "<table>" in report._repr_html_()  # type: ignore[attr-defined]  # it is a `Report`
    assert pickle.loads(pickle.dumps(report)) == report


# ---- what is asked --------------------------------------------------------------------------------------------------


def test_lengths_are_numbers_of_mm_or_texts_with_a_unit() -> None:
    program = porelang.compile("sphere(10)")
    assert program.mesh(voxel="1mm").volume == program.mesh(voxel=1.0).volume == program.mesh(voxel="0.1cm").volume
    assert len(program.mesh(voxel=1, simplify="0.2mm").faces) < len(program.mesh(voxel=1).faces)
    assert program.measure(voxel="1mm")["voxel"] == 1.0
    for wrong in ("3deg", "half a mm", "", "-1mm"):
        with pytest.raises(PoreError, match="voxel") as caught:
            program.mesh(voxel=wrong)
        assert caught.value.diagnostics[0].code == "E114"


def test_bounds_are_six_numbers_two_corners_or_a_text() -> None:
    program = porelang.compile("gyroid(10)")
    given: list[Any] = [(-5, -5, -5, 5, 5, 5), [[-5] * 3, [5] * 3], "-5,-5,-5,5,5,5"]
    made = [program.mesh(resolution=12, bounds=b) for b in given]
    assert made[0].volume == made[1].volume == made[2].volume
    with pytest.raises(PoreError, match="write six numbers"):
        program.mesh(resolution=12, bounds="1,2,3")


@pytest.mark.parametrize("given", ["specimen.pore", Path("parts") / "specimen.pore", "/home/me/my part.pore"])
def test_the_name_of_a_file_is_no_program(given: Any) -> None:
    with pytest.raises(PoreError, match="compile\\(path=") as caught:
        porelang.compile(given)
    assert caught.value.diagnostics[0].code == "E108"
    with pytest.raises(TypeError, match="not bytes"):
        porelang.compile(b"sphere(3)")  # type: ignore[arg-type]  # as a user might


def test_a_let_is_a_field(program: porelang.Program) -> None:
    assert program.field("heat")([[5, 0, 0]]).tolist() == [0.5]
    assert program.design(w=15).field("ball")([[0, 0, 0]]).tolist() == [-8.0]
    assert program.field("way")([[5, 0, 0]]).tolist() == [[1, 0, 0]]
    with pytest.raises(PoreError, match="did you mean `heat`") as caught:
        program.field("heal")
    assert caught.value.diagnostics[0].code == "E100"


def test_a_check_that_fails_stops_what_is_made(tmp_path: Path) -> None:
    program = porelang.compile(FAILING)
    makers: list[Any] = [
        lambda **more: program.mesh(resolution=8, **more),
        lambda **more: program.slices(folder=tmp_path / "layers", step="1mm", **more),
    ]
    for make in makers:
        with pytest.raises(PoreError, match="too large") as caught:
            make()
        assert caught.value.diagnostics[0].code == "E068"
        assert not (tmp_path / "layers").exists()
        make(r="3mm")
    assert program.mesh(resolution=8, check=False).volume > 0
    assert program.slices(folder=tmp_path / "layers", step="1mm", check=False)["layers"] == 10
    assert program.field()([[0, 0, 0]])[0] == -5  # who asks for numbers is not refused


def test_measuring_tells_of_checks_that_fail() -> None:
    """The command prints the report and ends with status 1; a report that is not returned helps nobody."""
    with pytest.warns(PoreWarning, match="too large"):
        report = porelang.compile(FAILING).measure(resolution=12)
    assert [d["code"] for d in report["failed_checks"]] == ["E068"]
    assert report["volume"] > 0


def test_doubts_are_warnings_at_the_caller_s_line() -> None:
    with pytest.warns(PoreWarning) as told:
        porelang.compile("sphere(10)").mesh(resolution=COARSE)
    assert [w.message.diagnostic.code for w in told] == ["W202"]  # type: ignore[union-attr]  # each is a `PoreWarning`
    assert told[0].filename == __file__
    with pytest.warns(PoreWarning, match="W201"):
        porelang.compile("sphere(x) & box([9, 9, 9])")
    with warnings.catch_warnings():
        warnings.simplefilter("error", PoreWarning)
        assert porelang.compile("sphere(10)").mesh(resolution=24).is_watertight
        with pytest.raises(PoreWarning, match="W202"):
            porelang.compile("sphere(10)").mesh(resolution=COARSE)


def test_a_setting_between_steps_is_a_warning() -> None:
    program = porelang.compile(
        "param r = 5mm in 1mm..9mm step 1mm\nparam n = 3 in 2..8\nring(translate(sphere(r), [30, 0, 0]), n)"
    )
    with pytest.warns(PoreWarning, match="between two of its steps") as told:
        program.design(r=5.3, n=4)
    assert len(told) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error", PoreWarning)
        program.design(r=6, n=5)


def test_layers_for_python(tmp_path: Path) -> None:
    layers = porelang.compile("cylinder(10, 4)").slices(folder=tmp_path / "layers", step="0.5mm", voxel="0.1mm")
    assert layers["layers"] == 8
    assert all(path.exists() for path in layers.paths)  # type: ignore[attr-defined]  # they are `Layers`
    assert layers["volume"] == pytest.approx(np.pi * 100 * 4, rel=0.01)
    assert "\n" not in repr(layers)
    assert len(repr(layers)) < 300
    with pytest.raises(PoreError, match="choose from png, svg"):
        porelang.compile("cylinder(10, 4)").slices(folder=tmp_path / "x", step=1, format="gif")  # type: ignore[arg-type]


# ---- what travels ---------------------------------------------------------------------------------------------------


def test_all_that_is_handed_out_comes_back_from_a_pickle_and_a_copy(program: porelang.Program) -> None:
    found = Diagnostic("W202", "doubtful", program.outputs["part"].span, severity="warning")
    for again in (lambda v: pickle.loads(pickle.dumps(v)), copy.copy, copy.deepcopy):
        assert repr(again(program)) == repr(program)
        assert repr(again(program.design(w=15))) == repr(program.design(w=15))
        assert again(program.field("heat"))([[5, 0, 0]]).tolist() == [0.5]
        assert repr(again(program.params)) == repr(program.params)
        assert again(program.bounds("cold")) == program.bounds("cold")
        assert str(again(PoreWarning(found))) == str(PoreWarning(found))
        assert str(again(PoreError(found))) == str(PoreError(found))


def test_threads_share_a_design(program: porelang.Program) -> None:
    design = program.design(w=13)
    points = np.random.default_rng(3).uniform(-8, 8, (1000, 3))
    expected = design.field("part")(points)
    found: list[Any] = [None] * 4

    def ask(i: int) -> None:
        found[i] = program.design(w=13).field("part")(points)

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert all(np.array_equal(f, expected) for f in found)


def test_a_notebook_shows_its_own_lines_and_what_is_wrong() -> None:
    with pytest.raises(PoreError) as caught:
        porelang.compile("gyroid(10)").mesh()  # the line that is shown
    lines = caught.value._render_traceback_()
    assert any("the line that is shown" in line for line in lines)
    assert any(line.startswith("error[E102]") for line in lines)
    assert not any(f"{Path(porelang.__file__).parent}{os.sep}" in line for line in lines)


def test_ipython_shows_a_program_s_errors_without_ours(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    shell = pytest.importorskip("IPython.core.interactiveshell").InteractiveShell()
    shell.run_cell("import porelang\nporelang.compile('spere(3)')")
    out = "".join(capsys.readouterr())
    assert "did you mean `sphere`" in out
    assert "compiler.py" not in out
    assert "bug" not in out


def test_a_command_in_a_text_is_that_of_python() -> None:
    def said(hint: str) -> str:
        return str(PoreError(Diagnostic("E100", "no", hint=hint)))

    assert "finer there, `program.study(refine=True)`" in said("finer there, `pore fea --refine`")
    whole = "`pore optimize FILE --iterate part --rule optimum`"
    assert whole in said(whole)
    assert "refine=True mends it" in said("--refine mends it")


def test_a_slip_in_an_option_or_a_name_is_guessed() -> None:
    program = porelang.compile("param w = 3 in 1..9\nlet ball = sphere(w)\nball")
    with pytest.raises(PoreError, match="did you mean the option `resolution`") as caught:
        program.mesh(resolutoin=20)
    assert caught.value.diagnostics[0].code == "E083"
    with pytest.raises(PoreError, match="`q` is neither an option of what is asked nor a param"):
        program.mesh(q=20)
    with pytest.raises(PoreError, match="`ball` is a let"):
        program.mesh("ball")


def test_the_text_of_an_error_says_where_and_what() -> None:
    with pytest.raises(PoreError) as caught:
        porelang.compile("let a = spere(3)\na", name="demo.pore")
    assert "demo.pore:1:9" in str(caught.value)
    assert "did you mean `sphere`" in str(caught.value)
