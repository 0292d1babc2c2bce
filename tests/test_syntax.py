"""The syntax: trees of everything that can be written, and that anything at all can be read without a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from porelang import cache, resources
from porelang.source import Source, Span
from porelang.syntax import parse as syntax
from porelang.syntax import tree
from porelang.syntax.builder import Builder
from porelang.syntax.parse import parse
from porelang.syntax.tables import unpack

FOLDER = Path(__file__).resolve().parent.parent


def read(text: str) -> tuple[tree.File, list[Any]]:
    return parse(Source("test.pore", text))


def statements(text: str) -> tuple[tree.Statement, ...]:
    """The statements of a text that must read."""
    file, diagnostics = read(text)
    assert not diagnostics, "\n".join(map(str, diagnostics))
    return file.statements


def show(node: Any) -> str:
    """An expression with all its brackets."""
    match node:
        case tree.Number():
            return f"{node.value:g}{node.unit}"
        case tree.Text():
            return repr(node.value)
        case tree.Boolean():
            return str(node.value).lower()
        case tree.Name():
            return node.name
        case tree.Member():
            return f"{show(node.target)}.{node.name}"
        case tree.Index():
            return f"{show(node.target)}[{show(node.index)}]"
        case tree.Call():
            given = (("" if a.name is None else a.name + "=") + show(a.value) for a in node.arguments)
            return f"{show(node.function)}({', '.join(given)})"
        case tree.Unary():
            return f"({node.op} {show(node.operand)})"
        case tree.Chain():
            return "(" + show(node.first) + "".join(f" {op} {show(b)}" for op, b in node.rest) + ")"
        case tree.If():
            branches = " ".join(f"if {show(c)} then {show(a)} else" for c, a in node.branches)
            return f"({branches} {show(node.otherwise)})"
        case tree.Lambda():
            return f"(({', '.join(p.name for p in node.parameters)}) => {show(node.body)})"
        case tree.List():
            return "[" + ", ".join(map(show, node.items)) + "]"
        case tree.Comprehension():
            clauses = (
                " ".join([f"for {c.name.name} in {show(c.items)}", *(f"if {show(f)}" for f in c.filters)])
                for c in node.clauses
            )
            return f"[{' '.join(clauses)}: {show(node.value)}]"
        case tree.Block():
            return "{" + "; ".join([*map(show, node.bindings), show(node.value)]) + "}"
        case tree.Let():
            return f"let {node.name} = {show(node.value)}"
        case tree.Def():
            return f"def {node.name}({', '.join(p.name for p in node.parameters)}) = {show(node.body)}"
    raise AssertionError(node)


def value(text: str) -> Any:
    (out,) = statements(text)
    assert isinstance(out, tree.Out)
    return out.value


# ---- expressions


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("f(1, r=2)", "f(1, r=2)"),
        ("f()", "f()"),
        ("f(1, 2,)", "f(1, 2)"),
        ("f(1)(2).x[3].y", "f(1)(2).x[3].y"),
        ("study.von_mises", "study.von_mises"),
        ("points[2]", "points[2]"),
        ("[a, b, c]", "[a, b, c]"),
        ("[a, b,]", "[a, b]"),
        ("[]", "[]"),
        ("t => t^2", "((t) => (t ^ 2))"),
        ("(a, b) => a + b", "((a, b) => (a + b))"),
        ("(a) => a", "((a) => a)"),
        ("a => b => a", "((a) => ((b) => a))"),
        ("solve(t => f(t), 3, 0..10)", "solve(((t) => f(t)), 3, (0 .. 10))"),
        ("f(at=lo..hi)", "f(at=(lo .. hi))"),
        ("if a then b else c", "(if a then b else c)"),
        ("if a then b else if c then d else e", "(if a then b else if c then d else e)"),
        ("if a then if b then c else d else e", "(if a then (if b then c else d) else e)"),
        (
            "if a then if b then c else if d then e else f else g",
            "(if a then (if b then c else if d then e else f) else g)",
        ),
        ("[for i in range(6): i*2]", "[for i in range(6): (i * 2)]"),
        ("[for i in range(3) for j in range(i): [i, j, 0]]", "[for i in range(3) for j in range(i): [i, j, 0]]"),
        ("{ let k = tau / w; cos(k*x) }", "{let k = (tau / w); cos((k * x))}"),
        ("{ let k = 1; def g(t) = t + k\n g(2) }", "{let k = 1; def g(t) = (t + k); g(2)}"),
        ("{ 3 }", "{3}"),
        ("{\n  let a = 1\n\n  let b = 2;\n  a\n}", "{let a = 1; let b = 2; a}"),
        ("f({ let a = 1\n a }, 2)", "f({let a = 1; a}, 2)"),
        ("a |> f(b) |> g", "(a |> f(b) |> g)"),
        ("a |> lib.grow(2) |> lib.g", "(a |> lib.grow(2) |> lib.g)"),
        ("a - b - c + d", "(a - b - c + d)"),
        ("a & b \\ c", "(a & b \\ c)"),
        ("2^3^2", "(2 ^ (3 ^ 2))"),
        ("-2^2", "(- (2 ^ 2))"),
        ("2^-1", "(2 ^ (- 1))"),
        ("f @ q @ r", "(f @ q @ r)"),
        ("f @ q ^ 2", "((f @ q) ^ 2)"),
        ("- -a", "(- (- a))"),
        ("a - -b", "(a - (- b))"),
        ("a*-b", "(a * (- b))"),
        ("~a & ~b", "((~ a) & (~ b))"),
        ("not not a", "(not (not a))"),
        ("not a == b", "(not (a == b))"),
        ("a and not b or c", "((a and (not b)) or c)"),
        ("(a + b) * c", "((a + b) * c)"),
        ("((a))", "a"),
        ("(f)(x)", "f(x)"),
        ("(a + b).x", "(a + b).x"),
        ("(if a then b else c) + 1", "((if a then b else c) + 1)"),
        ("true and false", "(true and false)"),
        ("as + step", "(as + step)"),
        ("step(0, x)", "step(0, x)"),
        ('f("a \\"b\\" \\\\ \\n")', "f('a \"b\" \\\\ \\n')"),
        ("gyroid(w) |> thicken(s, 0.3) & cylinder(75, 300)", "((gyroid(w) |> thicken(s, 0.3)) & cylinder(75, 300))"),
        ("[x*cos(r) - y, -z].x", "[((x * cos(r)) - y), (- z)].x"),
    ],
)
def test_expressions(text: str, shape: str) -> None:
    assert show(value(text)) == shape


# Section 2 of the language, loosest first; the operators of one line associate to the left.
LEVELS = [["or"], ["and"], ["=="], ["|"], ["&", "\\"], ["|>"], ["+", "-"], ["*", "/", "%"], ["^"], ["@"]]


@pytest.mark.parametrize("loose", range(len(LEVELS)))
@pytest.mark.parametrize("tight", range(len(LEVELS)))
def test_precedence(loose: int, tight: int) -> None:
    for a in LEVELS[loose]:
        for b in LEVELS[tight]:
            if loose < tight:
                # The operand right of `|>` must be a call or a name, so the tighter one is tried on its left.
                if a != "|>":
                    assert show(value(f"p {a} q {b} r")) == f"(p {a} (q {b} r))"
                assert show(value(f"p {b} q {a} r")) == f"((p {b} q) {a} r)"
            elif loose == tight and a not in ("^", "=="):
                assert show(value(f"p {a} q {b} r")) == f"(p {a} q {b} r)"


def test_unary_stands_between_power_and_product() -> None:
    assert show(value("-a ^ b")) == "(- (a ^ b))"
    assert show(value("-a * b")) == "((- a) * b)"
    assert show(value("-f @ q")) == "(- (f @ q))"
    assert show(value("not a < b and c")) == "((not (a < b)) and c)"


@pytest.mark.parametrize("op", ["<", "<=", ">", ">=", "==", "!="])
def test_comparisons(op: str) -> None:
    assert show(value(f"a + 1 {op} b | c")) == f"((a + 1) {op} (b | c))"


# ---- numbers


@pytest.mark.parametrize(
    ("text", "number", "unit"),
    [
        ("30", 30, ""),
        (".5", 0.5, ""),
        ("1.", 1, ""),
        ("1e-3", 1e-3, ""),
        ("2.5E+2mm", 250, "mm"),
        ("1in", 1, "in"),
        ("3m", 3, "m"),
        ("45%", 45, "%"),
        ("1.5%", 1.5, "%"),
        ("1.mm", 1, "mm"),
    ],
)
def test_numbers(text: str, number: float, unit: str) -> None:
    node = value(text)
    assert isinstance(node, tree.Number)
    assert (node.value, node.unit) == (number, unit)


@given(st.floats(min_value=0, allow_infinity=False, allow_nan=False), st.sampled_from(["", "mm", "deg", "kPa"]))
def test_a_number_reads_as_python_writes_it(number: float, unit: str) -> None:
    text = repr(number)
    if unit and number > 1e300:
        return
    node = value(text + unit)
    assert (node.value, node.unit) == (number, unit)


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("10%3", "(10 % 3)"),
        ("10 % 3", "(10 % 3)"),
        ("10 %3", "(10 % 3)"),
        ("10%x", "(10 % x)"),
        ("10%(x)", "(10 % x)"),
        ("10%[x]", "(10 % [x])"),
        ("10%.5", "(10 % 0.5)"),
        ("x % 3", "(x % 3)"),
        ("10% - 3", "(10% - 3)"),
        ("10%-3", "(10% - 3)"),
        ("f(10%, 3)", "f(10%, 3)"),
        ("a > 45% and b", "((a > 45%) and b)"),
    ],
)
def test_percent_or_remainder(text: str, shape: str) -> None:
    assert show(value(text)) == shape


# ---- statements


def test_the_program_of_the_first_page() -> None:
    text = (
        "# adaptive infill of a compression specimen (a complete program)\n"
        'param w = 30mm in 10mm..60mm            "unit cell"\n'
        "let specimen = cylinder(75, 300)\n"
        "let heat = (torus(60, 20) - sphere(40)) / 100\n"
        "gyroid(w) |> thicken(heat, 0.3) & specimen\n"
    )
    param, specimen, heat, part = statements(text)
    assert isinstance(param, tree.Param)
    assert (param.name, show(param.default), show(param.low), show(param.high)) == ("w", "30mm", "10mm", "60mm")
    assert (param.step, param.choices, param.doc) == (None, (), "unit cell")
    assert show(specimen) == "let specimen = cylinder(75, 300)"
    assert show(heat) == "let heat = ((torus(60, 20) - sphere(40)) / 100)"
    assert isinstance(part, tree.Out)
    assert part.name == "part"
    assert part.name_span.text == ""
    assert show(part.value) == "((gyroid(w) |> thicken(heat, 0.3)) & specimen)"


def test_use_out_and_check() -> None:
    use, out, check = statements(
        'use "lib/plates.pore" as plates\nout core = ~skin\ncheck porosity(solid, cyl) > 45%, "too dense"'
    )
    assert isinstance(use, tree.Use)
    assert (use.path.value, use.name, use.name_span.text) == ("lib/plates.pore", "plates", "plates")
    assert isinstance(out, tree.Out)
    assert (out.name, out.name_span.text, show(out.value)) == ("core", "core", "(~ skin)")
    assert isinstance(check, tree.Check)
    assert (show(check.condition), check.message) == ("(porosity(solid, cyl) > 45%)", "too dense")


def test_params() -> None:
    plain, stepped, choice = statements(
        'param a = 1 in 0..2\nparam step = 3 in 2..6 step 2 "as many"\nparam k = gyroid in {\n  gyroid,\n  diamond,\n}'
    )
    assert isinstance(plain, tree.Param)
    assert (plain.step, plain.doc) == (None, "")
    assert isinstance(stepped, tree.Param)
    assert (stepped.name, show(stepped.step), stepped.doc) == ("step", "2", "as many")
    assert isinstance(choice, tree.Param)
    assert ([show(c) for c in choice.choices], choice.low, choice.high) == (["gyroid", "diamond"], None, None)


def test_parameters_of_a_def() -> None:
    (d,) = statements(
        "def f(a, b: length | vector where b > 0 = 2mm, c = 1 where c < 2, w: period or phase: vector = p / w,) = a"
    )
    assert isinstance(d, tree.Def)
    a, b, c, w, phase = d.parameters
    assert (a.kinds, a.where, a.default, a.alternative) == ((), None, None, None)
    assert [k.name for k in b.kinds] == ["length", "vector"]
    assert (show(b.where), show(b.default), b.span.text) == (
        "(b > 0)",
        "2mm",
        "b: length | vector where b > 0 = 2mm",
    )
    assert (show(c.where), show(c.default)) == ("(c < 2)", "1")
    assert (w.alternative, w.default, [k.name for k in w.kinds]) == ("phase", None, ["period"])
    assert (phase.alternative, show(phase.default), phase.name_span.text) == (None, "(p / w)", "phase")


def test_a_contract_may_say_or() -> None:
    (d,) = statements("def f(a where a > 0 or a < -1 = 2) = a")
    assert isinstance(d, tree.Def)
    assert show(d.parameters[0].where) == "((a > 0) or (a < (- 1)))"


def test_documentation() -> None:
    a, b, c, d, e, f = statements(
        "## The first.\n##  indented, and with # in it\ndef a() = 1\n"
        "## far away\n\ndef b() = 1\n"
        "let x1 = 3 ## behind a statement\ndef c() = 1\n"
        "## of a param\nparam d = 1 in 0..2\n"
        '### a ruler\n## kept\n## two\nparam e = 1 in 0..2 "said"'
    )
    assert isinstance(a, tree.Def)
    assert a.doc == "The first.\n indented, and with # in it"
    assert isinstance(b, tree.Def)
    assert b.doc == ""
    assert isinstance(c, tree.Let)
    assert isinstance(d, tree.Def)
    assert d.doc == ""
    assert isinstance(e, tree.Param)
    assert e.doc == "of a param"
    assert isinstance(f, tree.Param)
    assert f.doc == "said"
    inner = value("{\n  ## Of the inner one.\n  def g(t) = t\n  g(1)\n}")
    assert inner.bindings[0].doc == "Of the inner one."


def test_spans_are_the_text_of_each_node() -> None:
    text = "let a = (f(x, r=2) + q.x) * [1mm, -b] |> g\n"
    (let,) = statements(text)
    assert isinstance(let, tree.Let)
    assert let.span.text == text.strip()
    pipe = let.value
    assert isinstance(pipe, tree.Chain)
    assert pipe.span.text == text.strip().removeprefix("let a = ")
    assert [s.text for s in pipe.op_spans] == ["|>"]
    product = pipe.first
    assert isinstance(product, tree.Chain)
    assert product.first.span.text == "(f(x, r=2) + q.x)"
    vector = product.rest[0][1]
    assert isinstance(vector, tree.List)
    assert [item.span.text for item in vector.items] == ["1mm", "-b"]
    assert vector.span.column == text.index("[") + 1


# ---- where a line ends a statement


@pytest.mark.parametrize(
    "text",
    [
        "let a = b +\n  c",
        "let a = b\n  + c",
        "let a = b -\n  c",
        "let a =\n  b + c",
        "let a = f(b,\n  c)",
        "let a = f(\n  b\n  , c\n)",
        "let a = [\n  b,\n  c,\n]",
        "let a = b\n  |> f(c)\n\n  # between\n  |> g\n  & d",
        "let a = b \\\n c",
        "let a = b\n\\ c",
        "let a = t =>\n  t",
        "let a = if b\n  then c\n  else d",
        "let a = if b then\n  c else\n  d",
        "let a = b and\n  c\n  or d",
        "param a = b in\n  1\n  ..\n  2",
        "let a = b <\n  c",
        "let a = ~\n  b",
        "let a = [for i in range(3):\n  i]",
        "let a = b\r\n  + c",
        "\ufefflet a = b\n  + c",
        "let a = (b\n  - c)",
        "let a = f(b\n  -c)",
        "def a(b,\n  c = 1,\n  d: length\n    where d > 0) = b",
        "\n\n  let a = b  # the end\n\n",
    ],
)
def test_one_statement_over_lines(text: str) -> None:
    assert len(statements(text)) == 1


@pytest.mark.parametrize(
    "text",
    ["-b", "(b)", "[b]", "~b", "b", "not b", "if b then c else d", "{ b }", "{\n let b = 1\n b }", ".5", "3"],
)
def test_these_start_anew(text: str) -> None:
    first, second = statements(f"let a = c\n{text}")
    assert isinstance(first, tree.Let)
    assert isinstance(second, tree.Out)
    assert show(first) == "let a = c"


def test_crlf_and_bom() -> None:
    text = "\ufefflet a = 1\r\nlet b = {\r\n  let c = 2\r\n  c\r\n}\r\na + b\r\n"
    assert [type(s).__name__ for s in statements(text)] == ["Let", "Let", "Out"]


def test_nothing_is_a_program() -> None:
    for text in ("", "\n\n", "# only a comment", "\ufeff", "## doc of nothing"):
        assert statements(text) == ()


# ---- a mistake costs its own statement


def codes(text: str) -> list[tuple[str, int]]:
    return [(d.code, d.span.line) for d in read(text)[1]]


def names(text: str) -> list[str]:
    return [getattr(s, "name", "") for s in read(text)[0].statements]


def test_each_bad_statement_is_reported_and_each_good_one_kept() -> None:
    text = "let a = 1 +\nlet b = 2\nlet = 3\nlet c = $\nlet d = 4)\nlet e = 5\nlet f = 2x\ne"
    assert codes(text) == [("E007", 1), ("E009", 3), ("E001", 4), ("E006", 5), ("E002", 7)]
    assert names(text) == ["b", "e", "part"]


def test_an_open_bracket_ends_at_the_next_statement() -> None:
    text = (
        "let a = f(1, [2, 3)\nlet b = g(\n  1,\n  2\nlet c = 3\nout d = (1\ndef e(x) = {\n  x\nlet f = 1\n\nlet g = 2"
    )
    assert codes(text) == [("E006", 1), ("E005", 2), ("E005", 6), ("E005", 7)]
    assert names(text) == ["c", "f", "g"]


def test_a_block_need_not_be_indented() -> None:
    text = "let a = {\nlet b = {\nlet c = 1\nc }\ndef g(t) = t\nb }\nlet d = 1"
    assert not read(text)[1]
    assert names(text) == ["a", "d"]


def test_an_open_text_costs_its_line() -> None:
    text = 'let a = f("abc)\nlet b = 1\ng("x)\nlet c = 2'
    assert codes(text) == [("E004", 1), ("E004", 3)]
    assert names(text) == ["b", "c"]


def test_the_diagnostics_come_in_order_and_not_without_end() -> None:
    found = codes("let = 1\n" * 1000)
    assert len(found) == 50
    assert found == sorted(found, key=lambda c: c[1])


# ---- limits


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("(", ")"),
        ("[", "]"),
        ("{", "}"),
        ("f(", ")"),
        ("-", ""),
        ("not ", ""),
        ("2^", ""),
        ("t => ", ""),
        ("if a then ", " else b"),
        ("", ".x"),
        ("", "(1)"),
        ("if a then b else (", ")"),
    ],
)
@pytest.mark.slow
def test_deep_nesting_is_a_diagnostic(before: str, after: str) -> None:
    n = 20_000
    assert [c for c, _ in codes("let a = " + before * n + "x" + after * n)] == ["E027"]
    assert not codes("let a = " + before * 100 + "x" + after * 100)


@pytest.mark.parametrize("text", ["(" * 100_000, ")" * 100_000, "[(" * 5_000, "if " * 10_000, "{\nlet a = 1\n" * 1_000])
@pytest.mark.slow
def test_unbalanced_depth_is_a_diagnostic(text: str) -> None:
    assert codes(text)


@pytest.mark.slow
def test_what_is_long_is_not_deep() -> None:
    n = 5_000
    assert len(value("1" + " + 1" * n).rest) == n
    assert len(value("a" + "\n |> f(1)" * n).rest) == n
    assert len(value("if a then 1 else " * n + "2").branches) == n
    assert len(value("[" + "1, " * n + "]").items) == n
    assert len(statements("".join(f"let a{i} = 1\n" for i in range(n)))) == n


def test_a_large_file_is_refused_at_once() -> None:
    assert [c for c, _ in codes("1" * 1_000_001)] == ["E028"]
    assert not codes("# " + "x" * 900_000)


@pytest.mark.parametrize(
    "text", ["\0", "let a = \0\0\x01", "\udc80\ud800", 'let a = "\udc80"', 'let a = "\0"', "\x7fELF\x01"]
)
def test_junk_is_a_diagnostic_that_prints(text: str) -> None:
    _, found = read(text)
    assert found
    for d in found:
        str(d).encode()
        assert "\0" not in str(d)


# ---- anything at all


def check_promises(text: str) -> None:
    file, found = read(text)
    assert len(found) <= 50
    for d in found:
        assert d.span is not None
        assert 0 <= d.span.start <= d.span.end <= len(text)
        assert str(d)
    for s in file.statements:
        assert s.span.end <= len(text)


@given(st.text(max_size=200))
@settings(max_examples=300, deadline=None)
@pytest.mark.slow
def test_any_text_is_read(text: str) -> None:
    check_promises(text)


WORDS = """
use param let def out check if then else for in where and or not true false as step a f 30 2.5mm 45% 3x .5 "text"
== != <= < => |> | & \\ + - * / % ^ ~ @ .. . : , ; ( ) [ ] { } = && ** ! ? $ # ## "
"""
SOUP = [*WORDS.split(), "\n", "\n", "\n  ", " "]


@given(st.lists(st.sampled_from(SOUP), max_size=40), st.sampled_from(["", " "]))
@settings(max_examples=600, deadline=None)
@pytest.mark.slow
def test_any_soup_of_words_is_read(soup: list[str], gap: str) -> None:
    check_promises(gap.join(soup))


@given(st.data())
@settings(max_examples=200, deadline=None)
@pytest.mark.slow
def test_a_program_with_a_word_changed_is_read(data: st.DataObject) -> None:
    text = (
        'param w = 30mm in 10mm..60mm step 1mm "cell"\nuse "a.pore" as b\n'
        "def f(a, b: length where b > 0 = 2mm, c or d = c / 2) = { let k = tau / a; if k > 1 then [k, b, c] else d }\n"
        'check f(1) > 45%, "message"\nout s = solve(t => t^2, 3, 0..10)\n[for i in range(3): i].x |> g(r=1) & ~f @ p\n'
    )
    at = data.draw(st.integers(0, len(text)))
    width = data.draw(st.integers(0, 6))
    check_promises(text[:at] + data.draw(st.sampled_from(SOUP)) + text[at + width :])


# ---- the parser itself


def test_the_grammar_is_strict() -> None:
    syntax.build(resources.read(syntax.GRAMMAR), strict=True)


def test_lark_is_imported_only_to_parse() -> None:
    code = "import sys, porelang.syntax.parse; sys.exit('lark' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=FOLDER, check=False).returncode == 0


def test_the_tables_in_the_package_are_those_of_the_grammar() -> None:
    """`make grammar` writes them. With another lark than they were made with, the parser is built at each start."""
    grammar = resources.read(syntax.GRAMMAR)
    assert unpack(grammar + " ") is None
    kept = unpack(grammar, transformer=Builder(), postlex=syntax.KeepAll())
    assert kept is not None
    made = syntax.build(grammar)
    words, same_words = (
        [(t.name, t.pattern.to_regexp(), sorted(t.pattern.flags), t.priority) for t in p.terminals]
        for p in (kept, made)
    )
    assert words == same_words
    assert sorted(map(str, kept.rules)) == sorted(map(str, made.rules))
    for text in ("param w = 3mm in 1mm..9mm step 1mm\n[for i in range(3): i].x |> g(r=1) & ~f @ p", "a + + b\n(", ""):
        trees = []
        for parser in (kept, made):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(syntax, "parser", lambda parser=parser: parser)
                file, found = read(text)
                trees.append((outline(file.statements), [(d.code, d.message, d.hint) for d in found]))
        assert trees[0] == trees[1]


def outline(node: Any) -> Any:
    """A tree as plain tuples, with the places of its nodes as numbers."""
    match node:
        case Span():
            return node.start, node.end
        case tuple():
            return tuple(map(outline, node))
        case _ if is_dataclass(node):
            return type(node).__name__, *(outline(getattr(node, f.name)) for f in fields(node))
    return node


def test_a_part_of_a_text_is_read_as_it_is_in_the_whole() -> None:
    source = Source("test.pore", "## one\nlet a = 1\n## two\ndef f(x) =\n  x + 1  # the end\n\nlet b = a )\n")
    whole, _ = parse(source)
    start, end = source.text.index("## two"), source.text.index("let b")
    part, found = parse(source, start, end)
    assert not found
    assert outline(part.statements) == outline(whole.statements[1:2])
    assert part.statements[0].doc == "two"
    _, (wrong,) = parse(source, end)
    assert wrong.span is not None
    assert (wrong.code, wrong.span.start) == ("E006", source.text.index(")", end))


def test_the_cache_is_a_convenience(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "deep" / "er"))
    assert cache.get("key") is None
    cache.put("key", b"one")
    cache.put("key", b"two")
    assert cache.get("key") == b"two"
    assert [f.name for f in (tmp_path / "deep" / "er").iterdir()] == ["key"]
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("PORELANG_CACHE", str(blocked))
    cache.put("key", b"three")
    assert cache.get("key") is None


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and modes of files")
def test_what_others_may_have_written_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path))
    cache.put("key", b"one")
    assert cache.get("key") == b"one"
    for mode in (0o620, 0o602):
        (tmp_path / "key").chmod(mode)
        assert cache.get("key") is None
    cache.put("key", b"two")  # which replaces it
    assert cache.get("key") == b"two"
    (tmp_path / "link").symlink_to(tmp_path / "key")
    os.mkfifo(tmp_path / "pipe")
    assert cache.get("link") is None
    assert cache.get("pipe") is None
    if os.geteuid() == 0:
        os.chown(tmp_path / "key", 12345, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert cache.get("key") is None


def test_the_cache_lies_where_the_user_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PORELANG_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache.folder() == Path("/somewhere/porelang")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", "/home/someone")
    assert cache.folder() == Path("/home/someone/.cache/porelang")
