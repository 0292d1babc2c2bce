"""Lattices that do not meet themselves, where a turn closes or a phase passes from one formula to another; and such as
are squashed by a turn."""

from __future__ import annotations

import math
import re

import numpy as np

from porelang.analysis.sampled import MOST, Points, Sampler, number, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.lattices import FEW
from porelang.doubts.parts import parts_of, reads_tasks
from porelang.elaborate.bare import value_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import ONE, ZERO, Node, X, Y, Z, const, node, order, within
from porelang.rewrites import flatten

#: Within this angle (rad) of a seam on both sides a part reaches it.
BESIDE = 0.2
#: A cell that is longer one way than another by more than this factor is told of, where most of a ring is such.
STRETCHED = 2.0
#: Points of a part that are joined over a seam, each with so many others.
_JOINED, _NEIGHBOURS = 1000, 4


def seam(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A lattice that is bent round and does not meet itself after a full turn, or that is squashed by it."""
    lattice, turn, made = s.nodes
    full = number(turn, bindings)
    if full is None or full == 0:
        return None
    if reads_tasks(lattice):  # which know it where the part is
        return _torn(s, full, found, bindings)
    if _closes(lattice, full, bindings):
        return _squashed(s, found, bindings, full)
    if not _seen(made, found, bindings):
        return None
    period = None if s.period is None else number(s.period, bindings)
    hint, edit = "take a whole multiple of the lattice's period", None
    if period:
        times = max(1, round(full / period))
        if _closes(lattice, times * period, bindings):
            hint = f"take a whole multiple of the period: {times:g} x {period:g} = {times * period:g}"
            edit = _instead(s, times * period)
    return Diagnostic(
        "W218",
        f"`{s.name}` leaves a seam: after a full turn of {full:g} mm the lattice does not meet itself",
        s.argument or s.span,
        f"{full / period:.4g} periods" if period else "no whole number of periods",
        hint=hint,
        edit=edit,
        severity="warning",
    )


def _torn(s: Suspicion, full: float, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A seam of a lattice whose cells were found, or whose period is: looked at where a part reaches it."""
    lattice, _, made = s.nodes
    for part, points in parts_of(made, found, bindings):
        own, at = sampler([part.seen(c) for c in (X, Y, Z)], bindings), sampler([made], bindings)
        if own is None or at is None:
            continue
        x, y, z = own(points)
        near = np.abs(np.arctan2(y, x)) > math.pi - BESIDE
        if min((near & (y > 0)).sum(), (near & (y < 0)).sum()) < FEW:
            continue
        rho, z = np.hypot(x, y)[near], z[near]
        places = [np.stack([-rho, side * 1e-9 * rho, z], -1) for side in (1, -1)]
        one, other = (at(p)[0] < 0 for p in places)
        cut, solid = one != other, one | other
        if cut.sum() < FEW or cut.sum() < 0.05 * solid.sum():
            continue
        hint = "let the lattice have one period along y, a whole part of that turn"
        if any(n.op == "phase" for n in order(flatten(lattice))):
            hint += ": `phase([w, turn / n, w], ...)`"
        return Diagnostic(
            "W218",
            f"`{s.name}` leaves a seam: after a full turn of {full:g} mm the lattice does not meet itself",
            s.argument or s.span,
            "cells are cut along the half plane y = 0, x < 0 of its coordinates",
            hint=hint,
            severity="warning",
        )
    return None


def _instead(s: Suspicion, length: float) -> Edit | None:
    """Another length of a full turn, where one was written as a number."""
    if s.argument is None or not re.fullmatch(r"(?:\w+\s*=\s*)?[\d.]+\s*(?:mm)?", s.argument.text):
        return None
    return Edit(value_of(s.argument), f"{length:g}{'mm' if s.argument.text.endswith('mm') else ''}")


def _squashed(s: Suspicion, found: Elaborated, bindings: Bindings, full: float) -> Diagnostic | None:
    """A lattice bent round with so many cells, or so few, that most of what is seen of it is longer than wide by more
    than `STRETCHED`; near the axis cells are narrower, and far from it wider, with any number of them."""
    lattice, _, made = s.nodes
    period = None if s.period is None else number(s.period, bindings)
    if made.op != "at" or not period:
        return None
    slopes = [node("d", made.args[2], value=axis) for axis in range(3)]
    for part, points in parts_of(made, found, bindings):
        at = sampler([part.seen(n) for n in slopes], bindings)
        if at is None:
            continue
        rates = np.linalg.norm(at(points), axis=0)  # of its mm along y to one of the part
        known = np.isfinite(rates) & (rates > 0)
        points, rates = points[known], rates[known]
        if len(rates) < FEW:
            continue
        middle = float(np.median(rates))
        factor = np.maximum(rates, 1 / rates)
        best = period * max(1, round(full / middle / period))
        least = np.maximum(rates * best / full, full / (rates * best))
        if np.median(factor) <= STRETCHED or np.median(least) > STRETCHED or not _closes(lattice, best, bindings):
            continue
        share, worst = round(100 * float((factor > STRETCHED).mean())), factor >= np.median(factor)
        cells = round(full / period), round(best / period)
        return Diagnostic(
            "W239",
            f"`{s.name}` stretches cells beyond {STRETCHED:g}:1 in {share} % of the part: {cells[0]} to a full turn",
            s.argument or s.span,
            f"by {float(np.median(factor)):.2g}:1 or more at ({coordinates(points[worst][0], 3)}), for one",
            hint=f"take a full turn of {best:g} mm: {cells[1]} of {period:g} mm, as wide as long in its middle",
            edit=_instead(s, best),
            severity="warning",
        )
    return None


def jump(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A lattice that is cut where its phase passes from one formula to another, as over the edges of `sphere_map`, or
    where an angle in it passes from half a turn to minus half a turn."""
    lattice, *turns = s.nodes
    flat = order(flatten(*turns), within)
    tests = [n.args[0] for n in flat if n.op == "select" and n.args[0].axes]
    angles = list(dict.fromkeys(n.args for n in flat if n.op == "atan2" and n.axes))
    tests += [node("lt", up, ZERO) for up, _ in angles if up.axes]
    cosines = [node("cos", const(math.tau) * u) for u in turns]
    primitive = cosines[0] + cosines[1] + cosines[2]  # is the same along all axes, and mirrored
    for part, points in parts_of(lattice, found, bindings):
        which = sampler([part.seen(node("select", test, ONE, ZERO)) for test in tests], bindings)
        at = sampler([part.seen(n) for n in (primitive, *turns)], bindings)
        solid_at = sampler([part.root], bindings)
        if which is None or at is None or solid_at is None:
            continue
        ends = _between(which, points[:_JOINED])
        if ends is None:
            continue
        one, other = (np.concatenate([solid_at(end), at(end)]) for end in ends)
        solid, cut = (one[0] < 0) | (other[0] < 0), (one[0] < 0) != (other[0] < 0)
        if cut.sum() < FEW or cut.sum() < 0.05 * solid.sum():
            continue
        alike = float(np.mean(np.abs(one[1] - other[1]) > 1e-3)) < 0.05
        # how many turns of the phase are lost or gained, where that is the same all along the seam
        lost = np.abs(one[2:5] - other[2:5])[:, cut].max(axis=0)
        turned = bool(angles) and not any(n.op == "select" and n.args[0].axes for n in flat)
        return _seams(s, found, ends[0][cut][0], alike, float(np.median(lost)) if turned and np.ptp(lost) < 1e-3 else 0)
    return None


def _seams(s: Suspicion, found: Elaborated, place: Points, alike: bool, lost: float) -> Diagnostic:
    """Of a place where cells do not meet; `alike` where those would that are the same along all axes; of how many turns
    are `lost` where an angle begins again, if that is it."""
    lattice = s.nodes[0]
    if lost > 0:
        return Diagnostic(
            "W218",
            f"`{s.name}` has a seam: its cells do not meet where an angle in its phase begins again",
            s.argument or s.span,
            f"{lost:.4g} cells to a full turn, cut at ({coordinates(place, 3)}), for one",
            hint=f"let a full turn be a whole number of cells: {max(1, math.floor(lost + 0.501))}",
            severity="warning",
        )
    hint = "let both formulas of the phase meet where one takes over from the other"
    asked = next((o.argument for o in found.suspicions if o.what == "period" and o.nodes[0] is lattice), None)
    if asked is not None:  # a period that jumps: p / w does, too
        call = f"phase=phase({' '.join(value_of(asked).text.split())}, ...)"
        hint = (
            f"write `{call}` with the solid that it fills: no cell is cut; or `crossfade` lattices of one period each"
        )
    elif alike:
        hint = "take `schwarz_p`, `iwp`, `neovius` or `diamond`: they are the same along all axes, and mirrored"
    return Diagnostic(
        "W218",
        f"`{s.name}` has seams: its cells do not meet where the phase passes from one formula to another",
        s.argument or s.span,
        f"at ({coordinates(place, 3)}), for one",
        hint=hint,
        severity="warning",
    )


def _between(which: Sampler, points: Points) -> tuple[Points, Points] | None:
    """Pairs of places a nanometre apart for which conditions differ, each between a point and the nearest of those for
    which they do: what joins points far apart goes through the hollow of a shell, and not through the shell."""
    of_all = np.stack(which(points), -1)
    _, kind = np.unique(of_all, axis=0, return_inverse=True)
    square = (points**2).sum(axis=1)
    away = square[:, None] + square - 2 * points @ points.T
    away[kind[:, None] == kind] = np.inf
    several = min(_NEIGHBOURS, len(points) - 1)
    nearest = np.argpartition(away, several, axis=1)[:, :several] if several else np.zeros((len(points), 0), np.int64)
    first, second = np.repeat(np.arange(len(points)), several), nearest.ravel()
    differ = kind[first] != kind[second]
    a, b, of_a = points[first[differ]], points[second[differ]], of_all[first[differ]]
    if not len(a):
        return None
    for _ in range(30):
        middle = (a + b) / 2
        same = (np.stack(which(middle), -1) == of_a).all(1)[:, None]
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    return a, b


def _seen(made: Node, found: Elaborated, bindings: Bindings) -> bool:
    """Whether what lies at x < 0, y = 0 of a field can be seen in an output: a sector beside it has no seam."""
    random = np.random.default_rng(1)
    x = -(10 ** random.uniform(-1, 2.5, MOST))
    z = random.uniform(-1, 1, MOST) * 10 ** random.uniform(0, 2.5, MOST)
    for output in found.outputs.values():
        reached = order(output.nodes, lambda n: n.args[1:] if n.op == "at" else within(n))
        if made not in reached:  # it is not in it, or it was moved
            if made in order(output.nodes, within):
                return True
            continue
        at = sampler(output.nodes, bindings)
        if at is None:  # it is looked at again when it is known what that reads
            continue
        sides = [np.stack([x, 1e-6 * side * x, z], axis=1) for side in (-1, 1)]
        if any(bool(((a < 0) != (b < 0)).any()) for a, b in zip(at(sides[0]), at(sides[1]), strict=True)):
            return True
    return False


def _closes(lattice: Node, turn: float, bindings: Bindings) -> bool:
    """Whether a lattice is the same at y = -turn/2 and y = turn/2, on most of that plane."""
    points = np.random.default_rng(1).uniform(-100, 100, (MOST // 4, 3))
    ends = [node("at", lattice, X, (side * 0.5 * turn) + 0.0 * Y, Z) for side in (1, -1)]
    at = sampler(ends, bindings)
    if at is None:
        return True
    one, other = at(points)
    return float(np.mean((one < 0) != (other < 0))) < 0.005
