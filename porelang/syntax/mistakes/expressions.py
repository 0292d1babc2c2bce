"""Mistakes of expressions: values, operators, brackets, `if` and `for`."""

from __future__ import annotations

from collections.abc import Collection

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.source import Span
from porelang.syntax import habits
from porelang.syntax.failure import KEYWORDS, Failure, describe, new_value, reserved
from porelang.syntax.measures import is_bound, unknown_unit
from porelang.syntax.tokens import BINARY, CLOSING, OPENING, STATEMENTS, VALUE_START
from porelang.units import ELSEWHERE, UNITS, WITHOUT


def comparison(f: Failure) -> Diagnostic | None:
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


def value_missing(f: Failure) -> Diagnostic | None:
    if not f.value_wanted:
        return None
    kind, before = f.found.type, f.before
    if f.found.text == before.text == ">" and f.found.span.start == before.span.end:
        edit = Edit(before.span.to(f.found.span), "|>")
        return Diagnostic("E001", "`>>` is not a sign of Pore", edit.span,
                          hint="`a |> f(b)` hands a value on: it is `f(a, b)`", edit=edit)  # fmt: skip
    after = f"after {describe(before)}" if f.at else "at the start"
    if kind == "PLUS":
        return f.error(
            "E007",
            "`+` needs a value on its left",
            hint="leave it out: a number without a sign is positive",
            edit=f.instead(""),
        )
    if before.type == "PIPE":
        hint = "write `a |> f(b)` for `f(a, b)`"
        return f.error("E016", "a function is missing right of `|>`", "a call or a name expected", hint)
    if kind in ("NOT", "IF") and before.type in BINARY | {"MINUS", "TILDE"}:
        form = "(not a)" if kind == "NOT" else "(if c then a else b)"
        return f.error(
            "E007", f"`{f.found.text}` after an operator stands in parentheses", hint=f"write `{before.text} {form}`"
        )
    if kind in ("MINUS", "TILDE"):
        return f.error(
            "E007",
            f"`{f.found.text}` after `{before.text}` stands in parentheses",
            hint=f"write `{before.text} ({f.found.text}a)`",
        )
    if kind == "FOR":
        if before.type == "LBRACK":
            return None
        clauses = f.inner == "LBRACK" and f.tokens[f.tokens.index(f.within[-1]) + 1].type == "FOR"
        if before.type == "COLON" and clauses:
            hint = "one `:` stands before the value: `[for i in range(3) for j in range(4): value]`"
            return Diagnostic("E026", "no `:` stands between one `for` and the next", before.span, "", (), hint,
                              Edit(before.span, ""))  # fmt: skip
        return f.error(
            "E026", "there are no loops; a list is made by `[for ...]`", hint="write `[for i in range(6): ...]`"
        )
    if f.inner == "LBRACE" and kind == "RBRACE":
        what = "is empty" if before.type == "LBRACE" else "has no value"
        return f.error(
            "E025", f"this block {what}", "a value expected before `}`", "a block is `{ let k = ...; value }`"
        )
    if kind in STATEMENTS:
        word = f.found.text
        if f.inner == "LBRACE" and kind not in ("LET", "DEF"):
            return f.error(
                "E025",
                f"`{word}` cannot stand in a block",
                hint="a block holds `let` and `def`, and a value at its end",
            )
        if f.at and before.type != "_SEP":
            hint = "bindings inside a value stand in a block: `{ let k = ...; value }`"
            return f.error("E007", f"a value is missing {after}: `{word}` begins a statement", "value expected", hint)
    if kind == "STRING" or kind in VALUE_START:
        return None
    if kind == "COLON" and before.type == "ELSE":
        return f.error("E014", "no `:` stands after `else`", hint="leave it out", edit=f.instead(""))
    if kind in ("THEN", "ELSE", "ELSE_IF") and f.inner not in ("IF", "THEN"):
        return f.error("E014", f"`{f.found.text}` without `if`", hint="write `if c then a else b`")
    got = "" if kind in ("$END", "_SEP") else f", before {describe(f.found)}"
    return f.error("E007", f"a value is missing {after}{got}", "value expected")


def conditional(f: Failure) -> Diagnostic | None:
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
        return f.error("E014", f"`{f.found.text}` without `if`", hint="write `if c then a else b`")
    return None


def condition_last(f: Failure) -> Diagnostic | None:
    """`5 if c else 2`, as Python has it."""
    if f.found.type != "IF" or not f.after_value:
        return None
    first = _start_of(f, _VALUE_BEGINS)
    middle = _at_depth(f, f.at + 1, ("ELSE",))
    end = _at_depth(f, middle + 1, ("_COMMA", "_SEP", "$END", *CLOSING))

    def text(start: int, stop: int) -> str:
        return f.tokens[start].span.to(f.tokens[stop - 1].span).text

    if f.tokens[middle].type != "ELSE":
        return f.error("E014", "the condition of an `if` stands first", hint="write `if c then a else b`")

    ours = f"if {text(f.at + 1, middle)} then {text(first, f.at)} else {text(middle + 1, end)}"
    edit = Edit(f.tokens[first].span.to(f.tokens[end - 1].span), ours)
    return f.error("E014", "the condition of an `if` stands first", "a value ends before it", f"write `{ours}`", edit)


def _at_depth(f: Failure, start: int, kinds: tuple[str, ...]) -> int:
    """The first token from `start` on, in no bracket that opens there, of one of these kinds; the last if none is."""
    depth = 0
    for i in range(start, len(f.tokens)):
        kind = f.tokens[i].type
        if depth == 0 and kind in kinds:
            return i
        depth += (kind in OPENING) - (kind in CLOSING)
    return len(f.tokens) - 1


def comprehension(f: Failure) -> Diagnostic | None:
    kinds = [t.type for t in f.tokens[: f.at]]
    form = "write `[for i in range(6): value]`, or with a filter `[for i in range(6) if i != 3: value]`"
    if f.found.type == "FOR":
        where = "first in its list: `[for i in range(6): value]`" if f.inner == "LBRACK" else "in a list"
        return f.error("E026", f"`for` stands {where}", hint=form)
    if f.before.type == "FOR" or (f.before.type == "NAME" and f.at > 1 and kinds[-2] == "FOR"):
        if f.found.type in KEYWORDS and f.before.type == "FOR":
            return reserved(f, "the name of a variable")
        return f.error(
            "E026",
            "a name and `in` stand after `for`",
            f"{'a name' if f.before.type == 'FOR' else '`in`'} expected",
            form,
        )
    brackets = [t for t in f.within if t.type in OPENING]
    if brackets and brackets[-1].type == "LBRACK" and f.inner in ("LBRACK", "IF") and not f.value_wanted:
        opened = f.tokens.index(brackets[-1])
        if f.tokens[opened + 1].type == "FOR" and "COLON" not in kinds[opened:]:
            if f.found.type == "WHERE":
                return f.error("E026", "a filter begins with `if`", "`if` expected", form, f.instead("if"))
            if f.found.type == "_COMMA":
                nested = "write `[for i in range(6) for j in range(i): value]`, without a comma"
                return f.error("E026", "`:` or another `for` stands here", "`:` expected", nested)
            return f.error("E026", "`:` is missing before the value", "`:` expected", form, f.insert(":"))
        if f.tokens[opened + 1].type == "FOR" and f.found.type == "_COMMA":
            return f.error(
                "E026", "a list made by `for` has one value", hint="write `[for i in range(6): [a, b, c]]` for several"
            )
    return None


def misplaced(f: Failure) -> Diagnostic | None:
    kind, inner = f.found.type, f.inner
    if kind == "ARROW":
        return f.error(
            "E017",
            "a function among operators stands in parentheses",
            hint="write `(t => ...)`, with a name left of `=>`",
        )
    if kind == "DOTS":
        hint = "a range stands after `in` of a param, and as an argument of a call"
        return f.error("E013", "a range cannot stand here", hint=hint)
    inch = kind == "IN" and f.before.type == "NUMBER" and f.before.text[-1] in "0123456789."
    if inch and f.tokens[f.at + 1].type not in VALUE_START:
        edit = Edit(Span(f.before.span.source, f.before.span.end, f.found.span.start), "")
        return f.error("E002", "a unit touches its number", hint=f"write `{f.before.text}in`", edit=edit)
    if kind == "IN":
        return f.error(
            "E029", "`in` cannot stand here", hint="it belongs to `param w = 30 in 10..60` and `[for i in range(3): i]`"
        )
    if kind in STATEMENTS and f.after_value:
        if inner == "LBRACE":
            return f.error(
                "E025", "the bindings of a block stand on their own lines", hint="put `;` between", edit=f.insert(";")
            )
        return f.error("E020", "a statement starts on a line of its own", hint="begin a new line", edit=f.insert("\n"))
    if kind == "RBRACE" and f.after_value:
        hint = "a block is `{ let k = ...; value }`"
        return f.error("E025", "this block has no value", "a value expected before `}`", hint)
    if inner == "LBRACE" and f.before.type == "_SEP":
        hint = "a block is `{ let k = ...; value }`; only the last line is its value"
        return f.error("E025", "a block has one value, at its end", hint=hint)
    if (
        kind == "COLON"
        and inner == "LPAR"
        and f.before.type == "NAME"
        and f.tokens[f.at - 2].type in ("LPAR", "_COMMA")
    ):
        return f.error(
            "E021", "an argument is named with `=`", hint=f"write `{f.before.text}=...`", edit=f.instead("=")
        )
    if kind == "_COMMA":
        if not inner and f.tokens[f.at + 1].type == "$END":
            return f.error("E021", "a comma cannot stand here", hint="leave it out", edit=f.instead(""))
        if inner == "LBRACE":
            return f.error("E021", "a comma cannot stand in a block", hint="a list is written in `[ ]`")
        if inner == "LBRACK" and f.opening_is_index:
            opened = f.within[-1]
            if opened.starts_line:
                return new_value(opened, f.tokens[f.tokens.index(opened) - 1].span)
            hint = "write `points[2]`, or `points[2].x`; a list in a call stands in parentheses, `union([a, b])`"
            return f.error("E021", "an index is one number", hint=hint)
        if not inner:
            return f.error("E021", "a comma cannot stand here", hint="write [a, b, c] for a vector or a list")
    if kind == "COLON":
        return f.error(
            "E029",
            "`:` cannot stand here",
            hint="it belongs to the kind of a parameter and to `[for i in range(3): i]`",
        )
    return None


#: What a value may begin after, and what a condition may.
_VALUE_BEGINS = ("EQUAL", "_COMMA", "ARROW", "_SEP", "COLON")
_BEGINS = (*_VALUE_BEGINS, "IF", "ELSE_IF", "CHECK", "WHERE", "AND", "OR", "NOT", "THEN")


def _start_of(f: Failure, begins: Collection[str]) -> int:
    """Where what stands before the place starts: after one of these words, or an open bracket."""
    first, depth = f.at, 0
    while first > 0:
        token = f.tokens[first - 1]
        depth += (token.type in CLOSING) - (token.type in OPENING)
        if depth < 0 or (depth == 0 and token.type in begins):
            break
        first -= 1
    return first


def within(f: Failure) -> Diagnostic | None:
    """`a in 1..2` as a condition: two comparisons."""
    if f.found.type != "IN" or not f.after_value:
        return None
    first = _start_of(f, _BEGINS)
    ends = ("_COMMA", "_SEP", "$END", "THEN", "AND", "OR", *CLOSING)
    dots = _at_depth(f, f.at + 1, ("DOTS", *ends))
    end = _at_depth(f, dots + 1, ends)
    if f.tokens[dots].type != "DOTS" or not f.at + 1 < dots < end - 1:
        return None
    value, low, high = (
        f.tokens[a].span.to(f.tokens[b - 1].span).text for a, b in ((first, f.at), (f.at + 1, dots), (dots + 1, end))
    )
    ours = f"{value} >= {low} and {value} <= {high}"
    shown = f"`{ours}`" if len(ours) < 100 else f"`... >= {low} and ... <= {high}`"
    return f.error("E029", "`in` is no comparison", "a range stands behind it", f"write {shown}",
                   Edit(f.tokens[first].span.to(f.tokens[end - 1].span), ours))  # fmt: skip


#: Words that stand between two solids elsewhere.
_WORDS = {"union": "|", "unite": "|", "intersection": "&", "intersect": "&", "difference": "\\", "subtract": "\\",
          "minus": "\\"}  # fmt: skip


def _in_binding(f: Failure) -> bool:
    """Whether the value before ends a `let` or `def` of a block."""
    for token in reversed(f.tokens[: f.at]):
        if token.type in ("_SEP", "LBRACE"):
            return False
        if token.type in ("LET", "DEF"):
            return True
    return False


def two_values(f: Failure) -> Diagnostic | None:
    if not f.after_value or f.found.type not in VALUE_START:
        return None
    before, found = f.before, f.found
    others = (Label(before.span, "this value ends here"),)
    if before.text == "lambda" and found.type == "NAME":
        return _lambda(f)
    if found.text in _WORDS and f.tokens[f.at + 1].type != "LPAR":
        sign = _WORDS[found.text]
        return Diagnostic("E008", f"solids are joined with `{sign}`, not with `{found.text}`", found.span, "", others,
                          f"write `{sign}`", f.instead(sign))  # fmt: skip
    if f.inner == "LBRACE" and _in_binding(f):
        hint = "put `;` between, or begin a new line"
        return Diagnostic("E025", "the bindings of a block stand on their own lines", found.span, "", others, hint,
                          f.insert(";"))  # fmt: skip
    if before.type == "NAME" and (theirs := habits.hint(before.text)):
        return Diagnostic("E037", f"`{before.text}` is not a word of Pore", before.span, hint=theirs)
    if before.type == "NUMBER" and found.type == "NAME" and found.text in UNITS and before.text[-1] in "0123456789.":
        edit = Edit(Span(before.span.source, before.span.end, found.span.start), "")
        return f.error("E002", "a unit touches its number", hint=f"write `{before.text}{found.text}`", edit=edit)
    number = before.type == "NUMBER" and before.text[-1] in "0123456789."
    if number and found.text in {*ELSEWHERE, *WITHOUT} and not is_bound(found.text, found.span.source.text):
        return unknown_unit(before.span.to(found.span), before.text, found.span)
    if before.text.endswith("%"):
        edit = Edit(before.span, before.text[:-1] + " % ")
        hint = f"`{before.text}` is a percentage; for the remainder write `{before.text[:-1]} % {found.text}`"
        return Diagnostic("E008", "an operator is missing between two values", found.span, "", others, hint, edit)
    if f.inner in ("LPAR", "LBRACK", "SET") and found.type != "LBRACE":
        hint = "put a comma between two values, or an operator"
        return Diagnostic("E008", "a comma or an operator is missing", found.span, "", others, hint, f.insert(","))
    if before.type == "NAME" and found.type in ("NUMBER", "STRING") and f.within == []:
        call = f"{before.text}({found.text})"
        hint = f"a function is called with parentheses: `{call}`"
        return Diagnostic("E008", "an operator or parentheses are missing between two values", found.span, "", others,
                          hint, Edit(before.span.to(found.span), call))  # fmt: skip
    simple = found.type in ("NAME", "NUMBER") and before.type in ("NAME", "NUMBER")
    hint = "put an operator between: `*` multiplies, `|` joins solids, `&` intersects them"
    if simple:
        hint = f"for a product write `{before.text}*{found.text}`"
    product = f.insert(" *") if simple else None
    return Diagnostic("E008", "an operator is missing between two values", found.span, "", others, hint, product)


def _lambda(f: Failure) -> Diagnostic:
    """`lambda t: t + 1`, as Python has it."""
    word = f.before
    names: list[str] = []
    at = f.at
    while f.tokens[at].type == "NAME":
        names.append(f.tokens[at].text)
        at += 2 if f.tokens[at + 1].type == "_COMMA" else 1
    head = names[0] if len(names) == 1 else f"({', '.join(names)})"
    colon = f.tokens[at]
    edit = Edit(word.span.to(colon.span), f"{head} =>") if colon.type == "COLON" else None
    return Diagnostic(
        "E017", "`lambda` is not a word of Pore", word.span, hint=f"a function is written `{head} => ...`", edit=edit
    )
