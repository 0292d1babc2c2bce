"""`parse`: from a source text to its syntax tree and all that is wrong with its syntax.

The text is lexed once and split at the ends of its statements; each statement is parsed by itself, so that every bad
one is reported and every good one is kept. Nothing here recurses: how deep a program nests is checked, not suffered.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from porelang import resources
from porelang.diagnostics import Diagnostic, Edit, Label, PoreError
from porelang.once import once
from porelang.source import Home, Piece, Source, Span
from porelang.syntax import tree
from porelang.syntax.builder import Bare, Builder
from porelang.syntax.failure import Failure
from porelang.syntax.foreign import comment_at, foreign_comment, foreign_symbol
from porelang.syntax.mistakes import explain
from porelang.syntax.mistakes.statements import check_in_parentheses
from porelang.syntax.tables import pack, unpack
from porelang.syntax.tokens import LEXER_ONLY, LexedToken, RawStatement, Token, split_statements, tokenize

if TYPE_CHECKING:
    import lark

GRAMMAR = "grammar/pore.lark"
LARGEST = 1_000_000  # characters of a source
BLANKS = " \t\r\f\v\u00a0\ufeff"  # what the grammar takes no notice of
DEEPEST = 800  # nodes on a path through a statement's tree, so that its readers may recurse
MOST = 50  # diagnostics of one source


class KeepAll:
    """Has the lexer keep the terminals that no rule names; `tokens` takes them out."""

    always_accept = LEXER_ONLY

    def process(self, stream: Iterator[lark.Token]) -> Iterator[lark.Token]:
        return stream


class Reading:
    """What was read of a file before: the statement of each text. A statement is what its own text says, so that of
    a file that was edited only those are parsed that were. What is met again is the same object, and lies where it lies
    now.
    """

    def __init__(self) -> None:
        self._statements: dict[tuple[str, str], list[_Read]] = {}
        self._met: dict[tuple[str, str], list[_Read]] = {}

    def statement(self, raw: RawStatement) -> _Read:
        """What the tokens of a statement say. Errors: those of its syntax."""
        first, last = raw.tokens[0].span, raw.tokens[-1].span
        text = first.source.text[first.start : last.end]
        key = text, raw.tokens[0].doc
        same, met = self._statements.get(key, []), self._met.setdefault(key, [])
        if len(met) < len(same):
            read = same[len(met)]
            read.piece.moves(first.source, first.start)
        else:
            read = _read(raw, Piece(first.source.name, text, first.source.prelude, Home(first.source, first.start)))
        met.append(read)
        return read

    def end(self) -> None:
        """The text has been read to its end: what was not met in it is forgotten."""
        self._statements, self._met = self._met, {}


@dataclass(frozen=True, slots=True)
class _Read:
    """A statement that was read, as a piece of its file; `bare` if it is an expression alone."""

    statement: tree.Statement
    piece: Piece
    bare: bool


def parse(
    source: Source, start: int = 0, end: int | None = None, reading: Reading | None = None
) -> tuple[tree.File, list[Diagnostic]]:
    """The statements of a source that could be read, and one diagnostic for each that could not (50 at most).

    `start..end` is the part of the text to be read, by characters: a whole number of statements. `reading` is what was
    read of the same file before, and is brought up to date.
    """
    if len(source.text) > LARGEST:
        message = f"this file is too large: {len(source.text)} characters, where {LARGEST} are read"
        hint = "share definitions with `use`"
        return tree.File(source, ()), [Diagnostic("E028", message, Span(source, 0, 0), hint=hint)]
    statements: list[tree.Statement] = []
    diagnostics: list[Diagnostic] = []
    habits: list[Diagnostic] = []  # what the statements beside are read in spite of
    tokens: list[Token] = []
    after = 0  # the end of a `/* */`
    reading = reading or Reading()
    for token in tokenize(source, lexed(source.text[start:end], start)):
        if token.span.start < after:
            continue
        if token.type == "FOREIGN" and token.text == "/*":
            habits.append(foreign_comment(token.span))
            after = token.span.start + len(comment_at(token.span))
        elif token.type == "FOREIGN" and token.text.startswith("//"):
            habits.append(foreign_symbol(token.type, token.span))
        else:
            tokens.append(token)
    for raw, following in _followed(split_statements(tokens)):
        try:
            if raw.tokens:
                statements.append(_statement(raw, following, reading))
        except PoreError as error:
            diagnostics.extend(error.diagnostics)
        if raw.error_after is not None:
            habits.append(raw.error_after)
        if len(diagnostics) >= MOST:
            break
    reading.end()
    return tree.File(source, tuple(statements)), _told_once(sorted([*diagnostics, *habits], key=_start))[:MOST]


def build(text: str, *, strict: bool = False) -> lark.Lark:
    """The parser of a grammar text; `strict` refuses any conflict (and needs the package `interegular`)."""
    import lark

    return lark.Lark(
        text, parser="lalr", lexer="basic", start="file", postlex=KeepAll(), transformer=Builder(), strict=strict
    )


@once
def parser() -> lark.Lark:
    """The parser, from the tables in the package; the import of lark waits until something has to be parsed."""
    text = resources.read(GRAMMAR)
    return unpack(text, transformer=Builder(), postlex=KeepAll()) or build(text)


def tables() -> str:
    """The text of `grammar/pore.lalr.json` as it has to be: the tables of the grammar."""
    text = resources.read(GRAMMAR)
    return pack(build(text), text)


def lexed(text: str, offset: int = 0, comments: bool = False) -> Iterator[LexedToken]:
    """The tokens of a text that begins at a character of its file, line ends too; with `comments` these as well, as
    tokens called COMMENT. Documentation is a token always."""
    for line in text.split("\n"):
        end = 0
        for kind, said, start in _of_line(line):
            yield LexedToken(kind, said, offset + start)
            end = start + len(said)
        rest = line[end:]
        if comments and rest.lstrip(BLANKS).startswith("#"):
            said = rest.lstrip(BLANKS).rstrip(BLANKS)
            yield LexedToken("COMMENT", said, offset + end + rest.index("#"))
        offset += len(line)
        yield LexedToken("NEWLINE", "\n", offset)
        offset += 1


@lru_cache(20_000)
def _of_line(line: str) -> tuple[LexedToken, ...]:
    """The tokens of a line; none goes beyond it. They are remembered, as most lines stay when a file is edited."""
    thread: Any = parser().parse_interactive(line).lexer_thread
    return tuple(LexedToken(t.type, str(t), t.start_pos or 0) for t in thread.lex(None)) if line else ()


def _told_once(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """A habit (`;` at the ends of lines, `//` before comments) is one mistake, told where it is first seen."""
    places: dict[tuple[str, str, str], list[Diagnostic]] = {}
    for d in diagnostics:
        if d.code in ("E001", "E020"):
            places.setdefault((d.code, d.message, d.hint), []).append(d)
    out: list[Diagnostic] = []
    for d in diagnostics:
        same = places.get((d.code, d.message, d.hint), [d])
        if d is not same[0]:
            continue
        if len(same) > 1 and same[1].span is not None:
            more = f", and in {len(same) - 2} more places" if len(same) > 2 else ""
            d = replace(d, others=(*d.others, Label(same[1].span, f"and here{more}")))
        out.append(d)
    return out


def _start(diagnostic: Diagnostic) -> int:
    return diagnostic.span.start if diagnostic.span else 0


def _followed(statements: Iterator[RawStatement]) -> Iterator[tuple[RawStatement, Token | None]]:
    """Each statement with the first token of the next one that has any."""
    waiting: RawStatement | None = None
    for raw in statements:
        if not raw.tokens:
            yield raw, None
            continue
        if waiting is not None:
            yield waiting, raw.tokens[0]
        waiting = raw
    if waiting is not None:
        yield waiting, None


def _statement(raw: RawStatement, following: Token | None, reading: Reading) -> tree.Statement:
    if raw.error is not None:
        raise PoreError(raw.error)
    read = reading.statement(raw)
    if read.bare and following is not None:
        raise PoreError(_not_last(read.statement, following))
    return read.statement


def _read(raw: RawStatement, piece: Piece) -> _Read:
    """A statement whose places are those of its piece. Errors: those of its syntax, at places of the file."""
    if (told := check_in_parentheses(raw.tokens)) is not None:
        raise PoreError(told)
    begins = piece.begins
    tokens = [t._replace(span=Span(piece, t.span.start - begins, t.span.end - begins)) for t in raw.tokens]
    try:
        statement: tree.Statement | Bare = _parsed(tokens)
    except PoreError:
        _parsed(raw.tokens)  # what is said of a mistake may look beyond the statement
        raise
    if len(raw.tokens) > DEEPEST and _is_deep(statement):
        hint = "name the inner parts with `let`"
        raise PoreError(Diagnostic("E027", "this statement is nested too deeply", raw.tokens[0].span, hint=hint))
    if isinstance(statement, Bare):
        start = Span(piece, statement.span.start, statement.span.start)
        return _Read(tree.Out(statement.span, "part", start, statement.value), piece, True)
    return _Read(statement, piece, False)


def _parsed(tokens: list[Token]) -> Any:
    from lark import UnexpectedToken

    state: Any = parser().parse_interactive()
    last = tokens[-1].span
    ended = [*tokens, Token("$END", "", Span(last.source, last.end, last.end), False)]
    for i, token in enumerate(ended):
        try:
            result = state.feed_token(token)
        except UnexpectedToken as error:
            raise PoreError(explain(Failure(ended, i, error.expected))) from None
    return result[0]


def _not_last(statement: tree.Statement, following: Token) -> Diagnostic:
    start = statement.span.start
    place = Span(statement.span.source, start, start)
    if following.type in ("MINUS", "TILDE", "LPAR", "LBRACK"):
        hint = f"a line that starts with `{following.text}` starts anew; to go on, put it at the end of the line before"
    else:
        hint = "give it a name: `let a = ...`, or `out a = ...` for a result"
    message = "this value is not used: only the last expression of a file is its part"
    return Diagnostic(
        "E018", message, statement.span, "no name is given to it", hint=hint, edit=Edit(place, "let a = ")
    )


def _is_deep(statement: Any) -> bool:
    """Whether a path of more than `DEEPEST` nodes leads through the tree."""
    todo: list[tuple[Any, int]] = [(statement, 1)]
    while todo:
        node, depth = todo.pop()
        if isinstance(node, tuple):
            todo.extend((part, depth) for part in node if not isinstance(part, str | Span))
        elif is_dataclass(node) and not isinstance(node, Span):
            if depth > DEEPEST:
                return True
            todo.extend((getattr(node, f.name), depth + 1) for f in fields(node))
    return False
