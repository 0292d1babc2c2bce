"""A length that meets a raw lattice: refused, with the edit that makes mm of the lattice (docs/decisions/0015).

The values of a lattice are raw: `gyroid(10)` runs from -1.5 to 1.5. What is added to it or compared with it is a number
of those units, and 0.4mm is none: whoever writes a unit means it.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace

from porelang.diagnostics import Diagnostic, Edit, Label
from porelang.elaborate.bare import doubt, short, value_of
from porelang.elaborate.context import Context
from porelang.elaborate.natures import Nature, nature
from porelang.elaborate.results import Suspicion
from porelang.elaborate.values import Function, Given, ListValue, Poison, Scalar, Value
from porelang.ir import Node, order, within
from porelang.source import Span
from porelang.units import ANGLE, LENGTH, RATIO, UNITS

#: Operations that want both sides in one unit. A solid may be cut by `z - 2mm`: that is another solid.
_MEETING = frozenset({"add", "sub", "lt", "le", "eq"})
_CUTTING = frozenset({"min", "max"})
#: Operations of lengths that give one.
_KEEPING = frozenset({"add", "sub", "min", "max", "neg", "abs", "at", "ensure", "select"})
#: `f * b to a`: of a function that adds to its argument a.
_ADDS = re.compile(r"(\w+) \* (\w+) to (\w+)")
#: As many sums of one place are looked at: a shell has five, one of each side or two.
_OFTEN = 8
#: The function that makes mm of it.
LIFT = "metric"
_ABS = "abs"


def length_on_lattice(
    ctx: Context, op: str, numbers: Sequence[Value], places: Sequence[Span], span: Span
) -> Poison | None:
    """Refuse a sum or a comparison of a raw lattice and a length, and doubt one with what was made of a length by a
    number of which the unit is not known; None where nothing is refused."""
    if len(numbers) != 2 or op not in _MEETING | _CUTTING:
        return None
    one, other = numbers
    if op in ("add", "sub"):
        _on_uneven(ctx, numbers, places, span)
    for field, length, at, lies in ((one, other, places[1], places[0]), (other, one, places[0], places[1])):
        if not (isinstance(field, Scalar) and isinstance(length, Scalar)):
            continue
        if op in _MEETING and (wrong := _unit_on_field(ctx, field, length, at, span)) is not None:
            return wrong
        if op not in _CUTTING and length.dimension is None and _is_raw(ctx, field):
            _note_params(ctx, length.node)
        if not _is_length(ctx, length) or (op in _CUTTING and length.node.axes) or not _is_raw(ctx, field):
            continue
        place = ctx.users_place(span)
        if place is span:
            edit = _lift([lies], (), [lies] if _is_folded(ctx, field) else [])
            return _told(ctx, at, edit, length.dimension == LENGTH)
        given = list(ctx.given_at.get(place, {}).values())
        said = _length_among(ctx, given)
        sure = length.dimension == LENGTH or (said is not None and _is_known(said))
        return _told(ctx, place if said is None else said.span, _lifted(ctx, given), sure, said is None)
    return None


def _unit_on_field(ctx: Context, field: Scalar, number: Scalar, at: Span, span: Span) -> Poison | None:
    """Refuse a stress, a force or the like that meets the values of a lattice, or a distance."""
    if number.dimension in (None, RATIO, LENGTH, ANGLE) or not field.node.axes or field.dimension not in (None, LENGTH):
        return None
    found = nature(ctx.natures, field.node)
    if found is None:
        return None
    place = ctx.users_place(span)
    given = [g for g in ctx.given_at.get(place, {}).values() if place is not span and g.value is not field]
    said = next((g.span for g in given if isinstance(g.value, Scalar) and g.value.dimension == number.dimension), None)
    value = value_of(at if place is span else said or place)
    unit = next((name for name, u in UNITS.items() if u.dimension == number.dimension and u.scale == 1), None)
    what = "the values of a raw lattice have no unit" if found.raw else "a distance is in mm"
    text, each = short(value.text), "" if found.raw else " * 1mm"
    hint = "divide it by what counts as 1" + (f", as in `{text} / 100{unit}{each}`" if unit is not None else "")
    return ctx.error("E062", f"`{text}` is {number.dimension}, and {what}", value, hint=hint)


def _on_uneven(ctx: Context, numbers: Sequence[Value], places: Sequence[Span], span: Span) -> None:
    """Suspect a length that is added to what was made of distances, and may be none any more, there or later."""
    for i, field in enumerate(numbers):
        length, lies = numbers[1 - i], places[i]
        if not (isinstance(field, Scalar) and isinstance(length, Scalar)):
            continue
        place = ctx.users_place(span)
        direct, handed = place is span, list(ctx.given_at.get(place, {}).values())
        found = nature(ctx.natures, field.node)
        if found is None or found.raw or found.total is not None:
            continue
        if length.dimension != LENGTH and not _counts_mm(found, length, None if direct else handed):
            continue
        other = nature(ctx.natures, length.node)
        if other is not None and not other.uneven:  # a solid, whose values are mm: it is `field` that is added to it
            continue
        if direct and length.node.axes:
            continue
        added = set(order([length.node], within))
        given = [] if direct else [g for g in handed if _is_uneven(ctx, g.value, added)]
        spans = [lies] if direct else [g.span for g in given]
        at = places[1 - i] if direct else place
        edit = _lift(spans, (), [lies] if direct and found.folded else ()) if found.uneven else None
        where, text = (edit.span, edit.text) if edit else (None, "")
        # all branches of a function are made: which of them is in the part is seen when it is whole
        lifted = () if found.uneven else _lifted_of(ctx, field.node)
        nodes = (field.node, length.node, *found.uneven, *lifted)
        ctx.suspect(Suspicion("uneven", at, nodes, where, LIFT if lifted else "", text), _OFTEN)


def _lifted_of(ctx: Context, n: Node) -> tuple[Node, ...]:
    """The distance that `metric` has found of which a wall is made, and a wall of that."""
    while n not in ctx.lifted:
        varying = [a for a in n.args if a.axes]
        if n.op not in ("abs", "neg", "add", "sub") or len(varying) != 1:
            return ()
        (n,) = varying
    return (n,)


def _counts_mm(found: Nature, number: Scalar, handed: Sequence[Given] | None) -> bool:
    """Whether a number without a unit that is added to a distance counts mm: where a function is given it, or where it
    meets what is at other coordinates than it was made: what was multiplied may have been made a number."""
    if number.dimension is not None or number.node.axes:
        return False
    if handed is None:
        return not found.uneven or any(m.op == "at" for n in found.uneven for m in (n, *n.args))
    numbers = [g.value for g in handed if isinstance(g.value, Scalar) and not g.value.node.axes]
    return any(n.dimension in (None, LENGTH) for n in numbers)


def note_varied(ctx: Context, numbers: Sequence[Value], made: Value, span: Span) -> None:
    """Note that a distance to which what varies was added, a texture too, may be none any more. A fillet is meant: what
    the prelude adds to the least or the greatest of solids."""
    known, place = ctx.natures, ctx.users_place(span)
    if len(numbers) != 2 or not isinstance(made, Scalar):
        return
    handed = numbers if place is span else [g.value for g in ctx.given_at.get(place, {}).values()]
    own = {v.node for v in handed if isinstance(v, Scalar)}
    for one, other in (numbers, (numbers[1], numbers[0])):
        if not (isinstance(one, Scalar) and isinstance(other, Scalar)) or not other.node.axes:
            continue
        if (other.dimension is not None and not _is_length(ctx, other)) or (
            one.node.op in ("min", "max") and one.node not in own
        ):
            continue
        field, added, total = nature(known, one.node), nature(known, other.node), nature(known, made.node)
        if field is None or field.raw or total is None or (added is not None and not added.raw):
            continue
        known[made.node] = replace(total, uneven=total.uneven | {made.node})


def _is_uneven(ctx: Context, value: Value, but: Container[Node]) -> bool:
    found = nature(ctx.natures, value.node) if isinstance(value, Scalar) and value.node not in but else None
    return found is not None and bool(found.uneven)


def call_on_lattice(ctx: Context, function: Function, given: Mapping[str, Given]) -> Poison | None:
    """Refuse the call of a function that says by `Adds:` what it adds to a lattice, if that is a length."""
    fact = _ADDS.fullmatch(function.definition.fact("Adds") or "") if function.definition is not None else None
    if fact is None or fact[3] not in given:
        return None
    _unit_by_number(ctx, function, fact, given)
    if not _is_raw(ctx, given[fact[3]].value):
        return None
    said = _length_among(ctx, [given[name] for name in fact.groups()[:2] if name in given])
    return None if said is None else _told(ctx, said.span, _lifted(ctx, given.values()), _is_known(said))


def _unit_by_number(ctx: Context, function: Function, fact: re.Match[str], given: Mapping[str, Given]) -> None:
    """Doubt a stress or the like that is added to a field, times a number without a unit: that may be of 1/MPa, and
    was rarely meant so."""
    field = given[fact[3]].value
    if not isinstance(field, Scalar) or not field.node.axes or nature(ctx.natures, field.node) is None:
        return
    for one, other in (fact.groups()[:2], fact.groups()[1::-1]):
        value = given[one].value if one in given else None
        factor = given[other].value if other in given else None
        if not isinstance(value, Scalar) or value.dimension in (None, RATIO, LENGTH, ANGLE):
            continue
        if factor is not None and not (isinstance(factor, Scalar) and factor.dimension is None):
            continue
        said = value_of(given[one].span)
        text = short(said.text)
        plain = short(_without_brackets(said.text.removeprefix("-").strip()))
        unit = next((name for name, u in UNITS.items() if u.dimension == value.dimension and u.scale == 1), None)
        much = f"10{unit}" if unit is not None else "..."
        doubt(
            ctx,
            "W287",
            f"`{text}` is {value.dimension}, and `{function.name}` adds it to a field whose values are none: where "
            f"that is above 0 the part gets thinner, by as many units as it has {value.dimension.called}",
            said,
            f"is in {value.dimension.called}",
            f"divide it by what counts as 1, with the sign that is meant: `1 - {plain} / {much}` has walls grow where "
            f"it is above {much}, and give where it is less; `-clamp({plain} / {much}, 0, 1)` has them grow alone",
        )


def note_length(ctx: Context, numbers: Sequence[Value], made: Value) -> None:
    """Note the product of a length and a number that varies or is set, without a known unit: a length, most likely."""
    if len(numbers) != 2 or not isinstance(made, Scalar) or made.dimension is not None or made.node.op != "mul":
        return
    for one, other in (numbers, (numbers[1], numbers[0])):
        if not (isinstance(one, Scalar) and isinstance(other, Scalar)) or other.dimension is not None:
            continue
        known = nature(ctx.natures, other.node)
        if (
            _is_length(ctx, one)
            and (known is None or (known.scaled and not known.raw))
            and ctx.constant(other.node) is None
        ):
            ctx.lengths[made.node] = True


def _note_params(ctx: Context, number: Node) -> None:
    """Note the params without a unit that are what meets a lattice, or times a number are: they count its units."""
    if number.axes:
        return
    for n in order([number], lambda n: n.args if n.op in _KEEPING or _is_multiple(n) else ()):
        info = ctx.found.params.get(str(n.value)) if n.op == "param" else None
        if info is not None and info.dimension is None and not info.raw:
            ctx.found.params[info.name] = replace(info, raw=True)


def _is_multiple(n: Node) -> bool:
    return n.op in ("mul", "div") and any(a.op == "const" for a in n.args)


def _length_among(ctx: Context, given: Sequence[Given]) -> Given | None:
    """The first argument that is a length; else the first that was made of one."""
    numbers = [g for g in given if isinstance(g.value, Scalar) and not _is_raw(ctx, g.value)]
    made = [g for g in numbers if isinstance(g.value, Scalar) and _is_length(ctx, g.value)]
    return next((g for g in made if _is_known(g)), made[0] if made else None)


def _is_known(given: Given) -> bool:
    return isinstance(given.value, Scalar) and given.value.dimension == LENGTH


def _is_length(ctx: Context, value: Scalar) -> bool:
    """Whether a number is a length, as far as is known, or was made of one."""
    if value.dimension is not None or not ctx.lengths:
        return value.dimension == LENGTH
    known = ctx.lengths
    for n in order([value.node], lambda n: () if n in known else within(n)):
        if n not in known:
            parts = n.args[1:] if n.op == "select" else n.args[:1] if n.op == "at" else n.args
            known[n] = (n.op in _KEEPING or _is_multiple(n)) and any(known.get(a, False) for a in parts)
    return known[value.node]


def _is_raw(ctx: Context, value: Value) -> bool:
    """Whether a value is a raw lattice, or a list with one; a lattice that was multiplied by a length is none."""
    if isinstance(value, ListValue):
        return any(_is_raw(ctx, v) for v in value.items)
    if not isinstance(value, Scalar) or not value.node.axes or value.dimension not in (None, LENGTH):
        return False
    found = nature(ctx.natures, value.node)
    return found is not None and found.raw and not (found.scaled and value.dimension == LENGTH)


def _lifted(ctx: Context, given: Iterable[Given]) -> Edit | None:
    """The arguments of a call with each raw lattice made a distance."""
    lifted = {g.span: g.value for g in given if _is_raw(ctx, g.value)}
    lists = [s for s, value in lifted.items() if isinstance(value, ListValue)]
    if any(isinstance(v, ListValue) and any(_is_number(i) for i in v.items) for v in lifted.values()):
        return None  # a number in the list is no field to be lifted with the others
    spans = sorted(lifted, key=lambda s: s.start)
    return _lift(spans, lists, [s for s, value in lifted.items() if _is_folded(ctx, value)])


def _is_number(value: Value) -> bool:
    return isinstance(value, Scalar) and not value.node.axes


def _is_folded(ctx: Context, value: Value) -> bool:
    """Whether a value is the magnitude of a lattice: its surface is no place where it changes its sign."""
    found = nature(ctx.natures, value.node) if isinstance(value, Scalar) else None
    return found is not None and found.folded


def _lift(spans: Sequence[Span], lists: Sequence[Span] = (), folded: Sequence[Span] = ()) -> Edit | None:
    """One edit that wraps the texts of places in `metric(...)`; None where there are none, or not in one text."""
    if not spans or any(s.source is not spans[0].source or s.source.prelude for s in spans):
        return None
    source, text, end = spans[0].source, "", _closed(value_of(spans[0])).start
    for s in spans:
        value = _closed(value_of(s))
        if s in lists:
            wrapped = f"[for f in {value.text}: {LIFT}(f)]"
        elif s in folded:  # what is folded is lifted within: no distance is found to where nothing changes its sign
            inner = _without_brackets(value.text.removeprefix(_ABS))
            if not value.text.startswith(_ABS) or inner == value.text.removeprefix(_ABS):
                return None
            wrapped = f"{_ABS}({LIFT}({inner}))"
        else:
            wrapped = f"{LIFT}({_without_brackets(value.text)})"
        text += source.text[end : value.start] + wrapped
        end = value.end
    return Edit(Span(source, _closed(value_of(spans[0])).start, end), text)


def _closed(span: Span) -> Span:
    """A place with the parentheses of its first and last operand, which no operand's own place has."""
    text, start, end = span.source.text, span.start, span.end
    depth = least = 0
    for c in span.text:
        depth += (c == "(") - (c == ")")
        least = min(least, depth)
    for _ in range(-least):
        start = max(text.rfind("(", 0, start), 0)
    for _ in range(depth - least):
        end = text.find(")", end) + 1 or end
    return Span(span.source, start, end)


def _without_brackets(text: str) -> str:
    """A text without the parentheses that enclose all of it."""
    depth = 0
    for i, c in enumerate(text):
        depth += (c == "(") - (c == ")")
        if depth == 0:
            return text[1:-1].strip() if c == ")" and i == len(text) - 1 and text[0] == "(" else text
    return text


def _told(ctx: Context, said: Span, edit: Edit | None, sure: bool, within_it: bool = False) -> Poison | None:
    value, does = value_of(said), "holds" if within_it else "is" if sure else "is made of"
    lifted = f"`{short(edit.text)}`" if edit is not None else f"`{LIFT}(...)` of the lattice"
    other = "a raw number, without a unit" if sure else "`bare(...)` of the length, if raw units are meant"
    porous = "for a porosity there are `to_porosity` and `shell_to_porosity`"
    told = Diagnostic(
        "E145" if sure else "W212",
        f"`{short(value.text)}` {does} a length, and the values of a raw lattice are not in mm",
        value,
        "meets a raw lattice, whose values have no unit",
        () if edit is None else (Label(edit.span, f"its distance in mm is {lifted}"),),
        f"write {lifted}, whose values are mm; or {other}; {porous}",
        edit,
    )
    if not sure:
        doubt(ctx, told.code, told.message, value, told.label, told.hint, told.others, edit)
        return None
    return ctx.error(told.code, told.message, value, told.label, told.others, told.hint, edit)
