"""Void that lies within tetrahedra: a slit narrower than a cube, whose corners do not know of it, is filled by them,
and what is on both sides of it is joined.

It is looked for along the edges of the mesh: one that leaves the part and enters it again, through surfaces that face
each other, spans void. Chords of a hollow lie in void too, but the surface at their ends is the same. Many such edges
side by side are a gap that is closed; how far they reach is how much is joined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from porelang.diagnostics import Diagnostic
from porelang.solid import Solid
from porelang.tet.gap import OPEN, Gap, told
from porelang.tet.tetmesh import Indices, TetMesh
from porelang.walls import rounded

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: Places along an edge that are looked at first, steps by which the greatest value is sought from there, and by which
#: a side of the void is.
_PLACES, _CLOSER, _HALVINGS = 8, 6, 20
#: How much more steeply than nearly all edges show (this share of them) the field may change along one.
_STEEP, _NEARLY = 2.0, 0.99
#: Tetrahedra whose edges are asked at first, of more; and how far beside void the others are, in edges.
_MOST, _BESIDE = 60_000, 2.0
#: Cosine between the outward directions on both sides: 30 degrees of a wedge at most. At a blunter one void ends within
#: an element. Measured, none in 22 meshes of lattices in boxes and cylinders.
_FACING = -0.87
#: Edges whose void is no farther apart than this share of the longest span one gap. Where it lies beside a plane of
#: corners of cubes, they do so round these corners, an edge apart.
_TOGETHER = 1.3
#: Edges to a gap: fewer are a corner.
_FEWEST = 4
#: A gap of which a tenth is narrower than this part of the rest runs out in an edge or a point.
_TAPERS = 0.5
#: Extents of gaps are found to a tenth: so much of them is no less than they hold.
_AMPLE = 1.1


@dataclass(frozen=True, slots=True)
class Spanned:
    """Void that edges of a mesh span: the middles (n, 3) of it, how wide it is across (n,), and how long the edges are
    (n,), in mm."""

    middle: Floats
    width: Floats
    length: Floats


def closed_gap(found: Spanned) -> Gap | None:
    """The gap that is closed over the most, of what edges span; None where that is none."""
    middle, width, length = found.middle, found.width, found.length
    if len(width) < _FEWEST:
        return None
    pairs = cKDTree(middle).query_pairs(_TOGETHER * float(length.max()), output_type="ndarray")
    beside = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), (len(middle), len(middle)))
    _, which = connected_components(beside, directed=False)
    gaps = [_gap(middle[which == k], width[which == k]) for k in np.flatnonzero(np.bincount(which) >= _FEWEST)]
    most = max(gaps, key=lambda g: g.reach[0] * max(g.reach[1], float(np.median(length))), default=None)
    volume = _AMPLE * sum(g.wide * g.reach[0] * max(g.reach[1], g.wide) for g in gaps)
    return None if most is None else replace(most, of=len(gaps), volume=volume)


def closed(spans: Spanned, size: float) -> list[Diagnostic]:
    """W254 where a gap is closed, with a place; `size` is that of the cubes (mm)."""
    found = closed_gap(spans)
    if found is None:
        return []
    if found.tapers:
        hint = "smaller cubes (--size, --surface-size) close less of what narrows to nothing; separate it, or join it"
    else:
        hint = f"take a --size, or a --surface-size, of {rounded(OPEN * found.wide)} mm, or leave the gap out"
    return [Diagnostic("W254", f"{told(found)}: cubes of {size:.3g} mm are too large to keep it open", hint=hint,
                       severity="warning")]  # fmt: skip


def beside_gaps(edges: Floats, spans: Spanned) -> Floats:
    """Of edges (n, 2, 3) those that lie in no gap: one that is closed in places has hinges between these."""
    if not len(edges) or not len(spans.width):
        return edges
    far, _ = cKDTree(spans.middle).query(edges.mean(axis=1))
    kept: Floats = edges[far > float(spans.length.max())]
    return kept


def _gap(middle: Floats, width: Floats) -> Gap:
    """The gap of edges that span it, from their places (n, 3) and widths (n,). Of places evenly over a length the
    standard deviation is the twelfth part's root of it."""
    centre = middle.mean(axis=0)
    spread = np.linalg.svd(middle - centre, compute_uv=False) * (12 / len(middle)) ** 0.5
    narrow, wide = np.quantile(width, [0.1, 0.9])
    at = middle[np.linalg.norm(middle - centre, axis=1).argmin()]
    return Gap(float(wide), (float(spread[0]), float(spread[1])), at, bool(narrow < _TAPERS * wide))


def spanned(part: Solid, mesh: TetMesh) -> Spanned:
    """The void of a part that edges of its mesh span. Of very many tetrahedra some are asked, and then all those beside
    edges that span void."""
    tets = mesh.tets[mesh.phase == 0]
    every = 1 + len(tets) // _MOST
    with np.errstate(all="ignore"):
        found = _of_tets(part, mesh, tets[::every])
        if every == 1 or not len(found.width):
            return found
        middle = mesh.vertices[tets].mean(axis=1)
        asked = np.zeros(len(tets), np.bool_)
        while True:
            beside, _ = cKDTree(found.middle).query(middle, distance_upper_bound=_BESIDE * float(found.length.max()))
            near = np.isfinite(beside)
            if not (near & ~asked).any():
                return found
            asked |= near
            found = _of_tets(part, mesh, tets[asked])


def _of_tets(part: Solid, mesh: TetMesh, tets: Indices) -> Spanned:
    """The void that edges of some tetrahedra span."""
    edges, steepest = _edges(part, mesh, tets)
    start, way = mesh.vertices[edges[:, 0]], np.diff(mesh.vertices[edges], axis=1)[:, 0]
    length = np.linalg.norm(way, axis=1)
    inside, most = _greatest(part, start, way, steepest * length)
    some = np.flatnonzero(most > 0)
    start, way, length, inside = start[some], way[some], length[some], inside[some]
    ends = np.stack([_side(part, start, way, inside, end) for end in (0.0, 1.0)], axis=1)
    ends = start[:, None] + ends[..., None] * way[:, None]
    slopes = np.stack([part.slope(ends[:, k])[1] for k in (0, 1)], axis=1)
    slopes /= np.linalg.norm(slopes, axis=2, keepdims=True)
    across = slopes[:, 0] - slopes[:, 1]
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    width = np.abs(((ends[:, 1] - ends[:, 0]) * across).sum(axis=1))
    facing = (slopes[:, 0] * slopes[:, 1]).sum(axis=1) < _FACING
    return Spanned(ends[facing].mean(axis=1), width[facing], length[facing])


def _edges(part: Solid, mesh: TetMesh, tets: Indices) -> tuple[Ints, float]:
    """The edges (n, 2) of some tetrahedra, each once, between whose ends the field may be 0; and by how much it changes
    along an edge at most, per mm."""
    pairs = np.sort(
        np.concatenate([tets[:, [a, b]] for a in range(4) for b in range(a + 1, 4)]).astype(np.int64), axis=1
    )
    if not len(pairs):
        return pairs, 0.0
    pairs = np.stack(np.divmod(np.unique(pairs[:, 0] * len(mesh.vertices) + pairs[:, 1]), len(mesh.vertices)), axis=1)
    used, place = np.unique(pairs, return_inverse=True)
    value = np.abs(part.value(mesh.vertices[used]))[place.reshape(pairs.shape)]
    length = np.linalg.norm(mesh.vertices[pairs[:, 0]] - mesh.vertices[pairs[:, 1]], axis=1)
    steepest = _STEEP * float(np.quantile(np.abs(value[:, 0] - value[:, 1]) / length, _NEARLY))
    return pairs[value.sum(axis=1) <= steepest * length], steepest


def _greatest(part: Solid, start: Floats, way: Floats, change: Floats) -> tuple[Floats, Floats]:
    """Where along edges (n, 3) the field is greatest (0 to 1), and its value there; `change` (n,) is what it may change
    by from end to end. Where it may be above 0 between two places it is looked for more closely."""
    first = (np.arange(_PLACES) + 0.5) / _PLACES
    values = part.value((start[:, None] + first[:, None] * way[:, None]).reshape(-1, 3)).reshape(-1, _PLACES)
    at, most = first[values.argmax(axis=1)], values.max(axis=1)
    near = np.flatnonzero((most <= 0) & (most > -change / _PLACES))
    step = 0.5 / _PLACES
    for _ in range(_CLOSER):
        for aside in (-step, step):
            tried = np.clip(at[near] + aside, 0, 1)
            value = part.value(start[near] + tried[:, None] * way[near])
            up = value > most[near]
            at[near[up]], most[near[up]] = tried[up], value[up]
        step /= 2
    return at, most


def _side(part: Solid, start: Floats, way: Floats, inside: Floats, end: float) -> Floats:
    """Where the void that holds a place `inside` each edge (0 to 1) ends on the way to one `end` of it."""
    low, high = inside.copy(), np.full(len(inside), end)
    left = np.ones(len(inside), bool)
    for share in np.linspace(0, 1, 2 * _PLACES + 1)[1:]:
        tried = inside + share * (end - inside)
        solid = part.value(start + tried[:, None] * way) <= 0
        high[left & solid] = tried[left & solid]
        left &= ~solid
        low[left] = tried[left]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        void = part.value(start + middle[:, None] * way) > 0
        low, high = np.where(void, middle, low), np.where(void, high, middle)
    return high
