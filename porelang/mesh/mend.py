"""A mesh held to its promises: vertices that lie on one another moved apart, triangles without area opened.

Where a field jumps, or a rim runs through a node, two vertices may land in one place. Each is moved towards the
middle of its neighbours by a part of a voxel that is far below the error of the mesh there, and far above what files
round off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import PoreError, fail
from porelang.mesh.grid import place
from porelang.mesh.surface import Surface, single

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
ROUNDS = 6
ASIDE = 1e-3  # voxels, doubled from round to round


def kept_sound(surface: Surface, voxel: float, refined: bool) -> Surface:
    """The surface as docs/mesh.md promises it; where it is not, with its vertices moved by less than a tenth of a
    voxel.

    How triangles are joined is asked only of what was `refined`: marching cubes joins by a table that is right.
    Errors: E119 where a promise cannot be kept.
    """
    if not surface.check_vertices() and (not refined or not surface.check_vertices(single(1.0))):
        defects = surface.check() if refined else []
        if defects:
            raise _broken(surface, defects)
        return surface
    for rounded in (True, False):  # as files of 32-bit numbers store it, or at least as it is
        mended = _mended(surface, voxel, rounded)
        if mended is not None and not (defects := mended.check()):
            return mended
    if mended is None:
        defects = surface.check_vertices()
    raise _broken(surface, defects)


def _mended(surface: Surface, voxel: float, rounded: bool) -> Surface | None:
    """The surface with what is wrong with its places mended, also when rounded to float32 if `rounded`; None if it
    cannot be."""
    random = np.random.default_rng(0)
    vertices = np.array(surface.vertices)
    for turn in range(ROUNDS):
        now = Surface(vertices, surface.faces)
        bad = _bad(now.rounded() if rounded else now)
        if not len(bad):
            return now
        beside = np.isin(surface.faces, bad).any(axis=1)
        for v in bad:
            fan = surface.faces[beside][(surface.faces[beside] == v).any(axis=1)]
            others = np.setdiff1d(fan, [v])
            weight = random.random(len(others)) + 0.5
            aim = weight @ vertices[others] / weight.sum() - vertices[v]
            far = float(np.linalg.norm(aim))
            if far > 0:
                vertices[v] += aim / far * min(far / 4, ASIDE * voxel * 2.0**turn)
    return None


def _bad(surface: Surface) -> Ints:
    """The vertices to be moved: of those in one place all but the first, of a triangle without area the one across from
    its longest side."""
    _, first, which, count = np.unique(
        surface.vertices + 0.0, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    doubled = np.flatnonzero(count[which.ravel()] > 1)
    doubled = np.setdiff1d(doubled, first)
    flat = surface.faces[~surface.normals().any(axis=1)]
    corners = surface.vertices[flat]
    sides = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)  # across from each corner
    across = flat[np.arange(len(flat)), sides.argmax(axis=1)] if len(flat) else np.zeros(0, np.int64)
    return np.unique(np.concatenate([doubled, across])).astype(np.int64)


def _broken(surface: Surface, defects: list[str]) -> PoreError:
    """What the mesh would be, and where."""
    bad = _bad(surface)
    where = f", at {place(surface.vertices[bad[0]])}" if len(bad) else ""
    return fail(
        "E119",
        f"the mesh would not be sound{where}: {'; '.join(defects)}",
        hint="the field jumps or is flat there; use another --voxel, or leave out --sharp and --smooth",
    )
