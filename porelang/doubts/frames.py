"""What values show to be a mistake of local frames and of coordinates that follow a shape: directions that are 0, turns
that a lattice does not share, and periods that it does not have."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import MOST, about_the_origin, number, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.parts import parts_of, reads_tasks
from porelang.elaborate.bare import value_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import Node
from porelang.source import Span

Points = NDArray[np.float64]
#: As many points of a part make a doubt.
FEW = 8
#: A shorter vector has no direction, as `direction` of the prelude has it.
SHORTEST = 1e-12
#: As near, as a sine, directions come to those where one of two opposite ones is exchanged for the other.
NEAR = 0.1
#: Lattices are looked for an axis in such parts of their period.
PARTS = 8


def still(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A direction that is 0 in some of a part: the cells there are not turned."""
    *v, made = s.nodes
    at = sampler(v, bindings)
    if at is None or not (np.linalg.norm(np.stack(at(about_the_origin()), -1), axis=1) < SHORTEST).any():
        return None
    for part, points in parts_of(made, found, bindings):
        seen = sampler([part.seen(n) for n in v], bindings)
        if seen is None:
            continue
        none = np.linalg.norm(np.stack(seen(points), -1), axis=1) < SHORTEST
        if none.sum() < FEW:
            continue
        share = max(1, round(100 * none.sum() / len(points)))
        return Diagnostic(
            "W235",
            f"the direction that `{s.name}` follows is 0 in {share} % of the part: the cells are not turned there",
            s.span if s.argument is None else s.argument,
            f"it is 0 at ({coordinates(points[none][0], 3)}), for one",
            hint="give it a direction there, as in `if length(v) > 0 then v else [1, 0, 0]`",
            severity="warning",
        )
    return None


def fold(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A lattice that is not the same after turns that are taken for one, where directions pass from one to another."""
    field, symmetry, about, made = s.nodes[0], s.nodes[1], s.nodes[2:5], s.nodes[-1]
    times, centre = number(symmetry, bindings), [number(n, bindings) for n in about]
    if times is None or any(c is None for c in centre) or reads_tasks(field):
        return None
    times = round(times)
    if _is_symmetric(field, times, np.array(centre), bindings):
        return None
    for part, points in parts_of(made, found, bindings):
        frame = sampler([part.seen(n) for n in s.nodes[5:11]], bindings)
        if frame is not None and _passes(np.stack(frame(points), -1), times):
            break
    else:
        return None
    turn = {2: "half a turn", 4: "a quarter of a turn"}[times]
    message = f"`{s.name}` leaves breaks: the lattice is not the same after {turn} about z through `about`"
    label = f"`symmetry={times}` takes directions for one that the lattice tells apart"
    hint, edit = "take `schwarz_p`, `iwp` or `neovius`, which are the same, or leave `symmetry` out", None
    w = None if s.period is None else number(s.period, bindings)
    axis = None if w is None else _axis(field, times, w, bindings)
    if axis is not None and s.period is not None:
        ours = ", ".join(_part(k, s.period, w or 0.0) for k in (*axis, 0))
        hint = f"an axis of such turns runs through `about=[{ours}]`"
        if s.argument is not None:
            edit = Edit(value_of(s.argument), f"[{ours}]")
        elif s.span.text.endswith(")"):
            end = s.span.end
            edit = Edit(Span(s.span.source, end - 1, end), f", about=[{ours}])")
    elif times == 4 and w is not None and _axis(field, 2, w, bindings) is not None:
        hint = "this lattice has no quarter turns: take `symmetry=2`, or `schwarz_p`, `iwp` or `neovius`"
    return Diagnostic("W236", message, s.span, label, hint=hint, edit=edit, severity="warning")


def fits(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """A number that is no period of the lattice that is fitted by it."""
    field, asked, _ = s.nodes
    given, at = number(asked, bindings), sampler([field], bindings)
    if given is None or at is None or given <= 0 or reads_tasks(field):
        return None
    points = np.random.default_rng(1).uniform(-100, 100, (MOST // 8, 3))
    there = points + given * np.eye(3)["xyz".index(s.instead)]
    if float(np.mean((at(points)[0] < 0) != (at(there)[0] < 0))) < 0.005:
        return None
    w = None if s.period is None else number(s.period, bindings)
    if w and abs(given / w - round(given / w)) < 1e-6:
        return None  # what varies besides its waves may do so along them: walls that grow
    hint, edit = "give it the period of the lattice", None
    if w is not None and s.period is not None:
        ours = str(s.period.value) if s.period.op == "param" else f"{w:g}mm"
        hint = f"the period is {w:g} mm: write `w={ours}`"
        edit = None if s.argument is None else Edit(value_of(s.argument), ours)
    return Diagnostic(
        "W218",
        f"`{s.name}` leaves a seam: {given:g} mm is no period of the lattice",
        s.argument or s.span,
        f"a whole number of cells of {given:g} mm is made to fit",
        hint=hint,
        edit=edit,
        severity="warning",
    )


def _passes(frame: Points, times: int) -> bool:
    """Whether directions in a part come near those where one is exchanged for another, from both sides."""
    v, up = frame[:, :3], frame[:, 3:]
    with np.errstate(all="ignore"):
        a = v / np.linalg.norm(v, axis=1, keepdims=True)
        b = np.cross(up, a)
        b /= np.linalg.norm(b, axis=1, keepdims=True)
        along, across = (e @ (np.array([9.0, 3.0, 1.0]) / np.sqrt(91.0)) for e in (a, b))
        margin = along if times == 2 else np.abs(along) - np.abs(across)
        return min(int(((side > 0) & (side < NEAR)).sum()) for side in (margin, -margin)) >= FEW


def _is_symmetric(field: Node, times: int, centre: Points, bindings: Bindings) -> bool:
    """Whether a field is the same after a part of a turn about an axis along z; so where it takes long to say."""
    at = sampler([field], bindings)
    if at is None:
        return True
    points = np.random.default_rng(1).uniform(-100, 100, (MOST // 8, 3))
    x, y, z = points.T
    turned = np.stack([-x, -y, z] if times == 2 else [-y, x, z], -1)
    one, other = at(points + centre)[0], at(turned + centre)[0]
    return float(np.mean((one < 0) != (other < 0))) < 0.005


def _axis(field: Node, times: int, w: float, bindings: Bindings) -> tuple[int, int] | None:
    """Where an axis of such turns runs, in eighths of the period."""
    for i, j in sorted(product(range(PARTS), repeat=2), key=sum):
        if _is_symmetric(field, times, np.array([i, j, 0]) * (w / PARTS), bindings):
            return i, j
    return None


def _part(k: int, period: Node, w: float) -> str:
    """Some eighths of a period, as one would write them."""
    if k == 0:
        return "0"
    if period.op != "param":
        return f"{k * w / PARTS:g}"
    up, down = (k, PARTS)
    while up % 2 == 0:
        up, down = up // 2, down // 2
    return f"{period.value} / {down}" if up == 1 else f"{up} * {period.value} / {down}"
