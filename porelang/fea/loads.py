"""Loads as forces on nodes: consistent with the shape functions, so that they do the same work on every
displacement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from porelang.diagnostics import fail
from porelang.fea.covered import Patch, covered, seen
from porelang.fea.elements import shape_values, tet_rule
from porelang.fea.nodes import EDGES, Nodes
from porelang.fea.problem import BodyForce, Floats, Force, Ints, Load, Moment, Pressure, Weight
from porelang.fea.surface import Surface, nothing, place, vectors

#: g/cm3 times mm/s2, in N/mm3.
GRAM = 1e-9
#: Body forces are integrated as exactly as polynomials of this degree times the shape functions.
_DEGREE = 5


def name_of(load: Load, number: int) -> str:
    """What a load is called in a sentence."""
    kind = {Force: "force", Pressure: "pressure", Moment: "moment", Weight: "weight", BodyForce: "body force"}[
        type(load)
    ]
    return f"the {kind} `{load.name}`" if load.name and load.name != kind else f"the {kind} number {number + 1}"


@dataclass(frozen=True, slots=True)
class Applied:
    """A load as forces (k, 3) N on nodes; what of the boundary it is `on`, None on the volume. `name` is what it is
    called in a sentence."""

    name: str
    forces: Floats
    on: Patch | None


def applied(load: Load, number: int, nodes: Nodes, boundary: Surface, density: Floats) -> Applied:
    """A load on all nodes. Errors: E170 where nothing is selected, E173 for no number, E174."""
    name = name_of(load, number)
    match load:
        case Weight():
            acceleration = _triple(load.acceleration, name)
            of_mass = _on_volume(nodes, lambda _, part: (density[part] * GRAM)[:, None, None] * acceleration, 2)
            return Applied(name, of_mass, None)
        case BodyForce():
            field = load.density
            of_field = _on_volume(
                nodes, lambda at, _: vectors(field, at.reshape(-1, 3), name).reshape(at.shape), _DEGREE
            )
            return Applied(name, of_field, None)
    on = _selected(load, name, nodes, boundary)
    shares = np.einsum("cq,cqd,cqw->cwd", on.areas, _traction(load, name, on), on.shapes)
    return Applied(name, _gathered(nodes.faces[on.faces], shares, len(nodes.points)), on)


def _traction(load: Force | Pressure | Moment, name: str, on: Patch) -> Floats:
    """The traction (c, q, 3) MPa at the points of what a load is on."""
    match load:
        case Force():
            return np.broadcast_to(_triple(load.total, name) / on.area, on.points.shape)
        case Pressure():
            value = float(_numbers(load.value, name))
            return np.broadcast_to(-value * on.normals[:, None], on.points.shape)
        case Moment():
            arms = on.points - on.centre
            inertia = np.eye(3) * np.einsum("cq,cqd,cqd->", on.areas, arms, arms) - np.einsum(
                "cq,cqi,cqj->ij", on.areas, arms, arms
            )
            turn = np.linalg.solve(inertia, _triple(load.total, name))
            return np.cross(turn, arms)


def _selected(load: Force | Pressure | Moment, name: str, nodes: Nodes, boundary: Surface) -> Patch:
    """What of the boundary a load is on."""
    on = covered(load.where, nodes, boundary, name)
    if not on.area > 0:
        corners = nodes.points[: nodes.vertices]
        points = boundary.points.reshape(-1, 3)
        raise nothing(name, "area", load.where, points, np.stack([corners.min(0), corners.max(0)]),
                      seen(nodes))  # fmt: skip
    if not on.all_seen:
        raise fail(
            "E170",
            f"{name} is on so narrow an area, at {place(on.centre)}, that all of it cannot be seen: "
            f"{on.area:.3g} mm2 of it are, by points {seen(nodes):.2g} mm apart and finer ones round it",
            hint="make it wider, or take finer elements",
        )
    return on


def _on_volume(nodes: Nodes, density: Callable[[Floats, slice], Floats], degree: int) -> Floats:
    """`density` gives N/mm3 at points (m, q, 3) of some tetrahedra, or what has the shape (m, 1, 3)."""
    barycentric, weights = tet_rule(degree)
    shapes = shape_values(barycentric, None if nodes.order == 1 else EDGES)
    out = np.zeros((len(nodes.points), 3))
    step = 50_000
    for first in range(0, len(nodes.elements), step):
        part = slice(first, first + step)
        points = np.einsum("qk,mkd->mqd", barycentric, nodes.points[nodes.corners[part]])
        values = np.broadcast_to(density(points, part), points.shape)
        shares = np.einsum("m,q,mqd,qw->mwd", nodes.volumes[part], weights, values, shapes, optimize=True)
        out += _gathered(nodes.elements[part], shares, len(out))
    return out


def _gathered(numbers: Ints, shares: Floats, count: int) -> Floats:
    flat = numbers.ravel()
    return np.stack([np.bincount(flat, shares[..., i].ravel(), count) for i in range(3)], axis=1)


def _triple(values: object, name: str) -> Floats:
    found = _numbers(values, name)
    if found.shape != (3,):
        raise fail("E173", f"{name} has no three components: {values!r}", hint="give (x, y, z)")
    return found


def _numbers(values: object, name: str) -> Floats:
    try:
        found = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        found = np.array(np.nan)
    if not np.isfinite(found).all():
        raise fail("E173", f"{name} is no number: {values!r}", hint="give finite numbers, in N, N mm or MPa")
    return found
