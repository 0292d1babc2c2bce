"""Pictures of a scene in a window: coarse while something moves, full when it is still, in strips so that hands are
answered meanwhile."""

from __future__ import annotations

import time

import moderngl

from porelang.preview.drawing import Drawing, Section
from porelang.render.camera import Camera

#: Seconds that a frame may take while something moves, and a strip of the full picture; without a change until that is
#: begun.
FRAME, STRIP, STILL = 0.04, 0.03, 0.15
COARSEST = 8.0


class Frames:
    """The pictures that `drawing` makes; `shown` is the last that is whole."""

    def __init__(self, context: moderngl.Context, drawing: Drawing) -> None:
        self.context, self.drawing = context, drawing
        self.shown: moderngl.Framebuffer | None = None
        self.full: moderngl.Framebuffer | None = None
        self.coarse, self.per_pixel = 4.0, 0.0
        self.moved, self.left = True, -1  # rows of the full picture that are not drawn yet
        self.since = time.monotonic()
        self.pictures = 0  # full ones so far

    @property
    def still(self) -> bool:
        """Whether there is nothing to be drawn."""
        return not self.moved and self.left == 0

    def draw(self, camera: Camera, section: Section, size: tuple[int, int]) -> None:
        """Some of what there is to do."""
        if self.moved:
            self._quick(camera, section, size)
        elif self.left != 0 and time.monotonic() - self.since > STILL:
            self._strip(camera, section, size)

    def _target(
        self, size: tuple[int, int], coarse: float, before: moderngl.Framebuffer | None
    ) -> moderngl.Framebuffer:
        size = max(1, round(size[0] / coarse)), max(1, round(size[1] / coarse))
        if before is not None and before.size == size:
            return before
        depth = self.context.depth_renderbuffer(size)
        made: moderngl.Framebuffer = self.context.framebuffer([self.context.texture(size, 4)], depth)
        return made

    def _quick(self, camera: Camera, section: Section, size: tuple[int, int]) -> None:
        begun = time.monotonic()
        self.shown = self._target(size, self.coarse, self.shown if self.shown is not self.full else None)
        self.drawing.draw(self.shown, camera, section, 0, self.shown.height)
        self.context.finish()
        taken = time.monotonic() - begun
        self.per_pixel = taken / (self.shown.width * self.shown.height)
        if taken > FRAME:
            self.coarse = min(COARSEST, self.coarse * (taken / FRAME) ** 0.5)
        elif taken < FRAME / 3:
            self.coarse = max(1.0, self.coarse / 1.3)
        self.moved, self.left, self.since = False, -1, time.monotonic()

    def _strip(self, camera: Camera, section: Section, size: tuple[int, int]) -> None:
        """Some more rows of the full picture, from the top."""
        if self.left < 0:
            self.full = self._target(size, 1.0, self.full if self.full is not self.shown else None)
            self.left = self.full.height
        assert self.full is not None
        rows = max(1, int(STRIP / max(self.per_pixel, 1e-12) / self.full.width))
        first = max(0, self.left - rows)
        self.drawing.draw(self.full, camera, section, first, self.left)
        self.context.finish()
        self.left = first
        if not first:
            self.shown = self.full
            self.pictures += 1
