"""Units that the language has not, and units that stand without a number: what they are here."""

from __future__ import annotations

import re

from porelang.diagnostics import Diagnostic, Edit, suggest
from porelang.source import Span
from porelang.units import ELSEWHERE, SPELT, UNITS, WITHOUT, converted

#: What divides or multiplies a unit: `/cm^3` of `2.7 g/cm^3`.
_ANY = "|".join(sorted({*UNITS, *ELSEWHERE, *WITHOUT} - {"%"}))
_REST = re.compile(rf"(?:\s*[/*]\s*(?:{_ANY})\b(?:\^-?\d)?)+")
_NUMBER = re.compile(r"\d+\.?\d*|\.\d+")
_KNOWN = f"the units are {', '.join(UNITS)}"


def unknown_unit(whole: Span, digits: str, place: Span) -> Diagnostic:
    """What to say of a number with a unit that there is not: `whole` are both, `place` the unit."""
    unit, text = place.text, place.source.text
    message = f"`{unit}` is not a unit"
    if is_bound(unit, text):
        hint = f"for a product write `{digits}*{unit}`; {_KNOWN}"
        return Diagnostic("E002", message, place, hint=hint, edit=Edit(whole, f"{digits}*{unit}"))
    if unit in ELSEWHERE:
        ours = converted(float(digits), unit)
        return Diagnostic("E002", message, place, hint=f"write `{ours}`; {_KNOWN}", edit=Edit(whole, ours))
    if unit in WITHOUT:
        rest = _REST.match(text, place.end)
        end = rest.end() if rest else place.end
        hint = f"{_without(unit)}: write the number alone, `{digits}`; {_KNOWN}"
        return Diagnostic("E002", message, place, hint=hint, edit=Edit(Span(whole.source, whole.start, end), digits))
    near = SPELT.get(unit) or suggest(unit, UNITS)
    if near is not None:
        hint, ours = f"did you mean `{digits}{near}`?", digits + near
        return Diagnostic("E002", message, place, hint=hint, edit=Edit(whole, ours))
    return Diagnostic("E002", message, place, hint=_KNOWN)


def _without(unit: str) -> str:
    return f"there is no unit of {WITHOUT[unit]}"


#: Units that are no likely names of anything else.
_CLEAR = frozenset({"mm", "cm", "um", "deg", "kN", "Pa", "kPa", "MPa", "GPa"})


def unit_alone(name: str, span: Span) -> Diagnostic | None:
    """What to say of a name that nothing has and that is a unit: `0.3/mm`.

    It has to stand where a unit does, beside `*` or `/`; a word that may well be a name behind a number, and a single
    letter beside another unit: in `2 * h` it is a height that was forgotten.
    """
    before, after = span.source.text[: span.start], span.source.text[span.end :]
    ours = SPELT.get(name, name)
    beside_a_unit = re.search(rf"(?<![A-Za-z_])(?:{_ANY})(?:\^-?\d)?\s*[*/]\s*$", before) or re.match(
        rf"\s*[*/]\s*[\d.]*(?:{_ANY})\b", after
    )
    if ours in _CLEAR:
        fits = re.search(r"[*/]\s*$", before) or re.match(r"\s*[*/^]", after)
    elif len(name) == 1:
        fits = beside_a_unit
    else:
        fits = beside_a_unit or re.search(r"(?<![A-Za-z_])[\d.]+\s*[*/]\s*$", before)
    if not fits:
        return None
    if ours in UNITS:
        hint, edit = f"a unit has a number: write `1{ours}`, as in `0.3 / 1{ours}`", Edit(span, f"1{ours}")
    elif name in ELSEWHERE:
        hint, edit = f"it is `{converted(1, name)}`; {_KNOWN}", Edit(span, converted(1, name))
    elif name in WITHOUT:
        return Diagnostic("E030", f"`{name}` is not a unit of Pore", span, "nothing is called this",
                          hint=f"{_without(name)}: leave it out; {_KNOWN}")  # fmt: skip
    else:
        return None
    what = "is a unit, and stands without a number" if ours in UNITS else "is not a unit of Pore"
    return Diagnostic("E030", f"`{name}` {what}", span, "nothing is called this", hint=hint, edit=edit)


def with_unit(text: str, unit: str) -> str:
    """An expression as one with a unit: `30deg`, `a * 1deg`, `(a + 10) * 1deg`."""
    if _NUMBER.fullmatch(text):
        return f"{text}{unit}"
    return f"{text} * 1{unit}" if text.isidentifier() else f"({text}) * 1{unit}"


def of_a_number(name: str, argument: Span) -> str:
    """A unit that is called, `deg(30)` or `mm(a)`, as a number with that unit; "" where it is none."""
    ours = SPELT.get(name, name)
    text = argument.text
    if _NUMBER.fullmatch(text):
        return with_unit(text, ours) if ours in UNITS else converted(float(text), name) if name in ELSEWHERE else ""
    return f"({with_unit(text, ours)})" if ours in _CLEAR else ""


def is_bound(name: str, text: str) -> bool:
    """Whether a text binds a name somewhere, or the language does."""
    binding = rf"\b(?:let|param|def|for|as)\s+{name}\b|[(,]\s*{name}\s*[:,)=]|(?<![\w.]){name}\s*=>"
    return name in ("x", "y", "z", "pi", "tau") or re.search(binding, text) is not None
