"""The tables of the parser as a data file of the package: `grammar/pore.lalr.json`, made from `grammar/pore.lark`.

Lark needs 0.3 s to make them, which every `pore` would pay. They are JSON and lie in the package, not in a folder
that others may write to: reading them runs nothing.
"""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

from porelang import resources

if TYPE_CHECKING:
    import lark

FILE = "grammar/pore.lalr.json"
#: Options of lark that are objects of this process: they are given when the tables are read.
_OBJECTS = ("transformer", "postlex")


def pack(made: lark.Lark, grammar: str) -> str:
    """The text of the file: a parser's tables, and which grammar and which lark they are of."""
    from lark.grammar import Rule
    from lark.lexer import TerminalDef

    data, memo = made.memo_serialize([TerminalDef, Rule])
    data["options"] = {name: value for name, value in data["options"].items() if name not in _OBJECTS}
    return json.dumps({"made_of": _made_of(grammar), "data": data, "memo": memo}, separators=(",", ":")) + "\n"


def unpack(grammar: str, **objects: Any) -> lark.Lark | None:
    """The parser of a grammar from the file; None where the file is of another grammar, or of another lark."""
    import lark

    try:
        kept = json.loads(resources.read(FILE), object_hook=_numbered)
    except FileNotFoundError:
        return None
    if kept["made_of"] != _made_of(grammar):
        return None
    parser: lark.Lark = lark.Lark._load_from_dict(kept["data"], kept["memo"], **objects)  # type: ignore[no-untyped-call]  # lark has no types there
    return parser


def _made_of(grammar: str) -> list[str]:
    import lark

    version = ".".join(lark.__version__.split(".")[:2])  # releases that mend lark keep the form of its tables
    return [version, hashlib.sha256(grammar.encode()).hexdigest()]


def _numbered(found: dict[str, Any]) -> dict[str | int, Any]:
    """A JSON object whose names that are whole numbers are numbers again, as lark numbers states and terminals."""
    return {int(name) if name.isdigit() else name: value for name, value in found.items()}
