"""The window of `pore view --window`, on a screen that nobody sees."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
#: Opened as a user opens it; keys and frames come from here instead of a hand and a clock.
DRIVER = """
import json, sys, time
import moderngl_window
from porelang.preview.live import Start
from porelang.preview.window import Window

path = sys.argv[1]
kind = type("Shown", (Window,), {"path": path, "start": Start({"r": "9mm"}, None, {}), "window_size": (320, 240)})
made = moderngl_window.create_window_config_instance(kind, args=["-wnd", "pyglet"])
keys = made.wnd.keys


class Plain:
    shift = False


def frames(until):
    end = time.monotonic() + 60
    while not until() and time.monotonic() < end:
        made.wnd.clear()
        made.on_render(0.0, 0.0)
        made.wnd.swap_buffers()
    assert until(), made.told


def seen():
    pixels = made.shown.color_attachments[0].read()
    of_each = list(zip(pixels[::4], pixels[2::4], pixels[3::4]))
    return sum(a > 127 for _, _, a in of_each), sum(b > r + 20 and a > 0 for r, b, a in of_each)


def press(key, there):
    # the full picture of a scene that is as it is to be: others are under way
    made.on_key_event(key, keys.ACTION_PRESS, Plain)
    frames(lambda: there(made.drawing.scene))
    count = made.pictures
    made.moved = True
    frames(lambda: made.pictures > count)


frames(lambda: made.pictures > 0)
found = {"first": seen(), "r": made.params[0]["value"]}
press(keys.PERIOD, lambda scene: scene.stage.hi[0] > 9.4)
found |= {"larger": seen(), "r2": made.params[0]["value"]}
made.on_mouse_drag_event(0, 0, 40, 10)
press(keys.X, lambda scene: scene.plane is not None)
found |= {"section": seen()}
open(path, "w").write("sphere(")
frames(lambda: bool(made.told["text"]))
found |= {"wrong": made.told["text"], "kept": seen()}
made.on_close()
print(json.dumps(found))
"""


#: The command, on its screen; it is closed by a key when its window has the name of the file.
COMMAND = """
"$1" -m porelang view "$2" --window & pid=$!
window=$(timeout 60 xdotool search --sync --name ball.pore) && sleep 3 && xdotool key --window $window Escape
for i in $(seq 200); do kill -0 $pid 2>/dev/null || break; sleep 0.1; done
kill $pid 2>/dev/null && echo still there
wait $pid; echo "ended $?"
"""


def screened(tmp_path: Path, command: list[str]) -> subprocess.CompletedProcess[str]:
    pytest.importorskip("moderngl_window")
    if not shutil.which("xvfb-run"):
        if os.environ.get("PORELANG_TEST_BROWSER") == "required":
            pytest.fail("PORELANG_TEST_BROWSER is required, and there is no Xvfb", pytrace=False)
        pytest.skip("no Xvfb here")
    path = tmp_path / "ball.pore"
    path.write_text('param r = 8mm in 5mm..15mm step 0.5mm "its radius"\nsphere(r) & gyroid(6)\n')
    screen = ["xvfb-run", "-a", "-s", "-screen 0 640x480x24", *command, str(path)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(screen, capture_output=True, text=True, env=environment, timeout=180, check=False)


@pytest.mark.slow
def test_the_command_opens_a_window(tmp_path: Path) -> None:
    done = screened(tmp_path, ["sh", "-c", COMMAND, "sh", sys.executable])
    assert done.stdout.split("\n")[-2] == "ended 0", done.stdout + done.stderr


@pytest.mark.slow
def test_a_window_shows_the_part(tmp_path: Path) -> None:
    done = screened(tmp_path, [sys.executable, "-c", DRIVER])
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["first"][0] > 5000
    assert (found["r"], found["r2"]) == (9, 9.5)
    assert found["larger"][0] > found["first"][0]
    assert found["first"][1] < 50
    assert found["section"][1] > 1000  # the field beside the part is blue
    assert "E005" in found["wrong"]
    assert found["kept"] == found["section"]
