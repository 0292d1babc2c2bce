"""Where a solid ends along each axis: proven from outside, witnessed from inside.

For each face of a box the boxes that reach furthest are looked at first. One that is proven void is dropped, another is
cut, and a middle that is solid is a witness: what does not reach beyond it by more than the tolerance needs no look
(branch and bound). So the end of the part lies between the witness and what is left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import LONGEST, slopes
from porelang.analysis.enclose import boxes, enclose
from porelang.analysis.kin import Ints, Kin, Points
from porelang.interval import INF

#: Of the size along an axis: faces across it that are this near the part are where they should be.
TOLERANCE = 5e-4
#: Boxes looked at together before each face, and boxes times operations looked at in all (a tenth of a second or two).
AT_ONCE, MOST_WORK = 256, 1_500_000
#: Boxes that cost as much as it costs to begin with any.
_CALL = 400
#: How near (of that) a witness is looked for in the end.
_CLOSEST = 0.02
#: A witness is looked for first on this grid just below each face, and then on ones in place of its best points.
_ACROSS, _ZOOMS, _BEST = 13, 4, 2
#: Points at random before a face, and how far they go: up to so many doublings of the tolerance.
_SAMPLES, _NEARER = 4096, 8
#: Cells across a sheet before a face, times that its depth is halved, and boxes at most for which sheets are looked at.
_SHEET, _PRESSES, _PRESSED = 8, 10, 8
#: The centred form is worth its time where it rules out this share of the boxes.
_WORTH = 0.1
_LEAST = float(np.nextafter(0.0, 1.0))
#: Times that what lies beyond a round number is cut, to prove it void.
_CUTS = 4
_AXIS = np.array([0, 0, 1, 1, 2, 2])
_SIDE = np.array([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0])


@dataclass(slots=True, eq=False)
class Boxes:
    """Boxes (n, 3) .. (n, 3), each about one member: the kin (n,) that it is of, and its row there (n,).

    `weight` (n, 3) is how much there is to gain from cutting a box across each axis: its size, or what is better known.
    """

    lo: Points
    hi: Points
    kin: Ints
    row: Ints
    weight: Points | None = None

    def __len__(self) -> int:
        return len(self.lo)

    def some(self, which: NDArray[np.generic]) -> Boxes:
        weight = None if self.weight is None else self.weight[which]
        return Boxes(self.lo[which], self.hi[which], self.kin[which], self.row[which], weight)


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """How far a solid reaches before each of six faces (-x, +x, -y, ...): `outer` (6,) is proven, `inner` (6,) is where
    a point of it lies, -inf times the side where none was found."""

    outer: Points
    inner: Points


def ends_of(
    kins: Sequence[Kin],
    start: Boxes,
    near: float | None = None,
    work: int = 1,
    void: Callable[[], bool] = lambda: False,
) -> Ends | None:
    """The ends of what lies within some boxes, to `near` (mm) if the work allowed does, which is so many times as much.

    None where all of the boxes are proven void; `void` is asked too where no witness is found at once.
    """
    search = _Search(kins, start, near, work)
    search.look_at_faces(0.9 * search.near)
    search.sure = np.array([not search.wanting(face) for face in range(6)])
    if not search.sure.all():
        search.press()
        search.look_at_faces(0.9 * search.near)
        if search.inner.max() == -INF and void():
            return None
        search.run()
        if search.void:
            return None
        search.sample_near_faces()
        search.round_off()
    search.look_at_faces(_CLOSEST * search.near)
    return Ends(_SIDE * search.reach(), _SIDE * search.inner)


class _Search:
    """The state: before each face the boxes that may reach it, and the furthest witness; all as signed coordinates."""

    def __init__(self, kins: Sequence[Kin], start: Boxes, near: float | None, work: int):
        self.kins = kins
        self.start = start
        self.fronts = [start] * 6
        size = start.hi.max(axis=0) - start.lo.min(axis=0)
        self.near = TOLERANCE * size[_AXIS] if near is None else np.full(6, near)
        self.allowed = work * MOST_WORK
        self.inner = np.full(6, -INF)
        self.settled = np.full(6, -INF)  # how far boxes reach that were left alone, as a witness is near enough
        self.aside: list[list[Boxes]] = [[] for _ in range(6)]  # these
        self.sure = np.zeros(6, np.bool_)  # faces that had a witness at once
        self.void = False
        self.work = 0
        self.open = np.ones(6, np.bool_)
        self.worth, self.turns = np.zeros(len(kins)), np.zeros(len(kins), np.int64)

    def tops(self, face: int) -> Points:
        """How far each box before a face reaches."""
        return _signed(self.fronts[face], face)

    def reach(self) -> Points:
        """How far the solid is proven to end before each face."""
        left = np.array([self.tops(f).max(initial=-INF) for f in range(6)])
        return np.asarray(np.maximum(np.maximum(self.inner, self.settled), left))

    def seen(self, points: Points, kin: Ints, row: Ints) -> Points:
        """Take note of points of the solid among some; their values (n,), infinite where the field is not a number."""
        out = np.full(len(points), INF)
        for k, rows in _by_kin(kin):
            at = points[rows]
            value = enclose(self.kins[k].of(row[rows]), boxes(at, at))[0].range
            out[rows] = np.where(value.nan | value.empty, INF, value.hi)
        self._witness(points[out < 0])
        return out

    def _witness(self, points: Points) -> None:
        if len(points):
            self.inner = np.maximum(self.inner, (_SIDE * points[:, _AXIS]).max(axis=0))

    def look_at_faces(self, below: Points) -> None:
        """Look for witnesses so far (mm, (6,)) below each face, before the boxes that reach it: most often it is where
        it should be. From the points where the field is least the look goes on more closely."""
        t = (np.arange(_ACROSS) + 0.5) / _ACROSS - 0.5
        spread = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
        looks: list[tuple[int, Boxes]] = []
        for face in range(6):
            tops = _signed(self.start, face)
            looks.append((face, self.start.some(np.flatnonzero(tops >= tops.max() - self.near[face])[:_BEST])))
        for _ in range(_ZOOMS):
            reach = self.reach()
            laid = [
                (face, sheet, _laid(face, sheet, spread, reach[face] - below[face]))
                for face, sheet in looks
                if self.inner[face] < reach[face] - below[face]
            ]
            if not laid:
                return
            of = [np.repeat(np.arange(len(sheet)), len(spread)) for _, sheet, _ in laid]
            kin, row = (np.concatenate([getattr(sheet, name)[o] for o, (_, sheet, _) in zip(of, laid, strict=True)])
                        for name in ("kin", "row"))  # fmt: skip
            values = np.split(
                self.seen(np.concatenate([p for *_, p in laid]), kin, row), np.cumsum([len(o) for o in of])
            )
            looks = []
            for (face, sheet, points), o, value in zip(laid, of, values, strict=False):
                best = np.argsort(value)[:_BEST]
                half = (sheet.hi - sheet.lo)[o[best]] / _ACROSS
                looks.append(
                    (face, Boxes(points[best] - half, points[best] + half, sheet.kin[o[best]], sheet.row[o[best]]))
                )

    def wanting(self, face: int) -> bool:
        """Whether no witness is near a face yet."""
        return bool(self.inner[face] < self.reach()[face] - self.near[face])

    def sample_near_faces(self) -> None:
        """Look for witnesses at random before faces that still want one, more of them the nearer the face: in a lattice
        that enclosures cannot tell about, points can."""
        rng = np.random.default_rng(0)
        for face in range(6):
            if not self.wanting(face):
                continue
            reach, axis, near = self.reach()[face], _AXIS[face], self.near[face]
            some = _beyond(self.start, face, _SIDE[face] * max(self.inner[face], reach - 2.0**_NEARER * near))
            if not len(some):
                continue
            which = rng.integers(len(some), size=_SAMPLES)
            points = some.lo[which] + rng.random((_SAMPLES, 3)) * (some.hi - some.lo)[which]
            points[:, axis] = _SIDE[face] * (reach - near * 2.0 ** rng.uniform(-1, _NEARER, _SAMPLES))
            self.seen(points, some.kin[which], some.row[which])

    def press(self) -> None:
        """Move the faces of each box that want a witness inward as far as sheets before them are proven void: a flat
        face is found so at once, where boxes as long as wide would have to cover it."""
        start = self.fronts[0]
        faces = [face for face in range(6) if self.wanting(face)]
        if len(start) > _PRESSED:
            return
        reach = np.array([_signed(start, face) for face in faces])
        size = start.hi - start.lo
        proven, failed = np.zeros(reach.shape), np.ones(reach.shape)
        for _ in range(_PRESSES):
            share = (proven + failed) / 2
            level = reach - share * np.array([size[:, _AXIS[face]] for face in faces])
            sheets = [_sheet(start, face, at, _SHEET) for face, at in zip(faces, level, strict=True)]
            possible = self._possible(_joined(sheets), closely=False).reshape(*reach.shape, -1).any(axis=2)
            proven, failed = np.where(possible, proven, share), np.where(possible, share, failed)
        lo, hi = start.lo.copy(), start.hi.copy()
        for face, depth in zip(faces, proven, strict=True):
            axis = _AXIS[face]
            (hi if _SIDE[face] > 0 else lo)[:, axis] -= _SIDE[face] * depth * size[:, axis]
        self.start = Boxes(lo, np.maximum(lo, hi), start.kin, start.row)
        self.fronts = [self.start] * 6

    def run(self) -> None:
        """Cut, prove and drop, until every face has a witness near enough, or the work is as much as allowed."""
        while self.work < self.allowed:
            chosen = []
            for face in np.flatnonzero(self.open):
                chosen.append(self._furthest(int(face)))
                self.open[face] = len(chosen[-1]) > 0
            if self.void or not self.open.any():
                return
            picked = [(f, c) for f, c in zip(np.flatnonzero(self.open), (c for c in chosen if len(c)), strict=True)]
            together = _joined([self.fronts[f].some(c) for f, c in picked])
            possible = self._possible(together)
            at = 0
            for face, which in picked:
                mine = np.arange(at, at + len(which))
                at += len(which)
                rest = np.ones(len(self.fronts[face]), np.bool_)
                rest[which] = False
                cut = _halved(together.some(mine[possible[mine]]))
                self.fronts[face] = _joined([self.fronts[face].some(rest), cut])
                if not len(self.fronts[face]) and self.inner[face] == -INF and self.settled[face] == -INF:
                    self.void = True

    def _furthest(self, face: int) -> NDArray[np.intp]:
        """The boxes before a face that are to be looked at next; those near enough to the witness are settled."""
        tops = self.tops(face)
        beyond = tops > self.inner[face] + self.near[face]
        if not beyond.all():
            self.settled[face] = max(self.settled[face], float(tops[~beyond].max()))
            self.aside[face].append(self.fronts[face].some(~beyond))
            self.fronts[face], tops = self.fronts[face].some(beyond), tops[beyond]
        if len(tops) <= AT_ONCE:
            return np.arange(len(tops))
        return np.argpartition(-tops, AT_ONCE)[:AT_ONCE]

    def _possible(self, some: Boxes, closely: bool = True) -> NDArray[np.bool_]:
        """Which boxes may hold a part of the solid; looked at `closely`, middles that do are witnesses."""
        out = np.zeros(len(some), np.bool_)
        some.weight = some.hi - some.lo
        for k, which in _by_kin(some.kin):
            kin, mine = self.kins[k], some.some(which)
            self.work += (len(which) + _CALL) * len(kin.formula.tape)
            maybe = self._natural(kin, mine)
            left = mine.some(maybe)
            if not closely or not len(left):
                pass
            elif len(kin.formula.tape) <= LONGEST and self._worth_it(k):
                self.work += 4 * (len(left) + _CALL) * len(kin.formula.tape)
                closer, weight = self._centred(kin, left)
                some.weight[which[maybe]] = weight
                self.worth[k] = float((~closer).mean())
                maybe[maybe] = closer
            else:
                self.seen((left.lo + left.hi) / 2, left.kin, left.row)
            out[which] = maybe
        return out

    def _worth_it(self, kin: int) -> bool:
        """Whether the centred form ruled out enough when it was last asked; now and then it is asked again."""
        self.turns[kin] += 1
        return bool(self.worth[kin] >= _WORTH or self.turns[kin] % 4 == 0)

    def _natural(self, kin: Kin, some: Boxes) -> NDArray[np.bool_]:
        r = enclose(kin.of(some.row), boxes(some.lo, some.hi))[0].range
        return np.broadcast_to(~(r.lo >= 0), len(some)).copy()

    def _centred(self, kin: Kin, some: Boxes) -> tuple[NDArray[np.bool_], Points]:
        """The mean value theorem (`bounds.box_test`) in exact arithmetic: what the natural enclosure leaves open, and
        by how much the field may change along each axis: before a flat face only cuts along it tell more."""
        formula = kin.of(some.row)
        middle, half = (some.lo + some.hi) / 2, (some.hi - some.lo) / 2
        value, *slope = enclose(formula.with_roots(formula.root, *slopes(formula.root)), boxes(some.lo, some.hi))
        there = enclose(formula, boxes(middle, middle))[0].range
        solid = np.broadcast_to((there.hi < 0) & ~there.nan & ~there.empty, len(some))
        self._witness(middle[solid])
        change = np.zeros((len(some), 3))
        with np.errstate(all="ignore"):
            for i, s in enumerate(slope):
                steep = np.maximum(np.abs(s.range.lo), np.abs(s.range.hi))
                steep = np.where(s.range.nan | s.range.empty, INF, steep)
                change[:, i] = np.where(steep == 0, 0.0, steep * half[:, i])
            reach = change.sum(axis=1)
            sure = ~(value.jumps | value.range.nan | there.nan | there.empty)
            slack = 1e-12 * (np.abs(there.lo) + reach)
            void = sure & (there.lo - reach - slack >= 0)
            useful = np.broadcast_to(sure & np.isfinite(reach) & (reach > 0), len(some))
        return np.broadcast_to(~void, len(some)), np.where(useful[:, None], change, 2 * half)

    def round_off(self) -> None:
        """Move each face to the roundest number that is left for it, where the rest is void: 10 mm, not 10.0003."""
        reach = self.reach()
        for face in range(6):
            side = _SIDE[face]
            if self.sure[face] or reach[face] - self.inner[face] > 4 * self.near[face]:
                continue
            end = _roundest(side * self.inner[face], side * reach[face])
            if not side * end < reach[face]:
                continue
            rest = _beyond(_joined([*self.aside[face], self.fronts[face]]), face, end)
            if len(self.start) <= _PRESSED:
                sheet = _sheet(_beyond(self.start, face, end), face, side * end, 2 * _SHEET)
                rest = rest if self._possible(sheet, closely=False).any() else rest.some(np.zeros(0, np.int64))
            for _ in range(_CUTS):
                rest = rest.some(self._possible(rest))
                if not 0 < len(rest) <= AT_ONCE:
                    break
                rest = _halved(rest)
            if not len(rest):
                self.aside[face], self.fronts[face], self.settled[face] = [], rest, side * end


def _laid(face: int, sheet: Boxes, spread: Points, level: float) -> Points:
    """Points at a level (signed) before a face, `spread` (in shares of the size) over the middles of some boxes."""
    axis = _AXIS[face]
    points = np.empty((len(sheet), len(spread), 3))
    for n, across in enumerate(a for a in range(3) if a != axis):
        middle, size = (sheet.lo + sheet.hi)[:, across] / 2, (sheet.hi - sheet.lo)[:, across]
        points[:, :, across] = middle[:, None] + spread[:, n] * size[:, None]
    points[:, :, axis] = _SIDE[face] * level
    return points.reshape(-1, 3)


def _signed(some: Boxes, face: int) -> Points:
    """How far each box reaches before a face."""
    return np.asarray(_SIDE[face] * (some.hi if _SIDE[face] > 0 else some.lo)[:, _AXIS[face]])


def _beyond(some: Boxes, face: int, end: float) -> Boxes:
    """What of some boxes reaches beyond a coordinate, before a face."""
    side, axis = _SIDE[face], _AXIS[face]
    some = some.some(_signed(some, face) > side * end)
    ends = some.lo if side > 0 else some.hi
    ends[:, axis] = side * np.maximum(side * ends[:, axis], side * end)
    return some


def _sheet(some: Boxes, face: int, level: Any, cells: int) -> Boxes:
    """The sheets of boxes from a level (signed, one for all or for each) to a face, each in cells across, in rows."""
    side, axis = _SIDE[face], _AXIS[face]
    count = cells * cells
    at = np.stack(np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij"), -1).reshape(-1, 2) / cells
    lo, hi = np.repeat(some.lo[:, None], count, axis=1), np.repeat(some.hi[:, None], count, axis=1)
    size = some.hi - some.lo
    for n, across in enumerate(a for a in range(3) if a != axis):
        lo[:, :, across] = some.lo[:, across, None] + at[:, n] * size[:, across, None]
        hi[:, :, across] = lo[:, :, across] + size[:, across, None] / cells
    (lo if side > 0 else hi)[:, :, axis] = (side * np.broadcast_to(level, len(some)))[:, None]
    of = np.repeat(np.arange(len(some)), count)
    return Boxes(lo.reshape(-1, 3), hi.reshape(-1, 3), some.kin[of], some.row[of])


def _roundest(a: float, b: float) -> float:
    """The number with the fewest digits between two."""
    lo, hi = min(a, b), max(a, b)
    if lo <= 0 <= hi:
        return 0.0
    step = 10.0 ** math.ceil(math.log10(max(-lo, hi)))
    while step > 0:
        found = float(f"{math.ceil(lo / step) * step:.15g}")
        if lo <= found <= hi:
            return found
        step /= 10
    return b


def _by_kin(kin: Ints) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """The places of each kin."""
    for k in np.unique(kin):
        yield int(k), np.flatnonzero(kin == k)


def _joined(parts: Sequence[Boxes]) -> Boxes:
    return Boxes(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("lo", "hi", "kin", "row")))


def _weights(some: Boxes) -> Points:
    return some.hi - some.lo if some.weight is None else some.weight


def _halved(some: Boxes) -> Boxes:
    """Boxes cut in halves across each axis that weighs most, or nearly so: two to eight of each.

    What lies on both sides of 0 is cut there, into what is below 0 and what is above: an angle jumps at y = 0, and a
    plane holds no volume.
    """
    lo, hi, which = some.lo, some.hi, np.arange(len(some))
    weight = _weights(some)
    long = weight > 0.6 * weight.max(axis=1, initial=0.0)[:, None]
    for axis in range(3):
        cut = np.flatnonzero(long[which, axis])
        middle = (lo[cut, axis] + hi[cut, axis]) / 2
        across = (lo[cut, axis] < 0) & (hi[cut, axis] > 0)
        low, high = lo[cut].copy(), hi.copy()
        low[:, axis], high[cut, axis] = np.where(across, _LEAST, middle), np.where(across, -_LEAST, middle)
        lo, hi = np.concatenate([lo, low]), np.concatenate([high, hi[cut]])
        which = np.concatenate([which, which[cut]])
    return Boxes(lo, hi, some.kin[which], some.row[which])
