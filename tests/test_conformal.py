"""Cells that follow a shape: curves against paths that are walked step by step, maps against geometry, seams that are
not there, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang

Array = NDArray[np.float64]
RNG = np.random.default_rng(11)


def at(text: str, points: Array) -> Array:
    """A program's part at points (n, 3)."""
    return np.asarray(porelang.compile(text).field("part")(points))


def three(template: str, points: Array) -> Array:
    """What a field's coordinates x, y, z become, (n, 3)."""
    return np.stack([at(template.format(c), points) for c in "xyz"], 1)


def listed(points: Array) -> str:
    return "[" + ", ".join("[" + ", ".join(repr(float(c)) for c in q) + "]" for q in points) + "]"


def gyroid(points: Array, w: float) -> Array:
    x, y, z = (points * (math.tau / w)).T
    value: Array = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return value


# ---- along a curve ---------------------------------------------------------------------------------------------------


def walked(points: Array, bend: float, step: float = 0.005) -> tuple[Array, Array, Array]:
    """A path with its corners rounded by arcs of one radius, walked in small steps: places, directions, and the side,
    carried along by double reflection (W. Wang et al., Computation of rotation minimizing frames, 2008)."""
    d = np.diff(points, axis=0)
    size = np.linalg.norm(d, axis=1)
    d = d / size[:, None]
    places: list[Array] = []
    ways: list[Array] = []
    start = points[0]
    for i in range(len(d)):
        if i + 1 < len(d):
            theta = math.acos(np.clip(d[i] @ d[i + 1], -1, 1))
            end = points[i + 1] - bend * math.tan(theta / 2) * d[i]
        else:
            end = points[-1]
        t = np.arange(0, np.linalg.norm(end - start), step)
        places.append(start + t[:, None] * d[i])
        ways.append(np.broadcast_to(d[i], (len(t), 3)))
        if i + 1 < len(d):
            inward = d[i + 1] - (d[i] @ d[i + 1]) * d[i]
            inward /= np.linalg.norm(inward)
            phi = np.arange(0, theta, step / bend)[:, None]
            places.append(end + bend * (np.sin(phi) * d[i] + (1 - np.cos(phi)) * inward))
            ways.append(np.cos(phi) * d[i] + np.sin(phi) * inward)
            start = points[i + 1] + bend * math.tan(theta / 2) * d[i + 1]
    p, t = np.concatenate(places), np.concatenate(ways)
    new = np.append(True, np.linalg.norm(np.diff(p, axis=0), axis=1) > 1e-9)
    p, t = p[new], t[new]
    side = np.cross([0.0, 0, 1], t[0])
    side /= np.linalg.norm(side)
    sides = [side]
    for k in range(len(p) - 1):
        v = p[k + 1] - p[k]
        c = v @ v
        one = sides[-1] - 2 / c * (v @ sides[-1]) * v
        way = t[k] - 2 / c * (v @ t[k]) * v
        u = t[k + 1] - way
        sides.append(one - (2 / (u @ u) * (u @ one) * u if u @ u > 1e-30 else 0))
    return p, t, np.array(sides)


PATHS = {
    "flat": np.array([[0.0, 0, 0], [40, 0, 0], [40, 40, 0], [80, 40, 0]]),
    "screw": np.array([[0.0, 0, 0], [30, 0, 0], [30, 30, 0], [30, 30, 30], [60, 30, 30], [60, 60, 60]]),
    "blunt": np.array([[0.0, 0, 0], [30, 4, 0], [60, 0, 5], [90, -8, 5]]),
}


@pytest.mark.parametrize("name", PATHS)
def test_coordinates_along_a_path_are_those_of_a_walk(name: str) -> None:
    points, bend = PATHS[name], 9.0
    p, t, sides = walked(points, bend)
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    k = RNG.integers(200, len(p) - 200, 400)
    across = RNG.uniform(-5, 5, (400, 2))
    other = np.cross(t[k], sides[k])
    q = p[k] + across[:, :1] * sides[k] + across[:, 1:] * other
    found = three(f"along({{}}, {listed(points)}, bend={bend})", q)
    assert np.abs(found[:, 0] - s[k]).max() < 0.02
    assert np.abs(found[:, 1:] - across).max() < 0.02
    whole = at(f"curve({listed(points)}, bend={bend})[1] + 0 * x", q[:1])
    assert whole == pytest.approx(s[-1], abs=0.02)


def test_an_arc_is_an_arc() -> None:
    """Polar coordinates, the greatest bends that fit a tangent polygon being one circle."""
    angle = RNG.uniform(0.1, 1.9, 500)
    rho, z = RNG.uniform(30, 50, 500), RNG.uniform(-9, 9, 500)
    points = np.stack([rho * np.cos(angle), rho * np.sin(angle), z], 1)
    for parts in (2, 3, 8):
        found = three(f"along({{}}, arc(40mm, 0deg, 120deg, parts={parts}))", points)
        assert np.abs(found - np.stack([40 * angle, 40 - rho, z], 1)).max() < 1e-9
    back = three("along({}, arc(40mm, 120deg, 0deg))", points)
    assert np.abs(back[:, 0] - 40 * (math.radians(120) - angle)).max() < 1e-9
    assert np.abs(back[:, 1] - (rho - 40)).max() < 1e-9


def test_a_straight_curve_changes_nothing_but_where_it_starts() -> None:
    points = RNG.uniform(-50, 50, (500, 3))
    for curve in ("[[1, 2, 3], [20, 2, 3]]", "[[1, 2, 3], [5, 2, 3], [9, 2, 3], [20, 2, 3]]"):
        assert np.abs(three(f"along({{}}, {curve})", points) - (points - [1, 2, 3])).max() < 1e-12


def test_a_tube_is_the_distance_to_a_curve() -> None:
    points = PATHS["screw"]
    p, *_ = walked(points, 9.0)
    q = p[RNG.integers(2000, len(p) - 2000, 200)] + RNG.uniform(-4, 4, (200, 3))
    nearest = np.array([np.linalg.norm(p - one, axis=1).min() for one in q])
    assert at(f"pipe({listed(points)}, 3mm, bend=9mm)", q) == pytest.approx(nearest - 3, abs=0.01)
    body = porelang.compile("pipe([[0, 0, 0], [30, 0, 0], [30, 30, 0]], 4)").bounds()
    assert body.lo == pytest.approx((-4, -4, -4), abs=0.5)
    assert body.hi == pytest.approx((34, 34, 4), abs=0.5)


def test_a_spline_goes_through_its_points_and_is_smooth() -> None:
    knots = np.array([[0.0, 0, 0], [20, 10, 0], [40, 0, 10], [60, 0, 0]])
    text = f"spline({listed(knots)}, 6)"
    count = 19
    found = np.array(
        [[float(at(f"{text}[{i}].{c} + 0 * x", np.zeros((1, 3)))[0]) for c in "xyz"] for i in range(count)]
    )
    assert np.abs(found[::6] - knots).max() < 1e-12
    turn = np.diff(found, axis=0)
    turn /= np.linalg.norm(turn, axis=1)[:, None]
    assert (turn[1:] * turn[:-1]).sum(1).min() > math.cos(math.radians(25))


def test_a_whole_number_of_cells_fits_a_closed_curve() -> None:
    """Round a square with round corners, and round loops that leave their plane, by which a side turns about the curve:
    the last cell meets the first."""
    flat = "[[-20, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]]"
    whole = float(at(f"curve({flat}, closed=true)[1] + 0 * x", np.zeros((1, 3)))[0])
    assert whole == pytest.approx(math.tau * 20, rel=1e-9)
    for loop in (flat, "[[-20, -20, 0], [20, -20, 0], [20, 20, 15], [-20, 20, -5]]",
                 "[[-20, -20, 0], [20, -20, 0], [30, 0, 20], [0, 30, 0], [-20, 10, 20]]"):  # fmt: skip
        # the first piece runs along x; the joint is where the arc length begins again
        line = np.stack([x := np.linspace(-19, 19, 3801), 0 * x - 20, 0 * x], 1)
        s = at(f"curve({loop}, closed=true)[0].x", line)
        (k,) = np.flatnonzero(np.diff(s) < -50)
        beside = np.column_stack([np.zeros(200), RNG.uniform(-3, 3, (200, 2))])
        before, after = line[k] + beside, line[k + 1] + beside
        lattice = f"along(gyroid(9), {loop}, w=9mm, closed=true)"
        assert np.abs(at(lattice, before) - at(lattice, after)).max() < 0.02
    open_ended = "along(gyroid(9), [[-20, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]], w={}mm, closed=true)"
    circle = 20 * np.stack([np.cos(t := np.linspace(0, math.tau, 40001)), np.sin(t), 0.13 + 0 * t], 1)
    values = [at(open_ended.format(w), circle) for w in (9, 8)]
    assert np.abs(np.diff(values[0])).max() < 0.02
    assert np.abs(np.diff(values[1])).max() > 0.1  # 8 mm is no period: there is a seam, and it is seen


def test_cells_fit_the_length_of_a_curve() -> None:
    length = 40 * math.radians(100)
    cells = round(length / 9)
    ends = np.array([[40.0, 0, 0], [40 * math.cos(math.radians(100)), 40 * math.sin(math.radians(100)), 0]])
    assert at("along(x, arc(40, 0deg, 100deg), w=9mm)", ends) == pytest.approx([0, 9 * cells], abs=1e-9)


def test_a_lattice_follows_the_bars_of_a_frame(tmp_path: Path) -> None:
    (tmp_path / "f.json").write_text('{"nodes": [[0,0,0],[30,0,0],[30,40,0]], "bars": [[0,1],[1,2]], "radius": 1}')
    program = tmp_path / "bars.pore"
    text = (
        'let b = nearest_bar("f.json")\n'
        "beside({}, b.along * b.length, b.outward * (b.distance + b.radius), b.direction)"
    )
    points = np.stack([RNG.uniform(2, 20, 300), *RNG.uniform(-1.5, 1.5, (2, 300))], 1)
    second = np.stack([30 - points[:, 1], 5 + points[:, 0], points[:, 2]], 1)
    for c, wanted in zip("xyz", points.T, strict=True):
        program.write_text(text.format(c))
        field = porelang.compile(path=program).field("part")
        assert field(points) == pytest.approx(wanted, abs=1e-9)
        assert field(second) == pytest.approx(wanted + (5 if c == "x" else 0), abs=1e-9)


# ---- between, cylinder, sphere ---------------------------------------------------------------------------------------


def test_between_two_surfaces_cells_are_counted() -> None:
    points = RNG.normal(size=(500, 3)) * 12
    r = np.linalg.norm(points, axis=1)
    assert at("between(sphere(10), sphere(25), cells=3)", points) == pytest.approx(3 * (r - 10) / 15, abs=1e-9)
    x, y, z = points.T
    top, bottom = 10 + x / 10, -10 + 0.02 * y * y
    wanted = (z - bottom) / (top - bottom)
    inside = top - bottom > 1
    found = at("between(z + 10 - 0.02 * y^2, z - 10 - x / 10)", points)
    assert found[inside] == pytest.approx(wanted[inside], abs=1e-9)


def test_surfaces_that_cross_are_told_with_a_place() -> None:
    program = porelang.compile("gyroid(phase=[x / 5, y / 5, between(z + 5, z - 5 + x / 2)]) & cube(30)")
    assert any("b < a" in d.message for d in program.warnings) or any(
        "b < a" in d.message for d in porelang.compile("between(z, z + 1)").warnings
    )


def test_cells_round_a_cylinder_close_and_are_cubes_at_its_radius() -> None:
    points = np.stack([np.full(100, -20.0), np.full(100, 1e-9), RNG.uniform(-15, 15, 100)], 1)
    mirrored = points * [1, -1, 1]
    lattice = "gyroid(phase=cylinder_map(20mm, cells={}, h=30mm))"
    for cells in (3, 7, 12):
        one, other = at(lattice.format(cells), points), at(lattice.format(cells), mirrored)
        assert np.abs(one - other).max() < 1e-6
    phase = "cylinder_map(20mm, cells=12).{}"
    here = np.array([[20.0, 0, 0], [21, 0, 0], [20 * math.cos(0.05), 20 * math.sin(0.05), 0], [20, 0, 1]])
    found = np.stack([at(phase.format(c), here) for c in "xyz"], 1)
    w = math.tau * 20 / 12
    assert found[1] - found[0] == pytest.approx([1 / w, 0, 0], abs=1e-12)
    assert found[2] - found[0] == pytest.approx([0, 1 / w, 0], abs=1e-12)
    assert found[3] - found[0] == pytest.approx([0, 0, 1 / w], abs=1e-12)
    ends = np.array([[20.0, 0, -15], [20, 0, 15]])
    fitted = at("cylinder_map(20mm, cells=12, h=30mm).z", ends)
    assert fitted[1] - fitted[0] == pytest.approx(3)
    assert fitted[0] == pytest.approx(0)


@pytest.mark.parametrize("lattice", ["schwarz_p", "iwp", "neovius"])
def test_cells_on_a_sphere_have_no_seam_from_square_to_square(lattice: str) -> None:
    """Across the twelve edges and the eight corners: along small steps over random great circles."""
    field = porelang.compile(f"{lattice}(phase=sphere_map(20mm, cells=12))").field("part")
    steepest = 0.0
    for _ in range(10):
        a, b = np.linalg.qr(RNG.normal(size=(3, 2)))[0].T
        t = np.linspace(0, math.tau, 20001)[:, None]
        values = field(21.3 * (np.cos(t) * a + np.sin(t) * b))
        steepest = max(steepest, float(np.abs(np.diff(values)).max() / np.ptp(values)))
    assert steepest < 0.02
    gyroids = porelang.compile("gyroid(phase=sphere_map(20mm, cells=12))").field("part")
    t = np.linspace(0, math.tau, 20001)[:, None]
    values = gyroids(21.3 * (np.cos(t) * np.array([0.8, 0.0, 0.6]) + np.sin(t) * np.array([0.36, 0.8, -0.48])))
    assert np.abs(np.diff(values)).max() > 0.1  # it would be seen


def test_cells_on_a_sphere_are_as_wide_as_is_written() -> None:
    """By differences along the sphere: 1 in the middle of a square and 0.71 along the middle of an edge."""
    w, h = math.tau * 20 / 12, 1e-5

    def width(point: Array, way: Array, axis: str) -> float:
        ends = np.array([20 * (q := point + s * h * way) / np.linalg.norm(q) for s in (-1, 1)])
        phase = at(f"sphere_map(20mm, cells=12).{axis}", ends)
        return float(np.linalg.norm(ends[1] - ends[0]) / (phase[1] - phase[0])) / w

    x, y, z = np.eye(3)
    assert width(x, y, "y") == pytest.approx(1, abs=1e-6)
    assert width(x, z, "z") == pytest.approx(1, abs=1e-6)
    edge = x + (1 - 1e-9) * y
    assert width(edge, z, "z") == pytest.approx(1 / math.sqrt(2), abs=1e-4)


# ---- wedges ----------------------------------------------------------------------------------------------------------


def rings(lattice: Any, points: Array, w: float, cells: int) -> Array:
    """`wedges` in NumPy, by the radii that its documentation names."""
    rho, phi = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    first = cells * w * math.sqrt(2) / math.tau
    number = np.full(len(points), float(cells))
    t = np.zeros(len(points))
    for k in range(8):
        r = first * 2**k
        number = np.where(rho > r * math.sqrt(0.5), cells * 2.0**k, number)
        t = np.where((rho > r * math.sqrt(0.5)) | (k == 0), np.clip((rho - r) / w + 0.5, 0, 1), t)

    def polar(n: Array) -> Array:
        return np.stack([rho, n * phi / math.tau * w, points[:, 2]], 1)

    mixed: Array = (lattice(polar(number), w) * (1 - t) + lattice(polar(2 * number), w) * t) / np.hypot(t, 1 - t)
    return mixed


def test_wedges_double_where_they_are_too_wide() -> None:
    points = RNG.uniform(-120, 120, (4000, 3))
    assert at("wedges(gyroid(10), 10mm)", points) == pytest.approx(rings(gyroid, points, 10, 6), abs=1e-9)
    assert at("wedges(gyroid(10), 10mm, cells=9)", points) == pytest.approx(rings(gyroid, points, 10, 9), abs=1e-9)


def test_wedges_have_no_seam_anywhere() -> None:
    """Round the axis, and along a ray over all rings, in small steps."""
    for cells in (6, 7, 11):
        field = porelang.compile(f"wedges(gyroid(10), 10mm, cells={cells})").field("part")
        t = np.linspace(0, math.tau, 200_001)
        for rho in (5.0, 13.5, 20, 27, 41.7, 54, 100):
            circle = np.stack([rho * np.cos(t), rho * np.sin(t), 1.3 + 0 * t], 1)
            assert np.abs(np.diff(field(circle))).max() < 0.01
        rho = np.linspace(0.01, 200, 400_001)
        ray = np.stack([rho * math.cos(1), rho * math.sin(1), 1.3 + 0 * rho], 1)
        assert np.abs(np.diff(field(ray))).max() < 0.01


def test_outside_the_first_ring_wedges_keep_their_width() -> None:
    """Counted along circles between the rings: sign changes of a wave round the axis."""
    field = porelang.compile("wedges(cos(tau * y / 10), 10mm)").field("part")
    t = np.linspace(0, math.tau, 100_001)
    first = 60 * math.sqrt(2) / math.tau
    for k in range(4):
        for rho in (first * 2**k * 1.4143, first * 2**k * 1.41):
            values = field(np.stack([rho * np.cos(t), rho * np.sin(t), 0 * t], 1))
            count = int((np.diff(np.sign(values)) != 0).sum()) / 2
            assert count == 6 * 2 ** (k + 1)
            assert 0.7 < math.tau * rho / count / 10 < 1.42


# ---- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("pipe([[0, 0, 0], [9, 0, 0], [9, 0, 0], [9, 9, 0]], 3)", "each apart from the one before"),
        ("along(gyroid(6), [[0, 0, 0], [0, 0, 0]])", "none that repeats the one before it"),
        (
            "along(gyroid(6), [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 0, 0]], w=6, closed=true)",
            "`closed=true` joins them",
        ),
        ("along(gyroid(6), [[0, 0], [40, 0]])", "a point in space has three coordinates"),
        ("align(gyroid(6), p, up=[0, 0, 0])", "as in `up=[0, 1, 0]`"),
        ("gyroid(phase=[x / 8, 7.5 * atan2(y, x) / tau, z / 8])", "`atan2(y, x) / 1turn` is a number of turns"),
    ],
)
def test_what_is_refused_is_told_in_the_words_of_the_call(text: str, says: str) -> None:
    """Points that are one tore the pattern: a step of no length has no direction."""
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text)
    assert len(caught.value.diagnostics) == 1
    assert says in str(caught.value)


def test_surfaces_that_are_exchanged_are_told_so() -> None:
    (d,) = porelang.compile("gyroid(phase=[x / 10, y / 10, between(z - 5, z + 5)]) & cube(9)").warnings
    assert (d.code, d.hint[:16]) == ("W201", "exchange the two")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("along(gyroid(6), [[0, 0, 0]])", "at least 2 `points`"),
        ("along(gyroid(6), [[0, 0, 0], [9, 0, 0], [9, 9, 0]], closed=true)", "a `w`, and at least 3 `points`"),
        ("along(gyroid(6), [[0, 0, 0], [9, 0, 0], [9, 9, 0]], bend=10mm)", "widest_bend"),
        ("gyroid(phase=cylinder_map(20, cells=11.5))", "whole number"),
        ("gyroid(phase=cylinder_map(20, cells=0))", "cells >= 1"),
        ("schwarz_p(phase=sphere_map(20, cells=10))", "mod(cells, 4)"),
        ("wedges(gyroid(6), 6mm, cells=5)", "cells >= 6"),
        ("wedges(gyroid(6), 6mm, cells=6.5)", "whole number"),
        ("wedges(gyroid(6), 6deg)", "length"),
        ("between(z + 5, z - 5, cells=1.5)", "whole number"),
        ("pipe(arc(40, 0deg, 540deg, parts=6), 5)", "90deg"),
    ],
)
def test_what_would_leave_a_seam_is_refused(text: str, says: str) -> None:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text)
    assert says in str(caught.value)
