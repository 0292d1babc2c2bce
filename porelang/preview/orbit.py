"""Where a window looks from: a camera that is turned, moved and zoomed by hand, as web/camera.js is for the page."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.render.camera import FIELD_OF_VIEW, VIEWS, Camera, look

Floats = NDArray[np.float64]
HALF = math.tan(FIELD_OF_VIEW / 2)
#: What a picture may take in, in mm.
LEAST, MOST = 1e-4, 1e7


@dataclass(slots=True)
class Orbit:
    """Azimuth and elevation in degrees, the place that is looked at and what the picture takes in there (mm)."""

    azimuth: float = VIEWS["iso"][0]
    elevation: float = VIEWS["iso"][1]
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    height: float = 100.0
    perspective: bool = True

    def axes(self) -> tuple[Floats, Floats, Floats]:
        """To the viewer, right, and up."""
        turn, lift = math.radians(self.azimuth), math.radians(self.elevation)
        out = np.array([math.cos(turn) * math.cos(lift), math.sin(turn) * math.cos(lift), math.sin(lift)])
        right = np.array([-math.sin(turn), math.cos(turn), 0.0])
        return out, right, np.cross(out, right)

    def turn(self, azimuth: float, elevation: float) -> None:
        self.azimuth = (self.azimuth + azimuth) % 360
        self.elevation = min(90.0, max(-90.0, self.elevation + elevation))

    def move(self, dx: float, dy: float, pixels: int) -> None:
        """By pixels of a picture that is so many high."""
        _, right, up = self.axes()
        x, y, z = np.array(self.target) + (dy * up - dx * right) * self.height / pixels
        self.target = (float(x), float(y), float(z))

    def closer(self, factor: float) -> None:
        self.height = min(MOST, max(LEAST, self.height / factor))

    def fit(self, box: Box, size: tuple[int, int]) -> None:
        """Take in all of a box, in a picture of this size."""
        found = look(box, (self.azimuth, self.elevation), size, "perspective" if self.perspective else "orthographic")
        x, y, z = np.add(box.lo, box.hi) / 2
        self.target = (float(x), float(y), float(z))
        far = float(np.linalg.norm(found.eye - np.array(self.target)))
        self.height = 2 * found.zoom * (far if self.perspective else 1.0)

    def camera(self, diagonal: float) -> Camera:
        """Of a scene whose box has this diagonal (mm)."""
        out, right, up = self.axes()
        far = self.height / 2 / HALF if self.perspective else 2 * diagonal
        zoom = HALF if self.perspective else self.height / 2
        return Camera(np.array(self.target) + far * out, right, up, -out, zoom,
                      "perspective" if self.perspective else "orthographic")  # fmt: skip
