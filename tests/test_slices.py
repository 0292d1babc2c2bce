"""Layers for printing against the cross-sections that closed forms give."""

from __future__ import annotations

import json
import math
import os
import re
import struct
import tracemalloc
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import porelang
from porelang.analysis.box import Box
from porelang.cli import main
from porelang.progress import watching
from porelang.slices import Format, stack_of, write_layer_file, write_slices
from porelang.slices.outline import outlines

Points = NDArray[np.float64]
SVG = "{http://www.w3.org/2000/svg}"


def test_layers_of_a_ball_have_the_areas_of_discs(tmp_path: Path) -> None:
    program = porelang.compile("sphere(10)")
    found = write_slices(program.design(), tmp_path / "layers", 0.5, pixel=0.1)
    assert found["layers"] == 40
    for k in (0, 7, 20, 39):
        z = -10 + (k + 0.5) * 0.5
        exact = math.pi * (100 - z * z)
        picture = np.asarray(Image.open(tmp_path / "layers" / f"layer_{k:04}.png"))
        # a disc of radius r on a grid h errs by less than its rim of pixels, 2 pi r h, by far
        assert abs(np.count_nonzero(picture) * 0.01 - exact) < 0.1 * math.sqrt(2 * math.pi * math.sqrt(exact / math.pi))
        assert found["area"][k] == pytest.approx(np.count_nonzero(picture) * 0.01)
    assert found["volume"] == pytest.approx(4 / 3 * math.pi * 1000, rel=5e-3)


def test_pictures_have_y_up_and_x_right(tmp_path: Path) -> None:
    program = porelang.compile("(sphere(2) |> translate([6, 8, 0])) | sphere(0.5)")
    write_slices(program.design(), tmp_path / "layers", 1, pixel=0.25, bounds=(-10, -10, -0.5, 10, 10, 0.5))
    picture = np.asarray(Image.open(tmp_path / "layers" / "layer_0000.png"))
    rows, columns = np.nonzero(picture[:40])
    assert rows.mean() * 0.25 == pytest.approx(2, abs=0.3)  # 8 mm up is 2 mm below the top edge
    assert columns.mean() * 0.25 == pytest.approx(16, abs=0.3)


def rings_of(path: Path) -> list[Points]:
    """The rings of a layer in mm, with y up. Each is written as it is drawn: from a place, lines, and back to it."""
    (drawn,) = ET.parse(path).getroot().iter(f"{SVG}path")
    text = drawn.attrib["d"]
    assert re.fullmatch(r"(M[-\d.,]+(L[-\d.,]+)+Z)+", text)
    return [np.array([[float(v) for v in p.split(",")] for p in ring[1:].split("L")]) * [1, -1]
            for ring in text.split("Z")[:-1]]  # fmt: skip


def signed_area(ring: Points) -> float:
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize(
    ("text", "area"),
    [
        ("sphere(10)", lambda z: math.pi * (100 - z * z)),
        ("cone(9, 3, 20)", lambda z: math.pi * (6 - 0.3 * z) ** 2),
        ("box([18, 10, 20]) |> twist(7deg / 1mm)", lambda z: 180 + 0 * z),
    ],
)
@pytest.mark.parametrize("form", ["png", "svg"])
def test_each_layer_has_the_area_of_its_cross_section(
    text: str, area: Callable[[Points], Points], form: Format, tmp_path: Path
) -> None:
    """Pixels err at the rim alone, by chance: within 2 sqrt(pixels of the rim). Contours lose what chords cut off,
    h^2 pi/6 round a disc, what interpolation does to a curved field, h^2 pi/4, and half a pixel at a corner: 2 pixels.
    """
    h = 0.1
    found = write_slices(porelang.compile(text).design(), tmp_path / "layers", 1, form=form, pixel=h)
    z, areas = np.array(found["z"]), np.array(found["area"])
    assert z == pytest.approx(np.arange(-9.5, 10), abs=1e-5)
    exact = np.broadcast_to(area(z), z.shape)
    rim = 2 * np.sqrt(math.pi * exact) * 1.2  # of a disc; of the box it is a fifth more
    off = 2 * h * h * np.sqrt(rim / h) if form == "png" else 2 * h * h + 0 * rim
    assert (np.abs(areas - exact) < off).all()
    for name, total in zip(found["files"], areas, strict=True):
        if form == "svg":
            written = sum(map(signed_area, rings_of(tmp_path / "layers" / name)))
        else:
            written = np.count_nonzero(np.asarray(Image.open(tmp_path / "layers" / name))) * h * h
        assert written == pytest.approx(total, abs=1e-3 * h * rim.max())


def test_twisted_layers_turn_as_they_should(tmp_path: Path) -> None:
    """The long side of the box at height z lies at -rate * z: y is up and x to the right in either format."""
    program = porelang.compile("box([18, 6, 20]) |> twist(3deg / 1mm)")
    for form in ("png", "svg"):
        found = write_slices(program.design(), tmp_path / form, 4, form=form, pixel=0.1)
        for name, z in zip(found["files"], found["z"], strict=True):
            if form == "png":
                rows, columns = np.nonzero(np.asarray(Image.open(tmp_path / form / name)))
                x, y = columns * 1.0, -rows * 1.0
            else:
                (ring,) = rings_of(tmp_path / form / name)
                x, y = ring.T
            xx, yy, xy = np.var(x), np.var(y), np.cov(x, y)[0, 1]
            assert math.degrees(0.5 * math.atan2(2 * xy, xx - yy)) == pytest.approx(-3 * z, abs=0.5)


def test_contours_have_holes_the_other_way_round(tmp_path: Path) -> None:
    program = porelang.compile("(cylinder(10, 4) \\ cylinder(6, 10)) | cylinder(2, 4) |> translate([3, 0, 0])")
    found = write_slices(program.design(), tmp_path / "layers", 1, form="svg", pixel=0.2)
    rings = rings_of(tmp_path / "layers" / "layer_0001.svg")
    areas = [math.pi * r * r for r in (10, 6, 2)]
    assert sorted(map(signed_area, rings)) == pytest.approx(sorted([areas[0], -areas[1], areas[2]]), rel=3e-3)
    island = min(rings, key=lambda ring: abs(signed_area(ring)))
    assert island.mean(axis=0) == pytest.approx([3, 0], abs=0.02)
    root = ET.parse(tmp_path / "layers" / "layer_0001.svg").getroot()
    x0, y0, *_ = found["bounds"][0]
    x1, y1, *_ = found["bounds"][1]
    assert root.attrib["width"].endswith("mm")
    assert float(root.attrib["width"][:-2]) == pytest.approx(x1 - x0)
    assert [float(v) for v in root.attrib["viewBox"].split()] == pytest.approx([x0, -y1, x1 - x0, y1 - y0])
    assert root.findtext(f"{SVG}title") == f"layer 1 of 4, z = {found['z'][1]:.10g} mm"


def test_every_set_of_corners_is_parted_as_its_signs_say() -> None:
    """On random samples: rings close, cross no pixel that they should not, and part solid from void."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(40, 30))
    stack = stack_of(Box((0.0, 0.0, 0.0), (40.0, 30.0, 1.0)), 1.0, 1.0)
    framed = np.pad(values, 1, constant_values=1.0)
    rings = outlines(iter([framed[:1], framed[1:17], framed[17:]]), stack)
    points = np.stack(np.meshgrid(stack.x, stack.y, indexing="ij"), axis=-1).reshape(-1, 2)
    turns = np.zeros(len(points))
    for ring in rings:
        assert np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).max() < math.sqrt(2) + 1e-9
        to = ring[None] - points[:, None]
        angle = np.arctan2(to[..., 1], to[..., 0])
        turn = np.diff(np.concatenate([angle, angle[:, :1]], axis=1), axis=1)
        turns += np.sum((turn + math.pi) % math.tau - math.pi, axis=1) / math.tau
    assert np.round(turns).reshape(40, 30) == pytest.approx((values < 0) * 1.0)
    # where two solid corners lie across, the mean of the four tells whether they are joined
    joined = np.array([[-2.0, 1.0], [1.0, -2.0]])
    two = stack_of(Box((0.0, 0.0, 0.0), (2.0, 2.0, 1.0)), 1.0, 1.0)
    assert len(outlines([np.pad(joined, 1, constant_values=1.0)], two)) == 1
    assert len(outlines([np.pad(joined + 0.9, 1, constant_values=1.0)], two)) == 2


def test_contours_of_solid_that_reaches_the_bounds_end_there(tmp_path: Path) -> None:
    found = write_slices(porelang.compile("sphere(50)").design(), tmp_path / "layers", 2, form="svg", pixel=0.5,
                         bounds=(-4, -3, 0, 4, 3, 2))  # fmt: skip
    (ring,) = rings_of(tmp_path / "layers" / found["files"][0])
    assert found["area"] == pytest.approx([48], abs=0.2)  # but for its corners
    assert np.abs(ring).max(axis=0) == pytest.approx([4, 3])


def test_pictures_know_their_size(tmp_path: Path) -> None:
    """A pixel of 0.05 mm is 20000 to the metre, and 20 x 8 mm are 400 x 160 of them."""
    write_slices(
        porelang.compile("box([20, 8, 3])").design(), tmp_path / "layers", 1, pixel=0.05, bounds=(-10, -4, 0, 10, 4, 1)
    )
    data = (tmp_path / "layers" / "layer_0000.png").read_bytes()
    at = data.index(b"pHYs") + 4
    assert struct.unpack(">IIB", data[at : at + 9]) == (20000, 20000, 1)
    with Image.open(tmp_path / "layers" / "layer_0000.png") as picture:
        assert picture.size == (400, 160)
        assert np.asarray(picture).all()


@pytest.mark.parametrize(
    ("step", "heights", "last"), [(100, [0], 4), (3, [-0.5, 1.5], 1), (1, [-1.5, -0.5, 0.5, 1.5], 1)]
)
def test_the_last_layer_is_as_thick_as_what_is_left(
    step: float, heights: list[float], last: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A step larger than the part makes one layer, at the middle of the part."""
    source = tmp_path / "plate.pore"
    source.write_text("box([10, 10, 4])\n")
    out = tmp_path / "out"
    assert main(["slices", str(source), "-o", str(out), "--step", f"{step}mm", "--voxel", "0.5mm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["z"] == pytest.approx(heights)
    assert found["area"] == pytest.approx([100] * len(heights))
    assert found["volume"] == pytest.approx(400)
    assert main(["slices", str(source), "-o", str(out), "--step", f"{step}mm", "--voxel", "0.5mm"]) == 0
    assert ("filled to" in capsys.readouterr().out) == (last < step)


def test_names_sort_in_the_order_of_layers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = porelang.compile("box([1, 1, 100.01])")
    found = write_slices(program.design(), tmp_path / "layers", 1, pixel=0.5)
    assert json.loads((tmp_path / "layers" / "layers.json").read_text()) == found
    assert sorted(os.listdir(tmp_path / "layers")) == [*found["files"], "layers.json"]
    monkeypatch.setattr("porelang.slices.write._png", lambda *_: 1.0)  # ten thousand files take long
    monkeypatch.setattr("porelang.slices.write.digest_of", lambda _: "")
    many = write_slices(program.design(), tmp_path / "layers", 0.01, pixel=0.5)
    assert many["layers"] == 10001
    assert sorted(set(many["files"])) == many["files"]
    assert (np.diff(many["z"]) > 0).all()


@pytest.mark.parametrize("form", ["png", "svg"])
def test_memory_is_that_of_a_band(form: Format, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A layer of 4 million pixels: its values alone are 16 MB in float32, which is solid 4 MB."""
    program = porelang.compile("gyroid(30) & cylinder(75, 30)")
    write_slices(program.design(), tmp_path / "layers", 40, form=form, pixel=10)
    monkeypatch.setattr("porelang.slices.stack.AT_ONCE", 1 << 17)
    tracemalloc.start()
    write_slices(program.design(), tmp_path / "layers", 40, form=form, pixel=150 / 2000)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 14e6


def test_a_part_cut_by_bounds_is_closed_there(tmp_path: Path) -> None:
    program = porelang.compile("gyroid(10)")
    write_slices(program.design(), tmp_path / "layers", 5, form="svg", pixel=0.25, bounds=(-10, -10, 0, 10, 10, 5))
    text = (tmp_path / "layers" / "layer_0000.svg").read_text()
    assert text.count("M") == text.count("Z") > 0


def test_layers_do_not_depend_on_what_is_computed_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = porelang.compile("gyroid(7) & sphere(9)")
    for form in ("png", "svg"):
        whole = write_slices(program.design(), tmp_path / "a", 0.5, form=form)
        with monkeypatch.context() as few:
            few.setattr("porelang.slices.stack.AT_ONCE", 100)  # less than a layer: bands of two rows
            bands = write_slices(program.design(), tmp_path / "b", 0.5, form=form)
        assert bands == whole
        for name in whole["files"]:
            assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_folders_are_written_whole_or_not_at_all(tmp_path: Path) -> None:
    program = porelang.compile("sphere(3)")
    target = tmp_path / "layers"

    def fails(what: str, done: int, of: int) -> None:
        raise KeyboardInterrupt

    with watching(fails), pytest.raises(KeyboardInterrupt):
        write_slices(program.design(), target, 1)
    assert list(tmp_path.iterdir()) == []
    write_slices(program.design(), target, 1)
    write_slices(program.design(), target, 0.5)  # an older folder of layers is replaced
    assert json.loads((target / "layers.json").read_text())["layers"] == 12
    other = tmp_path / "mine"
    other.mkdir()
    (other / "thesis.txt").write_text("x")
    with pytest.raises(porelang.PoreError, match="E113"):
        write_slices(program.design(), other, 1)
    assert (other / "thesis.txt").exists()


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ball.pore"
    path.write_text("param r = 5mm in 1mm..9mm\nsphere(r)\n")
    out = tmp_path / "out"
    assert main(["slices", str(path), "-o", str(out), "--step", "1mm", "--set", "r=4mm", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["layers"] == 8
    assert main(["slices", str(path), "-o", str(out), "--step", "0.0000001mm"]) == 2
    assert "too many" in capsys.readouterr().err
    for step in ("0", "-1mm", "1deg"):
        assert main(["slices", str(path), "-o", str(out), "--step", step]) == 2
        assert "--step" in capsys.readouterr().err
    assert main(["slices", str(path), "-o", str(path), "--step", "1"]) == 2
    assert "is a file" in capsys.readouterr().err


def test_stopped_it_says_that_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ball.pore"
    path.write_text("sphere(5)\n")

    def stopped(*_: object) -> float:
        raise KeyboardInterrupt

    monkeypatch.setattr("porelang.slices.write._png", stopped)
    assert main(["slices", str(path), "-o", str(tmp_path / "out"), "--step", "1"]) == 130
    assert "nothing is written" in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["ball.pore"]


def test_layers_that_hold_nothing_are_refused_and_replace_nothing(tmp_path: Path) -> None:
    design = porelang.compile("gyroid(5) |> shell(0.8) & cube(20)").design()
    write_slices(design, tmp_path / "layers", 2.0)
    before = sorted(p.name for p in (tmp_path / "layers").iterdir())
    with pytest.raises(porelang.PoreError, match="no layer holds material"):
        write_slices(design, tmp_path / "layers", 1e9)
    assert sorted(p.name for p in (tmp_path / "layers").iterdir()) == before


# ---- one file -------------------------------------------------------------------------------------------------------


def read_common(path: Path) -> tuple[dict[str, str], list[tuple[float, list[tuple[int, Points]]]]]:
    """The header of a file of the Common Layer Interface, and its layers: height, and contours with directions."""
    lines = path.read_text(encoding="ascii").split("\n")
    assert lines[:2] == ["$$HEADERSTART", "$$ASCII"]
    ends = lines.index("$$HEADEREND")
    assert lines[ends + 1] == "$$GEOMETRYSTART"
    assert lines[-2:] == ["$$GEOMETRYEND", ""]
    layers: list[tuple[float, list[tuple[int, Points]]]] = []
    for line in lines[ends + 2 : -2]:
        word, _, rest = line.partition("/")
        if word == "$$LAYER":
            layers.append((float(rest), []))
            continue
        assert word == "$$POLYLINE"
        _, direction, count, *numbers = rest.split(",")
        ring = np.array(numbers, float).reshape(-1, 2)
        assert len(ring) == int(count)
        np.testing.assert_array_equal(ring[0], ring[-1])
        layers[-1][1].append((int(direction), ring[:-1]))
    return dict(line.partition("/")[::2] for line in lines[2:ends]), layers


def enclosed(ring: Points) -> float:
    x, y = ring.T
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)


def test_one_file_holds_all_layers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """A tube: outer contours counter-clockwise, holes clockwise, areas of rings, heights from the lowest to the top."""
    monkeypatch.chdir(tmp_path)
    Path("tube.pore").write_text("cylinder(10, 5.3) \\ cylinder(4, 9)\n")
    assert main(["slices", "tube.pore", "-o", "tube.cli", "--step", "0.5", "--voxel", "0.2", "-q"]) == 0
    header, layers = read_common(Path("tube.cli"))
    assert (header["$$UNITS"], header["$$VERSION"], header["$$LABEL"]) == ("1", "200", "1,part")
    np.testing.assert_allclose(
        [float(v) for v in header["$$DIMENSION"].split(",")], [-10, -10, -2.65, 10, 10, 2.65], atol=0.01
    )
    assert int(header["$$LAYERS"]) == len(layers) == 12
    heights = np.array([z for z, _ in layers])
    np.testing.assert_allclose(heights, [*(-2.65 + 0.5 * np.arange(11)), 2.65], atol=0.006)
    assert layers[0][1] == []  # where the lowest begins
    for _, rings in layers[1:]:
        assert sorted(direction for direction, _ in rings) == [0, 1]
        assert all((enclosed(ring) > 0) == (direction == 1) for direction, ring in rings)
        assert sum(enclosed(ring) for _, ring in rings) == pytest.approx(math.pi * (100 - 16), rel=2e-3)
    Path("tube.cli").write_text("mine")
    assert main(["slices", "tube.pore", "-o", "tube.cli", "--step", "0.5", "--format", "svg"]) == 2
    assert "leave it out" in capsys.readouterr().err
    assert main(["slices", "tube.pore", "-o", "tube.pore", "--step", "0.5"]) != 0  # a folder would be in its way
    assert main(["slices", "tube.pore", "-o", "tube.cli", "--step", "9", "--bounds", "20,20,20,21,21,21"]) == 1
    assert Path("tube.cli").read_text() == "mine"
    assert not list(tmp_path.glob(".*"))


def test_its_contours_are_those_of_the_folder(tmp_path: Path) -> None:
    design = porelang.compile("gyroid(4) & cube(8)").design()
    one = write_layer_file(design, tmp_path / "a.cli", 1, pixel=0.25)
    many = write_slices(design, tmp_path / "b", 1, form="svg", pixel=0.25)
    assert one["area"] == many["area"]
    assert one["volume"] == many["volume"]
