"""`make docs`: the parts of docs/language.md that the table of operations, the kinds and the prelude already say."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable
from pathlib import Path

from porelang.elaborate.builtins import builtins
from porelang.elaborate.calls import signature
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.prelude import prelude_files, prelude_scope
from porelang.elaborate.values import Builtin, Function, Record, Scope
from porelang.ops import TABLE
from porelang.ops.strut_cells import CELLS
from porelang.syntax import tree
from porelang.syntax.parse import parse
from porelang.units import UNITS

PAGE = Path(__file__).parent / "language.md"
PART = re.compile(r"(<!-- generated: ([a-z_ /]+) -->\n).*?(<!-- end -->)", re.DOTALL)
_OF_LATTICES = "Formula|Range|Volume fraction|Steepest|Balanced|Reference"
FACT = re.compile(
    rf"({_OF_LATTICES}|Modifies|Adds|Gives|Copies|Instead|Closes|Follows|Folds|Fits|Stretches|Rounds|Rod|Else \w+"
    r"|Example): ?(.*)"
)


def page(text: str) -> str:
    """The page with its generated parts written anew."""
    return PART.sub(lambda m: f"{m[1]}{written(m[2])}\n{m[3]}", text)


def written(part: str) -> str:
    """A generated part by its name: `units`, `kinds`, `operations`, `functions`, `cells`, `lattices`, `prelude X`."""
    if part.startswith("prelude "):
        return prelude(part.removeprefix("prelude "))
    return PARTS[part]()


def row(*cells: str) -> str:
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


def code(text: str) -> str:
    return f"`{text}`" if text else ""


def units() -> str:
    lines = [row("suffix", "is", "in base units"), row("---", "---", "---")]
    return "\n".join([*lines, *(row(code(u.name), str(u.dimension), f"{u.scale:.8g}") for u in UNITS.values())])


def kinds() -> str:
    lines = [row("kind", "takes"), row("---", "---")]
    return "\n".join([*lines, *(row(code(k.name), k.doc) for k in KINDS.values())])


def operations() -> str:
    lines = [row("written", "is", "example", "defined for"), row("---", "---", "---", "---")]
    for op in TABLE.values():
        if op.symbol and op.example:
            text, value = op.example
            shown = str(value).lower() if isinstance(value, bool) else f"{value:g}"
            lines.append(row(code(op.symbol), op.doc, f"`{text}` is {shown}", op.domain))
    return "\n".join(lines)


def functions() -> str:
    """The functions that are neither operations nor written in Pore."""
    found = [
        b for name, b in builtins().items() if isinstance(b, Builtin) and name not in {o.symbol for o in TABLE.values()}
    ]
    return "\n".join(f"- `{called(b)}`: {b.doc}" for b in found if b.name not in ("pow", "mod"))


def called(b: Builtin) -> str:
    """A call as it is written, with brackets about what may be left out."""
    names = [*b.signature[: b.least], *(f"[{name}]" for name in b.signature[b.least :])] if b.optional else b.signature
    return f"{b.name}({', '.join(names)})"


def prelude(name: str) -> str:
    """The defs of a file of the prelude with their documentation."""
    scope = _scope(name)
    lines = []
    for s in _defs(name):
        text, facts = _read(s.doc)
        function = scope.names[s.name]
        assert isinstance(function, Function)
        example = f" Example: `{facts['Example']}`" if "Example" in facts else ""
        modifies = f" Modifies {_modifies(facts['Modifies'])}." if "Modifies" in facts else ""
        lines.append(f"- `{signature(function)}`: {text}{modifies}{example}")
    return "\n".join(lines)


def cells() -> str:
    """The cells of struts, with the sum of their lengths in sides of the cell: pi (r / w)^2 of that is solid."""
    lines = [row("cell", "is", "bars", "meet in a node", "length / w", "source"), row(*["---"] * 6)]
    for c in CELLS.values():
        length = sum(math.dist(a, b) for a, b in c.bars)
        met = ", ".join(map(str, sorted(c.met)))
        lines.append(row(code(c.name), c.doc, str(len(c.bars)), met, f"{length:.4g}", c.source))
    return "\n".join(lines)


def lattices() -> str:
    lines = [row("lattice", "formula (X = 2 pi x / w ...)", "range", "solid", "steepest"), row(*["---"] * 5)]
    sources = []
    for s in _defs("tpms"):
        text, facts = _read(s.doc)
        lines.append(
            row(f"`{s.name}`", code(facts["Formula"]), *(facts[k] for k in ("Range", "Volume fraction", "Steepest")))
        )
        sources.append(f"- `{s.name}`: {text} {facts['Reference']}")
    return "\n".join([*lines, "", *sources])


def _defs(name: str) -> list[tree.Def]:
    source = next(source for file, source in prelude_files() if file == name)
    file, found = parse(source)
    assert not found
    return [s for s in file.statements if isinstance(s, tree.Def)]


def _scope(name: str) -> Scope:
    scope = prelude_scope()
    folder, _, last = name.rpartition("/")
    if folder:
        record = scope.find(folder)
        assert isinstance(record, Record)
        inner = record.members[last]
        assert isinstance(inner, Record)
        return Scope(dict(inner.members))
    return scope


def _read(doc: str) -> tuple[str, dict[str, str]]:
    """The text of a doc comment as one paragraph, and the facts that stand in it as `Name: ...`."""
    text: list[str] = []
    facts: dict[str, str] = {}
    last = ""
    for line in doc.split("\n"):
        if match := FACT.fullmatch(line.strip()):
            last = match[1]
            facts[last] = match[2]
        elif last and line.startswith("  "):
            facts[last] += f" {line.strip()}"
        else:
            last = ""
            text.append(line.strip())
    return " ".join(" ".join(text).split()), facts


def _modifies(fact: str) -> str:
    """`space by angle, as a local frame` in a sentence, with the parameters as code."""
    dimension, parameters, *letter = re.split(r" by |, ", fact)
    return ", ".join([f"the {dimension} by {' or '.join(map(code, parameters.split(' or ')))}", *letter])


PARTS: dict[str, Callable[[], str]] = {
    "units": units, "kinds": kinds, "operations": operations, "functions": functions, "cells": cells,
    "lattices": lattices,
}  # fmt: skip

if __name__ == "__main__":
    before = PAGE.read_text(encoding="utf-8")
    after = page(before)
    PAGE.write_text(after, encoding="utf-8")
    sys.stdout.write(f"{PAGE.name}: {'up to date' if before == after else 'written anew'}\n")
