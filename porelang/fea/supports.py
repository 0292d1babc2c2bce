"""Supports on nodes: which components are held, and at what displacement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.diagnostics import PoreError, fail
from porelang.fea.covered import covered
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints, Mask, Support
from porelang.fea.surface import asked, nothing, place, surface, vectors

#: Two supports agree if what they prescribe differs by less than this of the part's size.
_AGREE = 1e-12


@dataclass(frozen=True, slots=True)
class Held:
    """`components` (k, 3) of the nodes are held at `displacement` (k, 3) mm, each by so many `supports` (k, 3); `nodes`
    and `axes` are those of each support."""

    components: Mask
    displacement: Floats
    supports: Ints
    nodes: tuple[Ints, ...]
    axes: tuple[tuple[bool, bool, bool], ...]


def name_of(support: Support, number: int) -> str:
    """What a support is called in a sentence."""
    return f"the support `{support.name}`" if support.name else f"the support number {number + 1}"


def hold_all(supports: tuple[Support, ...], nodes: Nodes) -> Held:
    """What supports hold. Errors: E170 where one selects nothing, E173 for one that holds no axis, E174, E177 where
    two disagree."""
    boundary = np.unique(nodes.faces)
    points = nodes.points[boundary]
    box = np.stack([points.min(0), points.max(0)])
    size = float(np.linalg.norm(box[1] - box[0]))
    components = np.zeros(nodes.points.shape, bool)
    displacement = np.zeros(nodes.points.shape)
    by = np.full(nodes.points.shape, -1, np.int32)
    count = np.zeros(nodes.points.shape, np.int32)
    chosen = []
    for number, support in enumerate(supports):
        name = name_of(support, number)
        axes = np.asarray(support.axes)
        if axes.shape != (3,) or axes.dtype != bool or not axes.any():
            raise fail(
                "E173",
                f"{name} holds no axis: {support.axes!r}",
                hint="say for each of x, y, z whether it is held: (False, False, True) lets a face slide",
            )
        found = asked(support.where, points, name)
        if not found.any():
            raise _none(support, name, nodes, points, box)
        mine = boundary[found]
        wanted = _prescribed(support, points[found], name)
        for axis in np.flatnonzero(axes):
            other = components[mine, axis] & (np.abs(displacement[mine, axis] - wanted[:, axis]) > _AGREE * size)
            if other.any():
                at = mine[np.argmax(other)]
                first = name_of(supports[by[at, axis]], int(by[at, axis]))
                raise fail(
                    "E177",
                    f"{first} moves {place(nodes.points[at])} by {displacement[at, axis]:.4g} mm along "
                    f"{'xyz'[axis]}, and "
                    f"{name} by {wanted[np.argmax(other), axis]:.4g} mm",
                    hint="have them select different nodes, or hold different axes",
                )
            components[mine, axis] = True
            displacement[mine, axis] = wanted[:, axis]
            by[mine, axis] = number
            count[mine, axis] += 1
        chosen.append(mine.astype(np.int32))
    return Held(components, displacement, count, tuple(chosen), tuple(support.axes for support in supports))


def _none(support: Support, name: str, nodes: Nodes, points: Floats, box: Floats) -> PoreError:
    """E170 for a support that holds no node: it is smaller than elements, or elsewhere."""
    on = covered(support.where, nodes, surface(nodes), name)
    corners = nodes.points[nodes.faces[:, :3]]
    edge = float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean())
    if not on.area > 0:
        return nothing(name, "node", support.where, points, box, edge / nodes.order)
    return fail(
        "E170",
        f"{name} selects {on.area:.3g} mm2 of the boundary, at {place(on.centre)}, and no node there: it is smaller "
        f"than an element, of some {edge:.2g} mm",
        hint=f"hold more of the part, or take elements of some {on.widths[0] / 4:.1g} mm there",
    )


def _prescribed(support: Support, points: Floats, name: str) -> Floats:
    given = support.displacement
    if callable(given):
        return vectors(given, points, f"the displacement of {name}")
    return vectors(
        lambda p: np.broadcast_to(np.asarray(given, np.float64), p.shape), points, f"the displacement of {name}"
    )


def hold_still(fields: Floats, vertices: int) -> Ints:
    """Components, as 3 node + axis, that together hold r motions (r, k, 3): the pivots of their columns, of vertices
    only.

    As many as there are motions, so that loads which do no work on the motions leave no force there.
    """
    from scipy.linalg import qr

    flat = fields[:, :vertices].reshape(len(fields), -1)
    pivots = qr(flat, mode="r", pivoting=True)[1] if len(fields) else np.zeros(0, np.int32)
    return np.asarray(pivots[: len(fields)], np.int32)
