"""A study of a program posed on voxels of its envelope: what holds and loads the real part, for the homogenised one.

Pads and platens are where `porelang.tasks.study.ends` finds them, on the ends and sides of the voxels. A test whose
loads balance each other is kept in place by three nodes, which then bear nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import PoreError, fail
from porelang.optimize.grid import Flags, Force, Grid, Moment, Platen, Problem, Support, Where
from porelang.tasks.study.asked import Acts, Question
from porelang.tasks.study.ends import pads_of

Array = NDArray[np.float64]


def posed(asked: Question, grid: Grid) -> Problem:
    """The problem of a study on a grid of its envelope.

    Errors: E193 for what acts on the walls of the real lattice alone, E191 for what selects nothing of the voxels, E187
    for pads that do not fit.
    """
    whole = asked.whole
    if whole is None:
        return _listed(asked.acts, grid)
    ends = _Ends(grid)
    if whole.name == "compress":
        force, axis, bonded = whole.numbers
        return _compressed(ends, force, int(axis), bool(bonded))
    if whole.name == "shear":
        force, axis, toward, sign = whole.numbers
        low, high = ends.at(int(axis), False), ends.at(int(axis), True)
        return Problem(grid, (Support(low),), (Platen(high, sign * force, int(toward), bonded=True),))
    if whole.name == "bend":
        return _bent(asked, ends, *whole.numbers)
    torque, axis = whole.numbers
    turning = Moment(ends.at(int(axis), True), _along(int(axis), torque), "the torque")
    return Problem(grid, (Support(ends.at(int(axis), False)),), (turning,))


def _listed(acts: tuple[Acts, ...], grid: Grid) -> Problem:
    supports: list[Support] = []
    loads: list[Force | Moment] = []
    for act in acts:
        match act.name, act.numbers:
            case "held", (x, y, z):
                supports.append(Support(act.holds, (bool(x), bool(y), bool(z)), "what is held"))
            case "force", (x, y, z):
                loads.append(Force(act.holds, (x, y, z)))
            case "torque", (x, y, z):
                loads.append(Moment(act.holds, (x, y, z)))
            case _:
                raise _not_there(act.name)
    return Problem(grid, tuple(supports), tuple(loads))


def _not_there(name: str) -> PoreError:
    why = {"pressure": "it acts on the walls of the lattice, within as without",
           "weight": "it changes with the density",
           "moved": "what a displacement takes is not to be as little as can be"}  # fmt: skip
    hint = "hold and load the part by forces and torques, or take the rule `energy`, which solves the lattice alone"
    return fail("E193", f"the homogenised part has no `{name}`: {why[name]}", hint=hint)


@dataclass(frozen=True, eq=False)
class _Ends:
    """The ends and sides of a part of voxels."""

    grid: Grid

    def at(self, axis: int, high: bool, among: Where | None = None) -> _Side:
        """What lies at an end along an axis, of places for which a condition holds."""
        nodes, middles, _ = self.grid.faces
        flat = np.ptp(self.grid.node_places(nodes.ravel()).reshape(-1, 4, 3)[..., axis], axis=1) == 0
        there = flat if among is None else flat & among(middles)
        if not there.any():
            return _Side(axis, np.nan, 0.0, among)
        along = middles[there][:, axis]
        return _Side(axis, float(along.max() if high else along.min()), self.grid.spacing[axis] / 8, among)

    @property
    def nodes(self) -> Array:
        """The nodes of the surface (n, 3) mm."""
        return self.grid.node_places(np.unique(self.grid.faces[0]))


@dataclass(frozen=True, eq=False)
class _Side:
    """Places no farther than `near` (mm) from an end along an axis, and for which a condition holds."""

    axis: int
    end: float
    near: float
    among: Where | None

    def __call__(self, places: Array) -> Flags:
        there = np.abs(places[:, self.axis] - self.end) <= self.near
        return np.asarray(there if self.among is None else there & self.among(places))


def _compressed(ends: _Ends, force: float, axis: int, bonded: bool) -> Problem:
    low, high = ends.at(axis, False), ends.at(axis, True)
    platen = Platen(high, -force, axis, bonded)
    if bonded:
        return Problem(ends.grid, (Support(low),), (platen,))
    rest = ends.nodes[low(ends.nodes)]
    first = rest[np.argmin(np.linalg.norm(rest - rest.mean(axis=0), axis=1))]
    away = rest[np.argmax(np.linalg.norm(rest - first, axis=1))]
    across = [a for a in range(3) if a != axis]
    least = min(across, key=lambda a: abs(away[a] - first[a]))  # a turn about the axis moves that the most
    held = Support(low, _axes(axis)), Support(_node(first, ends.grid), _axes(*across))
    return Problem(ends.grid, (*held, Support(_node(away, ends.grid), _axes(least))), (platen,))


def _bent(
    asked: Question, ends: _Ends, force: float, axis_: float, toward_: float, sign: float, points: float, span: float,
    pads: float,
) -> Problem:  # fmt: skip
    axis, toward, grid = int(axis_), int(toward_), ends.grid
    total = np.array(_along(toward, sign * force))
    if points == 1:
        loads = (Force(ends.at(axis, True), _along(toward, sign * force)),)
        return Problem(grid, (Support(ends.at(axis, False)),), loads)
    low, high = ends.at(axis, False).end, ends.at(axis, True).end
    apart, wide = pads_of(low, high, span, pads)
    middle = (low + high) / 2
    places = [ends.at(toward, sign < 0, _strip(grid, axis, middle, wide))]
    places += [ends.at(toward, sign > 0, _strip(grid, axis, middle + s * apart / 2, wide)) for s in (-1, 1)]
    names = ("the force in the middle", "the first support", "the second support")
    centres = []
    for place, name in zip(places, names, strict=True):
        faces, areas = grid.surface_faces(place, name)
        at = grid.node_places(faces.ravel()).reshape(-1, 4, 3).mean(axis=1)
        centres.append(np.average(at, axis=0, weights=areas))
    one = (centres[0][axis] - centres[2][axis]) / (centres[1][axis] - centres[2][axis])
    forces = np.stack([total, -one * total, (one - 1) * total])
    found: list[Force | Moment] = [
        Force(place, _triple(f), name) for place, f, name in zip(places, forces, names, strict=True)
    ]
    turn = np.cross(np.stack(centres), forces).sum(axis=0)
    if np.abs(turn).max() > 1e-9 * force * (high - low):
        found.append(Moment(lambda p: places[1](p) | places[2](p), _triple(-turn), "what balances the supports"))
    return Problem(grid, _pinned(ends), tuple(found))


def _strip(grid: Grid, axis: int, middle: float, wide: float) -> Where:
    """Places of a pad, which is a voxel wide at least."""
    half = max(wide, grid.spacing[axis]) / 2 * (1 + 1e-9)
    return lambda p: np.abs(p[:, axis] - middle) <= half


def _pinned(ends: _Ends) -> tuple[Support, ...]:
    """Three nodes far from each other that leave no rigid motion, and take no force from loads that balance."""
    nodes = ends.nodes
    first = nodes[np.argmin((nodes - nodes.min(axis=0)).sum(axis=1))]
    second = nodes[np.argmax(np.linalg.norm(nodes - first, axis=1))]
    line = (second - first) / np.linalg.norm(second - first)
    beside = nodes - first - np.outer((nodes - first) @ line, line)
    third = nodes[np.argmax(np.linalg.norm(beside, axis=1))]
    across = np.argsort(np.abs(line))[:2]  # these two keep it from turning the line
    normal = np.cross(line, third - first)
    pins = ((first, (0, 1, 2)), (second, tuple(across)), (third, (int(np.argmax(np.abs(normal))),)))
    return tuple(Support(_node(place, ends.grid), _axes(*axes)) for place, axes in pins)


def _node(place: Array, grid: Grid) -> Where:
    near = min(grid.spacing) / 8
    return lambda p: np.linalg.norm(p - place, axis=1) < near


def _axes(*axes: int) -> tuple[bool, bool, bool]:
    return 0 in axes, 1 in axes, 2 in axes


def _along(axis: int, value: float) -> tuple[float, float, float]:
    return _triple(value * np.eye(3)[axis])


def _triple(of: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in of)
    return x, y, z
