"""What is selected of a boundary: nodes for supports, area for loads; and what is said where that is nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.fea.elements import TRIANGLE_EDGES, shape_values, triangle_rule
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Mask, Where

#: Exact for quadratic tractions on quadratic shapes, and nine points to see where a selection cuts through.
_DEGREE = 4


@dataclass(frozen=True, slots=True)
class Surface:
    """Points of quadrature on the boundary (f, q, 3) mm, the area (f, q) mm2 of each, outward normals (f, 3), and the
    shape functions (q, w) there."""

    points: Floats
    areas: Floats
    normals: Floats
    shapes: Floats


def surface(nodes: Nodes) -> Surface:
    """The boundary of a mesh, ready to be loaded."""
    barycentric, weights = triangle_rule(_DEGREE)
    corners = nodes.points[nodes.faces[:, :3]]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    shapes = shape_values(barycentric, None if nodes.order == 1 else TRIANGLE_EDGES)
    normals = cross / np.where(twice > 0, twice, 1.0)[:, None]
    return Surface(np.einsum("qk,fkd->fqd", barycentric, corners), twice[:, None] / 2 * weights, normals, shapes)


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


def nothing(what: str, kind: str, where: Where, points: Floats, box: Floats) -> PoreError:
    """E170: a selection that holds no point of the boundary, with how near it comes, as far as points round it tell.

    The selection is asked on a grid of points in twice the part's box: what it holds there, and which point of the
    boundary is nearest to that.
    """
    low, high = box
    middle, half = (low + high) / 2, (high - low)
    axes = [np.linspace(m - h, m + h, 41) for m, h in zip(middle, half, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    try:
        held = grid[asked(where, grid, what)]
    except PoreError:  # away from the boundary it may have no answer
        held = grid[:0]
    extent = f"the part reaches from {place(low)} to {place(high)}"
    if not len(held):
        return fail(
            "E170",
            f"{what} selects no {kind} of the boundary, nor anything near: {extent}",
            hint="select a region that the boundary runs through, "
            "with some room: z < -149mm where the part ends at z = -150mm",
        )
    from scipy.spatial import cKDTree

    distances, which = cKDTree(held).query(points)
    nearest = int(np.argmin(distances))
    return fail(
        "E170",
        f"{what} selects no {kind} of the boundary: the nearest is at {place(points[nearest])}, "
        f"and about {distances[nearest]:.3g} mm from what is selected, at {place(held[which[nearest]])}; {extent}",
        hint="move the selection there, or give it more room",
    )


def place(point: Floats) -> str:
    """A point in a sentence."""
    return f"{vector(point)} mm"


def vector(values: Floats) -> str:
    """Three numbers in a sentence; one that is 0 beside the others is said to be 0."""
    largest = float(np.abs(values).max())
    return "(" + ", ".join(f"{v if abs(v) > 1e-9 * largest else 0.0:.4g}" for v in values) + ")"
