"""Tight framing: a camera that just takes in the surface that is seen.

Bounds are safe, and so may be much larger than the part. What fills a picture is found in a coarse one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.render.camera import MARGIN, Camera, Points

#: Pixels along the longer side of the coarse picture, and how often it is drawn again of a part that was small in it.
COARSE, ROUNDS = 192, 3
SMALL = 0.67


def coarse(size: tuple[int, int]) -> tuple[int, int]:
    """The size of the coarse picture for one of a size."""
    share = min(1.0, COARSE / max(size))
    return max(1, round(size[0] * share)), max(1, round(size[1] * share))


def met(camera: Camera, size: tuple[int, int], distances: NDArray[np.float32]) -> Points:
    """The places (n, 3) that rays meet, from their distances (height, width)."""
    origin, way = camera.rays(size)
    hit = np.isfinite(distances)
    return np.asarray(origin[hit] + way[hit] * distances[hit][:, None].astype(np.float64))


def closer(camera: Camera, size: tuple[int, int], places: Points, pixel: float) -> Camera:
    """The camera that looks the same way and just takes in places, each `pixel` mm wide; never from farther away."""
    middle = places.mean(axis=0)
    across, up, toward = ((places - middle) @ axis for axis in (camera.right, camera.up, -camera.forward))
    wide = 1 + 2 * MARGIN
    # as if the picture were square
    sides = [(across, size[1] / size[0] * wide), (up, wide)]
    if not camera.perspective:
        ends = [(v.min() - pixel, v.max() + pixel, share) for v, share in sides]
        zoom = max((b - a) / 2 * share for a, b, share in ends)
        (x0, x1, _), (y0, y1, _) = ends
        back = float((camera.eye - middle) @ -camera.forward)
        eye = middle + (x0 + x1) / 2 * camera.right + (y0 + y1) / 2 * camera.up - back * camera.forward
        return camera if zoom >= camera.zoom else Camera(eye, camera.right, camera.up, camera.forward,
                                                         float(zoom), camera.projection)  # fmt: skip
    # a place (a, c), c toward the viewer, is seen from (ea, ec) where |a - ea| <= slope * (ec - c)
    found = []
    for v, share in sides:
        slope = camera.zoom / share
        # the highest of v + slope * c lies below ea + slope * ec, the lowest of v - slope * c above ea - slope * ec
        high, low = (v + pixel + slope * toward).max(), (v - pixel - slope * toward).min()
        found.append(((high + low) / 2, (high - low) / (2 * slope)))
    (ea, da), (eb, db) = found
    distance = max(da, db)
    eye = middle + ea * camera.right + eb * camera.up - distance * camera.forward
    if (eye - camera.eye) @ camera.forward <= 0:
        return camera
    return Camera(eye, camera.right, camera.up, camera.forward, camera.zoom, camera.projection)


def zoomed(camera: Camera, zoom: float) -> Camera:
    """The camera with the middle of its picture `zoom` times as large."""
    return Camera(camera.eye, camera.right, camera.up, camera.forward, camera.zoom / zoom, camera.projection)


def touches_rim(distances: NDArray[np.float32]) -> bool:
    """Whether the part reaches the rim of a picture."""
    return any(bool(np.isfinite(rim).any()) for rim in (distances[0], distances[-1], distances[:, 0], distances[:, -1]))
