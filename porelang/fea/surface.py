"""Selections of a boundary: how they are asked, and what is said where one selects nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.fea.elements import triangle_rule
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Mask, OnSurface, Where

#: Nine points of each triangle, at which a selection is asked first.
_DEGREE = 4
#: What is a little beyond an end of a part, of its size.
_ASIDE = 0.01
#: How many times the size of the part is looked at on each side for what is selected: a slip of the unit is thousands.
_FAR = (1.0, 10.0, 100.0, 1000.0)
#: Directions in which a line is looked for that parts the points of a triangle.
_WAYS = 180
#: How a distance to a selection is found: from so many points of the boundary, bisected so often, on so many grids;
#: and below which share of the part's box it is none.
_NEAREST, _BISECTIONS, _FINER, _TOUCHES = 64, 50, 3, 1e-9


@dataclass(frozen=True, slots=True)
class Surface:
    """Points of quadrature on the boundary (f, q, 3) mm, the area (f, q) mm2 of each, and outward normals (f, 3)."""

    points: Floats
    areas: Floats
    normals: Floats


def surface(nodes: Nodes) -> Surface:
    """The boundary of a mesh, ready to be loaded."""
    barycentric, weights = triangle_rule(_DEGREE)
    corners = nodes.points[nodes.faces[:, :3]]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    normals = cross / np.where(twice > 0, twice, 1.0)[:, None]
    return Surface(np.einsum("qk,fkd->fqd", barycentric, corners), twice[:, None] / 2 * weights, normals)


def asked(where: Where, points: Floats, what: str) -> Mask:
    """Which points (n, 3) are selected, (n,). Errors: E174 for what is no selection."""
    shape = (len(points),)
    found = np.asarray(_called(where, points, what))
    if found.shape != shape:
        raise fail(
            "E174",
            f"the selection of {what} gives an array of the shape {found.shape} for {shape[0]} points",
            hint=f"give True or False for each point: an array of the shape ({shape[0]},)",
        )
    if found.dtype == bool:
        return found
    _finite(found, points, f"the selection of {what}")
    raise fail(
        "E174",
        f"the selection of {what} gives numbers, such as {found.flat[0]:.4g}, where True or False is wanted",
        hint="compare: lambda p: field(p) < 0",
    )


def vectors(field: Any, points: Floats, what: str) -> Floats:
    """The vectors (n, 3) of a field at points (n, 3). Errors: E174."""
    found = np.asarray(_called(field, points, what))
    if found.shape != points.shape or found.dtype.kind not in "fiu":
        raise fail(
            "E174",
            f"{what} gives an array of the shape {found.shape} for {len(points)} points",
            hint=f"give a vector for each point: an array of the shape ({len(points)}, 3)",
        )
    _finite(found, points, what)
    return found.astype(np.float64)


def _called(field: Any, points: Floats, what: str) -> Any:
    try:
        return field(points)
    except PoreError:
        raise
    except (TypeError, ValueError, IndexError, ArithmeticError) as error:
        raise fail("E174", f"{what} cannot be evaluated: {error}",
                   hint="it is called with points, an array (n, 3) in mm") from error  # fmt: skip


def _finite(found: Any, points: Floats, what: str) -> None:
    bad = ~np.isfinite(np.asarray(found, np.float64)).reshape(len(points), -1).all(axis=1)
    if bad.any():
        at = int(np.argmax(bad))
        raise fail(
            "E174",
            f"{what} is no number at {place(points[at])}, and at {bad.sum()} of {len(points)} points in all",
            hint="a field that divides by 0 or takes a root of less than 0 there has no value: guard it",
        )


def interleaved(chosen: Mask) -> Mask:
    """Which triangles (f,) have points of quadrature (f, q) chosen that no straight line parts from the others: a
    selection cuts a triangle in two, unless it follows the surface itself, or is smaller than a triangle."""
    barycentric, _ = triangle_rule(_DEGREE)
    angles = np.pi * np.arange(_WAYS) / _WAYS
    along = barycentric[:, :2] @ np.stack([np.cos(angles), np.sin(angles)])
    out: Mask = np.asarray(chosen.any(axis=1) & ~chosen.all(axis=1))
    some: Mask = chosen[out][:, :, None]

    def least(mask: Mask) -> Floats:
        return np.asarray(np.where(mask, along, np.inf).min(axis=1))

    def most(mask: Mask) -> Floats:
        return np.asarray(np.where(mask, along, -np.inf).max(axis=1))

    parted = (most(some) < least(~some)) | (most(~some) < least(some))
    out[out] = ~parted.any(axis=1)
    return out


def nothing(what: str, kind: str, where: Where, points: Floats, box: Floats, apart: float) -> PoreError:
    """E170: a selection that holds no point of the boundary, with how near it comes; these were `apart` (mm).

    The selection is asked on a grid of points in twice the part's box, and if it holds none of them in larger ones.
    From the points of the boundary nearest to what it holds there, its end is bisected; round the nearest of these,
    finer grids find where it is nearer still.
    """
    low, high = box
    if isinstance(where, OnSurface):
        where = where.anywhere
    for far in _FAR:
        held = _held_on_grid(where, (low + high) / 2, far * (high - low), 41, what)
        if len(held):
            break
    extent = f"the part reaches from {place(low)} to {place(high)}"
    if not len(held):
        return fail(
            "E170",
            f"{what} selects no {kind} of the boundary, which is looked at every {apart:.2g} mm, nor anything near: "
            f"{extent}",
            hint="if it is small, make it wider than that, or take finer elements; if not, select a region that the "
            f"boundary runs through, with some room, as in {_room(low, high, int(np.argmax(high - low)), high)}",
        )
    from scipy.spatial import cKDTree

    distances, which = cKDTree(held).query(points)
    first = np.argsort(distances, kind="stable")[:_NEAREST]
    ends = _bisected(where, points[first], held[which[first]], what)
    best = int(np.argmin(np.linalg.norm(ends - points[first], axis=1)))
    start, end = points[first[best]], ends[best]
    for _ in range(_FINER):
        there = _held_on_grid(where, start, np.full(3, np.linalg.norm(end - start)), 21, what)
        if len(there):
            nearest = there[np.argsort(np.linalg.norm(there - start, axis=1))[:_NEAREST]]
            tried = _bisected(where, np.broadcast_to(start, nearest.shape), nearest, what)
            end = min((end, *tried), key=lambda p: float(np.linalg.norm(p - start)))
    gap = float(np.linalg.norm(end - start))
    if gap <= _TOUCHES * float(np.linalg.norm(high - low)):
        said = f"it ends at the boundary, at {place(start)}, which it does not hold"
        return fail("E170", f"{what} selects no {kind} of the boundary: {said}; {extent}",
                    hint=f"give it some room: {_ends(where, start, low, high)}")  # fmt: skip
    return fail(
        "E170",
        f"{what} selects no {kind} of the boundary: the nearest is at {place(start)}, "
        f"and {gap:.3g} mm from what is selected, at {place(end)}; {extent}",
        hint="move the selection there, or give it more room",
    )


def _ends(where: Where, at: Floats, low: Floats, high: Floats) -> str:
    """How an end of the part is selected, in its own numbers: the one that a selection just misses at a place of it, as
    it holds what is a little beyond along that axis."""
    beyond = np.where(high - at < at - low, 1.0, -1.0) * _ASIDE * (high - low)
    held = np.asarray(where(at + np.diag(beyond)))
    apart = np.where(held, 0.0, 1.0) + np.minimum(at - low, high - at) / (high - low)
    return _room(low, high, int(np.argmin(apart)), at)


def _room(low: Floats, high: Floats, axis: int, at: Floats) -> str:
    """How the end of a part along an axis that is the nearer one to a place is selected, with a hundredth of room."""
    upper = high[axis] - at[axis] < at[axis] - low[axis]
    end = high[axis] if upper else low[axis]
    room = 10.0 ** np.floor(np.log10((high[axis] - low[axis]) / 30))
    inner = end - room if upper else end + room
    return f"{'xyz'[axis]} {'>' if upper else '<'} {inner:.6g}mm, where the part ends at {end:.6g} mm"


def _held_on_grid(where: Where, middle: Floats, half: Floats, count: int, what: str) -> Floats:
    """The points of a grid that are selected, (n, 3)."""
    axes = [np.linspace(m - h, m + h, count) for m, h in zip(middle, half, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid[_anywhere(where, grid, what)]


def _anywhere(where: Where, points: Floats, what: str) -> Mask:
    """Which points are selected; none where it has no answer, as it may away from the boundary."""
    try:
        return asked(where, points, what)
    except PoreError:
        return np.zeros(len(points), bool)


def _bisected(where: Where, out: Floats, held: Floats, what: str) -> Floats:
    """Where a selection begins (n, 3), on the way from points that it does not hold to others that it does."""
    low, high = np.zeros(len(out)), np.ones(len(out))
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        inside = _anywhere(where, out + middle[:, None] * (held - out), what)
        low, high = np.where(inside, low, middle), np.where(inside, middle, high)
    return np.asarray(out + high[:, None] * (held - out))


def place(point: Floats) -> str:
    """A point in a sentence."""
    return f"{vector(point)} mm"


def vector(values: Floats) -> str:
    """Three numbers in a sentence; one that is 0 beside the others is said to be 0."""
    largest = float(np.abs(values).max())
    return "(" + ", ".join(f"{v if abs(v) > 1e-9 * largest else 0.0:.4g}" for v in values) + ")"
