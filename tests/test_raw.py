"""A length that meets a raw lattice: refused, and the edit that is shown makes a program of it with walls in mm."""

from __future__ import annotations

import pytest

import porelang
from porelang.compiler import try_compile
from porelang.diagnostics import Diagnostic, PoreError
from porelang.source import Source


def said(text: str) -> list[Diagnostic]:
    return try_compile(Source("a.pore", text))[1]


#: What is written, and what the edit makes of it.
REFUSED = {
    "gyroid(10) |> shell(0.4mm) & cube(60mm)": "metric(gyroid(10)) |> shell(0.4mm) & cube(60mm)",
    "shell(gyroid(10mm), 0.4mm)": "shell(metric(gyroid(10mm)), 0.4mm)",
    "shell(t=0.4mm, a=gyroid(10))": "shell(t=0.4mm, a=metric(gyroid(10)))",
    "param w = 30mm in 10mm..60mm\ngyroid(w) |> shell(0.4mm) & cube(60mm)": (
        "param w = 30mm in 10mm..60mm\nmetric(gyroid(w)) |> shell(0.4mm) & cube(60mm)"
    ),
    "param t = 0.4mm in 0.2mm..1mm\ngyroid(8) |> shell(t) & cube(20)": (
        "param t = 0.4mm in 0.2mm..1mm\nmetric(gyroid(8)) |> shell(t) & cube(20)"
    ),
    "offset(diamond(10), 0.3mm) & cube(20)": "offset(metric(diamond(10)), 0.3mm) & cube(20)",
    "thicken(gyroid(10), 0.3mm) & cube(20)": "thicken(metric(gyroid(10)), 0.3mm) & cube(20)",
    "gyroid(10) |> thicken(-z / 20, 0.3mm) & cube(20)": "metric(gyroid(10)) |> thicken(-z / 20, 0.3mm) & cube(20)",
    "multishell(gyroid(10), 0.3mm, 2, 0.2mm) & cube(20)": (
        "multishell(metric(gyroid(10)), 0.3mm, 2, 0.2mm) & cube(20)"
    ),
    "gyroid(10) - 0.3mm & cube(20)": "metric(gyroid(10)) - 0.3mm & cube(20)",
    "0.3mm - gyroid(10) & cube(20)": "0.3mm - metric(gyroid(10)) & cube(20)",
    "0.5 * gyroid(10) - 0.3mm & cube(20)": "metric(0.5 * gyroid(10)) - 0.3mm & cube(20)",
    "max(gyroid(10), 0.3mm) & cube(20)": "max(metric(gyroid(10)), 0.3mm) & cube(20)",
    "if gyroid(10) < 0.3mm then sphere(10) else cube(9)": "if metric(gyroid(10)) < 0.3mm then sphere(10) else cube(9)",
    "def wall(f, t: length) = abs(f) - t / 2\nwall(gyroid(10), 0.4mm) & cube(20)": (
        "def wall(f, t: length) = abs(metric(f)) - t / 2\nwall(gyroid(10), 0.4mm) & cube(20)"
    ),
    "(gyroid(10) & sphere(20)) |> shell(0.4mm)": "metric(gyroid(10) & sphere(20)) |> shell(0.4mm)",
    "conventions.axolotl.gyroid(10) |> shell(0.4mm) & cube(20)": (
        "metric(conventions.axolotl.gyroid(10)) |> shell(0.4mm) & cube(20)"
    ),
    "param k = gyroid in {gyroid, diamond}\nk(10) |> shell(0.4mm) & cube(20)": (
        "param k = gyroid in {gyroid, diamond}\nmetric(k(10)) |> shell(0.4mm) & cube(20)"
    ),
    "translate(gyroid(10), [1, 2, 3]) |> shell(0.4mm) & cube(20)": (
        "metric(translate(gyroid(10), [1, 2, 3])) |> shell(0.4mm) & cube(20)"
    ),
    "twist(gyroid(10), 90deg / 50mm) |> shell(0.4mm) & cube(20)": (
        "metric(twist(gyroid(10), 90deg / 50mm)) |> shell(0.4mm) & cube(20)"
    ),
    "blend(gyroid(10), diamond(10), along=z, r=4mm) |> shell(0.4mm) & cube(20)": (
        "metric(blend(gyroid(10), diamond(10), along=z, r=4mm)) |> shell(0.4mm) & cube(20)"
    ),
    "smooth_union(gyroid(10), sphere(4), 2mm) & cube(9)": "smooth_union(metric(gyroid(10)), sphere(4), 2mm) & cube(9)",
    "gyroid(10) |> smooth_union(schwarz_p(10), 2mm) & cube(20)": (
        "metric(gyroid(10)) |> smooth_union(metric(schwarz_p(10)), 2mm) & cube(20)"
    ),
    "smooth_union([gyroid(10) & cube(20), sphere(4)], 2mm)": (
        "smooth_union([for f in [gyroid(10) & cube(20), sphere(4)]: metric(f)], 2mm)"
    ),
    # the surface of a magnitude is found within it
    "abs(gyroid(10)) - 1mm & cube(20)": "abs(metric(gyroid(10))) - 1mm & cube(20)",
    "abs(gyroid(10)) |> offset(1mm) & cube(20)": "abs(metric(gyroid(10))) |> offset(1mm) & cube(20)",
    "if abs(gyroid(10)) < 0.2mm then sphere(10) else cube(9)": (
        "if abs(metric(gyroid(10))) < 0.2mm then sphere(10) else cube(9)"
    ),
    # what was made of the values of a lattice is raw still
    "blur(gyroid(10), 1mm, cube(9)) |> shell(0.4mm) & cube(9)": (
        "metric(blur(gyroid(10), 1mm, cube(9))) |> shell(0.4mm) & cube(9)"
    ),
    "sample(gyroid(10), 1mm, cube(9), smooth=true) |> shell(0.4mm) & cube(9)": (
        "metric(sample(gyroid(10), 1mm, cube(9), smooth=true)) |> shell(0.4mm) & cube(9)"
    ),
    "clamp(gyroid(10), -1, 1) |> shell(0.4mm) & cube(20)": (
        "metric(clamp(gyroid(10), -1, 1)) |> shell(0.4mm) & cube(20)"
    ),
    "conventions.axolotl.overlay(gyroid(10), 0.4mm) & cube(20)": (
        "conventions.axolotl.overlay(metric(gyroid(10)), 0.4mm) & cube(20)"
    ),
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_length_that_meets_a_raw_lattice_is_refused_with_its_way_out(text: str) -> None:
    (found,) = said(text)
    assert (found.code, found.severity) == ("E145", "error")
    assert "mm" in found.message or "`t" in found.message
    assert found.edit is not None
    made = found.edit.apply(text)
    assert made == REFUSED[text]
    assert said(made) == []


@pytest.mark.parametrize(
    "text",
    [
        "sum([gyroid(10), 0.4mm]) & cube(9)",
        "hypot(gyroid(10), 0) - 0.2mm & cube(9)",
        "sqrt(square(gyroid(10))) - 0.2mm & cube(9)",
        "let f = abs(gyroid(10))\nf - 1mm & cube(9)",
        "gyroid(10) * gyroid(10) - 0.2mm & cube(9)",
        "2 * abs(gyroid(10)) - 0.2mm & cube(9)",
        "pow(gyroid(10), 2) - 0.2mm & cube(9)",
        "sqrt(square(diamond(10)) + 0.01) - 0.2mm & cube(9)",
        "max(abs(gyroid(10)), abs(diamond(8))) - 0.3mm & cube(9)",
    ],
)
def test_where_no_edit_of_one_place_mends_it_none_is_shown(text: str) -> None:
    (found,) = said(text)
    assert (found.code, found.edit) == ("E145", None)


def test_a_setting_with_a_unit_is_refused_for_a_number_of_the_lattice() -> None:
    text = "param t = 0.4 in 0.2..1\nparam r = 9 in 5..20\ngyroid(10) |> shell(2 * t) & sphere(r)"
    program = porelang.compile(text)
    assert program.design(t=0.5, r="11mm").settings["r"] == 11
    with pytest.raises(porelang.PoreError, match=r"`t` is a number of the lattice's own units, and 0.5mm is a length"):
        program.design(t="0.5mm")
    lifted = porelang.compile(text.replace("gyroid(10)", "metric(gyroid(10))"))
    assert lifted.design(t="0.5mm").settings["t"] == 0.5


def test_each_place_is_told() -> None:
    found = said("out a = shell(gyroid(10), 0.4mm) & cube(9)\nout b = shell(diamond(10), 0.4mm) & cube(9)")
    assert [(d.code, d.span.line) for d in found if d.span] == [("E145", 1), ("E145", 2)]


@pytest.mark.parametrize(
    "text",
    [
        "gyroid(10) |> shell(0.4) & cube(20)",
        "gyroid(10) |> thicken(-0.3, 1) & cube(20)",
        "param w = 6mm in 4mm..10mm\ngyroid(w) |> shell(0.4mm * 9.6 / w) & cube(20)",
        "bare(0.4mm) - abs(gyroid(10)) & cube(20)",
        "gyroid(10) * 1.5mm |> shell(0.4mm) & cube(20)",
        "metric(gyroid(10)) |> shell(0.4mm) & cube(20)",
        "metric(gyroid(10), 3) - 0.3mm & cube(20)",
        "thicken(sphere(20), gyroid(5), 0.3mm)",
        # a share from 0 to 1 is a weight, and has no surface
        "sphere(20 + 3 * saturate(gyroid(9)))",
        "offset(cube(20), mix(0.2mm, 1mm, saturate(gyroid(9))))",
        "sample(sphere(9), 1mm, cube(20)) |> shell(1mm)",
    ],
)
def test_a_number_of_the_lattice_and_a_distance_are_taken(text: str) -> None:
    assert said(text) == []


@pytest.mark.parametrize(
    ("text", "shown", "hint"),
    [
        ("let s = 5MPa + x * 1MPa / 9mm\ngyroid(6) |> shell(s) & sphere(9)", "`s` is a stress", "`s / 100MPa`"),
        ("gyroid(6) |> shell(mix(0.4, 1.2, 3MPa)) & sphere(9)", "`mix(0.4, 1.2, 3MPa)` is a stress", "100MPa"),
        ("gyroid(6) - 3N & sphere(9)", "`3N` is a force", "`3N / 100N`"),
        ("sphere(5) + 3N", "`3N` is a force, and a distance is in mm", "`3N / 100N * 1mm`"),
    ],
)
def test_a_stress_or_a_force_is_no_thickness(text: str, shown: str, hint: str) -> None:
    with pytest.raises(PoreError) as refused:
        porelang.compile(text)
    (told,) = refused.value.diagnostics
    assert told.code == "E062"
    assert shown in told.message
    assert hint in told.hint


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("(metric(gyroid(10)) @ (2 * p)) |> shell(0.8mm) & cube(30)", "is 0.5 mm long"),
        ("0.4 * sphere(10) - 1mm", "is 2.5 mm long"),
        ("0.5 * sphere(10) @ (p) |> shell(1mm)", "is 2 mm long"),
        ("shell((0.5) * (sphere(10)), 1mm)", "is 2 mm long"),
        ("(sphere(10) @ [x, y, z / 3]) - 1mm & slab([0, 0, 1], 60)", "is 1.1 to "),
        # of 20 mm, a mixture within 5 mm is off: the others are as long as they say, and are not in its numbers
        ("crossfade(sphere(20), box([40, 40, 20]), along=z - 3, r=5mm) |> shell(1mm)", " % of its surface"),
    ],
)
def test_a_distance_no_longer_is_told_by_how_much(text: str, told: str) -> None:
    """Where a field rises by g in each mm, a length that is added to it is 1/g times as long."""
    (found,) = said(text)
    assert (found.code, found.severity) == ("W238", "warning")
    assert told in found.message
    assert found.edit is not None
    assert said(found.edit.apply(text)) == []
