"""What holds and loads a part, as the solver takes it: of a test between two ends, found from the part's elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.fea import Facing, Force, Moment, OnSurface, Pressure, Support, Weight, Where
from porelang.fea.covered import Patch, covered
from porelang.fea.nodes import Nodes, number
from porelang.fea.surface import Surface, surface
from porelang.solid import Solid, onto
from porelang.tasks.study.asked import Acts, Question, solid_of
from porelang.tet.tetmesh import TetMesh, boundary

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Load = Force | Pressure | Moment | Weight
#: What lies at an end, or on a side, within this part of an element's edge does lie on it.
FLAT = 0.02
#: Newton's steps to the surface of a part, how far of an element's edge it is from a facet at most, and what is no
#: distance.
_STEPS, _NEAR, _ROUNDED = 3, 0.2, 1e-6
#: Of the box of a part across an axis, how much of an end has to be flat that a platen can press.
_LEAST_FACE = 1e-3
#: Of a beam that is bent by three points, how far the outer ones are apart and how wide each pad is, unless given.
_SPAN, _PAD = 0.9, 0.05
#: What is flat keeps more than this share of its area where a quarter as much depth counts as its side; what is round
#: keeps half.
_AS_FLAT = 0.75
#: Standard gravity in mm/s2 (CGPM 1901, resolution 3).
GRAVITY = 9806.65


@dataclass(frozen=True, slots=True)
class Setting:
    """Supports and loads. Where a platen is moved by 1 mm, `reached` says which support that is, along which axis, and
    with which force (N) it is to press in the end: all is scaled to that. `balanced`: loads do no work on the motions
    that supports leave free. `rests` are where such a part lies on pads: displacements are counted from there."""

    supports: tuple[Support, ...]
    loads: tuple[Load, ...]
    reached: tuple[int, int, float] | None = None
    balanced: bool = False
    rests: tuple[Where, ...] = ()


def setting(asked: Question, mesh: TetMesh, size: float) -> Setting:
    """What holds and loads a part of elements of a size (mm). Errors: E187 for pads that do not fit, E189 for an end
    that no platen can press."""
    whole = asked.whole
    if whole is None:
        return _listed(asked.acts, OnPart(solid_of(asked), size), asked.balanced)
    ends = Ends(mesh, size)
    if whole.name == "compress":
        return _compressed(ends, *whole.numbers)
    if whole.name == "shear":
        return _sheared(ends, *whole.numbers)
    if whole.name == "bend":
        return _bent(ends, *whole.numbers)
    return _twisted(ends, *whole.numbers)


@dataclass(frozen=True, slots=True)
class OnPart:
    """The surface of a part, on which conditions are asked: at what is nearest to a point on the boundary of elements.

    A round wall has flat faces in elements, and corners a little off it so that the volume is that of the part: half
    of `length(p) < 10.01mm` in a hollow sphere of that radius would not hold on them.
    """

    part: Solid
    size: float

    def nearest(self, points: Floats) -> Floats:
        """The places (n, 3) on the surface next to points (n, 3) mm; those that are farther from it than facets are
        stay where they are, and so do those that lie on it but for rounding."""
        at = onto(self.part, points, _STEPS, _NEAR * self.size)
        with np.errstate(all="ignore"):
            away = np.linalg.norm(at - points, axis=1)
            moves = (away > _ROUNDED * self.size) & (away < _NEAR * self.size) & self.part.within(at)
        return np.where(moves[:, None], at, points)


def _listed(acts: Sequence[Acts], on: OnPart, balanced: bool) -> Setting:
    supports: list[Support] = []
    loads: list[Load] = []
    names = [a.name for a in acts]
    for i, act in enumerate(acts):
        name = act.name if names.count(act.name) == 1 else f"{act.name} #{names[: i + 1].count(act.name)}"
        where = OnSurface(act.holds, on.nearest)
        match act.name, act.numbers:
            case "held", (x, y, z):
                supports.append(Support(where, (bool(x), bool(y), bool(z)), name=name))
            case "moved", (x, y, z, dx, dy, dz):
                supports.append(Support(where, (bool(x), bool(y), bool(z)), (dx, dy, dz), name))
            case "force", (x, y, z):
                loads.append(Force(where, (x, y, z), name))
            case "pressure", (p,):
                loads.append(Pressure(where, p, name))
            case "torque", (x, y, z):
                loads.append(Moment(where, (x, y, z), name))
            case "weight", (x, y, z):
                loads.append(Weight((x * GRAVITY, y * GRAVITY, z * GRAVITY)))
    return Setting(tuple(supports), tuple(loads), balanced=balanced)


class Ends:
    """The ends and sides of a part of elements: what of its surface lies on them."""

    def __init__(self, mesh: TetMesh, size: float) -> None:
        triangles, _ = boundary(mesh)
        self.mesh = mesh
        self.corners = mesh.vertices[triangles]
        points = mesh.vertices[np.unique(triangles)]
        self.lo, self.hi = points.min(axis=0), points.max(axis=0)
        self.size = min(size, float((self.hi - self.lo).min()))  # of a plate that is thinner than that
        self.areas = np.linalg.norm(
            np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]), axis=1
        ) / 2  # fmt: skip

    def at(self, axis: int, high: bool, depth: float = 0.0) -> Side:
        """What lies at an end along an axis, or no deeper than so many mm."""
        end = float(self.hi[axis] if high else self.lo[axis])
        return Side(axis, end, max(depth, FLAT * self.size))

    def face(self, axis: int, high: bool) -> Side:
        """An end that is flat. Errors: E189."""
        side = self.at(axis, high)
        area = self.area(side)
        across = float(np.prod(np.delete(self.hi - self.lo, axis)))
        if area < _LEAST_FACE * across:
            where = f"{'xyz'[axis]} = {side.end:.6g} mm"
            hint = "cut the part flat there, or say where it is held and loaded: `study(part, fix=..., load=...)`"
            raise fail("E189", f"the part has no face at its end {where}", hint=hint)
        return side

    def on(self, where: Where) -> Patch:
        """What the solver finds of the surface in a selection."""
        return covered(where, *self._loaded, "a pad")

    @cached_property
    def _loaded(self) -> tuple[Nodes, Surface]:
        nodes = number(self.mesh.vertices, self.mesh.tets, 1)
        return nodes, surface(nodes)

    def area(self, side: Side) -> float:
        """How much of the surface lies on a side, in mm2."""
        flat = (np.abs(self.corners[:, :, side.axis] - side.end) <= side.near).all(axis=1)
        return float(self.areas[flat & side(self.corners.mean(axis=1))].sum())


@dataclass(frozen=True, slots=True)
class Side:
    """Places no farther than `near` (mm) from an end along an axis, and of those between two others along another."""

    axis: int
    end: float
    near: float
    along: int = 0
    between: tuple[float, float] = (-np.inf, np.inf)

    def __call__(self, points: Floats) -> Flags:
        there = points[:, self.along]
        within = (there >= self.between[0]) & (there <= self.between[1])
        return np.asarray((np.abs(points[:, self.axis] - self.end) <= self.near) & within)


def _only(*axes: int) -> tuple[bool, bool, bool]:
    return 0 in axes, 1 in axes, 2 in axes


def _compressed(ends: Ends, force: float, axis_: float, bonded: float) -> Setting:
    axis = int(axis_)
    low, high = ends.face(axis, high=False), ends.face(axis, high=True)
    held = (True, True, True) if bonded else _only(axis)
    by = [0.0, 0.0, 0.0]
    by[axis] = -1.0
    platens = (Support(low, held, name="platen"), Support(high, held, (by[0], by[1], by[2]), "platen that moves"))
    reached = (1, axis, force)
    return Setting(platens, (), reached, balanced=not bonded)


def _sheared(ends: Ends, force: float, axis_: float, toward_: float, sign: float) -> Setting:
    axis, toward = int(axis_), int(toward_)
    low, high = ends.face(axis, high=False), ends.face(axis, high=True)
    by = [0.0, 0.0, 0.0]
    by[toward] = 1.0
    moves = Support(high, (True, True, True), (by[0], by[1], by[2]), "platen that moves")
    return Setting((Support(low, name="platen"), moves), (), (1, toward, sign * force))


def _bent(
    ends: Ends, force: float, axis_: float, toward_: float, sign: float, points: float, span: float, pads: float
) -> Setting:
    axis, toward = int(axis_), int(toward_)
    total = [0.0, 0.0, 0.0]
    total[toward] = sign * force
    whole = (total[0], total[1], total[2])
    if points == 1:
        held = Support(ends.face(axis, high=False), name="held end")
        return Setting((held,), (Force(ends.face(axis, high=True), whole, "force at the end"),))
    low, high = float(ends.lo[axis]), float(ends.hi[axis])
    apart, wide = pads_of(low, high, span, pads)
    middle = (high + low) / 2
    pressed = [_pad(ends, toward, sign < 0, axis, middle, wide)]
    pressed += [_pad(ends, toward, sign > 0, axis, middle + side * apart / 2, wide) for side in (-1, 1)]
    return Setting((), _balanced(ends, pressed, axis, np.array(total)), balanced=True, rests=tuple(pressed[1:]))


def pads_of(low: float, high: float, span: float, pads: float) -> tuple[float, float]:
    """How far the supports of a beam from `low` to `high` (mm) are apart, and how wide each pad is; 0 for what is not
    given. Errors: E187 for pads that do not fit."""
    length = high - low
    apart, wide = span or _SPAN * length, pads or _PAD * length
    if apart + wide > length * (1 + 1e-9):
        hint = f"take a `span` of {length - wide:.4g} mm at most" if wide < length / 2 else "take narrower `pads`"
        raise fail("E187", f"supports {apart:.4g} mm apart, {wide:.3g} mm wide each, do not fit under a part that is "
                   f"{length:.4g} mm long", hint=hint)  # fmt: skip
    if 2 * wide > apart:
        hint = f"take pads of {apart / 4:.3g} mm"
        raise fail("E187", f"pads {wide:.3g} mm wide leave nothing of {apart:.4g} mm to bend", hint=hint)
    return apart, wide


def _balanced(ends: Ends, pads: Sequence[Where], axis: int, total: Floats) -> tuple[Load, ...]:
    """A force in the middle and two that bear it, spread over pads. A force acts in the middle of the area that the
    solver finds on its pad; where these lie beside each other, a couple on the outer pads balances the rest."""
    middle, *outer = (ends.on(pad).centre for pad in pads)
    one = (middle[axis] - outer[1][axis]) / (outer[0][axis] - outer[1][axis])
    forces = [total, -one * total, -(1 - one) * total]
    turn = np.cross(np.stack([middle, *outer]), np.stack(forces)).sum(axis=0)
    names = ("force in the middle", "first support", "second support")
    loads: list[Load] = [Force(pad, _triple(f), n) for pad, f, n in zip(pads, forces, names, strict=True)]
    if np.abs(turn).max() > 1e-12 * float(np.abs(total).max()) * float((ends.hi - ends.lo).max()):
        both = _either(*pads[1:])
        loads.append(Moment(both, _triple(-turn), "what balances the supports"))
    return tuple(loads)


def _either(one: Where, other: Where) -> Where:
    """What lies on one of two pads."""

    def on(points: Floats) -> Flags:
        return np.asarray(one(points) | other(points))

    if isinstance(one, Facing) and isinstance(other, Facing):
        return Facing(on, one.toward)
    return on


def _triple(of: Floats) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in of)
    return x, y, z


def _pad(ends: Ends, toward: int, high: bool, axis: int, middle: float, wide: float) -> Where:
    """Where a pad presses: on what is flat at that side, or where that is round, on what is no deeper than half the
    pad is wide."""
    between = middle - wide / 2, middle + wide / 2
    outward = np.zeros(3)
    outward[toward] = 1.0 if high else -1.0
    side, deep = (replace(ends.at(toward, high, d), along=axis, between=between) for d in (0.0, wide / 2))
    flat, closer = (Facing(s, _triple(outward)) for s in (side, replace(side, near=side.near / 4)))
    if (area := ends.on(flat).area) > 0 and ends.on(closer).area > _AS_FLAT * area:
        return flat
    if ends.on(deep).area > 0:
        return deep
    hint = f"the part does not reach there, or its elements ({ends.size:.3g} mm) are too coarse: give `size` or `pads`"
    place = f"{'xyz'[axis]} = {middle:.4g} mm"
    raise fail("E187", f"a pad {wide:.3g} mm wide at {place} touches nothing", hint=hint)


def _twisted(ends: Ends, torque: float, axis_: float) -> Setting:
    axis = int(axis_)
    total = [0.0, 0.0, 0.0]
    total[axis] = torque
    held = Support(ends.face(axis, high=False), name="held end")
    turned = Moment(ends.face(axis, high=True), (total[0], total[1], total[2]), "torque at the end")
    return Setting((held,), (turned,))
