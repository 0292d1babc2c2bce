"""The bounding box of a part: the smallest box outside of which the field is proven positive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import boxes, enclose, enclose_all
from porelang.formula import Formula
from porelang.interval import Interval, interval, meet
from porelang.ir import Node, X, Y, Z, node
from porelang.ops import TABLE
from porelang.tape import AXES, PICK, Tape

#: Parts are looked for within this distance of the origin, in mm, along each axis.
UNIVERSE = 1e5
#: Members of a union that are looked at closely one by one; the others keep their rough (larger) box.
MOST_CLOSE = 6
FEW = 8
#: Unions within smooth unions within ... are followed this deep.
DEEPEST = 40


Points = NDArray[np.float64]
Rough = tuple[Points, Points]
#: Whether any material is possible in each of n boxes, given by their corners (n, 3).
Solid = Callable[[Points, Points], NDArray[np.bool_]]


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


def block(box: Box) -> Node:
    """A box as a field: the largest signed distance to its six planes."""
    out: Node | None = None
    for axis, lo, hi in zip((X, Y, Z), box.lo, box.hi, strict=True):
        sides = node("max", lo - axis, axis - hi)
        out = sides if out is None else node("max", out, sides)
    assert out is not None
    return out


def part_box(formula: Formula) -> Box | None:
    """The box that holds all of a formula's `root <= 0` within the universe, or None if that is proven empty.

    Ends that touch +-UNIVERSE mean that the part has no end there. The box is tight to about 1e-4 of its size for
    shapes along the axes, and to a few percent for rotated ones. A union is taken apart: each member gets a rough box
    by reading its formula backwards, and only those that reach the ends of the whole are looked at closely.
    """
    formula = formula.taken
    seen: dict[tuple[Node, float], Rough | None] = {}
    found_rough = {m: _backwards(formula.with_roots(m), 0.0, seen, 0) for m in _members(formula.root)}
    rough = {m: box for m, box in found_rough.items() if box is not None}
    close: dict[Node, None] = {}
    while rough:
        lo = np.min([box[0] for box in rough.values()], axis=0)
        hi = np.max([box[1] for box in rough.values()], axis=0)
        near = 1e-9 * (hi - lo)
        # an end is settled where a member that was looked at closely reaches it
        open_lo = ~np.any([rough[m][0] <= lo + near for m in close], axis=0) if close else np.full(3, True)
        open_hi = ~np.any([rough[m][1] >= hi - near for m in close], axis=0) if close else np.full(3, True)
        # among many members, one that is small beside the whole is not worth a closer look
        least = 0.2 * (hi - lo) if len(rough) > FEW else np.zeros(3)
        todo = [
            m
            for m, box in rough.items()
            if m not in close
            and (((box[0] <= lo + near) & open_lo | (box[1] >= hi - near) & open_hi) & (box[1] - box[0] > least)).any()
        ]
        if todo and len(close) >= MOST_CLOSE:
            if (hi - lo).max() >= UNIVERSE:  # some have no rough box: all together is cheaper now than one by one
                found = _search(formula, lo, hi)
                if found is None:
                    return None
                lo, hi = found
            todo = []
        if not todo:
            return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))
        member = todo[0]
        found = _search(formula.with_roots(member), *rough.pop(member))
        if found is not None:
            rough[member] = found
            close[member] = None
    return None


def _members(root: Node) -> list[Node]:
    """The members of a union, or the root itself."""
    stack, seen, out = [root], {root}, []
    while stack:
        n = stack.pop()
        if n.op != "min":
            out.append(n)
            continue
        for a in n.args:
            if a not in seen:
                seen.add(a)
                stack.append(a)
    return out


def _backwards(formula: Formula, most: float, seen: dict[tuple[Node, float], Rough | None], depth: int) -> Rough | None:
    """A rough box of `root <= most`: ranges pushed from the root back to the coordinates, a few times over."""
    key = (formula.root, most)
    if key not in seen:
        seen[key] = _pushed_back(formula, most, seen, depth)
    return seen[key]


def _pushed_back(
    formula: Formula, most: float, seen: dict[tuple[Node, float], Rough | None], depth: int
) -> Rough | None:
    tape = formula.tape
    root = tape.roots[0]
    space = [interval(np.array([-UNIVERSE]), np.array([UNIVERSE])) for _ in range(3)]
    known: dict[int, Interval] = {}
    for _ in range(4):
        known = {i: e.range for i, e in enclose_all(formula, space).items()}
        known[root] = meet(known[root], interval(np.array([-np.inf]), np.array([most])))
        with np.errstate(all="ignore"):
            for i in reversed(tape.field):
                _narrow(formula, i, known)
        before = space
        places = [tape.position.get(n) for n in (X, Y, Z)]
        space = [s if at is None else meet(s, known[at]) for at, s in zip(places, space, strict=True)]
        space = _solved(tape, known, space)
        if any(bool((s.lo > s.hi).any()) for s in space):
            return None
        if all(float((s.hi - s.lo)[0]) > 0.95 * float((b.hi - b.lo)[0]) for s, b in zip(space, before, strict=True)):
            break
    lo, hi = np.array([float(s.lo[0]) for s in space]), np.array([float(s.hi[0]) for s in space])
    if depth < DEEPEST and (hi - lo).max() >= UNIVERSE:
        return _by_branches(formula, known, lo, hi, seen, depth)
    return lo, hi


def _narrow(formula: Formula, i: int, known: dict[int, Interval]) -> None:
    """What the range of an operation's result says of its arguments, met with what is known of them."""
    tape = formula.tape
    inputs, op = tape.inputs[i], tape.ops[i]
    if op == PICK:  # of a walk with several results, the first is what narrows
        walk = inputs[0]
        row = TABLE[tape.ops[walk]]
        if row.narrow is None or tape.values[i] != row.results[0]:
            return
        inputs = tape.inputs[walk]
    else:
        row = TABLE[op]
        if row.narrow is None or row.results:
            return
    arguments = [known[a] if a in known else formula.known[a] for a in inputs]
    for a, r in zip(inputs, row.narrow(known[i], *arguments), strict=True):
        if tape.axes[a] and r is not None:
            known[a] = meet(known[a], r)


def _solved(tape: Tape, known: Mapping[int, Interval], space: list[Interval]) -> list[Interval]:
    """Coordinates from the ranges of turned ones: three linear forms of x, y, z are solved for them.

    A rotated box says that three sums of coordinates are small; one at a time that says nothing about any coordinate.
    """
    forms: dict[int, NDArray[np.float64]] = {}  # of what is linear: the factors of x, y, z, and the rest
    for i, op in enumerate(tape.ops):
        inputs, varies = tape.inputs[i], tape.axes[i] != 0
        if op in AXES:
            forms[i] = np.eye(4)[AXES[op]]
        elif not varies:
            value = known.get(i)
            if value is not None and value.lo.size == 1 and float(value.lo.flat[0]) == float(value.hi.flat[0]):
                forms[i] = np.array([0.0, 0.0, 0.0, float(value.lo.flat[0])])
        elif all(a in forms for a in inputs):
            f = [forms[a] for a in inputs]
            if op in ("add", "sub"):
                forms[i] = f[0] + f[1] if op == "add" else f[0] - f[1]
            elif op == "neg":
                forms[i] = -f[0]
            elif op == "mul" and not all(tape.axes[a] for a in inputs):
                forms[i] = f[0] * f[1][3] if tape.axes[inputs[0]] else f[1] * f[0][3]
            elif op == "div" and not tape.axes[inputs[1]] and f[1][3] != 0:
                forms[i] = f[0] / f[1][3]
    rows: list[tuple[float, NDArray[np.float64], float, float]] = []
    for i, form in forms.items():
        size = float(np.linalg.norm(form[:3]))
        lo, hi = (float(known[i].lo.flat[0]), float(known[i].hi.flat[0])) if tape.axes[i] else (0.0, 0.0)
        if size > 0 and np.isfinite([lo, hi]).all() and hi - lo < UNIVERSE * size:
            rows.append(((hi - lo) / size, form / size, lo / size, hi / size))
    picked: list[tuple[float, NDArray[np.float64], float, float]] = []
    for row in sorted(rows, key=lambda r: r[0]):  # the narrowest three that are independent
        stack = np.array([r[1][:3] for r in [*picked, row]])
        if np.linalg.svd(stack, compute_uv=False)[-1] > 1e-3:
            picked.append(row)
        if len(picked) == 3:
            break
    if len(picked) < 3:
        return space
    inverse = np.linalg.inv(np.array([r[1][:3] for r in picked]))
    low = np.array([r[2] - r[1][3] for r in picked])
    high = np.array([r[3] - r[1][3] for r in picked])
    middle, half = inverse @ (low + high) / 2, np.abs(inverse) @ (high - low) / 2
    half = half * (1 + 1e-12) + 1e-12 * np.abs(middle)
    return [meet(s, interval(middle[i : i + 1] - half[i], middle[i : i + 1] + half[i])) for i, s in enumerate(space)]


def _by_branches(
    formula: Formula,
    known: Mapping[int, Interval],
    lo: Points,
    hi: Points,
    seen: dict[tuple[Node, float], Rough | None],
    depth: int,
) -> Rough | None:
    """The box cut to where a lesser of two inside the formula can be as small as it must be, by either branch."""
    tape = formula.tape
    for i in reversed(tape.field):
        if tape.ops[i] != "min" or i in tape.roots:
            continue
        most = float(known[i].hi.max())
        if not np.isfinite(most) or most >= UNIVERSE:
            continue
        branches = (formula.with_roots(a) for a in tape.nodes[i].args)
        parts = [box for branch in branches if (box := _backwards(branch, most, seen, depth + 1)) is not None]
        if not parts:
            return None
        lo = np.maximum(lo, np.min([p[0] for p in parts], axis=0))
        hi = np.minimum(hi, np.max([p[1] for p in parts], axis=0))
        if (hi < lo).any():
            return None
        if (hi - lo).max() < UNIVERSE:
            break
    return lo, hi


def _search(formula: Formula, lo: Points, hi: Points) -> tuple[Points, Points] | None:
    """A tight box within `lo..hi`: cells proven void are dropped, then the faces are moved inward."""
    cost = len(formula.tape)

    def maybe_solid(lo: Points, hi: Points) -> NDArray[np.bool_]:
        r = enclose(formula, boxes(lo, hi))[0].range
        return np.broadcast_to(r.lo <= 0, len(lo))

    finest = 32 if cost < 300 else 16 if cost < 3000 else 8
    steps = 22 if cost < 300 else 14 if cost < 1000 else 7 if cost < 5000 else 3
    _shave(lo, hi, 4, 1, maybe_solid)
    _snap(lo, hi, 2, maybe_solid)
    cells = 8
    for _ in range(60):
        cell_lo, cell_hi = _split(lo, hi, (cells, cells, cells))
        keep = maybe_solid(cell_lo, cell_hi)
        if not keep.any():
            return None
        before = np.prod(hi - lo)
        lo, hi = cell_lo[keep].min(axis=0), cell_hi[keep].max(axis=0)
        if np.prod(hi - lo) < 0.9 * before:
            continue
        moved = _shave(lo, hi, min(steps, 8), _ACROSS, maybe_solid)
        if moved:
            _snap(lo, hi, 2, maybe_solid)
            _shave(lo, hi, steps, _ACROSS, maybe_solid)
            _snap(lo, hi, 4, maybe_solid)
        # Where thin layers of cells as small as these could not be ruled out, the cells cannot be either; and where
        # cells and the faces agree, as for shapes along the axes, finer cells find no more.
        if cells >= finest or (not moved and cells < _ACROSS) or (cells > 8 and np.prod(hi - lo) > 0.98 * before):
            break
        cells *= 2
    return lo, hi


def unbounded_axes(box: Box) -> str:
    """The axes along which a box reaches the end of the universe, as text."""
    return ", ".join(name for name, a, b in zip("xyz", box.lo, box.hi, strict=True) if a <= -UNIVERSE or b >= UNIVERSE)


def _split(lo: Points, hi: Points, counts: tuple[int, int, int]) -> tuple[Points, Points]:
    """The corners (m, 3) of the cells of boxes (n, 3)."""
    index = np.stack(np.meshgrid(*(np.arange(c) for c in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    lo, hi = np.atleast_2d(lo)[:, None], np.atleast_2d(hi)[:, None]
    step = (hi - lo) / counts
    low = lo + index * step
    high = np.where(index + 1 == counts, hi, lo + (index + 1) * step)
    return low.reshape(-1, 3), high.reshape(-1, 3)


_ACROSS = 16  # cells along a layer that is looked at closely
_DEPTHS = 32  # layers that are looked at whole in one go
#: The faces of a box: an axis, and the side it is on.
_FACES = tuple((axis, side) for axis in range(3) for side in (-1, 1))


def _shave(lo: Points, hi: Points, steps: int, across: int, maybe_solid: Solid) -> bool:
    """Move the faces of the box inward as far as the layers before them are proven void, all six at a time; whether any
    has moved. Layers are looked at whole, many depths at once, or bisected in `across` by `across` cells."""
    cuts = _DEPTHS if across == 1 else 1
    width = np.array([side * (hi - lo)[axis] for axis, side in _FACES])
    proven, failed = np.zeros(6), np.ones(6)  # shares of the width
    moving = np.arange(6)
    for step in range(steps):
        shares = proven[:, None] + (failed - proven)[:, None] * (np.arange(1, cuts + 1) / (cuts + 1))
        if not step:  # most often the face is where it should be
            shares = np.full((6, 1), 1e-6)
        planes = _ends(lo, hi)[:, None] - shares * width[:, None]
        solid = _solid_beyond(lo, hi, moving, planes[moving], across, maybe_solid)
        void = np.where(solid.any(axis=1), solid.argmax(axis=1), shares.shape[1])
        for i, deepest in zip(moving, void, strict=True):
            proven[i] = shares[i, deepest - 1] if deepest else proven[i]
            failed[i] = shares[i, deepest] if deepest < shares.shape[1] else failed[i]
        if not step:
            moving = moving[void > 0]
        if not len(moving):
            return False
    _move(lo, hi, moving, (_ends(lo, hi) - proven * width)[moving])
    return True


def _snap(lo: Points, hi: Points, figures: int, maybe_solid: Solid) -> None:
    """Move faces to rounder numbers, if nothing lies beyond those: a radius of 75 mm should end at 75."""
    rounder = _ends(lo, hi)
    for i, (axis, _) in enumerate(_FACES):
        if hi[axis] > lo[axis]:
            rounder[i] = round(float(rounder[i]), figures - int(np.floor(np.log10(hi[axis] - lo[axis]))))
    side = np.array([s for _, s in _FACES])
    moving = np.flatnonzero((_ends(lo, hi) - rounder) * side > 0)
    if len(moving):
        planes = np.nextafter(rounder, side * np.inf)[moving, None]
        void = moving[~_solid_beyond(lo, hi, moving, planes, _ACROSS, maybe_solid)[:, 0]]
        _move(lo, hi, void, rounder[void])


def _ends(lo: Points, hi: Points) -> Points:
    """The coordinate of each face."""
    return np.array([(hi if side > 0 else lo)[axis] for axis, side in _FACES])


def _move(lo: Points, hi: Points, faces: NDArray[np.intp], to: Points) -> None:
    """Put some faces at other coordinates."""
    for i, end in zip(faces, to, strict=True):
        axis, side = _FACES[i]
        (hi if side > 0 else lo)[axis] = end


def _solid_beyond(
    lo: Points, hi: Points, faces: NDArray[np.intp], planes: Points, across: int, maybe_solid: Solid
) -> NDArray[np.bool_]:
    """Whether any material is possible between some faces of a box and planes (faces, n) inside it."""
    lows, highs = [], []
    for i, inner in zip(faces, planes, strict=True):
        axis, side = _FACES[i]
        sheet = (1 if axis == 0 else across, 1 if axis == 1 else across, 1 if axis == 2 else across)
        layer_lo, layer_hi = np.tile(lo, (len(inner), 1)), np.tile(hi, (len(inner), 1))
        (layer_lo if side > 0 else layer_hi)[:, axis] = inner
        low, high = _split(layer_lo, layer_hi, sheet)
        lows.append(low)
        highs.append(high)
    solid = maybe_solid(np.concatenate(lows), np.concatenate(highs)).reshape(*planes.shape, -1)
    return np.asarray(solid.any(axis=2))
