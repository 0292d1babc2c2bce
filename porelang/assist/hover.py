"""What is said of a place: the name there, what it stands for and is worth."""

from __future__ import annotations

from dataclasses import dataclass

from porelang.assist.names import Bound, Use, use_at, value_of
from porelang.assist.shown import Signature, signature, told
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.values import Poison
from porelang.program import Design
from porelang.session import Snapshot
from porelang.source import Span
from porelang.syntax import tree
from porelang.units import UNITS


@dataclass(frozen=True, slots=True)
class Hover:
    """What is said of a place: code that declares it, lines about it, and its documentation."""

    span: Span
    code: str
    lines: tuple[str, ...] = ()
    doc: str = ""

    @property
    def markdown(self) -> str:
        """As an editor shows it."""
        parts = [f"```pore\n{self.code}\n```", "  \n".join(self.lines), self.doc]
        return "\n\n".join(part for part in parts if part)


#: What is found from fields while a pointer rests may take so long.
SECONDS = 2.0


def _design(snapshot: Snapshot) -> Design | None:
    return None if snapshot.good is None else snapshot.good.design()


def hover(snapshot: Snapshot, offset: int) -> Hover | None:
    """What is said of the name, or else the number, at a place; None where there is neither."""
    use = use_at(snapshot, offset)
    if use is not None and use.bound is not None:
        return _of_name(snapshot, use, use.bound)
    expressions = snapshot.expressions_at(offset)
    innermost = expressions[-1] if expressions else None
    if isinstance(innermost, tree.Number):
        unit = UNITS.get(innermost.unit)
        base = "" if unit is None else f"{innermost.value * unit.scale:.10g}{unit.dimension.called}"
        lines = (str(unit.dimension),) if unit is not None else ()
        said = innermost.span.text
        return Hover(innermost.span.in_file, f"{said} = {base}" if base and base != said else said, lines)
    if isinstance(innermost, tree.Member):
        value = snapshot.value(innermost)
        if value is not None and not isinstance(value, Poison):
            return Hover(
                innermost.span.in_file, innermost.span.text, tuple(told(value, _design(snapshot), seconds=SECONDS))
            )
    return None


def _of_name(snapshot: Snapshot, use: Use, bound: Bound) -> Hover:
    place, by = use.span.in_file, bound.by
    if isinstance(by, tree.Param):
        info = snapshot.good.params.get(by.name) if snapshot.good is not None else None
        doc = by.doc if info is None or not info.structural else f"{by.doc}\n\nSomething is counted or picked by it."
        return Hover(place, _declared(by.span.text, by.doc), (), doc)
    if isinstance(by, tree.Parameter):
        kinds = [KINDS[k.name].doc for k in by.kinds if k.name in KINDS]
        return Hover(place, by.span.text, tuple(kinds))
    if isinstance(by, tree.Use):
        return Hover(place, by.span.text)
    found = signature(by if isinstance(by, tree.Def) else bound.value, use.name)
    if found is not None:
        return Hover(place, f"def {found}" if isinstance(by, tree.Def) else str(found), (), documented(found))
    value = value_of(snapshot, bound) or snapshot.compiled.elaborated.values.get(use.span)
    value = None if isinstance(value, Poison) else value
    word = {"let": "let", "out": "out", "preset": "preset"}.get(bound.kind, "")
    code = f"{word} {use.name}".strip() if by is None else " ".join(by.span.text.split())[:200]
    return Hover(place, code, tuple(told(value, _design(snapshot), seconds=SECONDS)) if value is not None else ())


def _declared(text: str, doc: str) -> str:
    """A declaration without the doc at its end, which is said below it."""
    text = " ".join(text.split())
    return text.removesuffix(f'"{doc}"').rstrip() if doc else text


def documented(found: Signature) -> str:
    """The documentation of a function, with its example."""
    example = f"```pore\n{found.example}\n```" if found.example else ""
    return "\n\n".join(part for part in (found.doc.replace("\n", "  \n"), example) if part)
