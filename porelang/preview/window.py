"""The preview in a window of the system: the part, its params by keys, and what is wrong, on it."""

from __future__ import annotations

import math
import queue
import threading
import time
from typing import Any

import moderngl
import moderngl_window
from moderngl_window.context.base import KeyModifiers, WindowConfig
from PIL import Image

from porelang.preview.doing import Message
from porelang.preview.drawing import Drawing, Section, diagonal
from porelang.preview.live import Live, Start
from porelang.preview.orbit import Orbit
from porelang.preview.panel import panel
from porelang.preview.scene import Scene, Wish
from porelang.preview.watched import LOOK, Watched
from porelang.render.camera import VIEWS

#: Seconds that a frame may take while something moves, and a strip of the full picture; without a change until that is
#: begun.
FRAME, STRIP, STILL = 0.04, 0.03, 0.15
COARSEST = 8.0
SHOWN = """#version 330
uniform sampler2D picture; uniform vec2 size; uniform vec2 corner; out vec4 colour;
void main() { colour = texture(picture, (gl_FragCoord.xy - corner) / size); }"""
PLACED = """#version 330
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }"""


class Window(WindowConfig):
    """A program in a window. `path` and `start` say which, and what it begins with."""

    gl_version = (4, 3)
    window_size = (960, 720)
    aspect_ratio = None  # type: ignore[assignment]  # as wide as it is made
    title = "porelang"
    path = ""
    start = Start({}, None, {})

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.orbit, self.section = Orbit(), Section()
        self.drawing = Drawing(self.ctx)
        self.heard: queue.Queue[Message] = queue.Queue()
        self.told: dict[str, str] = {}
        self.params: list[dict[str, Any]] = []
        self.bodies: list[str] = []
        self.fields: list[str] = []
        self.chosen, self.file, self.doing = 0, "", ""
        self.paint, self.fitted = "", ""
        self.coarse, self.per_pixel = 4.0, 0.0
        self.moved, self.left = True, -1  # rows of the full picture that are not drawn yet
        self.since = time.monotonic()
        self.pictures = 0  # full ones so far
        self.shown: moderngl.Framebuffer | None = None
        self.full: moderngl.Framebuffer | None = None
        self.words: moderngl.Texture | None = None
        program = self.ctx.program(vertex_shader=PLACED, fragment_shader=SHOWN)
        self.shower = program, self.ctx.vertex_array(program, [])
        self.live = Live(self.path, self.heard.put, self.start)
        self.ended = threading.Event()
        threading.Thread(target=self._follow, daemon=True).start()

    # ---- what is heard ----------------------------------------------------------------------------------------------

    def _follow(self) -> None:
        self.live.begin()
        watched = Watched(self.live.document.path)
        while not self.ended.wait(LOOK):
            if watched.changed():
                self.live.reread()

    def _hear(self) -> None:
        changed = False
        while not self.heard.empty():
            word = self.heard.get()
            changed = True
            if isinstance(word, Scene):
                self._take(word)
            elif word["say"] == "program":
                self.params, self.bodies, self.fields = word["params"], word["bodies"], word["fields"]
                self.chosen = min(self.chosen, max(len(self.params) - 1, 0))
                self.file, self.wnd.title = word["file"], word["file"]
                self.told["text"] = "\n\n".join(word["wrong"])
            elif word["say"] == "refused":
                self.told[word["of"]] = word["text"]
            elif word["say"] == "doing" and word["of"] == "scene":
                self.doing = f"{word['what']} {word['share']:.0%}"
            elif word["say"] == "done" and word["of"] == "scene":
                self.doing = ""
        if changed:
            self._write()

    def _take(self, scene: Scene) -> None:
        try:
            self.drawing.take(scene)
        except moderngl.Error as error:
            self.told["scene"] = f"this graphics driver refuses the shader of the part:\n{error}"
            return
        self.told["scene"] = ""
        names = " ".join(b.layer.name for b in scene.bodies)
        if names != self.fitted:
            self.orbit.fit(scene.stage, self.wnd.buffer_size)
        self.fitted = names
        self.moved = True

    def _write(self) -> None:
        """What stands over the picture."""
        wrong = "\n\n".join(filter(None, self.told.values()))
        image = panel(self.file, self.params, self.chosen, self._looks(), wrong, self.doing)
        if self.words is not None:
            self.words.release()
        self.words = self.ctx.texture(image.size, 4, image.transpose(Image.Transpose.FLIP_TOP_BOTTOM).tobytes())

    def _looks(self) -> str:
        axis = self.section.axis
        across = "" if axis < 0 else f"section {'xyz'[axis]} = {self.section.offset:.4g} mm   "
        return across + (f"colour: {self.paint}" if self.paint else "")

    # ---- what is drawn ----------------------------------------------------------------------------------------------

    def on_render(self, time: float, frame_time: float) -> None:
        self._hear()
        if self.drawing.scene is not None:
            if self.moved:
                self._quick()
            elif self.left != 0 and _now() - self.since > STILL:
                self._strip()
        self._present()
        if not self.moved and self.left == 0:
            _rest()

    def _camera(self) -> Any:
        assert self.drawing.scene is not None
        return self.orbit.camera(diagonal(self.drawing.scene.stage))

    def _target(self, coarse: float, before: moderngl.Framebuffer | None) -> moderngl.Framebuffer:
        width, height = self.wnd.buffer_size
        size = max(1, round(width / coarse)), max(1, round(height / coarse))
        if before is not None and before.size == size:
            return before
        depth = self.ctx.depth_renderbuffer(size)
        made: moderngl.Framebuffer = self.ctx.framebuffer([self.ctx.texture(size, 4)], depth)
        return made

    def _quick(self) -> None:
        begun = _now()
        self.shown = self._target(self.coarse, self.shown if self.shown is not self.full else None)
        self.drawing.draw(self.shown, self._camera(), self.section, 0, self.shown.height)
        self.ctx.finish()
        taken = _now() - begun
        self.per_pixel = taken / (self.shown.width * self.shown.height)
        if taken > FRAME:
            self.coarse = min(COARSEST, self.coarse * (taken / FRAME) ** 0.5)
        elif taken < FRAME / 3:
            self.coarse = max(1.0, self.coarse / 1.3)
        self.moved, self.left, self.since = False, -1, _now()

    def _strip(self) -> None:
        """Some more rows of the full picture, from the top."""
        if self.left < 0:
            self.full = self._target(1.0, self.full if self.full is not self.shown else None)
            self.left = self.full.height
        assert self.full is not None
        rows = max(1, int(STRIP / max(self.per_pixel, 1e-12) / self.full.width))
        first = max(0, self.left - rows)
        self.drawing.draw(self.full, self._camera(), self.section, first, self.left)
        self.ctx.finish()
        self.left = first
        if not first:
            self.shown = self.full
            self.pictures += 1

    def _present(self) -> None:
        self.wnd.use()
        self.ctx.scissor = None
        self.ctx.clear(1.0, 1.0, 1.0, 1.0)
        self.ctx.enable_only(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        if self.shown is not None:
            picture = self.shown.color_attachments[0]
            assert isinstance(picture, moderngl.Texture)
            self._show(picture, self.wnd.buffer_size, (0, 0))
        if self.words is not None:
            self._show(self.words, self.words.size, (0, self.wnd.buffer_size[1] - self.words.height))

    def _show(self, picture: moderngl.Texture, size: tuple[int, int], corner: tuple[int, int]) -> None:
        program, corners = self.shower
        picture.filter = moderngl.NEAREST, moderngl.NEAREST
        picture.repeat_x = picture.repeat_y = False
        picture.use(0)
        for name, value in (("size", size), ("corner", corner)):
            member: Any = program[name]
            member.value = tuple(map(float, value))
        self.ctx.scissor = (*corner, *size)
        corners.render(moderngl.TRIANGLES, 3)
        self.ctx.scissor = None

    # ---- hands ------------------------------------------------------------------------------------------------------

    def on_resize(self, width: int, height: int) -> None:
        self.moved = True

    def on_mouse_drag_event(self, x: int, y: int, dx: int, dy: int) -> None:
        if self.wnd.mouse_states.right or self.wnd.modifiers.shift:
            self.orbit.move(dx, dy, self.wnd.size[1])
        else:
            self.orbit.turn(-0.4 * dx, 0.4 * dy)
        self.moved = True

    def on_mouse_scroll_event(self, x_offset: float, y_offset: float) -> None:
        self.orbit.closer(1.1**y_offset)
        self.moved = True

    def on_key_event(self, key: Any, action: Any, modifiers: KeyModifiers) -> None:
        keys = self.wnd.keys
        scene = self.drawing.scene
        if action != keys.ACTION_PRESS or scene is None:
            return
        turn = 1.0 if modifiers.shift else 5.0
        acts: dict[Any, Any] = {
            keys.LEFT: lambda: self.orbit.turn(-turn, 0), keys.RIGHT: lambda: self.orbit.turn(turn, 0),
            keys.UP: lambda: self.orbit.turn(0, turn), keys.DOWN: lambda: self.orbit.turn(0, -turn),
            keys.EQUAL: lambda: self.orbit.closer(1.15), keys.MINUS: lambda: self.orbit.closer(1 / 1.15),
            keys.F: lambda: self.orbit.fit(scene.stage, self.wnd.buffer_size), keys.O: self._project,
            keys.X: lambda: self._cross(0), keys.Y: lambda: self._cross(1), keys.Z: lambda: self._cross(2),
            keys.PAGE_UP: lambda: self._slide(1), keys.PAGE_DOWN: lambda: self._slide(-1), keys.C: self._colour,
            keys.TAB: lambda: self._choose(-1 if modifiers.shift else 1),
            keys.PERIOD: lambda: self._set(1), keys.COMMA: lambda: self._set(-1),
        }  # fmt: skip
        acts |= {getattr(keys, f"NUMBER_{i + 1}"): lambda v=v: self._stand(v) for i, v in enumerate(VIEWS.values())}
        if key in acts:
            acts[key]()
            self.moved = True
            self._write()

    def _project(self) -> None:
        self.orbit.perspective = not self.orbit.perspective

    def _stand(self, view: tuple[float, float]) -> None:
        assert self.drawing.scene is not None
        self.orbit.azimuth, self.orbit.elevation = view
        self.orbit.fit(self.drawing.scene.stage, self.wnd.buffer_size)

    def _cross(self, axis: int) -> None:
        """A section across an axis, through the middle; the same key again takes it away."""
        assert self.drawing.scene is not None
        box = self.drawing.scene.stage
        if self.section.axis == axis:
            self.section.axis = -1
        else:
            away = -1 if self.orbit.axes()[0][axis] > 0 else 1  # what is before it is taken away
            self.section = Section(axis, (box.lo[axis] + box.hi[axis]) / 2, away)
        self._wish()

    def _slide(self, way: int) -> None:
        axis = self.section.axis
        if axis >= 0 and self.drawing.scene is not None:
            box = self.drawing.scene.stage
            moved = self.section.offset + way * box.size[axis] / 50
            self.section.offset = min(max(moved, box.lo[axis]), box.hi[axis])

    def _colour(self) -> None:
        """The next of the fields."""
        offered = ["", *self.fields]
        self.paint = offered[(offered.index(self.paint) + 1) % len(offered)] if self.paint in offered else ""
        self._wish()

    def _wish(self) -> None:
        self.told["scene"] = ""
        self.live.show(Wish((), self.paint, self.section.axis >= 0))

    def _choose(self, way: int) -> None:
        if self.params:
            self.chosen = (self.chosen + way) % len(self.params)

    def _set(self, way: int) -> None:
        """The chosen param, a step up or down."""
        if not self.params:
            return
        param = self.params[self.chosen]
        if param["choices"]:
            place = (param["choices"].index(param["value"]) + way) % len(param["choices"])
            param["value"] = param["choices"][place]
        else:
            step = param["step"] or param["scale"] * _fine((param["high"] - param["low"]) / param["scale"])
            param["value"] = min(max(param["value"] + way * step, param["low"]), param["high"])
        self.told["scene"] = ""
        self.live.set({param["name"]: param["value"]})

    def on_close(self) -> None:
        self.ended.set()
        self.live.close()


def _fine(range: float) -> float:
    """A step of 1, 2 or 5 times a power of ten, of which some fifty make a range."""
    power = 10.0 ** math.floor(math.log10(range / 50))
    return next(power * n for n in (5, 2, 1) if n * power <= range / 50)


def _now() -> float:
    return time.monotonic()


def _rest() -> None:
    """Nothing moves: leave the machine to others."""
    time.sleep(0.02)


def opened(path: str, start: Start) -> None:
    """Show a program in a window until it is closed."""
    shown = type("Shown", (Window,), {"path": path, "start": start})
    moderngl_window.run_window_config(shown, args=["--window", "pyglet"])  # without any it reads those of `pore`
