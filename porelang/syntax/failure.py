"""Where the parser stops in a statement, and what is known of that place: what a diagnostic is made from."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.source import Span
from porelang.syntax.tokens import CLOSING, OPENING, STATEMENTS, VALUE_END, Token

KEYWORDS = STATEMENTS | {"IF", "THEN", "ELSE", "ELSE_IF", "FOR", "IN", "WHERE", "AND", "OR", "NOT", "TRUE", "FALSE"}


@dataclass(frozen=True)
class Failure:
    """The tokens of a statement, which of them does not fit (the last is the end), and what would fit there."""

    tokens: list[Token]
    at: int
    expected: Collection[str]

    @property
    def found(self) -> Token:
        return self.tokens[self.at]

    @property
    def before(self) -> Token:
        return self.tokens[self.at - 1] if self.at else self.found

    @property
    def head(self) -> Token:
        return self.tokens[0]

    @property
    def value_wanted(self) -> bool:
        return "NUMBER" in self.expected

    @property
    def after_value(self) -> bool:
        return self.at > 0 and self.before.type in VALUE_END and not self.value_wanted

    @cached_property
    def within(self) -> list[Token]:
        """What is open at the place: brackets, and the last keyword of each `if` that has no `else` yet."""
        opened: list[Token] = []
        for token in self.tokens[: self.at]:
            kind = token.type
            if kind in OPENING or kind == "IF":
                opened.append(token)
            elif kind in CLOSING:
                while opened and opened[-1].type not in OPENING:
                    opened.pop()
                opened = opened[:-1]
            elif opened and (kind, opened[-1].type) in (("THEN", "IF"), ("THEN", "ELSE_IF"), ("ELSE_IF", "THEN")):
                opened[-1] = token
            elif kind == "ELSE" and opened and opened[-1].type == "THEN":
                opened.pop()
        return opened

    @property
    def inner(self) -> str:
        return self.within[-1].type if self.within else ""

    @property
    def opening_is_index(self) -> bool:
        """Whether the innermost open bracket is the `[` of an index."""
        opened = self.tokens.index(self.within[-1])
        return self.within[-1].type == "LBRACK" and opened > 0 and self.tokens[opened - 1].type in VALUE_END

    def opening(self, at: int) -> int:
        """Where the bracket opens that the token `at` closes; -1 if it closes none."""
        depth = 0
        for i in range(at, -1, -1):
            depth += (self.tokens[i].type in CLOSING) - (self.tokens[i].type in OPENING)
            if depth == 0:
                return i if i < at else -1
        return -1

    @property
    def gap(self) -> Span:
        """The empty place right after the last token that fitted."""
        return Span(self.found.span.source, self.before.span.end, self.before.span.end)

    def error(self, code: str, message: str, label: str = "", hint: str = "", edit: Edit | None = None) -> Diagnostic:
        return Diagnostic(code, message, self.found.span, label, hint=hint, edit=edit)

    def insert(self, text: str) -> Edit:
        return Edit(self.gap, text)

    def instead(self, text: str) -> Edit:
        return Edit(self.found.span, text)


def describe(token: Token) -> str:
    """A token of the source in a sentence."""
    shown = token.text if len(token.text) <= 40 else token.text[:37] + "..."
    match token.type:
        case "$END":
            return "the end of the statement"
        case "_SEP":
            return "the end of the line" if token.text == "\n" else "`;`"
        case "NUMBER":
            return f"the number `{shown}`"
        case "NAME":
            return f"the name `{shown}`"
        case "STRING":
            return f"the text {shown}"
    return f"the word `{shown}`" if token.type in KEYWORDS else f"`{shown}`"


def new_value(opened: Token, before: Span) -> Diagnostic:
    """Of a `(` or `[` that begins a line inside brackets: it would call or index the value before it."""
    return Diagnostic(
        "E008",
        f"a `{opened.text}` at the start of a line begins a new value",
        opened.span,
        others=(Label(before, "this value ends here"),),
        hint=f"put a comma between the two, or the `{opened.text}` on the line before",
        edit=Edit(Span(before.source, before.end, before.end), ","),
    )


def reserved(f: Failure, what: str) -> Diagnostic:
    """Of a keyword where a name has to stand; `what` says which name."""
    text = f.found.text
    hint = f"choose another name, `{text}_` for one"
    return f.error(
        "E010", f"`{text}` is a word of the language and cannot be {what}", hint=hint, edit=f.instead(text + "_")
    )
