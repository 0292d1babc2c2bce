"""Typical mistakes: the code, the place, the words and the edit that a user gets."""

from __future__ import annotations

import inspect
import re

import pytest

from porelang.diagnostics import Diagnostic
from porelang.error_codes import CODES
from porelang.source import Source
from porelang.syntax import builder, failure, foreign, mistakes, tokens
from porelang.syntax import parse as syntax
from porelang.syntax.parse import parse

# The program, the code, the text under the caret, words of the message or hint, and the program after the edit.
MISTAKES: list[tuple[str, str, str, str, str | None]] = [
    # signs
    ("let a = b && c", "E001", "&&", "`and`", "let a = b & c"),
    ("let a = b || c", "E001", "||", "`or`", "let a = b | c"),
    ("let a = b ** 2", "E001", "**", "`^`", "let a = b ^ 2"),
    ("let a = 3 // three", "E001", "//", "`#`", "let a = 3 # three"),
    ("let a = 3 /* three */", "E001", "/*", "`#`", None),
    ("let a = !b", "E001", "!", "`not`", "let a = not b"),
    ("let f = t -> t + 1", "E001", "->", "`=>`", "let f = t => t + 1"),
    ("let a := 3", "E001", ":=", "`=`", "let a = 3"),
    ("let a = b ? 1 : 2", "E001", "?", "if c then a else b", None),
    ("let a = 3 \u2212 2", "E001", "\u2212", "U+2212", "let a = 3 - 2"),
    ("let a = 3 \u00d7 2", "E001", "\u00d7", "`*`", "let a = 3 * 2"),
    ("let a = 30\u00b0", "E001", "\u00b0", "deg", "let a = 30deg"),
    ("let gr\u00f6sse = 3", "E001", "\u00f6", "a-z", None),
    ("let a = $b", "E001", "$", "not a sign", None),
    # numbers and texts
    ("let a = 30mmm", "E002", "mmm", "did you mean `30mm`", "let a = 30mm"),
    ("let a = 30MM", "E002", "MM", "did you mean `30mm`", "let a = 30mm"),
    ("let a = 3inch", "E002", "inch", "did you mean `3in`", "let a = 3in"),
    ("let a = 30px", "E002", "px", "the units are um, mm, cm", None),
    ("def a(px) = 30px", "E002", "px", "for a product", "def a(px) = 30*px"),
    ("let a = 2pi", "E002", "pi", "`2*pi`", "let a = 2*pi"),
    ("let a = 2x", "E002", "x", "`2*x`", "let a = 2*x"),
    ("let a = 30 mm", "E002", "mm", "`30mm`", "let a = 30mm"),
    ("let a = 1e999", "E003", "1e999", "too large", None),
    ("let a = 1e306m", "E003", "1e306m", "too large", None),
    ('use "a.pore as b', "E004", '"a.pore as b', "not closed", None),
    ("let a = \u201ctext\u201d", "E004", "\u201ctext\u201d", "straight double quotes", 'let a = "text"'),
    ("let a = 'text'", "E004", "'text'", "double quotes", 'let a = "text"'),
    ('let a = "C:\\parts"', "E004", "\\p", "escape", 'let a = "C:\\\\parts"'),
    # brackets
    ("let a = f(1, 2", "E005", "(", "never closed", None),
    ("let a = [1, 2]]", "E006", "]", "closes nothing", "let a = [1, 2]"),
    ("let a = f(1, [2)", "E006", ")", "`]` is missing", None),
    # values and operators
    ("let a = 3 +", "E007", "", "after `+`", None),
    ("let a = 3 + * 4", "E007", "*", "after `+`, before `*`", None),
    ("let a = + 3", "E007", "+", "leave it out", "let a =  3"),
    ("let a = f(1, , 2)", "E007", ",", "missing after `,`", None),
    ("let a = ()", "E007", "()", "empty", None),
    ("let a = f @ -p", "E007", "-", "parentheses", None),
    ("let a = 1 + if b then 1 else 2", "E007", "if", "parentheses", None),
    ("let a =\nlet b = 2", "E007", "", "after `=`", None),
    ("let a = b c", "E008", "c", "`b*c`", "let a = b * c"),
    ("let a = f(1 2)", "E008", "2", "comma", "let a = f(1, 2)"),
    ("let a = [1 2]", "E008", "2", "comma", "let a = [1, 2]"),
    ("let a = 10% x", "E008", "x", "percentage", "let a = 10 %  x"),
    ("let a = [[1, 2, 3]\n[4, 5, 6]]", "E008", "[", "comma", "let a = [[1, 2, 3],\n[4, 5, 6]]"),
    ("var a = 3", "E008", "var", "`let`", "let a = 3"),
    ("function f(x) = x", "E008", "function", "`def`", "def f(x) = x"),
    ('import "a.pore" as b', "E008", "import", "`use`", 'use "a.pore" as b'),
    ("let a = { return 3 }", "E008", "return", "last expression", "let a = { 3 }"),
    ("let a = if b then 1 elif c then 2 else 3", "E008", "elif", "", "let a = if b then 1 else if c then 2 else 3"),
    # names
    ("let = 3", "E009", "=", "a name stands after `let`", None),
    ("let 3 = a", "E009", "3", "the number `3`", None),
    ("let", "E009", "", "a name stands after `let`", None),
    ("let my part = 3", "E009", "part", "my_part", "let my_part = 3"),
    ("let a = b.", "E009", "", "after `.`", None),
    ("let for = 3", "E010", "for", "word of the language", "let for_ = 3"),
    ("def f(in) = 3", "E010", "in", "a parameter", "def f(in_) = 3"),
    ('use "a.pore" as check', "E010", "check", "word of the language", 'use "a.pore" as check_'),
    # `=`
    ("let a == 3", "E011", "==", "`=`", "let a = 3"),
    ("let a = if b = c then 1 else 2", "E011", "=", "`==`", "let a = if b == c then 1 else 2"),
    ("def f(x) { x }", "E012", "{", "before its body", "def f(x) = { x }"),
    ("def f(x): x", "E012", ":", "`=`", "def f(x)= x"),
    ("def f(x)", "E012", "", "no body", None),
    ("let a 3", "E012", "3", "`=` is missing", "let a = 3"),
    ("out a", "E012", "", "no value", None),
    ("let a: length = 3", "E012", ":", "parameters of a `def`", None),
    # ranges
    ("param w = 30", "E013", "", "in lo..hi", None),
    ('param w = 30 "cell"', "E013", '"cell"', "in lo..hi", None),
    ("param w = 30 10..60", "E013", "10", "`in`", "param w = 30 in 10..60"),
    ("param w = 30 in 10...60", "E013", "...", "two dots", "param w = 30 in 10..60"),
    ("param w = 30 in [10, 60]", "E013", "", "two limits", None),
    ("param w = 30 in 10..60 cell", "E013", "cell", "in quotes", None),
    ("let a = 1..3", "E013", "..", "as an argument", None),
    # if and comparisons
    ("let a = if b then 1", "E014", "", "`else`", None),
    ("let a = if b 1 else 2", "E014", "1", "`then`", "let a = if b then 1 else 2"),
    ("let a = if b { 1 } else { 2 }", "E014", "{", "`then`", "let a = if b then { 1 } else { 2 }"),
    ("let a = b then c", "E014", "then", "without `if`", None),
    ("let a = if b < c < d then 1 else 0", "E015", "<", "do not chain", "let a = if b < c and c < d then 1 else 0"),
    # `|>` and `=>`
    ("let a = b |>", "E016", "", "missing right of `|>`", None),
    ("let a = b |> 3", "E016", "3", "a |> f(b)", None),
    ("let a = b |> f(c) + d", "E016", "f(c) + d", "binds tighter", None),
    ("let a = b |> (t => t)", "E016", "(t => t)", "a |> f(b)", None),
    ("let a = (1, 2, 3)", "E017", "(1, 2, 3)", "[a, b, c]", "let a = [1, 2, 3]"),
    ("let a = (b, 1) => b", "E017", "1", "not a name", None),
    ("let a = () => 3", "E017", "()", "parameter", None),
    ("let a = b + t => t", "E017", "=>", "parentheses", None),
    # statements
    ("sphere(3)\nlet a = 2", "E018", "sphere(3)", "not used", "let a = sphere(3)\nlet a = 2"),
    ("sphere(3)\n- sphere(2)", "E018", "sphere(3)", "starts anew", "let a = sphere(3)\n- sphere(2)"),
    ("w = 30", "E019", "=", "`let w = ...`", "let w = 30"),
    ("b = cube(9)\nb & gyroid(6)", "E019", "=", "`let b = ...`", "let b = cube(9)\nb & gyroid(6)"),
    ("part = cube(9) & gyroid(6)\n# end", "E019", "=", "`out part = ...`", "out part = cube(9) & gyroid(6)\n# end"),
    ("f(x) = x + 1", "E019", "=", "`def`", "def f(x) = x + 1"),
    ("let a = { k = 1; k }", "E019", "=", "`let k = ...`", "let a = { let k = 1; k }"),
    ("let a = 3;", "E020", ";", "leave out", "let a = 3"),
    ("let a = 3; let b = 4", "E020", ";", "line of its own", "let a = 3\n let b = 4"),
    ("let a = 3 let b = 4", "E020", "let", "line of its own", "let a = 3\n let b = 4"),
    ("let a = 1, 2", "E021", ",", "[a, b, c]", None),
    ("let a = f(r=1, 2)", "E021", "2", "without a name", None),
    ("let a = b[1, 2]", "E021", ",", "one number", None),
    ("use plates", "E022", "plates", "in quotes", None),
    ('use "a.pore"', "E022", "", "needs a name", None),
    ("check a > 3", "E023", "", "message", 'check a > 3, "..."'),
    ('check a > 3 "small"', "E023", '"small"', "comma", 'check a > 3, "small"'),
    ("check a > 3, small", "E023", "small", "in quotes", None),
    ("let f(x) = x", "E024", "(", "`def`", "def f(x) = x"),
    ("def f = 3", "E024", "=", "`let f = ...`", "let f = 3"),
    ("def f x = x", "E024", "x", "parentheses", None),
    ("def f(x y) = x", "E024", "y", "comma", "def f(x, y) = x"),
    ("def f(x: 3) = x", "E024", "3", "a kind", None),
    ("def f(w or phase) = w", "E024", "phase", "default", None),
    ("let a = { let b = 1 }", "E025", "}", "no value", None),
    ("let a = {}", "E025", "}", "empty", None),
    ("let a = { b; c }", "E025", "c", "one value", None),
    ("let a = { let b = 1 let c = 2; c }", "E025", "let", "`;`", "let a = { let b = 1; let c = 2; c }"),
    ("let a = { out b = 1; 2 }", "E025", "out", "cannot stand in a block", None),
    ("let a = [2*i for i in range(3)]", "E026", "for", "first", None),
    ("let a = [for i in [1] where i > 1: i]", "E026", "where", "if i != 3", "let a = [for i in [1] if i > 1: i]"),
    ("let a = [for i in range(3) if i > 1 i]", "E026", "i", "`:`", "let a = [for i in range(3) if i > 1: i]"),
    ("let a = [for i in range(3), j in range(2): i]", "E026", ",", "without a comma", None),
    ("preset fine: w = 6mm", "E089", "fine", "preset", 'preset "fine": w = 6mm'),
    ('preset "fine" w = 6mm', "E089", "w", "`:`", 'preset "fine": w = 6mm'),
    ('preset "fine": w: 6', "E089", ":", "w = 6mm", 'preset "fine": w= 6'),
    ('preset "fine": w = 6mm t = 3', "E089", "t", "w = 6mm, t", 'preset "fine": w = 6mm, t = 3'),
    ('preset "fine": "w" = 6mm', "E089", '"w"', "w = 6mm", None),
    ("let a = [for i range(3): i]", "E026", "range", "`in`", None),
    ("let a = [for i in range(3) i]", "E026", "i", "`:`", "let a = [for i in range(3): i]"),
    ("for i in range(3)", "E026", "for", "no loops", None),
    ("let a = 3 in b", "E029", "in", "cannot stand here", None),
]  # fmt: skip


def only(text: str) -> Diagnostic:
    (found,) = parse(Source("test.pore", text))[1]
    return found


@pytest.mark.parametrize(("text", "code", "place", "says", "mended"), MISTAKES, ids=[m[0] for m in MISTAKES])
def test_mistake(text: str, code: str, place: str, says: str, mended: str | None) -> None:
    found = only(text)
    assert found.code == code
    assert found.span is not None
    assert found.span.text == place
    assert says in f"{found.message}\n{found.label}\n{found.hint}"
    if mended is not None:
        assert found.edit is not None
        assert found.edit.apply(text) == mended
        assert not parse(Source("test.pore", mended))[1]


def test_the_second_place_is_shown() -> None:
    for text, place, label in [
        ("let a = (1]", "(", "opened here"),
        ("let a = f(1\nlet b = 2", "let", "the next statement"),
        ("let a = b < c < d", "<", "already"),
        ("let a = if b then c", "then", "then"),
        ("f(r=1, 2)", "r=1", "named"),
    ]:
        (other,) = only(text).others
        assert other.span.text == place
        assert label in other.text


def test_the_rendered_diagnostic() -> None:
    assert str(only("let a = 1\nlet b = (a + 2]\n")) == (
        "error[E006]: `]` does not close `(`\n"
        " --> test.pore:2:15\n"
        "  |\n"
        "2 | let b = (a + 2]\n"
        "  |               ^ `)` expected\n"
        " --> test.pore:2:9\n"
        "  |\n"
        "2 | let b = (a + 2]\n"
        "  |         - opened here\n"
        "  = hint: write `)`"
    )


def test_no_name_of_the_grammar_is_said() -> None:
    terminals = {t.name for t in syntax.parser().terminals} | {"ELSE_IF", "SEP", "STEP", "AS", "SET", "END", "Token"}
    for text, *_ in MISTAKES:
        found = only(text)
        said = " ".join((found.message, found.label, found.hint, *(o.text for o in found.others)))
        assert not terminals & set(re.findall(r"\w+", said)), said


def test_every_code_has_a_page_that_shows_it() -> None:
    for page in CODES.values():
        assert page.title
        assert page.explanation
        if "E001" <= page.code <= "E029":
            assert not parse(Source(page.code, page.right))[1], page.code
            if page.wrong:
                assert [d.code for d in parse(Source(page.code, page.wrong))[1]] == [page.code]


def test_every_code_of_the_syntax_is_given_and_explained() -> None:
    given = set()
    rules = (mistakes, mistakes.expressions, mistakes.openscad, mistakes.statements)
    for module in (builder, failure, foreign, *rules, syntax, tokens):
        given |= set(re.findall(r'"(E\d{3})"', inspect.getsource(module)))
    assert given == {c for c in CODES if "E001" <= c <= "E029"} | {"E037", "E038", "E046", "E089"}
