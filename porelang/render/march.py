"""The shader at work: uniforms, tiles that no driver takes for a hang, and the pictures that come back."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.backends.glsl import Shader, shader
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.gpu import Gpu, GpuFailed
from porelang.gpu.fields import LONGEST, resident
from porelang.ir import Node
from porelang.progress import cancelled, tell
from porelang.render.camera import Camera
from porelang.render.cells import Cells
from porelang.render.cuts import MOST_NOTCHES, Shown
from porelang.tape import operations

#: What a round over the picture is of all the work: where it begins, how much it is, and of how much.
Part = tuple[int, int, int]
WHOLE: Part = (0, 1, 1)
Distances = NDArray[np.float32]
#: Rows, counted from the top, and columns of a picture.
Tile = tuple[slice, slice]
LIGHT, DISTANCE, STEPS, GLASS = 0, 1, 2, 3
#: Pixels of the small picture that is drawn first, to learn how long one takes.
PROBE = (48, 36)
#: What a single call of the driver should take, in seconds, and the sides of its tile in pixels.
CALL, SMALLEST, LARGEST = 0.5, 16, 1024
#: The shortest step, in samples of the picture: solid that a ray passes through for less may be missed.
FINEST = 0.01
COMPILING, DRAWING = 600.0, 60.0
#: Red, green and blue of the part, and of faces where it is cut, in the light.
MATERIAL = np.array((0.945, 0.915, 0.855), np.float32)
SECTION = np.array((0.800, 0.440, 0.330), np.float32)


@dataclass(frozen=True, slots=True)
class Scene:
    """What is drawn: a formula, the box that is shown of it, and what is known of its cells; and the params' ranges."""

    part: Formula
    ranges: Mapping[str, tuple[float, float]]
    cells: Cells
    shown: Shown

    @property
    def box(self) -> Box:
        return self.cells.box


class Marcher:
    """The shader of a scene, ready to draw it from a camera in pictures of `size` pixels (width, height)."""

    def __init__(
        self, scene: Scene, camera: Camera, size: tuple[int, int], gpu: Gpu, samples: int = 1, bare: bool = False
    ):
        """`bare` draws the light alone, on white."""
        self.size, self.gpu, self.pixel = size, gpu, camera.pixel(size, scene.box)
        self.shader = _shader(scene.part.roots, tuple(sorted(scene.ranges.items())), bool(scene.shown.notches))
        self.data = resident(scene.part, self.shader)
        box, pixel = scene.box, self.pixel
        middle = np.add(box.lo, box.hi) / 2
        farthest = float(np.linalg.norm(camera.eye - middle) + np.linalg.norm(box.size))
        diagonal = float(np.linalg.norm(box.size))
        # what float32 rounds of a place: it counts for parts far from the origin
        rounded = 2.0**-23 * float(np.abs(np.concatenate([camera.eye, box.lo, box.hi])).max())
        self.nearest = max(0.2 * pixel, 1e-6 * farthest, 4 * rounded)
        self.finest = max(FINEST * pixel, 1e-7 * farthest, rounded)
        with np.errstate(over="ignore"):
            numbers = np.array(scene.part.with_roots(*self.shader.uniforms).numbers, dtype=np.float32)
        corners = np.zeros((2, MOST_NOTCHES, 3))
        for i, notch in enumerate(scene.shown.notches):
            corners[:, i] = notch.lo, notch.hi
        self.uniforms: dict[str, Any] = {
            "samples": samples,
            "material": np.ones(3, np.float32) if bare else MATERIAL,
            "section": np.ones(3, np.float32) if bare else SECTION,
            "eye": camera.eye,
            "camera": np.stack([camera.right, camera.up, camera.forward]),
            "zoom": camera.zoom,
            "perspective": float(camera.perspective),
            "box_lo": np.array(box.lo),
            "box_hi": np.array(box.hi),
            "cells_lo": np.array(box.lo),
            "cells_hi": np.array(box.hi),
            "cut_lo": np.array(scene.shown.cut_lo, np.float32),
            "cut_hi": np.array(scene.shown.cut_hi, np.float32),
            "notches": len(scene.shown.notches),
            "notch_lo": corners[0],
            "notch_hi": corners[1],
            "counts": np.array(scene.cells.counts),
            "finest": self.finest,
            "rounding": rounded,
            "nearest": self.nearest,
            "jump": max(0.5 * pixel, self.nearest),
            "reach": 0.1 * diagonal,
            "grain": max(0.5 * pixel, 1e-5 * farthest, 32 * rounded),
        } | ({"u": numbers} if len(numbers) else {})
        self.cells = scene.cells.values
        self.per_pixel, self.steps = self._probe()

    def light(self, distances: Distances, part: Part = WHOLE, glass: bool = False) -> NDArray[np.uint8]:
        """The picture of what lies at `distances`: (height, width, 4) bytes, alpha 0 where no part is seen.

        Of glass all colours are the brightness, alpha is how much it hides, and the faces of cuts are left out.
        """
        out = np.zeros((*distances.shape, 4), np.uint8)
        for tile in self._tiles(part):
            if np.isfinite(distances[tile]).any():
                out[tile] = self._draw(GLASS if glass else LIGHT, self.size, tile, DRAWING, distances[tile])
        return out

    def distances(self, part: Part = WHOLE, behind: Distances | None = None, leaving: bool = False) -> Distances:
        """How far from the eye each ray meets the part, in mm (height, width); infinite where it does not.

        Asked for what lies `behind` other distances, it is where the ray meets the part from there on; or where it
        leaves the part.
        """
        out = np.empty(self.size[::-1], np.float32)
        for tile in self._tiles(part):
            before = None if behind is None else behind[tile]
            if before is not None and not np.isfinite(before).any():
                out[tile] = np.inf
                continue
            found = _numbers(self._draw(DISTANCE, self.size, tile, DRAWING, before, leaving), np.float32)
            out[tile] = np.where(found < 0, np.float32(np.inf), found)
        return out

    def _probe(self) -> tuple[float, float]:
        """Seconds for a pixel, and samples of the field for a ray, from a picture of few pixels."""
        one, few = _tile(0, 0, 1, 1), _tile(0, 0, *PROBE)
        self._draw(DISTANCE, (1, 1), one, COMPILING)
        start = time.perf_counter()
        found = _numbers(self._draw(DISTANCE, PROBE, few, COMPILING), np.float32)
        self._draw(LIGHT, PROBE, few, COMPILING, np.where(found < 0, np.float32(np.inf), found))
        taken = time.perf_counter() - start
        steps = _numbers(self._draw(STEPS, PROBE, few, COMPILING), np.uint32)
        return taken / (PROBE[0] * PROBE[1]), float(steps.mean())

    def _tiles(self, part: Part) -> Iterator[Tile]:
        """Squares that cover the picture, each of which takes about CALL seconds; `part` is their share of the work."""
        width, height = self.size
        side = int(np.clip((CALL / max(self.per_pixel, 1e-12)) ** 0.5, SMALLEST, LARGEST)) // 16 * 16
        done = 0
        for top in range(0, height, side):
            for left in range(0, width, side):
                w, h = min(side, width - left), min(side, height - top)
                yield _tile(left, top, w, h)
                done += w * h
                begin, parts, of = part
                tell(begin * width * height + parts * done, of * width * height)

    def _draw(
        self,
        want: int,
        size: tuple[int, int],
        tile: Tile,
        timeout: float,
        distances: Distances | None = None,
        leaving: bool = False,
    ) -> NDArray[np.uint8]:
        """One tile: (height, width, 4) bytes, top row first."""
        rows, columns = tile
        width, height = columns.stop - columns.start, rows.stop - rows.start
        known = np.zeros(1, np.float32) if distances is None else np.where(np.isfinite(distances), distances, -1)[::-1]
        here = {
            "want": want,
            "side": -1.0 if leaving else 1.0,
            "layer": 0.0 if distances is None else 1.0,
            "size": np.array(size, np.float32),
            "corner": np.array((columns.start, size[1] - rows.stop), np.float32),
            "across": width,
        }
        try:
            return self.gpu.render(self.shader.text, size=(width, height), uniforms=self.uniforms | here,
                                   inputs=[self.cells, known.astype(np.float32)], data=self.data, timeout=timeout,
                                   cancel=cancelled)  # fmt: skip
        except GpuFailed as failed:
            raise _failed(failed) from None


def _tile(left: int, top: int, width: int, height: int) -> Tile:
    return slice(top, top + height), slice(left, left + width)


def _numbers(pixels: NDArray[np.uint8], form: type[np.float32] | type[np.uint32]) -> NDArray[Any]:
    """Four bytes of a pixel, the lowest first, as a number."""
    return np.ascontiguousarray(pixels).view("<u4")[..., 0].view(form)


@lru_cache(maxsize=64)
def _shader(roots: tuple[Node, ...], ranges: tuple[tuple[str, tuple[float, float]], ...], notched: bool) -> Shader:
    length = operations(roots)
    if length > LONGEST:
        raise fail(
            "E121",
            f"the program is too long for a shader: {length:,} operations, where drivers manage {LONGEST:,}",
            hint="`pore mesh --backend numpy` has no such limit, and its mesh can be looked at",
        )
    made = shader(roots, dict(ranges), "fragment")
    version, rest = made.text.split("\n", 1)
    return replace(made, text=f"{version}\n#define NOTCHED\n{rest}") if notched else made


def _failed(error: GpuFailed) -> PoreError:
    return fail("E122", f"the graphics driver failed: {error.reason}",
                hint="`pore mesh --backend numpy` needs no driver; `pore doctor` examines it")  # fmt: skip
