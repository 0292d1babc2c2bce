"""Distances from fields that are none: walls in mm, measured along normals by independent code."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.compiler import try_compile
from porelang.source import Source

Points = NDArray[np.float64]


def gradient(f: porelang.Field, p: Points, h: float = 1e-3) -> Points:
    return np.stack([(f(p + h * e) - f(p - h * e)) / (2 * h) for e in np.eye(3)], 1)


def on_surface(f: porelang.Field, period: float) -> tuple[Points, Points]:
    """Points of a lattice's surface, and the normals there."""
    p = np.random.default_rng(0).uniform(0, period, (3000, 3))
    for _ in range(30):
        g = gradient(f, p)
        p = p - 0.8 * (f(p) / np.maximum((g * g).sum(1), 1e-4))[:, None] * g
    p = p[np.abs(f(p)) < 1e-8]
    assert len(p) > 2500
    g = gradient(f, p)
    return p, g / np.linalg.norm(g, axis=1)[:, None]


def walls(d: porelang.Field, p: Points, n: Points, t: float) -> Points:
    """How thick the wall of a distance is at points, along their normals: where it is t / 2 on either side."""
    sides = []
    for way in (1.0, -1.0):
        low, high = np.zeros(len(p)), np.full(len(p), t)
        for _ in range(40):
            middle = (low + high) / 2
            inside = way * d(p + (way * middle)[:, None] * n) < t / 2
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        sides.append(low)
    return sides[0] + sides[1]


#: Up to which part of the period walls are true to 1 %: the whole of a fifth, or as far as the sheets' bend allows.
TRUE_TO = {
    "gyroid": 0.2,
    "schwarz_p": 0.2,
    "diamond": 0.2,
    "double_diamond": 0.2,
    "iwp": 0.2,
    "c_pmy": 0.2,
    "c_y": 0.1,
    "fischer_koch_s": 0.1,
    "double_gyroid": 0.1,
    "c_d": 0.02,
}


@pytest.mark.parametrize("lattice", TRUE_TO)
def test_walls_are_as_thick_as_they_say(lattice: str) -> None:
    program = porelang.compile(f"out raw = {lattice}(10)\nout d = metric({lattice}(10))")
    p, n = on_surface(program.field("raw"), 10)
    d = program.field("d")
    for share in (0.02, 0.05, 0.1, 0.2):
        if share <= TRUE_TO[lattice]:
            found = walls(d, p, n, 10 * share) / (10 * share)
            assert np.quantile(np.abs(found - 1), 0.99) < 0.01, share


#: Of the surfaces in a cube of one period: area over its square, and Euler characteristic (A. Schoen, 1970).
SURFACES = {"gyroid": (3.0915, -8), "schwarz_p": (2.3451, -4), "diamond": (3.8378, -16)}


@pytest.mark.parametrize("lattice", SURFACES)
def test_the_volume_of_walls_is_that_of_a_tube(lattice: str) -> None:
    """Weyl's: area times thickness, and pi chi t^3 / 6 for the bend; nodal surfaces have up to 0.5 % more area."""
    area, chi = SURFACES[lattice]
    program = porelang.compile(f"param t = 1mm in 0.1mm..2mm\nmetric({lattice}(10)) |> shell(t)")
    axis = (np.arange(120) + 0.5) / 12
    for t in (0.5, 1.0, 1.5):
        share = float((program.field(dtype="f32", t=t).on_grid([axis] * 3).all() < 0).mean())
        expected = (100 * area * t + math.pi * chi * t**3 / 6) / 1000
        assert share == pytest.approx(expected, rel=6e-3)


def test_a_thickness_that_varies_five_to_one() -> None:
    program = porelang.compile(
        "let t = mix(0.2mm, 1mm, ramp(z, 0, 30))\n"
        "out raw = gyroid(10)\nout wall = shell(metric(gyroid(10)), t)\nout t_there = t + 0 * x"
    )
    p, n = on_surface(program.field("raw"), 30)
    wall, asked = program.field("wall"), program.field("t_there")(p)
    sides = []
    for way in (1.0, -1.0):
        low, high = np.zeros(len(p)), np.full(len(p), 1.0)
        for _ in range(40):
            middle = (low + high) / 2
            inside = wall(p + (way * middle)[:, None] * n) < 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        sides.append(low)
    assert np.abs((sides[0] + sides[1]) / asked - 1).max() < 0.02


def test_a_distance_of_a_quadric_is_one() -> None:
    """x^2 + y^2 + z^2 - 25 is no distance; metric is |p| - 5 about its surface, and has its sign everywhere."""
    d = porelang.compile("metric(dot(p, p) - 25)").field()
    r = np.linspace(1, 12, 200)
    way = np.array([0.6, 0.0, 0.8])
    found = d(r[:, None] * way)
    near = np.abs(r - 5) < 1
    assert np.allclose(found[near], r[near] - 5, atol=0.003)
    assert (np.sign(found) == np.sign(r - 5)).all()


@pytest.mark.parametrize("lattice", ["gyroid", "neovius", "lidinoid", "w_surface", "fischer_koch_s"])
@pytest.mark.parametrize("steps", [1, 2, 3])
def test_its_sign_is_that_of_the_field(lattice: str, steps: int) -> None:
    """So that no wall comes from nowhere, however wild the lattice is between its sheets."""
    program = porelang.compile(f"out raw = {lattice}(10)\nout d = metric({lattice}(10), {steps})")
    p = np.random.default_rng(1).uniform(-10, 10, (20000, 3))
    raw, d = program.field("raw")(p), program.field("d")(p)
    assert np.isfinite(d).all()
    assert (np.sign(d) == np.sign(raw)).all()


@pytest.mark.parametrize(
    "lattice",
    [
        "twist(gyroid(10), 90deg / 60mm)",
        "gyroid(10 + z / 20)",
        "rotate(schwarz_p([8, 10, 12]), [1, 2, 3], 35deg)",
        "morph(gyroid(10), schwarz_p(10), 0.3)",
    ],
)
def test_walls_of_what_was_bent_are_as_thick_as_they_say(lattice: str) -> None:
    program = porelang.compile(f"out raw = {lattice}\nout d = metric({lattice})")
    p, n = on_surface(program.field("raw"), 10)
    found = walls(program.field("d"), p, n, 0.8) / 0.8
    assert np.quantile(np.abs(found - 1), 0.98) < 0.01


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_a_wall_on_one_side_is_as_thick_as_it_says(side: str) -> None:
    program = porelang.compile(f'out raw = gyroid(10)\nout wall = shell(metric(gyroid(10)), 0.7mm, side="{side}")')
    p, n = on_surface(program.field("raw"), 10)
    way = -1.0 if side == "inside" else 1.0
    wall = program.field("wall")
    assert (wall(p + way * 0.01 * n) < 0).all()
    assert (wall(p + way * 0.69 * n) < 0).all()
    assert (wall(p + way * 0.71 * n) > 0).all()
    assert (wall(p - way * 0.01 * n) > 0).all()


def test_of_a_distance_there_is_nothing_to_do() -> None:
    program = porelang.compile("out d = box([20, 30, 40], round=3)\nout m = metric(box([20, 30, 40], round=3))")
    p = np.random.default_rng(3).uniform(-18, 18, (20000, 3))
    d, m = program.field("d")(p), program.field("m")(p)
    near = np.abs(d) < 1
    assert np.quantile(np.abs(m - d)[near], 0.99) < 1e-6


def test_a_lattice_in_a_shape_has_the_distance_to_both() -> None:
    program = porelang.compile(
        "out both = metric(gyroid(10) & sphere(20))\nout one = metric(gyroid(10))\nout other = sphere(20)"
    )
    p = np.random.default_rng(4).uniform(-14, 14, (20000, 3))
    both, one, other = (program.field(name)(p) for name in ("both", "one", "other"))
    deep = other < -3  # where the lattice decides
    assert np.abs(both - one)[deep & (np.abs(one) < 1)].max() < 1e-9


@pytest.mark.parametrize("lattice", ["gyroid(10)", "schwarz_p(10)", "diamond(10)", "x * y * z", "(x^2 + y^2 - 9)^2"])
def test_where_a_field_is_level_the_value_is_a_number(lattice: str) -> None:
    """Middles of cells and channels, saddles, axes: all of the places of eighths of a period."""
    d = porelang.compile(f"metric({lattice} + 0 * x)").field()
    axis = np.arange(-8, 9) * 1.25
    p = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    found = d(p)
    assert np.isfinite(found).all()
    raw = porelang.compile(f"{lattice} + 0 * x").field()(p)
    clear = np.abs(raw) > 1e-9
    assert (np.sign(found) == np.sign(raw))[clear].all()


@pytest.mark.parametrize(
    ("solid", "distance"),
    [
        ("box([20, 24, 30])", lambda p: (np.abs(p) - [10, 12, 15]).max(1)),
        ("cylinder(10, 20)", lambda p: np.maximum(np.hypot(p[:, 0], p[:, 1]) - 10, np.abs(p[:, 2]) - 10)),
        ("extrude(rect(20, 24), 30)", lambda p: (np.abs(p) - [10, 12, 15]).max(1)),
        ("scale(box([10, 12, 15]), 2)", lambda p: (np.abs(p) - [10, 12, 15]).max(1)),
    ],
)
def test_the_inside_of_what_has_corners_is_a_distance(solid: str, distance: Callable[[Points], Points]) -> None:
    """Where the length of what lies beyond the faces is 0 over all of the inside, its slopes and bends are 0."""
    d = porelang.compile(f"metric({solid})").field()
    p = np.random.default_rng(5).uniform(-9, 9, (5000, 3))
    p = p[distance(p) > -3]  # about the axis of a cylinder, where its sheets meet, it is a guess
    assert np.allclose(d(p), distance(p), atol=1e-9)


@pytest.mark.parametrize(
    "field", ["twist(box([20, 20, 50]), 0.05)", "gyroid(8) & cylinder(15, 40)", "cone(10, 2, 20)",
              "gyroid(10 - cube(20) / 40)", "gyroid(10 + hypot(x, y) / 5)", "polar(gyroid(6), 30)"],
)  # fmt: skip
def test_it_is_a_number_also_at_axes_and_within_corners(field: str) -> None:
    found, program = try_compile(Source("part.pore", f"out raw = {field}\nout d = metric({field})"))[::-1]
    assert program is not None
    assert not [d for d in found if d.code == "W201"]
    axis = np.linspace(-12, 12, 13)  # through the axes, and corners of the boxes
    p = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    raw, d = program.field("raw")(p), program.field("d")(p)
    assert np.isfinite(d).all()
    clear = np.abs(raw) > 1e-9
    assert (np.sign(d) == np.sign(raw))[clear].all()
