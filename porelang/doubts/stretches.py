"""Cells that coordinates stretch or fold: what is looked up at other coordinates keeps its shape only where these
change as the point does, but for a turn and a size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import Points, Sampler, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, Edit
from porelang.doubts.parts import parts_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import X, Y, Z, order, within
from porelang.source import Span

#: As many points of a part are looked at, and the distance in mm to those beside them that tell the slopes.
POINTS, FEW, ASIDE = 1000, 50, 1e-4
#: A cell that is longer one way than another by more than this factor is told of, where more of the part than this
#: share has such cells, or such that are folded over.
STRETCHED, SHARE = 2.0, 0.05
#: A direction runs along `up` where the cosine of the angle between them is greater.
ALONG = 0.95
#: Beyond this factor there are no cells left to speak of.
FLAT = 100.0


def stretched(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Coordinates that give a lattice cells that are stretched, or folded over."""
    made, *given = s.nodes
    for part, points in parts_of(made, found, bindings):
        at = sampler([part.seen(n) for n in given[:3]], bindings)
        if at is None or len(points) < FEW or (told := _told(s, at, points[:POINTS])) is None:
            continue
        follows = sampler([*(part.seen(n) for n in given[3:]), *(part.seen(c) for c in (X, Y, Z))], bindings)
        up = None if not given[3:] or follows is None else _upright(follows, points[:POINTS])
        if up is None:
            return told
        end, text = s.span.end, f"up={up}"
        edit = Edit(Span(s.span.source, end - 1, end), f", {text})") if s.span.text.endswith(")") else None
        return replace(told, hint=f"it runs nearly along `up`, and the frame turns about it: write `{text}`", edit=edit)
    return None


def _slopes(at: Callable[[Points], Points], points: Points) -> tuple[Points, Points]:
    """How coordinates (n, 3) change along x, y and z (m, 3, 3), at the points at which they are known."""
    beside = [(at(points + e) - at(points - e)) / (2 * ASIDE) for e in ASIDE * np.eye(3)]
    slopes = np.stack(beside, -1)
    known = np.isfinite(slopes).all(axis=(1, 2))
    return points[known], slopes[known]


def _cells(slopes: Points) -> tuple[Points, NDArray[np.bool_]]:
    """By how much cells are longer one way than another, and which are folded over."""
    sizes = np.linalg.svd(slopes, compute_uv=False)  # of a mm in each of three directions at right angles
    volume = np.linalg.det(slopes)
    folded = volume * np.sign(np.median(volume)) < 0  # a lattice that is mirrored throughout is none
    return sizes[:, 0] / np.maximum(sizes[:, 2], 1e-12), folded


def _upright(at: Sampler, points: Points) -> str | None:
    """Another `up`, as text, with which the frame of a direction that runs along the given one leaves cells as they
    are; `at` samples that direction, `up`, `about` and the place."""

    def turned(points: Points, up: Points) -> Points:
        """Where a lattice is looked up with that `up`: see `align` of the prelude, but for opposite directions."""
        v, _, about, own = _threes(at(points))
        x = v / np.linalg.norm(v, axis=1, keepdims=True)
        y = np.cross(up, x)
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        return np.stack([((own - about) * e).sum(axis=1) for e in (x, y, np.cross(x, y))], -1)

    v, given, _, _ = _threes(at(points))
    with np.errstate(all="ignore"):
        cosine = np.abs((v * given).sum(axis=1)) / np.linalg.norm(v, axis=1) / np.linalg.norm(given, axis=1)
        if not np.nanmedian(cosine) > ALONG:
            return None
        for up in ([0, 1, 0], [1, 0, 0], [0, 0, 1]):
            _, slopes = _slopes(partial(turned, up=np.array(up)), points)
            if len(slopes):
                factor, folded = _cells(slopes)
                if ((factor > STRETCHED) | folded).mean() <= SHARE:
                    return str(up)
    return None


def _threes(values: list[Points]) -> list[Points]:
    """Vectors (n, 3) of their components."""
    return [np.stack(values[i : i + 3], -1) for i in range(0, len(values), 3)]


def _told(s: Suspicion, at: Sampler, points: Points) -> Diagnostic | None:
    made, *given = s.nodes
    points, slopes = _slopes(lambda points: np.stack(at(points), -1), points)
    if not len(points):
        return None
    factor, folded = _cells(slopes)
    if made.op != "at" and any(n.op == "select" for n in order(given[:3], within)):
        folded[:] = False  # a phase of several formulas may be mirrored from one to the next, as that of `sphere_map`
    flat, long = factor > FLAT, factor > STRETCHED
    if (long | folded).mean() <= SHARE:
        return None
    share = round(100 * (long | folded).mean())
    if flat.mean() > 0.5:
        message, worst, label = f"`{s.name}` leaves no cells in {share} % of the part", flat, "they are flat at"
    elif folded.mean() > SHARE:
        message = f"`{s.name}` stretches cells beyond {STRETCHED:g}:1, or folds them over, in {share} % of the part"
        worst, label = folded, "they are folded over at"
    else:
        message = f"`{s.name}` stretches cells beyond {STRETCHED:g}:1 in {share} % of the part"
        middle = float(np.median(factor[long]))
        worst, label = long & (factor >= middle), f"by {middle:.2g}:1 or more at"
    place = coordinates(points[worst][0], 3)
    return Diagnostic("W239", message, s.span, f"{label} ({place}), for one", hint=s.instead, severity="warning")
