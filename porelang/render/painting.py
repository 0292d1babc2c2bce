"""The colours of what light falls on: those of a field on a surface, or of the output that a place belongs to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.field import Field
from porelang.render.camera import Camera
from porelang.render.frame import met
from porelang.render.march import Distances
from porelang.render.marks import Colour
from porelang.render.planes import ROWS
from porelang.render.scale import Colouring, scale_colours

#: The colours of several outputs, after Okabe and Ito (2008), so that all eyes tell them apart: the first is that of
#: the material, the next two are as far from each other as warm from cold.
BODIES: tuple[Colour, ...] = (
    (236, 230, 216), (226, 110, 50), (86, 160, 220), (20, 100, 60), (240, 200, 60), (204, 121, 167), (60, 60, 66),
)  # fmt: skip
#: How much of a colour is seen in the darkest shade: colours are to be read, not only seen.
AMBIENT = 0.35
#: Places on the surface from which the range of a field's colours is taken.
MOST_SURVEYED = 100_000


#: Colours (n, 3) in 0..1 of places (n, 3).
Paint = Callable[[NDArray[np.float64]], NDArray[np.float32]]


#: A field as a function of places (n, 3) in mm.
Evaluate = Callable[[NDArray[np.float64]], NDArray[Any]]


def ramp_of(field: Evaluate, scale: Colouring) -> Paint:
    return lambda places: scale_colours(np.asarray(field(places), np.float64), scale)


def patches_of(outputs: Sequence[Field], colours: Sequence[Colour], within: float, camera: Camera) -> Paint:
    """The colour of the output that a place belongs to: the one that it lies deepest in, just behind the surface."""
    table = np.array(colours, np.float32) / 255

    def paint(places: NDArray[np.float64]) -> NDArray[np.float32]:
        ahead = places - camera.eye if camera.perspective else np.broadcast_to(camera.forward, places.shape)
        behind = places + within * ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
        values = np.stack([np.asarray(f(behind), np.float64) for f in outputs])
        return np.asarray(table[np.nanargmin(np.where(np.isnan(values), np.inf, values), axis=0)])

    return paint


def surveyed(camera: Camera, size: tuple[int, int], distance: Distances) -> NDArray[np.float64]:
    """Some places (n, 3) of the surface that is seen, evenly."""
    hits = np.flatnonzero(np.isfinite(distance))
    if not len(hits):
        return np.zeros((0, 3))
    few = np.full(distance.size, np.inf, np.float32)
    chosen = hits[:: max(1, len(hits) // MOST_SURVEYED)]
    few[chosen] = distance.ravel()[chosen]
    return met(camera, size, few.reshape(distance.shape))


def colour(light: NDArray[np.uint8], camera: Camera, distance: Distances, size: tuple[int, int], paint: Paint) -> None:
    """Give what the light falls on its colours, in place."""
    for top in range(0, size[1], ROWS):
        rows = slice(top, min(top + ROWS, size[1]))
        hit = np.isfinite(distance[rows])
        if not hit.any():
            continue
        origin, way = camera.rays(size, rows)
        places = origin[hit] + way[hit] * distance[rows][hit][:, None].astype(np.float64)
        lit = light[rows]
        shade = (AMBIENT * 255 + (1 - AMBIENT) * lit[hit, :3]) * paint(places)
        lit[hit, :3] = np.rint(shade).astype(np.uint8)
