"""Where a picture is taken from: a place, three axes, and how a pixel becomes a ray."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box

Points = NDArray[np.float64]
Projection = Literal["perspective", "orthographic"]
#: Azimuth and elevation in degrees of the viewer, seen from the part; at azimuth 0 one stands on the x axis.
VIEWS: dict[str, tuple[float, float]] = {
    "iso": (-45.0, math.degrees(math.atan(math.sqrt(0.5)))),
    "front": (-90.0, 0.0),
    "back": (90.0, 0.0),
    "left": (180.0, 0.0),
    "right": (0.0, 0.0),
    "top": (-90.0, 90.0),
    "bottom": (-90.0, -90.0),
}
#: The angle that the height of a picture in perspective takes in, in radians: that of a long lens.
FIELD_OF_VIEW = math.radians(22.0)
MARGIN = 0.03


@dataclass(frozen=True, slots=True)
class Camera:
    """A viewer at `eye` (mm). `zoom` is half the height of the picture: in mm for parallel rays, else at distance 1."""

    eye: Points
    right: Points
    up: Points
    forward: Points
    zoom: float
    projection: Projection

    @property
    def perspective(self) -> bool:
        return self.projection == "perspective"

    def rays(self, size: tuple[int, int], rows: slice = slice(None)) -> tuple[Points, Points]:
        """Origins and unit directions (rows, width, 3) through the pixels' centres, top row first."""
        width, height = size
        across = (2 * np.arange(width) + 1 - width) / height * self.zoom
        down = (height - 2 * np.arange(height)[rows] - 1) / height * self.zoom
        aside = across[None, :, None] * self.right + down[:, None, None] * self.up
        if not self.perspective:
            return self.eye + aside, np.broadcast_to(self.forward, aside.shape)
        way = self.forward + aside
        return np.broadcast_to(self.eye, way.shape), way / np.linalg.norm(way, axis=-1, keepdims=True)

    def pixel(self, size: tuple[int, int], box: Box) -> float:
        """The size of a pixel in mm at the middle of a box."""
        depth = float((np.add(box.lo, box.hi) / 2 - self.eye) @ self.forward) if self.perspective else 1.0
        return 2 * self.zoom * max(depth, 1e-9) / size[1]


def look(
    box: Box,
    view: tuple[float, float],
    size: tuple[int, int],
    projection: Projection = "perspective",
    zoom: float = 1.0,
) -> Camera:
    """The camera that sees all of a box from azimuth, elevation (degrees); `zoom` 2 doubles what is in the middle."""
    turn, lift = (math.radians(v) for v in view)
    out = np.array([math.cos(turn) * math.cos(lift), math.sin(turn) * math.cos(lift), math.sin(lift)])
    right = np.array([-math.sin(turn), math.cos(turn), 0.0])
    up = np.cross(out, right)
    middle = np.add(box.lo, box.hi) / 2
    corners = np.array(list(product(*zip(box.lo, box.hi, strict=True)))) - middle
    # how far the corners reach, as if the picture were square
    spread = np.maximum(np.abs(corners @ right) * size[1] / size[0], np.abs(corners @ up)) * (1 + 2 * MARGIN)
    toward = corners @ out
    if projection == "orthographic":
        return Camera(middle + out * 2 * float(np.linalg.norm(corners[0])), right, up, -out,
                      float(spread.max()) / zoom, projection)  # fmt: skip
    half = math.tan(FIELD_OF_VIEW / 2)
    distance = float((spread / half + toward).max())
    return Camera(middle + out * distance, right, up, -out, half / zoom, projection)
