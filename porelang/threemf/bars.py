"""Which bars a field is: read from its graph, laid out in a box where they repeat."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import BoxTest
from porelang.analysis.box import Box
from porelang.data import Segments
from porelang.formula import Formula
from porelang.ir import Node, Stage, order, within

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: More bars than this are a slip of the size of a cell.
MOST = 5_000_000
#: Ends that lie nearer to each other than this part of a cell are one: what a cell has on a face its neighbour has too.
SAME = 1e-9


class NoBarsError(Exception):
    """Why a field is no union of bars, and the operation that says so, if one does."""

    def __init__(self, why: str, op: str = "") -> None:
        super().__init__(why)
        self.why, self.op = why, op


@dataclass(frozen=True, slots=True)
class Laid:
    """Bars that lie somewhere: `turn @ p + shift` (mm) is the place among them, where their radii are `more` larger."""

    bars: Segments
    turn: Floats
    shift: Floats
    more: float


@dataclass(frozen=True, slots=True)
class Beams:
    """Places (n, 3) in mm, pairs of their numbers (m, 2), and the radius of each pair (m,)."""

    places: Floats
    pairs: Ints
    radii: Floats


def bars_of(formula: Formula) -> tuple[list[Laid], list[Node]]:
    """The bars whose union a field is, and the solids that cut all of it. Errors: NoBarsError."""
    formula = formula.taken
    root, clips = formula.root, []
    if not _has_bars(root):
        raise NoBarsError("no bars are in it")
    while root.op == "max":
        inside = [a for a in root.args if _has_bars(a)]
        if len(inside) != 1:
            raise NoBarsError("bars that are intersected with bars")
        clips.append(next(a for a in root.args if a is not inside[0]))
        root = inside[0]
    return [_laid(formula, n) for n in _united(root)], clips


def _has_bars(n: Node) -> bool:
    return any(m.op in ("nearest", "joined") for m in order([n], within))


def _united(root: Node) -> Iterator[Node]:
    if root.op == "min":
        for a in root.args:
            yield from _united(a)
    else:
        yield root


def _laid(formula: Formula, n: Node) -> Laid:
    """A solid as bars: a distance from them, times a number, more or less another, moved, turned or scaled."""
    factor, offset = 1.0, 0.0
    while n.op in ("add", "sub", "mul", "div"):
        a, b = n.args
        if n.op in ("add", "mul") and b.stage is Stage.FIELD:
            a, b = b, a
        if b.stage is Stage.FIELD:
            plain = n.op in ("add", "sub") and _has_bars(a) and not _has_bars(b)
            raise NoBarsError(*("bars whose radius varies", "nearest") if plain else ("more than bars",))
        value = float(formula.with_roots(b).numbers[0])
        if n.op in ("add", "sub"):
            offset += factor * (value if n.op == "add" else -value)
        else:
            factor *= value if n.op == "mul" else 1 / value
        n = a
    if n.op == "joined":
        raise NoBarsError("bars with fillets", "joined")
    if n.op != "nearest" or n.value != "distance" or not factor > 0:
        raise NoBarsError("more than bars")
    bars, *place = n.args
    rows = [_linear(formula, q) for q in place]
    turn, shift = np.array([r[:3] for r in rows]), np.array([r[3] for r in rows])
    size = abs(np.linalg.det(turn)) ** (1 / 3)
    if not size > 0 or not np.allclose(turn @ turn.T, size**2 * np.eye(3), rtol=0, atol=1e-9 * size**2):
        raise NoBarsError("bars that are stretched")
    found = formula.bindings[bars]
    assert isinstance(found, Segments)
    return Laid(found, turn, shift, -offset / factor)


def _linear(formula: Formula, n: Node) -> Any:
    """The numbers a, b, c, d of a x + b y + c z + d, as an array. Errors: NoBarsError."""
    if n.stage is not Stage.FIELD:
        return np.array([0.0, 0.0, 0.0, float(formula.with_roots(n).numbers[0])])
    if n.op in ("x", "y", "z"):
        return np.eye(4)["xyz".index(n.op)]
    parts = [_linear(formula, a) for a in n.args] if n.op in ("add", "sub", "mul", "div", "neg") else []
    match n.op, parts:
        case "add", [a, b]:
            return a + b
        case "sub", [a, b]:
            return a - b
        case "neg", [a]:
            return -a
        case "mul", [a, b] if not a[:3].any() or not b[:3].any():
            return a * b[3] if not b[:3].any() else b * a[3]
        case "div", [a, b] if not b[:3].any():
            return a / b[3]
    raise NoBarsError("bars that are bent")


def laid_out(laid: list[Laid], box: Box, holds: BoxTest | None) -> Beams:
    """The bars that reach into a box, each once, and of these those in whose boxes a solid may lie (`holds` encloses
    it). Errors: NoBarsError for too many."""
    found = [_in_box(some, box, holds) for some in laid]
    starts = np.cumsum([0, *(len(b.places) for b in found)])
    return Beams(
        np.concatenate([b.places for b in found]),
        np.concatenate([b.pairs + start for b, start in zip(found, starts, strict=False)]),
        np.concatenate([b.radii for b in found]),
    )


def _in_box(laid: Laid, box: Box, holds: BoxTest | None) -> Beams:
    back = np.linalg.inv(laid.turn)
    size = abs(np.linalg.det(back)) ** (1 / 3)
    lo, hi = np.array(box.lo), np.array(box.hi)
    corners = np.array(list(itertools.product(*zip(lo, hi, strict=True)))) @ laid.turn.T + laid.shift
    ends, radii = _copies(laid.bars, corners.min(axis=0), corners.max(axis=0), laid.more)
    period = np.array(laid.bars.period) if laid.bars.period is not None else np.ones(3)
    thick = np.argsort(-radii, kind="stable")  # of bars in one place the thickest is seen
    ends, radii = ends[thick], radii[thick]
    places, numbers = _named(ends, laid.bars.period is not None)
    places = (places * period - laid.shift) @ back.T
    pairs, first = np.unique(np.sort(numbers, axis=1), axis=0, return_index=True)
    radii = (radii[first] + laid.more) * size
    reach = radii[:, None]
    low = places[pairs].min(axis=1) - reach
    high = places[pairs].max(axis=1) + reach
    kept = ((low <= hi) & (high >= lo)).all(axis=1) & (radii > 0)
    if holds is not None and kept.any():
        least = np.full(len(pairs), np.inf)
        least[kept] = holds(np.maximum(low[kept], lo), np.minimum(high[kept], hi))[0]
        kept &= least <= 0
    used, pairs = np.unique(pairs[kept], return_inverse=True)
    return Beams(places[used], pairs.reshape(-1, 2), radii[kept])


def _copies(bars: Segments, lo: Floats, hi: Floats, more: float) -> tuple[Floats, Floats]:
    """The ends (n, 2, 3) of bars in periods (in mm where they have none) and their radii, of all copies near a box."""
    ends = np.stack([bars.starts, bars.ends], axis=1)
    if bars.period is None:
        return ends, bars.radii
    period = np.array(bars.period)
    reach = float(bars.radii.max()) + max(more, 0.0)
    first = np.ceil((lo - reach - ends.max(axis=(0, 1))) / period).astype(int)
    last = np.floor((hi + reach - ends.min(axis=(0, 1))) / period).astype(int)
    many = float(np.prod(last - first + 1.0)) * len(ends)
    if many > MOST:
        raise NoBarsError(f"{many:.2g} bars, which are too many")
    shifts = np.stack(np.meshgrid(*map(np.arange, first, last + 1), indexing="ij"), -1).reshape(-1, 1, 1, 3)
    copies = (ends / period + shifts).reshape(-1, 2, 3)
    return copies, np.tile(bars.radii, len(shifts))


def _named(ends: Floats, repeat: bool) -> tuple[Floats, Ints]:
    """The distinct places of ends, and the numbers of each bar's two; what rounding parts in periods is one place."""
    flat = ends.reshape(-1, 3)
    keys = np.rint(flat / SAME).astype(np.int64) if repeat else flat
    _, first, numbers = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return flat[first], numbers.reshape(-1, 2)
