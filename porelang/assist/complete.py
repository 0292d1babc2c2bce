"""What may stand at a place: names, arguments, members, units, files and the arrays in them, words of the language."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from porelang.assist.calls import before, call_around, members_of, signature_of
from porelang.assist.names import Bound, is_function, settable, visible
from porelang.assist.shown import signature
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.values import Record, describe
from porelang.materials import MATERIALS
from porelang.ops.strut_cells import CELLS
from porelang.session import Snapshot
from porelang.syntax import tree
from porelang.syntax.highlighting import STATEMENTS, TRUTHS, WORDS
from porelang.syntax.tokens import STATEMENTS as HEADS
from porelang.syntax.tokens import VALUE_END, LexedToken
from porelang.units import UNITS

What = Literal["function", "param", "value", "file", "argument", "member", "unit", "word", "kind", "text", "namespace"]


@dataclass(frozen=True, slots=True)
class Item:
    """What may be written instead of the characters `start..end`: `text`, shown as `label` with a line about it. What
    stands first has the lower `rank`."""

    label: str
    what: What
    text: str
    start: int
    end: int
    detail: str = ""
    doc: str = ""
    rank: int = 1


_UNIT = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?([A-Za-z%]*)$")
_WORD = re.compile(r"[A-Za-z_]\w*$")
_QUOTED = re.compile(r'"([^"\n]+)"')
_TEXT = re.compile(r'"([^"\n]*)$')
#: What ends the binding of a name in a block, and in a comprehension.
_ENDS_LET, _ENDS_FOR = frozenset({"SEMICOLON", "LET"}), frozenset({"FOR", "IF", "COLON"})
#: What files a call or a statement reads, by their endings.
_FILES = {
    "use": (".pore",),
    "load": (".vtu", ".vtk", ".vti", ".npz", ".nrrd"),
    "mesh": (".stl", ".obj", ".ply", ".3mf", ".off"),
    "frame": (".json",),
    "nearest_bar": (".json",),
    "truss": (".json",),
}


def completions(snapshot: Snapshot, offset: int, folder: str = "") -> list[Item]:
    """What may stand where a character is about to be written, the likeliest first. Files are sought beside the
    file, whose path begins in `folder`."""
    text = snapshot.source.text
    begins_at = text.rfind("\n", 0, offset) + 1
    line = text[begins_at:offset]
    if any(t.type in ("COMMENT", "DOC") and begins_at <= t.start < offset for t in snapshot.tokens):
        return []
    written = _TEXT.search(line)
    if written is not None and line.count('"') % 2:
        return list(_texts(snapshot, offset, written[1], folder))
    if (unit := _UNIT.search(line)) is not None:
        start = offset - len(unit[1])
        return [Item(u.name, "unit", u.name, start, offset, str(u.dimension)) for u in UNITS.values()]
    word = _WORD.search(line)
    start = offset - len(word[0]) if word is not None else offset
    tokens = [t for t in before(snapshot, offset) if t.start < start]
    last = tokens[-1].type if tokens else ""
    if (setting := _setting(snapshot, tokens, start)) is not None:
        return [Item(n, "param", n, setting, offset, "a param") for n in settable(snapshot)]
    if last == "DOT":
        return list(_members(snapshot, offset, tokens, start))
    if last == "COLON" and _is_declaration(tokens):
        return [Item(k.name, "kind", k.name, start, offset, k.doc) for k in KINDS.values()]
    begins = not line[: len(line) - (offset - start)].strip()
    items = [] if begins and last in VALUE_END else list(_arguments(snapshot, offset, start, last))
    items += _names(snapshot, offset, start)
    words = (*STATEMENTS, *WORDS, *TRUTHS) if begins else (*WORDS, *TRUTHS)
    items += [Item(w, "word", w, start, offset, rank=0 if begins and w in STATEMENTS else 3) for w in words]
    return sorted(items, key=lambda item: (item.rank, item.label))


def _names(snapshot: Snapshot, offset: int, start: int) -> Iterator[Item]:
    own, inner = _being_bound(snapshot, start), _locals(snapshot, start)
    for name, bound in visible(snapshot, offset).items():
        if name in inner or (name == own and bound.kind != "prelude"):  # nothing is defined by itself
            continue
        found = signature(bound.by if isinstance(bound.by, tree.Def) else bound.value, name)
        doc = found.doc.partition("\n")[0] if found is not None else ""
        detail = _detail(bound, str(found) if found else "")
        yield Item(name, _what(bound), name, start, offset, detail, doc, 2 if bound.kind == "prelude" else 1)
    for name in sorted(inner):
        yield Item(name, "value", name, start, offset, "bound in this statement", rank=0)


def _statement(snapshot: Snapshot, start: int) -> list[LexedToken]:
    """The tokens before a place of the statement that ends there."""
    tokens = before(snapshot, start)
    first = next((i for i in range(len(tokens) - 1, -1, -1) if _begins(snapshot, tokens[i])), 0)
    return tokens[first:]


def _setting(snapshot: Snapshot, tokens: list[LexedToken], start: int) -> int | None:
    """Where the name of a param begins that a preset is about to set; None where none is."""
    text = snapshot.source.text
    first = next((t for t in reversed(tokens) if t.start == 0 or text[t.start - 1] == "\n"), None)
    if first is None or first.text != "preset":
        return None
    named = tokens[:-2] if tokens[-1].type == "DOT" and len(tokens) > 2 else tokens
    begins = tokens[-2].start if named is not tokens else start
    return begins if named[-1].type in ("COLON", "_COMMA") else None


def _being_bound(snapshot: Snapshot, start: int) -> str:
    """The name that the statement at a place binds."""
    tokens = _statement(snapshot, start)
    binds = len(tokens) > 1 and tokens[0].type in HEADS and tokens[1].type == "NAME"
    another = start > 0 and snapshot.source.text[start - 1] == "\n"  # an expression in column 1
    return tokens[1].text if binds and not another else ""


def _locals(snapshot: Snapshot, start: int) -> set[str]:
    """The names that are bound in the statement that ends at a place, read from its tokens: parameters of a def or of a
    function, items of a comprehension, lets of a block."""
    tokens = _statement(snapshot, start)
    found: set[str] = set()
    in_head = len(tokens) > 2 and tokens[0].type == "DEF"
    for i, t in enumerate(tokens):
        last = tokens[i - 1].type if i else ""
        if t.type == "EQUAL" and last == "RPAR":
            in_head = False
        if t.type != "NAME":
            continue
        after = tokens[i + 1].type if i + 1 < len(tokens) else ""
        rest = {later.type for later in tokens[i + 1 :]}
        line_ends = "\n" in snapshot.source.text[t.start : start]
        if (last == "LET" and i > 1 and not line_ends and not rest & _ENDS_LET) or (
            last == "FOR" and not rest & _ENDS_FOR
        ):
            continue  # it is being bound
        if (
            last == "FOR"
            or (last == "LET" and i > 1)
            or after == "ARROW"
            or (in_head and last in ("LPAR", "_COMMA", "OR"))
        ):
            found.add(t.text)
    return found


def _begins(snapshot: Snapshot, token: LexedToken) -> bool:
    """Whether a token begins a statement in column 1."""
    text = snapshot.source.text
    return token.type in HEADS and (token.start == 0 or text[token.start - 1] == "\n")


def _what(bound: Bound) -> What:
    if is_function(bound):
        return "function"
    if bound.kind == "param":
        return "param"
    if bound.kind == "use" or isinstance(bound.value, Record):
        return "namespace"
    return "value"


def _detail(bound: Bound, called: str) -> str:
    if called:
        return called
    if bound.by is not None and not isinstance(bound.by, tree.Parameter):
        return " ".join(bound.by.span.text.split())[:80]
    if isinstance(bound.by, tree.Parameter):
        return " ".join(bound.by.span.text.split())
    return describe(bound.value) if bound.value is not None else ""


def _arguments(snapshot: Snapshot, offset: int, start: int, last: str) -> Iterator[Item]:
    """The parameters of the call at hand that have no argument yet, where one may begin."""
    within = call_around(snapshot, offset) if last in ("LPAR", "_COMMA") else None
    found = signature_of(snapshot, offset, within.name) if within is not None else None
    if within is None or found is None:
        return
    for p in found.parameters[found.place(within.argument) if not within.given else 0 :]:
        if p.name not in within.given and p.name.isidentifier():
            yield Item(f"{p.name}=", "argument", f"{p.name}=", start, offset, p.text, rank=0)


def _members(snapshot: Snapshot, offset: int, tokens: list[LexedToken], start: int) -> Iterator[Item]:
    first = len(tokens) - 1
    while first >= 1 and tokens[first].type == "DOT" and tokens[first - 1].type == "NAME":
        first -= 2
    name = "".join(t.text for t in tokens[first + 1 : -1])
    for member, value in members_of(snapshot, offset, name).items():
        if not member.startswith("_"):
            found = signature(value, member)
            detail = str(found) if found is not None else describe(value) if value is not None else "a number"
            yield Item(member, "member" if found is None else "function", member, start, offset, detail)


def _texts(snapshot: Snapshot, offset: int, written: str, folder: str) -> Iterator[Item]:
    """What may stand in quotes: a file, an array in the file before it, a material."""
    start = offset - len(written)
    tokens = [t for t in before(snapshot, offset) if t.start < start - 1]
    within = call_around(snapshot, start - 1)
    beside = os.path.join(folder, os.path.dirname(snapshot.path))
    called = "use" if tokens and tokens[-1].type == "USE" else within.name if within is not None else ""
    if called.startswith("load"):
        named = [t for t in tokens if t.type == "STRING"][-1:] if tokens and tokens[-1].type == "_COMMA" else []
        if named and within is not None and within.argument == 1:
            yield from _arrays(os.path.join(beside, named[0].text.strip('"')), start, offset)
            return
        called = "load"
    if within is not None and within.named == "material":
        for name in MATERIALS:
            yield Item(name, "text", name, start, offset, rank=0)
    elif called == "truss" and within is not None and (within.named or ("cell", "")[min(within.argument, 1)]) == "cell":
        for cell in CELLS.values():
            yield Item(cell.name, "text", cell.name, start, offset, cell.doc, rank=0)
    elif within is not None and (found := signature_of(snapshot, start - 1, within.name)) is not None:
        here = [p for i, p in enumerate(found.parameters)
                if (p.name == within.named if within.named else i == found.place(within.argument))]  # fmt: skip
        for word in dict.fromkeys(_QUOTED.findall(here[0].text) if here else ()):
            yield Item(word, "text", word, start, offset, rank=0)
    if called in _FILES:
        yield from _files(beside, written, _FILES[called], start, offset)


def _files(base: str, written: str, endings: tuple[str, ...], start: int, end: int) -> Iterator[Item]:
    inside, _, _ = written.rpartition("/")
    try:
        entries = sorted(os.scandir(os.path.join(base or ".", inside)), key=lambda e: e.name)
    except OSError:
        return
    for entry in entries[:500]:
        name = f"{inside}/{entry.name}" if inside else entry.name
        if entry.name.startswith("."):
            continue
        if entry.is_dir():
            yield Item(f"{name}/", "file", f"{name}/", start, end, "a folder", rank=2)
        elif entry.name.lower().endswith(endings):
            yield Item(name, "file", name, start, end)


def _arrays(path: str, start: int, end: int) -> Iterator[Item]:
    """The arrays in a file of data, where it can be read."""
    from porelang.tasks.readers.names import names_in

    for name, detail in names_in(path):
        yield Item(name, "text", name, start, end, detail, rank=0)


def _is_declaration(tokens: list[LexedToken]) -> bool:
    """Whether a colon is one behind which a kind stands: of a param, or of a parameter of a def."""
    begins = next((t.type for t in reversed(tokens) if t.type in ("PARAM", "DEF", "LET", "OUT", "FOR")), "")
    return begins in ("PARAM", "DEF")
