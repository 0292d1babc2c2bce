"""E060-E079: kinds of values, units, stages, and the size of a program."""

from __future__ import annotations

from porelang.error_codes.page import Code

KINDS = (
    Code(
        "E060",
        "a value of the wrong kind",
        "Operators and functions take certain kinds: numbers (fields are numbers), vectors, conditions, texts, lists\n"
        "or functions. Solids are joined with `&`, `|` and `~`, conditions with `and`, `or` and `not`. A lattice is a\n"
        "function until it is called: `gyroid(30)`.",
        "gyroid & sphere(20)",
        "gyroid(30) & sphere(20)",
    ),
    Code(
        "E061",
        "something that has no meaning here",
        "Only functions are called; an empty list has no least element and a range of step 0 no end.",
        "let r = 10\nsphere(r(3))",
        "let r = 10\nsphere(r * 3)",
    ),
    Code(
        "E062",
        "units that do not fit",
        "A number with a unit is a length, an angle, a force or a stress, and what is computed from it knows what it\n"
        "is. Two that are known and different are not added, compared, or handed over for one another. A bare number\n"
        "fits anywhere (in mm, rad, N, MPa), and so do coordinates, shapes and lattices.",
        "cylinder(75mm, 30deg)",
        "cylinder(75mm, 30mm)",
    ),
    Code(
        "E063",
        "a value that is not known in time",
        "A few places need a number when the program is compiled: how often something is repeated, an index, a filter\n"
        "of a list, the range of a param. A field is known only at a point, a number found from fields only later. A\n"
        "param may count if its default, its ends and its step are whole numbers without a unit: the program is then\n"
        "compiled for each value of it that is used.",
        "param n = 2.5 in 1..6\nunion([for i in range(n): translate(sphere(5), [10 * i, 0, 0])])",
        "param n = 3 in 1..6\nunion([for i in range(n): translate(sphere(5), [10 * i, 0, 0])])",
    ),
    Code(
        "E064",
        "a contract that is broken",
        "A def can say what its parameters must keep to: `sphere(r: length where r > 0)`. For constants that is\n"
        "checked when the program is compiled, for params over their whole range (E086), for fields through their\n"
        "bounds (W201).",
        "shell(sphere(10), -2)",
        "shell(sphere(10), 2)",
    ),
    Code(
        "E065",
        "an index out of reach",
        "The items of a list, and the components of a vector, are numbered from 0.",
        "let q = [1, 2, 3]\nsphere(q[3])",
        "let q = [1, 2, 3]\nsphere(q[2])",
    ),
    Code(
        "E066",
        "an output that is no field",
        "The result of a program is a number that varies in space, negative inside the solid (or a vector, or a\n"
        "condition). A list of solids is joined with `union`; a function is called.",
        "out parts = [sphere(5), sphere(10)]",
        "out parts = union([sphere(5), sphere(10)])",
    ),
    Code(
        "E067",
        "a check that varies in space",
        "A `check` is a design rule over numbers: constants and params. A condition on a field is true at some points\n"
        "and false at others.",
        'check sphere(10) > 0, "outside"\nsphere(10)',
        'param r = 10mm in 1mm..50mm\ncheck r > 2mm, "too small to print"\nsphere(r)',
    ),
    Code(
        "E068",
        "a check that does not hold",
        "The program's own rule, written with `check`, is broken by the settings in use. The message is the author's.",
        'param t = 1mm in 0.5mm..5mm\ncheck t >= 2mm, "walls under 2 mm do not print"\nshell(sphere(20), t)',
        'param t = 2mm in 0.5mm..5mm\ncheck t >= 2mm, "walls under 2 mm do not print"\nshell(sphere(20), t)',
    ),
    Code(
        "E069",
        "a constant that is no number",
        "An operation on constants gives an infinity, or something that is not a number at all, such as the root of a\n"
        "negative number. In a field that happens at some points only; here it would happen at all of them.",
        "sphere(sqrt(-4))",
        "sphere(sqrt(4))",
    ),
    Code(
        "E070",
        "a program that is too big",
        "Calls of calls, and lists of lists, can multiply a short text into millions of operations. That is an\n"
        "accident rather than a design, and it is stopped. What repeats in space is written with `repeat` or `ring`,\n"
        "which cost the same for a thousand copies as for one.",
        "union([for i in range(2000) for j in range(2000): translate(sphere(1), [4 * i, 4 * j, 0])])",
        "repeat(sphere(1), 4, counts=[2000, 2000, 1])",
    ),
    Code(
        "E071",
        "a range that is too long",
        "A list has at most 100 000 items. What repeats in space is written with `repeat`.",
        "union([for i in range(1000000000): translate(sphere(1), [4 * i, 0, 0])])",
        "repeat(sphere(1), 4, counts=[1000, 1, 1])",
    ),
    Code(
        "E072",
        "calls that are nested too deeply",
        "A function that is handed to itself never ends: that is recursion by another way.",
        "let again = f => f(f)\nagain(again)",
        "let again = f => f(f(5))\nsphere(again(t => t + 1))",
    ),
)
