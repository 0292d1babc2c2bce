"""The shader at work: uniforms, tiles that no driver takes for a hang, and the pictures that come back."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.glsl import Shader, shader
from porelang.backends.uniform import uniform_values
from porelang.device import LONGEST
from porelang.diagnostics import PoreError, fail
from porelang.gpu import Gpu, GpuFailed
from porelang.ir import Node, order
from porelang.passes.box import Box
from porelang.render.camera import Camera
from porelang.render.cells import Cells

Progress = Callable[[int, int], None]
LIGHT, DISTANCE, STEPS = 0, 1, 2
#: Pixels of the small picture that is drawn first, to learn how long one takes.
PROBE = (48, 36)
#: What a single call of the driver should take, in seconds, and the sides of its tile in pixels.
CALL, SMALLEST, LARGEST = 0.5, 16, 1024
COMPILING, DRAWING = 600.0, 60.0


@dataclass(frozen=True, slots=True)
class Scene:
    """What is drawn: a root with its params set, in a box of cells that cuts it at some of its faces."""

    root: Node
    params: Mapping[str, float]
    ranges: Mapping[str, tuple[float, float]]
    cells: Cells
    cut_lo: tuple[bool, bool, bool]
    cut_hi: tuple[bool, bool, bool]

    @property
    def box(self) -> Box:
        return self.cells.box


class Marcher:
    """The shader of a scene, ready to draw it from a camera in pictures of `size` pixels (width, height)."""

    def __init__(self, scene: Scene, camera: Camera, size: tuple[int, int], gpu: Gpu, samples: int = 1):
        self.size, self.gpu = size, gpu
        self.shader = _shader(scene.root, tuple(sorted(scene.ranges.items())))
        box, pixel = scene.box, camera.pixel(size, scene.box)
        middle = np.add(box.lo, box.hi) / 2
        farthest = float(np.linalg.norm(camera.eye - middle) + np.linalg.norm(box.size))
        diagonal = float(np.linalg.norm(box.size))
        self.nearest = max(0.2 * pixel, 1e-6 * farthest)
        known = uniform_values(self.shader.uniforms, scene.params)
        with np.errstate(over="ignore"):
            numbers = np.array([known[n] for n in self.shader.uniforms], dtype=np.float32)
        self.uniforms: dict[str, Any] = {
            "samples": samples,
            "eye": camera.eye,
            "camera": np.stack([camera.right, camera.up, camera.forward]),
            "zoom": camera.zoom,
            "perspective": float(camera.perspective),
            "box_lo": np.array(box.lo),
            "box_hi": np.array(box.hi),
            "cut_lo": np.array(scene.cut_lo, np.float32),
            "cut_hi": np.array(scene.cut_hi, np.float32),
            "counts": np.array(scene.cells.counts),
            "nearest": self.nearest,
            "jump": max(pixel, self.nearest),
            "reach": 0.1 * diagonal,
            "grain": max(0.5 * pixel, 1e-5 * farthest),
        } | ({"u": numbers} if len(numbers) else {})
        self.cells = scene.cells.values
        self.per_pixel, self.steps = self._probe()

    def light(self, progress: Progress | None = None) -> NDArray[np.uint8]:
        """The picture: (height, width, 4) bytes, alpha 0 where no part is seen."""
        return self._tiles(LIGHT, progress)

    def distances(self, progress: Progress | None = None) -> NDArray[np.float32]:
        """How far from the eye each ray meets the part, in mm (height, width); infinite where it does not."""
        found = _numbers(self._tiles(DISTANCE, progress), np.float32)
        return np.where(found < 0, np.float32(np.inf), found)

    def _probe(self) -> tuple[float, float]:
        """Seconds for a pixel, and samples of the field for a ray, from a picture of few pixels."""
        self._draw(LIGHT, (1, 1), (0, 0), (1, 1), COMPILING)
        start = time.perf_counter()
        self._draw(LIGHT, PROBE, (0, 0), PROBE, COMPILING)
        taken = time.perf_counter() - start
        steps = _numbers(self._draw(STEPS, PROBE, (0, 0), PROBE, COMPILING), np.uint32)
        return taken / (PROBE[0] * PROBE[1]), float(steps.mean())

    def _tiles(self, want: int, progress: Progress | None) -> NDArray[np.uint8]:
        width, height = self.size
        side = int(np.clip((CALL / max(self.per_pixel, 1e-12)) ** 0.5, SMALLEST, LARGEST)) // 16 * 16
        out = np.empty((height, width, 4), np.uint8)
        done = 0
        for top in range(0, height, side):
            for left in range(0, width, side):
                w, h = min(side, width - left), min(side, height - top)
                tile = self._draw(want, self.size, (left, height - top - h), (w, h), DRAWING)
                out[top : top + h, left : left + w] = tile
                done += w * h
                if progress is not None:
                    progress(done, width * height)
        return out

    def _draw(
        self, want: int, size: tuple[int, int], corner: tuple[int, int], tile: tuple[int, int], timeout: float
    ) -> NDArray[np.uint8]:
        here = {"want": want, "size": np.array(size, np.float32), "corner": np.array(corner, np.float32)}
        try:
            return self.gpu.render(self.shader.text, size=tile, uniforms=self.uniforms | here, inputs=[self.cells],
                                   timeout=timeout)  # fmt: skip
        except GpuFailed as failed:
            raise _failed(failed) from None


def _numbers(pixels: NDArray[np.uint8], form: type[np.float32] | type[np.uint32]) -> NDArray[Any]:
    """Four bytes of a pixel, the lowest first, as a number."""
    return np.ascontiguousarray(pixels).view("<u4")[..., 0].view(form)


@lru_cache(maxsize=64)
def _shader(root: Node, ranges: tuple[tuple[str, tuple[float, float]], ...]) -> Shader:
    length = len(order([root]))
    if length > LONGEST:
        raise fail(
            "E121",
            f"the program is too long for a shader: {length:,} operations, where drivers manage {LONGEST:,}",
            hint="`pore mesh --backend numpy` has no such limit, and its mesh can be looked at",
        )
    return shader(root, dict(ranges), "fragment")


def _failed(error: GpuFailed) -> PoreError:
    return fail("E122", f"the graphics driver failed: {error.reason}",
                hint="`pore mesh --backend numpy` needs no driver; `pore doctor` examines it")  # fmt: skip
