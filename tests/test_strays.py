"""Data that lie elsewhere than the part that reads them, or in another unit, are doubted; what is right is not."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

import porelang
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic
from porelang.program import Program
from porelang.source import Source

#: Nodes every 2 mm from (0, 0, 0) to (40, 40, 40); the value is x + 2 y + 3 z.
AXIS = np.linspace(0, 40, 21)
VALUES = np.stack(np.meshgrid(AXIS, AXIS, AXIS, indexing="ij"), -1) @ np.array([1.0, 2, 3])
PART = "gyroid(8) |> shell(0.8) |> thicken(-s / 300, 0.3) & "


@pytest.fixture(autouse=True)
def _files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez(
        "a.npz", s=VALUES, same=np.ones((2, 2, 2)), plane=np.repeat(VALUES[..., :1], 2, 2), origin=[0, 0, 0], spacing=2
    )
    np.savez("fine.npz", s=VALUES[np.ix_(np.arange(201) // 10, np.arange(201) // 10, [0, 10, 20])], origin=[0, 0, 0],
             spacing=[0.2, 0.2, 20])  # fmt: skip
    np.savez("m.npz", s=VALUES, origin=[0, 0, 0], spacing=0.002)
    np.savez("long.npz", s=VALUES[:11, :11, :11], origin=[0, 0, 0], spacing=[0.2, 0.1, 0.1])


def compiled(text: str) -> Program:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return porelang.compile(text)


def doubts(made: Program | str) -> list[Diagnostic]:
    made = compiled(made) if isinstance(made, str) else made
    return [d for d in made.design().told(*made.roots()) if d.severity == "warning"]


def codes(made: Program | str) -> list[str]:
    return [d.code for d in doubts(made)]


INSIDE = "(cube(36) |> translate([20, 20, 20]))"
BASE = "(cube(36) |> translate([-40, 20, 20]))"
STRAY = {
    "another origin": f'let s = load("a.npz", "s")\n{PART} cube(36)',
    "far away": f'let s = load("a.npz", "s")\n{PART} (cube(36) |> translate([1000, 0, 0]))',
    "half of the part": f'let s = load("a.npz", "s")\n{PART} (box([70, 36, 36]) |> translate([35, 20, 20]))',
    "outside along it": f'let s = load("a.npz", "plane", outside=0)\n{PART} (cube(36) |> translate([20, 20, 99]))',
    "along what is not the same": f'let s = load("a.npz", "plane")\n{PART} (cube(36) |> translate([60, 20, 20]))',
    "of samples of a slope": f"let s = sample(x * z, 2mm, box([36, 36, 9]))\n{PART} cube(36)",
    "of a blur": f"let s = blur(x + z, 2mm, box([36, 36, 9]))\n{PART} cube(36)",
    "its axes exchanged": f'let s = load("a.npz", "s") @ [z + 99, y, x]\n{PART} {INSIDE}',
    "all outside": f'let s = load("a.npz", "s", outside=0)\n{PART} (cube(36) |> translate([99, 0, 0]))',
    "in a mean": f'let s = load("a.npz", "s")\nlet m = mean(s, cube(36))\n{PART.replace("s /", "m /")} {INSIDE}',
    "in a blur": f'let s = blur(load("a.npz", "s"), 4mm, cube(36))\n{PART} cube(36)',
    "in a condition": 'let s = load("a.npz", "s")\ngyroid(8) |> shell(if s > 99 then 0.4 else 0.9) & cube(36)',
    "of samples": f"let s = sample(x + y, 2mm, cube(9))\n{PART} cube(36)",
    "of a slope": 'let s = load("a.npz", "s", smooth=true)\nshell(gyroid(8), 0.4 + length(grad(s)) / 20) & cube(36)',
}


@pytest.mark.parametrize("case", STRAY)
def test_a_part_beyond_its_data_is_doubted(case: str) -> None:
    found = doubts(STRAY[case])
    assert "W241" in [d.code for d in found], case
    stray = next(d for d in found if d.code == "W241")
    assert stray.hint
    assert stray.span is not None
    assert stray.span.text.startswith(("load", "sample", "mean", "blur"))


def test_who_reads_beyond_is_named() -> None:
    """A mean that looks elsewhere is no matter of the part, and moving the data would put them out of the part."""
    (found,) = doubts(STRAY["in a mean"])
    assert found.span is not None
    assert found.span.text == "mean(s, cube(36))"
    assert "this `mean` looks within" in found.message
    assert "the part" not in found.message
    assert "@" not in found.hint
    assert '`load("a.npz", "s")`: from (0, 0, 0) to (40, 40, 40) mm' in found.label


def test_a_part_is_named_before_what_it_reads() -> None:
    (found,) = doubts(
        f'let s = load("a.npz", "s")\nlet m = mean(s, cube(36))\n{PART.replace("s /", "(s + m) /")} cube(36)'
    )
    assert "of the part" in found.message
    assert "`@ (p - [-20, -20, -20])`" in found.hint


RIGHT = {
    "within": f'let s = load("a.npz", "s")\n{PART} {INSIDE}',
    "a skin beyond": f'let s = load("a.npz", "s")\n{PART} (cube(42) |> translate([20, 20, 20]))',
    "outside is said": f'let s = load("a.npz", "s", outside=0)\n{PART} (cube(60) |> translate([20, 20, 20]))',
    "an if of its own": f'let s = if x < 0 then 0 else load("a.npz", "s")\n{PART} (BASE | {INSIDE})',
    "a base without data": f'let s = load("a.npz", "s")\n({PART} {INSIDE}) | BASE',
    "a smooth base": f'let s = load("a.npz", "s")\nsmooth_union({PART} {INSIDE}, BASE, 3)',
    "constant": f'let s = load("a.npz", "same")\n{PART} cube(36)',
    "moved": f'let s = load("a.npz", "s") @ (p + 20)\n{PART} cube(36)',
    "saturated": 'let s = clamp(load("a.npz", "s"), -9, -1)\nshell(gyroid(8), s + 10) & cube(36)',
    "no part": 'out part = load("a.npz", "s") + 0',
    "the same along z": f'let s = load("a.npz", "plane")\n{PART} (box([36, 36, 90]) |> translate([20, 20, 0]))',
    "a skin beyond fine data": f'let s = load("fine.npz", "s")\n{PART} (cube(42) |> translate([20, 20, 20]))',
    "samples of what is the same there": f"let s = sample(x, 2mm, box([36, 36, 9]))\n{PART} cube(36)",
    "a blur of what is the same there": f"let s = blur(exp(x / 9), 2mm, box([36, 36, 9]))\n{PART} cube(36)",
    "samples of what is found": f"let s = sample(sample(x, 1mm, cube(48)), 2mm, box([36, 36, 9]))\n{PART} cube(36)",
    "samples": f"let s = sample(x + y, 2mm, cube(36))\n{PART} cube(36)",
}  # fmt: skip


@pytest.mark.parametrize("case", RIGHT)
def test_what_is_right_is_not_doubted(case: str) -> None:
    assert codes(RIGHT[case].replace("BASE", BASE)) == [], case


def test_the_way_out_mends_it() -> None:
    (found,) = doubts(STRAY["another origin"])
    assert "from (0, 0, 0) to (40, 40, 40) mm" in found.label
    text = STRAY["another origin"].replace('"s")', f'"s") {found.hint.split("`")[1]}')
    assert codes(text) == []


METRES = {
    "24 mm": f'let s = load("m.npz", "s")\n{PART} {INSIDE}',
    "2 m": 'let s = load("long.npz", "s")\n' + PART.replace("8", "60") + "LONG",
    "no part": 'out part = load("m.npz", "s") + 0',
    "in a blur": f'let s = blur(load("m.npz", "s"), 4mm, {INSIDE})\n{PART} {INSIDE}',
}  # fmt: skip


@pytest.mark.parametrize("case", METRES)
def test_metres_are_seen_and_the_edit_mends_it(case: str) -> None:
    text = METRES[case].replace("LONG", "(box([1900, 900, 900]) |> translate([1000, 500, 500]))")
    found = [d for d in doubts(text) if d.code == "W231"]
    assert len(found) == 1, case
    edit = found[0].edit
    assert edit is not None
    mended = edit.apply(text)
    assert "lengths=m)" in mended
    assert codes(mended) == []


def test_a_place_that_is_scaled_is_not_doubted() -> None:
    assert codes(f'let s = load("m.npz", "s") @ (p / 1000)\n{PART} {INSIDE}') == []


@pytest.mark.parametrize("name", ["hole", "bending"])
def test_examples_lie_in_their_data(name: str) -> None:
    made = porelang.compile(path=Path(__file__).parent.parent / "examples" / f"{name}.pore")
    assert codes(made) == []


def test_what_is_bound_is_looked_at_too() -> None:
    made = compiled(f"param s: field = 0\n{PART} cube(36)")
    assert codes(made) == []
    (found,) = doubts(made.bind(s=SampledField.from_array(VALUES, (0, 0, 0), 2)))
    assert found.code == "W241"
    assert found.span is not None
    assert found.span.text == "s"
    assert "`s @ (p - [-20, -20, -20])` where the program reads it" in found.hint
    Path("p.pore").write_text(f"param s: field = 0\n{PART} cube(36)")
    (found,) = doubts(porelang.compile(path="p.pore").bind(s="a.npz:s"))
    assert "`s @ (p - [-20, -20, -20])` where the program reads it" in found.hint
    assert codes(made.bind(s=SampledField.from_array(VALUES, (-20, -20, -20), 2))) == []


def test_it_is_said_by_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    from porelang.cli import main

    Path("part.pore").write_text(STRAY["another origin"])
    assert main(["check", "part.pore"]) == 0
    assert "W241" in "".join(capsys.readouterr())
    with pytest.warns(porelang.PoreWarning, match="lies beyond the data"):
        porelang.compile(path="part.pore").notes()


def test_the_unit_of_lengths_is_one() -> None:
    from porelang.compiler import try_compile

    for text, code in (('load("a.npz", "s", lengths=MPa)', "E062"), ('load("a.npz", "s", lengths=-1mm)', "E153"),
                       ('load("a.npz", "s", lengths=2)', "E153")):  # fmt: skip
        _, found = try_compile(Source("part.pore", text))
        assert [d.code for d in found if d.severity == "error"] == [code]
    made = compiled('let a = load("m.npz", "s", lengths=m)\nout part = a + 0')
    np.testing.assert_allclose(made.field("part")([[1.0, 2, 3]]), 14, rtol=1e-12)


def test_of_a_misspelt_unit_of_lengths_one_thing_is_said() -> None:
    from porelang.compiler import try_compile

    def said(call: str) -> list[Diagnostic]:
        return [d for d in try_compile(Source("part.pore", call))[1] if d.severity == "error"]

    (found,) = said('load("a.npz", "s", length=m)')
    assert found.code == "E041"
    assert "lengths" in found.hint
    (found,) = said('load("a.npz", "s", lengths=3)')
    assert "the units are um, mm, cm, m, 1in" in found.hint
    assert "kPa" not in found.hint
    np.savez("far.npz", s=VALUES, origin=[0, 0, 0], spacing=900)
    with pytest.raises(porelang.PoreError) as raised:
        compiled('load("far.npz", "s", lengths=m)').field()
    assert "says that one of the file is 1000 mm" in str(raised.value.diagnostics[0].hint)


def test_a_tensor_that_nothing_reads_is_a_field() -> None:
    np.savez("t.npz", s=np.ones((3, 3, 3, 6)), origin=[0, 0, 0], spacing=1)
    (found,) = [
        d for d in compiled('let t = load_tensor("t.npz", "s")\nout part = sphere(3)').warnings if d.code == "W220"
    ]
    assert 'field("_t")' in found.hint
    assert "number" not in found.hint


def test_inches_are_written_as_the_language_has_them() -> None:
    np.savez("in.npz", s=VALUES, origin=[0, 0, 0], spacing=2 / 25.4)
    (found,) = doubts(f'let s = load("in.npz", "s")\n{PART} {INSIDE}')
    assert found.code == "W231"
    assert "`lengths=1in`" in found.message
    text = f'let s = load("in.npz", "s", lengths=1in)\n{PART} {INSIDE}'
    assert codes(text) == []


def test_a_part_between_two_samples_is_doubted() -> None:
    (found,) = doubts(f'let s = load("a.npz", "s", lengths=m)\n{PART} {INSIDE}')
    assert found.code == "W231"
    assert "lies between two samples of these data, 2000 mm apart" in found.message
    assert "`lengths=mm`" in found.message


def test_what_is_said_of_what_lies_beyond_is_so() -> None:
    """How much of a cube from 20 to 56 lies beyond 40, how far, what holds there, and where it would lie within."""
    (found,) = doubts(f'let s = load("a.npz", "s")\n{PART} (cube(36) |> translate([38, 20, 20]))')
    assert found.message.startswith(("44%", "43%", "45%"))  # (56 - 40) / 36, of what the lattice leaves
    assert "by up to 16 mm" in found.message
    assert "as at their faces" in found.label
    (found,) = doubts(STRAY["all outside"])
    assert "beyond holds what `outside` says" in found.label
    assert "outside=" not in found.hint
    (found,) = doubts(f'let s = load("a.npz", "s")\n{PART} (cube(40) |> translate([1234.56, 20, 20]))')
    assert "[1214.56, 0, 0]" in found.hint
    assert "by up to 1215 mm" in found.message


def test_the_rim_of_a_blur_is_no_matter() -> None:
    within = "(cube(43.4) |> translate([20, 20, 20]))"
    assert codes(f'let s = blur(load("a.npz", "s"), 4mm, {within})\n{PART} {INSIDE}') == []


def test_components_that_have_one_order_are_not_told_of() -> None:
    from porelang.tasks.readers.tensors import are_named

    assert are_named((), 9)
    assert not are_named((), 6)
    np.savez("t.npz", t=np.ones((3, 3, 3, 6)), origin=[0, 0, 0], spacing=20)
    made = compiled('sphere(9) + load_tensor("t.npz", "t").xx')
    (note,) = [d for d in made.design().told(*made.roots()) if d.severity == "note"]
    assert "does not name" not in note.message


def test_a_mesh_that_grows_beyond_its_margin_is_doubted_and_the_hint_mends_it() -> None:
    """A bar of 20 mm that is known to 1.25 mm around it: farther off its distance is one of 0.7 to 1 of what is so."""
    trimesh.creation.box([20, 8, 8]).export("bar.stl")
    grown = 'offset(mesh("bar.stl"{}), 6mm)'
    (doubt,) = doubts(grown.format(""))
    assert doubt.code == "W241"
    assert "beyond where this mesh was measured" in doubt.message
    margin = re.search(r"margin=[\d.]+mm", doubt.hint)
    assert margin is not None
    assert codes(grown.format(f", {margin[0]}")) == []
    for wrong in ('{0} \\ offset(mesh("bar.stl"), 5mm)', "translate({0}, [200, 0, 0])", "cube(60) \\ {0}"):
        assert codes(wrong.format(grown.format(""))) == ["W241"]
    for right in (
        'offset(mesh("bar.stl"), 1mm)',
        'shell(mesh("bar.stl", error=0.4mm), 1mm, side="inside") | translate(sphere(5), [60, 0, 0])',
        'mesh("bar.stl") \\ translate(sphere(6), [0, 0, 6])',
    ):
        assert codes(right) == []
