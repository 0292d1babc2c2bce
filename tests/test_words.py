"""What is shown to users stands in the words and units of their program."""

from __future__ import annotations

import pytest

import porelang
from porelang.compiler import try_compile
from porelang.data import coordinates
from porelang.diagnostics import PoreError
from porelang.mesh.grid import place
from porelang.refusals import refusals
from porelang.source import Source

# A declaration, its default and its range as they are shown, a setting that is too large and as what it is shown.
SHOWN = [
    ("6deg in 0deg..12deg", "6deg", "0deg..12deg", "15deg", "15deg"),
    ("6deg in 0deg..12deg step 2deg", "6deg", "0deg..12deg step 2deg", 1.0, "57.2958deg"),
    ("35% in 10%..50%", "35%", "10%..50%", 0.9, "90%"),
    ("0.5 in 10%..90%", "50%", "10%..90%", "95%", "95%"),
    ("2cm in 5mm..30mm", "2cm", "0.5cm..3cm", "40mm", "4cm"),
    ("1in in 0.5in..2in", "1in", "0.5in..2in", "100mm", "3.93701in"),
    ("5MPa in 1MPa..9MPa", "5MPa", "1MPa..9MPa", "1GPa", "1000MPa"),
    ("0 in -5deg..5deg", "0deg", "-5deg..5deg", "6deg", "6deg"),
    ("2 * 3deg in 0..12deg", "6deg", "0deg..12deg", "15deg", "15deg"),
    ("0.25turn in 0turn..1turn", "0.25turn", "0turn..1turn", "540deg", "1.5turn"),
    ("3 in 1..5", "3", "1..5", 6, "6"),
    ("2mm * 1mm in 1mm * 1mm..9mm * 1mm", "2mm^2", "1mm^2..9mm^2", 10, "10"),
]


@pytest.mark.parametrize(("declared", "default", "allowed", "large", "told"), SHOWN)
def test_a_param_is_shown_in_the_unit_of_its_declaration(
    declared: str, default: str, allowed: str, large: str | float, told: str
) -> None:
    program = porelang.compile(f"param q = {declared}\nsphere(10 + sin(bare(q)))")
    info = program.params["q"]
    assert info.shown(info.default) == default
    assert info.range == allowed
    assert f"q = {default} in {allowed}" in repr(info)
    with pytest.raises(PoreError) as refused:
        program.design({"q": large})
    assert f"`q` = {told} lies outside" in refused.value.diagnostics[0].message


def test_a_choice_among_numbers_is_shown_in_its_unit() -> None:
    program = porelang.compile("param a = 30deg in {15deg, 30deg}\nrotate(cube(10), [0, 0, 1], a)")
    assert program.params["a"].shown(program.params["a"].default) == "30deg"
    with pytest.raises(PoreError, match="cannot be 45deg"):
        program.design({"a": "45deg"})


def test_base_units_stay_the_numbers_of_settings() -> None:
    program = porelang.compile("param a = 180deg in 0deg..360deg\nrotate(box([1, 2, 3]), [0, 0, 1], a)")
    assert program.design().settings["a"] == pytest.approx(3.141592653589793)
    assert program.params["a"].unit == "rad"
    assert "a = 180deg" in repr(program.design())


def test_an_end_of_a_range_and_a_step_are_told_in_the_unit() -> None:
    text = "param q = 35% in 10%..100% step 10%\ncube(20) \\ cube(bare(q) * 20.5)"
    program, found = try_compile(Source("part.pore", text))
    assert program is not None
    (step,) = [d for d in found if d.code == "W219"]
    assert "35%, between two of its steps of 10%" in step.message
    assert "30% or 40%" in step.hint
    (end,) = [d for d in refusals(program.design(), measure=True) if d.code == "W222"]
    assert end.message.startswith("with `q` = 100%: `part` holds no material")


def test_what_rounding_leaves_of_zero_is_shown_as_zero() -> None:
    assert coordinates([-1.712e-07, 2.5, 1e-9]) == "0, 2.5, 0"
    assert place([-1.712e-07, 1e-5, -20.0]) == "(0, 1e-05, -20) mm"
