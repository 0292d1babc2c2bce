"""What a designer almost certainly did not mean, seen while a program is elaborated.

What the text alone decides is said at once, as a warning. What values decide (whether two solids overlap, whether
copies are cut) is noted as a `Suspicion`, and looked at when the program is whole (`porelang.doubts`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Literal

from porelang.diagnostics import Edit, Label
from porelang.elaborate.bare import DEGREES, degrees, doubt, short, value_of
from porelang.elaborate.context import Context
from porelang.elaborate.kinds import Kind
from porelang.elaborate.natures import nature
from porelang.elaborate.raw import LIFT
from porelang.elaborate.results import Suspicion
from porelang.elaborate.values import Bool, Function, Given, ListValue, Scalar, Value, Vector, as_vector
from porelang.ir import UNKNOWN, order, within
from porelang.source import Span
from porelang.syntax import tree

_COPIES = re.compile(r"(\w+)(?:, in cells of (\w+))?")
_CLOSES = re.compile(r"(\w+) along y after (\w+)")
_FITS = re.compile(r"(\w+) along ([xyz]) by (\w+)")
_ROUNDS = re.compile(r"(\w+) by (\w+)")
_FOLDS = re.compile(r"(\w+) by (\w+) about z through (\w+)")
_SETS = ("&", "|", "\\")


# ---- solids ---------------------------------------------------------------------------------------------------------


def total_as_solid(ctx: Context, value: Value) -> None:
    """Suspect a sum or a difference of two distances that is used as a solid."""
    if isinstance(value, Scalar) and value.node.axes:
        found = nature(ctx.natures, value.node)
        if found is not None and found.total is not None and found.total in ctx.totals:
            op, span = ctx.totals[found.total]
            ctx.suspect(Suspicion("total", span, found.total.args, None, op))


def note_total(ctx: Context, op: str, value: Value, span: Span) -> None:
    """Remember where the user added or subtracted two distances."""
    if span.source.prelude or not isinstance(value, Scalar) or not value.node.axes:
        return
    found = nature(ctx.natures, value.node)
    if found is not None and found.total is value.node:
        ctx.totals.setdefault(value.node, (op, span))


def cut(ctx: Context, op: str, a: tuple[Value, Span], b: tuple[Value, Span], made: Value, span: Span) -> None:
    """Suspect two solids that do not meet, and a lattice without pores; of places that cut several times, nothing."""
    if span.source.prelude or not (isinstance(made, Scalar) and made.node.axes):
        return
    natures = []
    for (value, place), (other, _) in ((a, b), (b, a)):
        if not isinstance(value, Scalar) or not isinstance(other, Scalar):
            return
        known = nature(ctx.natures, value.node)
        natures.append(known)
        walls = known is not None and known.raw and not known.plain and value.node.op not in ("max", "min", "select")
        if walls and op == "&":
            ctx.suspect(Suspicion("pores", place, (value.node, other.node)))
    if op == "|":
        _beside(ctx, a, b)
    if op == "|" or None in natures or made.node.depends >= UNKNOWN:  # what a `solve` tries may well miss
        return
    first, second = made.node.args
    ctx.cuts.append(Suspicion("apart", span, (first, second), b[1], op))


def _beside(ctx: Context, a: tuple[Value, Span], b: tuple[Value, Span]) -> None:
    """Note of `a | b \\ c` what stands beside the cut: it was not cut."""
    (one, first), (other, last) = a, b
    if not (isinstance(one, Scalar) and isinstance(other, Scalar)) or other.node.op != "max":
        return
    for s in [s for s in ctx.cuts if s.name == "\\" and s.nodes == other.node.args]:
        mine = s.span.source is last.source and last.start <= s.span.start < last.end
        if mine and not last.text.startswith("("):
            ctx.cuts.append(replace(s, beside=(first.to(last), one.node)))


def once_cut(cuts: Iterable[Suspicion]) -> Iterator[Suspicion]:
    """Of all cuts those of places that cut the same solids each time, with all that was noted of them."""
    by_place: dict[Span, list[Suspicion]] = {}
    for s in cuts:
        by_place.setdefault(s.span, []).append(s)
    for same in by_place.values():
        if all(s.nodes[0] is same[0].nodes[0] and s.nodes[1] is same[0].nodes[1] for s in same):
            yield same[-1]


def made_empty(ctx: Context, function: Function, result: Scalar, given: Mapping[str, Given], site: tree.Call) -> None:
    """Suspect an inward offset that leaves nothing; of places that make several, nothing."""
    definition, place = function.definition, ctx.users_place(site.span)
    if function.name != "offset" or definition is None or not definition.span.source.prelude or place != site.span:
        return
    body, d = given["a"].value if "a" in given else None, given.get("d")
    if not isinstance(body, Scalar) or d is None or result.node.depends >= UNKNOWN:
        return
    known = nature(ctx.natures, body.node)
    if known is None or known.raw or known.total is not None:
        return
    ctx.cuts.append(Suspicion("empty", place, (result.node, body.node), d.span, function.name))


def drifts(
    ctx: Context,
    function: Function,
    bound: Mapping[str, Value],
    result: Scalar,
    given: Mapping[str, Given],
    site: tree.Call,
) -> None:
    """Suspect a lattice whose period varies in space: its cells have another."""
    w, turns = bound.get("w"), bound.get("phase")
    if not _has_cells(ctx, function, result) or not isinstance(turns, Vector) or not isinstance(w, Scalar | Vector):
        return
    periods = w.nodes if isinstance(w, Vector) else (w.node,) * 3
    if not any(n.axes for n in periods) or result.node.depends >= UNKNOWN:
        return
    place = ctx.users_place(site.span)
    own = given["w"].span if "w" in given and place == site.span else None
    argument = own if own is not None and own.start >= place.start else None  # a piped one stands before
    ctx.suspect(Suspicion("period", place, (result.node, *periods, *turns.nodes), argument, function.name))


def _has_cells(ctx: Context, function: Function, result: Scalar) -> bool:
    """Whether a field is a lattice, or another that takes its cells by a size or by a phase, as foams do."""
    found = nature(ctx.natures, result.node) if result.node.axes else None
    return found is not None and (found.raw or any(p.alternative == "phase" for p in function.parameters))


def jumps(
    ctx: Context, function: Function, bound: Mapping[str, Value], result: Scalar, given: Mapping[str, Given],
    site: tree.Call,
) -> None:  # fmt: skip
    """Suspect a lattice by its phase: of several formulas, of stretched cells, or found within a solid."""
    turns = bound.get("phase")
    if not _has_cells(ctx, function, result) or not isinstance(turns, Vector) or result.node.depends >= UNKNOWN:
        return
    below, nodes = order(turns.nodes, within), (result.node, *turns.nodes)
    place = ctx.users_place(site.span)
    spot = given["phase"].span if "phase" in given and place == site.span else None
    if any((n.op == "select" and n.args[0].axes) or (n.op == "atan2" and n.axes) for n in below):
        ctx.suspect(Suspicion("jump", place, nodes, spot, function.name))
    if by := next((ctx.stretching[n] for n in below if n in ctx.stretching), None):
        ctx.suspect(Suspicion("stretched", place, nodes, name=by[0], instead=by[1]))
    if any(n.op == "lookup_cubic" and n.args[0].op == "phase" for n in below):
        ctx.suspect(Suspicion("beyond", place, nodes, spot, function.name))


# ---- calls ----------------------------------------------------------------------------------------------------------


def call_of(
    ctx: Context, function: Function, given: Mapping[str, Given], kinds: Mapping[str, Kind], site: tree.Call
) -> bool:
    """Doubt the arguments of a call in the user's text; whether two of them were taken for one another."""
    if site.span.source.prelude:
        return False
    ctx.given_at[site.span] = given
    for name, kind in kinds.items():
        if kind.name in ("angle", "rate") and name in given:
            degrees(ctx, given[name].value, given[name].span, function.name, kind.name == "rate")
        if kind.name == "solid" and name in given:
            total_as_solid(ctx, given[name].value)
    return _swapped(ctx, function, given, kinds, site)


def _swapped(
    ctx: Context, function: Function, given: Mapping[str, Given], kinds: Mapping[str, Kind], site: tree.Call
) -> bool:
    """Whether a number stands where a field is asked for, and a solid where a number is."""
    plain = solid = None
    for name, g in given.items():
        if name not in kinds or not isinstance(g.value, Scalar):
            continue
        if kinds[name].name in ("field", "solid"):
            plain = plain or (name if not g.value.node.axes else None)
        elif g.value.node.axes and nature(ctx.natures, g.value.node) is not None:
            solid = solid or name
    if plain is None or solid is None:
        return False
    texts = {name: g.span.text for name, g in given.items()}
    if all(g.name is None and g.span.start >= site.span.start for g in given.values()):  # none is piped
        texts[plain], texts[solid] = texts[solid], texts[plain]
        call = f"{site.function.span.text}({', '.join(texts.values())})"
        edit = Edit(site.span, call) if site.span.text.startswith(site.function.span.text + "(") else None
        hint = f"write `{call}`"
    else:
        edit, hint = None, "exchange the two"
    doubt(
        ctx,
        "W216",
        f"`{function.name}` is given a number for `{plain}` and a solid for `{solid}`; are the two exchanged?",
        given[plain].span,
        f"`{plain}` is the field",
        hint,
        others=(Label(given[solid].span, f"`{solid}` is a number"),),
        edit=edit,
    )
    return True


def made_by(ctx: Context, function: Function, bound: Mapping[str, Value], result: Value, site: tree.Call) -> None:
    """Suspect what a call has made, by what the documentation of its function says: copies, and fields that close."""
    definition = function.definition
    if definition is None or not isinstance(result, Scalar):
        return
    given = ctx.given_at.get(site.span, {})
    if function.name == DEGREES and definition.span.source.prelude and "angle" in given:
        angle = given["angle"].value
        if isinstance(angle, Scalar):
            ctx.in_degrees.setdefault(result.node, angle)
    if function.name == LIFT and definition.span.source.prelude:
        lattice = bound.get("f")
        found = nature(ctx.natures, lattice.node) if isinstance(lattice, Scalar) else None
        if found is not None and found.raw and found.plain:  # what was cut has corners, and they no distance outside
            ctx.lifted.add(result.node)
    made_empty(ctx, function, result, given, site)
    drifts(ctx, function, bound, result, given, site)
    jumps(ctx, function, bound, result, given, site)
    if fact := _COPIES.fullmatch(definition.fact("Copies") or ""):
        body, cell = bound.get(fact[1]), bound.get(fact[2] or "")
        if isinstance(body, Scalar) and body.node.axes:
            sizes = cell.nodes if isinstance(cell, Vector) else (cell.node,) * 3 if isinstance(cell, Scalar) else ()
            place = ctx.users_place(site.span)
            whole = all(g.span.start >= place.start for g in given.values()) and place == site.span  # not piped
            ctx.suspect(
                Suspicion(
                    "copies",
                    place,
                    (body.node, result.node, *sizes),
                    place if whole else None,
                    function.name,
                    _instead(definition, given),
                )
            )
    if fact := _CLOSES.fullmatch(definition.fact("Closes") or ""):
        field, turn = bound.get(fact[1]), bound.get(fact[2])
        if isinstance(field, Scalar) and isinstance(turn, Scalar):
            found = nature(ctx.natures, field.node)
            if found is not None and found.raw:
                ctx.suspect(
                    Suspicion(
                        "seam",
                        ctx.users_place(site.span),
                        (field.node, turn.node, result.node),
                        given[fact[2]].span if fact[2] in given else None,
                        function.name,
                        period=found.period,
                    )
                )

    turned(ctx, definition, bound, given, result, site)
    if (way_out := definition.fact("Stretches")) is not None and result.node.axes and result.node.depends < UNKNOWN:
        ctx.stretching.setdefault(result.node, (function.name, way_out))
        if result.node.op == "at":
            place = ctx.users_place(site.span)
            turned_by = [bound.get(name) for name in (definition.fact("Follows") or "", "up", "about")]
            frame = [n for v in turned_by if isinstance(v, Vector) for n in v.nodes]
            mine = len(frame) == 9 and place == site.span and "up" not in given
            nodes = (result.node, *result.node.args[1:], *(frame if mine else ()))
            ctx.suspect(Suspicion("stretched", place, nodes, name=function.name, instead=way_out))
    rounds, rod = definition.fact("Rounds"), definition.fact("Rod")
    if fact := _ROUNDS.fullmatch(rounds or rod or ""):
        points, bend, closed = (bound.get(name) for name in (*fact.groups(), "closed"))
        corners = [as_vector(q) for q in points.items] if isinstance(points, ListValue) else []
        if isinstance(bend, Scalar) and isinstance(closed, Bool) and corners and result.node.depends < UNKNOWN:
            nodes = (result.node, bend.node, closed.node, *(n for q in corners if q is not None for n in q.nodes))
            radius = given["bend"].span if "bend" in given else None
            what: Literal["bend", "rod"] = "bend" if rounds else "rod"
            ctx.suspect(Suspicion(what, ctx.users_place(site.span), nodes, radius, function.name))
    if fact := _FITS.fullmatch(definition.fact("Fits") or ""):
        field, period = bound.get(fact[1]), bound.get(fact[3])
        if isinstance(field, Scalar) and isinstance(period, Scalar) and ctx.constant(period.node) != 0:
            found = nature(ctx.natures, field.node)
            if found is not None and found.raw:
                nodes = (field.node, period.node, result.node)
                spot = given[fact[3]].span if fact[3] in given else None
                place = ctx.users_place(site.span)
                ctx.suspect(Suspicion("fits", place, nodes, spot, definition.name, fact[2], found.period))


def turned(
    ctx: Context,
    definition: tree.Def,
    bound: Mapping[str, Value],
    given: Mapping[str, Given],
    result: Scalar,
    site: tree.Call,
) -> None:
    """Suspect a direction that is 0, and a lattice that is not the same after the turns that are taken for one."""
    v, up = bound.get(definition.fact("Follows") or ""), bound.get("up")
    if not isinstance(v, Vector) or not result.node.axes or result.node.depends >= UNKNOWN:
        return
    place = ctx.users_place(site.span)
    followed = given[definition.fact("Follows") or ""].span if site.span == place and given else None
    if v.x.op != "principal":  # which is never 0
        ctx.suspect(Suspicion("still", place, (*v.nodes, result.node), followed, definition.name))
    fact = _FOLDS.fullmatch(definition.fact("Folds") or "")
    if fact is None or not isinstance(up, Vector):
        return
    field, symmetry, about = (bound.get(name) for name in fact.groups())
    if not (isinstance(field, Scalar) and isinstance(symmetry, Scalar) and isinstance(about, Vector)):
        return
    found, times = nature(ctx.natures, field.node), ctx.constant(symmetry.node)
    if found is None or not found.raw or times is None or times < 2:
        return
    nodes = (field.node, symmetry.node, *about.nodes, *v.nodes, *up.nodes, result.node)
    spot = given[fact[3]].span if fact[3] in given else None
    ctx.suspect(Suspicion("fold", place, nodes, spot, definition.name, period=found.period))


def _instead(definition: tree.Def, given: Mapping[str, Given]) -> str:
    """What the documentation proposes in place of a call, with the texts of its arguments."""
    proposed = definition.fact("Instead")
    if proposed is None:
        return ""
    texts = {name: value_of(g.span).text for name, g in given.items()}
    return re.sub(r"\w+", lambda word: texts.get(word[0], word[0]), proposed)


# ---- layout ---------------------------------------------------------------------------------------------------------


def pipe_below_set(ctx: Context, t: tree.Chain) -> None:
    """Doubt a `|>` that begins a line below `a & b`: it takes b alone."""
    if t.span.source.prelude or t.rest[0][0] not in _SETS:
        return
    at, right = t.op_spans[-1], t.rest[-1][1]
    while isinstance(right, tree.Chain) and right.rest[0][0] in _SETS and not bracketed(right):
        at, right = right.op_spans[-1], right.rest[-1][1]
    if not isinstance(right, tree.Chain) or right.rest[0][0] != "|>" or bracketed(right):
        return
    pipe = right.op_spans[0]
    depth = _leading(pipe)
    if depth is None or pipe.line <= at.line:
        return
    own = _leading(at)
    if own is not None and depth > own:  # laid out as belonging to what stands on that line
        return
    alone = right.first.span
    whole = Span(t.span.source, t.first.span.start, alone.end)
    call = " ".join(right.rest[0][1].span.text.split())
    doubt(
        ctx,
        "W217",
        f"`|> {call}` takes `{short(alone.text)}` alone, not what stands before `{at.text}`",
        pipe,
        "binds more tightly than the operator above",
        f"put what it is to take into brackets: `({short(whole.text)}) |> {call}`",
        others=(Label(alone, "this is what it takes"),),
        edit=Edit(whole, f"({whole.text})"),
    )


def _leading(span: Span) -> int | None:
    """How far a token that begins its line is indented; None if something stands before it."""
    before = span.source.text[: span.start].rpartition("\n")[2]
    return None if before.strip() else len(before.expandtabs(4))


def bracketed(t: tree.Chain) -> bool:
    """Whether a chain stands in parentheses."""
    return t.span.start < t.first.span.start
