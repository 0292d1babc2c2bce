"""The call that a place stands in: what it takes, and which argument is being written. Read from the tokens, as what is
being written can seldom be parsed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from porelang.assist.names import value_of, visible
from porelang.assist.shown import Signature, signature
from porelang.elaborate.values import Record, Value, as_vector
from porelang.session import Snapshot
from porelang.syntax import tree
from porelang.syntax.tokens import CLOSING, OPENING, LexedToken


@dataclass(frozen=True, slots=True)
class Within:
    """The call around a place: the name of what is called (`plates.ring`), at which argument the place is, counted from
    0 with what is piped, the names that arguments were given by, and the name of the one at hand, if it has one."""

    name: str
    argument: int
    given: tuple[str, ...]
    named: str = ""


def before(snapshot: Snapshot, offset: int) -> list[LexedToken]:
    """The tokens that begin before a place, without remarks."""
    return [t for t in snapshot.tokens if t.start < offset and t.type not in ("COMMENT", "DOC")]


def call_around(snapshot: Snapshot, offset: int) -> Within | None:
    """The innermost call whose arguments hold a place; None where there is none."""
    tokens = before(snapshot, offset)
    depth, argument, named = 0, 0, ""
    given: list[str] = []
    for i in range(len(tokens) - 1, -1, -1):
        kind = tokens[i].type
        if kind in CLOSING:
            depth += 1
        elif kind in OPENING:
            if depth:
                depth -= 1
            elif kind == "LPAR" and i and tokens[i - 1].type == "NAME":
                name, first = _called(tokens, i - 1)
                piped = first > 0 and tokens[first - 1].type == "PIPE"
                return Within(name, argument + piped, tuple(reversed(given)), named)
            else:  # of a list or a group within the call
                argument, given, named = 0, [], ""
        elif depth == 0:
            if kind == "_COMMA":
                argument += 1
            elif kind == "EQUAL" and i and tokens[i - 1].type == "NAME":
                given.append(tokens[i - 1].text)
                named = named or ("" if argument else tokens[i - 1].text)
            elif kind in ("LET", "DEF", "OUT", "PARAM", "CHECK", "USE"):
                return None
    return None


def _called(tokens: list[LexedToken], last: int) -> tuple[str, int]:
    """The name of what is called, members and all, and where it begins."""
    first = last
    while first >= 2 and tokens[first - 1].type == "DOT" and tokens[first - 2].type == "NAME":
        first -= 2
    return "".join(t.text for t in tokens[first : last + 1]), first


def signature_at(snapshot: Snapshot, offset: int) -> tuple[Signature, int] | None:
    """How what is called around a place is called, and which parameter is being written; None where there is no call,
    or nothing known is called."""
    within = call_around(snapshot, offset)
    found = None if within is None else signature_of(snapshot, offset, within.name)
    if within is None or found is None:
        return None
    names = [p.name for p in found.parameters]
    at = names.index(within.named) if within.named in names else found.place(within.argument)
    return found, min(at, max(len(names) - 1, 0))


def signature_of(snapshot: Snapshot, offset: int, name: str) -> Signature | None:
    """How the function of a name is called: of the file, of one that it uses, or of the language."""
    first, *members = name.split(".")
    bound = visible(snapshot, offset).get(first)
    if bound is None:
        return None
    if not members:
        return signature(bound.by if isinstance(bound.by, tree.Def) else value_of(snapshot, bound), name)
    return signature(members_of(snapshot, offset, ".".join([first, *members[:-1]])).get(members[-1]), members[-1])


def members_of(snapshot: Snapshot, offset: int, name: str) -> Mapping[str, Value | None]:
    """What can stand behind the dot of a name, and what each is, as far as that is known."""
    first, *rest = name.split(".")
    bound = visible(snapshot, offset).get(first)
    if bound is None:
        return {}
    value = value_of(snapshot, bound)
    for member in rest:
        value = value.members.get(member) if isinstance(value, Record) else None
    if isinstance(value, Record):
        return value.members
    return {} if value is None or as_vector(value) is None else {"x": None, "y": None, "z": None}
