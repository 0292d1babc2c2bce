"""The page of `pore view` in a real browser: Chromium without a window, WebGL on software."""

from __future__ import annotations

import asyncio
import base64
import io
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import uvicorn
from numpy.typing import NDArray
from PIL import Image

import porelang
from porelang.preview.live import Start
from porelang.preview.scene import ROOM
from porelang.preview.server import application, door, server_of
from porelang.render.camera import Camera, look

pytestmark = pytest.mark.slow
BROWSER = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
REQUIRED = os.environ.get("PORELANG_TEST_BROWSER") == "required"
PART = """param r = 10mm in 5mm..14mm "its radius"
param kind = gyroid in {gyroid, schwarz_p}
let high = z + 3mm
out part = (kind(8) |> shell(0.7)) & sphere(r)
out foot = box([24, 24, 2]) |> translate([0, 0, -13])
check r > 6mm, "it can be held"
"""
SIZE = (700, 300)


class Page:
    """A browser that looks at a program."""

    def __init__(self, page: Any, path: Path, port: int) -> None:
        self.page, self.path, self.port = page, path, port
        self.wrong: list[str] = []
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        page.on("console", lambda said: self.wrong.append(said.text) if said.type == "error" else None)

    def drawn(self) -> int:
        return int(self.page.get_attribute("#view", "data-drawn") or 0)

    def after(self, act: Callable[[], object]) -> NDArray[np.uint8]:
        """Do something, and give the full picture (height, width, 4) that is drawn then, top row first."""
        before = self.drawn()
        act()
        self.until(lambda: self.drawn() > before)
        while True:
            self.until(lambda: not self.changes())  # a scene may follow what the page does at once
            found = self.picture()
            if not self.coarse(found.shape[1]):
                return found

    def changes(self) -> bool:
        """Whether something is being drawn, or will be within a moment."""
        before = self.drawn()
        self.page.wait_for_timeout(300)
        small = self.coarse(self.page.evaluate("document.getElementById('view').width"))
        return bool(small or self.drawn() > before or self.page.is_visible("#doing"))

    def coarse(self, width: int) -> bool:
        return width < int(self.page.evaluate("document.getElementById('view').clientWidth"))

    def until(self, holds: Callable[[], bool], seconds: float = 60) -> None:
        end = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < end, self.page.inner_text("body")
            self.page.wait_for_timeout(20)

    def picture(self) -> NDArray[np.uint8]:
        url = self.page.evaluate("document.getElementById('view').toDataURL()")
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2]))).convert("RGBA"))

    def shows(self, known: NDArray[np.uint8]) -> bool:
        """Whether the picture is one that is known: it has another shape while it is coarse."""
        now = self.picture()
        return now.shape == known.shape and bool((now == known).all())

    def slide(self, of: str, value: float) -> None:
        self.page.eval_on_selector(of, "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", str(value))


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    if not BROWSER:
        if REQUIRED:
            pytest.fail("PORELANG_TEST_BROWSER is required, and there is no Chromium", pytrace=False)
        pytest.skip("no Chromium here")
    with playwright.sync_playwright() as started:
        # software WebGL; root has no sandbox
        opened = started.chromium.launch(executable_path=BROWSER, args=["--use-angle=swiftshader", "--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, int]]:
    path = tmp_path_factory.mktemp("page") / "part.pore"
    path.write_text(PART, encoding="utf-8")
    opened, port = door()
    server = server_of(application(str(path), "token", port))
    thread = threading.Thread(target=lambda: asyncio.run(server.serve([opened])), daemon=True)
    thread.start()
    yield path, port
    server.should_exit = True
    thread.join(10)


@pytest.fixture
def page(browser: Any, served: tuple[Path, int]) -> Iterator[Page]:
    path, port = served
    path.write_text(PART, encoding="utf-8")
    opened = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
    made = Page(opened, path, port)
    opened.goto(f"http://127.0.0.1:{port}/token/?stats&refine=0")
    made.until(lambda: made.drawn() > 0 and not made.changes())  # the better scene is there too
    yield made
    opened.close()
    assert made.wrong == []


def silhouette(program: porelang.Program, name: str, camera: Camera, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether a ray meets the solid, from samples in float64 a tenth of a mm apart, and nothing else."""
    box = program.bounds(name)
    field = program.field(name)
    origin, way = camera.rays(size, slice(0, size[1]))
    reach = np.linalg.norm(np.subtract(box.hi, box.lo)) / 2 + 0.1
    middle = np.add(box.lo, box.hi) / 2
    nearest = ((middle - origin) * way).sum(axis=-1)
    hit = np.zeros(nearest.shape, bool)
    aside = np.linalg.norm(origin + nearest[..., None] * way - middle, axis=-1)
    within = np.sqrt(np.maximum(reach**2 - aside**2, 0.0))  # half of the way through a ball around it
    for t in np.arange(-reach, reach, 0.1):
        left = ~hit & (np.abs(t) < within)
        hit[left] = field((origin + (nearest + t)[..., None] * way)[left]) <= 0
    return hit


def rim(shape: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pixels beside one of the other kind."""
    wide = np.pad(shape, 1, mode="edge")
    near = [wide[1 + a : wide.shape[0] - 1 + a, 1 + b : wide.shape[1] - 1 + b] for a in (-1, 0, 1) for b in (-1, 0, 1)]
    return ~np.all([n == shape for n in near], axis=0)


def test_the_picture_is_the_part(page: Page) -> None:
    """Its outline is that of samples along each ray, but for pixels at the rim: no step passes over anything."""
    program = porelang.compile(PART)
    for view, angles in (("iso", (-45.0, 35.2644)), ("front", (-90.0, 0.0))):
        got = page.after(lambda view=view: page.page.click(f"#views button:has-text('{view}')"))  # type: ignore[misc]
        size = got.shape[1], got.shape[0]
        camera = look(program.bounds("part").grown(ROOM), angles, size, "perspective", 1.0)
        seen, known = got[..., 3] > 127, silhouette(program, "part", camera, size)
        differ = seen != known
        assert known.mean() > 0.1
        assert differ.mean() < 0.005, view
        assert not (differ & ~rim(known)).any(), view


def test_dragging_turns_it_and_keys_do_too(page: Page) -> None:
    first = page.picture()
    box = page.page.locator("#view").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    turned = page.after(lambda: (page.page.mouse.move(x + 50, y - 20, steps=3), page.page.mouse.up()))
    assert (turned != first).any(axis=-1).mean() > 0.05
    page.page.focus("#view")
    again = page.after(lambda: page.page.keyboard.press("1"))
    assert (again == first).all()
    near = page.after(lambda: page.page.keyboard.press("+"))
    assert (near[..., 3] > 0).sum() > 1.1 * (first[..., 3] > 0).sum()


def test_a_slider_changes_the_part_and_no_shader(page: Page) -> None:
    first = page.picture()
    compiled = page.page.evaluate("performance.getEntriesByName('compiled').length")
    smaller = page.after(lambda: page.slide("#param-r", 6))
    assert 0 < (smaller[..., 3] > 0).sum() < 0.6 * (first[..., 3] > 0).sum()
    assert page.page.input_value("input[aria-label='r in mm']") == "6"
    assert page.page.evaluate("performance.getEntriesByName('compiled').length") == compiled == 1
    page.page.select_option("#param-kind", "schwarz_p")
    page.until(lambda: "fails" in (page.page.get_attribute("#checks li", "class") or ""))
    assert "r = 6mm" in page.page.inner_text("#checks")
    page.until(lambda: page.page.text_content("#measures-head") == "Measures of part")
    assert page.page.get_attribute("#checks", "class") == page.page.get_attribute("#rows", "class") == ""
    assert page.page.inner_text("#rows dd.of").startswith("of the shape")
    heights = page.page.locator("#rows dd:not(.of)").evaluate_all("all => all.map(e => e.clientHeight)")[1:]
    assert max(heights) < 1.5 * min(heights)  # a number and its unit are in one line
    labels = page.page.locator("#rows dt")  # and none is cut
    assert not any(labels.evaluate_all("all => all.map(e => e.scrollWidth > e.clientWidth)"))


def test_numbers_have_units_and_the_address_keeps_what_is_set(page: Page, browser: Any) -> None:
    box, of = page.page, "input[aria-label='r in mm']"

    def enter(text: str) -> None:
        box.fill(of, text)
        box.press(of, "Enter")

    enter("0.8cm")
    page.until(lambda: box.input_value(of) == "8")
    box.press(of, "ArrowUp")
    assert box.input_value(of) == "8.02"
    for text, code in (("99", "E085"), ("1e999", "E084"), ("thick", "E084"), ("8", "")):
        enter(text)
        page.until(lambda code=code: code in box.inner_text("#said") and box.is_visible("#said") == bool(code))  # type: ignore[misc]
        assert box.input_value(of) == ("8.02" if code else "8")
        assert box.input_value("#param-r") == box.input_value(of)  # the slider says the same
    box.select_option("#param-kind", "schwarz_p")
    box.check("#output-1")
    box.fill("#paint", "high")
    box.press("#paint", "Enter")
    page.until(lambda: box.is_visible("#legend"))
    box.click("#across-y")
    box.click("#views button:has-text('front')")
    box.click("#projection")
    page.until(lambda: "parallel" in box.evaluate("location.hash"))
    other = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
    try:
        other.goto(box.url)
        second = Page(other, page.path, page.port)
        second.until(lambda: second.drawn() > 0 and not second.changes())
        assert other.input_value(of) == "8"
        assert (other.input_value("#param-kind"), other.input_value("#paint")) == ("schwarz_p", "high")
        assert other.get_attribute("#view", "data-outputs") == "part foot"
        assert other.get_attribute("#projection", "aria-pressed") == "true"
        page.until(lambda: not page.changes())
        assert (second.picture() == page.picture()).mean() > 0.999
        assert other.evaluate("location.hash") == box.evaluate("location.hash")
        other.goto(
            f"{box.url.partition('#')[0]}#p.r=1000&p.kind=none&paint=nonsense(&cut=q<<&eye=1,x&at=-1,0,0,0&outputs=,&p"
        )
        # the page is loaded anew by itself
        second.until(lambda: other.locator(of).count() == 1 and other.input_value(of) == "10" and second.drawn() > 0)
        assert not other.is_visible("#said")
    finally:
        other.close()
    assert second.wrong == []


def test_a_broken_program_keeps_its_picture_under_what_is_wrong(page: Page) -> None:
    first = page.picture()
    page.slide("#param-r", 12)
    page.path.write_text(PART.replace("sphere(r)", "sphere(r"), encoding="utf-8")
    page.until(lambda: page.page.is_visible("#said"))
    assert "E005" in page.page.inner_text("#said")
    code = page.page.locator("#said .code").evaluate_all("all => all.map(e => [e.textContent, e.clientHeight])")
    assert any("^" in text for text, _ in code)
    assert len({height for _, height in code}) == 1  # none is wrapped: marks stand below what they mean
    assert (page.picture()[..., 3] > 0).any()
    other = page.path.with_suffix(".saved")
    other.write_text(PART.replace("+ 3mm", "+ 4mm"), encoding="utf-8")
    other.replace(page.path)
    page.until(lambda: not page.page.is_visible("#said"))
    assert page.page.input_value("#param-r") == "12"
    page.until(lambda: page.picture().shape == first.shape)
    page.until(lambda: (page.picture()[..., 3] > 0).mean() > 1.1 * (first[..., 3] > 0).mean())


def test_a_section_with_the_field_on_it(page: Page) -> None:
    first = page.picture()
    cut = page.after(lambda: page.page.click("#across-x"))
    red = (cut[..., 0] > cut[..., 1] + 40) & (cut[..., 3] > 0)
    assert red.sum() > 200  # the cut face
    moved = page.after(lambda: page.slide("#offset", 4))
    assert (moved != cut).any()
    for text in ("5,5", "1.5.2", "1kg", "abc", "1e999"):
        page.page.fill("#offset-number", text)
        page.page.press("#offset-number", "Enter")
        assert f"`{text}` is no place of the section" in page.page.inner_text("#said")
        assert page.page.input_value("#offset-number") == "4"
    page.page.fill("#offset-number", "0.2cm")
    page.page.press("#offset-number", "Enter")
    assert page.page.input_value("#offset-number") == "2"
    assert not page.page.is_visible("#said")
    page.page.fill("#offset-number", "500")
    page.page.press("#offset-number", "Enter")
    assert page.page.is_visible("#offset-beyond")
    assert float(page.page.input_value("#offset-number")) == pytest.approx(10, abs=0.1)
    page.after(lambda: page.slide("#offset", 4.0004123))
    assert page.page.input_value("#offset-number") == "4"
    assert not page.page.is_visible("#offset-beyond")
    coloured = page.after(lambda: page.page.click("#plane"))
    blue = (coloured[..., 2].astype(int) > coloured[..., 0] + 30) & (coloured[..., 3] > 0)
    assert blue.sum() > 200  # beside the part its field is positive
    assert "part" in page.page.inner_text("#legend")
    page.page.evaluate("""() => {
        const gl = WebGL2RenderingContext.prototype, read = gl.readPixels;
        window.labels = [];
        gl.readPixels = function (...all) {
          labels.push(document.getElementById("legend").getAttribute("aria-label"));
          return read.apply(this, all);
        };
    }""")
    page.page.fill("#paint", "high")
    by_height = page.after(lambda: page.page.press("#paint", "Enter"))
    labels = page.page.evaluate("labels")
    assert labels[0].startswith("Colours of part")  # until there is a picture: it is what is waited for here
    assert labels[-1].startswith("Colours of high")
    assert (by_height != coloured).any()
    assert page.page.get_attribute("#legend", "aria-label").startswith("Colours of high")
    page.page.fill("#paint", "nothing_such")
    page.page.press("#paint", "Enter")
    page.until(lambda: "E100" in page.page.inner_text("#said"))
    assert "The picture is as before: the colours of `high`." in page.page.inner_text("#said")
    page.page.fill("#paint", "")
    page.page.press("#paint", "Enter")
    page.until(lambda: not page.page.is_visible("#said"))
    page.page.click("#across-none")
    page.until(lambda: page.shows(first))


def test_what_the_panel_says_is_what_is_set(page: Page) -> None:
    box, of = page.page, "#param-r-number"
    box.evaluate("""() => {
        const line = WebSocket.prototype, send = line.send;
        window.sent = [];
        line.send = function (text) { sent.push(JSON.parse(text)); return send.call(this, text); };
    }""")
    box.fill(of, "8")
    box.press(of, "Enter")
    box.click("h1")  # a browser may tell of the change once more
    page.until(lambda: box.evaluate("location.hash") == "#p.r=8")
    assert box.evaluate("sent") == [{"do": "set", "settings": {"r": 8}}]
    assert box.get_attribute("#checks", "class") == box.get_attribute("#rows", "class") == "old"
    assert "not of this part yet" in box.text_content("#measures-head")
    # what is taken away while somebody writes there sets nothing, and the cursor is where it was
    box.fill(of, "7")
    page.path.write_text(PART.replace("+ 3mm", "+ 4mm"), encoding="utf-8")
    page.until(lambda: box.input_value(of) == "8")
    assert box.evaluate("document.activeElement.id") == "param-r-number"
    assert len(box.evaluate("sent")) == 1
    # what was set before a preset is told before it
    box.evaluate("""() => {
        const box = document.querySelector("#param-r-number");
        box.value = "9";
        box.onchange();
        document.querySelector("#defaults").click();
    }""")
    page.until(lambda: box.input_value(of) == "10" and box.evaluate("location.hash") == "")
    assert [word["do"] for word in box.evaluate("sent")] == ["set", "set", "preset"]
    # what is nowhere a number gives no colours
    box.fill("#paint", "x / 0")
    box.press("#paint", "Enter")
    page.until(lambda: "nowhere a number" in box.inner_text("#legend"))
    assert box.locator("#legend canvas").count() == 0


def test_what_cannot_be_saved_is_told_until_it_is(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "part.pore"
    text = "param r = 5mm in 2mm..9mm\nout part = sphere(r)\n"
    path.write_text(text, encoding="utf-8")
    opened, port = door()
    server = server_of(application(str(path), "token", port, Start({"r": "7mm"}, None, {})))
    thread = threading.Thread(target=lambda: asyncio.run(server.serve([opened])), daemon=True)
    thread.start()
    made = Page(browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}), path, port)
    box = made.page
    box.on("dialog", lambda asked: asked.accept())
    try:
        box.goto(f"http://127.0.0.1:{port}/token/?refine=0")
        made.until(lambda: box.evaluate("location.hash") == "#p.r=7")
        box.click("#defaults")  # and no reload brings 7 back
        made.until(lambda: box.evaluate("location.hash") == "#p.r=5")
        box.click("#open")
        box.wait_for_selector("#editor .cm-content")
        path.chmod(0o444)
        box.keyboard.press("Control+End")
        box.keyboard.type("param q = 3mm in 2mm..4mm")
        box.keyboard.press("Control+s")
        made.until(lambda: "E113" in box.inner_text("#said"))
        made.until(lambda: box.locator("#param-q").count() == 1)  # the text is known meanwhile
        assert "E113" in box.inner_text("#said")
        path.chmod(0o644)
        box.keyboard.press("Control+s")
        made.until(lambda: box.inner_text("#state") == "saved" and not box.is_visible("#said"))
        saved = path.read_text(encoding="utf-8")

        # a text that is too long to be sent
        box.locator(".cm-content").evaluate("""e => {
            const clipboardData = new DataTransfer();
            clipboardData.setData("text/plain", "\\n" + `# ${"x".repeat(97)}\\n`.repeat(10600));
            e.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
        }""")
        made.until(lambda: "longer than 1 MB" in box.inner_text("#said"))
        box.keyboard.press("Control+s")
        assert box.inner_text("#state") == "Nothing was saved: it is longer than 1 MB"
        box.keyboard.press("Control+z")
        made.until(lambda: not box.is_visible("#said"))  # nor was the line ended
        assert path.read_text(encoding="utf-8") == saved

        # a file that nobody has read is not saved empty
        path.unlink()
        box.reload()
        made.until(lambda: "is no longer there. Nothing of it is known here" in box.inner_text("#said"))
        box.click("#open")
        box.wait_for_selector("#editor .cm-content")
        assert box.is_disabled("#save")
        box.keyboard.press("Control+s")
        path.write_text(saved, encoding="utf-8")
        made.until(lambda: box.locator("#param-q").count() == 1 and not box.is_visible("#said"))
        assert path.read_text(encoding="utf-8") == saved
        assert box.input_value("#param-r") == "5"
    finally:
        box.close()
        server.should_exit = True
        thread.join(20)
    assert made.wrong == []


def test_several_outputs_are_shown_in_their_colours(page: Page) -> None:
    both = page.after(lambda: page.page.check("#output-1"))
    orange = (both[..., 0] > 150) & (both[..., 2] < 90) & (both[..., 3] > 0)
    assert orange.sum() > 200
    assert page.page.get_attribute("#view", "data-outputs") == "part foot"


def test_outputs_and_angles_are_what_was_asked_for(page: Page) -> None:
    """Two boxes that are ticked one after the other, before a picture is there; and an angle that comes back to 0."""
    page.after(lambda: page.path.write_text(
        "param a = 0deg in -90deg..90deg step 15deg\nout part = rotate(box([9, 4, 4]), [0, 0, 1], a)\n"
        "out b = sphere(3) |> translate([0, 9, 0])\nout c = sphere(3) |> translate([0, -9, 0])\n"
    ))  # fmt: skip
    click = "(some) => { for (const k of some) document.getElementById(`output-${k}`).click(); }"
    page.after(lambda: page.page.evaluate(click, [1, 2]))
    assert page.page.get_attribute("#view", "data-outputs") == "part b c"
    page.after(lambda: page.page.evaluate(click, [0, 2]))
    assert page.page.get_attribute("#view", "data-outputs") == "b"
    page.page.focus("#param-a")
    for key in ("ArrowRight", "ArrowLeft"):
        page.page.keyboard.press(key)
    assert page.page.input_value("#param-a-number") == "0"
    page.until(lambda: "p.a=" not in page.page.evaluate("location.hash"))
    assert page.wrong == []


def test_a_mesh_and_a_picture_can_be_had(page: Page) -> None:
    page.page.fill("#voxel", "0.3mm")
    page.page.click("#export")
    page.page.wait_for_selector("#made a")
    with page.page.expect_download() as download:
        page.page.click("#made a")
    assert download.value.suggested_filename == "part-part.stl"
    assert Path(download.value.path()).stat().st_size > 10_000
    page.slide("#param-r", 9)
    assert page.page.locator("#made a").count() == 0  # it was of the part before
    with page.page.expect_download() as download:
        page.page.click("#picture")  # while a coarse one is shown
    size = page.page.eval_on_selector("#view", "(e) => [e.clientWidth, e.clientHeight]")
    assert Image.open(download.value.path()).size == tuple(size)


def test_a_mesh_that_lost_much_can_be_had_all_the_same(page: Page) -> None:
    page.page.fill("#voxel", "1mm")
    page.page.click("#export")
    page.page.wait_for_selector("#said-again")
    assert "--" not in page.page.inner_text("#said").replace("-->", "")
    page.page.click("#said-again")
    page.page.wait_for_selector("#made a")
    assert not page.page.is_visible("#said")


def test_a_narrow_canvas_shows_all_that_was_seen(page: Page) -> None:
    page.after(lambda: page.page.set_viewport_size({"width": 660, "height": 800}))
    page.until(lambda: page.picture().shape[0] == 800)
    edges = page.picture()[:, [0, -1], 3]
    assert not edges.any()


def test_a_page_finds_its_way_back_with_its_text(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "part.pore"
    path.write_text("param r = 5mm in 2mm..9mm\nsphere(r)\n", encoding="utf-8")
    opened, port = door()

    def serve(token: str) -> tuple[uvicorn.Server, threading.Thread]:
        server = server_of(application(str(path), token, port))
        at = opened if opened.fileno() >= 0 else door(port)[0]
        thread = threading.Thread(target=lambda: asyncio.run(server.serve([at])), daemon=True)
        thread.start()
        return server, thread

    def stop(server: uvicorn.Server, thread: threading.Thread) -> None:
        server.should_exit = True
        thread.join(20)
        opened.close()

    running = serve("token")
    made = Page(browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}), path, port)
    try:
        made.page.goto(f"http://127.0.0.1:{port}/token/?refine=0")
        made.until(lambda: made.drawn() > 0)
        made.slide("#param-r", 7)
        made.page.click("#open")
        made.page.wait_for_selector("#editor .cm-content")
        made.page.keyboard.press("Control+End")
        made.page.keyboard.type("# mine")
        made.until(lambda: made.page.inner_text("#state") == "not saved")
        stop(*running)
        made.until(lambda: f"--port {port}" in made.page.inner_text("#said"))
        assert "Your text is not saved" in made.page.inner_text("#said")
        made.page.keyboard.press("Control+s")
        assert "Nothing was saved" in made.page.inner_text("#state")
        running = serve("another")  # a page gives its token only to who knows it
        made.until(lambda: "is not of this page" in made.page.inner_text("#said"))
        stop(*running)
        theirs = "param r = 5mm in 2mm..9mm\nsphere(r)  # theirs\n"
        path.write_text(theirs, encoding="utf-8")  # meanwhile
        running = serve("token")
        made.until(lambda: not made.page.is_visible("#said"))
        assert made.page.inner_text("#state") == "not saved"
        made.until(lambda: made.page.is_visible("#conflict"))
        made.page.keyboard.press("Control+s")
        assert path.read_text(encoding="utf-8") == theirs
        made.page.click("#ours")
        made.until(lambda: made.page.inner_text("#state") == "saved")
        mine = path.read_text(encoding="utf-8")
        assert mine.endswith("# mine")
        assert made.page.input_value("#param-r") == "7"
        made.page.click(".cm-content")
        made.page.keyboard.type("# more")
        made.until(lambda: made.page.inner_text("#state") == "not saved")
        path.write_text(theirs, encoding="utf-8")
        made.until(lambda: made.page.is_visible("#conflict"))
        made.page.click("#theirs")
        made.until(lambda: "# theirs" in made.page.inner_text(".cm-content"))
        assert made.page.inner_text("#state") == "saved"
        assert "# more" not in made.page.inner_text(".cm-content")
        path.write_text(mine, encoding="utf-8")
        made.until(lambda: "# mine" in made.page.inner_text(".cm-content"))
    finally:
        made.page.close()
        stop(*running)
