"""Light on triangles: that of `shaders/march.frag` without its shadows; hollows are told from depths in the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.parallel import parallel_for, workers
from porelang.render.camera import Camera

Floats = NDArray[np.float64]
#: Where the lamp and the two lights stand, in the viewer's axes: right, up, forward. As in the shader.
LAMP = np.array((-0.451, 0.621, -0.641))
FILL = np.array((0.80, 0.05, -0.55)) / np.linalg.norm((0.80, 0.05, -0.55))
RIM = np.array((0.10, 0.90, 0.40)) / np.linalg.norm((0.10, 0.90, 0.40))
OVER = np.array((-0.2, 0.9, -0.4)) / np.linalg.norm((-0.2, 0.9, -0.4))
MATERIAL, SECTION = np.array((0.945, 0.915, 0.855)), np.array((0.800, 0.440, 0.330))
COOL = np.array((0.80, 0.86, 1.0))
#: Directions in the picture in which hollows are looked for, and places along each.
DIRECTIONS, RINGS = 6, 6
#: What rises over a place by less than this sine hides nothing of its sky: the facets of a round surface do not.
LEVEL = 0.08


def vertex_normals(vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """Outward unit normals (n, 3): the mean of the triangles at a vertex, by their areas."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    out = np.stack([np.bincount(faces.ravel(), np.repeat(cross[:, i], 3), len(vertices)) for i in range(3)], axis=-1)
    return np.asarray(out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300))


def open_sky(distance: NDArray[np.float32], normals: NDArray[np.float32], camera: Camera, reach: float) -> Floats:
    """How much of the sky above each sample of a picture (height, width) is not hidden, 0 to 1, by what is seen within
    `reach` mm; `normals` (height, width, 3) in the viewer's axes."""
    height, width = distance.shape
    out = np.ones((height, width))
    threads = workers()
    edges = np.linspace(0, height, threads + 1).astype(int)
    per = height / (2 * camera.zoom)  # samples a mm, at distance 1 in perspective
    parallel_for(
        lambda k: _hidden(distance, normals, per, camera.perspective, reach, int(edges[k]), int(edges[k + 1]), out),
        range(threads), threads,
    )  # fmt: skip
    return out


@compiled
def _place(
    i: int, j: int, far: float, half_high: float, half_wide: float, per: float, perspective: bool
) -> tuple[float, float, float]:
    """Where a sample lies, in the viewer's axes."""
    x, y = (j + 0.5 - half_wide) / per, (half_high - i - 0.5) / per
    if not perspective:
        return x, y, far
    z = far / np.sqrt(1.0 + x * x + y * y)
    return x * z, y * z, z


@compiled
def _hidden(
    distance: NDArray[np.float32], normals: NDArray[np.float32], per: float, perspective: bool, reach: float,
    top: int, bottom: int, out: Floats,
) -> None:  # fmt: skip
    """The highest that anything rises over each place in some directions of the picture (horizons: Bavoil, Sainz and
    Dimitrov 2008), in the mean, the less the farther it is."""
    height, width = distance.shape
    half_high, half_wide = height / 2, width / 2
    for i in range(top, bottom):
        for j in range(width):
            far = distance[i, j]
            if not np.isfinite(far):
                continue
            x, y, z = _place(i, j, far, half_high, half_wide, per, perspective)
            nx, ny, nz = normals[i, j]
            wide = reach * per / (z if perspective else 1.0)
            turn = 0.61803398875 * ((i * 7 + j * 3) % 8)  # neighbours look in others
            hidden = 0.0
            for k in range(DIRECTIONS):
                angle = 2 * np.pi * (k + turn) / DIRECTIONS
                most = 0.0
                for r in range(RINGS):
                    step = wide * ((r + 1) / RINGS) ** 2
                    p, q = int(np.floor(i + 0.5 - np.sin(angle) * step)), int(np.floor(j + 0.5 + np.cos(angle) * step))
                    if p < 0 or q < 0 or p >= height or q >= width:
                        break
                    if (p == i and q == j) or not np.isfinite(distance[p, q]):
                        continue
                    a, b, c = _place(p, q, distance[p, q], half_high, half_wide, per, perspective)
                    dx, dy, dz = a - x, b - y, c - z
                    long = np.sqrt(dx * dx + dy * dy + dz * dz)
                    if long >= reach or long == 0.0:
                        continue
                    rise = (dx * nx + dy * ny + dz * nz) / long - LEVEL
                    most = max(most, rise * (1.0 - (long / reach) ** 2))
                hidden += most
            out[i, j] = 1.0 - hidden / DIRECTIONS


def lit(normals: Floats, sky: Floats, section: NDArray[np.bool_], bare: bool) -> Floats:
    """Red, green and blue (k, 3) in 0..1 of places with normals (k, 3) in the viewer's axes; `bare`: the light alone,
    as it falls on white. On the faces of cuts (`section`) it is flat."""
    key = np.maximum(normals @ LAMP, 0.0)
    fill, rim = np.maximum(normals @ FILL, 0.0), np.maximum(normals @ RIM, 0.0)
    light = 0.08 + 0.38 * sky + 0.46 * key * (0.35 + 0.65 * sky) + (0.12 * fill + 0.08 * rim) * (0.35 + 0.65 * sky)
    light *= 0.80 + 0.20 * _step(np.clip(-normals[:, 2], 0, 1), 0.35)
    cool = _step(light, 0.75)[:, None]
    shade = COOL * (1 - cool) + cool
    out = (1.0 if bare else MATERIAL) * shade * (light * 1.10)[:, None] ** 0.80
    flat = (0.90 + 0.20 * np.maximum(normals @ OVER, 0.0))[:, None] * (np.ones(3) if bare else SECTION)
    return np.asarray(np.clip(np.where(section[:, None], flat, out), 0, 1))


def _step(value: Floats, end: float) -> Floats:
    """GLSL's smoothstep from 0 to `end`."""
    t = np.clip(value / end, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
