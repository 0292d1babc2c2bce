"""The window of `pore view --window`, on a screen that nobody sees."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

import porelang
from porelang.analysis.box import Box
from porelang.preview import letters, told
from porelang.preview.heard import Known
from porelang.preview.scene import Wish, scene

pytest.importorskip("moderngl")
from porelang.preview.items import Desk, Item
from porelang.preview.panel import colours, column, notice

ROOT = Path(__file__).parent.parent
#: Opened as a user opens it; keys and frames come from here instead of a hand and a clock.
DRIVER = """
import json, os, sys, time
import moderngl_window
from porelang.preview.live import Start
from porelang.preview.window import Window

path = sys.argv[1]
kind = type("Shown", (Window,), {"path": path, "start": Start({"r": "9mm"}, None, {}), "window_size": (620, 300)})
made = moderngl_window.create_window_config_instance(kind, args=["--window", "pyglet"])
keys = made.wnd.keys


class Plain:
    shift = False


def frames(until):
    end = time.monotonic() + 60
    while not until() and time.monotonic() < end:
        made.wnd.clear()
        made.on_render(0.0, 0.0)
        made.wnd.swap_buffers()
    assert until(), made.known


def seen():
    pixels = made.frames.shown.color_attachments[0].read()
    of_each = list(zip(pixels[::4], pixels[2::4], pixels[3::4]))
    return sum(a > 127 for _, _, a in of_each), sum(b > r + 20 and a > 0 for r, b, a in of_each)


def press(key, there):
    # the full picture of a scene that is as it is to be: others are under way
    made.on_key_event(key, keys.ACTION_PRESS, Plain)
    frames(lambda: there(made.drawing.scene))
    count = made.frames.pictures
    made.frames.moved = True
    frames(lambda: made.frames.pictures > count)


frames(lambda: made.frames.pictures > 0)
found = {"first": seen(), "picture": made.frames.shown.size, "r": made.known.params[0]["value"]}
press(keys.PERIOD, lambda scene: scene.stage.hi[0] > 9.4)
found |= {"larger": seen(), "r2": made.known.params[0]["value"]}
made.on_mouse_drag_event(0, 0, 40, 10)
press(keys.X, lambda scene: scene.plane is not None)
found |= {"section": seen(), "words": sorted(made.words)}
# the mouse takes the slider of the radius to its lower end
top, bottom = made.column.rows[0]
made.on_mouse_press_event(made.column.left + 60, bottom - 4, made.wnd.mouse.left)
made.on_mouse_drag_event(made.column.left, bottom - 4, -60, 0)
made.on_mouse_release_event(made.column.left, bottom - 4, made.wnd.mouse.left)
press(keys.H, lambda scene: scene.stage.hi[0] < 6.5)
found |= {"r3": made.known.params[0]["value"], "wide": made.frames.shown.size}
frames(lambda: made.known.head == "measures of part")
found |= {"measures": made.known.rows, "checks": made.known.checks, "section": seen()}
open(path, "w").write("sphere(")
frames(lambda: bool(made.known.wrong.get("text")))
found |= {"wrong": made.known.wrong.get("text"), "kept": seen()}
os.remove(path)
frames(lambda: bool(made.known.wrong.get("file")))
found |= {"gone": made.known.wrong.get("file")}
made.on_close()
print(json.dumps(found))
"""


#: The command line as it is; the window is closed by itself when a picture was drawn.
COMMAND = """
import sys
from porelang.cli import main
from porelang.preview.window import Window

render = Window.on_render


def once(self, time, frame_time):
    render(self, time, frame_time)
    if self.frames.pictures:
        print("drawn", self.wnd.title, flush=True)
        self.wnd.close()


Window.on_render = once
sys.exit(main(sys.argv[1:]))
"""
TEXT = """param r = 8mm in 5mm..15mm step 0.5mm "its radius"
check r > 5.5mm, "it is large"
out part = sphere(r) & gyroid(6)
"""


def on_a_screen(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A script of Python, on a screen that nobody sees."""
    pytest.importorskip("moderngl_window")
    if not shutil.which("xvfb-run"):
        if os.environ.get("PORELANG_TEST_BROWSER") == "required":
            pytest.fail("PORELANG_TEST_BROWSER is required, and there is no Xvfb", pytrace=False)
        pytest.skip("no Xvfb here")
    command = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24", sys.executable, "-c", script, *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=180, check=False)


@pytest.mark.slow
@pytest.mark.parametrize("order", ["first", "last"])
def test_the_command_opens_a_window(tmp_path: Path, order: str) -> None:
    path = tmp_path / "ball.pore"
    path.write_text("sphere(5)\n")
    arguments = ["--window", str(path)] if order == "first" else [str(path), "--set", "r=5", "--window"]
    if order == "last":
        path.write_text(TEXT)
    done = on_a_screen(COMMAND, "view", *arguments)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "drawn ball.pore\n"
    assert "usage" not in done.stderr


@pytest.mark.slow
def test_a_window_shows_the_part(tmp_path: Path) -> None:
    path = tmp_path / "ball.pore"
    path.write_text(TEXT)
    done = on_a_screen(DRIVER, str(path))
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["picture"] == [320, 300]  # beside the column
    assert found["wide"] == [620, 300]  # and without it
    assert found["words"] == ["colours", "column"]
    assert found["r3"] == 5
    assert [name for name, _, _ in found["measures"]][:2] == ["size", "volume"]
    assert found["checks"][0][:2] == ["it is large", False]
    assert found["first"][0] > 5000
    assert (found["r"], found["r2"]) == (9, 9.5)
    assert found["larger"][0] > found["first"][0]
    assert found["first"][1] < 50
    assert found["section"][1] > 1000  # the field beside the part is blue
    assert "E005" in found["wrong"]
    assert found["gone"].startswith("ball.pore is no longer there")
    assert found["kept"] == found["section"]


# ---- what stands beside the picture ---------------------------------------------------------------------------------


class Told:
    """In place of a program: what it is told to do."""

    def __init__(self) -> None:
        self.words: list[Any] = []

    def set(self, settings: Any) -> None:
        self.words.append(settings)

    def preset(self, name: str) -> None:
        self.words.append(name)

    def show(self, wish: Wish) -> None:
        self.words.append(wish)


def desk() -> tuple[Desk, Told]:
    known = Known()
    program = porelang.compile(
        'param w = 2cm in 1cm..4cm\nparam kind = gyroid in {gyroid, schwarz_p}\npreset "small": w = 1cm\n'
        "let heat = x\nout part = kind(w) & sphere(10)\nout foot = sphere(3)"
    )
    known.hear({"say": "program", "file": "a.pore", "wrong": [], **told.described(program, {})})
    live = Told()
    return Desk(live, known, stage=Box((-10.0,) * 3, (10.0,) * 3), drawn=("part",)), live  # type: ignore[arg-type]


def test_all_that_is_set_is_listed_and_stepped() -> None:
    made, live = desk()

    def item(name: str) -> Item:
        return next(i for i in made.items() if i.name == name)

    assert [i.name for i in made.items()] == ["preset", "w", "kind", "part", "foot", "colours", "section"]
    assert (item("w").value, item("w").share) == ("2 cm", pytest.approx(1 / 3))
    assert "1 to 4 cm" in item("w").more
    put = item("w").put
    assert put is not None
    put(2.0)  # beyond its end
    assert live.words.pop() == {"w": 40.0}
    item("w").step(1)
    assert live.words.pop() == {"w": 40.0}
    item("kind").step(-1)
    assert live.words.pop() == {"kind": "schwarz_p"}
    item("preset").step(1)
    assert live.words.pop() == ""
    item("preset").step(1)
    assert live.words.pop() == "small"
    item("foot").step(1)
    assert live.words.pop() == Wish(("part", "foot"))
    item("part").step(1)
    item("foot").step(1)  # the last one stays
    assert live.words.pop() == Wish(("foot",))
    item("colours").step(1)
    assert live.words.pop().paint == "heat"
    item("section").step(1)
    assert live.words.pop() == Wish(("foot",), "heat", True)
    item("section x").step(1)
    assert made.section.offset == pytest.approx(0.4)
    item("field on it").step(1)
    assert live.words.pop() == Wish(("foot",), "heat", False)


def test_the_words_of_a_window_are_those_of_the_page() -> None:
    known = Known()
    known.hear({"say": "refused", "of": "measure", "text": "error"})
    known.hear({"say": "unmeasured"})
    assert (known.head, known.old, known.wrong["measure"]) == ("", True, "")
    known.hear({"say": "measuring", "output": "part"})
    assert (known.head, known.old) == ("measuring part ...", True)
    rows = [["volume", "3.0 mm3", "+- 0.1 mm3"], ["bounds_of", "", ""], ["size", "1 x 1 x 1 mm", "+- 0.1 mm"],
            ["porosity(a, b)", "0.5", "+- 0.1"]]  # fmt: skip
    known.hear({"say": "measured", "output": "part", "rows": rows})
    assert known.rows == [("volume", "3.0 mm3", "+- 0.1 mm3"), ("size", "1 x 1 x 1 mm", ""),
                          ("porosity(a, b)", "0.5", "+- 0.1")]  # fmt: skip
    assert not known.old
    known.hear({"say": "checked", "checks": [{"text": "thick", "holds": None, "why": "0.5 +- 0.1"}]})
    assert known.checks == [("thick", None, "0.5 +- 0.1")]
    shown = column(known, [], 0, 100)
    assert shown.image.width == 300
    # from the moment of a change all that was measured and checked is grey
    known.hear({"say": "checked", "checks": [{"text": "thick", "holds": True, "why": ""}]})
    green = np.asarray(column(known, [], 0, 100).image).astype(int)
    known.hear({"say": "unmeasured"})
    assert known.head == "measures: not of this part yet"
    grey = np.asarray(column(known, [], 0, 100).image).astype(int)
    assert (green[..., 1] > green[..., 0] + 40).sum() > 20
    assert (grey[..., 1] > grey[..., 0] + 40).sum() == 0
    known.hear({"say": "doubts", "doubts": ["warning"], "notes": ["stresses err by 8%"], "marks": []})
    assert known.doubts == ["stresses err by 8%", "warning"]


def test_letters_are_of_one_width(monkeypatch: pytest.MonkeyPatch) -> None:
    for known in (letters.KNOWN, ()):  # and where no such font is there
        monkeypatch.setattr(letters, "KNOWN", known)
        letters.font.cache_clear()
        _, cell = letters.font(13)
        ends = []
        for text in ("iiii|", "MMMM|"):
            page = Image.new("L", (200, 30), 0)
            letters.written(ImageDraw.Draw(page), (0, 0), text, 255, 13)  # type: ignore[arg-type]
            ends.append(np.flatnonzero(np.asarray(page).max(axis=0))[-1])
        assert ends[0] == ends[1]
        assert 4 * cell < ends[0] < 5 * cell
    letters.font.cache_clear()


def test_messages_keep_their_columns_and_words() -> None:
    text = "error: something\n   |\n12 | let q = z + nothere\n   |             ^^^^^^^ nothing is called so"
    assert letters.broken(text, 80) == text.splitlines()
    assert letters.broken(text, 32)[-2:] == ["   |             ^^^^^^^ nothing", "    is called so"]
    assert letters.broken("x" * 20, 12) == ["x" * 12, "    " + "x" * 8]


def test_what_is_wrong_covers_two_fifths_at_most() -> None:
    text = "\n".join(f"line {i}" for i in range(80))
    made = notice(text, (400, 300))
    assert made.height <= 120
    assert made.width <= 400
    assert notice("error: x", (400, 300)).width < 120


def test_colours_have_their_numbers_and_unit() -> None:
    program = porelang.compile("let heat = 20 + x\nout part = sphere(10)")
    made = scene(program.design(), Wish((), "heat"))
    shown = colours(made, (640, 480))
    assert shown is not None
    pixels = np.asarray(shown)
    assert pixels.shape[0] == 480
    assert (pixels[120:360, :30, 3] == 255).any()  # the bar
    assert (pixels[:, 26:, :3].max(axis=2) < 60)[pixels[:, 26:, 3] > 200].any()  # ink beside it
    assert (pixels[..., :3] <= pixels[..., 3:]).all()  # premultiplied
    assert colours(made, (100, 60)) is None
    assert colours(scene(program.design()), (640, 480)) is None


def test_what_takes_long_is_cancelled() -> None:
    pytest.importorskip("moderngl_window")
    from porelang.preview.window import Window

    known, cancelled = Known(), []
    for purpose in ("scene", "measure"):
        known.hear({"say": "doing", "of": purpose, "what": "solving", "share": 0.1})
    Window._cancel(SimpleNamespace(known=known, live=SimpleNamespace(cancel=cancelled.append)))  # type: ignore[arg-type]
    assert cancelled == ["scene", "measure"]
    # and says of what the picture is; outputs and colours are those again
    known.hear({"say": "stopped", "of": "scene", "text": "Cancelled. The picture is as before: r = 5mm.", "wish": {}})
    assert known.wrong["scene"].startswith("Cancelled. The picture is as before")
    made, _ = desk()
    made.outputs, made.paint = ("foot",), "heat"
    made.wished(["part"], "", plane=False)
    assert (made.outputs, made.paint, made.plane) == (("part",), "", True)  # there is no section that showed none
    known.hear({"say": "done", "of": "scene"})
    assert known.doing == {"measure": "solving 10%"}
