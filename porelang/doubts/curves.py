"""Curves that are not where their points are, and parts that reach the centre of a bend, where all sections meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic
from porelang.doubts.parts import Part, parts_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import X, Y, Z

Points = NDArray[np.float64]
#: A corner is missed if the curve passes it by more than this part of the room that its arc has: one that turns by more
#: than 106 degrees, with the greatest arc.
MISSED = 0.5
#: So many points are looked at within this part of the radius of a bend about its centre, and so many make a doubt.
NEAR, LOOKED, FEW = 0.1, 500, 8
#: Corners that turn by less (the tangent of half the angle) have wide arcs of which a part may well hold the centre.
STRAIGHT = 0.1
#: What moves a part moves all of its points as one, to so many mm.
STRAY = 1e-6


def bend(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A curve that misses a corner of its points, or that bends within the part that follows it."""
    _, radius, closed, *rest = s.nodes
    at = None if any(n.axes for n in s.nodes[1:]) else sampler([radius, closed, *rest], bindings)
    if at is None:
        return None
    asked, joined, *numbers = (float(v[0]) for v in at(np.zeros((1, 3))))
    q = np.array(numbers).reshape(-1, 3)
    legs = (np.roll(q, -1, axis=0) - q)[: None if joined else -1]
    size = np.linalg.norm(legs, axis=1)
    if not np.isfinite(q).all() or len(legs) < 2 or size.min() <= 0:
        return None
    ways, room = legs / size[:, None], size / 2
    if not joined:
        room[[0, -1]] *= 2
    for i in range(len(legs) if joined else len(legs) - 1):
        j = (i + 1) % len(legs)
        cosine, least = float(ways[i] @ ways[j]), min(room[i], room[j])
        steep = float(np.sqrt(max(1 - cosine, 0.0) / max(1 + cosine, 1e-9)))  # the tangent of half the turn
        r = asked or least / max(steep, 1 / 200)
        miss = r * (float(np.hypot(1, steep)) - 1)
        corner = f"({coordinates(q[(i + 1) % len(q)], 3)})"
        if miss > MISSED * least:
            return Diagnostic(
                "W240",
                f"the curve of `{s.name}` passes the corner {corner} by {miss:.3g} mm",
                s.span,
                f"it is rounded there by an arc of {r:.3g} mm",
                hint="give several points round it, each of which turns less",
                severity="warning",
            )
        if steep > STRAIGHT and _reached(s, found, bindings, (q[(i + 1) % len(q)], ways[i], ways[j], r, steep)):
            return Diagnostic(
                "W240",
                f"the part reaches the centre of a bend of `{s.name}`, where all sections meet",
                s.span,
                f"the bend at {corner} has a radius of {r:.3g} mm",
                hint="take a wider bend, or a rod thinner than it: cells break on the inside",
                severity="warning",
            )
    return None


def _reached(
    s: Suspicion, found: Elaborated, bindings: Bindings, arc: tuple[Points, Points, Points, float, float]
) -> bool:
    """Whether a lattice along a curve is seen about the centre of an arc, as far from the curve as that is."""
    made = s.nodes[0]
    if made.op != "at":
        return False
    corner, one, other, r, steep = arc
    inward = (other - one) / np.linalg.norm(other - one)
    centre = corner + r * float(np.hypot(1, steep)) * inward
    points = centre + r * NEAR * np.random.default_rng(1).uniform(-1, 1, (LOOKED, 3))
    across = sampler(made.args[2:], bindings)
    if across is None:
        return False
    points = points[np.hypot(*across(points)) > (1 - 2 * NEAR) * r]  # not where another part of the curve is nearer
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
