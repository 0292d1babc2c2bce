"""Copies that are cut, and walls that are solid or void throughout."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import EXACT, at_points, enclose
from porelang.analysis.sampled import inside_of, number, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Edit
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings, Formula
from porelang.interval import interval
from porelang.ir import SLOTS, order, param, substitute, within
from porelang.rewrites import flatten

#: As many of the points that were looked at make a suspicion a doubt.
FEW = 8
#: Of the range that samples of a lattice have: how far its values go beyond.
BEYOND = 0.01


def copies(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Copies that reach beyond their cell, and are cut there."""
    body, made, *cell = s.nodes
    points, at = inside_of(body, bindings), sampler([made], bindings)
    sizes = [number(w, bindings) for w in cell] or [0.0] * 3
    if points is None or at is None or any(w is None for w in sizes):
        return None
    points = points[:2500]
    least: NDArray[np.bool_] | None = None
    for bits in range(8 if cell else 1):  # a row of an even number has no copy in the middle
        shift = [0.5 * w * (bits >> i & 1) for i, w in enumerate(sizes) if w is not None]
        lost = at(points + shift)[0] > 0
        least = lost if least is None or lost.sum() < least.sum() else least
    assert least is not None
    share = least.sum() / len(points)
    if least.sum() < FEW or share < 0.002:
        return None
    parts = "sector" if not cell else "cell"
    far = points[least][int(np.argmax(np.abs(points[least]).sum(axis=1)))]
    place = coordinates(far, 3)
    if s.instead:
        hint = f"join copies that are turned one by one: `{s.instead}`"
    else:
        hint = "take larger cells, or join moved copies: `union([for i in range(n): translate(f, [w * i, 0, 0])])`"
    return Diagnostic(
        "W215",
        f"`{s.name}` cuts its copies: each is seen only in its own {parts}, and {max(1, round(100 * share))} % is lost",
        s.span,
        f"({place}) of the body, for one",
        hint=hint,
        edit=Edit(s.argument, s.instead) if s.argument is not None and s.instead else None,
        severity="warning",
    )


def pores(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Whether a wall is solid, or void, whatever value its lattice has."""
    walls, around = s.nodes
    lattices = [n for n in order([walls], within) if n in found.lattices]
    if not lattices:
        return None
    points, at = inside_of(around, bindings), sampler(lattices, bindings)
    if points is None or at is None:
        return None
    points = points[:500]
    ranges = at(np.random.default_rng(1).uniform(-100, 100, (1000, 3)))
    stand_in = {n: param(f"the value of lattice {i}") for i, n in enumerate(lattices)}
    replaced = flatten(substitute([walls], stand_in)[0])
    if any(n not in bindings for n in order(replaced, within) if n.op in SLOTS and n not in stand_in.values()):
        return None
    # samples do not reach the very ends of a range
    ends = [(r.min() - BEYOND * np.ptp(r), r.max() + BEYOND * np.ptp(r)) for r in ranges]
    levels = {p: interval(*end) for p, end in zip(stand_in.values(), ends, strict=True)}
    found_there = enclose(Formula(replaced, {**bindings, **levels}), at_points(points, EXACT))[0].range
    solid = bool((found_there.hi < 0).all())
    if (not solid and not (found_there.lo > 0).all()) or bool(found_there.nan.any()):
        return None
    low, high = min(float(r.min()) for r in ranges), max(float(r.max()) for r in ranges)
    return Diagnostic(
        "W224",
        f"`{' '.join(s.span.text.split())}` is {'solid' if solid else 'void'} everywhere: the lattice is lost",
        s.span,
        f"the lattice runs from {low:.2g} to {high:.2g}",
        hint="its values are raw, not mm: " + ("take less" if solid else "take more, or check the sign"),
        severity="warning",
    )
