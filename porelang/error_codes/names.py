"""E030-E059: what names stand for, and how functions are called."""

from __future__ import annotations

from porelang.error_codes.page import Code

NAMES = (
    Code(
        "E030",
        "a name that stands for nothing",
        "Every name is bound in the file (`param`, `let`, `def`, `use`), is a parameter of the def around it, or\n"
        "comes from the language itself. Statements may stand in any order, so a name may be used above its `let`.",
        "gyrod(30) & sphere(20)",
        "gyroid(30) & sphere(20)",
    ),
    Code(
        "E031",
        "a name that is bound twice",
        "In a file a name means one thing: nothing is ever assigned anew. The same holds for the parameters of a def\n"
        "and the outputs of a program. A file's own name may be one of the language's; then the file's wins.",
        "let r = 10\nlet r = 12\nsphere(r)",
        "let r = 10\nlet larger = 12\nsphere(r) | translate(sphere(larger), [0, 0, 15])",
    ),
    Code(
        "E032",
        "a coordinate that is bound",
        "x, y and z are the coordinates of the point at which a field is evaluated and p is [x, y, z]; a file that\n"
        "bound them could not be read. A parameter of a def or of a `=>` may be called so.",
        "let x = 5\nsphere(x)",
        "let r = 5\nsphere(r)",
    ),
    Code(
        "E033",
        "a definition that needs itself",
        "There is no recursion: every program is a finite graph, which is why it can be compiled to a shader and\n"
        "bounded. What repeats a fixed number of times is a comprehension; what repeats in space is `repeat` or\n"
        "`ring`.",
        "def stack(n) = sphere(n) | stack(n - 1)\nstack(3)",
        "def stack(n) = union([for i in range(n): translate(sphere(i + 1), [0, 0, 3 * i])])\nstack(3)",
    ),
    Code(
        "E034",
        "a kind that does not exist",
        "A parameter can say what it takes: `r: length`, `f: field`, `v: vector`. The message lists the kinds.",
        "def plate(t: lenght) = abs(z) - t / 2\nplate(3) & sphere(20)",
        "def plate(t: length) = abs(z) - t / 2\nplate(3) & sphere(20)",
    ),
    Code(
        "E035",
        "a file that cannot be used here",
        "`use` brings in another file's lets and defs. Files cannot use each other in a ring, and a program that was\n"
        "compiled from a text in memory has no folder in which to look for files.",
        "",
        'use "plates.pore" as plates\nplates.grid(5) & sphere(20)',
    ),
    Code(
        "E036",
        "a member that does not exist",
        "A vector has x, y and z; a used file has its lets and defs; a collection of the language has what the\n"
        "message lists. Other values have no members.",
        "let q = [1, 2, 3]\nsphere(q.w)",
        "let q = [1, 2, 3]\nsphere(q.z)",
    ),
    Code(
        "E037",
        "a word of another program",
        "Some names of OpenSCAD, GLSL, NumPy, Curv and others stand for what Pore calls or writes otherwise:\n"
        "    difference(a, b)      a \\ b                   smin(a, b, r)     smooth_union(a, b, r)\n"
        "    union(a, b)           a | b                   vec3(a, b, c)     [a, b, c]\n"
        "    linear_extrude        extrude(profile, h)     np.sin(x)         sin(x)\n"
        "    rotate_extrude        revolve(profile)        a ? b : c         if a then b else c\n"
        "    hull                  capsule, smooth_union   print             pore eval, pore measure\n"
        "Shapes are centred on the origin, also `cube` and `cylinder`. Angles are in radians unless they have a unit:\n"
        "`45deg`.",
        "smin(sphere(5), cube(8), 2)",
        "smooth_union(sphere(5), cube(8), 2)",
    ),
    Code(
        "E038",
        "what is done to a solid stands before it",
        "OpenSCAD writes `translate([1, 2, 3]) sphere(5);`. In Pore a solid is a value: it comes first, and what is\n"
        "done to it follows by `|>`, or it is an argument, `translate(sphere(5), [1, 2, 3])`. Solids are joined by\n"
        "operators: `a | b` both, `a & b` what they share, `a \\ b` a without b; many at once by\n"
        "`union([for i in range(6): ...])`. The way out that the message shows keeps the numbers as they are:\n"
        "mind that `cube(10)` and `cylinder(h=10, r=2)` are centred on the origin here.",
        "difference() { sphere(5); translate([0, 0, 3]) cube(4); }",
        "sphere(5) \\ (cube(4) |> translate([0, 0, 3]))",
    ),
    Code(
        "E039",
        "a power of a number with a unit",
        "`640mm^3` reads as 640 mm3, and would be (640mm)^3, which is 409,600 times as much. Write which of\n"
        "them is meant: `640 * 1mm^3`, or `(640mm)^3`.",
        'param r = 5mm in 1mm..9mm\ncheck r^3 < 640mm^3, "too large"\nsphere(r)',
        'param r = 5mm in 1mm..9mm\ncheck r^3 < 640 * 1mm^3, "too large"\nsphere(r)',
    ),
    Code(
        "E040",
        "too many arguments",
        "A function takes as many arguments as it has parameters.",
        "sphere(10, 20)",
        "sphere(10)",
    ),
    Code(
        "E041",
        "an argument for a parameter that does not exist",
        "A named argument, `r=10`, goes to the parameter of that name.",
        "cylinder(radius=10, h=20)",
        "cylinder(r=10, h=20)",
    ),
    Code(
        "E042",
        "an argument that is given twice",
        "Positional arguments come first and fill the parameters from the left; a named one cannot go to a parameter\n"
        "that is filled already. In `a |> f(b)`, a is the first argument.",
        "cylinder(10, r=12)",
        "cylinder(10, h=12)",
    ),
    Code(
        "E043",
        "an argument that is missing",
        "Every parameter without a default needs an argument.",
        "cylinder(75)",
        "cylinder(75, 300)",
    ),
    Code(
        "E045",
        "two arguments of which one is enough",
        "Some functions take one thing in two forms: a lattice takes its period `w`, or in its place the `phase`,\n"
        "from which the period follows.",
        "gyroid(10, phase=p / 10) & sphere(20)",
        "gyroid(phase=p / 10) & sphere(20)",
    ),
    Code(
        "E046",
        "a file that is no program",
        '`use` brings in programs, files of Pore. Sampled fields come by `load("grid.npz", "name")`, bars by\n'
        '`frame("bars.json")`, meshes by `mesh("part.stl")`.',
        'use "part.stl" as part\npart & gyroid(10)',
        "",
    ),
)
