"""The preview in a window of the system: the part, beside it what is set and was measured, and what is wrong."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Sequence
from typing import Any

import moderngl
import moderngl_window
from moderngl_window.context.base import KeyModifiers, WindowConfig
from PIL import Image

from porelang.preview.doing import Message
from porelang.preview.drawing import Drawing, diagonal
from porelang.preview.frames import Frames
from porelang.preview.heard import Known
from porelang.preview.items import Desk
from porelang.preview.live import Live, Start
from porelang.preview.orbit import Orbit
from porelang.preview.panel import WIDE, Column, colours, column, notice
from porelang.preview.scene import Scene
from porelang.preview.watched import LOOK, Watched
from porelang.render.camera import VIEWS

SHOWN = """#version 330
uniform sampler2D picture; uniform vec2 size; uniform vec2 corner; out vec4 colour;
void main() { colour = texture(picture, (gl_FragCoord.xy - corner) / size); }"""
PLACED = """#version 330
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }"""


class Window(WindowConfig):
    """A program in a window. `path` and `start` say which, and what it begins with."""

    gl_version = (4, 3)
    window_size = (1120, 760)
    aspect_ratio = None  # type: ignore[assignment]  # as wide as it is made
    title = "porelang"
    log_level = logging.WARNING  # the terminal is not told what the driver is called
    path = ""
    start = Start({}, None, {})

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.orbit, self.drawing, self.known = Orbit(), Drawing(self.ctx), Known()
        self.frames = Frames(self.ctx, self.drawing)
        self.heard: queue.Queue[Message] = queue.Queue()
        self.chosen, self.fitted = 0, ""
        self.beside, self.scrolled = True, 0  # whether the column is seen, and by how many pixels it is moved up
        self.column: Column | None = None
        self.pulled: int | None = None  # the item whose slider the mouse holds; -1 elsewhere on the column
        # what stands beside and over the picture, by what it is
        self.words: dict[str, moderngl.Texture] = {}
        self.written = 0, 0  # the size that these were made for
        program = self.ctx.program(vertex_shader=PLACED, fragment_shader=SHOWN)
        self.shower = program, self.ctx.vertex_array(program, [])
        self.live = Live(self.path, self.heard.put, self.start)
        self.desk = Desk(self.live, self.known)
        self.ended = threading.Event()
        threading.Thread(target=self._follow, daemon=True).start()

    # ---- what is heard ----------------------------------------------------------------------------------------------

    def _follow(self) -> None:
        self.live.begin()
        watched = Watched(self.live.document.path)
        gone = ""
        while not self.ended.wait(LOOK):
            if (now := watched.gone()) != gone:
                gone = now
                self.heard.put({"say": "gone", "why": gone})
            if watched.changed():
                self.live.reread()

    def _hear(self) -> None:
        changed = False
        while not self.heard.empty():
            word = self.heard.get()
            changed = True
            if isinstance(word, Scene):
                self._take(word)
            else:
                self.known.hear(word)
                if word["say"] == "stopped":
                    self.desk.wished(**word["wish"])
        if changed and self.known.file:
            self.wnd.title = self.known.file
        if changed or self.written != self.wnd.buffer_size:
            self._write()

    def _take(self, scene: Scene) -> None:
        try:
            self.drawing.take(scene)
        except moderngl.Error as error:
            self.known.wrong["scene"] = f"this graphics driver refuses the shader of the part:\n{error}"
            return
        self.known.wrong["scene"] = f"`{scene.shown}` is nowhere a number" if scene.shown and not scene.scale else ""
        self.desk.stage, self.desk.drawn = scene.stage, tuple(b.layer.name for b in scene.bodies)
        names = " ".join(self.desk.drawn)
        if names != self.fitted:
            self.orbit.fit(scene.stage, self._size())
        self.fitted = names
        self.frames.moved = True

    # ---- what stands beside the picture -----------------------------------------------------------------------------

    @property
    def _scale(self) -> float:
        """Pixels of a screen to one of a window's."""
        return float(self.wnd.pixel_ratio)

    def _left(self) -> int:
        """Where the picture begins: a narrow window has no room for a column."""
        wide = round(WIDE * self._scale)
        return wide if self.beside and self.wnd.buffer_size[0] >= 1.6 * wide else 0

    def _size(self) -> tuple[int, int]:
        """Of the picture."""
        width, height = self.wnd.buffer_size
        return max(1, width - self._left()), max(1, height)

    def _write(self) -> None:
        self.written = self.wnd.buffer_size
        height, scale = self.written[1], self._scale
        items = self.desk.items()
        self.chosen = min(self.chosen, len(items) - 1)
        self.column = column(self.known, items, self.chosen, height, scale) if self._left() else None
        if self.column is not None:
            self.scrolled = min(max(self.scrolled, 0), self.column.image.height - height)
            self._put("column", self.column.image.crop((0, self.scrolled, self._left(), self.scrolled + height)))
        wrong = "\n\n".join(filter(None, self.known.wrong.values()))
        self._put("notice", notice(wrong, self._size(), scale) if wrong else None)
        scene = self.drawing.scene
        self._put("colours", None if scene is None else colours(scene, self._size()))

    def _put(self, name: str, image: Image.Image | None) -> None:
        before = self.words.pop(name, None)
        if before is not None:
            before.release()
        if image is not None:
            upright = image.transpose(Image.Transpose.FLIP_TOP_BOTTOM)
            self.words[name] = self.ctx.texture(image.size, 4, upright.tobytes())

    # ---- what is drawn ----------------------------------------------------------------------------------------------

    def on_render(self, time: float, frame_time: float) -> None:
        self._hear()
        if (scene := self.drawing.scene) is not None:
            self.frames.draw(self.orbit.camera(diagonal(scene.stage)), self.desk.section, self._size())
        self._present()
        if scene is None or self.frames.still:
            _rest()

    def _present(self) -> None:
        self.wnd.use()
        self.ctx.scissor = None
        self.ctx.clear(1.0, 1.0, 1.0, 1.0)
        self.ctx.enable_only(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        width, height = self.wnd.buffer_size
        left = self._left()
        if self.frames.shown is not None:
            picture = self.frames.shown.color_attachments[0]
            assert isinstance(picture, moderngl.Texture)
            self._show(picture, self._size(), (left, 0))
        for name, made in self.words.items():
            if name == "column" and not left:
                continue
            corner = {"column": (0, height - made.height), "notice": (left, 0)}
            self._show(made, made.size, corner.get(name, (width - made.width, height - made.height)))

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
        self.frames.moved = True

    def on_mouse_press_event(self, x: int, y: int, button: int) -> None:
        self.pulled = None
        place = self._on_column(x, y)
        if place is None or self.column is None:
            return
        self.pulled = -1
        for i, (top, bottom) in enumerate(self.column.rows):
            if top <= place[1] < bottom:
                self.chosen, item = i, self.desk.items()[i]
                if item.put is None:  # a click goes on, the right button back
                    item.step(1 if button == self.wnd.mouse.left else -1)
                else:
                    self.pulled = i
                    if place[1] >= top + (bottom - top) / 2:  # on the slider, not on its name
                        self._pull(place[0])
        self._changed()

    def on_mouse_release_event(self, x: int, y: int, button: int) -> None:
        self.pulled = None

    def on_mouse_drag_event(self, x: int, y: int, dx: int, dy: int) -> None:
        if self.pulled is not None:
            self._pull(x * self._scale)
        elif self.wnd.mouse_states.right or self.wnd.modifiers.shift:
            self.orbit.move(dx, dy, self.wnd.size[1])
        else:
            self.orbit.turn(-0.4 * dx, 0.4 * dy)
        self.frames.moved = True

    def on_mouse_scroll_event(self, x_offset: float, y_offset: float) -> None:
        if self._on_column(*map(int, self.mouse_at)) is None:
            self.orbit.closer(1.1**y_offset)
            self.frames.moved = True
        else:
            self.scrolled -= round(60 * y_offset * self._scale)
            self._write()

    def on_mouse_position_event(self, x: int, y: int, dx: int, dy: int) -> None:
        self.mouse_at = x, y

    #: Where the mouse was last seen, in pixels of the window.
    mouse_at: tuple[float, float] = (1e6, 0.0)

    def _on_column(self, x: int, y: int) -> tuple[float, float] | None:
        """The place in the column's picture; None elsewhere."""
        place = x * self._scale, y * self._scale + self.scrolled
        return place if place[0] < self._left() else None

    def _pull(self, x: float) -> None:
        """The slider that the mouse holds, to under it."""
        items = self.desk.items()
        if self.column is None or self.pulled is None or not 0 <= self.pulled < len(items):
            return
        put = items[self.pulled].put
        if put is not None:
            put((x - self.column.left) / (self.column.right - self.column.left))
            self._changed()

    def on_key_event(self, key: Any, action: Any, modifiers: KeyModifiers) -> None:
        keys, desk = self.wnd.keys, self.desk
        if action != keys.ACTION_PRESS:
            return
        turn = 1.0 if modifiers.shift else 5.0
        toward: Sequence[float] = self.orbit.axes()[0].tolist()
        acts: dict[Any, Any] = {
            keys.LEFT: lambda: self.orbit.turn(-turn, 0), keys.RIGHT: lambda: self.orbit.turn(turn, 0),
            keys.UP: lambda: self.orbit.turn(0, turn), keys.DOWN: lambda: self.orbit.turn(0, -turn),
            keys.EQUAL: lambda: self.orbit.closer(1.15), keys.MINUS: lambda: self.orbit.closer(1 / 1.15),
            keys.F: self._fit, keys.O: self._project, keys.H: self._hide,
            keys.X: lambda: desk.cross(0, toward), keys.Y: lambda: desk.cross(1, toward),
            keys.Z: lambda: desk.cross(2, toward), keys.P: desk.field_on, keys.C: desk.colour,
            keys.PAGE_UP: lambda: desk.slide(1), keys.PAGE_DOWN: lambda: desk.slide(-1),
            keys.TAB: lambda: self._choose(-1 if modifiers.shift else 1),
            keys.PERIOD: lambda: self._set(1), keys.COMMA: lambda: self._set(-1), keys.BACKSPACE: self._cancel,
        }  # fmt: skip
        acts |= {getattr(keys, f"NUMBER_{i + 1}"): lambda v=v: self._stand(v) for i, v in enumerate(VIEWS.values())}
        if key in acts:
            acts[key]()
            self._changed()

    def _changed(self) -> None:
        self.frames.moved = True
        self._write()

    def _project(self) -> None:
        self.orbit.perspective = not self.orbit.perspective

    def _hide(self) -> None:
        self.beside = not self.beside

    def _fit(self) -> None:
        if self.desk.stage is not None:
            self.orbit.fit(self.desk.stage, self._size())

    def _stand(self, view: tuple[float, float]) -> None:
        self.orbit.azimuth, self.orbit.elevation = view
        self._fit()

    def _choose(self, way: int) -> None:
        self.chosen = (self.chosen + way) % len(self.desk.items())
        self._write()
        if self.column is not None:  # what is chosen is to be seen
            top, bottom = self.column.rows[self.chosen]
            self.scrolled = min(max(self.scrolled, bottom + 80 - self.wnd.buffer_size[1]), top)

    def _set(self, way: int) -> None:
        self.desk.items()[self.chosen].step(way)

    def _cancel(self) -> None:
        """What takes long is not wanted any more; the picture stays."""
        for purpose in self.known.doing:
            self.live.cancel(purpose)

    def on_close(self) -> None:
        self.ended.set()
        self.live.close()


def _rest() -> None:
    """Nothing moves: leave the machine to others."""
    time.sleep(0.02)


def opened(path: str, start: Start, args: Sequence[str] = ("--window", "pyglet")) -> None:
    """Show a program in a window until it is closed; `args` are those of moderngl-window, which takes an empty list
    for none and reads the command line of whoever called: there has to be one."""
    moderngl_window.run_window_config(type("Shown", (Window,), {"path": path, "start": start}), args=list(args))
