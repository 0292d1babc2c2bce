"""Putting graphs to the law, and finding the operation to blame where it is broken."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F64, enclose
from porelang.backends.error import Verdict, judge
from porelang.conformance.backend import Backend, Points, Ranges
from porelang.formula import Formula
from porelang.ir import TASKS, Stage, order, show, within

#: A bound wider than this, beside the reference or 1, says little: such points are counted apart.
SHARP = 1e-2
NONE: dict[str, Any] = {}


@dataclass(frozen=True, slots=True)
class Failure:
    """A breach of the law: where it was found, on which backend, the operation to blame and the smallest example."""

    where: str
    backend: str
    operation: str
    example: str


@dataclass(frozen=True, slots=True)
class Finding:
    """How one graph did on one backend: the points judged, how many of them under a sharp bound, the worst use of the
    bound at those, and the failure if there was one."""

    points: int
    sharp: int
    use: float
    failure: Failure | None


def put(where: str, formula: Formula, points: Points, backend: Backend, ranges: Ranges = NONE) -> Finding:
    """Judge a formula on a backend at points (n, 3)."""
    verdict, _ = _verdict(formula, points, backend, ranges)
    with np.errstate(all="ignore"):
        width = verdict.allowed.hi - verdict.allowed.lo
        sharp = width <= SHARP * np.maximum(1.0, np.abs(verdict.reference))
    certain_nan = verdict.allowed.nan & (verdict.allowed.lo > verdict.allowed.hi)
    use = float(np.where(sharp, verdict.use, 0.0).max(initial=0.0))
    failure = None
    if verdict.broken.any():
        failure = blame(where, formula, points, backend, ranges)
    return Finding(len(points), int((sharp | certain_nan).sum()), use, failure)


def blame(where: str, formula: Formula, points: Points, backend: Backend, ranges: Ranges) -> Failure:
    """The first operation, arguments first, whose own value breaks the law, at the first point where it does."""
    for n in order(formula.roots, within):
        part = formula.with_roots(n)
        if not n.args or n.stage is Stage.CONST or n.op in TASKS:
            continue
        if n.stage is Stage.UNIFORM:  # computed before any backend is asked
            value = float(part.numbers[0])
            r = enclose(part, precision=F64)[0].range
            if not (bool(r.nan) if np.isnan(value) else bool((r.lo <= value) & (value <= r.hi))):
                return Failure(where, backend.name, n.op, f"{show({'value': n})}\nis {value!r}")
            continue
        verdict, got = _verdict(part, points, backend, ranges)
        if verdict.broken.any():
            i = int(np.argmax(verdict.broken))
            x, y, z = (float(v) for v in points[i])
            text = (
                f"{show({'value': n})}\nat ({x!r}, {y!r}, {z!r}): {backend.name} gives {float(got[i])!r}, "
                f"the law allows {float(verdict.allowed.lo[i])!r} to {float(verdict.allowed.hi[i])!r}"
                f"{' or NaN' if verdict.allowed.nan[i] else ''}"
            )
            return Failure(where, backend.name, n.op, text)
    return Failure(where, backend.name, formula.root.op, show({"value": formula.root}))


def _verdict(formula: Formula, points: Points, backend: Backend, ranges: Ranges) -> tuple[Verdict, NDArray[Any]]:
    got = backend.evaluate(formula, points, ranges)
    with np.errstate(all="ignore"):
        return judge(formula, points.astype(np.float64), got, backend.precision), got


def places(count: int, seed: int, reach: float = 50.0) -> NDArray[np.float64]:
    """Points (count, 3) at which graphs are judged: within `reach`, near the origin, on whole numbers and on the axes.

    All are float32 numbers, so that what is measured is the operations and not the rounding of the places.
    """
    rng = np.random.default_rng(seed)
    part = -(-count // 4)
    axis = rng.uniform(-reach, reach, (part, 3)) * (rng.random((part, 3)) < 0.5)
    near, whole = rng.uniform(-2, 2, (part, 3)), rng.integers(-int(reach), int(reach) + 1, (part, 3))
    points = np.concatenate([rng.uniform(-reach, reach, (part, 3)), near, whole, axis])[:count]
    return points.astype(np.float32).astype(np.float64)
