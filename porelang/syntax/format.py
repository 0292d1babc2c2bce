"""One style for `.pore` files, as `pore fmt` writes it.

Where lines end is the writer's choice; what lies between the tokens of a line, how far it is indented, and how docs and
remarks stand under one another is not. Every remark stays, and every group of lines: more than one empty line between
two groups becomes one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import groupby

from porelang.diagnostics import PoreError
from porelang.source import Source, Span
from porelang.syntax.parse import lexed, parse
from porelang.syntax.tokens import CONTINUING, OPENING, STATEMENTS, UNFINISHED, VALUE_END, LexedToken

#: How far a line is indented below the one that it belongs to; what stands before a doc or a remark behind a line.
STEP, BESIDE = 2, 2
#: Docs and remarks are put under one another where no line is longer than the next by more than this.
UNEVEN = 30
_TIGHT_AFTER = frozenset({"LPAR", "LBRACK", "SET", "DOT", "DOTS"})
_TIGHT_BEFORE = frozenset({"RPAR", "RBRACK", "_COMMA", "SEMICOLON", "DOT", "DOTS", "COLON"})


def formatted(source: Source) -> str:
    """The text of a program in the one style. What it means stays the same, as comparing both trees shows.

    Errors: `PoreError` with all mistakes of its syntax: a text that cannot be read is not touched.

    >>> formatted(Source("a.pore", "let  a=f( x,y )   # why"))
    'let a = f(x, y)  # why\\n'
    """
    file, found = parse(source)
    if found:
        raise PoreError(found)
    text = _text(source.text)
    if "\r\n" in source.text:  # lines end as they did, on Windows
        text = text.replace("\n", "\r\n")
    again, wrong = parse(Source(source.name, text))
    if wrong or not _same(file.statements, again.statements):
        raise AssertionError("formatting has changed what the text means")
    return text


def _text(text: str) -> str:
    lines = [_Line(row) for row in _rows(text)]
    _indent(lines)
    _line_up(lines)
    out: list[str] = []
    for line in lines:
        if line.code or line.remark:
            out.append(line.text)
        elif out and out[-1]:
            out.append("")
    while out and not out[-1]:
        out.pop()
    return "\n".join([*out, ""]) if out else ""


def _rows(text: str) -> Iterator[list[LexedToken]]:
    """The tokens of each line, remarks and documentation too."""
    row: list[LexedToken] = []
    for token in lexed(text, comments=True):
        if token.type == "NEWLINE":
            yield row
            row = []
        else:
            row.append(token)


@dataclass(slots=True, eq=False)
class _Bracket:
    """One that is open: its terminal; how far what it stands in is indented; the column of what follows it on its line;
    of a block, the terminal that its statement begins with; whether it holds the parameters of a def."""

    type: str
    base: int
    column: int | None
    head: str = ""
    of_def: bool = False


class _Line:
    """A line: its code, without the doc of a param that ends it, that doc, and the remark behind it or alone on it."""

    def __init__(self, row: Sequence[LexedToken] = ()) -> None:
        self.code = [t for t in row if t.type not in ("COMMENT", "DOC")]
        self.remark = next((_remark(t.text) for t in row if t.type in ("COMMENT", "DOC")), "")
        self.doc = ""
        self.indent = 0
        self.doc_at = self.remark_at = 0
        self.written = ""

    @property
    def text(self) -> str:
        """The line as it is written."""
        if not self.code:
            return " " * self.indent + self.remark
        return self.without_remark.ljust(self.remark_at) + self.remark

    @property
    def without_remark(self) -> str:
        """The line as it is written, but for the remark behind it."""
        out = " " * self.indent + self.written
        return out.ljust(self.doc_at) + self.doc if self.doc else out


def _remark(text: str) -> str:
    """A remark, or a line of documentation, with a blank after its sign."""
    sign = text[: len(text) - len(text.lstrip("#"))]
    rest = text[len(sign) :].rstrip()
    return f"{sign} {rest}" if rest and rest[0] not in " \t!" and len(sign) < 3 else sign + rest


def _indent(lines: Sequence[_Line]) -> None:
    """Indent each line, and write its code, by the brackets that are open where it begins."""
    opened: list[_Bracket] = []
    last = ""  # the terminal before this line
    head = ""  # that which the statement begins with
    waiting: list[_Line] = []  # remarks alone on their lines, which go with the code below them
    for line in lines:
        if not line.code:
            waiting += [line] if line.remark else []
            continue
        first = line.code[0].type
        goes_on = _goes_on(opened, first, last)
        closes = bool(opened) and OPENING[opened[-1].type] == first
        below = goes_on and last not in ("LBRACE", "SEMICOLON")
        if opened and opened[-1].type == "LBRACE" and not closes:
            opened[-1].head = opened[-1].head if below else first
            below = below and (opened[-1].head, first) != ("IF", "ELSE")
        line.indent = _indentation(opened, closes, below)
        for remark in waiting:  # before a bracket that closes they stand with what it holds
            remark.indent = _indentation(opened, False, False) if closes else line.indent
        waiting = []
        if not opened and not goes_on:
            head = first
        _write(line, opened, last if goes_on else "", head)
        last = line.code[-1].type


def _goes_on(opened: Sequence[_Bracket], first: str, last: str) -> bool:
    """Whether a line goes on with what the one before it says."""
    if opened and opened[-1].type != "LBRACE":
        return True
    return first not in STATEMENTS and (first in CONTINUING or last in UNFINISHED)


def _indentation(opened: Sequence[_Bracket], closes: bool, goes_on: bool) -> int:
    if not opened:
        return STEP if goes_on else 0
    inner = opened[-1]
    if closes:
        return inner.base if inner.column is None else inner.column - 1
    if inner.column is not None:
        return inner.column
    return inner.base + STEP + (STEP if inner.type == "LBRACE" and goes_on else 0)


def _write(line: _Line, opened: list[_Bracket], before: str, head: str) -> None:
    """Write the code of a line, which goes on after the terminal `before`; afterwards `opened` are the brackets that
    are open at its end."""
    tokens = line.code
    last = [t.type for t in tokens[-2:]]
    if head == "PARAM" and not opened and len(last) == 2 and last[0] in VALUE_END and last[1] == "STRING":
        line.doc, tokens = tokens[-1].text, tokens[:-1]
    out, base, earlier = "", line.indent, len(opened)
    for i, token in enumerate(tokens):
        kind = "SET" if _is_set(tokens, i, before, head) else token.type
        if i and _is_apart(tokens, i, before, opened, head):
            out += " "
        if opened and OPENING[opened[-1].type] == kind:
            closed = opened.pop()
            if len(opened) < earlier:  # what follows stands in what the line stands in that opened it
                base, earlier = closed.base, len(opened)
        out += token.text
        if kind in OPENING:  # what is in a block is indented, wherever the block begins
            beside = kind != "LBRACE" and i + 1 < len(tokens)
            column = line.indent + len(out) if beside else None
            opened.append(_Bracket(kind, base, column, of_def=head == "DEF" and i == 2 and not opened))
    line.written = out


def _before(tokens: Sequence[LexedToken], i: int, before: str) -> str:
    """The terminal before a token."""
    return tokens[i - 1].type if i > 0 else before


def _is_set(tokens: Sequence[LexedToken], i: int, before: str, head: str) -> bool:
    """Whether a token opens the choices of a param."""
    return tokens[i].type == "LBRACE" and head == "PARAM" and _before(tokens, i, before) == "IN"


def _is_apart(tokens: Sequence[LexedToken], i: int, before: str, opened: Sequence[_Bracket], head: str) -> bool:
    """Whether a blank stands before a token."""
    one, other = tokens[i - 1].type, tokens[i].type
    inner = opened[-1].type if opened else ""
    if one == "LBRACE" or other == "RBRACE":
        is_set = inner == "SET" or _is_set(tokens, i - 1, before, head)
        return not is_set and {one, other} != {"LBRACE", "RBRACE"}
    if one in _TIGHT_AFTER or other in _TIGHT_BEFORE:
        return False
    if "CARET" in (one, other):  # beside `@`, which binds tighter, blanks keep `f @ q ^ 2` from looking otherwise
        return any(t.type == "AT" for t in tokens)
    if one == "TILDE" or (one == "MINUS" and _before(tokens, i - 1, before) not in VALUE_END):
        return False  # a sign
    if "EQUAL" in (one, other) and inner == "LPAR":
        return opened[-1].of_def
    return other not in ("LPAR", "LBRACK") or one not in VALUE_END


def _line_up(lines: Sequence[_Line]) -> None:
    """Put docs of params, and then remarks, of lines that follow one another under each other."""
    for run in _runs(lines, lambda line: bool(line.doc), lambda line: line.indent + len(line.written)):
        at = max(line.indent + len(line.written) for line in run) + BESIDE
        for line in run:
            line.doc_at = at
    for run in _runs(lines, lambda line: bool(line.code and line.remark), lambda line: len(line.without_remark)):
        at = max(len(line.without_remark) for line in run) + BESIDE
        for line in run:
            line.remark_at = at


def _runs(
    lines: Sequence[_Line], belongs: Callable[[_Line], bool], width: Callable[[_Line], int]
) -> Iterator[list[_Line]]:
    """The lines that belong together, in runs of such as follow one another and are about as wide."""
    for wanted, group in groupby(lines, belongs):
        run: list[_Line] = []
        for line in group if wanted else ():
            if run and abs(width(line) - width(run[-1])) > UNEVEN:
                yield run
                run = []
            run.append(line)
        if run:
            yield run


def _same(one: object, other: object) -> bool:
    """Whether two trees say the same, wherever it is written."""
    todo: list[tuple[object, object]] = [(one, other)]
    while todo:
        a, b = todo.pop()
        if type(a) is not type(b):
            return False
        if isinstance(a, Span):
            continue
        if isinstance(a, tuple) and isinstance(b, tuple):
            if len(a) != len(b):
                return False
            todo.extend(zip(a, b, strict=True))
        elif is_dataclass(a):
            todo.extend((getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
        elif a != b:
            return False
    return True
