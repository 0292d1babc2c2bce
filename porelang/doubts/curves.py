"""Curves that miss their points or the rod beside them, and parts that reach the centre of a bend, where all sections
meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Label
from porelang.doubts.parts import Part, parts_of
from porelang.elaborate.bare import value_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import X, Y, Z, order, within

Points = NDArray[np.float64]
#: A corner is missed if the curve passes it by more than this part of the room that its arc has: one that turns by more
#: than 106 degrees, with the greatest arc.
MISSED = 0.5
#: So many points are looked at within this part of the radius of a bend about its centre, and so many make a doubt.
NEAR, LOOKED, FEW = 0.1, 500, 8
#: Corners that turn by less (the tangent of half the angle) have wide arcs of which a part may well hold the centre.
STRAIGHT = 0.1
#: A rod is along another curve if that is so many mm away, and more than a tenth of what its corners are cut by.
APART, CUT = 0.1, 0.1
#: What moves a part moves all of its points as one, to so many mm.
STRAY = 1e-6


@dataclass(frozen=True, slots=True)
class _Corner:
    """A corner of a curve: its place, the directions before and after it, the tangent of half its turn, the radius of
    its arc, and how much room (mm) of its pieces that has."""

    place: Points
    one: Points
    other: Points
    steep: float
    r: float
    room: float

    @property
    def miss(self) -> float:
        """How far the arc passes it, in mm."""
        return self.r * (float(np.hypot(1, self.steep)) - 1)

    def __str__(self) -> str:
        return f"({coordinates(self.place, 3)})"


def bend(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A curve that misses a corner of its points, that bends within the part that follows it, or is not that of its
    rod."""
    corners = _corners(s, bindings)
    if (told := _beside_its_rod(s, corners, found, bindings)) is not None:
        return told
    for c in corners:
        if c.miss > MISSED * c.room:
            return Diagnostic(
                "W240",
                f"the curve of `{s.name}` passes the corner {c} by {c.miss:.3g} mm",
                s.span,
                f"it is rounded there by an arc of {c.r:.3g} mm",
                hint="give several points round it, each of which turns less",
                severity="warning",
            )
        if c.steep > STRAIGHT and _reached(s, found, bindings, c):
            return Diagnostic(
                "W240",
                f"the part reaches the centre of a bend of `{s.name}`, where all sections meet",
                s.span,
                f"the bend at {c} has a radius of {c.r:.3g} mm",
                hint="take a wider bend, or a rod thinner than it: cells break on the inside",
                severity="warning",
            )
    return None


def _corners(s: Suspicion, bindings: Bindings) -> list[_Corner]:
    """The corners of a curve; none where it takes long to say where they are."""
    _, radius, closed, *rest = s.nodes
    at = None if any(n.axes for n in s.nodes[1:]) else sampler([radius, closed, *rest], bindings)
    if at is None:
        return []
    asked, joined, *numbers = (float(v[0]) for v in at(np.zeros((1, 3))))
    q = np.array(numbers).reshape(-1, 3)
    legs = (np.roll(q, -1, axis=0) - q)[: None if joined else -1]
    size = np.linalg.norm(legs, axis=1)
    if not np.isfinite(q).all() or len(legs) < 2 or size.min() <= 0:
        return []
    ways, room = legs / size[:, None], size / 2
    if not joined:
        room[[0, -1]] *= 2
    out = []
    for i in range(len(legs) if joined else len(legs) - 1):
        j = (i + 1) % len(legs)
        cosine, least = float(ways[i] @ ways[j]), float(min(room[i], room[j]))
        steep = float(np.sqrt(max(1 - cosine, 0.0) / max(1 + cosine, 1e-9)))  # the tangent of half the turn
        r = asked or least / max(steep, 1 / 200)
        out.append(_Corner(q[(i + 1) % len(q)], ways[i], ways[j], steep, r, least))
    return out


def _beside_its_rod(
    s: Suspicion, corners: Sequence[_Corner], found: Elaborated, bindings: Bindings
) -> Diagnostic | None:
    """A lattice along one curve in a rod along another, past the same corners."""
    rods = [r for r in found.suspicions if r.what == "rod"]
    outputs = [set(order(o.nodes, within)) for o in found.outputs.values()] if rods else []
    beside: list[tuple[float, _Corner, _Corner, Suspicion]] = []
    for rod in rods:
        others = _corners(rod, bindings)
        one, other = (np.array([(c.place, c.one, c.other) for c in some]) for some in (corners, others))
        if not any(s.nodes[0] in nodes and rod.nodes[0] in nodes for nodes in outputs):
            continue
        if not others or one.shape != other.shape or not np.allclose(one, other):
            continue
        pairs = [(abs(a.miss - b.miss), a, b) for a, b in zip(corners, others, strict=True)]
        off, ours, its = max(pairs, key=lambda pair: pair[0])
        if off <= max(APART, CUT * max(ours.miss, its.miss)):
            return None  # it follows this one, and another of its points is there for something else
        beside.append((off, ours, its, rod))
    if not beside:
        return None
    off, ours, its, rod = min(beside, key=lambda pair: pair[0])
    given = s.argument or rod.argument
    hint = "give both the same `bend`"
    if given is not None and (s.argument is None or rod.argument is None):
        asks, takes = (s, rod) if rod.argument is None else (rod, s)
        text = " ".join(value_of(given).text.split())
        hint = f"give `{takes.name}` the same, `bend={text}`, or leave it out of `{asks.name}`"
    return Diagnostic(
        "W240",
        f"`{rod.name}` is not along the curve of `{s.name}`: they pass the corner {ours} {off:.3g} mm apart",
        s.span,
        f"cells follow an arc of {ours.r:.3g} mm there",
        (Label(rod.span, f"the rod one of {its.r:.3g} mm"),),
        hint,
        severity="warning",
    )


def _reached(s: Suspicion, found: Elaborated, bindings: Bindings, c: _Corner) -> bool:
    """Whether a lattice along a curve is seen about the centre of an arc, as far from the curve as that is."""
    made = s.nodes[0]
    if made.op != "at":
        return False
    inward = (c.other - c.one) / np.linalg.norm(c.other - c.one)
    centre = c.place + c.r * float(np.hypot(1, c.steep)) * inward
    points = centre + c.r * NEAR * np.random.default_rng(1).uniform(-1, 1, (LOOKED, 3))
    across = sampler(made.args[2:], bindings)
    if across is None:
        return False
    points = points[np.hypot(*across(points)) > (1 - 2 * NEAR) * c.r]  # not where another part of the curve is nearer
    for part, places in parts_of(made, found, bindings):
        there = _moved(part, points, places, bindings)
        if there is not None and int(part.shows(there).sum()) >= FEW:
            return True
    return False


def _moved(part: Part, points: Points, places: Points, bindings: Bindings) -> Points | None:
    """Where points of a lattice's own place lie in a part that moves, turns or scales it; None where it bends it."""
    own = sampler([part.seen(c) for c in (X, Y, Z)], bindings)
    if own is None or not len(points):
        return None
    from_there = np.column_stack([np.stack(own(places), -1), np.ones(len(places))])
    back, *_ = np.linalg.lstsq(from_there, places, rcond=None)
    if np.abs(from_there @ back - places).max() > STRAY:
        return None
    return np.asarray(np.column_stack([points, np.ones(len(points))]) @ back)
