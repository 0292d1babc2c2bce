"""What to say of a statement that does not read: what was found, what would fit, and the edit that mends it."""

from __future__ import annotations

from collections.abc import Callable

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.source import Span
from porelang.syntax.failure import WORDS, Failure, describe, new_value
from porelang.syntax.tokens import CLOSING, OPENING, OPERATORS, STATEMENTS, VALUE_END, Token
from porelang.units import UNITS

BINARY = OPERATORS | {"MINUS"}
VALUE_START = frozenset({"NAME", "NUMBER", "STRING", "TRUE", "FALSE", "LPAR", "LBRACK", "LBRACE", "NOT", "IF"})
NAMED = {"LET": "let", "OUT": "out", "PARAM": "param", "DEF": "def"}

# A word with which another language begins what is begun with this one here.
OTHER_WORDS = {
    **dict.fromkeys(("var", "const", "val", "auto", "float", "int", "double", "vec3", "set"), "let"),
    **dict.fromkeys(("function", "fn", "func", "fun", "module", "define"), "def"),
    **dict.fromkeys(("import", "include", "from", "using"), "use"),
    **dict.fromkeys(("parameter", "input", "uniform"), "param"),
    **dict.fromkeys(("output", "export"), "out"),
    **dict.fromkeys(("assert", "require"), "check"),
    "elif": "else if",
    "elseif": "else if",
    "return": "",
}


def explain(failure: Failure) -> Diagnostic:
    """The diagnostic of a statement that does not read."""
    for rule in RULES:
        diagnostic = rule(failure)
        if diagnostic is not None:
            return diagnostic
    return failure.say(
        "E029", f"{describe(failure.found)} does not fit here", hint=f"it stands after {describe(failure.before)}"
    )


# ---- rules, each for one kind of mistake; the first that knows an answer gives it


def _other_word(f: Failure) -> Diagnostic | None:
    if f.after_value and f.found.type == "NAME" and OTHER_WORDS.get(f.found.text) == "else if":
        edit = f.instead("else if")
        return f.say("E008", f"`{f.found.text}` is not a word of Pore", hint="write `else if`", edit=edit)
    word = f.before
    if (
        word.type != "NAME"
        or f.found.type not in {"NAME", "STRING", "NUMBER"} | STATEMENTS
        or word.text not in OTHER_WORDS
    ):
        return None
    if f.at > 1 and f.tokens[f.at - 2].type in STATEMENTS:
        return None
    ours = OTHER_WORDS[word.text]
    hint = f"write `{ours}`" if ours else "leave it out: the value of a block or a def is its last expression"
    end = word.span.end if ours else f.found.span.start
    edit = Edit(Span(word.span.source, word.span.start, end), ours)
    return Diagnostic("E008", f"`{word.text}` is not a word of Pore", word.span, hint=hint, edit=edit)


def _name_missing(f: Failure) -> Diagnostic | None:
    if f.before.type == "DOT":
        if f.found.type in WORDS:
            return _reserved(f, "the name of a member")
        return f.say("E009", "a name is missing after `.`", "name expected", "write `q.x` or `study.von_mises`")
    word = NAMED.get(f.before.type)
    if word is None or "NAME" not in f.expected or f.value_wanted:
        return None
    if f.found.type in WORDS:
        return _reserved(f, f"the name of a `{word}`")
    got = "" if f.found.type == "$END" else f", not {describe(f.found)}"
    form = {"param": "param w = 30 in 10..60", "def": "def f(a) = a + 1"}.get(word, f"{word} a = 30")
    return f.say("E009", f"a name stands after `{word}`{got}", "name expected", f"write `{form}`")


def _reserved(f: Failure, what: str) -> Diagnostic:
    text = f.found.text
    hint = f"choose another name, `{text}_` for one"
    return f.say(
        "E010", f"`{text}` is a word of the language and cannot be {what}", hint=hint, edit=f.instead(text + "_")
    )


def _equal_missing(f: Failure) -> Diagnostic | None:
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
            return f.say("E024", "a `def` has parameters in parentheses", "`(` expected", hint, edit)
        hint = f"write `def {name}(a, b) = ...`"
        return f.say("E024", "the parameters of a `def` stand in parentheses", "`(` expected", hint)
    if f.found.text == "==":
        message = f"`{word}` gives a name its value with `=`; `==` compares"
        return f.say("E011", message, hint="write `=`", edit=f.instead("="))
    if kind == "LPAR" and head.type in ("LET", "OUT"):
        function = Edit(head.span, "def") if head.type == "LET" else None
        hint = f"write `def {name}(...) = ...`"
        return f.say("E024", f"`{word}` names a value; a function is a `def`", hint=hint, edit=function)
    if kind == "COLON":
        hint = f"{form}; kinds are declared for the parameters of a `def`"
        return f.say("E012", f"`=` is missing after `{word} {name}`", "`=` expected", hint)
    if kind == "NAME" and f.tokens[f.at + 1].type == "EQUAL":
        joined = f"{name}_{f.found.text}"
        edit = Edit(f.before.span.to(f.found.span), joined)
        return f.say("E009", "a name is one word", hint=f"write `{joined}`", edit=edit)
    if kind in ("$END", "_SEP", *CLOSING):
        return f.say("E012", f"`{word} {name}` has no value", "`=` expected", form)
    return f.say("E012", f"`=` is missing after `{word} {name}`", "`=` expected", form, f.insert(" ="))


def _after_parameters(f: Failure, name: str) -> Diagnostic:
    if f.found.type in ("ARROW", "COLON", "COMPARE"):
        return f.say("E012", "`=` stands before the body of a `def`", hint="write `=`", edit=f.instead("="))
    form = f"write `def {name}(...) = ...`"
    if f.found.type in ("$END", "_SEP", *CLOSING):
        return f.say("E012", f"`def {name}` has no body", "`=` expected", form)
    return f.say("E012", f"`def {name}` needs `=` before its body", "`=` expected", form, f.insert(" ="))


def _param(f: Failure) -> Diagnostic | None:
    if f.head.type != "PARAM" or f.within or f.value_wanted or f.at < 4:
        return None
    name = f.tokens[1].text
    kinds = [t.type for t in f.tokens[: f.at]]
    if "IN" not in kinds:
        if f.found.type in ("$END", "STRING"):
            hint = f"write `param {name} = ... in lo..hi`, or `in {{a, b, c}}` for a choice; a fixed value is a `let`"
            return f.say("E013", f"`param {name}` has no range", "`in` expected", hint)
        if f.found.type in VALUE_START | {"DOTS"} and any(t.type == "DOTS" for t in f.tokens[f.at :]):
            return f.say("E013", "`in` is missing before the range", "`in` expected", "put it in", f.insert(" in"))
        return None
    if "DOTS" not in kinds and "SET" not in kinds:
        hint = "write `in lo..hi`, with two dots, or `in {a, b, c}`"
        return f.say("E013", "a range has two limits with `..` between", "`..` expected", hint)
    if f.found.type == "DOTS":
        return f.say("E013", "a range has two limits, not three", hint="write `lo..hi step s`")
    if f.found.type == "NAME" and f.before.type in VALUE_END:
        hint = 'write `step s` for a step, and the description in quotes: "unit cell"'
        return f.say("E013", f"`{f.found.text}` does not belong to a param", hint=hint)
    return None


def _use(f: Failure) -> Diagnostic | None:
    if f.head.type != "USE":
        return None
    hint = 'write `use "lib/plates.pore" as plates`'
    if f.at == 1:
        return f.say("E022", "the file to be used is named in quotes", "a text expected", hint)
    if f.found.type in WORDS and f.before.type == "AS":
        return _reserved(f, "the name of a file")
    message = (
        "a file that is used needs a name" if f.at in (2, 3) else f"{describe(f.found)} does not belong to a `use`"
    )
    return f.say("E022", message, "`as` and a name expected" if f.at == 2 else "", hint)


def _check(f: Failure) -> Diagnostic | None:
    if f.head.type != "CHECK" or f.within:
        return None
    if f.after_value and f.found.type in ("$END", "STRING") and f.before.type != "STRING":
        if f.found.type == "STRING":
            return f.say("E023", "a comma is missing before the message", hint="put it in", edit=f.insert(","))
        hint = 'say what a user should read if it fails: `check c, "message"`'
        return f.say("E023", "a `check` needs a message", "`,` and a text expected", hint, f.insert(', "..."'))
    if f.before.type == "_COMMA" and "STRING" in f.expected and not f.value_wanted:
        return f.say(
            "E023", "the message of a `check` is a text in quotes", "a text expected", 'write `check c, "message"`'
        )
    return None


def _parameters(f: Failure) -> Diagnostic | None:
    if f.head.type != "DEF" and not any(t.type == "DEF" for t in f.tokens[: f.at]):
        return None
    if f.inner != "LPAR" or f.value_wanted:
        return None
    opened = f.tokens.index(f.within[-1])
    if opened < 2 or f.tokens[opened - 2].type != "DEF":
        return None
    hint = "a parameter is `name`, `name = default`, `name: kind` or `name: kind where condition = default`"
    if f.before.type == "COLON":
        return f.say(
            "E024", f"a kind stands after `:`, not {describe(f.found)}", hint="length, angle, scalar, vector ..."
        )
    if f.found.type in WORDS and "NAME" in f.expected:
        return _reserved(f, "a parameter")
    if f.found.text == "==":
        return f.say("E011", "a default is given with `=`; `==` compares", hint="write `=`", edit=f.instead("="))
    if f.found.type == "NAME" and f.before.type == "NAME":
        return f.say("E024", "a comma is missing between two parameters", hint=hint, edit=f.insert(","))
    return f.say("E024", f"{describe(f.found)} does not fit in a list of parameters", hint=hint)


def _assignment(f: Failure) -> Diagnostic | None:
    if f.found.type != "EQUAL":
        return None
    starts = [0, *(i + 1 for i in range(f.at) if f.tokens[i].type in ("_SEP", "LBRACE"))]
    start = max(i for i in starts if i < f.at) if f.at else 0
    first = f.tokens[start]
    at_start = start == 0 or f.inner == "LBRACE"
    if at_start and first.type == "NAME" and start == f.at - 1:
        hint = f"write `let {first.text} = ...`; inside a call, `f(r=2)` names an argument"
        edit = Edit(Span(first.span.source, first.span.start, first.span.start), "let ")
        return f.say("E019", f"a name gets its value with `let`: `let {first.text} = ...`", hint=hint, edit=edit)
    if (
        at_start
        and first.type == "NAME"
        and f.before.type == "RPAR"
        and f.tokens[start + 1].type == "LPAR"
        and not f.value_wanted
    ):
        edit = Edit(Span(first.span.source, first.span.start, first.span.start), "def ")
        return f.say("E019", "a function is made with `def`", hint=f"write `def {first.text}(...) = ...`", edit=edit)
    if f.value_wanted:
        return f.say("E007", "a value is missing before `=`", hint="two values are compared with `==`, `<=` or `>=`")
    return f.say(
        "E011", "`=` gives a name its value; two values are compared with `==`", hint="write `==`", edit=f.instead("==")
    )


def _comparison(f: Failure) -> Diagnostic | None:
    if f.found.type != "COMPARE" or not f.after_value:
        return None
    depth = 0
    for i in range(f.at - 1, -1, -1):
        token = f.tokens[i]
        depth += (token.type in CLOSING) - (token.type in OPENING)
        if depth < 0 or (depth == 0 and token.type in ("AND", "OR", "IF", "THEN", "ELSE", "_COMMA", "EQUAL", "_SEP")):
            return None
        if depth == 0 and token.type == "COMPARE":
            middle = token.span.source.text[token.span.end : f.found.span.start].strip()
            joint = next((t for t in f.tokens[i : f.at] if t.text in ("&", "|")), None)
            if joint is not None:  # `a > 0 & b > 0`: meant as conditions, read as solids
                word = {"&": "and", "|": "or"}[joint.text]
                others = (Label(joint.span, "this joins solids, before anything is compared"),)
                hint = f"conditions are joined with `{word}`"
                return Diagnostic(
                    "E015", "comparisons do not chain", f.found.span, "", others, hint, Edit(joint.span, word)
                )
            hint = f"write `... {token.text} {middle} and {middle} {f.found.text} ...`"
            others = (Label(token.span, "compared here already"),)
            return Diagnostic(
                "E015", "comparisons do not chain", f.found.span, "", others, hint, f.insert(f" and {middle}")
            )
    return None


def _value_missing(f: Failure) -> Diagnostic | None:
    if not f.value_wanted:
        return None
    kind, before = f.found.type, f.before
    after = f"after {describe(before)}" if f.at else "at the start"
    if kind == "PLUS":
        return f.say(
            "E007",
            "`+` needs a value on its left",
            hint="leave it out: a number without a sign is positive",
            edit=f.instead(""),
        )
    if before.type == "PIPE":
        hint = "write `a |> f(b)` for `f(a, b)`"
        return f.say("E016", "a function is missing right of `|>`", "a call or a name expected", hint)
    if kind in ("NOT", "IF") and before.type in BINARY | {"MINUS", "TILDE"}:
        form = "(not a)" if kind == "NOT" else "(if c then a else b)"
        return f.say(
            "E007", f"`{f.found.text}` after an operator stands in parentheses", hint=f"write `{before.text} {form}`"
        )
    if kind in ("MINUS", "TILDE"):
        return f.say(
            "E007",
            f"`{f.found.text}` after `{before.text}` stands in parentheses",
            hint=f"write `{before.text} ({f.found.text}a)`",
        )
    if kind == "FOR":
        if before.type == "LBRACK":
            return None
        return f.say(
            "E026", "there are no loops; a list is made by `[for ...]`", hint="write `[for i in range(6): ...]`"
        )
    if f.inner == "LBRACE" and kind == "RBRACE":
        what = "is empty" if before.type == "LBRACE" else "has no value"
        return f.say("E025", f"this block {what}", "a value expected before `}`", "a block is `{ let k = ...; value }`")
    if kind in STATEMENTS:
        word = f.found.text
        if f.inner == "LBRACE" and kind not in ("LET", "DEF"):
            return f.say(
                "E025",
                f"`{word}` cannot stand in a block",
                hint="a block holds `let` and `def`, and a value at its end",
            )
        if f.at and before.type != "_SEP":
            hint = "bindings inside a value stand in a block: `{ let k = ...; value }`"
            return f.say("E007", f"a value is missing {after}: `{word}` begins a statement", "value expected", hint)
    if kind == "STRING" or kind in VALUE_START:
        return None
    if kind in ("THEN", "ELSE", "ELSE_IF") and f.inner not in ("IF", "THEN"):
        return f.say("E014", f"`{f.found.text}` without `if`", hint="write `if c then a else b`")
    got = "" if kind in ("$END", "_SEP") else f", before {describe(f.found)}"
    return f.say("E007", f"a value is missing {after}{got}", "value expected")


def _if(f: Failure) -> Diagnostic | None:
    kind = f.found.type
    if kind in BINARY or f.value_wanted:
        return None
    if (
        f.inner in ("IF", "ELSE_IF")
        and kind not in ("THEN", "DOTS", "ARROW")
        and (kind not in VALUE_START or f.after_value)
    ):
        others = (Label(f.within[-1].span, "this `if`"),)
        edit: Edit | None = f.instead(" then") if kind == "COLON" else f.insert(" then")
        if kind in ("$END", "_SEP") or kind in CLOSING:
            edit = None
        hint = "write `if c then a else b`"
        return Diagnostic(
            "E014", "`then` is missing after the condition", f.found.span, "`then` expected", others, hint, edit
        )
    if f.inner == "THEN" and (kind in ("$END", "_SEP", "_COMMA", "THEN", "STRING") or kind in CLOSING):
        others = (Label(f.within[-1].span, "for this `then`"),)
        hint = "every `if` has an `else`: `if c then a else b`"
        return Diagnostic("E014", "`else` is missing", f.found.span, "`else` expected", others, hint)
    if kind in ("THEN", "ELSE", "ELSE_IF"):
        return f.say("E014", f"`{f.found.text}` without `if`", hint="write `if c then a else b`")
    return None


def _comprehension(f: Failure) -> Diagnostic | None:
    kinds = [t.type for t in f.tokens[: f.at]]
    form = "write `[for i in range(6): value]`"
    if f.found.type == "FOR":
        where = "first in its list: `[for i in range(6): value]`" if f.inner == "LBRACK" else "in a list"
        return f.say("E026", f"`for` stands {where}", hint=form)
    if f.before.type == "FOR" or (f.before.type == "NAME" and f.at > 1 and kinds[-2] == "FOR"):
        if f.found.type in WORDS and f.before.type == "FOR":
            return _reserved(f, "the name of a variable")
        return f.say(
            "E026",
            "a name and `in` stand after `for`",
            f"{'a name' if f.before.type == 'FOR' else '`in`'} expected",
            form,
        )
    if f.inner == "LBRACK" and not f.value_wanted:
        opened = f.tokens.index(f.within[-1])
        if f.tokens[opened + 1].type == "FOR" and "COLON" not in kinds[opened:]:
            return f.say("E026", "`:` is missing before the value", "`:` expected", form, f.insert(":"))
        if f.tokens[opened + 1].type == "FOR" and f.found.type == "_COMMA":
            return f.say(
                "E026", "a list made by `for` has one value", hint="write `[for i in range(6): [a, b, c]]` for several"
            )
    return None


def _misplaced(f: Failure) -> Diagnostic | None:
    kind, inner = f.found.type, f.inner
    if kind == "ARROW":
        return f.say(
            "E017",
            "a function among operators stands in parentheses",
            hint="write `(t => ...)`, with a name left of `=>`",
        )
    if kind == "DOTS":
        hint = "a range stands after `in` of a param, and as an argument of a call"
        return f.say("E013", "a range cannot stand here", hint=hint)
    if kind == "IN":
        return f.say(
            "E029", "`in` cannot stand here", hint="it belongs to `param w = 30 in 10..60` and `[for i in range(3): i]`"
        )
    if kind in STATEMENTS and f.after_value:
        if inner == "LBRACE":
            return f.say(
                "E025", "the bindings of a block stand on their own lines", hint="put `;` between", edit=f.insert(";")
            )
        return f.say("E020", "a statement starts on a line of its own", hint="begin a new line", edit=f.insert("\n"))
    if kind == "RBRACE" and f.after_value:
        hint = "a block is `{ let k = ...; value }`"
        return f.say("E025", "this block has no value", "a value expected before `}`", hint)
    if inner == "LBRACE" and f.before.type == "_SEP":
        hint = "a block is `{ let k = ...; value }`; only the last line is its value"
        return f.say("E025", "a block has one value, at its end", hint=hint)
    if kind == "_COMMA":
        if inner == "LBRACE":
            return f.say("E021", "a comma cannot stand in a block", hint="a list is written in `[ ]`")
        if inner == "LBRACK" and f.opening_is_index:
            opened = f.within[-1]
            if opened.fresh:
                return new_value(opened, f.tokens[f.tokens.index(opened) - 1].span)
            return f.say("E021", "an index is one number", hint="write `points[2]`, or `points[2].x`")
        if not inner:
            return f.say("E021", "a comma cannot stand here", hint="write [a, b, c] for a vector or a list")
    if kind == "COLON":
        return f.say(
            "E029",
            "`:` cannot stand here",
            hint="it belongs to the kind of a parameter and to `[for i in range(3): i]`",
        )
    return None


def _two_values(f: Failure) -> Diagnostic | None:
    if not f.after_value or f.found.type not in VALUE_START:
        return None
    before, found = f.before, f.found
    others = (Label(before.span, "this value ends here"),)
    if before.type == "NUMBER" and found.type == "NAME" and found.text in UNITS and before.text[-1] in "0123456789.":
        edit = Edit(Span(before.span.source, before.span.end, found.span.start), "")
        return f.say("E002", "a unit touches its number", hint=f"write `{before.text}{found.text}`", edit=edit)
    if before.text.endswith("%"):
        edit = Edit(before.span, before.text[:-1] + " % ")
        hint = f"`{before.text}` is a percentage; for the remainder write `{before.text[:-1]} % {found.text}`"
        return Diagnostic("E008", "an operator is missing between two values", found.span, "", others, hint, edit)
    if f.inner in ("LPAR", "LBRACK", "SET") and found.type != "LBRACE":
        hint = "put a comma between two values, or an operator"
        return Diagnostic("E008", "a comma or an operator is missing", found.span, "", others, hint, f.insert(","))
    simple = found.type in ("NAME", "NUMBER") and before.type in ("NAME", "NUMBER")
    hint = "put an operator between: `*` multiplies, `|` joins solids, `&` intersects them"
    if simple:
        hint = f"for a product write `{before.text}*{found.text}`"
    product = f.insert(" *") if simple else None
    return Diagnostic("E008", "an operator is missing between two values", found.span, "", others, hint, product)


RULES: tuple[Callable[[Failure], Diagnostic | None], ...] = (
    _other_word,
    _use,
    _name_missing,
    _equal_missing,
    _assignment,
    _comparison,
    _check,
    _parameters,
    _value_missing,
    _if,
    _param,
    _comprehension,
    _misplaced,
    _two_values,
)
