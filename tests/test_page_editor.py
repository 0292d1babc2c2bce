"""The editor of the page: what is checked in is made of what stands here, and it works in a browser under the CSP."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

import pytest

ROOT = Path(__file__).parent.parent
HERE = ROOT / "editors" / "page"
WEB = ROOT / "porelang" / "preview" / "web"
sys.path.insert(0, str(ROOT / "editors"))
BUNDLE = (WEB / "editor.js").read_text(encoding="utf-8")
BROWSER = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), ""
)
#: Packages of the lock file of which no line is used.
UNUSED = {"@lezer/lr"}

PAGE = """<!doctype html><html lang="en"><head><title>editor</title><link rel="icon" href="data:,">
<link rel="stylesheet" href="page.css"></head>
<body><div id="editor"></div><button>next</button><script type="module" src="try.js"></script></body></html>"""
STYLE = (WEB / "page.css").read_text(encoding="utf-8") + "\n#editor { width: 520px; height: 100%; }"
TRY = r"""
import { edit } from "./editor.js";
window.said = [];
window.slow = 0;
window.open = window.most = 0;
const told = (name) => (text) => { said.push([name, text]); };
window.editor = edit(document.getElementById("editor"), {
  changed: told("changed"), save: told("save"), format: told("format"),
  async complete(text, offset) {
    said.push(["complete", text, offset]);
    most = Math.max(most, ++open);
    await new Promise((resolve) => setTimeout(resolve, slow));
    open--;
    const start = offset - /\w*$/.exec(text.slice(0, offset))[0].length;
    const detail = `(${"round: length, ".repeat(12)})`;
    const about = { kind: "function", detail, doc: "One line.\nAnother.", start, end: offset };
    return ["sphere", "shell", "side"].map((label) => ({ ...about, label, text: label + "()" }));
  },
});
"""
TEXT = """## of a part
# a note
param w = 30mm in 10mm..60mm  "unit cell"
let heat = 1 - ramp(hypot(x, y), 5, 30) * pi
gyroid(w) |> shell(envelop) & cylinder(30mm, 75mm)
"""


def test_patterns_are_those_of_the_package() -> None:
    from generate import MODULE, module

    assert MODULE.read_text(encoding="utf-8") == module(), "make editors, then make page"


def test_bundle_is_made_of_these_sources() -> None:
    sources = [HERE / "build.js", HERE / "package-lock.json", *sorted((HERE / "src").iterdir())]
    digest = hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()
    assert digest in BUNDLE.partition("\n")[0], "make page"


def test_versions_are_exact_and_notices_name_all_that_is_bundled() -> None:
    wanted = json.loads((HERE / "package.json").read_text(encoding="utf-8"))
    lock = json.loads((HERE / "package-lock.json").read_text(encoding="utf-8"))["packages"]
    for name, version in {**wanted["dependencies"], **wanted["devDependencies"]}.items():
        assert lock[f"node_modules/{name}"]["version"] == version
    used = {
        f"{path.removeprefix('node_modules/')} {of['version']}"
        for path, of in lock.items()
        if path and not of.get("dev") and path.removeprefix("node_modules/") not in UNUSED
    }
    notices = (WEB / "LICENCES.txt").read_text(encoding="utf-8").split("-" * 80)[1:]
    assert {notice.split("\n")[1] for notice in notices} == used
    assert all("Permission is hereby granted" in notice and "Copyright" in notice for notice in notices)


def test_bundle_keeps_to_the_csp_and_to_itself() -> None:
    assert not re.search(r"\beval\(|\bFunction\(|\bimport\b|\bfetch\(|XMLHttpRequest|sourceMappingURL", BUNDLE)
    assert set(re.findall(r"https?://[\w./-]+", BUNDLE)) <= {"http://www.w3.org/2000/svg"}
    lock = (HERE / "package-lock.json").read_text(encoding="utf-8")
    assert all(urlparse(url).hostname == "registry.npmjs.org" for url in re.findall(r'"resolved": "([^"]*)"', lock))


@pytest.fixture
def page() -> Iterator[Any]:
    """A page with the editor, from no server: what it asks for is answered here, with the headers of the server."""
    playwright = pytest.importorskip("playwright.sync_api")
    headers = pytest.importorskip("porelang.preview.server").HEADERS
    if not BROWSER:
        pytest.skip("no Chromium here")
    files = {
        "/": ("text/html", PAGE),
        "/page.css": ("text/css", STYLE),
        "/try.js": ("text/javascript", TRY),
        "/editor.js": ("text/javascript", BUNDLE),
    }
    asked, wrong = [], []

    def answer(route: Any) -> None:
        asked.append(route.request.url)
        kind, body = files[urlparse(route.request.url).path]
        route.fulfill(body=body, headers={**headers, "Content-Type": kind})

    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(
            executable_path=BROWSER, args=["--use-angle=swiftshader", "--no-sandbox"]
        )  # fmt: skip
        opened = browser.new_page(viewport={"width": 640, "height": 300})
        opened.on("pageerror", lambda error: wrong.append(str(error)))
        opened.on("console", lambda message: wrong.append(message.text))
        opened.route("**/*", answer)
        opened.goto("http://editor.test/")
        yield opened
        browser.close()
    assert wrong == []
    assert {urlparse(url).path for url in asked} == set(files)


def contrast(one: str, other: str) -> float:
    """That of WCAG 2, of two colours `rgb(r, g, b)`."""

    def light(colour: str) -> float:
        parts = [int(c) / 255 for c in re.findall(r"\d+", colour)[:3]]
        return sum(w * (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4)
                   for w, c in zip((0.2126, 0.7152, 0.0722), parts, strict=True))  # fmt: skip

    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.slow
def test_editor_in_a_browser(page: Any) -> None:
    do, press, write = page.evaluate, page.keyboard.press, page.keyboard.type
    lines = page.locator(".cm-line")

    def said(name: str) -> list[Any]:
        return [words[1] for words in do("said") if words[0] == name]

    def until(holds: str) -> None:  # Playwright's own wait evaluates a text in the page, which the CSP forbids
        for _ in range(200):
            if do(holds):
                return
            page.wait_for_timeout(10)
        raise AssertionError(holds)

    def show(text: str) -> None:
        do("text => editor.show(text)", text)
        assert do("editor.text()") == text

    # colours: as in other editors, and readable
    from pygments.token import Text

    from porelang.highlight import PoreLexer

    show(TEXT)
    written = page.locator(".cm-line [class^=pore-]")
    spans = written.evaluate_all("all => all.map(e => [e.className, e.textContent])")
    assert {kind for kind, _ in spans} >= {f"pore-{name}" for name in (
        "comment-documentation", "comment", "string", "number", "keyword-declaration", "keyword", "constant",
        "variable-coordinate", "function", "operator", "variable")}  # fmt: skip
    signs = "()[]{},:;."
    lexed = [value.strip() for kind, value in PoreLexer().get_tokens(TEXT) if kind is not Text and value not in signs]
    assert [text.strip() for _, text in spans] == [value for value in lexed if value]
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        colour = "(e, of) => getComputedStyle(e)[of]"
        ground = page.locator(".cm-editor").evaluate(colour, "backgroundColor")
        for one in written.evaluate_all("all => all.map(e => getComputedStyle(e).color)"):
            assert contrast(one, ground) >= 4.5, (scheme, one)
        beside = page.locator(".cm-gutters")
        assert contrast(beside.evaluate(colour, "color"), beside.evaluate(colour, "backgroundColor")) >= 4.5
    assert said("changed") == []

    # marks: on their text, beside their line, and told by F8
    at = TEXT.index("envelop")
    do("marks => editor.mark(marks)", [
        {"from": at, "to": at + 7, "severity": "error", "message": "no such name"},
        {"from": 3, "to": 5, "severity": "warning", "message": "doubtful"},
        {"from": 1e6, "to": 1e7, "severity": "info", "message": "of a text that was longer"},
    ])  # fmt: skip
    assert page.locator(".cm-lintRange-error").inner_text() == "envelop"
    do("editor.focus()")
    press("F8")
    assert page.locator(".cm-tooltip .cm-diagnostic").inner_text() == "doubtful"
    press("F8")
    page.locator(".cm-tooltip .cm-diagnostic", has_text="no such name").wait_for()
    press("Shift+F8")
    page.locator(".cm-tooltip .cm-diagnostic", has_text="doubtful").wait_for()
    assert page.locator(".cm-lint-marker-error").count() == 1
    do("editor.mark([])")
    assert page.locator(".cm-lintRange").count() == 0

    # what is written is told once, and completed; an answer that comes late is dropped
    press("Control+End")
    write("let a = sp")
    page.locator(".cm-tooltip-autocomplete li", has_text="sphere").wait_for()
    cut = page.locator(".cm-tooltip-autocomplete li").evaluate_all("all => all.map(e => e.scrollWidth > e.clientWidth)")
    assert not any(cut)  # long signatures are wrapped
    page.wait_for_timeout(200)
    assert said("changed") == [TEXT + "let a = sp"]
    press("Enter")
    assert lines.last.inner_text() == "let a = sphere()"
    do("slow = 150")
    write("; let b = 10 + sh", delay=15)
    write("e", delay=15)
    press("Escape")
    write(" ", delay=15)
    page.wait_for_timeout(350)
    assert page.locator(".cm-tooltip-autocomplete").count() == 0
    do("slow = 0")
    press("Control+Space")
    page.locator(".cm-tooltip-autocomplete li").first.wait_for()
    assert page.locator(".cm-completionLabel").all_inner_texts() == ["sphere", "shell", "side"]
    page.locator(".cm-completionInfo", has_text="Another.").wait_for()
    press("Escape")
    assert do("most") == 1

    # keys
    press("Control+s")
    press("Control+Shift+F")
    press("Alt+Shift+F")
    assert said("save") == said("format")[:1] == said("format")[1:] == [do("editor.text()")]
    press("Control+/")
    assert lines.last.inner_text().startswith("# let a")
    press("Enter")
    write("f([")
    press("Enter")
    assert do("editor.text()").endswith("\nf([\n  \n])")
    for _ in range(20):
        press("Control+z")
    assert do("editor.text()") == TEXT  # what was shown first is where it began
    do("editor.dirty(true)")
    assert page.locator("#editor[data-dirty]").count() == 1
    do("editor.dirty(false)")
    assert page.locator("#editor[data-dirty]").count() == 0
    press("Control+f")
    page.locator(".cm-search").wait_for()
    press("Escape")
    do("editor.focus()")
    press("Escape")
    press("Tab")
    assert do("document.activeElement.textContent") == "next"

    # another text: the cursor and what is seen stay with their lines
    page.wait_for_timeout(200)
    do("said.length = 0")
    long = "".join(f"let a{i}  = sin( {i} )\n" for i in range(200))
    show(long)
    do("at => { editor.go(at); editor.focus(); }", long.index("sin( 100 )") + 5)
    seen = "document.querySelector('#editor > *').shadowRoot.querySelector('.cm-scroller').scrollTop"
    until(f"{seen} > 1000")
    before = do(seen)
    show(long.replace("  =", " =").replace("( ", "(").replace(" )", ")"))
    page.wait_for_timeout(50)
    assert do(seen) == pytest.approx(before, abs=2)
    show("# a line more\n" + do("editor.text()"))
    page.wait_for_timeout(50)
    assert do(seen) == pytest.approx(before + 19.5, abs=2)
    write("7")
    assert "let a100 = sin(7100)\n" in do("editor.text()")

    # line ends of Windows stay, and offsets count them
    text = TEXT.replace("\n", "\r\n")
    at = text.index("envelop")
    show(text)
    page.wait_for_timeout(200)
    assert said("changed") == []
    do("at => { editor.mark([{from: at, to: at + 7, severity: 'error', message: ''}]); editor.go(at); }", at)
    assert page.locator(".cm-lintRange-error").inner_text() == "envelop"
    press("Enter")
    assert do("editor.text()") == text[:at] + "\r\n  " + text[at:]
    press("Control+Space")
    until("said.some(words => words[0] === 'complete')")
    assert do("said.find(words => words[0] === 'complete')[2]") == at + 4
    for mixed in ("a\r\nb\n", "a\rb", "\r\n\r", "\n", ""):
        show(mixed)
