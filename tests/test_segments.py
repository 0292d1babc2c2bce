"""The nearest bar: against trying every bar in float64, its bounds against dense samples, and on the GPU."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from slots import ES, at_points

from porelang.data import Segments
from porelang.gpu import Gpu, GpuMissing, open_gpu
from porelang.interval import Interval, interval
from porelang.ops import segments as ops
from porelang.ops.segment_cells import cells

Values = NDArray[Any]
RNG = np.random.default_rng(11)


def random_bars(count: int, origin: float = 0.0, side: float = 20.0) -> Segments:
    starts = origin + RNG.uniform(0, side, (count, 3))
    return Segments(starts, starts + RNG.normal(size=(count, 3)) * side / 10, RNG.uniform(0, side / 50, count))


def lattice(cells: int) -> Segments:
    """The edges of a grid of unit cubes, all of one radius: bars that meet in nodes and tie everywhere."""
    nodes = np.stack(np.meshgrid(*[np.arange(cells + 1.0)] * 3, indexing="ij"), -1)
    starts = [
        nodes[tuple(slice(0, cells) if b == a else slice(None) for b in range(3))].reshape(-1, 3) for a in range(3)
    ]
    ends = [s + np.eye(3)[a] for a, s in enumerate(starts)]
    return Segments(np.concatenate(starts), np.concatenate(ends), np.full(3 * cells * (cells + 1) ** 2, 0.1))


FRAMES = {
    "one": Segments(np.array([[1.0, 2, 3]]), np.array([[4.0, 2, 3]]), np.array([0.5])),
    "nine": random_bars(9),
    "crossing": Segments(
        np.array([[-5.0, 0, 0], [0, -5, 0]]), np.array([[5.0, 0, 0], [0, 5, 0]]), np.array([0.0, 1.0])
    ),
    "random": random_bars(700),
    "far": random_bars(300, 1e4),
    "lattice": lattice(4),
    "fat": Segments(*(random_bars(100).starts, random_bars(100).ends), np.linspace(0, 30, 100)),
}


def around(bars: Segments, count: int, margin: float = 0.3) -> Values:
    ends = np.concatenate([bars.starts, bars.ends])
    lo, hi = ends.min(0), ends.max(0)
    more = margin * (hi - lo).max() + 0.5
    return RNG.uniform((lo - more)[:, None], (hi + more)[:, None], (3, count))


def of_each(bars: Segments, p: Values) -> dict[str, Values]:
    """The results of every bar at points (3, n), in float64: arrays (n, bars)."""
    e = bars.ends - bars.starts
    square = (e * e).sum(1)
    w = p.T[:, None, :] - bars.starts
    t = np.clip((w * e).sum(2) / square, 0, 1)
    q = w - t[..., None] * e
    size = np.sqrt((q * q).sum(2))
    unit = q / np.where(size > 0, size, 1)[..., None]
    length = np.sqrt(square)
    flat = np.ones_like(size)
    found = {"distance": size - bars.radii, "along": t, "radius": bars.radii * flat, "length": length * flat}
    found["index"] = np.arange(len(bars)) * flat
    for a, name in enumerate("xyz"):
        found[f"n{name}"], found[f"d{name}"] = unit[..., a], e[:, a] / length * flat
    return found


def brute(bars: Segments, p: Values) -> dict[str, Values]:
    each = of_each(bars, p)
    best = each["distance"].argmin(1)
    return {name: values[np.arange(p.shape[1]), best] for name, values in each.items()}


@pytest.mark.parametrize("name", FRAMES)
def test_results_are_those_of_trying_every_bar(name: str) -> None:
    bars = FRAMES[name]
    p = around(bars, 2000)
    got = dict(zip(ops.RESULTS, ops.nearest(bars, *p), strict=True))
    want = brute(bars, p)
    np.testing.assert_allclose(got["distance"], want["distance"], atol=1e-9)
    each = of_each(bars, p)
    near = np.sort(each["distance"], axis=1)
    clear = np.ones(p.shape[1], bool) if len(bars) == 1 else near[:, 1] - near[:, 0] > 1e-9
    assert clear.mean() > 0.2
    for result in ops.RESULTS:
        np.testing.assert_allclose(got[result][clear], want[result][clear], atol=1e-8, err_msg=result)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_among_bars_that_tie_the_lowest_number_wins(dtype: Any) -> None:
    bars = FRAMES["lattice"]
    p = RNG.integers(0, 17, (3, 3000)) / 4  # nodes, axes and places between: all distances are exact
    (index,) = ops.nearest(bars, *p.astype(dtype), wanted=("index",))
    np.testing.assert_array_equal(index, of_each(bars, p)["distance"].argmin(1))
    outside = np.array([[-1.0, -2, -3], [9, 9, 9]]).T.astype(dtype)  # beyond ends that several bars share
    (index,) = ops.nearest(bars, *outside, wanted=("index",))
    joint = np.array([[0.0, 0, 0], [4, 4, 4]])
    for place, number in zip(joint, index, strict=True):
        meets = (bars.starts == place).all(1) | (bars.ends == place).all(1)
        assert number == np.flatnonzero(meets)[0]


def test_results_do_not_depend_on_the_order_of_points() -> None:
    bars = lattice(6)
    p = around(bars, 4000).astype(np.float32)
    p[:, ::2] = np.rint(p[:, ::2] * 2) / 2
    order = RNG.permutation(4000)
    for a, b in zip(ops.nearest(bars, *p), ops.nearest(bars, *p[:, order]), strict=True):
        np.testing.assert_array_equal(a[order], b)


@pytest.mark.parametrize("name", FRAMES)
def test_float32_stays_within_the_rounding_that_is_said(name: str) -> None:
    bars = FRAMES[name]
    p = around(bars, 3000).astype(np.float32)
    at = [interval(v.astype(float)) for v in p]
    want = brute(bars, p.astype(float))
    bounds = dict(zip(ops.RESULTS, ops.rounding_nearest(bars, *at), strict=True))
    jumps = dict(zip(ops.RESULTS, ops.jumps_nearest(bars, *at), strict=True))
    got = dict(zip(ops.RESULTS, ops.nearest(bars, *p), strict=True))
    for result in ops.RESULTS:
        steady = ~jumps[result]
        far = np.abs(got[result] - want[result])[steady]
        assert (far <= bounds[result][steady] * 2.0**-23).all(), result
    assert not jumps["distance"].any()
    assert np.isfinite(bounds["distance"]).all()
    assert (np.abs(got["distance"] - want["distance"]) / bounds["distance"] / 2.0**-23).max() > 0.002


def boxes(bars: Segments, count: int) -> tuple[Values, Values]:
    centre = around(bars, count)
    side = 10 ** RNG.uniform(-6, 1.3, (3, count)) * RNG.integers(0, 2, (3, count))
    return centre - side / 2, centre + side / 2


@pytest.mark.parametrize("name", FRAMES)
def test_no_sample_leaves_its_bound(name: str) -> None:
    bars = FRAMES[name]
    lo, hi = boxes(bars, 300)
    at = [interval(a, b) for a, b in zip(lo, hi, strict=True)]
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, *at), strict=True))
    several = ops.jumps_nearest(bars, *at)[-1]
    first = brute(bars, lo)["index"]
    for t in RNG.uniform(-0.2, 1.2, (25, 3, 1)).clip(0, 1):
        got = brute(bars, lo + t * (hi - lo))
        assert not ((got["index"] != first) & ~several).any()
        for result, bound in bounds.items():
            assert (got[result] >= bound.lo - 1e-12).all(), result
            assert (got[result] <= bound.hi + 1e-12).all(), result
    (alone,) = ops.enclose_nearest(bars, *at, wanted=("distance",))
    np.testing.assert_array_equal(alone.lo, bounds["distance"].lo)


def test_bounds_are_tight_where_one_bar_is_nearest() -> None:
    bars = FRAMES["random"]
    p = around(bars, 1000, 0.0)
    at = [interval(v - 1e-7, v + 1e-7) for v in p]
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, *at), strict=True))
    width = {result: bound.hi - bound.lo for result, bound in bounds.items()}
    assert (width["distance"] < 4e-7).all()
    single = ~ops.jumps_nearest(bars, *at)[-1]
    assert single.mean() > 0.95
    for result in ("dx", "dy", "dz", "radius", "length", "index"):
        assert (width[result][single] == 0).all()
    assert np.median(width["nx"]) < 1e-6
    assert np.median(width["along"]) < 1e-6
    wide = [interval(v - 0.5, v + 0.5) for v in p]
    (bound,) = ops.enclose_nearest(bars, *wide, wanted=("distance",))
    assert np.median(bound.hi - bound.lo) < 1.8  # the box's diagonal is 1.73


def test_bounds_of_all_of_space_and_of_nothing() -> None:
    bars = FRAMES["random"]
    whole = Interval(
        np.array([-np.inf, 0, np.inf]), np.array([np.inf, np.inf, -np.inf]), np.array([False, False, True])
    )
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, whole, whole, whole), strict=True))
    assert bounds["distance"].lo[0] == pytest.approx(-bars.radii.max())
    assert bounds["distance"].hi[:2].tolist() == [np.inf, np.inf]
    assert bounds["distance"].nan.tolist() == [False, False, True]
    assert bounds["nx"].nan.all()
    assert bounds["index"].hi[0] == len(bars) - 1
    assert bounds["index"].empty[2]


def test_where_the_distance_is_small_the_coordinates_are_near_the_bars() -> None:
    bars = FRAMES["random"]
    p = around(bars, 5000)
    whole = interval(np.array(-np.inf), np.array(np.inf))
    x, y, z = ops.narrow_distance(interval(-np.inf, 0.7), bars, whole, whole, whole)
    near = brute(bars, p)["distance"] <= 0.7
    assert near.any()
    for r, v in zip((x, y, z), p, strict=True):
        assert (v[near] >= r.lo).all()
        assert (v[near] <= r.hi).all()
    assert x.hi < 40


def test_places_without_a_number_and_far_away() -> None:
    bars = FRAMES["nine"]
    p = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [-np.inf, np.nan, 0], [0, 0, 0]]).T
    for dtype in (np.float32, np.float64):
        got = dict(zip(ops.RESULTS, ops.nearest(bars, *p.astype(dtype)), strict=True))
        np.testing.assert_array_equal(got["distance"][:3], [np.nan, np.inf, np.nan])
        for result in ops.RESULTS[1:]:
            np.testing.assert_array_equal(got[result][:3], np.nan)
            assert np.isfinite(got[result][3])
    on_axis = FRAMES["one"]
    assert [float(v) for v in ops.nearest(on_axis, 2.0, 2.0, 3.0)[:4]] == [-0.5, 0, 0, 0]
    with pytest.raises(ValueError, match="no bar"):
        ops.nearest(Segments(np.empty((0, 3)), np.empty((0, 3)), np.empty(0)), 0.0, 0.0, 0.0)


def test_coordinates_broadcast_keep_their_type_and_fill_what_is_given() -> None:
    bars = FRAMES["random"]
    x, y, z = (np.linspace(0, 20, n) for n in (3, 4, 5))
    flat = np.array(np.meshgrid(x, y, z, indexing="ij")).reshape(3, -1)
    views = (x[:, None, None], y[None, :, None], z[None, None, :])
    for a, b in zip(ops.nearest(bars, *views), ops.nearest(bars, *flat), strict=True):
        np.testing.assert_array_equal(a, b.reshape(3, 4, 5))
    out = [np.empty((3, 4, 5)), np.empty((3, 4, 5))]
    got = ops.nearest(bars, *views, wanted=("index", "distance"), out=out)
    assert got[0] is out[0]
    np.testing.assert_array_equal(out[1], ops.nearest(bars, *flat)[10].reshape(3, 4, 5))
    single = ops.nearest(bars, *(v.astype(np.float32) for v in views))
    assert {v.dtype for v in single} == {np.dtype(np.float32)}


def test_a_frame_of_a_hundred_thousand_bars() -> None:
    bars = random_bars(100_000, side=100.0)
    p = around(bars, 60)
    got = ops.nearest(bars, *p)
    want = brute(bars, p)
    np.testing.assert_allclose(got[0], want["distance"], atol=1e-9)
    np.testing.assert_array_equal(got[10], want["index"])
    tree = ops.tree(bars, np.float32)
    numbers = tree.ids[tree.ids < len(bars)]
    np.testing.assert_array_equal(np.sort(numbers), np.arange(len(bars)))


# ---- shaders ---------------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def gpu() -> Iterator[Gpu]:
    try:
        opened = open_gpu("egl")
    except GpuMissing as missing:
        pytest.skip(f"no OpenGL here: {missing.reason}")
    with opened:
        yield opened


WALK = "PoreNearest v = pore_nearest0(x, y, z);" + "".join(f"o[at + {k}] = v.{r};" for k, r in enumerate(ops.RESULTS))


@pytest.mark.parametrize("name", FRAMES)
def test_shaders_find_what_numpy_finds_in_float32(gpu: Gpu, name: str) -> None:
    bars = FRAMES[name]
    p = around(bars, 2000).astype(np.float32)
    if name == "lattice":
        p[:, ::2] = np.rint(p[:, ::2] * 4) / 4  # places where bars tie
    p[0, :3], p[1, 3], p[2, 4:6] = np.nan, np.inf, -np.inf
    p[0, 6] = 1e30
    got = at_points(gpu, bars, "pore_nearest", WALK, len(ops.RESULTS), p)
    for result, values, want in zip(ops.RESULTS, got, ops.nearest(bars, *p), strict=True):
        np.testing.assert_array_equal(values, want, err_msg=result)


def test_the_walk_is_valid_for_opengl_es(gpu: Gpu) -> None:
    bars = FRAMES["random"]
    p = around(bars, 500).astype(np.float32)
    got = at_points(gpu, bars, "pore_nearest", WALK, len(ops.RESULTS), p, ES)
    np.testing.assert_allclose(got[0], ops.nearest(bars, *p)[0], atol=1e-4)


def test_cells_list_every_bar_that_may_be_nearest() -> None:
    """What a shader tries in a cell holds the nearest bar of any place in it; a crowded cell is left to the tree."""
    bars = random_bars(400)
    found = cells(bars)
    assert found is not None
    points = np.random.default_rng(4).uniform(found.lo, found.lo + found.size * np.array(found.shape), (20_000, 3))
    k = np.ravel_multi_index(tuple(((points - found.lo) // found.size).astype(int).T), found.shape)
    (index,) = ops.nearest(bars, *points.T, wanted=("index",))
    ids = ops.tree(bars, np.float64).ids
    listed = [set(ids[found.places[found.starts[i] : found.starts[i + 1]]].tolist()) for i in k]
    walked = [not some for some in listed]
    assert np.mean(walked) < 0.5
    assert all(w or int(i) in some for w, some, i in zip(walked, listed, index, strict=True))


def test_few_bars_have_no_cells() -> None:
    assert cells(random_bars(3)) is None
