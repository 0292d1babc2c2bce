"""Scenes drawn by OpenGL in a window, as web/painter.js draws them in a page: the same shaders, lengths and order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from porelang.analysis.box import Box
from porelang.preview.scene import ROW, Body, Layer, Scene
from porelang.render.camera import Camera
from porelang.render.march import FINEST
from porelang.render.scale import COLOURS, VIRIDIS, Scale, line_step

CORNERS = """#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }"""
#: How much of a plane shows where the part is not.
CLEAR = 0.45


@dataclass(slots=True)
class Section:
    """A plane across an axis (-1: none) at `offset` mm; what is beyond it is kept, or what is before (`keeps` -1)."""

    axis: int = -1
    offset: float = 0.0
    keeps: int = 1


class Drawing:
    """A scene in a context. Errors: `moderngl.Error` with the driver's words where it refuses a shader."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.scene: Scene | None = None
        self._programs: dict[str, tuple[moderngl.Program, moderngl.VertexArray]] = {}
        self._textures: dict[int, list[Any]] = {}

    def take(self, scene: Scene) -> None:
        """From now on this is drawn; shaders that it shares with the one before are not compiled again."""
        layers = [*(b.layer for b in scene.bodies), *([scene.plane] if scene.plane is not None else [])]
        made = {layer.text: self._programs.get(layer.text) or self._compiled(layer.text) for layer in layers}
        for text in self._programs.keys() - made.keys():
            for thing in reversed(self._programs[text]):
                thing.release()
        self._programs = made
        for textures in self._textures.values():
            for texture in textures:
                texture.release()
        self._textures = {id(b.layer): [self._cells(b), *map(self._words, b.layer.data)] for b in scene.bodies}
        if scene.plane is not None:
            self._textures[id(scene.plane)] = [*map(self._words, scene.plane.data)]
        self.scene = scene

    def draw(self, into: moderngl.Framebuffer, camera: Camera, section: Section, first: int, last: int) -> None:
        """The rows first..last, counted from the bottom, of a picture."""
        scene = self.scene
        if scene is None:
            return
        width, height = into.size
        into.use()
        into.scissor = (0, first, width, last - first)
        into.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)
        self.context.enable_only(moderngl.DEPTH_TEST)
        self.context.depth_func = "<="
        ends = np.array([scene.stage.lo, scene.stage.hi])
        farthest = float(np.linalg.norm(np.abs(ends - camera.eye).max(axis=0)))
        rounding = 2.0**-23 * float(max(np.abs(ends).max(), np.abs(camera.eye).max()))
        common = {
            "zoom": camera.zoom, "perspective": float(camera.perspective), "size": (float(width), float(height)),
            "eye": tuple(camera.eye), "camera": np.array([camera.right, camera.up, camera.forward], "f4").tobytes(),
            "farthest": farthest,
        }  # fmt: skip
        if scene.scale is not None:
            low, high = scene.scale.ends
            around = isinstance(scene.scale, Scale)
            common["scale_colours"] = (COLOURS if around else VIRIDIS).astype("f4").tobytes()
            common["scale_ends"] = (low, 0.0 if around else (low + high) / 2, high)
        for body in scene.bodies:
            self._body(body, camera, section, height, rounding, common)
        if scene.plane is not None and section.axis >= 0 and scene.scale is not None:
            self.context.enable(moderngl.BLEND)
            self.context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
            self._run(scene.plane, common | {
                "box_lo": scene.stage.lo, "box_hi": scene.stage.hi, "axis": section.axis, "offset": section.offset,
                "nearer": max(2e-6 * farthest, 8 * rounding), "clear": CLEAR,
                "every": line_step(scene.scale),
            })  # fmt: skip

    def _body(
        self, body: Body, camera: Camera, section: Section, height: int, rounding: float, common: dict[str, Any]
    ) -> None:
        lo, hi, cut = list(body.box.lo), list(body.box.hi), np.zeros((2, 3))
        axis, offset = section.axis, section.offset
        if axis >= 0:
            if offset >= hi[axis] if section.keeps > 0 else offset <= lo[axis]:
                return
            if section.keeps > 0 and offset > lo[axis]:
                lo[axis], cut[0, axis] = offset, 1
            if section.keeps < 0 and offset < hi[axis]:
                hi[axis], cut[1, axis] = offset, 1
        pixel = camera.pixel((1, height), body.box)
        diagonal = math.hypot(*body.box.size)
        far = float(np.linalg.norm(camera.eye - np.add(body.box.lo, body.box.hi) / 2)) + diagonal
        nearest = max(0.2 * pixel, 1e-6 * far, 4 * rounding)
        self._run(body.layer, common | {
            "want": 0, "samples": 1, "side": 1.0, "layer": 0.0, "corner": (0.0, 0.0), "rounding": rounding,
            "nearest": nearest, "finest": max(FINEST * pixel, 1e-7 * far, rounding), "jump": max(0.5 * pixel, nearest),
            "reach": 0.1 * diagonal, "grain": max(0.5 * pixel, 1e-5 * far, 32 * rounding),
            "box_lo": tuple(lo), "box_hi": tuple(hi), "cells_lo": body.box.lo, "cells_hi": body.box.hi,
            "cut_lo": tuple(cut[0]), "cut_hi": tuple(cut[1]), "counts": body.cells.counts,
            "material": body.colour, "section": body.section,
        })  # fmt: skip

    def _run(self, layer: Layer, values: dict[str, Any]) -> None:
        program, corners = self._programs[layer.text]
        for unit, texture in enumerate(self._textures[id(layer)]):
            texture.use(unit)
        names = ["cells"] if "cells" in program else []
        names += [f"data{k}" for k in range(len(layer.data))]
        settings = values | {name: unit for unit, name in enumerate(names)}
        if len(layer.numbers):
            settings["u"] = layer.numbers.tobytes()
        for name, value in settings.items():
            if name not in program:  # a driver leaves out what nothing reads
                continue
            member: Any = program[name]
            if isinstance(value, bytes):
                member.write(value)
            else:
                member.value = value
        corners.render(moderngl.TRIANGLES, 3)

    def _compiled(self, text: str) -> tuple[moderngl.Program, moderngl.VertexArray]:
        program = self.context.program(vertex_shader=CORNERS, fragment_shader=text)
        return program, self.context.vertex_array(program, [])

    def _cells(self, body: Body) -> moderngl.Texture3D:
        values = np.ascontiguousarray(body.cells.values.transpose(2, 1, 0), "f4")
        made = self.context.texture3d(body.cells.counts, 1, values.tobytes(), dtype="f4")
        made.filter = moderngl.NEAREST, moderngl.NEAREST
        return made

    def _words(self, words: Any) -> moderngl.Texture:
        rows = -(-len(words) // ROW)
        whole = np.zeros(rows * ROW, np.uint32)
        whole[: len(words)] = words
        made = self.context.texture((ROW, rows), 1, whole.tobytes(), dtype="u4")
        made.filter = moderngl.NEAREST, moderngl.NEAREST
        return made


def diagonal(box: Box) -> float:
    """mm."""
    return math.hypot(*box.size)
