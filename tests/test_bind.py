"""Data for params that take some: from Python and from the command line."""

from __future__ import annotations

import json
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

import porelang
from porelang.cli import main
from porelang.cli.loading import load
from porelang.cli.parsing import parse
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, PoreError

DATA = Path(__file__).parent / "data"
TEXT = """param w = 8mm in 4mm..12mm
param n = 2 in 1..4
param stress: field = 3MPa "von Mises"
param flow: vector = [1mm, 0, 0]
let body = cube(20)
out s = stress
out v = flow
out parts = union([for i in range(n): translate(sphere(2mm + stress / 1MPa * 1mm), [9 * i, 0, 0])])
out part = gyroid(w) |> shell(0.8) |> thicken(-stress / 40MPa, 0.4) & body
"""
Q = np.random.default_rng(3).uniform(-9, 9, (300, 3))
BOX: Any = {"within": ((-10, -10, -10), (10, 10, 10))}


def program() -> porelang.Program:
    return porelang.compile(TEXT)


def affine(p: Any) -> Any:
    return p @ np.array([1.0, 2, 3])


def told(bind: Callable[[], object]) -> Diagnostic:
    with pytest.raises(PoreError) as error:
        bind()
    (found,) = error.value.diagnostics
    assert found.hint
    return found


def test_what_is_not_bound_has_its_default() -> None:
    made = program()
    assert set(made.data) == {"stress", "flow"}
    assert repr(made.data["stress"]) == '<param stress: field in N/mm^2 "von Mises">'
    assert "stress" not in made.params
    assert (made.field("s")(Q) == 3).all()
    assert (made.field("v")(Q) == [1, 0, 0]).all()


def test_a_function_is_sampled(backend: str) -> None:
    made = program().bind(stress=affine, flow=lambda p: p * 2, voxel="1.5mm", **BOX)
    options: dict[str, Any] = {"backend": backend, "dtype": "f32"} if backend == "glsl" else {}
    tolerance = 1e-4 if backend == "glsl" else 1e-12
    np.testing.assert_allclose(made.field("s", **options)(Q), affine(Q), atol=tolerance)
    np.testing.assert_allclose(made.field("v", **options)(Q), 2 * Q, atol=tolerance)
    named = program().bind(stress=affine, voxel=1, within="body")
    np.testing.assert_allclose(named.field("s")(Q), affine(Q), atol=1e-12)


def test_an_array_spans_its_box() -> None:
    axis = np.linspace(-10, 10, 11)
    values = affine(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1))
    made = program().bind(stress=values, **BOX)
    np.testing.assert_allclose(made.field("s")(Q), affine(Q), atol=1e-12)
    assert made.field("s")([[99.0, 99, 99]])[0] == 60  # beyond its ends it goes on as there


def test_a_tensor_is_bound(backend: str) -> None:
    """Its principal value against NumPy's, of a tensor that is linear in space."""
    text = "param s: tensor = tensor(0MPa, 0, 0, 0, 0, 0)\nout part = principal(s, 1).value"
    slopes = np.random.default_rng(5).normal(size=(3, 6))
    made = porelang.compile(text).bind(s=lambda p: p @ slopes + [9, 5, 1, 2, 3, 4], voxel=1, **BOX)
    xx, yy, zz, xy, yz, xz = (Q @ slopes + [9, 5, 1, 2, 3, 4]).T
    largest = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).T)[:, -1]
    options: dict[str, Any] = {"backend": backend, "dtype": "f32"} if backend == "glsl" else {}
    np.testing.assert_allclose(made.field("part", **options)(Q), largest, atol=1e-4 if backend == "glsl" else 1e-12)
    assert repr(made.data["s"]) == "<param s: tensor in N/mm^2>"
    assert porelang.compile(text).field("part")([[1.0, 2, 3]])[0] == 0


def test_samples_are_taken_as_they_are() -> None:
    grid = SampledField.from_array(np.arange(8.0).reshape(2, 2, 2), (0, 0, 0), 1.0)
    made = program().bind({"stress": grid})
    assert made.field("s")([[0.5, 0.5, 0.5]])[0] == 3.5
    again = made.bind(flow=np.ones((2, 2, 2, 3)), within=((0, 0, 0), (1, 1, 1)))
    assert again.field("s")([[0.5, 0.5, 0.5]])[0] == 3.5  # what else is bound stays
    assert (again.field("v")(Q) == 1).all()
    assert (made.field("v")(Q) == [1, 0, 0]).all()
    other = made.bind(stress=SampledField.from_array(np.full((2, 2, 2), 7.0), (0, 0, 0), 1.0))
    assert [d.values[0, 0, 0, 0] for d in other.held.values()] == [7]


@pytest.mark.parametrize("n", [1, 3])
def test_settings_variants_and_pickles_keep_what_is_bound(n: int) -> None:
    """A param that counts compiles the program anew; so does a pickle."""
    where = ((-10, -10, -10), (30, 10, 10))
    made = program().bind(stress=lambda p: p[:, 0] / 10, voxel=1, within=where)
    for other in (made, pickle.loads(pickle.dumps(made))):
        found = other.design(n=n)
        value = found.field("parts")([[9.0 * (n - 1), 0, 0]])[0]
        assert abs(value + 2) < 1e-9
        np.testing.assert_allclose(pickle.loads(pickle.dumps(found)).field("s")(Q), Q[:, 0] / 10, atol=1e-12)
    assert len(made.mesh("part", voxel=1.0, force=True).faces) > 1000


def test_numbers_from_bound_fields_are_kept_by_what_is_bound() -> None:
    text = "param f: field = 1\nlet m = mean(f, sphere(5))\nout part = sphere(m)"
    where: Any = {"voxel": 1, "within": ((-6,) * 3, (6,) * 3)}
    first = porelang.compile(text).bind(f=lambda p: p[:, 0] + 2, **where)
    second = first.bind(f=lambda p: p[:, 0] + 4, **where)
    assert porelang.compile(text).number("m").value == 1
    for made, mean in ((first, 2), (second, 4), (first, 2)):
        found = made.number("m")
        assert abs(found.value - mean) <= found.error < 0.05


def bind(**more: Any) -> Callable[[], object]:
    return lambda: program().bind(**{**BOX, **more})


def fails(points: Any) -> Any:
    raise ValueError("out of bounds")


WRONG: dict[str, tuple[Callable[[], object], str, str]] = {
    "no such param": (bind(stres=affine, voxel=1), "no param `stres`", "`stress`"),
    "a number": (bind(w=affine, voxel=1), "`w` is a number", "--set w="),
    "no voxel": (bind(stress=affine), "no samples", "voxel"),
    "no box": (bind(stress=affine, voxel=1, within=None), "where it lies", "within"),
    "a flat box": (bind(stress=affine, voxel=1, within=((0, 0, 0), (1, 1, 0))), "`within` is", "lower"),
    "a number as box": (bind(stress=affine, voxel=1, within=3), "`within` is 3", "corners"),
    "no length": (bind(stress=affine, voxel="1deg"), "no length", "unit"),
    "voxel 0": (bind(stress=affine, voxel=0), "0 mm", "above 0"),
    "too fine": (bind(stress=affine, voxel=0.001), "samples", "would do"),
    "a vector": (bind(stress=lambda p: p, voxel=1), "gives (", "one number"),
    "a number for vectors": (bind(flow=affine, voxel=1), "gives (", "three"),
    "it raises": (bind(stress=lambda p: p[:, 7], voxel=1), "IndexError", "a row each"),
    "no numbers": (bind(stress=lambda p: "a", voxel=1), "ValueError", "a row each"),
    "a matrix for tensors": (
        lambda: porelang.compile("param s: tensor = tensor(0, 0, 0, 0, 0, 0)\nsphere(3) + s.xx").bind(
            s=np.zeros((2, 2, 2, 9)), **BOX
        ),
        "9 numbers in each place, where six",
        "tensor",
    ),
    "nan": (bind(stress=lambda p: np.log(p[:, 0] + 10), voxel=1), "at (-10", "division by zero there; an interpolator"),
    "a shape": (bind(stress=np.zeros((2, 2))), "(2, 2)", "(nx, ny, nz)"),
    "texts": (bind(stress=np.full((2, 2, 2), "a")), "not numbers", "SampledField"),
    "an array with voxel": (bind(stress=np.zeros((2, 2, 2)), voxel=1), "own", "leave"),
    "nan in an array": (
        bind(stress=np.full((2, 2, 2), np.nan)),
        "8 of its values are not finite numbers, the first at [0, 0, 0]",
        "nan_to_num",
    ),
    "three of an array": (bind(stress=np.zeros((2, 2, 2, 3))), "3 numbers", "`field`"),
    "a number alone": (bind(stress=5.0), "5.0, which is no data", "the default: `param stress: field = 5.0`"),
    "nothing": (bind(stress=None), "None, which is no data", "FILE:ARRAY"),
    "a box for a file": (bind(stress="a.npz:s"), "where its samples lie, and `within` is given", "leave `within` out"),
    "a voxel for a file": (bind(stress="a.npz:s", within=None, voxel=1), "`voxel` is given", "FILE:ARRAY,voxel=1mm"),
    "a text of no file": (bind(stress="5MPa"), "names no array", "result.vtu:von_mises"),
    "a set": (bind(stress={1.0, 2.0}), "no data", "SampledField"),
    "a wide array": (bind(stress=np.broadcast_to(np.zeros(1), (4000, 4000, 4000))), "too many", "second node"),
    "masked values": (bind(stress=np.ma.masked_equal(np.eye(3)[None] + [[[0]]] * 2, 1)), "6 of its values", "fill"),
    "a function that fails": (bind(stress=fails, voxel=1), "out of bounds", "from (-10, -10, -10) to (10, 10, "),
    "large": (bind(stress=np.full((2, 2, 2), 1e38)), "1e+38", "unit"),
    "far": (bind(stress=np.zeros((2, 2, 2)), within=((0, 0, 0), (1, 1, 1e6))), "reaches", "100 m"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_bound_is_told(case: str) -> None:
    wrong, words, way_out = WRONG[case]
    with np.errstate(all="ignore"):
        found = told(wrong)
    assert found.code == "E155"
    assert words in found.message
    assert way_out in found.hint
    assert found.span is not None or case == "no such param"


def test_other_refusals() -> None:
    assert told(lambda: program().design(stress=3)).code == "E083"
    assert "--bind stress=" in told(lambda: program().design(stress=3)).hint
    assert "--bind stress=" in told(lambda: program().design({"stress": 3})).hint
    near = told(lambda: program().design({"strss": 3}))
    assert near.code == "E083"
    assert "did you mean `stress`, which takes data?" in near.hint
    assert told(bind(stress=affine, voxel=1, within="nothing")).code == "E100"
    endless = porelang.compile("param s: field = 0\nout part = gyroid(3) + s")
    assert told(lambda: endless.bind(s=affine, voxel=1, within="part")).code == "E091"


def test_a_function_is_asked_within_its_box_only() -> None:
    """SciPy's interpolators refuse what lies beyond the last sample by a rounding."""
    axes = [np.linspace(-10, 10, 7), np.linspace(-7, 7.3, 5), np.linspace(0.1, 9.7, 4)]
    values = affine(np.stack(np.meshgrid(*axes, indexing="ij"), -1))
    known = RegularGridInterpolator(axes, values)
    made = program().bind(stress=known, voxel="0.7mm", within=((-10, -7, 0.1), (10, 7.3, 9.7)))
    q = np.random.default_rng(1).uniform([-10, -7, 0.1], [10, 7.3, 9.7], (300, 3))
    np.testing.assert_allclose(made.field("s")(q), affine(q), atol=1e-10)


def test_samples_of_a_wrong_form_are_told() -> None:
    for origin, spacing, words in (((0, 0, 0), [2, 2], "the spacing is"), ((0, 0), 1, "the origin is")):
        with pytest.raises(ValueError, match=words):
            SampledField.from_array(np.zeros((2, 2, 2)), origin, spacing)  # type: ignore[arg-type]


# ---- the command line


def test_a_file_is_bound_by_a_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "ascii.vtu", "result.vtu")
    Path("part.pore").write_text("param stress: field = 0MPa\nout part = stress / 1MPa + x")
    Path("points.csv").write_text("1,1,1\n3,0.5,0.25\n")
    good = ["--bind", "stress=result.vtu:von_mises"]
    assert main(["eval", "part.pore", "--points", "points.csv", *good, "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["values"]
    np.testing.assert_allclose(values, [7, 7.75], atol=1e-6)
    assert main(["check", "part.pore", *good]) == 0
    for words, code in (
        (["--bind", "stress=result.vtu:nothing"], "E132"),
        (["--bind", "stress=result.vtu:slope"], "E133"),
        (["--bind", "stres=result.vtu:von_mises"], "E155"),
        (["--bind", "stress=none.vtu:a"], "E130"),
        ([*good, "--bind", "stress=result.vtu:slope"], "E155"),
    ):
        capsys.readouterr()
        assert main(["check", "part.pore", *words]) == 1, words
        assert code in "".join(capsys.readouterr())
    capsys.readouterr()
    assert main(["check", "part.pore", "--bind", "stress=result.vtu"]) == 2
    assert "NAME=FILE:ARRAY" in "".join(capsys.readouterr())


#: A default, what is bound over it, and the value at (1, 1, 1), where the array has 6.
BOUND = {
    "as it is": ("0MPa", "", 6.0),
    "in the unit of the default": ("0Pa", "", 6e-6),
    "as a load": ('load("result.vtu", "material", unit=Pa)', "", 6e-6),
    "as a load that is moved": ('load("result.vtu", "material", unit=kPa) @ (p - 1)', "", 6e-3),
    "in a unit that is said": ('load("result.vtu", "material", unit=Pa)', ",unit=kPa", 6e-3),
    "in a made unit": ("0MPa", ", unit=N/m^2", 6e-6),
    "in cm": ("0MPa", ",lengths=cm,unit=Pa", 0.6e-6),
    "as the default in cm": ('load("result.vtu", "material", lengths=cm)', "", 0.6),
    "beyond the cells": ('load("result.vtu", "material", outside=7MPa) @ (p + 99)', "", 6.0),
}


@pytest.mark.parametrize("case", BOUND)
def test_what_is_bound_is_read_as_its_default(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a command and from Python; an option that is said goes over that of the default."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "ascii.vtu", "result.vtu")
    default, said, value = BOUND[case]
    Path("part.pore").write_text(f"param stress: field = {default}\nout part = stress / 1MPa")
    options = parse(["eval", "part.pore", "--points", "p.csv", "--bind", f"stress=result.vtu:von_mises{said}"])
    for made in (
        load(options),
        porelang.compile(path="part.pore").bind(stress=f"result.vtu:von_mises{said}"),
    ):
        np.testing.assert_allclose(made.field("part")([[1.0, 1, 1]])[0], value, rtol=1e-9)
        assert pickle.loads(pickle.dumps(made)).field("part")([[1.0, 1, 1]])[0] == made.field("part")([[1.0, 1, 1]])[0]
    if "outside" in default:
        assert made.field("part")([[-50.0, 1, 1]])[0] == 7


def test_options_of_what_is_bound_are_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "ascii.vtu", "result.vtu")
    Path("part.pore").write_text("param stress: field = 0MPa\nout part = stress / 1MPa + x")
    for said, code, words in (
        (",unit=N", "E155", "what is bound to it is a force"),
        (",unit=Nonsense", "E002", "not a unit"),
        (",voxel=-1mm", "E152", "above 0"),
        (",outside=7mm", "E155", "give `outside` as a stress too"),
        (",unti=Pa", "E132", "did you mean `unit=`? it holds `von_mises`"),
        (",unit=Pa)", "E0", "--bind stress"),
        (",unit=Pa) + (x", "E155", "cannot be bound with"),
    ):
        assert main(["check", "part.pore", "--bind", f"stress=result.vtu:von_mises{said}"]) == 1, said
        out = "".join(capsys.readouterr())
        assert code in out, out
        assert words in out, out


def test_metres_of_what_is_bound_are_told_as_an_option(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("m.npz", s=np.arange(125.0).reshape(5, 5, 5), origin=[-0.01] * 3, spacing=0.005)
    Path("part.pore").write_text("param s: field = 0\ngyroid(6) |> shell(0.8) |> thicken(-s / 200, 0.3) & cube(19)")
    assert main(["check", "part.pore", "--bind", "s=m.npz:s"]) == 0
    out = "".join(capsys.readouterr())
    assert "W231" in out
    assert "`--bind s=FILE:ARRAY,lengths=m`" in out
    assert main(["check", "part.pore", "--bind", "s=m.npz:s,lengths=m"]) == 0
    assert "warning" not in "".join(capsys.readouterr()).replace("no warnings", "")


def test_what_is_bound_may_have_colons_and_spaces() -> None:
    options = parse(["mesh", "a.pore", "-o", "a.stl", "--bind", "s=C:/data/r.vtu:a b"])
    assert options.bindings == [("s", "C:/data/r.vtu", "a b", "")]
