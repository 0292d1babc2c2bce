"""E001-E029: how a program is written."""

from __future__ import annotations

from porelang.error_codes.page import Code

SYNTAX = (
    Code(
        "E001",
        "a sign that is not Pore's",
        "A character, or a pair of them, has no meaning here: a sign of another language (`&&`, `**`,\n"
        "`//`, `->`), a typographic one that looks like Pore's (a long minus, a times sign), or a\n"
        "character that was not meant for people at all. A power is `^`, a comment starts with `#`, a\n"
        "function is written with `=>`; conditions are joined by `and`, `or`, `not`, and solids by `&`,\n"
        "`|`, `~`. Names are made of a-z, A-Z, 0-9 and _.",
        "let a = x ** 2",
        "let a = x ^ 2",
    ),
    Code(
        "E002",
        "not a unit",
        "Letters that touch a number are its unit: um mm cm m in deg rad turn N kN Pa kPa MPa GPa %. A\n"
        "product is written with `*`, and no space stands between a number and its unit.",
        "let w = 30mmm",
        "let w = 30mm",
    ),
    Code(
        "E003",
        "a number that is too large",
        "Numbers are held in double precision; the largest is about 1.8e308, in base units (mm, rad, N,\nMPa).",
        "let w = 1e999",
        "let w = 1e99",
    ),
    Code(
        "E004",
        "a text that does not read",
        'A text stands in straight double quotes and ends on the line where it starts. In it `\\"` is a\n'
        "quote, `\\\\` a backslash and `\\n` a line end; there are no other escapes, and no control\n"
        "characters.",
        'use "plates.pore as plates',
        'use "plates.pore" as plates',
    ),
    Code(
        "E005",
        "a bracket that is never closed",
        "Each `(`, `[` and `{` needs its `)`, `]` or `}`. The place that is shown is where the bracket\n"
        "was opened; reading goes on at the next line that begins, in its first column, with a statement.",
        "let a = sphere(3",
        "let a = sphere(3)",
    ),
    Code(
        "E006",
        "a bracket that closes nothing, or another one",
        "A closing bracket must close the one that was opened last. Either one is too many, or one is\n"
        "missing before it.",
        "let a = [1, 2)",
        "let a = [1, 2]",
    ),
    Code(
        "E007",
        "a value is missing",
        "After an operator, `=`, a comma or an opening bracket a value is expected, and something else\n"
        "was found. `not` and `if` after an operator, and `-` after `@`, stand in parentheses: `f @\n"
        "(-p)`.",
        "let a = 3 +",
        "let a = 3 + 4",
    ),
    Code(
        "E008",
        "an operator or a comma is missing",
        "Two values stand side by side. There is no silent product: write `2*x`. Inside brackets a comma\n"
        "may be what is missing. A `(` or `[` at the start of a line begins a new value and does not go\n"
        "on with the one before. A word of another language (`var`, `function`, `return`, `elif`) reads\n"
        "like this too.",
        "let a = tau x",
        "let a = tau*x",
    ),
    Code(
        "E009",
        "a name is missing",
        "After `let`, `def`, `out`, `param` and `.` stands a name: letters a-z, digits and _, not\n"
        "starting with a digit.",
        "let = 3",
        "let a = 3",
    ),
    Code(
        "E010",
        "a word of the language as a name",
        "These words are taken: use param let def out check if then else for in where and or not true\n"
        "false. (`as`, `step` and `preset` are words only in their places, and names\n"
        "elsewhere.)",
        "let in = 3",
        "let inside = 3",
    ),
    Code(
        "E011",
        "`=` and `==` confused",
        "`=` gives a name, an argument or a parameter its value; `==` compares two values.",
        "let a = if x = 0 then 1 else 2",
        "let a = if x == 0 then 1 else 2",
    ),
    Code(
        "E012",
        "`=` is missing",
        "A statement that gives a name its value has `=` between the two, also before the block of a\n`def`.",
        "def double(a) { 2*a }",
        "def double(a) = { 2*a }",
    ),
    Code(
        "E013",
        "a range that does not read",
        "A param says where it may lie: `in lo..hi`, with two dots, then `step s` if it moves in steps;\n"
        "or `in {a, b, c}` for a choice. A value that never changes is a `let`. Besides, a range stands\n"
        "only as an argument of a call: `solve(t => t^2, 3, 0..10)`.",
        "param w = 30mm",
        "param w = 30mm in 10mm..60mm",
    ),
    Code(
        "E014",
        "an incomplete `if`",
        "A choice is an expression and always has a value: `if c then a else b`, with both words.",
        "let a = if x > 0 then 1",
        "let a = if x > 0 then 1 else 0",
    ),
    Code(
        "E015",
        "comparisons in a chain",
        "A comparison is true or false, and that is not compared further. Write the middle twice and join\nby `and`.",
        "let a = if 0 < x < 1 then 1 else 0",
        "let a = if 0 < x and x < 1 then 1 else 0",
    ),
    Code(
        "E016",
        "not a function right of `|>`",
        "`a |> f(b)` is `f(a, b)`; what stands right of `|>` is a call or a name. `+ - * /` bind tighter\n"
        "than `|>`, so a sum with its result needs parentheses.",
        "let a = sphere(3) |> offset(1) + 2",
        "let a = (sphere(3) |> offset(1)) + 2",
    ),
    Code(
        "E017",
        "a function, or parentheses, that do not read",
        "A function is `t => expr` or `(a, b) => expr`, with names on its left; among operators it stands\n"
        "in parentheses. Several values in parentheses mean nothing else: a vector or a list is written\n"
        "in `[ ]`.",
        "let a = (1, 2, 3)",
        "let a = [1, 2, 3]",
    ),
    Code(
        "E018",
        "a value that is not used",
        "An expression without a name is the part that a file describes, and must be its last statement.\n"
        "A line that starts with `-`, `~`, `(` or `[` starts anew: to go on, end the line before with the\n"
        "operator.",
        "sphere(3)\n- box([1, 1, 1])",
        "sphere(3) \\\n  box([1, 1, 1])",
    ),
    Code(
        "E019",
        "a name is given a value without `let`",
        "A value gets its name by `let`, a function by `def`, once for ever: nothing is assigned again\nlater.",
        "w = 30",
        "let w = 30",
    ),
    Code(
        "E020",
        "statements on one line",
        "A line end ends a statement, and no `;` is needed. (Inside a block `{ let k = 2; k }` it\nseparates.)",
        "let a = 1; let b = 2",
        "let a = 1\nlet b = 2",
    ),
    Code(
        "E021",
        "commas and arguments",
        "Commas stand in calls, lists and parameters. The arguments of a call come by position first,\n"
        "then by name. An index is one number.",
        "let a = torus(R=60, 20)",
        "let a = torus(60, r=20)",
    ),
    Code(
        "E022",
        "a `use` that does not read",
        "Another file is used by its path, in quotes and relative to this one, and gets a name.",
        'use "plates.pore"',
        'use "plates.pore" as plates',
    ),
    Code(
        "E023",
        "a `check` that does not read",
        "A design rule has a condition and a message in quotes, for the person who breaks it.",
        "check tau > 6",
        'check tau > 6, "a turn has become too small"',
    ),
    Code(
        "E024",
        "a `def` that does not read",
        "A function is `def f(a, b) = expr`. A parameter is a name, with a kind, a contract and a default\n"
        "if need be: `b: length where b > 0 = 2mm`. Of two, `w or phase = p / w`, a caller gives one.",
        "let double(a) = 2*a",
        "def double(a) = 2*a",
    ),
    Code(
        "E025",
        "a block that does not read",
        "A block is `{ let k = 2; k*x }`: bindings by `let` and `def`, each on its line or with `;`\n"
        "between, and one value at the end.",
        "let a = { let k = 2 }",
        "let a = { let k = 2; k*x }",
    ),
    Code(
        "E026",
        "a `for` that does not read",
        "There are no loops. A list is made by `[for i in range(6): expr]`; several `for` follow one\nanother.",
        "let a = [2*i for i in range(6)]",
        "let a = [for i in range(6): 2*i]",
    ),
    Code(
        "E027",
        "nested too deeply",
        "Brackets may be nested 200 levels deep, and a statement's operators, functions and branches 800.\n"
        "Names for the inner parts make a program that is easier to read, too. (Long sums, chains of `|>`\n"
        "and `else if` are not deep.)",
        "",
        "let inner = sphere(3)\nlet outer = ~inner",
    ),
    Code(
        "E028",
        "a file that is too large",
        "A program may have a million characters. Definitions that several programs share belong in a file of\n"
        "their own, which `use` brings in.",
        "",
        'use "lattices.pore" as lattices\nlattices.skin & cylinder(75, 300)',
    ),
    Code(
        "E029",
        "something does not fit",
        "What was found cannot stand at this place, though it may elsewhere.",
        "let a = 3 in x",
        "param a = 3 in 1..5",
    ),
)
