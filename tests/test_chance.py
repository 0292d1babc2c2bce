"""Random numbers, noise, particles and foams, against the same written a second time in NumPy and Python's integers."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.conformance.backend import Backend
from porelang.formula import Formula
from porelang.program import Program
from porelang.session import Session

Array = NDArray[np.float64]
PLACES = np.random.default_rng(31).uniform(-60, 60, (400, 3)).astype(np.float32).astype(np.float64)


def pcg4d(x: int, y: int, z: int, w: int) -> tuple[int, ...]:
    """The hash of Jarzynski and Olano (2020), in Python's integers."""
    v = [(int(a) * 1664525 + 1013904223) % 2**32 for a in (x, y, z, w)]
    for last in (False, True):
        for to, a, b in ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)):
            v[to] = (v[to] + v[a] * v[b]) % 2**32
        v = v if last else [a ^ (a >> 16) for a in v]
    return tuple(v)


def chance(cell: Array, seed: int) -> Array:
    """Three numbers of a cell, 24 bits each."""
    return np.array([a // 2**8 / 2**24 for a in pcg4d(*(int(c) for c in cell), seed)[:3]])


def field(text: str, points: Array = PLACES) -> Array:
    return np.asarray(porelang.compile(f"out part = {text}").field("part", dtype="f64")(points))


# ---- numbers --------------------------------------------------------------------------------------------------------


def test_random_numbers_are_the_same_bits_everywhere(backend: Backend) -> None:
    program = porelang.compile("param s = 5 in 0..9 step 1\nout part = random(p / 10, s)")
    exact = np.array([chance(np.floor(q / 10), 5) for q in PLACES])
    for root, wanted in zip(program.roots("part"), exact.T, strict=True):
        got = backend.evaluate(Formula.of(root, s=5.0), PLACES, program.ranges)
        np.testing.assert_array_equal(got, wanted)


def test_random_numbers_are_even_and_know_nothing_of_their_neighbours() -> None:
    at = np.stack(np.meshgrid(*[np.arange(-20.0, 20.0)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5
    number = field("random(p, 3).x", at)
    n = len(at)
    counts, _ = np.histogram(number, 64, (0, 1))
    assert ((counts - n / 64) ** 2 / (n / 64)).sum() < 118  # chi squared of 63 degrees: one in 30 000 is beyond
    cube = number.reshape(40, 40, 40) - 0.5
    for axis in range(3):
        product_ = (cube * np.roll(cube, 1, axis)).mean() * 12
        assert abs(product_) < 5 / math.sqrt(n)
    assert abs((field("random(p, 4).x", at) - 0.5) @ (number - 0.5)) * 12 / n < 5 / math.sqrt(n)


# ---- sites ----------------------------------------------------------------------------------------------------------


def brute(u: Array, seed: int, steps: int) -> dict[str, float]:
    """What is nearest to a place in cells, of the sites of 9^3 cells about it."""
    cell = np.floor(u)
    sites, numbers = [], []
    for o in product(range(-4, 5), repeat=3):
        h = pcg4d(*(int(c) for c in cell + o), seed)
        place = [(2 * (a // 2**17 - 2**14) + 1) * steps / 2**24 for a in h[:3]]
        sites.append(np.array(o) + 0.5 + place)
        numbers.append(h[3] // 2**8 / 2**24)
    at = np.array(sites) - (u - cell)
    square = (at**2).sum(1)
    order = np.argsort(square)
    own = order[0]
    others = np.delete(np.arange(len(at)), own)
    apart = np.sqrt(((at[others] - at[own]) ** 2).sum(1))
    walls = (square[others] - square[own]) / (2 * apart)
    f1, f2, f3 = np.sqrt(square[order[:3]])
    return {"f1": f1, "f2": f2, "f3": f3, "wall": walls.min(), "number": numbers[own]}


@pytest.mark.parametrize(("jitter", "steps"), [(1.0, 256), (0.6, 154), (0.0, 0)])
def test_what_is_nearest_is_found_among_all(jitter: float, steps: int) -> None:
    u = PLACES[:60] / 8
    exact = [brute(q, 9, steps) for q in u]
    for name in ("f1", "f2", "f3", "wall", "number"):
        got = field(f"nearest_site(p, 9, {jitter}).{name}", u)
        np.testing.assert_allclose(got, [e[name] for e in exact], rtol=0, atol=1e-12)


def test_the_nearest_wall_is_as_near_as_it_says() -> None:
    """From a place there is a way of that length to where two sites are equally near, and to none within less."""
    program = porelang.compile(
        "let s = nearest_site(p / 10, 2)\nout d = s.wall * 10\nout n = s.across\nout gap = s.f2 - s.f1"
    )
    at = PLACES[:200]
    d = np.asarray(program.field("d", dtype="f64")(at))
    n = np.asarray(program.field("n", dtype="f64")(at))
    gap = program.field("gap", dtype="f64")
    assert np.abs(np.asarray(gap(at - d[:, None] * n))).max() < 1e-9
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(200, 3))
    ways /= np.sqrt((ways**2).sum(1))[:, None]
    number = porelang.compile("out part = nearest_site(p / 10, 2).number").field("part", dtype="f64")
    np.testing.assert_array_equal(number(at), number(at + 0.999 * d[:, None] * ways))  # still in the same cell


@pytest.mark.parametrize("t", [0.8, 0.3])
def test_walls_of_a_closed_foam_are_as_thick_as_they_say(t: float) -> None:
    """Along a line across a wall, at right angles to it, the foam is solid for t."""
    program = porelang.compile(f"out part = voronoi_cells(10mm, {t}mm, seed=2)\nout n = nearest_site(p / 10, 2).across")
    part, at = program.field("part", dtype="f64"), PLACES[:40]
    d = np.asarray(part(at)) + t / 2
    foot = at - d[:, None] * np.asarray(program.field("n", dtype="f64")(at))
    way = (at - foot) / d[:, None]
    for side in (1, -1):
        for edge, solid in ((0.499, True), (0.501, False)):
            inside = np.asarray(part(foot + side * edge * t * way)) < 0
            assert (inside == solid).mean() > (0.99 if solid else 0.9)  # near a node another wall may go on


def test_particles_in_the_middle_of_their_cells_fill_what_balls_do() -> None:
    text = "let share = porosity(particles(10mm, 4mm, jitter=0), box([10, 10, 10]))\nout part = sphere(9 * share)"
    program = porelang.compile(text)
    (found,) = program.design().own_numbers(program.named("share")).values()  # type: ignore[arg-type]  # it is there
    assert found.value == pytest.approx(1 - 4 / 3 * math.pi * 4**3 / 1000, abs=found.error)
    assert found.error < 2e-3


def test_lengths_are_those_of_the_local_cell() -> None:
    plain = field("voronoi_cells(10, 1)")
    np.testing.assert_allclose(field("voronoi_cells(phase=p / 10, t=1)"), plain, atol=1e-12)
    turned = field("voronoi_cells(phase=([z, x, y]) / 10, t=1)", PLACES[:, [1, 2, 0]])
    np.testing.assert_allclose(turned, plain, atol=1e-12)
    np.testing.assert_allclose(field("cell_size(p / [4, 8, 16])"), 8.0, rtol=1e-12)
    open_ = field("nearest_site(p / 7, 1).f3") - field("nearest_site(p / 7, 1).f1")
    np.testing.assert_allclose(field("voronoi_edges(7, 1.5, seed=1)"), 3.5 * open_ - 0.75, atol=1e-12)


# ---- noise ----------------------------------------------------------------------------------------------------------


def slope(cell: Array, seed: int) -> Array:
    x, y, z = chance(cell, seed)
    a, b = (-1.0 if y < 0.5 else 1.0), (-1.0 if z < 0.5 else 1.0)
    return np.array([[0, a, b], [a, 0, b], [a, b, 0]][min(int(3 * x), 2)])


def perlin(u: Array, seed: int) -> float:
    cell = np.floor(u)
    f = u - cell
    t = f**3 * (f * (6 * f - 15) + 10)
    total = 0.0
    for o in product((0, 1), repeat=3):
        corner = np.array(o)
        total += np.prod(np.where(corner == 1, t, 1 - t)) * (slope(cell + corner, seed) @ (f - corner))
    return float(total / 1.0363538112118)


def cubic(u: Array, seed: int) -> float:
    cell = np.floor(u)
    t = u - cell
    weight = np.array([(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]) / 6
    return float(
        sum(
            weight[a, 0] * weight[b, 1] * weight[c, 2] * (2 * chance(cell + np.array([a, b, c]) - 1, seed)[0] - 1)
            for a, b, c in product(range(4), repeat=3)
        )
    )


def simplex(u: Array, seed: int) -> float:
    """By sorting: the corners of the tetrahedron are reached along the largest component first."""
    base = np.floor(u + u.sum() / 3)
    total, corner = 0.0, np.zeros(3)
    d = u - base + base.sum() / 6
    for n, axis in enumerate([None, *np.argsort(-d, kind="stable")]):
        if axis is not None:
            corner[axis] += 1
        r = d - corner + n / 6
        total += max(0.5 - r @ r, 0.0) ** 4 * (slope(base + corner, seed) @ r)
    return float(total * 76.88369319)


@pytest.mark.parametrize(("name", "known"), [("perlin", perlin), ("cubic_noise", cubic), ("simplex", simplex)])
def test_noise_is_its_formula(name: str, known: Callable[[Array, int], float]) -> None:
    at = PLACES[:80]
    np.testing.assert_allclose(field(f"{name}(10, seed=4)", at), [known(q / 10, 4) for q in at], atol=1e-11)


@pytest.mark.parametrize("name", ["perlin", "cubic_noise", "simplex", "worley"])
def test_noise_is_continuous_and_keeps_its_range(name: str) -> None:
    rng = np.random.default_rng(5)
    at = rng.uniform(-40, 40, (20_000, 3))
    at[:10_000, :2] = np.rint(at[:10_000, :2])  # on the borders of cells
    near = at + rng.normal(size=at.shape) * 1e-6
    here, there = field(f"{name}(1)", at), field(f"{name}(1)", near)
    assert np.abs(here - there).max() < 1e-4
    least, most = (0, 1.74) if name == "worley" else (-1, 1)
    assert least <= here.min()
    assert here.max() <= most
    assert here.std() > 0.1


def test_octaves_add_up() -> None:
    whole = field("fractal(perlin, 20, 3, gain=0.4, seed=6)")
    parts = [0.4**k * np.array([perlin(q / 20 * 2**k, 6 + k) for q in PLACES]) for k in range(3)]
    np.testing.assert_allclose(whole, sum(parts), atol=1e-11)


def test_a_spinodoid_has_the_spread_and_the_directions_it_says() -> None:
    """Mean 0, variance 1; the mean square of a slope along an axis is (2 pi / w)^2 times that of the waves' cosines."""
    at = np.random.default_rng(7).uniform(-1000, 1000, (20_000, 3))
    cap = 1 - math.cos(math.radians(20))
    for cones, wanted in (
        ("[90deg, 90deg, 90deg]", (1 / 3, 1 / 3, 1 / 3)),
        ("[20deg, 0deg, 0deg]", ((1 - cap / 2) ** 2 + cap**2 / 12, None, None)),
        ("[0deg, 0deg, 20deg]", (None, None, (1 - cap / 2) ** 2 + cap**2 / 12)),
    ):
        text = f"let f = spinodoid(10, cones={cones}, waves=200, seed=2)\nout part = f\nout slope = grad(f)"
        program = porelang.compile(text)
        value = np.asarray(program.field("part", dtype="f64")(at))
        slopes = np.asarray(program.field("slope", dtype="f64")(at))
        assert abs(value.mean()) < 0.02
        assert value.var() == pytest.approx(1, abs=0.03)
        for axis, share in enumerate(wanted):
            if share is not None:
                found = (slopes[:, axis] ** 2).mean() / (2 * math.pi / 10) ** 2
                assert found == pytest.approx(share, abs=0.05)


# ---- others ---------------------------------------------------------------------------------------------------------


def test_metaballs_flow_into_each_other() -> None:
    centres = np.array([[0.0, 0, 0], [8, 0, 0]])
    square = ((PLACES[:, None] / 4 - centres) ** 2).sum(-1)
    wanted = 0.4 - (np.maximum(1 - square / 100, 0) ** 3).sum(1)
    np.testing.assert_allclose(
        field("metaballs([[0, 0, 0], [8, 0, 0]], 10, level=0.4)", PLACES / 4), wanted, atol=1e-12
    )
    alone = 10 * math.sqrt(1 - 0.5 ** (1 / 3))
    assert alone == pytest.approx(4.542, abs=1e-3)
    np.testing.assert_allclose(field("metaballs([[0, 0, 0]], 10)", np.array([[alone, 0, 0]])), 0, atol=1e-12)


def test_the_ground_is_a_distance_where_it_is_a_plane() -> None:
    x, _, z = PLACES.T
    np.testing.assert_allclose(field("landscape(x / 2 + z)"), (z - x / 2) / math.sqrt(1.25), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("nearest_site(p / 10, 0, 2).f1", "E064", "from 0 to 1"),
        ("nearest_site(p / 10, 0, x).f1", "E063", "varies in space"),
        ("nearest_site([1mm, 2mm, 3mm]).f1", "E062", "size of a cell"),
        ("random(5)", "E060", "a place"),
        ("random(p, 8388608).x", "E064", "8,388,607"),
        ("perlin(9, seed=123456789)", "E064", "8,388,607"),
        ("random(p, gyroid(9))", "E063", "varies in space"),
        ("particles(10, 4, jitter=1.5)", "E064", "jitter"),
        ("particles(10, 4, seed=0.5)", "E064", "whole"),
        ("voronoi_cells(10, -1)", "E064", "t >= 0"),
        ("perlin(10, phase=p / 10)", "E045", "not both"),
        ("spinodoid(10, cones=[0deg, 0deg, 0deg])", "E064", "cones"),
    ],
)
def test_what_makes_no_sense_is_told(text: str, code: str, words: str) -> None:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text)
    assert [d.code for d in caught.value.diagnostics] == [code]
    assert words in str(caught.value)


def test_a_seed_is_a_param_and_makes_another_foam() -> None:
    program: Program = porelang.compile("param s = 1 in 0..9 step 1\nvoronoi_cells(10, 1, seed=s) & cube(30)")
    one, two = (np.asarray(program.field("part", s=s)(PLACES)) for s in (1, 2))
    assert np.abs(one - two).max() > 1
    np.testing.assert_allclose(field("voronoi_cells(10, 1, seed=2) & cube(30)"), two, atol=1e-4)


@pytest.mark.parametrize("corner", [(0, 0, 0), (0.5, 0, 0), (0, 0.5, 0.5), (0.5, 0.5, 0.5)])
def test_where_many_sites_are_as_near_there_is_a_wall_all_the_same(corner: tuple[float, float, float]) -> None:
    """Sites in the middle of cells: at a corner eight tie, on an edge four, on a face two."""
    at = np.array([corner]) + np.arange(-40, 40)[:, None]
    least = 0.5 - np.abs(np.array(corner) - 0.5).max()
    np.testing.assert_allclose(field("nearest_site(p, 1, 0).wall", at), least, atol=1e-12)


@pytest.mark.parametrize("foam", ["voronoi_cells({}, 0.8)", "particles({}, 2)", "voronoi_edges({}, 1)"])
def test_cells_are_cubes_and_as_large_as_they_say(foam: str) -> None:
    """Stretched ones have no walls of one thickness, and a size that varies has others than it says."""
    with pytest.raises(porelang.PoreError, match="must be a size"):
        porelang.compile(foam.format("[6, 6, 12]"))
    for size, codes in (("7 + z / 10", ["W228"]), ("9mm", [])):
        text = f"out part = {foam.format(size)} & cylinder(15, 40)\n"
        assert [d.code for d in Session().update("a.pore", text).all_diagnostics] == codes
