"""How far a part reaches: outside of its box nothing of it lies, by proof, and at each face a point of it was found.

Three steps, each of which does what the one before left: formulas are read backwards for a rough box (`backwards`);
what has no end by that is looked for all over space (`shaving`); and each face is moved in until a point of the part
lies before it (`faces`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.backwards import UNIVERSE, Seen, rough_boxes, surely_void
from porelang.analysis.faces import TOLERANCE, Boxes, ends_of
from porelang.analysis.kin import Kin, alone, kin_of
from porelang.analysis.shaving import shaved
from porelang.analysis.steps import held
from porelang.analysis.turned import unturned
from porelang.formula import Formula
from porelang.ir import Node, X, Y, Z, node, substitute

#: Members of a union that are looked for all over space one by one; more are looked for together.
MOST_ALONE = 6

#: Beyond the universe parts are looked for, to be told of, in one so many times as large.
_LARGER = 1e4
#: Work that is allowed where one asks for more than the usual, or where the usual did not do, to the usual.
_MORE = 4
#: A box that is smaller than the one before by so much along an axis is searched again, so many times in all.
_SMALLER, _SEARCHES = 0.5, 3
#: A box that may be too large by this share of its longest side is searched again, for so much work, if its formula is
#: this short.
_LOOSE, _AGAIN, _SHORT = 0.01, 2, 300

Points = NDArray[np.float64]


class Box(NamedTuple):
    """An axis-aligned box, in mm: `lo, hi = box`."""

    lo: tuple[float, float, float]
    hi: tuple[float, float, float]

    @property
    def size(self) -> tuple[float, float, float]:
        return (self.hi[0] - self.lo[0], self.hi[1] - self.lo[1], self.hi[2] - self.lo[2])

    @property
    def volume(self) -> float:
        return float(np.prod(self.size))

    def grown(self, share: float) -> Box:
        """This box, larger on all sides by a share of its longest."""
        more = share * max(self.size)
        return Box(
            (self.lo[0] - more, self.lo[1] - more, self.lo[2] - more),
            (self.hi[0] + more, self.hi[1] + more, self.hi[2] + more),
        )


def around(boxes: Sequence[Box]) -> Box:
    """The box that holds all of some."""
    lo, hi = np.min([b.lo for b in boxes], axis=0), np.max([b.hi for b in boxes], axis=0)
    return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))


class Extent(NamedTuple):
    """How far a part reaches, in mm: nothing of it lies outside `outer`, and points of it were found at every face of
    `inner`, which is None where no point was found at all."""

    outer: Box
    inner: Box | None

    @property
    def errors(self) -> tuple[float, float, float]:
        """By how much a face of `outer` may lie outside the part, at most, of the two across each axis."""
        if self.inner is None:
            return self.outer.size
        x, y, z = (
            max(abs(a - b), abs(c - d))
            for a, b, c, d in zip(self.outer.lo, self.inner.lo, self.outer.hi, self.inner.hi, strict=True)
        )
        return x, y, z

    @property
    def error(self) -> float:
        """The largest of the `errors`."""
        return max(self.errors)

    def as_near_as(self, near: float | None) -> bool:
        """Whether every face lies within `near` (mm) of the part; None: whether all are as usual, so that no more work
        is worth its time."""
        usual = TOLERANCE * max(self.outer.size)
        most = [min(usual, _LOOSE * size) for size in self.outer.size] if near is None else 3 * [near]
        return all(error <= m for error, m in zip(self.errors, most, strict=True))


def block(box: Box) -> Node:
    """A box as a field: the largest signed distance to its six planes."""
    out: Node | None = None
    for axis, lo, hi in zip((X, Y, Z), box.lo, box.hi, strict=True):
        sides = node("max", lo - axis, axis - hi)
        out = sides if out is None else node("max", out, sides)
    assert out is not None
    return out


def part_box(formula: Formula) -> Box | None:
    """The box that holds all of a formula's `root < 0` within the universe, or None if that is proven empty.

    Ends that touch +-UNIVERSE mean that the part has no end there. See `extent_of` for how tight it is.
    """
    found = extent_of(formula)
    return None if found is None else found.outer


def extent_of(formula: Formula, near: float | None = None) -> Extent | None:
    """How far a formula's `root < 0` reaches within the universe, or None if that is proven empty.

    The box is tight to `near` (mm; if left out 5e-4 of its size along each axis), unless the formula is so long or its
    walls are so thin that the work allowed does not do: `errors` says what is left. Where a part has no end its box
    touches +-UNIVERSE.
    """
    formula = formula.taken
    numbers = _numbers(formula)
    return _extent_of(formula, near) if numbers is None else _remembered(formula.root, numbers, near)


def _numbers(formula: Formula) -> tuple[tuple[Node, str], ...] | None:
    """What is bound in a formula, where all of it is numbers; -0 is not 0."""
    slots = [formula.tape.nodes[i] for i in formula.tape.slots]
    numbers = [(n, v.hex()) for n in slots if isinstance(v := formula.bindings.get(n), float)]
    return tuple(numbers) if len(numbers) == len(slots) else None


@lru_cache(64)
def _remembered(root: Node, numbers: tuple[tuple[Node, str], ...], near: float | None) -> Extent | None:
    """Each number of a part (its volume, porosity, area) asks for its extent: to measure one asked ten times over."""
    return _extent_of(Formula((root,), {n: float.fromhex(v) for n, v in numbers}), near)


def _extent_of(formula: Formula, near: float | None) -> Extent | None:
    if not formula.root.axes:
        return None if bool(formula.numbers[0] > 0) else _made(np.full(3, -UNIVERSE), np.full(3, UNIVERSE), None)
    formula = unturned(formula)
    found = _looked_for(formula, kin_of(formula), near)
    if found is None or found.as_near_as(near):
        return found
    copies = held(formula)
    loose = found.inner is not None and found.error > _LOOSE * max(found.outer.size)
    if copies is None and not (loose and len(formula.tape) <= _SHORT):
        return found
    closer = _looked_for(formula, kin_of(formula, copies), near, found.outer, _MORE if copies else _AGAIN)
    return None if closer is None else _met(found, closer)


def _looked_for(
    formula: Formula, kins: list[Kin], near: float | None, known: Box | None = None, work: int = 1
) -> Extent | None:
    """How far the members of a union reach, in a box that is known to hold all of it; for `work` times the work."""
    rough = _rough(formula, kins, known)
    start = _start(kins, rough)
    if not len(start):
        return None
    lo, hi = start.lo.min(axis=0), start.hi.max(axis=0)
    if max(-lo.min(), hi.max()) >= UNIVERSE:
        cut = all(kin.formula.root.op == "max" for kin in kins)
        return None if cut and _void(kins) else _made(lo, hi, None)
    if (lo == hi).any():
        return _made(lo, hi, None)
    work = max(work * min(len(kins), _MORE) if known else 1, 1 if near is None else _MORE)
    for left in reversed(range(_SEARCHES)):
        ends, size = ends_of(kins, start, near, work, lambda: _void(kins)), hi - lo
        if ends is None:
            return None
        lo, hi = ends.outer[::2], ends.outer[1::2]
        if not left or near is not None or (hi - lo > _SMALLER * size).all():
            return _made(lo, hi, ends.inner if np.isfinite(ends.inner).all() else None)
        start = _within(start, lo, hi)  # how near is near goes by the size that is found
    raise AssertionError("the last search is told")


def _void(kins: list[Kin]) -> bool:
    return all(surely_void(kin).all() for kin in kins)


def _rough(formula: Formula, kins: list[Kin], known: Box | None = None) -> list[tuple[Points, Points]]:
    """Boxes of the members of a union, with an end wherever that can be proven; `kins` is left with those that are
    there, or where too many have none with the union as one."""
    seen = Seen()
    rough = [rough_boxes(kin, seen) for kin in kins]
    if known is not None:
        rough = [(np.maximum(lo, known.lo), np.minimum(hi, known.hi)) for lo, hi in rough]
    if sum(int(_far(lo, hi).sum()) for lo, hi in rough) > MOST_ALONE:
        lo, hi = (np.array(end) for end in _hull(rough))
        kins[:], rough = [alone(formula)], [(lo[None], hi[None])]
    for k, (kin, (lo, hi)) in enumerate(zip(kins, rough, strict=True)):
        for row in np.flatnonzero(_far(lo, hi)):
            found = shaved(kin.of(np.array([row])), lo[row].copy(), hi[row].copy())
            lo[row], hi[row] = (np.full(3, np.inf), np.full(3, -np.inf)) if found is None else found
        there = (lo <= hi).all(axis=1)
        kins[k], rough[k] = kin.some(np.flatnonzero(there)), (lo[there], hi[there])
    return rough


def has_ends(formula: Formula) -> bool:
    """Whether a formula's `root < 0` is proven to end along every axis, in a tenth of the time of its extent."""
    formula = formula.taken
    numbers = _numbers(formula)
    return _ends(formula) if numbers is None else _ends_remembered(formula.root, numbers)


@lru_cache(64)
def _ends_remembered(root: Node, numbers: tuple[tuple[Node, str], ...]) -> bool:
    """`pore check` asks first whether meshing would refuse a part, and then whether it is a field without an end."""
    return _ends(Formula((root,), {n: float.fromhex(v) for n, v in numbers}))


def _ends(formula: Formula) -> bool:
    formula = unturned(formula)
    return not any(_far(lo, hi).any() for lo, hi in _rough(formula, kin_of(formula)))


def _met(a: Extent, b: Extent) -> Extent:
    """What two searches of one solid tell together."""
    lo, hi = np.maximum(a.outer.lo, b.outer.lo), np.minimum(a.outer.hi, b.outer.hi)
    seen = [e.inner for e in (a, b) if e.inner is not None]
    if not seen:
        return _made(lo, hi, None)
    low, high = np.min([s.lo for s in seen], axis=0), np.max([s.hi for s in seen], axis=0)
    return _made(lo, hi, np.stack([low, high], axis=1).reshape(-1))


def reach(formula: Formula) -> float | None:
    """How far a part reaches in mm where that is beyond the universe, if it ends in one `_LARGER` times as large: a
    point of it was found out there. None for any other."""
    larger = {axis: axis * _LARGER for axis in (X, Y, Z)}
    (root,) = substitute([formula.taken.root], larger)
    further = formula.with_roots(root)
    lo, hi = _hull([rough_boxes(kin) for kin in kin_of(further)])
    if not (lo <= hi).all():
        return None
    end = _LARGER * float(max(np.abs(lo).max(), np.abs(hi).max()))
    if not UNIVERSE < end < _LARGER * UNIVERSE:
        return None
    found = extent_of(further)
    if found is None or found.inner is None:
        return None
    return end if _LARGER * float(np.abs(found.inner).max()) > UNIVERSE else None


def unbounded_axes(box: Box) -> str:
    """The axes along which a box reaches the end of the universe, as text."""
    return ", ".join(name for name, a, b in zip("xyz", box.lo, box.hi, strict=True) if a <= -UNIVERSE or b >= UNIVERSE)


def _far(lo: Points, hi: Points) -> NDArray[np.bool_]:
    """Which boxes reach the end of the universe."""
    far = (lo <= hi).all(axis=1) & ((lo <= -UNIVERSE) | (hi >= UNIVERSE)).any(axis=1)
    return np.asarray(far, np.bool_)


def _hull(rough: list[tuple[Points, Points]]) -> tuple[Points, Points]:
    return np.concatenate([lo for lo, _ in rough]).min(axis=0), np.concatenate([hi for _, hi in rough]).max(axis=0)


def _start(kins: list[Kin], rough: list[tuple[Points, Points]]) -> Boxes:
    kin = np.concatenate([np.full(len(lo), k) for k, (lo, _) in enumerate(rough)])
    row = np.concatenate([np.arange(len(lo)) for lo, _ in rough])
    return Boxes(np.concatenate([lo for lo, _ in rough]), np.concatenate([hi for _, hi in rough]), kin, row)


def _within(some: Boxes, lo: Points, hi: Points) -> Boxes:
    """What of boxes lies in one."""
    cut = Boxes(np.maximum(some.lo, lo), np.minimum(some.hi, hi), some.kin, some.row)
    return cut.some(np.flatnonzero((cut.lo <= cut.hi).all(axis=1)))


def _made(lo: Points, hi: Points, inner: Points | None) -> Extent:
    def box(lo: Points, hi: Points) -> Box:
        return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))

    return Extent(box(lo, hi), None if inner is None else box(inner[::2], inner[1::2]))
