"""The scale of field planes: its numbers, its colours, and the room that it takes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import porelang
from porelang.cli import main
from porelang.expression import expression
from porelang.render import Wishes, render_output
from porelang.render.camera import VIEWS
from porelang.render.picture import legend_of
from porelang.render.planes import Plane
from porelang.render.scale import COLOURS, Scale, numbers

BALL = porelang.compile("sphere(20)").design()
FACE = Wishes((500, 400), VIEWS["top"], "orthographic", samples=1, slices=(Plane(2, 0.0),), solid="none")
BOX = (-40.0, -40.0, -40.0, 40.0, 40.0, 40.0)


@pytest.mark.parametrize(
    ("scale", "expected"),
    [
        (Scale(10, 52), [0, 20, 40]),
        (Scale(1, 3), [-1, 0, 1, 2, 3]),
        (Scale(0.02, 0.02), [-0.02, -0.01, 0, 0.01, 0.02]),
        (Scale(7e6, 5e3), [-6e6, -4e6, -2e6, 0]),
    ],
)
def test_numbers_are_round_and_zero_is_among_them(scale: Scale, expected: list[float]) -> None:
    assert numbers(scale) == pytest.approx(expected)


def test_the_bar_has_the_colours_of_the_plane_and_the_picture_its_size() -> None:
    plain = render_output(BALL, None, FACE, BOX)
    made = render_output(BALL, None, replace(FACE, legend="mm"), BOX)
    assert made.pixels.shape == plain.pixels.shape == (400, 500, 4)
    strip = 7 * 10
    bar = made.pixels[:, 500 - strip + 9, :3].astype(float)
    rows = np.arange(100, 300)
    assert made.scale is not None
    assert np.abs(bar[rows[2]] - 255 * COLOURS[-1]).max() < 12  # blue, the highest, is on top
    assert np.abs(bar[rows[-3]] - 255 * COLOURS[0]).max() < 12
    zero = rows[0] + made.scale.high / (made.scale.low + made.scale.high) * (len(rows) - 1)
    assert np.abs(bar[round(zero)] - 255 * COLOURS[4]).max() < 12
    # something is written beside it, and all of it is within the picture
    ink = (made.pixels[:, 500 - strip :, :3].max(axis=2) < 100).any(axis=0)
    assert ink[20:60].any()
    assert not ink[-2:].any()


def test_the_unit_is_that_of_the_field_where_it_is_known() -> None:
    program = porelang.compile("let load = 3MPa + x\nlet d = sphere(3)\nlet a = 5deg + x\nout part = sphere(9)")
    asked = ("load", "d", "a", "part", "2 * load", "load / 2MPa", "load * 1mm")
    found = [legend_of(expression(program, text, "--field")) for text in asked]
    assert found == ["MPa", "", "rad", "", "MPa", "", "N/mm"]


def test_the_command_draws_a_legend_of_the_range_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, out = tmp_path / "ball.pore", tmp_path / "a.png"
    source.write_text("sphere(20)\n")
    line = ["render", str(source), "-o", str(out), "--size", "300x200", "--slice", "z=0", "--solid", "none", "--json"]
    assert main([*line, "--range", "-5..10", "--legend", "distance, mm", "--samples", "1", "--view", "top"]) == 0
    assert json.loads(capsys.readouterr().out)["slice_range"] == [-5, 10]
    with Image.open(out) as image:
        assert image.size == (300, 200)
        red = np.asarray(image.convert("RGB"), dtype=float)[100, 118]  # the middle of the ball, beyond full red
    assert np.abs(red - 255 * COLOURS[0]).max() < 8
