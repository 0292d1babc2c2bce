"""Which piece of solid a closed void lies in.

From the point of a void that lies farthest along x one goes on along x: the first surface that is met bounds the same
material. It is the outside of the solid, or another void in it, that reaches farther, from which one goes on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.mesh.surface import Surface

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]
AT_ONCE = 2**15  # triangles looked at together
#: Of a triangle's area: rays of a grid run through corners and edges, and those are met too.
ON = 1e-9


def material(surface: Surface) -> Floats:
    """The volume of each of a surface's pieces, mm3: of a solid without the voids in it, of a void negative."""
    volume = surface.pieces.volume.copy()
    voids = np.flatnonzero(volume < 0)
    if len(voids) and len(voids) < len(volume):
        around = enclosing(surface, voids)
        np.add.at(volume, around[around >= 0], volume[voids[around >= 0]])
    return volume


def enclosing(surface: Surface, voids: Ints) -> Ints:
    """For each of the pieces `voids` (n,) of a surface the piece of solid that it lies in; -1 where none is met."""
    pieces = surface.pieces
    solids = np.flatnonzero(pieces.volume >= 0)
    if len(solids) == 1:
        return np.full(len(voids), solids[0])
    met = _met(surface, voids)
    owner = {int(i): int(i) for i in solids}
    for k in np.argsort(-pieces.high[voids, 0], kind="stable"):  # what one goes on from reaches farther
        owner[int(voids[k])] = owner.get(int(met[k]), -1)
    return np.array([owner[int(v)] for v in voids])


def _met(surface: Surface, voids: Ints) -> Ints:
    """The piece that a ray along x meets first from the farthest point of each void; -1: none."""
    start = _farthest(surface, voids)
    order = np.argsort(start[:, 1])
    start, mine = start[order], voids[order]
    nearest, met = np.full(len(voids), np.inf), np.full(len(voids), -1)
    for i in range(0, len(surface.faces), AT_ONCE):
        faces = surface.faces[i : i + AT_ONCE]
        corners = surface.vertices[faces]
        first = np.searchsorted(start[:, 1], corners[:, :, 1].min(axis=1), "left")
        count = np.searchsorted(start[:, 1], corners[:, :, 1].max(axis=1), "right") - first
        which = np.repeat(np.arange(len(faces)), count)
        ray = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
        label = surface.pieces.label[faces[which, 0]]
        z, x = corners[which, :, 2], corners[which, :, 0].max(axis=1)
        near = (z.min(axis=1) <= start[ray, 2]) & (start[ray, 2] <= z.max(axis=1)) & (x > start[ray, 0])
        near &= label != mine[ray]
        which, ray, label = which[near], ray[near], label[near]
        x = _crossing(corners[which], start[ray])
        for at in np.flatnonzero(np.isfinite(x)):
            if x[at] < nearest[ray[at]]:
                nearest[ray[at]], met[ray[at]] = x[at], label[at]
    out = np.empty_like(met)
    out[order] = met
    return out


def _farthest(surface: Surface, pieces: Ints) -> Floats:
    """The vertex of each of some pieces that lies farthest along x, (n, 3)."""
    label, x = surface.pieces.label, surface.vertices[:, 0]
    some = np.flatnonzero((label >= 0) & np.isin(label, pieces))
    some = some[x[some] >= surface.pieces.high[label[some], 0]]
    at = np.empty(len(surface.pieces.volume), np.intp)
    at[label[some]] = some
    return surface.vertices[at[pieces]]


def _crossing(corners: Floats, start: Floats) -> Floats:
    """Where rays along x from places (n, 3) meet triangles (n, 3, 3), their edges included; not a number: nowhere."""
    y, z = (corners[:, :, i] - start[:, i, None] for i in (1, 2))
    weight = np.stack([y[:, j] * z[:, k] - y[:, k] * z[:, j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)
    total = weight.sum(axis=1)
    with np.errstate(all="ignore"):
        weight = weight / total[:, None]
        x = (weight * corners[:, :, 0]).sum(axis=1)
        return np.where((np.abs(total) > 0) & (weight >= -ON).all(axis=1) & (x > start[:, 0]), x, np.nan)
