"""Cells that coordinates stretch or fold: what is looked up at other coordinates keeps its shape only where these
change as the point does, but for a turn and a size."""

from __future__ import annotations

import numpy as np

from porelang.analysis.sampled import Points, Sampler, sampler
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic
from porelang.doubts.parts import parts_of
from porelang.elaborate.results import Elaborated, Suspicion
from porelang.formula import Bindings
from porelang.ir import order, within

#: As many points of a part are looked at, and the distance in mm to those beside them that tell the slopes.
POINTS, FEW, ASIDE = 1000, 50, 1e-4
#: A cell that is longer one way than another by more than this factor is told of, where more of the part than this
#: share has such cells, or such that are folded over.
STRETCHED, SHARE = 2.0, 0.05
#: Beyond this factor there are no cells left to speak of.
FLAT = 100.0


def stretched(s: Suspicion, found: Elaborated, bindings: Bindings) -> Diagnostic | None:
    """Coordinates that give a lattice cells that are stretched, or folded over."""
    made, *given = s.nodes
    for part, points in parts_of(made, found, bindings):
        at = sampler([part.seen(n) for n in given], bindings)
        if at is not None and len(points) >= FEW and (told := _told(s, at, points[:POINTS])) is not None:
            return told
    return None


def _told(s: Suspicion, at: Sampler, points: Points) -> Diagnostic | None:
    made, *given = s.nodes
    beside = [(np.stack(at(points + e), -1) - np.stack(at(points - e), -1)) / (2 * ASIDE) for e in ASIDE * np.eye(3)]
    slopes = np.stack(beside, -1)
    known = np.isfinite(slopes).all(axis=(1, 2))
    points, slopes = points[known], slopes[known]
    if not len(points):
        return None
    sizes = np.linalg.svd(slopes, compute_uv=False)  # of a mm in each of three directions at right angles
    factor = sizes[:, 0] / np.maximum(sizes[:, 2], 1e-12)
    volume = np.linalg.det(slopes)
    folded = volume * np.sign(np.median(volume)) < 0  # a lattice that is mirrored throughout is none
    if made.op != "at" and any(n.op == "select" for n in order(given, within)):
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
