"""From characters to statements: the tokens of a source, and where its statements begin and end.

A line end ends a statement, except inside `( )` and `[ ]`, after a binary operator, `=`, `,` and their kin, and before
a line that starts with a binary operator. Inside `{ }` it separates. A bracket that is never closed, or a character
that means nothing, costs its own statement: each statement is parsed by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.source import Source, Span
from porelang.syntax.foreign import foreign_symbol, is_space

NESTING = 200  # brackets within brackets

# Terminals that the lexer yields and no rule of the grammar names.
FOREIGN = frozenset({"FOREIGN", "UNCLOSED", "JUNK"})
LEXER_ONLY = ("NEWLINE", "SEMICOLON", "DOC", *sorted(FOREIGN))

STATEMENTS = frozenset({"USE", "PARAM", "LET", "DEF", "OUT", "CHECK"})
OPENING = {"LPAR": "RPAR", "LBRACK": "RBRACK", "LBRACE": "RBRACE", "SET": "RBRACE"}
CLOSING = frozenset(OPENING.values())

OPERATORS = frozenset(
    ("COMPARE", "PIPE", "BAR", "AMP", "BACKSLASH", "PLUS", "STAR", "SLASH", "PERCENT", "CARET", "AT", "AND", "OR")
)
BINARY = OPERATORS | {"MINUS"}
_BOTH_SIDES = OPERATORS | {
    *("EQUAL", "ARROW", "_COMMA", "COLON", "DOTS", "DOT"),
    *("THEN", "ELSE", "ELSE_IF", "IN", "WHERE"),
}
# After these a line goes on ...
UNFINISHED = _BOTH_SIDES | {"MINUS", "TILDE", "NOT", "IF", "FOR", "LBRACE", "SET", "LPAR", "LBRACK"}
# ... and a line that starts with one of these goes on with the line before. (`-` `~` `(` `[` start anew.)
CONTINUING = _BOTH_SIDES | CLOSING

# A value can end with these; what stands after them is an operator, a bracket or the end.
VALUE_END = frozenset({"NAME", "NUMBER", "STRING", "TRUE", "FALSE", *CLOSING})
VALUE_START = frozenset({"NAME", "NUMBER", "STRING", "TRUE", "FALSE", "LPAR", "LBRACK", "LBRACE", "NOT", "IF"})


class Token(NamedTuple):
    """A token of the source; `starts_line` if it is the first on its line, `doc` the `##` lines right above it."""

    type: str
    text: str
    span: Span
    starts_line: bool
    doc: str = ""


@dataclass(slots=True)
class RawStatement:
    """The tokens of one statement; `error` if it need not be parsed; `error_after` of what stands after it."""

    tokens: list[Token] = field(default_factory=list)
    error: Diagnostic | None = None
    error_after: Diagnostic | None = None


class LexedToken(NamedTuple):
    """What is needed of a token of the lexer: its terminal, its text and where it starts."""

    type: str
    text: str
    start: int


def tokenize(source: Source, lexed: Iterable[LexedToken]) -> Iterator[Token]:
    """The tokens of a source without its line ends; documentation is handed to the token it stands before."""
    starts_line = True
    doc: list[str] = []
    line_ends = 1  # since the last token
    for kind, text, start in lexed:
        if kind == "NEWLINE":
            starts_line = True
            line_ends += len(text)
            continue
        if kind == "JUNK" and is_space(text):
            continue
        if kind == "DOC":
            if starts_line:
                doc = doc if line_ends == 1 else []
                doc.append(text)
                line_ends = 0
            continue
        said = ""
        if doc:
            if kind in ("DEF", "PARAM") and line_ends == 1:
                said = "\n".join(line[2:].removeprefix(" ").rstrip() for line in doc)
            doc = []
        yield Token(kind, text, Span(source, start, start + len(text)), starts_line, said)
        starts_line = False
        line_ends = 0


def split_statements(tokens: list[Token]) -> Iterator[RawStatement]:
    """The statements of a source, in order; what is not well bracketed or not a token of Pore is marked as an error."""
    raw = RawStatement()
    opened: list[Token] = []
    closed = _closed_braces(tokens)
    for i, token in enumerate(tokens):
        kind = token.type
        if token.starts_line and raw.tokens:
            last = raw.tokens[-1].type
            inner = opened[-1].type if opened else ""
            goes_on = kind not in STATEMENTS and (last in UNFINISHED or kind in CONTINUING)
            if opened and _restarts(token, opened[-1], closed):
                raw.error = raw.error or _unclosed(opened[-1], token)
                yield raw
                raw, opened = RawStatement(), []
            elif not opened and not goes_on:
                yield raw
                raw = RawStatement()
            elif inner == "LBRACE" and not goes_on:
                raw.tokens.append(token._replace(type="_SEP", text="\n", doc="", span=_empty(token)))
        if kind == "SEMICOLON" and not opened:
            raw.error_after = _semicolon(token, tokens, i)
            yield raw
            raw = RawStatement()
            continue
        token = _placed(token, raw.tokens, opened)
        kind = token.type
        if kind in OPENING:
            opened.append(token)
            if len(opened) > NESTING and raw.error is None:
                raw.error = Diagnostic(
                    "E027",
                    f"brackets are nested more than {NESTING} levels deep",
                    token.span,
                    hint="name the inner parts with `let`",
                )
        elif kind in CLOSING:
            raw.error = raw.error or _mismatch(token, opened)
            _close(token, opened)
        elif kind in FOREIGN:
            raw.error = raw.error or foreign_symbol(token.type, token.span)
            if kind == "UNCLOSED":  # it took the rest of its line, brackets and all
                opened = []
        if kind == "ELSE_IF":
            raw.tokens[-1] = token
        else:
            raw.tokens.append(token)
    if opened:
        raw.error = raw.error or _unclosed(opened[-1], None)
    if raw.tokens:
        yield raw


def _placed(token: Token, before: list[Token], opened: list[Token]) -> Token:
    """The token as its place makes it: `else if` is one word, `as` and `step` are words only where they fit, and so is
    `preset`: before a text."""
    if token.type == "STRING" and len(before) == 1 and before[0].type == "NAME" and before[0].text == "preset":
        before[0] = before[0]._replace(type="PRESET")
    if not before:
        return token
    kind, last, head = token.type, before[-1], before[0].type
    if kind == "IF" and last.type == "ELSE":
        return token._replace(
            type="ELSE_IF", text="else if", span=last.span.to(token.span), starts_line=last.starts_line
        )
    if kind == "LBRACE" and last.type == "IN" and head == "PARAM":
        return token._replace(type="SET")
    if kind == "SEMICOLON":
        return token._replace(type="_SEP")
    if kind != "NAME":
        return token
    if token.text == "as" and head == "USE" and last.type == "STRING":
        return token._replace(type="AS")
    if token.text == "step" and head == "PARAM" and not opened and last.type in VALUE_END and len(before) > 2:
        return token._replace(type="STEP")
    return token


def _restarts(token: Token, opened: Token, closed: frozenset[int]) -> bool:
    """Whether a statement in column 1 shows that the bracket before it was left open by mistake."""
    if token.type not in STATEMENTS or not _in_first_column(token):
        return False
    # `{` and then `let` in column 1 may be a block that is not indented: it is if its `}` comes.
    in_block = opened.type == "LBRACE" and token.type in ("LET", "DEF")
    return not (in_block and opened.span.start in closed)


def _closed_braces(tokens: list[Token]) -> frozenset[int]:
    """Where the `{` stand whose `}` comes before the next statement that cannot stand in a block."""
    opened: list[int] = []
    closed: set[int] = set()
    for token in tokens:
        if token.type == "LBRACE":
            opened.append(token.span.start)
        elif token.type == "RBRACE":
            if opened:
                closed.add(opened.pop())
        elif (
            token.type in STATEMENTS
            and token.type not in ("LET", "DEF")
            and token.starts_line
            and _in_first_column(token)
        ):
            opened.clear()
    return frozenset(closed)


def _in_first_column(token: Token) -> bool:
    start, text = token.span.start, token.span.source.text
    return start == 0 or text[start - 1] in "\n\ufeff"


def _close(token: Token, opened: list[Token]) -> None:
    # deeper than brackets may nest there is nothing to save, and looking through it all would take hours
    for depth in range(len(opened) - 1, max(-1, len(opened) - 2 * NESTING), -1):
        if OPENING[opened[depth].type] == token.type:
            del opened[depth:]
            return


def _empty(token: Token) -> Span:
    return Span(token.span.source, token.span.start, token.span.start)


# ---- what can be wrong before anything is parsed


def _unclosed(opened: Token, restart: Token | None) -> Diagnostic:
    want = {"LPAR": ")", "LBRACK": "]"}.get(opened.type, "}")
    where = "the end of the file" if restart is None else "the next statement"
    others = () if restart is None else (Label(restart.span, "the next statement starts here"),)
    return Diagnostic(
        "E005",
        f"`{opened.text}` is never closed",
        opened.span,
        "opened here",
        others,
        hint=f"a `{want}` is missing before {where}",
    )


def _mismatch(token: Token, opened: list[Token]) -> Diagnostic | None:
    if not opened:
        return Diagnostic(
            "E006",
            f"`{token.text}` closes nothing",
            token.span,
            "no bracket is open here",
            hint=f"leave out the `{token.text}`, or open its bracket before",
            edit=Edit(token.span, ""),
        )
    want = OPENING[opened[-1].type]
    if want == token.type:
        return None
    sign = {"RPAR": ")", "RBRACK": "]", "RBRACE": "}"}[want]
    closes_another = any(OPENING[o.type] == token.type for o in opened[-NESTING:-1])
    place, ours, hint = token.span, sign, f"write `{sign}`"
    if closes_another:
        place, hint = _empty(token), f"a `{sign}` is missing before the `{token.text}`"
    elif token.span.source.text[token.span.end :].lstrip().startswith(sign):
        ours, hint = "", f"leave out the `{token.text}`"
    return Diagnostic(
        "E006",
        f"`{token.text}` does not close `{opened[-1].text}`",
        token.span,
        f"`{sign}` expected",
        (Label(opened[-1].span, "opened here"),),
        hint=hint,
        edit=Edit(place, ours),
    )


def _semicolon(token: Token, tokens: list[Token], at: int) -> Diagnostic:
    last = at + 1 == len(tokens) or tokens[at + 1].starts_line
    return Diagnostic(
        "E020",
        "a line end ends a statement, not `;`",
        token.span,
        hint="leave out the `;`" if last else "put the next statement on a line of its own",
        edit=Edit(token.span, "" if last else "\n"),
    )
