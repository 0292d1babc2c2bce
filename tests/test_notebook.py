"""The viewer in a notebook: traits on both sides, what is seen without widgets, the bundle in a browser, an example."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import shutil
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import porelang
from porelang.diagnostics import PoreError
from porelang.notebook import display, still
from porelang.notebook.magic import load_ipython_extension
from porelang.notebook.slice import slice_picture
from porelang.preview import doing
from porelang.progress import checkpoint

pytest.importorskip("anywidget")
from porelang.notebook.widget import Viewer

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "editors" / "page"
WEB = ROOT / "porelang" / "preview" / "web"
BUNDLE = ROOT / "porelang" / "notebook" / "widget.js"
VIEW = "application/vnd.jupyter.widget-view+json"
BROWSER = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
TEXT = """param r = 10mm in 5mm..14mm "its radius"
param kind = gyroid in {gyroid, schwarz_p}
preset "small": r = 0.6cm
let high = z + 3mm
check r > 0mm, "it is there"
out part = (kind(8) |> shell(0.7)) & sphere(r) & box([40, 40, 16])
out foot = box([24, 24, 2]) |> translate([0, 0, -13])
out none = sphere(1) & box([24, 24, 2]) |> translate([0, 0, -13])
"""


@pytest.fixture(scope="module")
def program() -> porelang.Program:
    return porelang.compile(TEXT, name="knob")


class Heard:
    """A viewer, and what its part in a browser is told."""

    def __init__(self, viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
        self.viewer = viewer
        self.words: list[dict[str, Any]] = []
        self.scenes: list[bytes] = []
        self.states: list[dict[str, Any]] = []
        monkeypatch.setattr(viewer, "send", self._send)
        monkeypatch.setattr(viewer, "_send", lambda message, buffers=None: self.states.append(message["state"]))

    def _send(self, word: dict[str, Any], buffers: Any = None) -> None:
        self.words.append(word)
        self.scenes += buffers or []

    def after(self, act: Callable[[], object]) -> list[dict[str, Any]]:
        """What is told of an act, until all that it began has ended."""
        before = len(self.words)
        act()
        end = time.monotonic() + 60
        while not all(job.done for job in self.viewer._jobs._latest.values()):
            assert time.monotonic() < end, self.words
            time.sleep(0.01)
        return self.words[before:]

    def head(self, which: int = -1) -> Any:
        last = self.scenes[which]
        return json.loads(last[4 : 4 + int.from_bytes(last[:4], "little")])


@pytest.fixture
def heard(program: porelang.Program, monkeypatch: pytest.MonkeyPatch) -> Heard:
    return Heard(program.view(), monkeypatch)


def test_what_is_set_in_the_browser_is_set_here(heard: Heard) -> None:
    viewer = heard.viewer
    assert viewer.settings == {"r": 10.0, "kind": "gyroid"}
    heard.after(lambda: viewer._handle_custom_msg({"do": "begin"}, []))
    assert heard.words[0]["say"] == "program"
    assert [p["name"] for p in heard.words[0]["params"]] == ["r", "kind"]
    large, text = heard.head()["hi"], heard.head(0)["bodies"][0]["text"]
    assert text.startswith("#version 300 es")
    seen: list[Any] = []
    viewer.observe(lambda change: seen.append(change["new"]), "settings")
    heard.after(lambda: viewer.set_state({"settings": {"r": 6, "kind": "gyroid"}}))
    assert seen == [{"r": 6.0, "kind": "gyroid"}] == [viewer.settings]
    assert heard.head()["hi"][0] < 0.7 * large[0]
    assert heard.head()["bodies"][0]["text"] is None  # a slider compiles no shader
    assert viewer.design.settings["r"] == 6
    heard.after(lambda: viewer.set_state({"outputs": ["part", "foot"], "paint": "high", "plane": True}))
    assert [b["name"] for b in heard.head()["bodies"]] == ["part", "foot"]
    heard.after(lambda: viewer._handle_custom_msg({"do": "preset", "name": ""}, []))
    assert viewer.settings["r"] == 10
    heard.after(lambda: viewer._handle_custom_msg({"do": "preset", "name": "small"}, []))
    assert viewer.settings["r"] == 6


def test_what_is_set_here_is_set_in_the_browser(heard: Heard) -> None:
    viewer = heard.viewer
    viewer.settings = {"r": "1.2cm"}
    assert heard.words == []  # nobody looks yet, and nothing is drawn
    assert heard.states[-1]["settings"] == {"r": 12.0, "kind": "gyroid"}
    viewer.cut = "y < 1cm"
    assert heard.states[-1]["cut"] == viewer.cut == "y<10"
    heard.after(lambda: viewer._handle_custom_msg({"do": "begin"}, []))
    told = heard.after(lambda: setattr(viewer, "paint", "high"))
    assert heard.head()["scale"]["shown"] == "high"
    assert {"scene", "done"} <= {word["say"] for word in told}


def test_what_is_wrong_is_told_and_the_last_picture_stays(heard: Heard) -> None:
    viewer = heard.viewer
    heard.after(lambda: viewer._handle_custom_msg({"do": "begin"}, []))
    with pytest.raises(PoreError, match="E085"):
        viewer.settings = {"r": "9cm"}
    assert viewer.settings["r"] == 10
    none: list[tuple[dict[str, Any], str]] = [
        ({"outputs": ["prt"]}, "E100"),
        ({"cut": "sideways"}, "E108"),
        ({"settings": {"r": 99}}, "E085"),
    ]
    for wrong, code in none:
        viewer.set_state(wrong)
        assert code in viewer.wrong
        refused = heard.words[-1]
        assert (refused["say"], refused["of"], refused["text"]) == ("refused", "settings", viewer.wrong)
        (name,) = wrong
        assert heard.states[-1] == {name: getattr(viewer, name)}  # the browser is told what holds
    assert viewer.settings["r"] == 10
    scenes = len(heard.scenes)
    told = heard.after(lambda: viewer.set_state({"paint": "hihg"}))
    assert "did you mean `high`" in next(word["text"] for word in told if word["say"] == "refused")
    assert "did you mean `high`" in viewer.wrong
    assert (viewer.paint, len(heard.scenes)) == ("", scenes)
    told = heard.after(lambda: setattr(viewer, "paint", ""))
    assert viewer.wrong == ""
    assert {"say": "refused", "of": "settings", "text": ""}.items() <= told[0].items()  # nor in the browser
    # what can be set, and not drawn
    heard.after(lambda: setattr(viewer, "outputs", ["part", "none"]))
    assert "E103" in viewer.wrong
    heard.after(lambda: setattr(viewer, "cut", "y<0"))
    assert "E103" in viewer.wrong  # still
    heard.after(lambda: setattr(viewer, "outputs", ["part"]))
    assert viewer.wrong == ""


def test_what_is_cancelled_says_of_what_the_picture_is_and_can_be_had_again(
    heard: Heard, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer = heard.viewer
    heard.after(lambda: viewer._handle_custom_msg({"do": "begin"}, []))
    drawn = doing.draw

    def never(*_: object) -> None:
        while True:
            time.sleep(0.01)
            checkpoint()

    def stopped(act: Callable[[], object]) -> dict[str, Any]:
        monkeypatch.setattr("porelang.preview.seen.draw", never)
        told = heard.after(lambda: (act(), viewer._handle_custom_msg({"do": "cancel"}, [])))
        monkeypatch.setattr("porelang.preview.seen.draw", drawn)
        (word,) = [word for word in told if word["say"] == "stopped"]
        return word

    word = stopped(lambda: setattr(viewer, "settings", {"r": "1.2cm"}))
    assert word["text"] == viewer.wrong == "Cancelled. The picture is as before: r = 10mm."
    assert viewer.settings["r"] == 12
    # the same once more, here or by the button there, is drawn
    for again in (
        lambda: setattr(viewer, "settings", {"r": 12}),
        lambda: viewer._handle_custom_msg({"do": "again"}, []),
    ):
        assert "scene" in {word["say"] for word in heard.after(again)}
        assert viewer.wrong == ""
        assert heard.after(again) == []  # it is there
        heard.after(lambda: setattr(viewer, "settings", {"r": 11}))
        stopped(lambda: setattr(viewer, "settings", {"r": 12}))
    # outputs and colours are those that are seen
    word = stopped(lambda: setattr(viewer, "paint", "high"))
    assert (viewer.paint, word["wish"]) == ("", {"outputs": [], "paint": "", "plane": False})
    # and a refusal says so too
    heard.after(lambda: setattr(viewer, "outputs", ["part", "none"]))
    assert viewer.wrong.endswith("The picture is as before: r = 11mm, `part`.")


def test_every_trait_refuses_what_cannot_be(program: porelang.Program) -> None:
    viewer = program.view()
    cannot: list[tuple[str, Any, str]] = [
        ("cut", "q<0", "`q<0` cuts nothing"),
        ("paint", "nonsense(", "E00"),
        ("paint", "nothere", "nothere"),
        ("height", -5, "-5 pixels"),
        ("height", 100_000, "100000 pixels"),
        ("settings", {"r": 99}, "E085"),
        ("outputs", ["nothere"], "E100"),
    ]
    for name, value, why in cannot:
        before = getattr(viewer, name)
        with pytest.raises(PoreError):
            setattr(viewer, name, value)
        assert getattr(viewer, name) == before
        assert why in viewer.wrong  # of the last one, not of one before
    viewer.plane = True
    assert viewer.wrong == ""
    viewer.height = 300
    with pytest.raises(PoreError, match="nothere"):
        program.view(paint="nothere")


def test_what_is_counted_is_a_whole_number() -> None:
    counted = porelang.compile("param n = 4 in 2..8\nparam r = 5mm in 4mm..9mm\npreset \"many\": n = 8\n"
                               "out part = ring(translate(sphere(r), [20, 0, 0]), n)")  # fmt: skip
    viewer = counted.view(n="6")
    assert [repr(value) for value in viewer.settings.values()] == ["6", "5.0"]
    viewer._handle_custom_msg({"do": "preset", "name": ""}, [])
    assert repr(viewer.settings["n"]) == "4"
    viewer.settings = {"n": 3.0}
    assert repr(viewer.settings["n"]) == "3"


def test_a_viewer_begins_with_what_is_asked(program: porelang.Program) -> None:
    viewer = program.design(r=7).view(["part", "foot"], cut="x>0", plane=True, kind="schwarz_p")
    assert viewer.settings == {"r": 7.0, "kind": "schwarz_p"}
    assert (viewer.outputs, viewer.cut, viewer.plane) == (["part", "foot"], "x>0", True)
    with pytest.raises(PoreError, match="E100"):
        program.view("prt")
    with pytest.raises(PoreError, match="cuts at one"):
        program.view(cut="x>0 & y>0")


def test_what_is_missing_is_told(program: porelang.Program, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "porelang.notebook.widget", None)
    with pytest.raises(PoreError, match=r"pip install 'porelang\[notebook\]'") as caught:
        program.view()
    assert caught.value.diagnostics[0].code == "E126"


# ---- where no widgets run -------------------------------------------------------------------------------------------


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(display, "in_kernel", lambda: True)


PNG = b"\x89PNG not really"


@pytest.mark.usefixtures("kernel")
def test_a_picture_and_the_tables_stand_beside_the_viewer(
    program: porelang.Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(still, "still", lambda *_: PNG)
    for shown in (program, program.design(r=7)):
        data, _ = shown._repr_mimebundle_()
        assert set(data) == {VIEW, "text/html", "image/png", "text/plain"}
        assert base64.b64decode(data["image/png"]) == PNG
        assert data["text/html"].endswith(shown._repr_html_())
        assert data["image/png"] in data["text/html"]
    monkeypatch.setitem(sys.modules, "porelang.notebook.widget", None)
    assert set(program._repr_mimebundle_()[0]) == {"text/html", "image/png", "text/plain"}


@pytest.mark.usefixtures("kernel")
def test_without_a_picture_there_are_tables(program: porelang.Program, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise RuntimeError("no OpenGL")

    monkeypatch.setattr("porelang.render.picture.render_output", fails)
    data, _ = program._repr_mimebundle_()
    assert data["text/html"] == program._repr_html_()
    assert "image/png" not in data
    monkeypatch.setattr("porelang.render.picture.render_output", lambda *_: time.sleep(2))
    monkeypatch.setattr(still, "PATIENCE", 0.05)
    assert still.still(program, {}) == b""
    monkeypatch.setattr(display, "_bundle", fails)
    assert program._repr_mimebundle_() == {}


def test_a_terminal_and_a_number_have_no_viewer(program: porelang.Program, monkeypatch: pytest.MonkeyPatch) -> None:
    assert program._repr_mimebundle_() == {}
    assert program.field("high")._repr_png_() is None
    monkeypatch.setattr(display, "in_kernel", lambda: True)
    assert porelang.compile("out n = 3")._repr_mimebundle_() == {}


def test_a_field_shows_a_slice(program: porelang.Program, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(display, "in_kernel", lambda: True)
    field = porelang.compile("let lean = x + 3mm\nout part = box([20, 10, 20])").field("lean")
    png = field._repr_png_()
    assert png is not None
    shown = np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
    red, blue = shown[100, 20], shown[100, 330]  # to the left lean is negative
    assert red[0] > red[2] + 80
    assert blue[2] > blue[0] + 40
    assert porelang.compile("gyroid(10)").field("part")._repr_png_() is None  # it has no end
    made = porelang.compile("out way = [x, y, z]\nout part = sphere(4)").field("way")
    assert made.of is not None
    assert slice_picture(made, *made.of).startswith(b"\x89PNG")


def test_a_cell_tells_its_own_lines_and_no_others(
    program: porelang.Program, capsys: pytest.CaptureFixture[str]
) -> None:
    known: dict[str, Any] = {}
    shell = SimpleNamespace(user_ns=known, register_magic_function=lambda made, kind, name: known.update({name: made}))
    load_ipython_extension(shell)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        known["pore"]("bowl", "let unread = z\nout part = sphere(3)")
    assert "bowl" in known
    told = capsys.readouterr().err
    assert told.startswith("warning[W220]: nothing reads `unread`\n --> bowl:1:5\n")
    assert ".py" not in told
    with pytest.raises(PoreError) as caught:
        program.view().paint = "nothere"
    lines = caught.value._render_traceback_()
    assert "test_notebook.py" in lines[0]
    assert not any("traitlets" in line for line in lines)


# ---- the bundle -----------------------------------------------------------------------------------------------------


def test_bundle_is_made_of_these_sources() -> None:
    web = (
        "camera.js",
        "controls.js",
        "hands.js",
        "painter.js",
        "section.js",
        "viewer.js",
        "wire.js",
        "page.css",
        "page.html",
    )
    sources = [PAGE / "build.js", PAGE / "package-lock.json", *sorted((PAGE / "widget").iterdir())]
    digest = hashlib.sha256(b"".join(s.read_bytes() for s in [*sources, *(WEB / name for name in web)])).hexdigest()
    assert digest in BUNDLE.read_text(encoding="utf-8").partition("\n")[0], "make page"


MOUNT = """<!doctype html><html lang="en"><head><title>notebook</title><link rel="icon" href="data:,"></head>
<body data-jp-theme-light="false"><div id="cell" style="width: 700px"></div><script type="module">
import widget from "./widget.js";
const heard = {}, state = {}, said = window.said = [];
const call = (name, ...more) => (heard[name] ?? []).forEach((act) => act(...more));
const model = window.model = {
  get: (name) => state[name],
  set(name, value) { state[name] = value; call(`change:${name}`); },
  save_changes: () => said.push(structuredClone(state)),
  send: (word) => said.push(word),
  on: (name, act) => { (heard[name] ??= []).push(act); },
  off: (name, act) => { heard[name] = heard[name].filter((one) => one !== act); },
};
window.lost = () => call("comm_live_update");
window.tell = (word, text) => {  // bytes of a message begin wherever they do
  const bytes = Uint8Array.from(atob(text ?? ""), (c) => c.charCodeAt(0)), odd = new Uint8Array(bytes.length + 3);
  odd.set(bytes, 3);
  call("msg:custom", word, text ? [new DataView(odd.buffer, 3)] : []);
};
window.mount = (first) => {
  Object.assign(state, first, { still: Uint8Array.from(atob(first.still), (c) => c.charCodeAt(0)) });
  state.still = new DataView(state.still.buffer);
  const part = widget();
  part.initialize({ model });
  window.stop = part.render({ model, el: document.getElementById("cell") });
  window.again = () => part.render({ model, el: document.getElementById("cell") });
};
</script></body></html>"""


@pytest.mark.slow
def test_the_widget_draws_in_a_browser(heard: Heard) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    if not BROWSER:
        pytest.skip("no Chromium here")
    viewer = heard.viewer
    pixel = io.BytesIO()
    Image.new("RGB", (4, 3), (250, 10, 10)).save(pixel, "PNG")
    first = {name: getattr(viewer, name) for name in ("settings", "outputs", "paint", "plane", "cut")}
    wrong: list[str] = []
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=BROWSER, args=["--use-angle=swiftshader", "--no-sandbox"])
        page = browser.new_page(viewport={"width": 760, "height": 420})
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
        files = {"/": ("text/html", MOUNT), "/widget.js": ("text/javascript", BUNDLE.read_text(encoding="utf-8"))}

        def answer(route: Any) -> None:
            kind, body = files[route.request.url.removeprefix("http://notebook.test")]
            route.fulfill(body=body, headers={"Content-Type": kind})

        page.route("**/*", answer)
        page.goto("http://notebook.test/")
        page.evaluate("first => mount(first)",
                      {**first, "height": 300, "still": base64.b64encode(pixel.getvalue()).decode()})  # fmt: skip
        still, canvas = page.locator("#still"), page.locator("#view")
        assert still.evaluate("async image => (await image.decode(), image.naturalWidth)") == 4
        assert not page.locator("#panel").is_visible()  # nobody would hear what is set

        def passed(act: Callable[[], object]) -> None:
            """Hand on what Python tells of an act."""
            scenes = len(heard.scenes)
            for word in heard.after(act):
                if word["say"] == "scene":
                    text = base64.b64encode(heard.scenes[scenes]).decode()
                    page.evaluate("([word, text]) => tell(word, text)", [word, text])
                    scenes += 1
                else:
                    page.evaluate("word => tell(word)", word)

        def seen(before: int) -> Any:
            """The picture (height, width, 4), when a full one more is drawn."""
            page.wait_for_function("n => Number(document.getElementById('cell').firstChild.shadowRoot"
                                   ".getElementById('view').dataset.drawn ?? 0) > n", arg=before)  # fmt: skip
            url = canvas.first.evaluate("canvas => canvas.toDataURL()")
            return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2]))).convert("RGBA"))

        def drawn() -> int:
            return int(canvas.first.get_attribute("data-drawn") or 0)

        assert page.evaluate("said") == [{"do": "begin"}]
        passed(lambda: viewer._handle_custom_msg({"do": "begin"}, []))
        whole = seen(0)
        assert (whole[..., 3] > 0).mean() > 0.1
        assert not still.is_visible()
        assert page.locator("#panel").is_visible()

        # a slider sets the trait, and what comes of it is smaller
        page.eval_on_selector("#param-r", "e => { e.value = 6; e.dispatchEvent(new Event('input')); }")
        page.wait_for_function("said.at(-1).settings?.r === 6")
        before = drawn()
        passed(lambda: viewer.set_state({"settings": page.evaluate("said.at(-1).settings")}))
        assert viewer.settings["r"] == 6
        small = seen(before)
        assert (small[..., 3] > 0).sum() < 0.7 * (whole[..., 3] > 0).sum()

        # what is set in Python moves what is there
        page.evaluate("() => { model.set('settings', { r: 12, kind: 'schwarz_p' }); model.set('cut', 'x<2'); }")
        assert page.input_value("#param-r") == "12"
        assert page.input_value("#param-kind") == "schwarz_p"
        assert page.get_attribute("#across-x", "aria-pressed") == "true"
        assert page.input_value("#offset-number") == "2"
        page.click("#flip")
        assert page.evaluate("said.at(-1).cut") == "x>2"

        # what is wrong lies over the picture that was there
        page.fill("#paint", "hihg")
        page.press("#paint", "Enter")
        page.wait_for_function("said.at(-2).paint === 'hihg'")
        passed(lambda: viewer.set_state({"paint": "hihg"}))
        page.evaluate("state => Object.entries(state).forEach(([n, v]) => model.set(n, v))", heard.states[-1])
        assert page.evaluate("model.get('paint')") == ""
        assert page.input_value("#paint") == "hihg"  # to be mended
        page.evaluate("model.set('height', 350)")
        assert page.locator("#view").evaluate("e => e.getRootNode().host.style.getPropertyValue('--height')") == "350px"
        assert "did you mean `high`" in page.inner_text("#said")
        assert (seen(0)[..., 3] > 0).any()
        ground = page.locator(".frame").first.evaluate("e => getComputedStyle(e).backgroundColor")
        assert ground == "rgb(27, 28, 26)"  # the dark of the notebook, whatever the browser's is

        # the kernel is started again: nobody hears what is set
        page.evaluate("lost()")
        assert "run the cell again" in page.inner_text("#said")
        assert page.locator("#panel").evaluate("e => e.inert")
        page.evaluate("tell({ say: 'done', of: 'scene' })")
        assert "run the cell again" not in page.inner_text("#said")
        assert not page.locator("#panel").evaluate("e => e.inert")

        # what was cancelled is asked for again, also where no trait has changed
        stopped = {"say": "stopped", "of": "scene", "text": "Cancelled. As before.",
                 "wish": {"outputs": [], "paint": "", "plane": False}}  # fmt: skip
        page.evaluate("word => tell(word)", stopped)
        page.click("#said-again")
        assert page.evaluate("said.at(-1)") == {"do": "again"}

        # another view of the same, later
        page.evaluate("() => { stop(); document.getElementById('cell').replaceChildren(); again(); }")
        seen(0)
        assert "did you mean `high`" in page.inner_text("#said")
        assert "Cancelled. As before." in page.inner_text("#said")
        browser.close()
    assert [one for one in wrong if "CONTEXT_LOST" not in one] == []


# ---- the example ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_notebook_runs(tmp_path: Path) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    notebook = nbformat.read(ROOT / "examples" / "notebook.ipynb", 4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in code)
    nbclient.NotebookClient(notebook, timeout=60, resources={"metadata": {"path": str(tmp_path)}}).execute()
    found = {cell.id: cell.outputs for cell in code}

    def of(name: str) -> Any:
        return next(output.data for output in found[name] if "data" in output)

    for name in ("program", "view"):
        assert {VIEW, "text/html", "text/plain"} <= set(of(name))
        assert "unit cell" in of(name)["text/html"]
    states = notebook.metadata.widgets["application/vnd.jupyter.widget-state+json"]["state"]
    shown = states[of("view")[VIEW]["model_id"]]["state"]
    assert shown["settings"] == {"w": 7.0, "t": 0.6, "rim": 0.3}  # as it was set later
    assert shown["cut"] == "y<0"
    assert of("set")["text/plain"] == "{'w': 7.0, 't': 0.6, 'rim': 0.3}"
    assert "+-" in of("measure")["text/html"]
    assert of("sweep")["text/plain"].count("+-") == 4
    assert "polyline" in of("plot")["image/svg+xml"]
    assert of("field")["image/png"]
    assert "watertight: True" in found["mesh"][-1]["text"]
    assert (tmp_path / "plug.stl").stat().st_size > 100_000
    (wrong,) = found["wrong"]
    assert wrong.traceback[0].startswith("error[E030]")  # as on the command line, and nothing of Python
    assert "did you mean `cylinder`" in "\n".join(wrong.traceback)
