"""What people write who come from other programs: the way out that is shown is tried, and leads to a program."""

from __future__ import annotations

import pytest

import porelang
from porelang.compiler import try_compile
from porelang.diagnostics import Diagnostic, Edit, render
from porelang.elaborate.names import PLANNED
from porelang.elaborate.prelude import prelude_scope
from porelang.source import Source
from porelang.syntax import habits
from porelang.units import ELSEWHERE, UNITS, WITHOUT, converted


def errors(text: str) -> list[Diagnostic]:
    return [d for d in try_compile(Source("a.pore", text))[1] if d.severity == "error"]


def edited(text: str, edit: Edit) -> str:
    return edit.apply(text)


def mended(text: str) -> tuple[str, list[Diagnostic]]:
    """The text after the edit of its first error that has one, and so on; and what is still wrong with it."""
    for _ in range(12):
        found = errors(text)
        edits = [d.edit for d in found if d.edit is not None]
        if not edits:
            return text, found
        text = edited(text, edits[0])
    raise AssertionError(text)


# What was written, and what it becomes by the edits that are shown.
WRITTEN = {
    # OpenSCAD: what is done to a solid stands before it
    "translate([1,2,3]) sphere(5)": "sphere(5) |> translate([1,2,3])",
    "translate([1,2,3]) sphere(5);": "sphere(5) |> translate([1,2,3])",
    "difference() { sphere(5); cube(3); }": "sphere(5) \\ cube(3)",
    "intersection() {\n  sphere(5);\n  cube(8);\n}\n": "sphere(5) & cube(8)\n",
    "rotate([0,0,45]) cube(10)": "cube(10) |> rotate([0, 0, 1], 45deg)",
    "rotate([10,0,45]) cube(10)": "cube(10) |> rotate([1, 0, 0], 10deg) |> rotate([0, 0, 1], 45deg)",
    "rotate(a=45, v=[0,1,0]) cube(3)": "cube(3) |> rotate([0,1,0], 45deg)",
    "mirror(v=[1,0,0]) cube(4)": "cube(4) |> mirror([1,0,0])",
    "let a = scale([1,2,3]) sphere(5)\na": "let a = sphere(5) |> scale([1,2,3])\na",
    "linear_extrude(height=10) circle(5)": "circle(5) |> extrude(10)",
    "rotate_extrude() translate([10,0,0]) circle(2)": "circle(2) |> translate([10,0,0]) |> revolve()",
    'color("red") sphere(5)': "sphere(5)",
    "for (i=[0:5]) translate([i*10,0,0]) sphere(4);": "union([for i in range(6): sphere(4) |> translate([i*10,0,0])])",
    "for (i = [0 : 60 : 300]) rotate([0, 0, i]) cube(2)": (
        "union([for i in range(0, 301, 60): cube(2) |> rotate([0, 0, 1], i * 1deg)])"
    ),
    "translate([1,2,3]) difference() { cube(9); cylinder(r=2, h=20, center=true); }": (
        "(cube(9) \\ cylinder(r=2, h=20)) |> translate([1,2,3])"
    ),
    "module pin(r, h) {\n  cylinder(r, h);\n  translate([0,0,h]) sphere(r);\n}\npin(1, 5)": (
        "def pin(r, h) = cylinder(r, h) | sphere(r) |> translate([0,0,h])\npin(1, 5)"
    ),
    # its arguments
    "$fn = 64;\nsphere(5);": "\nsphere(5)",
    "sphere(r=5, $fn=100)": "sphere(r=5)",
    "cube(size=[10,20,30], center=true)": "box(s=[10,20,30])",
    "cube([10,20,30])": "box([10,20,30])",
    "cylinder(h=10, r1=5, r2=3)": "cone(h=10, r1=5, r2=3)",
    "cylinder(h=10, d=5)": "cylinder(h=10, r=5 / 2)",
    "cylinder(center=true, r=5, h=10)": "cylinder( r=5, h=10)",
    "sphere(radius=10)": "sphere(r=10)",
    "torus(major=10, minor=3)": "torus(R=10, r=3)",
    "gyroid(period=10) & sphere(4)": "gyroid(w=10) & sphere(4)",
    "shell(sphere(5), thickness=1)": "shell(sphere(5), t=1)",
    "ring(sphere(2), count=6)": "ring(sphere(2), n=6)",
    "box([1,2,3], radius=0.2)": "box([1,2,3], round=0.2)",
    # the items of a list and the components of a vector one by one
    "union(sphere(5), cube(3))": "union([sphere(5), cube(3)])",
    "box(1, 2, 3)": "box([1, 2, 3])",
    "translate(sphere(5), 1, 2, 3)": "translate(sphere(5), [1, 2, 3])",
    "polyline([0,0,0], [1,1,1], 2)": "polyline([[0,0,0], [1,1,1]], 2)",
    "box(10)": "cube(10)",
    'sphere("10")': "sphere(10)",
    # GLSL, C
    "smin(sphere(5), cube(3), 2)": "smooth_union(sphere(5), cube(3), 2)",
    "vec3 q = vec3(1,2,3);\nsphere(length(q));": "let q = [1,2,3]\nsphere(length(q))",
    "float d = 5;\nsphere(d);\n": "let d = 5\nsphere(d)\n",
    "// a comment\nsphere(5) // another": "# a comment\nsphere(5) # another",
    "/* a header\n * of two lines\n */\nsphere(5)": "# a header\n# of two lines\nsphere(5)",
    "sphere(/* radius */ 5)": "sphere( 5)",
    "sphere(5) /* and no end\nx": "sphere(5) # and no end\n# x",
    "!sphere(5) & cube(4)": "~sphere(5) & cube(4)",
    "sphere(5) && cube(3)": "sphere(5) & cube(3)",
    # Python
    "import numpy as np\nsphere(2 + np.sin(1))": "\nsphere(2 + sin(1))",
    "let f = lambda a, b: a + b\nsphere(f(1, 2))": "let f = (a, b) => a + b\nsphere(f(1, 2))",
    "def f(r):\n    return r*2\nsphere(f(2))": "def f(r)=\n    r*2\nsphere(f(2))",
    "let a = 5 if 3 > 2 else 4\nsphere(a)": "let a = if 3 > 2 then 5 else 4\nsphere(a)",
    "if x > 0: sphere(5)\nelse: cube(4)": "if x > 0 then sphere(5)\nelse cube(4)",
    "let r = 2 ** 3\nsphere(r)": "let r = 2 ^ 3\nsphere(r)",
    "w = 10mm\ngyroid(w) & sphere(20)": "let w = 10mm\ngyroid(w) & sphere(20)",
    # Curv
    "sphere(5) >> translate([1,2,3])": "sphere(5) |> translate([1,2,3])",
    "sphere 5": "sphere(5)",
    # ranges, params, functions, outputs and checks of other shapes
    "param w in 5..10\nsphere(w)": "param w = 5 in 5..10\nsphere(w)",
    "param w = 5mm in [1mm, 9mm]\nsphere(w)": "param w = 5mm in 1mm..9mm\nsphere(w)",
    "param w = 5mm in 1mm-9mm\nsphere(w)": "param w = 5mm in 1mm..9mm\nsphere(w)",
    "param w = 5mm in 1mm to 9mm\nsphere(w)": "param w = 5mm in 1mm..9mm\nsphere(w)",
    "param w = 5 mm in 1 mm..9 mm\nsphere(w)": "param w = 5mm in 1mm..9mm\nsphere(w)",
    "param w = 5mm in 1mm..9mm, step 1mm\nsphere(w)": "param w = 5mm in 1mm..9mm step 1mm\nsphere(w)",
    "def f(a: length > 0) = a\nsphere(f(2))": "def f(a: length where a > 0) = a\nsphere(f(2))",
    "def f(float a) = a\nsphere(f(2))": "def f(a: number) = a\nsphere(f(2))",
    "output sphere(5)": "out part = sphere(5)",
    "out sphere(5)": "out part = sphere(5)",
    'check(5 > 3, "five")\nsphere(4)': 'check 5 > 3, "five"\nsphere(4)',
    "[sphere(5), cube(9)]": "union([sphere(5), cube(9)])",
    "slider w = 8 in 5..12\ngyroid(w) & cube(9)": "param w = 8 in 5..12\ngyroid(w) & cube(9)",
    # units of elsewhere, and units as names and functions
    "let a = 0.3/mm\nsphere(1 / a)": "let a = 0.3/1mm\nsphere(1 / a)",
    "sphere(5*mm)": "sphere(5*1mm)",
    "let k = 3N/m\nsphere(2)": "let k = 3N/1m\nsphere(2)",
    "let p0 = 5bar\nsphere(3mm * p0 / p0)": "let p0 = 0.5MPa\nsphere(3mm * p0 / p0)",
    "let p0 = 5 bar\nsphere(3mm * p0 / p0)": "let p0 = 0.5MPa\nsphere(3mm * p0 / p0)",
    "let p0 = 1000psi\nsphere(3mm * p0 / p0)": "let p0 = 6894.75729kPa\nsphere(3mm * p0 / p0)",
    "sphere(1ft)": "sphere(304.8mm)",
    "let v = 2L\nsphere(v / 1mm^2)": "let v = (2000000 * 1mm^3)\nsphere(v / 1mm^2)",
    "let v = 3 ml\nsphere(v / 1mm^2)": "let v = (3000 * 1mm^3)\nsphere(v / 1mm^2)",
    "let s = 5N/mm2\nsphere(3mm * s / s)": "let s = 5N/1mm^2\nsphere(3mm * s / s)",
    "let rho = 2.7 g/cm^3\nsphere(rho)": "let rho = 2.7\nsphere(rho)",
    "let rho = 7.85g/cm^3\nsphere(rho)": "let rho = 7.85\nsphere(rho)",
    "rotate(cube(3), [0,0,1], deg(30))": "rotate(cube(3), [0,0,1], 30deg)",
    "let a = 30\nrotate(cube(3), [0,0,1], deg(a))": "let a = 30\nrotate(cube(3), [0,0,1], (a * 1deg))",
    "sphere(mm(5))": "sphere(5mm)",
    "sphere(2 in)": "sphere(2in)",
    # axes and decimals as they are written elsewhere
    'rotate(cube(3), "z", 45deg)': "rotate(cube(3), [0, 0, 1], 45deg)",
    'rotate(cube(3), axis="-X", angle=45deg)': "rotate(cube(3), axis=[-1, 0, 0], angle=45deg)",
    "rotate(cube(3), z, 45deg)": "rotate(cube(3), [0, 0, 1], 45deg)",
    "torus(9,65, 1,2)": "torus(9.65, 1.2)",
    # percent
    "shell(gyroid(5), shell_to_porosity(gyroid(5), 70, cube(9))) & cube(9)": (
        "shell(gyroid(5), shell_to_porosity(gyroid(5), 70%, cube(9))) & cube(9)"
    ),
    'param phi = 70 in 50..85 step 5 "open"\ngyroid(5) + to_porosity(gyroid(5), phi, cube(9)) & cube(9)': (
        'param phi = 70% in 50%..85% step 5% "open"\ngyroid(5) + to_porosity(gyroid(5), phi, cube(9)) & cube(9)'
    ),
    # words that are called
    "polar_array(sphere(2), 6)": "ring(sphere(2), 6)",
    "strut([0,0,0], [1,2,3], 2)": "capsule([0,0,0], [1,2,3], 2)",
    # joints and calls
    "sphere(5) and cube(8)": "sphere(5) & cube(8)",
    "sphere(5) union cube(8)": "sphere(5) | cube(8)",
    "{ let a = 5 sphere(a) }": "{ let a = 5; sphere(a) }",
    "sphere(r:5)": "sphere(r=5)",
    "sphere(5,5mm)": "sphere(5.5mm)",
    "box(1,2,3)": "box([1,2,3])",
    "sum(12,3) + x": "sum([12,3]) + x",
    "sphere(5]": "sphere(5)",
    "sphere(5])": "sphere(5)",
    "union([sphere(5)) & cube(8)": "union([sphere(5)]) & cube(8)",
    "sphere(1'000)": "sphere(1000)",
    "sphere(5).translate([1,2,3])": "sphere(5) |> translate([1,2,3])",
    "translate([1,2,3], sphere(5))": "translate(sphere(5), [1,2,3])",
    "scale([1,2,3], sphere(5))": "scale(sphere(5), [1,2,3])",
    "rotate([0,0,1], 45deg, sphere(5))": "rotate(sphere(5), [0,0,1], 45deg)",
    "rotate(45deg, sphere(5), [0,0,1])": "rotate(sphere(5), [0,0,1], 45deg)",
    "sphere(5) |> rotate(45deg, [0,0,1])": "sphere(5) |> rotate([0,0,1], 45deg)",
    # conditions for solids, ranges for comparisons, lists of lists
    "let dome = sphere(9) & z > 2mm\nout part = dome \\ sphere(3)": (
        "let dome = sphere(9) & (2mm - z)\nout part = dome \\ sphere(3)"
    ),
    "let c = z + 1 <= x * 2 & sphere(9)\nc |> translate([1,2,3])": (
        "let c = ((z + 1) - x * 2) & sphere(9)\nc |> translate([1,2,3])"
    ),
    "let dome = sphere(9) & z > 2mm\nunion([dome, sphere(3)])": (
        "let dome = sphere(9) & (2mm - z)\nunion([dome, sphere(3)])"
    ),
    "let dome = sphere(9) & z > 0\n~dome & cube(9)": "let dome = sphere(9) & (-z)\n~dome & cube(9)",
    "let dome = z < 0mm & sphere(9)\nsphere(9 * porosity(dome, cube(20)))": (
        "let dome = (z) & sphere(9)\nsphere(9 * porosity(dome, cube(20)))"
    ),
    "union([for i in range(3): for j in range(4): sphere(i + j + 1)])": (
        "union([for i in range(3) for j in range(4): sphere(i + j + 1)])"
    ),
    'let a = 40%\ncheck a in 30%..60%, "x"\nsphere(3)': ('let a = 40%\ncheck a >= 30% and a <= 60%, "x"\nsphere(3)'),
    "sphere(if 2 + 1 in 2..4 then 3 else 4)": "sphere(if 2 + 1 >= 2 and 2 + 1 <= 4 then 3 else 4)",
    "(hypot(x, y) - 5mm) \\ (abs(atan2(y, x)) - 30deg)": "(hypot(x, y) - 5mm) \\ bare(abs(atan2(y, x)) - 30deg)",
    "let turn = atan2(y, x)\nturn | x - 5mm": "let turn = atan2(y, x)\nbare(turn) | x - 5mm",
    "union([sphere(5) cube(8)])": "union([sphere(5), cube(8)])",
    # signs
    "sphere(-5)": "sphere(5)",
    "load(a.npz, vm)": 'load("a.npz", "vm")',
}


@pytest.mark.parametrize("text", WRITTEN)
def test_the_edit_that_is_shown_mends_the_program(text: str) -> None:
    assert errors(text)
    became, left = mended(text)
    assert became == WRITTEN[text]
    assert not left


# What was written, the code, and what the hint or message has to say of it.
TOLD = {
    "hull() { sphere(5); cube(3); }": ("E038", "smooth_union"),
    "hull(sphere(5), cube(3))": ("E037", "smooth_union"),
    "difference(sphere(5), cube(3))": ("E037", "`a \\ b`"),
    "gyroid.w = 3\nsphere(5)": ("E019", "`gyroid(w=...)`"),
    "rotate(cube(10), [0,0,45])": ("E043", "rotate(f, [0, 0, 1], 45deg)"),
    "scale(sphere(5), -1)": ("E064", "`mirror(f, [1, 0, 0])`"),
    'import "a.stl"\nsphere(5)': ("E046", "a mesh is read by"),
    'use "a.stl" as a\na': ("E046", "a mesh is read by"),
    'use "a.stl"\nsphere(5)': ("E046", "a mesh is read by"),
    'import("a.stl")': ("E037", "a mesh is read by"),
    'use "a.npz" as a\na': ("E046", '`load("a.npz", "name")`'),
    'let a = "x" + "y"\nsphere(5)': ("E060", "texts"),
    "echo(5) + sphere(4)": ("E037", "pore eval"),
    "while true { }": ("E037", "no loops"),
    "sphere(640mm^3)": ("E039", "`(640mm)^3`"),
    "let a, b = 1, 2\nsphere(5)": ("E012", "so for each"),
    "let (a, b) = [1, 2]\nsphere(5)": ("E009", "`q[0]`"),
    "solve(5, 3, 0..1)": ("E060", "`t => ...`"),
    "sphere(1,000)": ("E040", "`1000`"),
    "x = 3\nsphere(5)": ("E019", "choose another name"),
    'sphere("ten")': ("E060", "E060"),
    "fillet(cube(9), 2)": ("E037", "`round=2mm`"),
    "cube(9) |> chamfer(2)": ("E037", "`plane(normal, d)`"),
    "array(sphere(2), 5)": ("E037", "`repeat("),
    "tube(5, 4, 9)": ("E037", "`cylinder(R, h) \\ cylinder(r, h)`"),
    "bezier([0,0,0], [1,1,1])": ("E037", "`spline(points)`"),
    "bend(cube(9), 3)": ("E184", "`polar(f, turn)`"),
    "sphere(remap(x, 0, 9, 1, 2))": ("E037", "`mix(lo, hi, ramp(x, a, b))`"),
    "hexagon(5)": ("E037", "`regular_polygon(6, r)`"),
    'text("a", 5)': ("E037", "no letters"),
    "noise(5)": ("E037", "not there"),
    "trim(cube(5), sphere(2))": ("E037", "`a & b`"),
    "let rho = 2 / kg\nsphere(rho)": ("E030", "no unit of mass"),
    "let k = 2.7*g/1cm^3\nsphere(2)": ("E030", "no unit of mass"),
    "cylinder(5, 2*h)": ("E030", "bind it first"),
    "sphere(turn)": ("E030", "bind it first"),
    "sphere(3 * m)": ("E030", "as a unit it has a number, `1m`"),
    "ring(sphere(2), N)": ("E030", "bind it first"),
    "cube(9) & infill": ("E030", "bind it first"),
}


@pytest.mark.parametrize("text", TOLD)
def test_the_word_of_pore_is_told(text: str) -> None:
    code, said = TOLD[text]
    (found,) = errors(text)
    assert found.code == code
    assert said in found.hint


@pytest.mark.parametrize(
    "text",
    [
        "module foo(r) { hull() sphere(r); }\nfoo(5)",
        "function f(x) = x*2\nsphere(f(3))",
        "w = 10mm\ngyroid(w) & sphere(20)",
        "float d = 5\nsphere(d)",
        "import parts as q\nq.a & sphere(5)",
        "f(r) = 2*r\nsphere(f(3))",
        "var w := 5\nsphere(w)",
        "slider w = 8 in 5..12\ngyroid(w)",
        "number w = 8\ngyroid(w)",
    ],
)
def test_a_name_whose_statement_is_rejected_is_not_called_unknown(text: str) -> None:
    assert not {"E030", "E037"} & {d.code for d in errors(text)}


@pytest.mark.parametrize("text", ["let f = t => t\nsphere(f)", "let g = { let f = t => t; f }\nsphere(g)"])
def test_a_function_is_called_as_its_let_calls_it(text: str) -> None:
    (found,) = errors(text)
    assert "`f`" in found.message
    assert "lambda" not in render(found)


def test_a_function_without_a_name_is_called_as_it_is_written() -> None:
    (found,) = errors("sphere(t => 2 * t)")
    assert "`(t => 2 * t)`" in found.message


def test_the_contract_of_the_prelude_is_told_in_words_and_is_not_the_users_to_change() -> None:
    for text in (
        "scale(sphere(5), [1, -1, 1])",
        "box([1, -2, 3])",
        "plane([0, 0, 0])",
        "sphere(0)",
        "polyline([p], 1)",
    ):
        (found,) = errors(text)
        said = render(found)
        assert found.code == "E064"
        assert "min_component" not in said
        assert "dot(" not in said
        assert "or change the contract" not in said
    (found,) = errors("def f(a: length where a > 2) = sphere(a)\nf(1)")
    assert "or change the contract" in found.hint


def test_no_word_of_another_program_is_one_of_pore() -> None:
    known = prelude_scope().visible()
    assert not (habits.NAMES.keys() - PLANNED) & known
    assert {habits.ours(word) for word in habits.NAMES} - {""} <= known
    assert not habits.CALLED.keys() & (known | habits.NAMES.keys())
    assert {habits.ours(word, called=True) for word in habits.CALLED} - {""} <= known


#: What hints show, with the letters of their forms bound.
FORMS = [
    "mix(2, 3, ramp(x, 0, 9))",
    "cylinder(5, 9) \\ cylinder(4, 9)",
    "blend(extrude(circle(5), 9), extrude(rect(5, 6), 9), z, 3)",
    "(sphere(5) @ [x / (2 + z / 9), y / (2 + z / 9), z])",
    "octahedron(5) & plane([0, 0, -1])",
    "polar(box([9, 9, 9]), 40)",
    "prism(6, 3, 9)",
    "repeat(sphere(2), 9, counts=[4, 4, 1])",
    "sphere(9) - ramp(length(p - [10, 0, 0]), 0, 20)",
    'shell(sphere(9), 1mm, side="inside")',
]


@pytest.mark.parametrize("text", FORMS)
def test_the_forms_that_hints_show_are_programs(text: str) -> None:
    assert not errors(text)


def test_what_one_param_breaks_is_told_once_where_it_is() -> None:
    (found,) = errors("param wall = 2mm in 1mm..20mm\ncylinder(10mm - wall, 20mm)")
    assert found.code == "E086"
    assert found.span is not None
    assert found.span.text == "10mm - wall"


def test_a_param_that_is_wrong_itself_is_known_to_presets() -> None:
    text = 'param w = 4mm in 5mm..10mm\npreset "coarse": cell = 9mm\npreset "fine": w = 3mm\ngyroid(w) & cube(20)'
    found = errors(text)
    assert [d.code for d in found] == ["E080", "E087", "E085"]
    assert found[1].hint == "the params are w"


def test_a_setting_in_numbers_of_percent_is_told_how_it_is_written() -> None:
    program = porelang.compile("param a = 60% in 10%..90%\nsphere(5 * a)")
    with pytest.raises(porelang.PoreError, match="write `70%`"):
        program.design(a=70)
    with pytest.raises(porelang.PoreError, match="choose from 10% to 90%"):
        program.design(a=95)


def test_conversions_are_those_of_the_units() -> None:
    """By their definitions: a foot is 12 in, a litre 1 dm3, a bar 1e5 Pa; 1 psi is 6894.757 Pa (NIST SP 811)."""
    assert converted(1, "ft") == f"{12 * 25.4:g}mm"
    assert converted(1, "km") == "1000m"
    assert converted(1, "bar") == "0.1MPa"
    assert converted(1, "psi") == "6.89475729kPa"
    assert converted(1, "mm2") == "1mm^2"
    assert not (ELSEWHERE.keys() | WITHOUT.keys()) & UNITS.keys()
    for unit in ELSEWHERE:
        assert not errors(f"let a = {converted(2, unit)}\nsphere(if a > a then 1 else 2)")


def test_a_habit_is_told_once_with_how_often_it_was_seen() -> None:
    found = errors("".join(f"let a{i} = {i};  // the {i}th\n" for i in range(70)) + "sphere(b)")
    assert [d.code for d in found] == ["E020", "E001", "E030"]
    assert "and in 68 more places" in found[0].others[0].text


@pytest.mark.parametrize("space", "\u00a0\u1680\u2000\u2003\u2007\u2009\u200a\u202f\u205f\u3000")
def test_every_space_is_a_space(space: str) -> None:
    assert not errors(f"{space}gyroid(10){space}&{space}sphere(5){space}")
    assert mended(f"let a = 10{space}mm\nsphere(a)") == ("let a = 10mm\nsphere(a)", [])
    assert "\ufffd" not in render(errors(f"let a = 10{space}mm\nsphere(a)")[0])


@pytest.mark.parametrize("hidden", "\u200b\u200c\u200d\u200e\u2060\u00ad\u202a\u2066")
def test_a_character_that_is_not_seen_is_pointed_at(hidden: str) -> None:
    (found,) = errors(f"gy{hidden}roid(10) & sphere(5)")
    assert f"U+{ord(hidden):04X}" in found.message
    assert mended(f"gy{hidden}roid(10) & sphere(5)") == ("gyroid(10) & sphere(5)", [])


@pytest.mark.parametrize("dash", "\u2010\u2011\u2012\u2013\u2014\u2015\u2212\uff0d\ufe63")
def test_a_dash_is_a_minus(dash: str) -> None:
    assert mended(f"sphere(5) {dash} 2") == ("sphere(5) - 2", [])


@pytest.mark.parametrize(
    "marks", ["\u201c\u201d", "\u201e\u201c", "\u00ab\u00bb", "\u2018\u2019", "\u2039\u203a", "``"]
)
def test_a_quotation_mark_is_a_straight_one(marks: str) -> None:
    assert mended(f'load({marks[0]}a.npz{marks[1]}, "b")') == ('load("a.npz", "b")', [])


def test_letters_beyond_ascii_are_spelt_in_it() -> None:
    assert mended("let w\u00e4nde = 3\nsphere(w\u00e4nde)") == ("let wande = 3\nsphere(wande)", [])
    assert mended("let \u03b1 = 3\nsphere(\u03b1)") == ("let alpha = 3\nsphere(alpha)", [])
    assert mended("sphere(\uff15\uff09") == ("sphere(5)", [])
    assert mended("sphere(\u00bd)") == ("sphere(0.5)", [])
    assert mended("let r = 3\u2075\nsphere(r)") == ("let r = 3^5\nsphere(r)", [])


@pytest.mark.parametrize("end", ["\r", "\r\n", "\n"])
def test_every_line_end_is_one(end: str) -> None:
    assert not errors(f"# a sphere{end}let r = 5{end}sphere(r){end}")
    (found,) = errors(f"let r = 5{end}sphere(q){end}")
    assert found.span is not None
    assert (found.span.line, found.span.column) == (2, 8)


def test_line_ends_of_unicode_are_told() -> None:
    assert mended("let r = 5\u2028sphere(r)") == ("let r = 5\nsphere(r)", [])
