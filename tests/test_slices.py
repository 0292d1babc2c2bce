"""Layers for printing against the cross-sections that closed forms give."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import porelang
from porelang.cli import main
from porelang.slices import write_slices


def test_layers_of_a_ball_have_the_areas_of_discs(tmp_path: Path) -> None:
    program = porelang.compile("sphere(10)")
    found = write_slices(program, tmp_path / "layers", 0.5, pixel=0.1)
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
    write_slices(program, tmp_path / "layers", 1, pixel=0.25, bounds=(-10, -10, -0.5, 10, 10, 0.5))
    picture = np.asarray(Image.open(tmp_path / "layers" / "layer_0000.png"))
    rows, columns = np.nonzero(picture[:40])
    assert rows.mean() * 0.25 == pytest.approx(2, abs=0.3)  # 8 mm up is 2 mm below the top edge
    assert columns.mean() * 0.25 == pytest.approx(16, abs=0.3)


def test_contours_are_closed_and_enclose_the_area(tmp_path: Path) -> None:
    program = porelang.compile("cylinder(10, 4) \\ cylinder(6, 10)")
    write_slices(program, tmp_path / "layers", 1, form="svg", pixel=0.2)
    root = ET.parse(tmp_path / "layers" / "layer_0001.svg").getroot()
    area = 0.0
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        for ring in path.attrib["d"].split("Z")[:-1]:
            xy = np.array([[float(v) for v in p.split(",")] for p in ring[1:].split("L")])
            x, y = xy.T
            area += 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert abs(area) == pytest.approx(math.pi * (100 - 36), rel=2e-3)


def test_a_part_cut_by_bounds_is_closed_there(tmp_path: Path) -> None:
    program = porelang.compile("gyroid(10)")
    write_slices(program, tmp_path / "layers", 5, form="svg", pixel=0.25, bounds=(-10, -10, 0, 10, 10, 5))
    text = (tmp_path / "layers" / "layer_0000.svg").read_text()
    assert text.count("M") == text.count("Z") > 0


def test_memory_does_not_grow_with_layers_nor_do_their_values(tmp_path: Path) -> None:
    """A layer does not depend on how many are computed together."""
    from porelang import slices

    program = porelang.compile("gyroid(7) & sphere(9)")
    whole = write_slices(program, tmp_path / "a", 0.5)
    few = slices._AT_ONCE
    try:
        slices._AT_ONCE = 1
        single = write_slices(program, tmp_path / "b", 0.5)
    finally:
        slices._AT_ONCE = few
    assert whole["area"] == single["area"]


def test_folders_are_written_whole_or_not_at_all(tmp_path: Path) -> None:
    program = porelang.compile("sphere(3)")
    target = tmp_path / "layers"

    def fails(done: int, of: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_slices(program, target, 1, progress=fails)
    assert list(tmp_path.iterdir()) == []
    write_slices(program, target, 1)
    write_slices(program, target, 0.5)  # an older folder of layers is replaced
    assert json.loads((target / "layers.json").read_text())["layers"] == 12
    other = tmp_path / "mine"
    other.mkdir()
    (other / "thesis.txt").write_text("x")
    with pytest.raises(porelang.PoreError, match="E113"):
        write_slices(program, other, 1)
    assert (other / "thesis.txt").exists()


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ball.pore"
    path.write_text("param r = 5mm in 1mm..9mm\nsphere(r)\n")
    out = tmp_path / "out"
    assert main(["slices", str(path), "-o", str(out), "--step", "1mm", "--set", "r=4mm", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["layers"] == 8
    assert main(["slices", str(path), "-o", str(out), "--step", "0.0000001mm"]) == 2
    assert "too many" in capsys.readouterr().err
