"""Triangles as a camera sees them: for each sample of a picture which triangle is in front, how far, and where on it.

A depth buffer on the processor: what is drawn so has about as many triangles as samples, which takes a second, and
needs no device.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.parallel import parallel_for, workers
from porelang.render.camera import Camera

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
#: Rows of a picture that are worked on together.
ROWS = 64


@dataclass(frozen=True, slots=True)
class Seen:
    """What the samples of a picture (height, width) show of triangles: which is in front (-1: none), and how far from
    the eye it is there along the ray, in mm (infinite where there is none). `projected` (n, 3) are the vertices in
    samples, right and down, and by what they are the nearer; `faces` (m, 3) the triangles."""

    which: Ints
    distance: NDArray[np.float32]
    projected: Floats
    faces: Ints
    perspective: bool

    def bands(self) -> Iterator[tuple[slice, NDArray[np.bool_], Ints, Floats]]:
        """Rows of the picture by rows: which samples show something, and for these the triangle (k,) and the weights
        (k, 3) of its corners there."""
        height = self.which.shape[0]
        for top in range(0, height, ROWS):
            rows = slice(top, min(top + ROWS, height))
            hit = self.which[rows] >= 0
            if hit.any():
                y, x = np.nonzero(hit)
                one = self.which[rows][hit]
                yield rows, hit, one, self._weights(one, x.astype(np.float64) + 0.5, y.astype(np.float64) + (top + 0.5))

    def _weights(self, one: Ints, x: Floats, y: Floats) -> Floats:
        a, b, c = (self.projected[self.faces[one, k]] for k in range(3))
        share = np.stack([_twice(b, c, x, y), _twice(c, a, x, y), _twice(a, b, x, y)], axis=-1)
        if self.perspective:  # what is linear in the picture over the depth is linear on the triangle
            share *= np.stack([a[:, 2], b[:, 2], c[:, 2]], axis=-1)
        return np.asarray(share / share.sum(axis=1, keepdims=True))


def _twice(p: Floats, q: Floats, x: Floats, y: Floats) -> Floats:
    """Twice the area of the triangle of p, q and (x, y)."""
    return np.asarray((q[:, 0] - p[:, 0]) * (y - p[:, 1]) - (q[:, 1] - p[:, 1]) * (x - p[:, 0]))


def seen(vertices: Floats, faces: Ints, camera: Camera, size: tuple[int, int]) -> Seen:
    """What a camera sees of triangles (m, 3) between vertices (n, 3) mm, in a picture of `size` samples."""
    width, height = size
    projected = project(vertices, camera, size)
    which = np.full((height, width), -1, np.int32)
    near = np.full((height, width), -np.inf)
    threads = workers()
    edges = np.linspace(0, height, threads + 1).astype(int)
    parallel_for(
        lambda k: _cover(projected, faces, int(edges[k]), int(edges[k + 1]), which, near), range(threads), threads
    )
    distance = np.full((height, width), np.inf, np.float32)
    for top in range(0, height, ROWS):
        rows = slice(top, min(top + ROWS, height))
        hit = which[rows] >= 0
        if not camera.perspective:
            distance[rows][hit] = -near[rows][hit]
            continue
        _, way = camera.rays(size, rows)
        distance[rows][hit] = 1 / (near[rows][hit] * (way[hit] @ camera.forward))
    return Seen(which, distance, projected, faces, camera.perspective)


def project(vertices: Floats, camera: Camera, size: tuple[int, int]) -> Floats:
    """Places (n, 3) mm in a picture: samples to the right and down from its upper left corner, and what grows as they
    come nearer and is linear over a flat face: the inverse of the depth, or of parallel rays its negative."""
    width, height = size
    away = vertices - camera.eye
    depth = away @ camera.forward
    scale = height / (2 * camera.zoom) / (depth if camera.perspective else 1.0)
    near = 1 / depth if camera.perspective else -depth
    return np.stack([width / 2 + away @ camera.right * scale, height / 2 - away @ camera.up * scale, near], axis=-1)


@compiled
def _cover(projected: Floats, faces: Ints, top: int, bottom: int, which: Ints, near: Floats) -> None:
    """The nearest triangle at the middle of each sample in the rows top .. bottom. Edges belong to both sides."""
    width = which.shape[1]
    for f in range(len(faces)):
        ax, ay, az = projected[faces[f, 0]]
        bx, by, bz = projected[faces[f, 1]]
        cx, cy, cz = projected[faces[f, 2]]
        first = max(top, int(np.ceil(min(ay, by, cy) - 0.5)))
        last = min(bottom - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        if first > last:
            continue
        left = max(0, int(np.ceil(min(ax, bx, cx) - 0.5)))
        right = min(width - 1, int(np.floor(max(ax, bx, cx) - 0.5)))
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if left > right or area == 0.0:
            continue
        for i in range(first, last + 1):
            y = i + 0.5
            for j in range(left, right + 1):
                x = j + 0.5
                u = ((cx - bx) * (y - by) - (cy - by) * (x - bx)) / area
                v = ((ax - cx) * (y - cy) - (ay - cy) * (x - cx)) / area
                w = 1.0 - u - v
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                z = u * az + v * bz + w * cz
                if z > near[i, j]:
                    near[i, j] = z
                    which[i, j] = f
