"""What is doubted is doubtful, what is not is right, and the edit that comes with a doubt mends it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.checks import read_by
from porelang.cli import main
from porelang.compiler import try_compile
from porelang.diagnostics import Diagnostic, PoreError
from porelang.doubts import idle_cuts
from porelang.elaborate.prelude import prelude_files, prelude_scope
from porelang.elaborate.values import Function, Record
from porelang.error_codes import CODES
from porelang.files import read_source
from porelang.refusals import refusals
from porelang.source import Source

ROOT = Path(__file__).parent.parent
#: What is said of a field that is no part: it has no surface, which is so; a collection has no output.
OF_FIELDS = {"W211", "W221"}
#: The paper draws cells that are sheared, and so does the figure.
OF_FIGURES = {"fig07d_aligned": {"W239"}}


@cache
def said(text: str, measure: bool = False) -> tuple[Diagnostic, ...]:
    """All that `pore check` says of a program, but for its `check` statements: asked once, for several look at it."""
    return tuple(said_of(Source("part.pore", text), measure))


def said_of(source: Source, measure: bool = False) -> list[Diagnostic]:
    program, found = try_compile(source)
    if program is None:
        return found
    try:
        design = program.design()
        cuts = idle_cuts(program.elaborated, design.settings) if measure else []
        return [*found, *refusals(design, measure), *cuts]
    except PoreError as error:
        return [*found, *error.diagnostics]


def codes(text: str, measure: bool = False) -> list[str]:
    return [d.code for d in said(text, measure)]


DOUBTED = [
    # periods that vary, and cells that do not have them
    ("gyroid(25mm + z / 10) & cylinder(75mm, 300mm)", "W228"),
    ("let part = cylinder(75mm, 300mm)\nlet w = 25mm + z / 10\ndiamond(w=w) |> shell(0.5) & part", "W228"),
    ("let part = cylinder(75mm, 300mm)\ngyroid([20, 20, 25 + x / 5]) & part", "W228"),
    ("param k = gyroid in {gyroid, iwp}\nlet part = cylinder(75, 300)\nk(15 + z / 12) & part", "W228"),
    ("gyroid(20 + z / 12) |> rotate([1, 0, 0], 90deg) & cylinder(75, 300)", "W228"),
    # a raw lattice, and what was made of a length by a number of which the unit is not known
    ("let t = mix(0.2mm, 1mm, ramp(z, 0, 30))\nshell(gyroid(10), t) & cube(20)", "W212"),
    ("param low = 0.2mm in 0.1mm..1mm\noffset(diamond(10), low * ramp(z, 0, 30)) & cube(20)", "W212"),
    ("let heat = ramp(z, 0, 30)\ngyroid(10) |> thicken(-heat * 0.3mm) & cube(20)", "W212"),
    ("let s = compress(cube(20), 1kN, E=1GPa, nu=0.3)\ngyroid(10) |> thicken(s.von_mises, 0.3) & cube(20)", "W287"),
    ("let s = compress(cube(20), 1kN, E=1GPa, nu=0.3)\nsphere(9) |> thicken(-s.principal1)", "W287"),
    # lengths that are added to what is a distance no longer
    ("crossfade(metric(gyroid(10)), metric(gyroid(14)), along=z, r=5) |> shell(0.8mm) & cube(30)", "W238"),
    ("blend(metric(gyroid(10)), metric(schwarz_p(10)), along=z, r=5) |> shell(0.8mm) & cube(30)", "W238"),
    ("twist(metric(gyroid(10)), 0.1) |> shell(0.8mm) & cube(30)", "W238"),
    ("scale(metric(gyroid(10)), [3, 1, 1]) |> shell(0.8mm) & cube(30)", "W238"),
    ("polar(metric(gyroid(10)), 60) |> shell(0.8mm) & cylinder(20, 20)", "W238"),
    ("wedges(metric(gyroid(6)), 6) |> shell(0.8mm) & cylinder(30, 8)", "W238"),
    ("align(metric(gyroid(10)), grad(sphere(5))) |> shell(0.8mm) & sphere(20)", "W238"),
    ("abs(metric(gyroid(10)) @ (2 * p)) - 0.4mm & cube(30)", "W238"),
    ("2 * metric(gyroid(10)) |> shell(0.8mm) & cube(30)", "W238"),
    ("(gyroid(10) + sphere(10)) |> shell(0.4mm) & cube(30)", "W238"),
    ("scale(sphere(10), [1, 1, 2]) |> shell(1mm)", "W238"),
    ("def wall(f, t: length) = abs(f) - t / 2\nwall(twist(metric(gyroid(9)), 0.1), 0.4mm) & cube(30)", "W238"),
    # of which the length varied
    ("metric(gyroid(10)) - 2mm * ramp(z, -3, 3) |> shell(0.8mm) & cube(20)", "W238"),
    ("metric(gyroid(10)) |> offset(2mm * ramp(z, -3, 3)) |> shell(0.8mm) & cube(20)", "W238"),
    # also where that takes material away, where walls are thin, and once for a wall of a wall
    ("twist(metric(gyroid(10)), 0.1) + 0.5mm & sphere(20)", "W238"),
    ("thicken(twist(metric(gyroid(10)), 0.1), 0.5mm) & sphere(20)", "W238"),
    ("thicken(twist(metric(gyroid(10)), 0.1), -0.5mm) & sphere(20)", "W238"),
    ("twist(metric(gyroid(10)), 0.1) |> shell(0.2mm) & sphere(30)", "W238"),
    ("twist(metric(gyroid(10)), 0.1) |> shell(1mm) |> shell(0.2mm) & cube(20)", "W238"),
    ('scale(sphere(20), [1, 1, 2]) |> shell(2mm, side="inside")', "W238"),
    ('scale(sphere(20), [1, 1, 2]) |> shell(2mm, side="outside")', "W238"),
    ("scale(sphere(20), [1, 1, 2]) + 2mm", "W238"),
    ("sphere(60) \\ (scale(sphere(20), [1, 1, 2]) - 2mm)", "W238"),
    ("twist(metric(gyroid(8)), 0.1) |> shell(1.5mm + sphere(30) / 40) & sphere(30)", "W238"),
    # stretched after the length was added
    ("twist(metric(gyroid(10)) |> shell(0.8mm), 0.1) & cube(30)", "W238"),
    ("scale(metric(gyroid(10)) |> shell(0.8mm) & cube(20), [1, 1, 3])", "W238"),
    ("polar(metric(gyroid(6)) |> shell(0.5), 60) & cylinder(12, 20)", "W238"),
    # walls that the sheets of their lattice leave no room for, by the manual's table
    ("metric(w_surface(10)) |> shell(1mm) & cube(20)", "W238"),
    ("metric(neovius(10)) |> shell(2mm) & cube(20)", "W238"),
    ("metric(gyroid(4)) |> shell(2) & cube(20)", "W238"),
    # mm without their unit, and walls of a texture
    ("twist(metric(gyroid(8)), 0.05) |> shell(0.6) & cube(30)", "W238"),
    ("sphere(60) \\ (scale(sphere(20), [1, 1, 2]) - 2)", "W238"),
    ("torus(20, 5) + 0.3mm * gyroid(5) |> shell(0.8mm)", "W238"),
    ("sphere(12) - 0.5 * gyroid(5) |> shell(0.8)", "W238"),
    ("sphere(20) + sin(x) * sin(y) |> shell(0.8)", "W238"),
    # arithmetic between solids
    ("box([40, 40, 10]) & (cube(20) - sphere(9))", "W213"),
    ("cube(20) - cylinder(4, 30)", "W213"),
    ("sphere(10) + cube(12)", "W213"),
    ("let hollow = cube(20) - sphere(9)\ntranslate(hollow, [1, 0, 0]) | sphere(1)", "W213"),
    ("cube(20) - sphere(5) - cylinder(2, 30) & sphere(14)", "W213"),
    ("~(cube(20) - sphere(9)) & cube(30)", "W213"),
    ("extrude(circle(10) - rect(5, 5), 5)", "W213"),
    ("smooth_union(cube(20) - sphere(9), sphere(3), 2)", "W213"),
    # degrees
    ("rotate(box([30, 5, 5]), [0, 0, 1], 30)", "W214"),
    ("rotate(box([30, 5, 5]), [0, 0, 1], angle=-45)", "W214"),
    ("let a = 30\nrotate(box([30, 5, 5]), [0, 0, 1], a)", "W214"),
    ("param a = 45 in 0..90\nrotate(box([30, 5, 5]), [0, 0, 1], a)", "W214"),
    ("union([for i in range(6): rotate(box([30, 5, 5]), [0, 0, 1], 60 * i)])", "W214"),
    ("union([for i in range(6): translate(sphere(3), [20 * cos(60 * i), 20, 0])])", "W214"),
    ("translate(sphere(3), [20 * sin(45), 0, 0])", "W214"),
    ("twist(box([20, 20, 60]), 90)", "W214"),
    ("union([for i in range(7): rotate(box([30, 5, 5]), [0, 0, 1], 360 / 7 * i)])", "W214"),
    ("rotate(box([10, 20, 30]), [0, 0, 1], degrees(30))", "W214"),
    ("let a = degrees(30)\nrotate(box([10, 20, 30]), [0, 0, 1], a)", "W214"),
    ("rotate(box([10, 20, 30]), [0, 0, 1], degrees(30deg))", "W214"),
    ("let a = degrees(pi / 6)\nrotate(box([10, 20, 30]), [0, 0, 1], a)", "W214"),
    ("param a = 30deg in 0deg..90deg\nrotate(box([10, 20, 30]), [0, 0, 1], -degrees(a))", "W214"),
    ("param a = 30 in 0..90\nrotate(box([10, 20, 30]), [0, 0, 1], angle=degrees(a))", "W214"),
    ("sphere(9) - sin(degrees(atan2(y, x)))", "W214"),
    # shares and numbers of percent
    ('let env = cube(20)\ncheck porosity(env \\ sphere(5), env) < 70, "open"\nenv', "W226"),
    ('let env = cube(20)\ncheck 30 < 1 - porosity(env \\ sphere(5), env), "dense"\nenv', "W226"),
    ('param a = 60% in 10%..90%\ncheck a < 70, "open"\nsphere(5 * a)', "W226"),
    ('param a = 60% in 10%..90%\nlet most = 70\ncheck a <= most, "open"\nsphere(5 * a)', "W226"),
    ('let env = cube(9)\nparam most = 70 in 50..80\ncheck porosity(env, env) < most, "open"\nenv', "W226"),
    ("offset(gyroid(5), solve(t => porosity(offset(gyroid(5), t), cube(9)), 70, -1..1)) & cube(9)", "W226"),
    # offsets that leave nothing
    ("let core = gyroid(8) |> shell(0.5) & offset(box([80, 40, 6]), -8mm)\nbox([9, 9, 9]) | core", "W227"),
    ("param t = 4mm in 3.5mm..6mm\ncube(3) | offset(box([80, 40, 6]), -t)", "W227"),
    ("union([cube(3), offset(cylinder(2, 40), -2.5mm)])", "W227"),
    # a cut that binds more tightly than the union before it
    ("let skin = translate(sphere(3), [20, 0, 0])\nsphere(9) | skin \\ cylinder(1, 30)", "W223"),
    # copies that are cut
    ("ring(capsule([5, 0, 0], [15, 10, 0], 1), 8)", "W215"),
    ("cylinder(4, 4) | ring(translate(box([4, 10, 2]), [0, 9, 0]), 7)", "W215"),  # not on the side of +x
    ("repeat(capsule([0, 0, 0], [8, 0, 0], 1), 10, counts=[3, 1, 1])", "W215"),
    ("repeat(translate(sphere(4), [5, 0, 0]), 10, counts=[4, 1, 1])", "W215"),
    # exchanged arguments
    ("shell(0.5, gyroid(10)) & cube(20)", "W216"),
    ("0.5 |> shell(gyroid(10)) & cube(20)", "W216"),
    ("offset(2, box([10, 20, 30]))", "W216"),
    ("scale(2, sphere(5))", "W216"),
    # layout
    ("gyroid(10) & cube(20)\n  |> translate([10, 0, 0])", "W217"),
    ("gyroid(10)\n  & cube(20)\n  |> translate([10, 0, 0])", "W217"),
    ("sphere(3) | gyroid(10) & cube(20)\n|> translate([10, 0, 0])", "W217"),
    # seams
    ("polar(gyroid(6), turn=100) & cylinder(20, 20)", "W218"),
    ("spherical(gyroid(6) |> shell(0.3), 100mm) & sphere(20)", "W218"),
    ("translate(polar(gyroid(6), turn=100) & cylinder(20, 20), [50, 0, 0])", "W218"),
    ("param w = 6mm in 4mm..10mm\npolar(gyroid(w), turn=100) & cylinder(20, 20)", "W218"),
    # directions that are 0, and turns that a lattice does not share
    ("align(gyroid(6), grad(clamp(x, 0, 20))) & sphere(12)", "W235"),
    ("gyroid(6) |> align([max(x, 0), 0, 0]) & sphere(12)", "W235"),
    ("align(gyroid(6), [20, x - 60, 0], symmetry=2) & cylinder(12, 8)", "W236"),
    ("gyroid(6) |> shell(0.3) |> align([20, x - 60, 0], symmetry=2) & cylinder(12, 8)", "W236"),
    (
        "param w = 6mm in 4mm..9mm\nlet v = [20, x - 60, 0]\n"
        "align(diamond(w), v, symmetry=2, about=[0, w / 4, 0]) & cylinder(12, 8)",
        "W236",
    ),
    ("align(gyroid(6), [20, x + 40, 0], symmetry=4) & cylinder(12, 8)", "W236"),
    # curves that miss their points, or bend within the part
    ("let q = [[0, 0, 0], [40, 0, 0], [0, 20, 0]]\nalong(gyroid(6), q) & pipe(q, 4)", "W240"),
    ("let q = [[0, 0, 0], [40, 0, 0], [40, 40, 0]]\nalong(gyroid(6), q, bend=4mm) & pipe(q, 9, bend=4mm)", "W240"),
    ("let q = arc(10mm, 0deg, 270deg)\nalong(gyroid(6), q) & pipe(q, 12)", "W240"),
    ("let q = [[0, 0, 0], [40, 0, 0], [40, 40, 0]]\nalong(gyroid(6), q) & pipe(q, 3, bend=8mm)", "W240"),
    ("let q = [[0, 0, 0], [40, 0, 0], [40, 40, 0]]\nalong(gyroid(6), q, bend=9mm) & pipe(q, 3)", "W240"),
    # coordinates that stretch and fold cells
    ("align(gyroid(10), grad(sphere(20))) & sphere(40)", "W239"),
    ("align(gyroid(8), [0.001 * x, 0.001 * y, 1]) & sphere(20)", "W239"),
    ("gyroid(8) |> align([0.001 * y, 1, 0.001 * x], up=[0, 1, 0]) & sphere(20)", "W239"),
    ("polar(gyroid(8) |> align([0.001 * x, 0.001 * y, 1]), 80mm) & cylinder(20, 10) & (-x)", "W239"),
    ("metric(gyroid(10) |> align(grad(hypot(x, y)))) |> shell(0.8mm) & cylinder(35mm, 30mm)", "W239"),
    ("along(gyroid(6), arc(8, 0deg, 90deg)) & pipe(arc(8, 0deg, 90deg), 7) & cylinder(5, 20)", "W239"),
    (
        "gyroid(phase=[x / 6, y / 6, between(z + 3, z - 2 - x / 60, cells=3)]) & z - 2 & -3 - z & cylinder(20, 9)",
        "W239",
    ),
    ("wedges(gyroid(6), 7) & cylinder(30, 8)", "W218"),
    ("gyroid(phase=sphere_map(18, cells=12)) |> shell(1.2) & sphere(21) \\ sphere(15)", "W218"),
    ("translate(gyroid(phase=sphere_map(18, cells=12)) & sphere(21) \\ sphere(15), [90, 0, 0])", "W218"),
    ("gyroid(phase=sphere_map(20, cells=16)) |> shell(0.3) & sphere(22) \\ sphere(20)", "W218"),
    ("gyroid(phase=sphere_map(5, cells=16)) |> shell(0.3) & sphere(5.5) \\ sphere(5)", "W218"),
    ("gyroid(phase=[hypot(x, y) / 6, atan2(y, x) / 1turn * 19.5, z / 6]) |> shell(0.4) & cylinder(20, 20)", "W218"),
    (
        "rotate(gyroid(phase=[hypot(x, y) / 6, 6.5 * atan2(y, x) / 1turn, z / 6]), [1, 0, 0], 1) "
        "& translate(sphere(20), [0, 9, 0])",
        "W218",
    ),
    ("gyroid(phase=if x > 0 then p / 10 else p / 11) & sphere(20)", "W218"),
    ("param v = 6mm in 4mm..9mm\nwedges(gyroid(v), w=v * 1.5) & cylinder(30, 8)", "W218"),
    ("along(gyroid(6), arc(30, 0deg, 90deg), w=7mm) & pipe(arc(30, 0deg, 90deg), 5)", "W218"),
    # steps and names
    ("param w = 10.3mm in 10mm..60mm step 1mm\ngyroid(w) & sphere(20)", "W219"),
    ("let hole = cylinder(5, 40)\nsphere(10)", "W220"),
    ("param t = 1mm in 0.5mm..2mm\nsphere(10)", "W220"),
    # what meets nothing, and what is left of nothing
    ("cube(20) \\ translate(cylinder(3, 40), [30, 0, 0])", "W223"),
    ("cube(9) | sphere(2) & translate(sphere(2), [10, 0, 0])", "W223"),
    ("gyroid(10) |> shell(4) & cube(40)", "W224"),
    ("gyroid(10) |> shell(3.1) & cube(40)", "W224"),
    ("gyroid(10) - 2 * diamond(7) + 5 & cube(40)", "W224"),
    ("offset(gyroid(10), 2) & cube(40)", "W224"),
    (
        "param l = 40mm in 25mm..60mm\nlet tube = cylinder(10, l) \\ cylinder(8, l + 2)\n"
        "tube \\ ring(translate(cylinder(1, l + 2), [5, 0, 0]), 6)",
        "W223",
    ),
    # what other commands refuse
    ("gyroid(10) |> shell(0.5)", "W210"),
    ("gyroid(10) & slab([0, 0, 1], 30)", "W210"),
    ("offset(gyroid(10), to_porosity(gyroid(10), 60%, cube(20)))", "W210"),
    ("gyroid(10) > 0 & cube(20)", "W211"),
    ("let dome = sphere(10) & z > 2mm\nout part = dome", "W211"),
    ("grad(x)", "W211"),
    ("5", "W211"),
    ("x^2 + 1", "W211"),
    ("let a = sphere(5)", "W221"),
    ("", "E100"),
    ("sphere(2) & translate(sphere(2), [10, 0, 0])", "E103"),
    ("offset(cube(20), -15)", "E103"),
    ("cylinder(40, 10) \\ cylinder(40, 12)", "E103"),
    ("sphere(5) & ~sphere(5)", "E103"),
    ("gyroid(10) |> shell(0) & cube(40)", "E103"),
    ("gyroid(10) + 3 & cube(10)", "E103"),
    ("param phi = 70 in 50..90\noffset(gyroid(9), to_porosity(gyroid(9), phi, cube(20))) & cube(20)", "E086"),
]


def test_no_edit_is_proposed_that_leaves_nothing() -> None:
    """The plate is 4 mm thick, and its 3 mm are 0.6 mm: 3 mm from both sides are more than it has."""
    text = "(slab([0, 0, 1], 20) @ [x, y, 5 * z]) + {} & cylinder(10, 50)"
    (d,) = said(text.format("3mm"))
    assert (d.code, d.edit) == ("W238", None)
    assert "leave nothing" in d.hint
    (d,) = said(text.format("1mm"))
    assert d.edit is not None


def test_a_length_that_is_stretched_is_looked_for_as_far_as_it_reaches() -> None:
    """Between boxes of 20 x 20 x 60 and 16 x 16 x 48 are 11712 mm3: those at the ends, where 2 mm are 6, are 3904."""
    (d,) = said("offset(scale(box([20, 20, 20]), [1, 1, 3]), -2mm)")
    assert "is 3 mm long" in d.message
    share = float(re.findall(r"at (\d+) % of its surface", d.message)[0])
    assert share == pytest.approx(100 * 3904 / 11712, abs=7)


RIGHT = [
    # near the axis cells are narrow with any number of them
    "polar(gyroid(6), turn=60) & cylinder(20, 20)",
    "scale(polar(gyroid(6), turn=156), 2) & cylinder(60, 20) \\ cylinder(40, 30)",
    "spherical(gyroid(6), 156mm) & sphere(30) \\ sphere(20)",
    # an angle that begins again at a whole number of cells, where no part is, and in a part of a ring
    "gyroid(phase=[hypot(x, y) / 6, atan2(y, x) / 1turn * 20, z / 6]) |> shell(0.4) & cylinder(20, 20)",
    "gyroid(phase=[hypot(x, y) / 6, atan2(y, x) / 1turn * 19.5, z / 6]) & translate(cube(20), [20, 0, 0])",
    # distances that were moved, turned or scaled as a whole, hardly bent, or used as a number
    "metric(twist(metric(gyroid(10)), 0.1)) |> shell(0.8mm) & cube(30)",
    "scale(metric(gyroid(10)), 2) |> shell(0.8mm) & cube(30)",
    "rotate(metric(gyroid(10)), [1, 0, 0], 30deg) |> shell(0.8mm) & cube(30)",
    "param a = 20deg in 0deg..40deg\nrotate(metric(gyroid(10)), [1, 0, 0], a) |> shell(0.8mm) & cube(30)",
    "mirror(metric(gyroid(10)), [1, 0, 0]) |> shell(0.8mm) & cube(30)",
    "ring(metric(gyroid(10)), 6) |> shell(0.8mm) & cube(30)",
    "repeat(sphere(3), 10, counts=[3, 3, 1]) |> shell(0.5mm)",
    # as thick as the manual's table allows
    *(
        f"metric({lattice}(10)) |> shell({most}mm) & cube(20)"
        for lattice, most in (
            ("gyroid", 3.25),
            ("schwarz_p", 2.5),
            ("diamond", 2),
            ("neovius", 0.75),
            ("octo", 0.3),
        )
    ),
    "metric(gyroid(8) & cylinder(15, 40)) |> shell(1mm)",
    # of which the length hardly varied, and a texture without a wall
    "sphere(20) - 2mm * ramp(z, -20, 20) |> shell(0.8mm)",
    "torus(20, 5) + 0.3mm * gyroid(5)",
    # what a wall is graded by is no wall, however it depends on a distance
    *(
        f"let body = sphere(30)\nmetric(gyroid(8)) |> {graded} & body"
        for graded in (
            "shell(1.5mm + body / 20)",
            "shell(1.6mm + 0.05 * body)",
            "shell(clamp(0.5mm - body / 20, 0.2mm, 1mm))",
            "shell(max(0.4mm, 1.5mm + body / 10))",
            "offset(0.5mm + body * 0.02)",
            "thicken(body / 10 + 1mm, 0.5)",
            'shell(2mm + body / 20, side="inside")',
            "shell(0.6mm) |> thicken(-body * 0.02)",
        )
    ),
    "let body = sphere(30)\nblend(metric(gyroid(8)), metric(gyroid(9)), along=body / 2 + 5mm, r=4) & body",
    "shell(sphere(20), clamp(3mm - cube(30) / 10, 1mm, 3mm))",
    # a fillet rises by less, turned or not
    "smooth_union(sphere(10), translate(box([10, 50, 10]), [0, 9, 0]), 2mm + 2mm * ramp(x, -9, 9)) |> shell(1mm)",
    "smooth_union(cylinder(10, 40), translate(cylinder(40, 10), [0, 0, 3]), 5mm) |> shell(1mm)",
    "smooth_union(cylinder(9, 40), rotate(translate(cylinder(40, 9), [0, 0, 3]), [1, 0, 0], 0deg), 5mm) |> shell(1mm)",
    "smooth_union(box([33.5, 28.3, 16.7]), rotate(cylinder(7.8, 50.7), [1, 0, 0], 33deg), 1.6mm) |> shell(0.9mm)",
    "smooth_union(scale(sphere(10), 2), translate(box([10, 50, 10]), [0, 9, 0]), 5mm) |> shell(1mm)",
    "twist(box([20, 20, 60]), 0.03) |> shell(1mm)",
    "twist(metric(gyroid(10)) |> shell(0.8mm), 0.01) & cube(30)",
    "scale(metric(gyroid(10)) |> shell(0.8mm), 2) & cube(30)",  # larger as a whole
    "rotate(metric(gyroid(10)) |> shell(0.8mm), [1, 2, 0], 30deg) & cube(30)",
    "2 * sphere(10) - 4",  # a number of those that it was made
    "morph(metric(gyroid(10)), metric(gyroid(10)), 0.5) |> shell(0.8mm) & cube(30)",
    "let near = ramp(scale(sphere(10), [1, 1, 2]), 0mm, 10mm)\ngyroid(10) |> thicken(near, 0.3) & cube(20)",
    "let d = sphere(20)\nout part = d & cube(30)\nout heat = d / 100",
    # periods that are the same everywhere, or hardly vary, or are had by a phase; and a wave of p / w that is meant
    "gyroid(20mm + 0 * x) & cylinder(75mm, 300mm)",
    "gyroid(20mm + z / 150) & cylinder(75mm, 300mm)",
    "gyroid([10, 20, 30]) & cylinder(75mm, 300mm)",
    "let part = cylinder(75mm, 300mm)\ngyroid(phase=phase(25mm + z / 10, part)) & part",
    "gyroid(phase=p / (25mm + z / 10)) & cylinder(75mm, 300mm)",
    "gyroid(20mm + (if length(p) > 100 then x / 2 else 0)) & sphere(50mm)",
    # directions that are 0 at a point or outside, turns that a lattice shares, or that are not met
    "wedges(gyroid(6), 6mm) & cylinder(30, 8)",
    "param v = 6mm in 4mm..9mm\nwedges(gyroid(v), w=v) & cylinder(30, 8)",
    *(f"{f}(phase=sphere_map(18, cells=12)) & sphere(21) \\ sphere(15)" for f in ("schwarz_p", "iwp", "neovius")),
    "gyroid(phase=cylinder_map(18, cells=12)) & cylinder(21, 30) \\ cylinder(15, 40)",
    "gyroid(phase=if x > 0 then p / 10 else [2 * x, y, z] / 10) & sphere(20)",
    "gyroid(phase=if x > 20 then p / 10 else p / 11) & sphere(20)",
    "along(gyroid(6), arc(30, 0deg, 90deg), w=12mm) & pipe(arc(30, 0deg, 90deg), 5)",
    "along(gyroid(6), arc(30, 0deg, 90deg)) & pipe(arc(30, 0deg, 90deg), 5)",
    "align(gyroid(6), grad(sphere(50)), about=[50, 0, 0]) & translate(sphere(12), [50, 0, 0])",
    "align(gyroid(6), grad(max(x + 7, 0))) & sphere(12) & -6 - x",
    "let q = [[0, 0, 0], [40, 0, 0], [40, 40, 0]]\nalong(gyroid(6), q, bend=9mm) & pipe(q, 6, bend=9mm)",
    # the other leg passes through the centre of the bend between
    "let q = [[0, 0, 0], [30, 0, 0], [30, 30, 0], [22, 30, 9], [22, -9, 0]]\n"
    "along(gyroid(6), q, bend=3) & pipe(q, 2, bend=3)",
    "diamond(phase=sphere_map(20, cells=12)) & sphere(25) \\ sphere(15)",
    "align(schwarz_p(6), [y, x, 0], symmetry=2) & cylinder(12, 8)",
    "align(schwarz_p(6), [y, x, 0], symmetry=4) & cylinder(12, 8)",
    "align(gyroid(6), [20, x - 60, 0], symmetry=2, about=[0, 1.5, 0]) & cylinder(12, 8)",
    "align(diamond(8), [20, x - 60, 0], symmetry=2, about=[1, 1, 0]) & sphere(12)",
    "align(gyroid(6), [1, 0.2 * sin(x / 5), 0], symmetry=2) & cylinder(12, 8)",
    "align(gyroid(6), [sign(x), 0, 0], symmetry=2) & cylinder(12, 8)",
    # numbers of degrees, as numbers and as what they were made of
    "rotate(box([10, 20, 30]), [0, 0, 1], degrees(30deg) * 1deg)",
    "rotate(box([10, 20, 30]), [0, 0, 1], radians(degrees(30deg)))",
    "sphere(degrees(30deg))",
    'param a = 30deg in 0deg..90deg\ncheck degrees(a) < 91, "a quarter"\nrotate(box([10, 20, 30]), [0, 0, 1], a)',
    "sphere(9) - degrees(atan2(y, x)) / 100",
    # shares, and numbers that are none
    'let env = cube(20)\ncheck porosity(env \\ sphere(5), env) < 70%, "open"\nenv',
    'let env = cube(20)\ncheck porosity(env \\ sphere(5), env) <= 1, "open"\nenv',
    'let env = cube(20)\ncheck 100 * porosity(env \\ sphere(5), env) < 70, "open"\nenv',
    'let env = cube(20)\ncheck volume(env \\ sphere(5)) > 70, "there"\nenv',
    'param a = 60% in 10%..250%\ncheck a < 2, "stretched"\nsphere(5 * a)',
    'param a = 0.6 in 0.1..0.9\ncheck a < 70, "any number"\nsphere(5 * a)',
    "param a = 60% in 10%..90%\nsphere(if a < 50% then 4 else 5)",
    # offsets that leave something, now or with a param at an end of its range
    "offset(box([80, 40, 6]), -2.9mm)",
    "param t = 4mm in 1mm..6mm\ncube(3) | offset(box([80, 40, 6]), -t)",
    "union([for i in range(4): offset(sphere(5), -2 * i)])",
    "offset(gyroid(9), -0.5) & cube(20)",
    # a cut of the last of a union, which is the one that is meant
    "sphere(10) | cylinder(5, 40) \\ cylinder(4, 42)",
    # walls that read two lattices, of which the one is great where the other is small
    "(gyroid(10) - gyroid(7) + 0.5) & cube(40)",
    "(gyroid(10) + diamond(7) - 0.5) & cube(40)",
    "shell(gyroid(10) - diamond(7), 3) & cube(40)",
    "gyroid(30) & cylinder(75, 300)",
    "sphere(5)",
    "param w = 9mm in 6mm..20mm\nlet cyl = cylinder(20, 40)\nthicken(gyroid(w), cyl, 0.3) & cyl",
    "gyroid(20) |> thicken((torus(60, 20) - sphere(40)) / 100) & cylinder(75, 300)",
    'let b = cube(20)\nlet s = compress(b, 1kN, material="PA12")\ngyroid(10) |> thicken(1 - s.von_mises / 9MPa) & b',
    'let b = cube(20)\nlet s = compress(b, 1kN, material="PA12")\ngyroid(10) |> thicken(s.von_mises, -0.3 / 9MPa) & b',
    "let heat = torus(60, 20) - sphere(40)\ngyroid(20) |> thicken(max(heat, 0) / 100, 0.3) & cylinder(75, 300)",
    "sphere(10) - 2",
    "sphere(10) - 0.3 * sin(2 * x)",
    "sphere(20) & (sphere(2) @ [x - 9, y, z]) - (sphere(2) @ [x + 9, y, z])",  # the half that is nearer to one
    "rotate(box([30, 5, 5]), [0, 0, 1], pi / 3)",
    "rotate(box([30, 5, 5]), [0, 0, 1], 7)",
    "def spin(f, a) = rotate(f, [0, 0, 1], a)\nspin(box([30, 5, 5]), 12turn)",
    "param n = 7 in 0..20\nrotate(box([30, 5, 5]), [0, 0, 1], n * tau / 20)",
    "union([for i in range(40): translate(sphere(2), [12 * cos(0.7 * i), 12 * sin(0.7 * i), i])])",
    "union([for i in range(40): translate(sphere(2), [9 * sin(12.9898 * i), 9 * sin(78.233 * i), i])])",
    "sphere(10) & sin(40 * x)",
    "cylinder(10, 5) | ring(translate(box([4, 2, 5]), [11, 0, 0]), 24)",
    "polar(repeat(sphere(1), [100, 4, 4]), turn=40) & cylinder(8, 20)",
    "cylinder(10, 20) - 0.3 * max(sin(20 * atan2(y, x) + z), sin(20 * atan2(y, x) - z))",
    "let g = gyroid(10)\ng / length(grad(g)) |> shell(0.4mm) & cube(20)",
    "smooth_union(metric(gyroid(10)) & cube(20), sphere(4), 2mm)",
    "metric(gyroid(10)) |> shell(mix(0.2mm, 1mm, ramp(z, 0, 30))) & cube(20)",
    "gyroid(10) |> thicken(sphere(9) * 0.1) & cube(20)",  # by a distance, which is a number here
    "gyroid(10) & z - 2mm & cube(20)",
    "max(gyroid(10), z * 0.5 - 1mm) & cube(20)",
    "thicken(sphere(20), gyroid(5), 0.3mm)",  # a texture
    "offset(sphere(20), 0.5mm + gyroid(5) * 0.3mm)",
    "sphere(20) - 0.3 * gyroid(5)",
    "sphere(10) & translate(sphere(10), [12, 0, 0])",
    "cube(20um) & gyroid(5um)",
    "ring(translate(sphere(3), [12, 0, 0]), 6)",
    "ring(translate(sphere(8), [12, 0, 0]), 6)",  # they overlap, and nothing is lost
    "ring(gyroid(10) |> shell(0.5), 6) & cylinder(20, 20)",
    "repeat(sphere(3), 10, counts=[3, 2, 4])",
    "repeat(sphere(6), 10, counts=[3, 2, 1])",
    "repeat(cylinder(2, 40), [10, 10, 0.5], counts=[3, 3, 1])",
    "polar(gyroid(6), turn=102) & cylinder(20, 20)",
    "param w = 6mm in 4mm..10mm\npolar(gyroid(w), turn=17 * w) & cylinder(20, 20)",
    "polar(box([40, 50, 5]), turn=100)",  # a plate that is bent, open on purpose
    "polar(gyroid(6), turn=100) & translate(cylinder(8, 20), [15, 0, 0])",  # the seam lies elsewhere
    "let k = tau / 30\ntranslate(sphere(3), [9 * sin(k * 60), 0, 0])",
    "gyroid(2) |> thicken(hypot(x, y) / 5 - 1, 1.6) & cylinder(6, 6)",
    "gyroid(3) |> thicken(2 - hypot(x, y), 3) & translate(cylinder(2, 6), [2, 0, 0])",
    "param w = 6mm in 4mm..10mm\ngyroid(w) |> shell(0.4mm * 9.6 / w) & cube(20)",
    "shell(sphere(10), 0.4mm)",
    "(sphere(10) \\ cube(12)) |> shell(0.4mm)",
    "bare(0.4mm) - abs(gyroid(10)) & cube(20)",
    "gyroid(10) |> thicken(-0.2, 1) |> shell(0.4) & cube(20)",
    "gyroid(10) * 1.5mm |> shell(0.4mm) & cube(20)",  # somebody made it a length
    "sphere(20) - gyroid(5)",
    "gyroid(w=10) |> shell(0.8)\n  |> twist(90deg / 50mm)\n  & cylinder(10, 40)",
    "sphere(9) \\ cube(4)\n| cylinder(2, 30)\n    |> translate([0, 0, 9])",  # as it stands there
    "sphere(9) & (cube(20)\n  |> translate([5, 0, 0]))",
    "sphere(9) & cube(20) |> translate([5, 0, 0])",
    "param t = 0.5 in 0.1..2 step 0.25\nsphere(10) |> shell(t)",
    "let _envelope = cylinder(20, 20)\ngyroid(10) |> shell(0.5) & cylinder(20, 20)",
    "def unused(f) = shell(f, 1)\nsphere(10)",
    "union([for i in range(4): cube(20) \\ translate(cylinder(3, 40), [12 * i, 0, 0])])",
    "param at = 0mm in 0mm..30mm\ncube(20) \\ translate(sphere(3), [20 - at, 0, 0])",
    "(cube(5) | gyroid(10) |> shell(0.001)) & cube(20)",
    "gyroid(10) |> shell(2.9) & cube(40)",
    "translate(sphere(0.01), [5000, 0, 0])",
    "out heat = x / 10\nout direction = grad(x)",
    "x + 1",
    "offset(gyroid(9), to_porosity(gyroid(9), 60%, cube(20))) & cube(20)",
    "def lib(r) = sphere(r)",
    "let wall = 0.4mm",
]


@pytest.mark.parametrize(("text", "code"), DOUBTED)
def test_what_is_doubtful_is_doubted_once_with_a_place_a_reason_and_an_edit_that_mends_it(text: str, code: str) -> None:
    """As one test, for each of several processes would find the doubts of every text."""
    assert codes(text).count(code) == 1 if code != "W214" else code in codes(text)
    for d in said(text):
        if d.code != "E086":
            assert d.span is not None
            assert d.hint
            assert d.label or d.code == "E100"
    if edited(text, code):  # not every doubt has an edit
        assert_mended(text, code)


def edited(text: str, code: str) -> bool:
    return any(d.edit is not None for d in said(text) if d.code == code)


def assert_mended(text: str, code: str) -> None:
    """As often as something is said, and each time less is."""
    for _ in range(4):
        found = [d for d in said(text) if d.code == code]
        if not found:
            return
        edit = found[0].edit
        assert edit is not None
        text = edit.apply(text)
    assert code not in codes(text)


@pytest.mark.parametrize("text", RIGHT)
def test_what_is_right_is_not_doubted(text: str) -> None:
    assert codes(text) == []


@pytest.mark.parametrize("code", ["W212", "W213", "W214", "W215", "W216", "W217", "W218", "W223", "W226"])
def test_most_doubts_of_the_text_come_with_an_edit(code: str) -> None:
    assert any(edited(text, code) for text, of in DOUBTED if of == code)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("degrees(30)", "30deg"),
        ("angle=degrees(30)", "angle=30deg"),
        ("degrees(pi / 6)", "pi / 6"),
        ("degrees(30deg)", "30deg"),
        ("-degrees(30deg)", "-30deg"),
        ("degrees(30 + 15)", "(30 + 15) * 1deg"),
    ],
)
def test_a_number_of_degrees_becomes_the_angle_that_it_is_of(wrong: str, right: str) -> None:
    text = f"rotate(box([10, 20, 30]), [0, 0, 1], {wrong})"
    (d,) = said(text)
    assert d.edit is not None
    assert d.edit.apply(text) == text.replace(wrong, right)


def test_an_offset_that_leaves_nothing_says_how_thick_the_solid_is() -> None:
    (d,) = said("cube(9) | offset(box([80, 40, 6]), -8mm)")
    assert float(re.findall(r"about ([\d.]+) mm", d.label)[0]) == pytest.approx(3, rel=0.01)


def test_another_up_is_proposed_only_where_it_leaves_cells() -> None:
    """A direction along `up`, whose frame turns as it passes it; and one that points away from a centre."""
    (d,) = said("align(gyroid(8), [0.001 * x, 0.001 * y, 1]) & sphere(20)")
    assert d.edit is not None
    assert d.edit.text == ", up=[0, 1, 0])"
    for text in (
        "align(gyroid(10), grad(sphere(20))) & sphere(40)",
        "gyroid(8) |> align([x, y, 12]) & sphere(20)",
        "align(gyroid(8), [0.001 * y, 1, 0.001 * x], up=[0, 1, 0]) & sphere(20)",
    ):
        (d,) = [d for d in said(text) if d.code == "W239"]
        assert d.edit is None
        assert "`up`" not in d.hint


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("along(gyroid(6), q) & pipe(q, 3, bend=8mm)", "`along` the same, `bend=8mm`"),
        ("along(gyroid(6), q, bend=9mm) & pipe(q, 3)", "`pipe` the same, `bend=9mm`"),
        ("along(gyroid(6), q, bend=9mm) & pipe(q, 3, bend=15mm)", "both the same"),
        ("along(gyroid(6), q, bend=9mm) & pipe(q, 3, bend=9mm)", ""),
        ("along(gyroid(6), q) & pipe(q, 3, bend=40mm)", ""),  # which is what it is without
        ("along(gyroid(6), q) & pipe(q, 3) | pipe(q, 1, bend=8mm)", ""),
        ("along(gyroid(6), q) & pipe([[0, 0, 0], [40, 0, 0], [40, 0, 20]], 3, bend=8mm)", ""),
    ],
)
def test_a_rod_is_along_the_curve_of_the_cells_in_it(text: str, says: str) -> None:
    """At a right angle an arc of radius r passes the corner by r (sqrt 2 - 1), and without `bend=` r is 40 here."""
    told = [d for d in said(f"let q = [[0, 0, 0], [40, 0, 0], [40, 40, 0]]\n{text}") if d.code == "W240"]
    assert bool(told) == bool(says)
    if not says:
        return
    assert says in told[0].hint
    radii = [float(r[1]) if (r := re.search(r"bend=(\d+)mm", call)) else 40.0 for call in text.split("&")]
    apart = float(re.findall(r"([\d.]+) mm apart", told[0].message)[0])
    assert apart == pytest.approx(abs(radii[0] - radii[1]) * (np.sqrt(2) - 1), rel=0.01)


def test_parentheses_are_shown_only_where_they_mend_the_cut() -> None:
    (d,) = said("sphere(9) | translate(sphere(3), [20, 0, 0]) \\ translate(sphere(1), [40, 0, 0])")
    assert d.edit is None  # it meets neither


# ---- what is right as it is -----------------------------------------------------------------------------------------


def written_programs() -> Iterator[tuple[str, Source]]:
    for folder in ("examples", "tests/conformance", "tests/regressions"):
        for path in sorted((ROOT / folder).rglob("*.pore")):
            if "# rejected" in path.read_text(encoding="utf-8"):
                continue
            yield path.relative_to(ROOT).as_posix(), read_source(path)
    for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        for found in re.finditer(r"```pore\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL):
            yield f"{path.name}:{found.start()}", Source("document.pore", found[1])
    for name, source in prelude_files():
        for found in re.finditer(r"^## Example: (.*)$", source.text, re.MULTILINE):
            yield f"{name}: {found[1]}", Source("example.pore", found[1])
    for code, page in CODES.items():
        if page.right and 'use "' not in page.right:
            yield f"the right program of {code}", Source("right.pore", page.right)


WRITTEN = dict(written_programs())


@pytest.mark.parametrize("name", WRITTEN)
def test_no_false_alarm_about_a_program_that_is_right(name: str) -> None:
    found = {d.code for d in said_of(WRITTEN[name]) if d.code != "W201"}
    assert found <= (OF_FIELDS if not name.startswith("examples") else OF_FIGURES.get(Path(name).stem, set()))


@pytest.mark.parametrize("name", sorted(p.stem for p in (ROOT / "tests" / "errors").glob("*.pore")))
def test_golden_mistakes_bring_no_doubts_but_their_own(name: str) -> None:
    """A program with an error is not doubted on top of it."""
    if name == "too_big":
        return
    _, found = try_compile(read_source(ROOT / "tests" / "errors" / f"{name}.pore"))
    if any(d.severity == "error" for d in found):
        assert not {d.code for d in found if d.severity == "warning"}


@pytest.mark.parametrize("text", [text for text, code in DOUBTED if code == "W210"])
def test_no_end_is_said_only_where_bounds_say_so(text: str) -> None:
    with pytest.raises(PoreError, match="has no end"):
        porelang.compile(text).bounds()


# ---- numbers that a doubt states ------------------------------------------------------------------------------------


def test_a_cut_that_misses_says_with_what() -> None:
    text = "param d = 5mm in {}\nlet tube = cylinder(10, 9) \\ cylinder(8, 10)\n"
    text += "tube \\ translate(cylinder(1, 60), [d, 0, 0])"
    (d,) = said(text.format("3mm..6mm"))
    assert "takes nothing away here with d = 5mm" in d.message
    assert codes(text.format("3mm..9mm")) == []  # it may be what the param is for
    (d,) = said(text.format("3mm..9mm"), measure=True)
    assert "with d = 5mm" in d.message
    (d,) = said(text.format("3mm..9mm").replace("= 5mm", "= 9mm"), measure=True)
    assert "with d = 3mm" in d.message


@pytest.mark.parametrize("made", ["cylinder(10, 60) - cylinder(8, 70)", "cone(10, 5, 20) - cylinder(3, 50)"])
def test_no_end_is_said_in_the_words_of_meshing(made: str) -> None:
    found = [d for d in said(made) if d.code == "W210"]
    with pytest.raises(PoreError) as refused, pytest.warns(porelang.PoreWarning):
        porelang.compile(made).bounds()
    assert [d.message for d in found] == [d.message for d in refused.value.diagnostics]


def test_the_share_of_a_copy_that_is_lost() -> None:
    """`ring` keeps 142 mm3 of 385."""
    (d,) = said("ring(capsule([5, 0, 0], [15, 10, 0], 1), 8)")
    lost = int(re.findall(r"(\d+) % is lost", d.message)[0])
    assert lost == pytest.approx(100 * (1 - 142 / 385), abs=3)


# ---- what takes longer, and where it is said ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("param d = 5mm in 1mm..40mm\ncube(20) \\ cylinder(d, 40)", "W222"),
        ("sphere(10) & translate(sphere(10), [12, 16, 0])", "W211"),
        # a cut that does nothing now, or with a param at an end of its range
        ("param at = 0mm in 0mm..30mm\ncube(20) \\ translate(sphere(3), [20 - at, 0, 0])", "W223"),
        ("param at = 9mm in 0mm..30mm\ncube(20) \\ translate(sphere(3), [20 - at, 0, 0])", "W223"),
        ("gyroid(200) |> shell(0.3) & cube(20)", "W225"),
        ("rotate(translate(gyroid(200), [3, 0, 0]), [1, 1, 0], 0.5) |> shell(0.3) & cube(20)", "W225"),
        ("param k = gyroid in {gyroid, diamond}\nk(200) |> shell(0.3) & cube(20)", "W225"),
    ],
)
def test_what_takes_longer_is_found_by_measuring(text: str, code: str) -> None:
    assert code not in codes(text)
    assert codes(text, measure=True) == [code]


def test_a_thin_part_in_a_box_that_is_far_too_large_is_found() -> None:
    """1600 mm3, in a proven box of 130 litres."""
    part = "along(gyroid(5), q) |> shell(0.6) & pipe(q, 5mm)"
    assert codes(f"let q = spline([[0, 0, 0], [30, 10, 0], [60, 0, 10], [90, -10, 0]], 4)\n{part}", measure=True) == []


def test_shapes_that_only_touch_hold_nothing_that_rounding_does_not() -> None:
    for i in range(6):
        text = f"rotate(sphere(10) & translate(sphere(10), [20, 0, 0]), [1, {i}, 2], {i + 0.3})"
        assert set(codes(text, measure=True)) & {"W211", "E103"}, text


@pytest.mark.parametrize(
    "lattice", ["scale(gyroid(60), 0.1)", "gyroid(60) @ [10 * x, 10 * y, 10 * z]", "polar(gyroid(60), turn=600)"]
)
def test_a_period_that_is_stretched_is_not_taken_for_one_in_mm(lattice: str) -> None:
    assert "W225" not in codes(f"{lattice} |> shell(0.3) & cube(20)", measure=True)


def test_what_is_too_large_to_look_at_hides_no_smaller_one() -> None:
    many = ", ".join(f"translate(sphere(1), [{i}, {i % 7}, 0])" for i in range(500))
    assert codes(f"let big = ring(union([{many}]), 6)\nbig | (cube(20) - sphere(9)) & cube(30)").count("W213") == 1


@pytest.mark.parametrize("name", sorted(p.stem for p in (ROOT / "examples").glob("*.pore")))
def test_measuring_finds_nothing_in_the_examples(name: str) -> None:
    assert said_of(read_source(ROOT / "examples" / f"{name}.pore"), measure=True) == []


def test_a_setting_between_steps_is_told_by_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "part.pore"
    file.write_text("param r = 5mm in 1mm..9mm step 1mm\nsphere(r)")
    for command in (["check"], ["eval", "--points", str(tmp_path / "p.csv")], ["measure"]):
        (tmp_path / "p.csv").write_text("0,0,0\n")
        assert main([command[0], str(file), *command[1:], "--set", "r=5.3mm"]) == 0
        assert capsys.readouterr().err.count("W219") == 1
    assert main(["check", str(file), "--set", "r=6mm"]) == 0
    assert "W219" not in capsys.readouterr().err


def test_doubts_are_told_by_every_command_and_kept_quiet_on_request(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "part.pore"
    file.write_text("let hole = cylinder(3, 30)\nsphere(10)")
    for more, count in (([], 1), (["-q"], 0)):
        assert main(["mesh", str(file), "-o", str(tmp_path / "a.stl"), "--resolution", "12", *more]) == 0
        assert capsys.readouterr().err.count("W220") == count


def test_a_name_that_an_option_reads_is_not_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "part.pore"
    file.write_text("let room = cube(20)\nsphere(10)")
    for more, count in ((["--within", "room"], 0), ([], 1)):
        assert main(["measure", str(file), "--resolution", "12", *more]) == 0
        assert capsys.readouterr().err.count("W220") == count


def test_a_field_is_told_to_have_no_end_in_a_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "field.pore"
    file.write_text("gyroid(10)")
    assert main(["check", str(file)]) == 0
    told = capsys.readouterr().err
    assert "without an end along x, y, z" in told
    assert "no warnings" in told


# ---- facts beside functions -----------------------------------------------------------------------------------------


def test_every_shape_and_lattice_says_what_it_gives() -> None:
    for name, source in prelude_files():
        if name in ("shapes", "tpms", "conventions/axolotl"):
            for head in re.findall(r"((?:^##.*\n)+)def (\w+)", source.text, re.MULTILINE):
                lattice = "Modifies: wavelength" in head[0]
                if lattice or (name == "shapes" and head[1] not in ("both", "polygon_edge", "segment")):
                    assert re.search(r"^## Gives: (a distance|a raw lattice|as \w+)$", head[0], re.MULTILINE), head[1]


def test_facts_name_parameters_that_there_are() -> None:
    def functions(scope: object) -> Iterator[Function]:
        for value in scope.values():  # type: ignore[attr-defined]  # a mapping of names
            if isinstance(value, Function):
                yield value
            elif isinstance(value, Record):
                yield from functions(value.members)

    for f in functions(prelude_scope().names):
        assert f.definition is not None
        named = re.findall(r"^(?:Gives: as|Copies:|Closes:) (\w+)(?: along y after (\w+)|, in cells of (\w+))?$",
                           f.definition.doc, re.MULTILINE)  # fmt: skip
        assert {n for found in named for n in found if n} <= {p.name for p in f.parameters}


def test_a_users_def_may_say_what_it_gives() -> None:
    own = "## Gives: a raw lattice\ndef waves(w) = sin(tau * x / w) + sin(tau * y / w) + sin(tau * z / w)\n"
    assert "E145" in [d.code for d in try_compile(Source("a.pore", own + "waves(10) |> shell(0.4mm) & cube(20)"))[1]]
    assert codes("def waves(w) = sin(tau * x / w) + sin(tau * z / w)\nwaves(9) |> shell(0.4mm) & cube(20)") == []


def test_an_output_that_holds_nothing_is_refused_beside_the_part() -> None:
    """`check` looked at the output that commands take by themselves, and `mesh --out b` refused another."""
    text = "out part = sphere(5)\nout b = sphere(3) & translate(sphere(2), [20, 0, 0])\nout heat = x + 3"
    (found,) = refusals(porelang.compile(text).design())
    assert (found.code, found.span.text) == ("E103", "sphere(3) & translate(sphere(2), [20, 0, 0])")


def test_the_place_of_a_period_is_right() -> None:
    """w = 25 + z/10 along z: the wave of z/w has the length w^2 / (w - z w') there, and x/w is sheared by x w'."""
    (told,) = said("gyroid(25mm + z / 10) & cylinder(75mm, 300mm)")
    x, y, z = map(float, re.search(r"at \(([^)]*)\)", told.message)[1].split(","))  # type: ignore[index]
    real, asked = map(float, re.search(r"they are (\S+) mm long, and (\S+) mm", told.message).groups())  # type: ignore[union-attr]
    w = 25 + z / 10
    lengths = {"x": 1 / np.hypot(1 / w, x / 10 / w**2), "y": 1 / np.hypot(1 / w, y / 10 / w**2), "z": w**2 / 25}
    assert asked == pytest.approx(w, rel=0.01)
    assert real == pytest.approx(lengths[told.label[6]], rel=0.02)


def told_of(design: porelang.Design, measure: bool) -> list[Diagnostic]:
    return design.told(*read_by(design.program), measure=measure)


def test_a_period_from_a_file_is_looked_at_when_the_file_is_read(tmp_path: Path) -> None:
    n = np.linspace(-40, 40, 9)
    np.savez(tmp_path / "w.npz", w=np.broadcast_to(10 + (n + 40) / 8, (9, 9, 9)), origin=[-40.0] * 3, spacing=10.0)
    file = tmp_path / "a.pore"
    file.write_text('let part = sphere(35mm)\ngyroid(load("w.npz", "w")) & part\n')
    program = porelang.compile(path=file)
    note, told = told_of(program.design(), measure=False)
    assert note.severity == "note"
    assert told.code == "W228"
    assert told.edit is not None
    file.write_text("let part = sphere(35mm)\ngyroid(sample(10 + z / 6, 2mm, part)) & part\n")
    design = porelang.compile(path=file).design()
    assert told_of(design, measure=False) == []  # what takes seconds is looked at on request
    assert [d.code for d in told_of(design, measure=True)] == ["W228"]
