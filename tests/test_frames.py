"""Local frames: fields turned along a direction, the turns that are taken for one, and where there is no direction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import porelang

Array = NDArray[np.float64]
RNG = np.random.default_rng(7)
P: Array = RNG.uniform(-30, 30, (2000, 3))


def at(text: str, points: Array = P) -> Array:
    """A program's part at points (n, 3)."""
    return np.asarray(porelang.compile(text).field("part")(points))


def gyroid(points: Array, w: float) -> Array:
    x, y, z = (points * (math.tau / w)).T
    value: Array = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return value


def written(v: Array) -> str:
    return f"[{', '.join(repr(float(c)) for c in v)}]"


@pytest.mark.parametrize("seed", range(5))
def test_a_direction_that_is_the_same_everywhere_is_a_rotation(seed: int) -> None:
    """The axes: v, then what is at right angles to it in the plane that `up` leaves, by Gram and Schmidt."""
    v, up, about = np.random.default_rng(seed).normal(size=(3, 3))
    third = up - (up @ v) / (v @ v) * v
    frame = np.array([v / np.linalg.norm(v), np.zeros(3), third / np.linalg.norm(third)])
    frame[1] = np.cross(frame[2], frame[0])
    turn = Rotation.from_matrix(frame)
    expected = gyroid(about + turn.apply(P - about), 10)
    found = at(f"align(gyroid(10), {written(3 * v)}, up={written(up)}, about={written(about)})")
    assert np.abs(found - expected).max() < 1e-12


def test_along_x_nothing_is_turned() -> None:
    assert np.abs(at("align(gyroid(10), [2, 0, 0], about=[1, 2, 3])") - gyroid(P, 10)).max() < 1e-12


#: Fields that no turn leaves as they are, and directions of every sort.
LUMP = "(x + 2 * y + 5 * z + x * y / 7)"
WAYS = ["p", "[y, x, 0]", "[0, 0, z]", "grad(torus(20, 5))", "[0, 3, 0]", "[1, -3, 0]", "[0, 1, -3]", "[1e-9, 0, 0]"]


@pytest.mark.parametrize("way", WAYS)
def test_opposite_directions_are_one_with_symmetry_2(way: str) -> None:
    there, back = (f"align({LUMP}, {sign}1 * {way}, symmetry=2, about=[1, 2, 3])" for sign in ("", "-"))
    assert (at(there) == at(back)).all()
    plain = [at(f"align({LUMP}, {sign}1 * {way})") for sign in ("", "-")]
    assert np.abs(plain[0] - plain[1]).max() > 1  # without it they are two


@pytest.mark.parametrize("way", ["[x, y, 0]", "[y, x, 0]", "grad(cylinder(9, 900))", "[0, 3, 0]"])
def test_quarter_turns_are_one_with_symmetry_4(way: str) -> None:
    """About z, for directions at right angles to it."""
    text = f"let v = {way}\nlet turned = q => [-q.y, q.x, 0]\nalign({LUMP}, {{}}, symmetry=4, about=[1, 2, 3])"
    values = [at(text.format(v)) for v in ("v", "turned(v)", "turned(turned(v))", "turned(turned(turned(v)))")]
    for other in values[1:]:
        assert np.abs(other - values[0]).max() < 1e-12 * 200


def test_a_frame_is_right_handed_and_of_unit_vectors() -> None:
    for way in [*WAYS, "[0, 0, 0]", "0 * p"]:
        for symmetry in (1, 2, 4):
            text = f"let e = frame_from({way}, symmetry={symmetry})\n" + "\n".join(
                f"out e{k}{axis} = e[{k}].{axis}" for k in range(3) for axis in "xyz"
            )
            program = porelang.compile(text)
            points = np.concatenate([P, np.zeros((1, 3)), np.eye(3), -np.eye(3)])
            e = np.array([[np.broadcast_to(program.field(f"e{k}{axis}")(points), len(points)) for axis in "xyz"]
                          for k in range(3)])  # fmt: skip
            e = e.transpose(2, 0, 1)
            assert np.abs(e @ e.transpose(0, 2, 1) - np.eye(3)).max() < 1e-12
            assert np.linalg.det(e) == pytest.approx(np.ones(len(points)))


@pytest.mark.parametrize("dtype", ["f64", "f32"])
def test_there_is_a_number_at_every_singular_point(dtype: str) -> None:
    points = np.array([[0, 0, 0], [0, 0, 5], [0, 0, -5], [5, 0, 0], [1e-30, 0, 3], [-1e-20, 1e-20, 3]])
    for way in ("p", "grad(sphere(5))", "grad(cylinder(5, 9))", "[x, y, 0]", "0 * p", "grad(0 * x)"):
        for symmetry in (1, 2, 4):
            field = porelang.compile(f"align(gyroid(7), {way}, symmetry={symmetry})").field("part", dtype=dtype)
            assert np.isfinite(field(points)).all()


def jump(text: str, points: Array, step: Array) -> float:
    """The largest change of a field from one side of a place to the other."""
    return float(np.abs(at(text, points + step) - at(text, points - step)).max())


@pytest.mark.parametrize(
    "lattice",
    [
        "schwarz_p(10), {}, symmetry=2",
        "schwarz_p(10), {}, symmetry=4",
        "neovius(10), {}, symmetry=4",
        "iwp(10), {}, symmetry=4",
        "gyroid(10), {}, symmetry=2, about=[0, 2.5, 0]",
        "diamond(10), {}, symmetry=2, about=[1.25, 1.25, 0]",
    ],
)
def test_a_lattice_with_such_an_axis_has_no_break(lattice: str) -> None:
    """Round a circle the direction passes every place where one is exchanged for another, and turns round at y = 0."""
    turns = np.linspace(0, 1, 20001) * math.tau
    circle = np.stack([20 * np.cos(turns), 20 * np.sin(turns), 3 + 0 * turns], 1)
    round_twice = "[x^2 - y^2, 2 * x * y, 0]"
    way = f"(if y > 0 then {round_twice} else -{round_twice})"
    values = at(f"align({lattice.format(way)})", circle)
    assert np.ptp(values) > 1
    assert np.abs(np.diff(values)).max() < 0.15 * np.ptp(values)
    plain = at(f"align(gyroid(10), {round_twice}, symmetry=2)", circle)
    assert np.abs(np.diff(plain)).max() > 0.3 * np.ptp(plain)  # it would be seen


def test_the_break_at_a_ridge_is_spread_where_the_distance_is_smoothed() -> None:
    """Between two posts the gradient of the distance turns round at once; of its samples within a voxel."""
    across = RNG.uniform([0, -4, -4], [0, 4, 4], (500, 3))
    posts = "let d = min(hypot(x - 12, y), hypot(x + 12, y)) - 2\nlet body = box([40, 40, 20])\n"
    step = np.array([1e-3, 0, 0])
    sharp = jump(posts + "align(x + 2 * y, grad(d))", across, step)
    soft = [
        jump(posts + f"align(x + 2 * y, grad(sample(d, {v}mm, body, smooth=true)))", across, step) for v in (1, 2, 4)
    ]
    assert sharp > 4
    assert soft[0] < 0.1 * sharp
    assert soft[2] < soft[1] < soft[0]


def test_the_break_at_a_ridge_shrinks_with_blur() -> None:
    """Over a step of 0.1 mm, by the width of the Gaussian: the more of it, the more evenly the direction turns."""
    across = RNG.uniform([0, 5, -4], [0, 9, 4], (500, 3))  # between the posts, at y = 0, there is no direction at all
    posts = "let d = min(hypot(x - 12, y), hypot(x + 12, y)) - 2\nlet body = box([40, 40, 20])\n"
    step = np.array([0.05, 0, 0])
    sharp = jump(posts + "align(x + 2 * y, grad(d))", across, step)
    soft = [
        jump(posts + f"align(x + 2 * y, grad(blur(d, {s}mm, body, smooth=true)))", across, step) for s in (0.5, 1, 2)
    ]
    assert sharp > 4
    assert soft[0] < 0.3 * sharp
    assert soft[1] < 0.6 * soft[0]
    assert soft[2] < 0.6 * soft[1]


def test_what_symmetry_may_be() -> None:
    for wrong in ("3", "0", "1.5"):
        with pytest.raises(porelang.PoreError, match="symmetry"):
            porelang.compile(f"align(gyroid(10), p, symmetry={wrong})")
