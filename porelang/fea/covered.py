"""What a selection covers of a boundary: of each triangle the part that lies in it, so that the area of a load does not
depend on where elements end.

A straight end of a selection cuts a triangle along a line, which is found on its sides by bisection: a strip, or what
lies beyond a plane, is covered to rounding. Where the end is no line, triangles are quartered until it nearly is one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.fea.assemble import Longs
from porelang.fea.elements import TRIANGLE_EDGES, shape_values, triangle_rule
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Facing, Floats, Mask, OnSurface, Where
from porelang.fea.rims import over_rims
from porelang.fea.surface import Surface, asked

#: Exact for tractions that are linear, on quadratic shapes.
_DEGREE = 3
#: Points on each side of a triangle that is looked at, at first and where it was quartered: a strip so much narrower
#: than a triangle is seen in all of it.
_FIRST, _THEN = 8, 4
#: Triangles are quartered so often, unless there are then more than that; and more often as long as they are few.
_QUARTERED, _MOST, _ONCE_MORE, _FEW = 3, 20_000, 5, 1000
#: What covers less of the triangles that it reaches, and none of them whole, is looked at again in quarters of these,
#: so often, as long as there are no more than that, in no more rounds.
_NARROW, _DEEPEST, _QUARTERS, _ROUNDS = 0.15, 5, 40_000, 20
#: Halvings of a side; what is left of it at an end is none; and points so near to a line may lie on either side of it.
_BISECTIONS, _END, _NEAR = 30, 1e-6, 1e-3
#: An end that leaves the line between its places on two sides by this share of how far that is from their corner is
#: none.
_BENT = 5e-3
#: By how much of its size a facet is asked within.
_WITHIN = 0.15
#: The cosine of an angle up to which a triangle looks in a direction.
_ALIKE = 0.9


@dataclass(frozen=True, slots=True)
class Patch:
    """What is covered, in pieces: of which triangle of the boundary each is (`faces`, (c,)), points of quadrature
    (c, q, 3) mm on it with the area (c, q) mm2 and the shape functions (c, q, w) of each, outward normals (c, 3).

    `chosen` (f, q) are the points of the boundary's own quadrature that lie in the selection; `all_seen` says that it
    is not so narrow that there may be more of it between the points that are looked at.
    """

    faces: Longs
    points: Floats
    areas: Floats
    shapes: Floats
    normals: Floats
    chosen: Mask
    all_seen: bool

    @property
    def area(self) -> float:
        """mm2."""
        return float(self.areas.sum())

    @property
    def centre(self) -> Floats:
        """The middle (3,) mm of an area that is not 0."""
        return np.asarray(np.einsum("cq,cqd->d", self.areas, self.points) / self.areas.sum())

    @property
    def widths(self) -> tuple[float, float]:
        """How narrow and how wide (mm) an area that is not 0 is: of what is evenly w wide the variance is w^2 / 12."""
        arms = (self.points - self.centre).reshape(-1, 3)
        spread = np.einsum("n,ni,nj->ij", self.areas.ravel(), arms, arms) / self.area
        _, narrow, wide = np.sqrt(12 * np.maximum(np.linalg.eigvalsh(spread), 0.0))
        return float(narrow), float(wide)

    def of_nodes(self, nodes: Nodes, values: Floats) -> Floats:
        """Values (k, 3) of nodes at its points, (c, q, 3)."""
        return np.asarray(np.einsum("cqw,cwd->cqd", self.shapes, values[nodes.faces[self.faces]]))


def covered(where: Where, nodes: Nodes, boundary: Surface, what: str) -> Patch:
    """What a selection covers of the boundary, but for what of it reaches over a rim (`porelang.fea.rims`); nothing,
    where that lies between the points that are looked at (`seen`). Errors: E174."""
    corners = nodes.points[nodes.faces[:, :3]]
    chosen, within = _first_seen(where, corners, boundary, what)
    at_corners = asked(where, within.reshape(-1, 3), what).reshape(-1, 3)
    all_, any_ = chosen.all(axis=1) & at_corners.all(axis=1), chosen.any(axis=1) | at_corners.any(axis=1)
    if isinstance(where, Facing):
        looks = boundary.normals @ np.asarray(where.toward, np.float64) > _ALIKE
        chosen, all_, any_ = chosen & looks[:, None], all_ & looks, any_ & looks
    else:
        looks = np.ones(len(corners), bool)
    near = np.zeros(len(nodes.points), bool)
    near[nodes.faces[any_ & ~all_, :3]] = True
    close = looks & near[nodes.faces[:, :3]].any(axis=1)  # a strip that is narrower than elements goes on beside them
    if not any_.any():
        close = looks
    whole = np.flatnonzero(all_ & ~close)
    of_triangles = boundary.areas.sum(axis=1)
    if all_.any():  # larger than triangles are
        cut, pieces = _pieces(where, within[close], np.broadcast_to(np.eye(3), (close.sum(), 3, 3)), what)
        cut, all_seen = np.flatnonzero(close)[cut], True
    else:
        cut, pieces, all_seen = _small(where, within, close, looks, nodes, of_triangles, what)
    faces = np.concatenate([whole, cut])
    parts = np.concatenate([np.broadcast_to(np.eye(3), (len(whole), 3, 3)), pieces])
    rule, weights = triangle_rule(_DEGREE)
    inside = np.einsum("qk,ckj->cqj", rule, parts)
    share = np.abs(np.linalg.det(parts)) if len(parts) else np.zeros(0)
    areas = share * of_triangles[faces]
    if not isinstance(where, Facing):
        held: Floats = np.bincount(faces, areas, len(corners)).astype(np.float64)
        kept = ~over_rims(nodes, boundary.normals, of_triangles, held)[faces]
        faces, inside, areas = faces[kept], inside[kept], areas[kept]
    shapes = shape_values(inside.reshape(-1, 3), None if nodes.order == 1 else TRIANGLE_EDGES)
    return Patch(
        faces=faces,
        points=np.einsum("cqj,cjd->cqd", inside, corners[faces]),
        areas=areas[:, None] * weights,
        shapes=shapes.reshape(*inside.shape[:2], shapes.shape[-1]),
        normals=boundary.normals[faces],
        chosen=chosen,
        all_seen=all_seen,
    )


def seen(nodes: Nodes) -> float:
    """How far apart (mm) the points of a boundary are, at most, that a selection is asked at."""
    corners = nodes.points[nodes.faces[:, :3]]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()) / _FIRST


def _small(
    where: Where, corners: Floats, first: Mask, looks: Mask, nodes: Nodes, areas: Floats, what: str
) -> tuple[Longs, Floats, bool]:
    """What is selected of triangles of `areas` (f,) of which none is selected whole, as `_pieces` has it, from the
    `first` (f,) on to those beside them; and whether that is all of it.

    What is narrow beside triangles, or not seen at all, is looked at in quarters of these.
    """
    close, parts, depth = np.flatnonzero(first), np.eye(3)[None], 0
    for _ in range(_ROUNDS):
        of, started = np.repeat(close, len(parts)), np.tile(parts, (len(close), 1, 1))
        which, pieces = _pieces(where, corners[of], started, what)
        cut = of[which]
        area = float((np.abs(np.linalg.det(pieces)) * areas[cut]).sum()) if len(cut) else 0.0
        seen_all = area > _NARROW * float(areas[of[np.unique(which)]].sum()) / len(parts)
        last = close
        if len(cut):  # it may go on beside them
            near = np.zeros(len(nodes.points), bool)
            near[nodes.faces[np.unique(cut), :3]] = True
            close = np.flatnonzero(looks & near[nodes.faces[:, :3]].any(axis=1))
        more = not np.isin(close, last).all()
        if seen_all and not more:
            return cut, pieces, True
        depth += not seen_all
        if depth > _DEEPEST or 4**depth * len(close) > _QUARTERS:
            break
        parts = parts if seen_all else _quartered(parts)
    return cut, pieces, False


def _first_seen(where: Where, corners: Floats, boundary: Surface, what: str) -> tuple[Mask, Floats]:
    """Which points (f, q) of the boundary are selected, and the corners (f, 3, 3) that each triangle is asked between.

    Those of a facet of a round wall are a little within it: at a rim its own corners lie on the wall beside.
    """
    points = boundary.points.reshape(-1, 3)
    if not isinstance(where, OnSurface):
        return asked(where, points, what).reshape(boundary.areas.shape), corners
    at = where.nearest(points)
    chosen = asked(where.anywhere, at, what).reshape(boundary.areas.shape)
    facets = (at != points).any(axis=1).reshape(boundary.areas.shape).any(axis=1)
    middle = corners.mean(axis=1, keepdims=True)
    return chosen, np.where(facets[:, None, None], middle + (1 - _WITHIN) * (corners - middle), corners)


def _pieces(where: Where, corners: Floats, parts: Floats, what: str) -> tuple[Longs, Floats]:
    """Triangles (c, 3, 3), a corner a row in barycentric coordinates of a face, and of which of some `parts` (n, 3, 3)
    of faces with `corners` (n, 3, 3) each is a piece (c,), that together are what is selected of these."""
    faces = np.arange(len(parts))
    found: list[tuple[Longs, Floats]] = []
    for level in range(_ONCE_MORE + 1):
        lattice = _lattice(_FIRST if level == 0 and len(faces) <= _QUARTERS else _THEN)
        points = np.einsum("lk,nkj,njd->nld", lattice, parts, corners[faces], optimize=True)
        held = asked(where, points.reshape(-1, 3), what).reshape(points.shape[:2])
        all_ = held.all(axis=1)
        found.append((faces[all_], parts[all_]))
        some = held.any(axis=1) & ~all_
        faces, parts, held = faces[some], parts[some], held[some]
        if not len(faces):
            break
        lone, cuts, straight = _parted(where, corners[faces], parts, held, lattice, what)
        most_of = _MOST if level < _QUARTERED else _FEW if level < _ONCE_MORE else 0
        last = 4 * len(faces) > most_of
        if last:  # what no line parts is taken for what most of its points are
            most = ~straight & (lone < 0) & (held.mean(axis=1) > 0.5)
            found.append((faces[most], parts[most]))
            straight = lone >= 0
        corner_in = np.take_along_axis(held[:, :3], np.maximum(lone, 0)[:, None], axis=1)[:, 0]
        for inside in (True, False):
            these = straight & (corner_in == inside)
            for piece in _clipped(parts[these], lone[these], cuts[these], inside):
                found.append((faces[these], piece))
        if last:
            break
        faces, parts = np.repeat(faces[~straight], 4), _quartered(parts[~straight])
    numbers = np.concatenate([f for f, _ in found])
    pieces = np.concatenate([p for _, p in found])
    there = np.abs(np.linalg.det(pieces)) > _END**2 if len(pieces) else np.zeros(0, bool)
    return numbers[there], pieces[there]


def _lattice(steps: int) -> Floats:
    """Points (l, 3) in barycentric coordinates, so many steps along each side; the corners first."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(steps + 1), np.arange(steps + 1), indexing="ij"))
    inside = (i + j <= steps) & (np.maximum(np.maximum(i, j), steps - i - j) < steps)
    i, j = i[inside], j[inside]
    return np.concatenate([np.eye(3), np.stack([steps - i - j, i, j], axis=1) / steps])


def _parted(
    where: Where, corners: Floats, parts: Floats, held: Mask, lattice: Floats, what: str
) -> tuple[Longs, Floats, Mask]:
    """Of triangles of which some points are held: the corner (n,) that is held alone, or alone is not (-1: no one);
    at which share (n, 2) of the sides from it to the next two corners that changes; and whether a line through both
    places parts all points that were looked at."""
    three = held[:, :3]
    count = three.sum(axis=1)
    alone = np.where(count == 1, three.argmax(axis=1), (~three).argmax(axis=1))
    lone = np.where((count == 1) | (count == 2), alone, -1)
    k = np.maximum(lone, 0)
    sides = np.stack([(k + 1) % 3, (k + 2) % 3], axis=1)
    rows = np.arange(len(k))[:, None]
    start = np.einsum("nj,njd->nd", parts[rows[:, 0], k], corners)
    ends = np.einsum("nsj,njd->nsd", parts[rows, sides], corners)
    low, high = np.zeros(sides.shape), np.ones(sides.shape)
    of_lone = three[rows, k[:, None]]
    some = lone >= 0
    for _ in range(_BISECTIONS if some.any() else 0):
        middle = (low + high) / 2
        at = start[some, None] + middle[some][..., None] * (ends[some] - start[some, None])
        same = asked(where, at.reshape(-1, 3), what).reshape(-1, 2) == of_lone[some]
        low[some] = np.where(same, middle[some], low[some])
        high[some] = np.where(same, high[some], middle[some])
    cuts = (low + high) / 2
    cuts = np.where(cuts < _END, 0.0, np.where(cuts > 1 - _END, 1.0, cuts))
    at_sides = lattice[:, sides].transpose(1, 0, 2)  # (n, l, 2)
    # beyond the line through (a, 0) and (0, b) are x and y with x b + y a > a b
    a, b = np.maximum(cuts[:, None, 0], _END), np.maximum(cuts[:, None, 1], _END)
    beyond = at_sides[..., 0] * b + at_sides[..., 1] * a - a * b
    wrong = ((beyond < 0) != (held == of_lone)) & (np.abs(beyond) > _NEAR * (a + b))
    straight = some & ~wrong.any(axis=1)
    middle = start + np.einsum("ns,nsd->nd", cuts, ends - start[:, None]) / 2
    for share, same in ((1 - _BENT, True), (1 + _BENT, False)):
        at = start[straight] + share * (middle - start)[straight]
        straight[straight] = (asked(where, at, what) == of_lone[straight, 0]) == same
    return lone, cuts, straight


def _clipped(parts: Floats, lone: Longs, cuts: Floats, inside: bool) -> list[Floats]:
    """The triangles (n, 3, 3) between a corner and a line, or the two between the line and the other two corners."""
    rows = np.arange(len(lone))
    one, two, three = parts[rows, lone], parts[rows, (lone + 1) % 3], parts[rows, (lone + 2) % 3]
    first, second = one + cuts[:, :1] * (two - one), one + cuts[:, 1:] * (three - one)
    if inside:
        return [np.stack([one, first, second], axis=1)]
    return [np.stack([first, two, three], axis=1), np.stack([first, three, second], axis=1)]


def _quartered(parts: Floats) -> Floats:
    """Each triangle (n, 3, 3) in four (4 n, 3, 3), by the middles of its sides."""
    a, b, c = parts[:, 0], parts[:, 1], parts[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    four = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.stack(four, axis=1).reshape(-1, 3, 3)
