"""Mistakes of statements: their words, their names, `=`, and what each of them asks for."""

from __future__ import annotations

from porelang.diagnostics import Diagnostic, Edit
from porelang.source import Span
from porelang.syntax import habits
from porelang.syntax.failure import KEYWORDS, Failure, describe, reserved
from porelang.syntax.tokens import CLOSING, OPENING, STATEMENTS, VALUE_END, VALUE_START, Token
from porelang.units import UNITS

#: The statements that bind a name.
NAMED = {"LET": "let", "OUT": "out", "PARAM": "param", "DEF": "def"}

# A word with which another language begins what is begun with this one here.
OTHER_WORDS = {
    **dict.fromkeys(("var", "const", "val", "auto", "float", "int", "double", "vec3", "set"), "let"),
    **dict.fromkeys(("function", "fn", "func", "fun", "module", "define"), "def"),
    **dict.fromkeys(("import", "include", "from", "using"), "use"),
    **dict.fromkeys(("parameter", "input", "uniform", "slider", "number_slider"), "param"),
    **dict.fromkeys(("output", "export"), "out"),
    **dict.fromkeys(("assert", "require"), "check"),
    "elif": "else if",
    "elseif": "else if",
    "return": "",
}
#: A value with one of these is no constant, most likely.
_OF_SOLIDS = frozenset({"LPAR", "PIPE", "BAR", "AMP", "BACKSLASH"})


def other_word(f: Failure) -> Diagnostic | None:
    if f.after_value and f.found.type == "NAME" and OTHER_WORDS.get(f.found.text) == "else if":
        edit = f.instead("else if")
        return f.error("E008", f"`{f.found.text}` is not a word of Pore", hint="write `else if`", edit=edit)
    word = f.before
    if (
        word.type != "NAME"
        or (f.found.type not in {"NAME", "STRING", "NUMBER"} | STATEMENTS and f.found.text != "<")
        or word.text not in OTHER_WORDS
    ):
        return None
    if f.at > 1 and f.tokens[f.at - 2].type in STATEMENTS:
        return None
    if f.head.type == "DEF" and f.inner == "LPAR":
        return parameters(f)
    ours = OTHER_WORDS[word.text]
    if ours == "use" and f.found.type == "NAME" and f.at == 1:  # `import numpy as np`, `from math import sin`
        whole = Edit(word.span.to(f.tokens[-2].span), "")
        hint = 'leave it out: functions need no prefix, `sin(x)`; a file of yours comes by `use "parts.pore" as parts`'
        return Diagnostic("E008", f"`{word.text}` is not a word of Pore", word.span, hint=hint, edit=whole)
    if ours == "out" and f.at == 1 and f.tokens[f.at + 1].type != "EQUAL":
        ours = "out part ="
    hint = f"write `{ours}`" if ours else "leave it out: the value of a block or a def is its last expression"
    end = word.span.end if ours else f.found.span.start
    edit = Edit(Span(word.span.source, word.span.start, end), ours)
    return Diagnostic("E008", f"`{word.text}` is not a word of Pore", word.span, hint=hint, edit=edit)


def mesh(f: Failure) -> Diagnostic | None:
    """`import "part.stl"`, and `use` of one without a name."""
    words = ("use", *(word for word, ours in OTHER_WORDS.items() if ours == "use"))
    if f.head.text not in words or len(f.tokens) < 2:
        return None
    path = f.tokens[1]
    if path.type != "STRING" or not path.text.strip('"').lower().endswith(habits.MESH_ENDINGS):
        return None
    return Diagnostic("E046", f"{path.text} is no program of Pore", path.span, "a mesh", hint=habits.MESHES)


def name_missing(f: Failure) -> Diagnostic | None:
    if f.before.type == "DOT":
        if f.found.type in KEYWORDS:
            return reserved(f, "the name of a member")
        return f.error("E009", "a name is missing after `.`", "name expected", "write `q.x` or `study.von_mises`")
    word = NAMED.get(f.before.type)
    if word is None or "NAME" not in f.expected or f.value_wanted:
        return None
    if f.found.type in KEYWORDS:
        return reserved(f, f"the name of a `{word}`")
    if word == "let" and f.found.type in ("LPAR", "LBRACK"):
        hint = "write `let a = ...`, and so for each; the items of a list are `q[0]`, `q[1]`, those of a vector `q.x`"
        return f.error("E009", "a `let` binds one name", "name expected", hint)
    got = "" if f.found.type == "$END" else f", not {describe(f.found)}"
    form = {"param": "param w = 30 in 10..60", "def": "def f(a) = a + 1"}.get(word, f"{word} a = 30")
    return f.error("E009", f"a name stands after `{word}`{got}", "name expected", f"write `{form}`")


def equal_missing(f: Failure) -> Diagnostic | None:
    if f.at < 2 or f.value_wanted:
        return None
    if f.before.type == "NAME" and f.tokens[f.at - 2].type in NAMED:
        return _after_name(f, f.tokens[f.at - 2], f.before.text)
    opened = f.opening(f.at - 1)
    if opened >= 2 and f.tokens[opened - 2].type == "DEF":
        return _after_parameters(f, f.tokens[opened - 1].text)
    return None


def _after_name(f: Failure, head: Token, name: str) -> Diagnostic:
    kind, word = f.found.type, NAMED[head.type]
    form = f"write `{word} {name} = ...`"
    if head.type == "DEF":
        if kind == "EQUAL":
            hint = f"write `let {name} = ...` for a value"
            edit = Edit(head.span, "let")
            return f.error("E024", "a `def` has parameters in parentheses", "`(` expected", hint, edit)
        hint = f"write `def {name}(a, b) = ...`"
        return f.error("E024", "the parameters of a `def` stand in parentheses", "`(` expected", hint)
    if f.found.text == "==":
        message = f"`{word}` gives a name its value with `=`; `==` compares"
        return f.error("E011", message, hint="write `=`", edit=f.instead("="))
    if kind == "IN" and head.type == "PARAM":
        least = f.tokens[f.at + 1]
        known = f" = {least.text}" if least.type == "NUMBER" else " = ..."
        hint = f"a param has a default, which is within its range: `param {name}{known} in ...`"
        return f.error("E012", f"`param {name}` has no default", "`=` and a value expected", hint,
                       f.insert(known) if least.type == "NUMBER" else None)  # fmt: skip
    if kind == "_COMMA":
        return f.error(
            "E012", f"a `{word}` binds one name", hint=f"write `{word} {name} = ...`, and so for each of them"
        )
    if kind == "LPAR" and head.type == "OUT" and not _is_definition(f):
        start = f.tokens[1].span.start
        edit = Edit(Span(head.span.source, start, start), "part = ")
        return f.error("E012", "an output has a name", hint=f"write `out part = {name}(...)`", edit=edit)
    if kind == "LPAR" and head.type in ("LET", "OUT"):
        function = Edit(head.span, "def") if head.type == "LET" else None
        hint = f"write `def {name}(...) = ...`"
        return f.error("E024", f"`{word}` names a value; a function is a `def`", hint=hint, edit=function)
    if kind == "COLON":
        hint = f"{form}; kinds are declared for the parameters of a `def`"
        return f.error("E012", f"`=` is missing after `{word} {name}`", "`=` expected", hint)
    if kind == "NAME" and f.tokens[f.at + 1].type == "EQUAL":
        joined = f"{name}_{f.found.text}"
        edit = Edit(f.before.span.to(f.found.span), joined)
        return f.error("E009", "a name is one word", hint=f"write `{joined}`", edit=edit)
    if kind in ("$END", "_SEP", *CLOSING):
        return f.error("E012", f"`{word} {name}` has no value", "`=` expected", form)
    return f.error("E012", f"`=` is missing after `{word} {name}`", "`=` expected", form, f.insert(" ="))


def _is_definition(f: Failure) -> bool:
    """Whether a `=` follows the parentheses that begin here: `out f(x) = ...`."""
    depth = 0
    for i in range(f.at, len(f.tokens)):
        depth += (f.tokens[i].type in OPENING) - (f.tokens[i].type in CLOSING)
        if depth == 0:
            return f.tokens[i + 1].type == "EQUAL" if i + 1 < len(f.tokens) else False
    return False


def check_in_parentheses(tokens: list[Token]) -> Diagnostic | None:
    """`check(c, "message")`, which would be one value of several in parentheses."""
    kinds = [t.type for t in tokens]
    if kinds[:2] != ["CHECK", "LPAR"] or kinds[-3:] != ["_COMMA", "STRING", "RPAR"]:
        return None
    opened, closed = tokens[1].span, tokens[-1].span
    inside = Span(opened.source, opened.end, closed.start).text
    return Diagnostic(
        "E023",
        "a `check` has no parentheses",
        opened.to(closed),
        hint=f"write `check {inside}`" if len(inside) < 80 else 'write `check c, "message"`',
        edit=Edit(Span(opened.source, tokens[0].span.end, closed.end), f" {inside}"),
    )


def _after_parameters(f: Failure, name: str) -> Diagnostic:
    if f.found.type in ("ARROW", "COLON", "COMPARE"):
        return f.error("E012", "`=` stands before the body of a `def`", hint="write `=`", edit=f.instead("="))
    form = f"write `def {name}(...) = ...`"
    if f.found.type in ("$END", "_SEP", *CLOSING):
        return f.error("E012", f"`def {name}` has no body", "`=` expected", form)
    return f.error("E012", f"`def {name}` needs `=` before its body", "`=` expected", form, f.insert(" ="))


def kind_and_range(f: Failure) -> Diagnostic | None:
    """`param w: length = 5mm in 1mm..9mm`."""
    if f.head.type != "PARAM" or f.found.type != "IN" or f.within or len(f.tokens) < 4 or f.tokens[2].type != "COLON":
        return None
    kind = Span(f.found.span.source, f.tokens[1].span.end, f.tokens[3].span.end)
    hint = "leave the kind out: the unit of its default says it; a param with a kind takes data"
    return f.error("E013", "a param with a range has no kind", "a range follows", hint, Edit(kind, ""))


def param_range(f: Failure) -> Diagnostic | None:
    if f.head.type != "PARAM" or f.within or f.value_wanted or f.at < 4:
        return None
    if f.before.type == "NUMBER" and f.found.text in UNITS:
        return None
    name = f.tokens[1].text
    kinds = [t.type for t in f.tokens[: f.at]]
    if f.found.type == "_COMMA" and "IN" in kinds:
        return f.error("E013", "no comma stands in a param", hint="leave it out", edit=f.instead(""))
    if "IN" not in kinds:
        if f.found.type in ("$END", "STRING"):
            hint = f"write `param {name} = ... in lo..hi`, or `in {{a, b, c}}` for a choice; a fixed value is a `let`"
            return f.error("E013", f"`param {name}` has no range", "`in` expected", hint)
        if f.found.type in VALUE_START | {"DOTS"} and any(t.type == "DOTS" for t in f.tokens[f.at :]):
            return f.error("E013", "`in` is missing before the range", "`in` expected", "put it in", f.insert(" in"))
        return None
    if "DOTS" not in kinds and "SET" not in kinds:
        ends = _two_ends(f, kinds.index("IN") + 1)
        if ends is not None:
            message = "a range has two limits with `..` between"
            return f.error("E013", message, "", f"write `in {ends.text}`", ends)
        hint = "write `in lo..hi`, with two dots, or `in {a, b, c}`"
        return f.error("E013", "a range has two limits with `..` between", "`..` expected", hint)
    if f.found.type == "DOTS":
        return f.error("E013", "a range has two limits, not three", hint="write `lo..hi step s`")
    if f.found.type == "NAME" and f.before.type in VALUE_END:
        hint = 'write `step s` for a step, and the description in quotes: "unit cell"'
        return f.error("E013", f"`{f.found.text}` does not belong to a param", hint=hint)
    return None


def _two_ends(f: Failure, start: int) -> Edit | None:
    """`[1mm, 9mm]`, `1mm-9mm` and `1mm to 9mm`, which are meant as a range."""
    tokens = f.tokens[start:]
    if tokens[0].type == "LBRACK":
        tokens = tokens[1:4] if len(tokens) > 4 and tokens[4].type == "RBRACK" else []
        last = f.tokens[start + 4] if tokens else None
    else:
        tokens = tokens[:3]
        last = tokens[-1]
    between = tokens[1].type in ("_COMMA", "MINUS") or tokens[1].text in ("to", "until") if len(tokens) == 3 else False
    if last is None or not between or tokens[0].type != "NUMBER" or tokens[2].type != "NUMBER":
        return None
    return Edit(f.tokens[start].span.to(last.span), f"{tokens[0].text}..{tokens[2].text}")


def use(f: Failure) -> Diagnostic | None:
    if f.head.type != "USE":
        return None
    hint = 'write `use "lib/plates.pore" as plates`'
    if f.at == 1:
        return f.error("E022", "the file to be used is named in quotes", "a text expected", hint)
    if f.found.type in KEYWORDS and f.before.type == "AS":
        return reserved(f, "the name of a file")
    message = (
        "a file that is used needs a name" if f.at in (2, 3) else f"{describe(f.found)} does not belong to a `use`"
    )
    return f.error("E022", message, "`as` and a name expected" if f.at == 2 else "", hint)


def preset(f: Failure) -> Diagnostic | None:
    named = f.head.type == "PRESET"
    if f.within or f.value_wanted or not (named or (f.head.text == "preset" and f.at == 1)):
        return None
    form = 'write `preset "fine": w = 6mm, t = 0.4mm`'
    if not named:
        quoted = f.instead(f'"{f.found.text}"') if f.found.type == "NAME" else None
        return f.error("E089", "the name of a preset stands in quotes", "a text expected", form, quoted)
    if f.at == 2:
        edit = {"EQUAL": f.instead(":"), "ARROW": f.instead(":"), "NAME": f.insert(":")}.get(f.found.type)
        return f.error("E089", "`:` stands after the name of a preset", "`:` expected", form, edit)
    if f.before.type in ("COLON", "_COMMA"):
        if f.found.type in KEYWORDS:
            return reserved(f, "the name of a param")
        return f.error("E089", f"a preset names params, not {describe(f.found)}", "a name expected", form)
    if f.before.type == "NAME" and "EQUAL" in f.expected:
        edit = f.instead("=") if f.found.text in (":", "==", ":=", "=>") else None
        return f.error("E089", f"`=` stands between `{f.before.text}` and its value", "`=` expected", form, edit)
    if f.after_value and f.found.type == "NAME":
        return f.error("E089", "a comma is missing between two params", "`,` expected", form, f.insert(","))
    return None


def check(f: Failure) -> Diagnostic | None:
    if f.head.type != "CHECK" or f.within:
        return None
    if f.after_value and f.found.type in ("$END", "STRING") and f.before.type != "STRING":
        if f.found.type == "STRING":
            return f.error("E023", "a comma is missing before the message", hint="put it in", edit=f.insert(","))
        hint = 'say what a user should read if it fails: `check c, "message"`'
        return f.error("E023", "a `check` needs a message", "`,` and a text expected", hint, f.insert(', "..."'))
    if f.before.type == "_COMMA" and "STRING" in f.expected and not f.value_wanted:
        return f.error(
            "E023", "the message of a `check` is a text in quotes", "a text expected", 'write `check c, "message"`'
        )
    return None


def parameters(f: Failure) -> Diagnostic | None:
    if f.head.type != "DEF" and not any(t.type == "DEF" for t in f.tokens[: f.at]):
        return None
    if f.inner != "LPAR" or f.value_wanted:
        return None
    opened = f.tokens.index(f.within[-1])
    if opened < 2 or f.tokens[opened - 2].type != "DEF":
        return None
    hint = "a parameter is `name`, `name = default`, `name: kind` or `name: kind where condition = default`"
    if f.before.type == "COLON":
        return f.error(
            "E024", f"a kind stands after `:`, not {describe(f.found)}", hint="length, angle, scalar, vector ..."
        )
    if f.found.type in KEYWORDS and "NAME" in f.expected:
        return reserved(f, "a parameter")
    if f.found.text == "==":
        return f.error("E011", "a default is given with `=`; `==` compares", hint="write `=`", edit=f.instead("="))
    if f.found.type == "COMPARE" and f.tokens[f.at - 2].type == "COLON":
        parameter = f.tokens[f.at - 3].text
        hint = f"write `{parameter}: {f.before.text} where {parameter} {f.found.text} ...`"
        return f.error("E024", "a contract stands after `where`", "", hint, f.insert(f" where {parameter}"))
    if f.found.type == "NAME" and f.before.type == "NAME" and OTHER_WORDS.get(f.before.text) == "let":
        kind = "vector" if f.before.text == "vec3" else "number"
        ours = f"{f.found.text}: {kind}"
        return Diagnostic("E024", "the kind of a parameter stands behind it", f.before.span, hint=f"write `{ours}`",
                          edit=Edit(f.before.span.to(f.found.span), ours))  # fmt: skip
    if f.found.type == "NAME" and f.before.type == "NAME":
        return f.error("E024", "a comma is missing between two parameters", hint=hint, edit=f.insert(","))
    return f.error("E024", f"{describe(f.found)} does not fit in a list of parameters", hint=hint)


def assignment(f: Failure) -> Diagnostic | None:
    if f.found.type != "EQUAL":
        return None
    starts = [0, *(i + 1 for i in range(f.at) if f.tokens[i].type in ("_SEP", "LBRACE"))]
    start = max(i for i in starts if i < f.at) if f.at else 0
    first = f.tokens[start]
    at_start = start == 0 or f.inner == "LBRACE"
    if at_start and first.type == "NAME" and start == f.at - 1:
        if first.text in ("x", "y", "z", "p"):
            hint = "x, y, z and p are the point: choose another name, `let a = ...`"
            return f.error("E019", f"`{first.text}` is a coordinate, and gets no value", hint=hint)
        # a solid that is the last statement is the part of a program: `let` would leave it without one
        after = first.span.source.text[f.tokens[-1].span.end :].splitlines()
        last = f.inner == "" and all(line.strip()[:1] in ("", "#") for line in after)
        last = last and any(t.type in _OF_SOLIDS for t in f.tokens[f.at :])
        word = "out" if last else "let"
        hint = f"write `{word} {first.text} = ...`; inside a call, `f(r=2)` names an argument"
        edit = Edit(Span(first.span.source, first.span.start, first.span.start), f"{word} ")
        said = f"a result gets its name with `out`: `out {first.text} = ...`"
        if not last:
            said = f"a name gets its value with `let`: `let {first.text} = ...`"
        return f.error("E019", said, hint=hint, edit=edit)
    if (
        at_start
        and first.type == "NAME"
        and f.before.type == "RPAR"
        and f.tokens[start + 1].type == "LPAR"
        and not f.value_wanted
    ):
        edit = Edit(Span(first.span.source, first.span.start, first.span.start), "def ")
        return f.error("E019", "a function is made with `def`", hint=f"write `def {first.text}(...) = ...`", edit=edit)
    if at_start and start < f.at - 2 and f.before.type == "NAME" and f.tokens[f.at - 2].type == "DOT":
        owner = Span(first.span.source, first.span.start, f.tokens[f.at - 3].span.end).text
        hint = f"hand it over in the call, `{owner}({f.before.text}=...)`; a `param` is set from outside"
        return f.error("E019", f"nothing of `{owner}` can be set", "", hint)
    if f.value_wanted:
        return f.error("E007", "a value is missing before `=`", hint="two values are compared with `==`, `<=` or `>=`")
    return f.error(
        "E011", "`=` gives a name its value; two values are compared with `==`", hint="write `==`", edit=f.instead("==")
    )
