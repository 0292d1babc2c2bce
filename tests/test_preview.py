"""What a page of `pore view` is told and sent, without a browser: scenes, words, files, and who is refused."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import struct
import threading
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

import porelang
from porelang.cli import main
from porelang.diagnostics import Diagnostic, PoreError
from porelang.measure import measure
from porelang.preview import told
from porelang.preview.doing import Message
from porelang.preview.live import NOTHING, Live, Start
from porelang.preview.look import Look as Address
from porelang.preview.scene import QUICK, Wish, scene
from porelang.preview.server import FILES, LONGEST, MOST_A_SECOND, WEB, application, door, server_of
from porelang.preview.tokens import proof, token_of
from porelang.preview.watched import PATIENCE, Watched
from porelang.preview.wire import packed, texts
from porelang.preview.words import on_page
from porelang.progress import checkpoint

BALL = 'param r = 10mm in 5mm..20mm step 1mm "its radius"\nsphere(r) & gyroid(8) + r / 1mm * 0\n'
TWO = """param w = 8mm in 5mm..20mm
param angle = 30deg in 0deg..90deg
param kind = gyroid in {gyroid, schwarz_p}
preset "wide": w = 12mm, kind = schwarz_p
let far = z / 2
out walls = (kind(w) |> rotate([1, 0, 0], angle) |> shell(0.8)) & sphere(10)
out plate = box([30, 30, 4]) |> translate([0, 0, -12])
out mask = x > 0
check w > 6mm, "cells are large"
check porosity(walls, sphere(10)) < 5%, "it is solid"
"""


def read(message: bytes) -> tuple[dict[str, Any], bytes]:
    """The head of a scene, and its textures."""
    (size,) = struct.unpack_from("<I", message)
    return json.loads(message[4 : 4 + size]), message[4 + size :]


# ---- scenes ---------------------------------------------------------------------------------------------------------


def test_a_scene_comes_as_its_head_and_its_textures() -> None:
    made = scene(porelang.compile(BALL).design())
    (body,) = made.bodies
    head, textures = read(packed(made))
    cells = np.frombuffer(textures, "<f4")
    assert len(cells) == np.prod(head["bodies"][0]["counts"])
    x, y, z = (c // 2 for c in body.cells.counts)
    # x runs fastest in a texture
    nx, ny, _ = head["bodies"][0]["counts"]
    assert cells[x + nx * (y + ny * z)] == body.cells.values[x, y, z]
    assert head["bodies"][0]["text"].startswith("#version 300 es")
    assert np.allclose(head["lo"], -10.02, atol=0.05)
    again, _ = read(packed(made, texts(made)))
    assert again["bodies"][0]["text"] is None  # the page has it


def test_a_param_changes_numbers_and_no_shader() -> None:
    """Issue 11: sliders change nothing that has to be compiled, also with a colour and a plane."""
    program = porelang.compile(BALL)
    wish = Wish(paint="r * x", plane=True)
    one, other = (scene(program.design(r=r), wish, QUICK) for r in (8, 19))
    assert texts(one) == texts(other)
    assert list(one.bodies[0].layer.numbers) != list(other.bodies[0].layer.numbers)


def test_cells_made_quickly_say_less_and_nothing_wrong() -> None:
    """A slope of a coarse cell bounds those of the fine cells in it; void and solid are what they are."""
    design = porelang.compile("gyroid(5) & box([40, 40, 40], round=3)").design()
    quick, whole = (scene(design, None, budget).bodies[0].cells for budget in (QUICK // 20, 60_000_000))
    assert max(quick.counts) < max(whole.counts)
    times = [a // b for a, b in zip(whole.counts, quick.counts, strict=True)]
    wide = quick.values
    for axis, n in enumerate(times):
        wide = np.repeat(wide, n, axis=axis)
    assert (whole.values[wide == 0] == 0).all()
    assert (whole.values[wide == -1] == -1).all()
    sloped = (wide > 0) & (whole.values > 0)
    assert (whole.values[sloped] <= wide[sloped] * 1.001).all()


def test_outputs_have_the_colours_that_pictures_give_them() -> None:
    program = porelang.compile(TWO)
    (alone,) = scene(program.design()).bodies  # the first that may be solid, where nothing is called `part`
    assert alone.layer.name == "walls"
    walls, plate = scene(program.design(), Wish(("walls", "plate"))).bodies
    assert plate.colour == pytest.approx(np.array((226, 110, 50)) / 255)
    assert walls.colour != plate.colour
    with pytest.raises(PoreError, match="E101"):
        scene(program.design(), Wish(("mask",)))


def test_the_scale_takes_in_the_field_where_the_part_is() -> None:
    made = scene(porelang.compile("sphere(10) & gyroid(8)").design(), Wish(paint="z + 20"))
    assert made.scale is not None
    low, high = made.scale.ends
    assert 10 <= low < 11.5
    assert 28.5 < high <= 30
    assert made.shown == "z + 20"
    two = porelang.compile("out low = sphere(4)\nout high = sphere(4) @ [x, y, z - 30]").design()
    both = scene(two, Wish(("low", "high"), paint="z"))  # of all that is drawn
    assert both.scale is not None
    assert both.scale.ends == pytest.approx([-4, 34], abs=1)
    own = scene(porelang.compile("sphere(10)").design(), Wish(plane=True))
    assert own.scale is not None
    assert own.scale.ends[0] == pytest.approx(-10, abs=0.5)


def test_what_a_study_has_not_found_has_no_colour() -> None:
    """W285 of pictures: the study is of the lower half, and its result goes on above; there it is grey."""
    program = porelang.compile(
        "let low = box([10, 10, 10]) |> translate([0, 0, -5])\n"
        'let s = compress(low, force=1kN, axis=z, material="PA12", size=4mm)\nbox([10, 10, 20])\n'
    )
    made = scene(program.design(), Wish(paint="s.von_mises"))
    assert "3.40282347" in made.bodies[0].layer.text or "pore_nan" in made.bodies[0].layer.text
    assert made.unit.endswith("MPa")
    assert made.scale is not None
    assert made.scale.ends[1] < 30  # 10 MPa in the mean


# ---- a file that is looked at ---------------------------------------------------------------------------------------


class Page:
    """What a page was told by a `Live`, and how to wait for it."""

    def __init__(self, path: Path, start: Start = NOTHING) -> None:
        self.words: list[Message] = []
        self.live = Live(str(path), self.words.append, start)

    def said(self, kind: str, after: int = 0, seconds: float = 60) -> Any:
        """The first word of a kind (`scene` for one) after so many others."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            for word in self.words[after:]:
                if (word["say"] if isinstance(word, dict) else "scene") == kind:
                    return word
            time.sleep(0.01)
        heard = [w["say"] if isinstance(w, dict) else "scene" for w in self.words]
        raise AssertionError(f"nothing was said of {kind}: {heard}")


@pytest.fixture
def look(tmp_path: Path) -> Iterator[Callable[[str], tuple[Page, Path]]]:
    pages: list[Page] = []

    def begin(text: str) -> tuple[Page, Path]:
        path = tmp_path / "part.pore"
        path.write_text(text, encoding="utf-8")
        page = Page(path)
        pages.append(page)
        page.live.begin()
        return page, path

    yield begin
    for page in pages:
        page.live.close()


Look = Callable[[str], tuple[Page, Path]]


def test_a_page_is_told_of_the_program_its_text_and_its_picture(look: Look) -> None:
    page, _ = look(TWO)
    program = page.said("program")
    assert program["file"] == "part.pore"
    assert program["wrong"] == []
    assert program["bodies"] == ["walls", "plate"]
    assert "far" in program["fields"]
    assert program["presets"] == ["wide"]
    angle = program["params"][1]
    assert (angle["unit"], angle["value"] / angle["scale"]) == ("deg", pytest.approx(30))
    assert program["params"][2]["choices"] == ["gyroid", "schwarz_p"]
    assert page.said("text")["text"] == TWO
    assert [b.layer.name for b in page.said("scene").bodies] == ["walls"]


def test_measures_and_checks_come_by_themselves(look: Look) -> None:
    page, _ = look(TWO)
    checks = page.said("checked")["checks"]
    assert [c["holds"] for c in checks] == [True, False]
    assert "porosity(walls, sphere(10))" in checks[1]["why"]
    rows = {name: (value, error) for name, value, error in page.said("measured")["rows"]}
    assert 0.3 < float(rows["porosity"][0]) < 0.95
    assert rows["porosity"][1].startswith("+- ")


def test_a_program_that_is_broken_keeps_its_picture_and_its_sliders(look: Look) -> None:
    page, _ = look(BALL)
    page.live.set({"r": 15})
    page.said("measuring")  # nothing more is drawn
    page.live.cancel("measure")
    drawn = page.said("scene")
    count = len(page.words)
    page.live.edit("let a = (\n" + BALL)
    broken = page.said("program", after=count)
    assert "E0" in broken["wrong"][0]
    assert broken["marks"][0]["severity"] == "error"
    assert broken["params"][0]["value"] == 15
    time.sleep(0.3)
    assert all(isinstance(w, dict) for w in page.words[count:])  # no new picture
    page.live.edit("let a = 1\n" + BALL)
    again = page.said("scene", after=count)
    assert again.bodies[0].layer.text == drawn.bodies[0].layer.text
    assert again.stage.hi[0] == pytest.approx(15, abs=0.1)


def test_a_setting_that_a_program_does_not_take_any_more_is_dropped(look: Look) -> None:
    page, _ = look(BALL)
    page.live.set({"r": 15})
    count = len(page.words)
    page.live.edit(BALL.replace("5mm..20mm", "5mm..12mm"))
    assert page.said("program", after=count)["params"][0]["value"] == 10
    page.said("scene", after=count)


def test_presets_set_params_and_defaults_set_them_back(look: Look) -> None:
    page, _ = look(TWO)
    before = page.said("scene")
    count = len(page.words)
    page.live.preset("wide")
    params = page.said("program", after=count)["params"]
    assert [params[0]["value"], params[2]["value"]] == [12, "schwarz_p"]
    after = page.said("scene", after=count)
    assert set(after.bodies[0].layer.numbers) - set(before.bodies[0].layer.numbers)
    count = len(page.words)
    page.live.preset("")
    assert page.said("program", after=count)["params"][2]["value"] == "gyroid"
    page.live.preset("there is none")


def test_a_page_begins_with_what_the_command_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "two.pore"
    path.write_text(TWO)
    page = Page(path, Start({"angle": "60deg"}, "wide", {}))
    page.live.begin()
    w, angle, kind = page.said("program")["params"]
    assert (w["value"], angle["value"], kind["value"]) == (12, pytest.approx(np.pi / 3 / 1, rel=1e-9), "schwarz_p")
    assert (w["default"], w["begun"]) == (8, 12)  # an address says what is neither
    page.live.close()
    for options, code in ((["--set", "w=90mm"], "E085"), (["--preset", "none"], "E0"), (["--port", "70000"], "E108")):
        assert main(["view", str(path), "--no-browser", *options]) != 0
        assert f"error[{code}" in capsys.readouterr().err


def test_what_is_refused_is_said_and_the_picture_stays(look: Look) -> None:
    page, _ = look(BALL)
    page.said("scene")
    count = len(page.words)
    page.live.show(Wish(paint="nonsense"))
    refused = page.said("refused", after=count)
    assert refused["of"] == "scene"
    assert "`nonsense`" in refused["text"]
    page.said("done", after=count)
    assert all(isinstance(w, dict) for w in page.words[count:])


def test_saving_writes_the_file_unless_another_program_has(look: Look) -> None:
    page, path = look(BALL)
    page.live.edit("sphere(4)")
    page.live.save("sphere(4)")
    assert page.said("saved")
    assert path.read_text() == "sphere(4)"
    path.write_text("sphere(5)")
    page.live.edit("sphere(6)")
    page.live.session.jobs._latest["text"].result(10)
    page.live.save("sphere(6)")
    assert page.said("conflict")
    assert path.read_text() == "sphere(5)"  # theirs is not lost
    count = len(page.words)
    page.live.reread()
    assert page.said("conflict", after=count)
    page.live.save("sphere(6)", over=True)
    assert path.read_text() == "sphere(6)"
    path.write_text("sphere(7)")
    count = len(page.words)
    page.live.reread()  # nothing of the page's own would be lost
    assert page.said("text", after=count)["text"] == "sphere(7)"


def test_the_editor_is_served(look: Look) -> None:
    text = "# größe 🙂\nlet wall = 1mm\nsphere(10) & gyr"
    page, _ = look(text)
    offset = len(text.encode("utf-16-le")) // 2
    page.live.complete(7, text, offset)
    answer = page.said("completions")
    assert answer["number"] == 7
    item = next(i for i in answer["items"] if i["label"] == "gyroid")
    assert (item["start"], item["end"]) == (offset - 3, offset)
    (mark,) = [m for m in page.said("program")["marks"] if "gyr" in m["message"]]
    assert (mark["from"], mark["to"]) == (offset - 3, offset)
    page.live.style("let  a=1")
    assert page.said("styled")["text"] == "let a = 1\n"
    page.live.style("let a = (")
    assert page.said("refused")["of"] == "style"


def test_a_mesh_is_made_for_the_page_and_gone_with_it(look: Look) -> None:
    page, _ = look("sphere(10)")
    page.said("scene")
    page.live.export("part", ".stl", "1mm")
    made = page.said("made")
    path = page.live.made.path(made["name"])
    assert path.name == "part-part.stl"
    import trimesh

    assert trimesh.load_mesh(path).volume == pytest.approx(4188.8, rel=0.02)
    for output, ending, voxel, code in (("nothing", ".stl", "1mm", "E100"), ("part", ".doc", "1mm", "E112"),
                                        ("part", ".stl", "thick", "E114"), ("part", ".stl", "-1", "E114")):  # fmt: skip
        count = len(page.words)
        page.live.export(output, ending, voxel)
        refused = page.said("refused", after=count)
        assert refused["of"] == "export"
        assert code in refused["text"]
    page.live.close()
    assert not path.exists()


def test_work_can_be_cancelled(look: Look) -> None:
    page, _ = look("gyroid(3) & sphere(30)")
    page.said("scene")
    page.live.export("part", ".stl", "0.1mm")
    until = time.monotonic() + 20
    while not any(isinstance(w, dict) and w["say"] == "doing" and w["of"] == "export" for w in page.words):
        assert time.monotonic() < until
        time.sleep(0.01)
    page.live.cancel("export")
    until = time.monotonic() + 20
    while not any(isinstance(w, dict) and w["say"] == "done" and w["of"] == "export" for w in page.words):
        assert time.monotonic() < until
        time.sleep(0.02)
    assert not any(isinstance(w, dict) and w["say"] == "made" for w in page.words)


def test_characters_and_utf_16_units() -> None:
    text = "a🙂ß"
    assert [told.units(text, i) for i in range(4)] == [0, 1, 3, 4]
    assert [told.characters(text, i) for i in (0, 1, 3, 4)] == [0, 1, 2, 3]


def test_what_counts_has_whole_numbers(look: Look) -> None:
    page, _ = look(
        "param n = 6 in 3..12\nparam w = 8 in 5..9\nring(sphere(2) |> translate([6, 0, 0]), n) | sphere(w / 4)"
    )
    n, w = page.said("program")["params"]
    assert (n["step"], w["step"]) == (1, None)


def test_a_setting_may_have_a_unit_and_what_cannot_be_is_told_and_not_taken(look: Look) -> None:
    page, _ = look(TWO)
    page.said("scene")
    for text, value, code in (("1.2cm", 12, ""), ("abc", 12, "E084"), ("", 12, "E084"), (99.0, 12, "E085"),
                               ("2mm", 12, "E085"), ("0.5in", 12.7, ""), (10.0, 10, "")):  # fmt: skip
        count = len(page.words)
        page.live.set({"w": text})
        refused = page.said("refused", after=count)
        assert refused["of"] == "settings"
        assert code in refused["text"]
        assert bool(refused["text"]) == bool(code)
        assert page.said("settings", after=count)["settings"]["w"] == pytest.approx(value)
        assert page.live.settings["w"] == pytest.approx(value)
    page.live.set({"angle": "0.5rad", "nothing": 3})
    assert page.live.settings["angle"] == 0.5


def test_what_is_refused_says_of_what_the_picture_is(look: Look) -> None:
    page, _ = look(TWO)
    page.said("scene")
    page.live.set({"w": 9.0})
    page.said("measuring")
    page.live.show(Wish(("plate",), "far"))
    page.said("measuring", after=len(page.words))
    count = len(page.words)
    page.live.show(Wish(("walls", "plate"), "nonsense"))
    page.live.set({"w": 11.0})

    def told(ending: str) -> None:
        until = time.monotonic() + 60
        while not any(isinstance(w, dict) and w.get("text", "").endswith(ending) for w in page.words[count:]):
            assert time.monotonic() < until
            time.sleep(0.02)

    told("\n\nThe picture is as before: w = 9mm, `plate`, the colours of `far`.")
    count = len(page.words)
    page.live.edit(TWO.replace("sphere(10)", "sphere(11)"))
    told("The picture is as before: of the program as it was.")
    # a line of it that is quoted may be another now
    assert page.said("refused", after=count)["text"] == ""


def test_a_picture_that_is_cancelled_is_said_and_its_colours_are_not(
    look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, _ = look(TWO)
    page.said("measuring")

    def slow(*_: object) -> None:
        while True:
            time.sleep(0.01)
            checkpoint()

    monkeypatch.setattr("porelang.preview.doing.scene", slow)
    count = len(page.words)
    page.live.show(Wish(("plate",), "far"))
    page.live.cancel("scene")
    stopped = page.said("stopped", after=count)
    assert stopped["text"] == "Cancelled. The picture is as before: `walls`, no colours of a field."
    assert stopped["wish"] == {"outputs": [], "paint": "", "plane": False}
    page.live.cancel("scene")
    page.said("done", after=count)
    count = len(page.words)
    page.live.cancel("scene")  # nothing is being done
    page.live.cancel("export")
    assert len(page.words) == count


def test_a_page_begins_with_what_its_address_says(tmp_path: Path) -> None:
    path = tmp_path / "two.pore"
    path.write_text(TWO)

    def begun(**said: str) -> dict[str, Any]:
        page = Page(path, Start({"angle": "60deg", "w": "9mm"}, None, {}))
        page.live._look = Address.read([(name.replace("__", "."), text) for name, text in said.items()])
        page.live.begin()
        page.live.close()
        found: dict[str, Any] = page.said("program")
        return {p["name"]: p["value"] for p in found["params"]} | found["wish"]

    assert begun(p__w="12", p__kind="schwarz_p", outputs="plate,walls", paint="far", plane="1") == {
        "w": 12, "angle": pytest.approx(np.pi / 3), "kind": "schwarz_p", "outputs": ["plate", "walls"], "paint": "far",
        "plane": True,
    }  # fmt: skip
    # what cannot be is passed over, and what the command has set is not
    assert begun(p__w="99", p__kind="nothing", p__none="1", outputs="mask,none", paint="nonsense(", q="7") == {
        "w": 9, "angle": pytest.approx(np.pi / 3), "kind": "gyroid", "outputs": [], "paint": "", "plane": False,
    }  # fmt: skip


def test_what_a_page_is_told_names_no_option_of_a_command(look: Look) -> None:
    hints = {
        "use --voxel 0.9mm: why; or keep it as it is, --force": "use a voxel of 0.9mm: why; or have it as it is",
        "a voxel of 1 mm would do; or take a part of it, with --bounds": "a voxel of 1 mm would do",
        "intersect it with a shape, `... & box([5, 5, 5])`, or pass --bounds x0,y0,z0,x1,y1,z1":
            "intersect it with a shape, `... & box([5, 5, 5])`",
        "that takes 3 samples: take a part of it, with --bounds": "that takes 3 samples",
        "use a smaller --voxel": "use a smaller voxel",
        "`pore mesh --backend numpy` has no such limit": "`pore mesh --backend numpy` has no such limit",
    }  # fmt: skip
    for hint, said in hints.items():
        assert on_page(Diagnostic("E118", "", hint=hint)).hint == said
    page, _ = look("gyroid(4) |> shell(0.3) & sphere(8)")
    page.said("scene")
    page.live.export("part", ".stl", "1mm")
    refused = page.said("refused")
    assert refused["lost"]
    assert "E118" in refused["text"]
    assert "--" not in refused["text"].replace("-->", "")
    page.live.export("part", ".stl", "1mm", force=True)
    made = page.said("made")
    assert "voxel" in made["what"].partition("\n")[2]  # that it has lost much


def test_colours_are_refused_in_words_of_what_was_written() -> None:
    program = porelang.compile(BALL)
    for text, code, words in (("z +", "E007", "after `+`\n"), ("let q = 3", "E007", "`let` begins a statement"),
                              ("gyroid", "E101", "`gyroid(w=...)`"), ("(z", "E005", "never closed")):  # fmt: skip
        with pytest.raises(PoreError, match=code) as error:
            scene(program.design(), Wish(paint=text))
        assert words in str(error.value)
        assert "`)`, or" not in str(error.value)


def test_porosity_is_of_something(look: Look) -> None:
    page, _ = look("sphere(10)")
    assert page.said("measured")["envelope"] == "its box"
    page.live.edit("gyroid(8) & sphere(10)")
    count = len(page.words)
    assert page.said("measured", after=count)["envelope"] == "the shapes that the part is intersected with"


STUDY = """param F = 1kN in 1kN..9kN
param lim = 3MPa in 1MPa..90MPa
let bar = box([20, 20, 20])
let s = compress(bar, force=F, axis=z, material="PA12", size=5mm)
check s.max_von_mises < lim, "it holds"
out part = bar
out low = bar & box([30, 30, 4])
"""


def test_measures_are_of_what_is_set_and_what_was_found_before_is_told_no_more(
    look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("porelang.preview.live.STILL", 0.0)
    monkeypatch.setattr("porelang.preview.doing.BUDGET", 50_000)
    monkeypatch.setattr("porelang.preview.doing.QUICK", 10_000)
    quick = cache(lambda name: measure(porelang.compile(STUDY).design(), name, voxel=2.0))
    monkeypatch.setattr("porelang.preview.live.measure", lambda _, name: quick(name))
    page, _ = look(STUDY)
    rows = {name: (value, error) for name, value, error in page.said("measured")["rows"]}
    (stress,) = [told for name, told in rows.items() if name.endswith("max_von_mises")]
    assert stress[0].endswith(" MPa")
    assert stress[1].endswith(" MPa")
    doubts = page.said("doubts")
    assert "err by" in doubts["notes"][0]  # the study's own error
    assert page.said("checked")["checks"] == [{"text": "it holds", "holds": True, "why": ""}]

    # while one measures, something else is set: nothing that it finds is told then
    entered, go = threading.Event(), threading.Event()
    found = told.checked

    def slow(design: porelang.Design) -> dict[str, Any]:
        answer = found(design)
        entered.set()
        go.wait(60)
        return answer

    monkeypatch.setattr("porelang.preview.live.told.checked", slow)
    page.live.set({"lim": 4.0})
    assert entered.wait(60)
    monkeypatch.setattr("porelang.preview.live.told.checked", found)
    count = len(page.words)
    page.live.set({"lim": 1.0})
    go.set()
    checked = page.said("checked", after=count)
    assert checked["checks"][0]["holds"] is False
    assert "is 2.5 MPa with lim = 1MPa" in checked["checks"][0]["why"]
    said = [w["say"] for w in page.words[count:] if isinstance(w, dict)]
    assert said.index("unmeasured") < said.index("checked")
    page.said("measured", after=count)

    # nothing is drawn or measured where nothing is set that was not, and colours are not what is measured
    count = len(page.words)
    job = page.live.session.jobs._latest["scene"]
    page.live.set({"lim": "1MPa"})
    assert page.live.session.jobs._latest["scene"] is job
    page.live.show(Wish(paint="s.von_mises"))
    assert page.said("doubts", after=count)["notes"]
    page.live.session.jobs._latest["measure"].result(60)
    said = [w["say"] if isinstance(w, dict) else "scene" for w in page.words[count:]]
    assert said.count("scene") == 2  # one sooner, one better
    assert not {"unmeasured", "measuring", "checked", "measured"} & set(said)

    # what is refused, or cancelled, is measured all the same
    count = len(page.words)
    page.live.show(Wish(paint="nonsense"))
    page.live.set({"lim": 2.0})
    assert page.said("checked", after=count)["checks"][0]["holds"] is False
    assert page.said("measured", after=count)["output"] == "part"
    page.live.show(Wish(paint="z"))
    page.said("scene", after=count)

    def never(*_: object) -> None:
        while True:
            time.sleep(0.01)
            checkpoint()

    monkeypatch.setattr("porelang.preview.doing.scene", never)
    count = len(page.words)
    page.live.set({"lim": 5.0})
    page.live.cancel("scene")
    assert page.said("stopped", after=count)["text"] == "Cancelled. The picture is as before: lim = 2MPa."
    assert page.said("checked", after=count)["checks"][0]["holds"] is True
    # and as it is drawn, of the outputs that are
    page.live.show(Wish(("low",)))
    page.live.cancel("scene")
    count = len(page.words)
    assert page.said("measured", after=count)["output"] == "part"
    count = len(page.words)
    page.live.show(Wish(("low",)))
    page.said("unmeasured", after=count)
    page.live.cancel("scene")


def test_what_is_doubtful_is_told_where_there_is_no_picture(look: Look) -> None:
    page, _ = look("let bar = cylinder(5, 20)\nout part = bar - sphere(3)\n")
    assert "E102" in page.said("refused")["text"]
    assert "W213" in page.said("doubts")["doubts"][0]
    page.live.session.jobs._latest["measure"].result(60)
    told = [w["text"] for w in page.words if isinstance(w, dict) and w["say"] == "refused" and w["text"]]
    assert len(told) == 1  # once, not of its measures too


def test_a_field_that_is_nowhere_a_number_has_no_scale() -> None:
    made = scene(porelang.compile("sphere(10)").design(), Wish(paint="sqrt(-1 - x * x)", plane=True))
    assert (made.scale, made.plane, made.shown) == (None, None, "sqrt(-1 - x * x)")
    head, _ = read(packed(made))
    assert (head["nowhere"], head["scale"]) == ("sqrt(-1 - x * x)", None)
    thin = scene(porelang.compile("shell(sphere(4), 1e-6)").design(), Wish(paint="z"))
    assert thin.scale is not None  # no sample is in the wall
    assert thin.scale.ends == pytest.approx([-4, 4], abs=0.2)


# ---- the server -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[int, Path]]:
    path = tmp_path_factory.mktemp("served") / "part.pore"
    path.write_text("sphere(10)")
    opened, port = door()
    server = server_of(application(str(path), "right", port))
    thread = threading.Thread(target=lambda: asyncio.run(server.serve([opened])), daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield port, path
    server.should_exit = True
    thread.join(10)


def asked(port: int, path: str, **headers: str) -> tuple[int, bytes, Any]:
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    line.request("GET", path, headers=headers)
    answer = line.getresponse()
    return answer.status, answer.read(), answer.headers


def test_the_page_is_for_who_knows_its_address(served: tuple[int, Path]) -> None:
    port, _ = served
    status, body, headers = asked(port, "/right/")
    assert status == 200
    assert b"<canvas" in body
    assert "default-src 'self'" in headers["content-security-policy"]
    for name, (file, kind) in FILES.items():
        status, body, headers = asked(port, f"/right/{name}")
        assert (status, body) == (200, (WEB / file).read_bytes())
        assert headers["content-type"].startswith(kind)
    assert asked(port, "/wrong/")[0] == 403
    assert asked(port, "/")[0] in (403, 404)
    assert asked(port, "/right/", Host=f"evil.example:{port}")[0] == 403
    assert asked(port, "/right/", Origin="http://evil.example")[0] == 403
    for outside in ("../server.py", "..%2fserver.py", "/etc/passwd", "%2e%2e/%2e%2e/__init__.py", "made/x/../../y"):
        assert asked(port, f"/right/{outside}")[0] in (403, 404)


def opened(port: int, token: str = "right", origin: str | None = None, look: str = "") -> ClientConnection:
    own = f"http://127.0.0.1:{port}"
    return connect(f"ws://127.0.0.1:{port}/{token}/live{look}", origin=origin or own, max_size=1 << 24)  # type: ignore[arg-type]


def test_a_line_is_for_the_page_alone(served: tuple[int, Path]) -> None:
    port, _ = served
    for token, origin in (("wrong", None), ("right", "http://evil.example"), ("right", f"http://localhost:{port + 1}")):
        with pytest.raises(Exception, match="403"):
            opened(port, token, origin)
    with pytest.raises(Exception, match="403"):
        connect(f"ws://127.0.0.1:{port}/right/live")  # no browser


def until(line: ClientConnection, kind: str) -> Any:
    for _ in range(200):
        word = line.recv(timeout=30)
        if (isinstance(word, bytes) and kind == "scene") or (isinstance(word, str) and json.loads(word)["say"] == kind):
            return word if isinstance(word, bytes) else json.loads(word)
    raise AssertionError(kind)


def ended(line: ClientConnection) -> None:
    """The server ends the line, and says that it is for what was sent."""
    with contextlib.suppress(ConnectionClosed):
        for _ in range(200):
            line.recv(timeout=30)
    assert line.close_code in (1003, 1008, 1009)


def until_reaching(line: ClientConnection, x: float) -> None:
    """Scenes come quickly, and better ones after them."""
    while read(until(line, "scene"))[0]["hi"][0] != pytest.approx(x, abs=0.1):
        pass


def test_a_page_follows_the_file_however_it_is_saved(served: tuple[int, Path]) -> None:
    port, path = served
    with opened(port) as line:
        until(line, "scene")
        path.write_text("sphere(12)")
        until_reaching(line, 12)
        other = path.with_suffix(".new")
        other.write_text("sphere(14)")
        other.replace(path)  # as editors save
        assert until(line, "text")["text"] == "sphere(14)"
        until_reaching(line, 14)
        path.write_text("sphere(")
        assert "E005" in until(line, "program")["wrong"][0]
        path.write_text("sphere(11)")
        until_reaching(line, 11)


def test_a_file_that_cannot_be_read_is_told_and_waited_for(served: tuple[int, Path]) -> None:
    port, path = served
    text = path.read_text()
    path.unlink()
    with opened(port) as line:
        assert "E105" in until(line, "refused")["text"]
        line.send(json.dumps({"do": "discard"}))  # which reads it again
        assert "E105" in until(line, "refused")["text"]
        path.write_text(text)
        assert until(line, "text")["text"] == text


def test_what_is_started_again_is_told(look: Look, tmp_path: Path) -> None:
    page, path = look(BALL)
    assert page.said("program")["again"] == f"pore view {path}"
    hidden = Page(path, Start({}, None, {}, called="REPL"))
    hidden.live.begin()
    hidden.live.close()
    assert (hidden.said("program")["file"], hidden.said("program")["again"]) == ("REPL", "")


def test_nonsense_is_passed_over_or_ends_the_line(served: tuple[int, Path]) -> None:
    port, _ = served
    with opened(port) as line:
        until(line, "scene")
        for word in ({"do": "fly"}, {"do": "set", "settings": 3}, {"do": "show", "outputs": [1], "paint": 2}, {},
                     {"do": "set", "settings": {"nothing": 1, "r": [1]}}, {"do": "preset", "name": "none"},
                     {"do": "complete", "number": 1, "text": "sphere(", "offset": 10**9},
                     {"do": "complete", "number": 1, "text": "sphere(", "offset": -5}):  # fmt: skip
            line.send(json.dumps(word))
        line.send(json.dumps({"do": "style", "text": "let  a=1"}))
        assert until(line, "styled")["text"] == "let a = 1\n"  # it is still there
    for nonsense in ("{", "[1]", "x" * (LONGEST + 1), b"bytes"):
        with opened(port) as line:
            line.send(nonsense)
            ended(line)


def test_a_page_that_floods_is_dropped(served: tuple[int, Path]) -> None:
    port, _ = served
    with opened(port) as line:
        with contextlib.suppress(ConnectionClosed):  # before all are sent
            for _ in range(3 * MOST_A_SECOND):
                line.send('{"do": "fly"}')
        ended(line)


def test_who_listens_can_show_that_it_knows_a_page(served: tuple[int, Path]) -> None:
    port, _ = served
    nonce = "0123456789abcdef" * 2
    status, body, _ = asked(port, f"/known/{nonce}")
    assert (status, body.decode()) == (200, proof("right", nonce))
    assert b"right" not in body
    assert proof("wrong", nonce) != proof("right", nonce)
    assert asked(port, "/known/right")[0] == 403
    assert asked(port, f"/known/{nonce}", Host=f"evil.example:{port}")[0] == 403
    assert asked(port, f"/known/{nonce}", Origin="http://evil.example")[0] == 403


def test_a_token_is_kept_for_a_file_and_a_port_where_nobody_else_reads_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path / "cache"))
    first = token_of("a.pore", 8000, again=True)
    assert token_of("a.pore", 8000, again=True) == first
    assert len({first, token_of("b.pore", 8000, again=True), token_of("a.pore", 8001, again=True)}) == 3
    other = token_of("a.pore", 8000, again=False)
    assert other != first
    kept = [f for f in (tmp_path / "cache").iterdir() if f.read_text() == other]
    assert [f.stat().st_mode & 0o777 for f in kept] == [0o600]
    os.utime(kept[0], (time.time() - 90_000,) * 2)  # a day has gone by
    assert token_of("a.pore", 8000, again=True) != other
    seen = token_of("a.pore", 8000, again=True)
    kept[0].chmod(0o644)  # others may have read it
    assert token_of("a.pore", 8000, again=True) != seen
    (tmp_path / "cache").chmod(0o777)
    assert token_of("a.pore", 8000, again=True) != token_of("a.pore", 8000, again=True)


def test_a_file_that_is_gone_is_said_but_not_in_the_moment_of_a_save(tmp_path: Path) -> None:
    path = tmp_path / "part.pore"
    path.write_text("sphere(10)")
    watched = Watched(str(path))
    assert watched.gone() == ""
    path.rename(tmp_path / "other")
    assert [watched.gone() for _ in range(PATIENCE)] == ["", "", "", "is no longer there"]
    (tmp_path / "other").rename(path)
    assert watched.gone() == ""


def test_a_page_is_told_that_its_file_is_gone(served: tuple[int, Path]) -> None:
    port, path = served
    text = path.read_text()
    with opened(port) as line:
        until(line, "scene")
        path.unlink()
        assert until(line, "gone")["why"] == "is no longer there"
        line.send(json.dumps({"do": "save", "text": text, "over": False}))
        until(line, "saved")
        assert until(line, "gone")["why"] == ""
    assert path.read_text() == text


def test_an_address_is_looked_at_from_the_beginning(served: tuple[int, Path]) -> None:
    port, path = served
    path.write_text("param r = 10mm in 5mm..20mm\nsphere(r)")
    with opened(port, look="?p.r=15&paint=z&outputs=%00") as line:
        assert until(line, "program")["params"][0]["value"] == 15
        head, _ = read(until(line, "scene"))
        assert head["hi"][0] == pytest.approx(15, abs=0.1)
        assert head["scale"]["shown"] == "z"
