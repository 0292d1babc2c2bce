"""Lattices with a field as `w`: how long their cells really are within the part.

A lattice of the period w(p) is a wave of p / w(p), whose length is not w: it is 1 / |grad(x / w)|, and drifts from w
with the distance from the origin. What is said of one is what its cells are at a place of the part.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import inside_of, sampler
from porelang.data import SampledField, coordinates
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.parts import Way, seen_from, way_to
from porelang.elaborate.bare import value_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import Node, const, node, order, substitute, within
from porelang.rewrites import flatten

#: By how much cells may miss the period that is asked for before it is said, and as many of the points looked at.
OFF = 0.25
FEW = 8
#: A cell so many times as long as it should be has no length to be told.
ENDLESS = 20.0


def drifting(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A warning where cells of a lattice are not as long as `w` says, with the place where they miss it most."""
    lattice, *rest = s.nodes
    periods, turns = rest[:3], rest[3:]
    rates = [node("sqrt", sum((g * g for g in (node("d", u, value=a) for a in range(3))), const(0.0))) for u in turns]
    for output in found.outputs.values():
        if len(output.nodes) != 1:
            continue
        way = way_to(lattice, output.nodes[0])
        if way is None:
            continue
        around = _around(way)
        points = None if around is None else inside_of(around, bindings)
        if points is None:
            points = inside_of(output.nodes[0], bindings)
        at = sampler([seen_from(way, n) for n in (*periods, *rates)], bindings)
        if points is None or at is None or not len(points):
            continue
        values = np.stack(at(points))
        asked, real = values[:3], 1 / np.maximum(values[3:], 1e-12)
        if not (asked > 0).all():  # that is another fault, and is told
            return None
        off = np.nan_to_num(np.abs(np.log(real / asked)), posinf=0.0)
        if (off.max(axis=0) > np.log(1 + OFF)).sum() < FEW:
            return None
        axis, i = (int(v) for v in np.unravel_index(int(np.argmax(off)), off.shape))
        moved = any(n.op == "at" for n, _ in way)  # the solid lies elsewhere, seen from the lattice
        solid = None if around is None or moved else _name_of(around, found, s)
        cell = "xyz"[axis], float(asked[axis, i]), float(real[axis, i])
        return _told(s, points[i], cell, solid, moved)
    return None


def beyond(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A warning where a part reaches beyond the box in which the phase of its lattice is known, and shows it there."""
    lattice, *turns = s.nodes
    looked = [n for n in order(flatten(*turns), within) if n.op == "lookup_cubic" and n.args[0].op == "phase"]
    if not looked or any(n.args[0] not in bindings for n in looked):
        return None
    known, coordinates_of = bindings[looked[0].args[0]], looked[0].args[1:4]
    assert isinstance(known, SampledField)
    for root in bodies(found):
        way = way_to(lattice, root)
        if way is None:
            continue
        around = _around(way)
        points = inside_of(root if around is None else around, bindings)
        at = sampler([*(seen_from(way, n) for n in coordinates_of)], bindings)
        seen = sampler([root, substitute([root], {lattice: lattice + const(1e-3)})[0]], bindings)
        if points is None or at is None or seen is None:
            continue
        places = np.stack(at(points), -1)
        out = np.asarray(((places < known.origin) | (places > known.end)).any(axis=1))
        if out.any():
            with_it, without = seen(points[out])
            out[out] = with_it != without
        if out.sum() < FEW:
            return None
        share = max(1, round(100 * out.sum() / len(points)))
        solid = None if around is None or any(n.op == "at" for n, _ in way) else _name_of(around, found, s)
        far = points[out][int(np.argmax(np.abs(places[out] - np.mean([known.origin, known.end], 0)).max(1)))]
        return Diagnostic(
            "W237",
            f"the part reaches beyond the solid within which the phase of `{s.name}` was found, by {share} % of it",
            s.argument or s.span,
            f"known from ({coordinates(known.origin, 3)}) to ({coordinates(known.end, 3)}), and the part reaches "
            f"({coordinates(far, 3)}); beyond, cells are drawn out into bars",
            hint=f"find the phase within {f'`{solid}`' if solid else 'a solid that holds the part'}: it is the second "
            "argument of `phase`",
            severity="warning",
        )
    return None


def bodies(found: Elaborated) -> list[Node]:
    """The outputs of one number, with the fields that they read as samples in place of those: a lattice is in them."""
    roots = [o.nodes[0] for o in found.outputs.values() if len(o.nodes) == 1]
    while sampled := {n: f for n in order(roots, within) if (f := _sampled(n)) is not None}:
        roots = substitute(roots, sampled)
    return roots


def _sampled(n: Node) -> Node | None:
    """The field that a lookup reads the samples of."""
    if n.op not in ("lookup", "lookup_cubic") or n.args[0].op not in ("sample", "blur"):
        return None
    assert isinstance(n.value, tuple)
    return n.args[0].args[int(n.value[0])]


def _told(
    s: Suspicion, place: NDArray[np.float64], cell: tuple[str, float, float], solid: str | None, moved: bool
) -> Diagnostic:
    span, (axis, asked, real) = s.argument or s.span, cell
    text = value_of(s.argument).text if s.argument is not None else "..."
    if real > ENDLESS * asked:
        are = f"more than {ENDLESS:g} times as long as the {asked:.3g} mm that are asked for"
    else:
        are = f"{real:.3g} mm long, and {asked:.3g} mm are asked for"
    call = f"phase=phase({' '.join(text.split())}, {solid or '...'})"
    hint = f"write `{call}`: its cells have the size that is asked for, and it says how nearly"
    if solid is None:
        which = "that it fills, as that lies before the lattice is moved" if moved else "that it fills"
        hint = f"write `{call}` with the solid {which}: its cells have the size that is asked for"
    hint += "; or `phase=p / w` for just this"
    edit = Edit(span, call) if solid is not None and s.argument is not None else None
    return Diagnostic(
        "W228",
        f"cells of `{s.name}` are not as long as `w` says: at ({coordinates(place, 3)}) they are {are}",
        span,
        f"along {axis}; where a period varies, cells drift from it with the distance from the origin",
        (),
        hint,
        edit,
        "warning",
    )


def _name_of(around: Node, found: Elaborated, s: Suspicion) -> str | None:
    """How the text may name the solid that a lattice fills: a let above it, or what it is cut with beside it."""
    if s.argument is None or "phase" in {*found.lets, *found.params}:
        return None
    place = s.span.in_file
    before = place.source.text[: place.start]
    for name, value in found.lets.items():
        if value.node is around and re.search(rf"^let\s+{re.escape(name)}\s*=", before, re.MULTILINE):
            return name
    for cut in found.suspicions:
        beside = None if cut.argument is None else cut.argument.in_file
        if cut.what == "apart" and beside is not None and cut.nodes[1] is around and beside.source is place.source:
            between = place.source.text[place.end : beside.start]
            if beside.start > place.end and not re.search(r"\n\s*(let|out|def|check)\b|=>|[{}]", between):
                return " ".join(beside.text.split())
    return None


def _around(way: Way) -> Node | None:
    """What a lattice is cut with on the way; None where that is nothing."""
    solid: Node | None = None
    for n, i in reversed(way):
        if n.op == "max":
            other = n.args[1 - i]
            solid = other if solid is None else node("max", solid, other)
        elif n.op == "at" and solid is not None:
            solid = node("at", solid, *n.args[1:])
    return solid
