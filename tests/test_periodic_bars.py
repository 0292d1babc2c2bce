"""Bars of a cell that repeats: against every bar of 5^3 copies, across the faces of cells, bounded, and on the GPU."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from slots import at_points

from porelang.data import Segments
from porelang.gpu import Gpu, GpuMissing, open_gpu
from porelang.interval import Interval, interval
from porelang.ops import segments as ops
from porelang.ops.segment_copies import copies

Values = NDArray[Any]
RNG = np.random.default_rng(21)
CORNERS = np.array(list(product((0.0, 1.0), repeat=3)))


def scaled(starts: Any, ends: Any, period: Any, radii: Any = 0.0) -> Segments:
    """Bars in parts of a cell as bars in mm."""
    w, starts, ends = np.array(period, float), np.array(starts, float), np.array(ends, float)
    return Segments(starts * w, ends * w, np.broadcast_to(np.asarray(radii, float), len(starts)).copy(), tuple(w))


def octet() -> tuple[Values, Values]:
    """All bonds of the face-centred cubic lattice from the four nodes of a cell: each twice, from both of its ends."""
    nodes = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
    ways = np.array([v for v in product((-0.5, 0, 0.5), repeat=3) if np.count_nonzero(v) == 2])
    return np.repeat(nodes, 12, axis=0), np.repeat(nodes, 12, axis=0) + np.tile(ways, (4, 1))


CELLS = {
    "octet, each bar twice": scaled(*octet(), (10, 10, 10), 0.6),
    "body-centred, one cell in four": scaled(np.full((8, 3), 0.5), CORNERS, (4, 6, 9), 0.0),
    "off the origin": scaled(octet()[0] + 7.3, octet()[1] + 7.3, (3, 3, 3), 0.1),
    "longer than the cell": scaled([[0, 0, 0], [0.2, 0.1, 0]], [[1.7, 1.4, 2.1], [0.2, 0.1, 1]], (5, 5, 5), [0.3, 0.9]),
    "random": scaled(RNG.random((9, 3)), RNG.random((9, 3)), (8, 11, 10), RNG.uniform(0, 1.5, 9)),
    "flat": scaled([[0.1, 0.2, 0.3]], [[0.9, 0.2, 0.4]], (20, 2, 3), 0.2),
}  # fmt: skip


def brute(bars: Segments, p: Values, reach: int = 3) -> dict[str, Values]:
    """The results at places (3, n) of every bar in (2 reach + 1)^3 copies about them, in float64."""
    w = np.array(bars.period)
    at = p.T - np.floor(p.T / w) * w
    best = np.full(len(at), np.inf)
    found = {name: np.zeros(len(at)) for name in ops.RESULTS}
    second = np.full(len(at), np.inf)
    starts = bars.starts - np.floor((bars.starts + bars.ends) / 2 / w) * w
    e = bars.ends - bars.starts
    steps = [range(-reach * max(1, int(w.max() / v / 2)), reach * max(1, int(w.max() / v / 2)) + 1) for v in w]
    for i in range(len(bars)):
        length = np.linalg.norm(e[i])
        for k in product(*steps):
            v = at - starts[i] - np.array(k) * w
            t = np.clip(v @ e[i] / length**2, 0, 1)
            q = v - t[:, None] * e[i]
            size = np.linalg.norm(q, axis=1)
            d = size - bars.radii[i]
            nearer = d < best - 1e-9
            other = np.where(nearer, best, np.where(np.abs(d - best) > 1e-9, d, np.inf))
            second = np.minimum(second, other)
            best = np.where(nearer, d, best)
            unit = q / np.where(size > 0, size, 1)[:, None]
            mine = [d, *unit.T, *(e[i] / length), t, bars.radii[i], length, i]
            for name, value in zip(ops.RESULTS, mine, strict=True):
                found[name] = np.where(nearer, value, found[name])
    return found | {"second": second}


def around(bars: Segments, count: int) -> Values:
    return RNG.uniform(-3, 3, (3, count)) * np.array(bars.period)[:, None]


@pytest.mark.parametrize("name", CELLS)
def test_results_are_those_of_trying_every_copy(name: str) -> None:
    bars = CELLS[name]
    p = around(bars, 400)
    got = dict(zip(ops.RESULTS, ops.nearest(bars, *p), strict=True))
    want = brute(bars, p)
    np.testing.assert_allclose(got["distance"], want["distance"], atol=1e-9)
    clear = want["second"] - want["distance"] > 1e-6
    assert clear.mean() > 0.5
    for result in ("nx", "ny", "nz", "along", "radius", "length"):
        near = np.abs(got[result] - want[result]) < 1e-6
        assert (near | ~clear).all() or name.startswith("octet"), result  # whose bars may be found the other way round
    if name.startswith("octet"):
        assert (got["index"] < 48).all()
    else:
        np.testing.assert_array_equal(got["index"][clear], want["index"][clear])


def test_bars_that_lie_in_one_place_are_one() -> None:
    assert len(np.unique(copies(CELLS["octet, each bar twice"]).of)) == 24
    faces = scaled([[0, 0, 0], [1, 0, 0], [0, 1, 1], [0, 0, 0]], [[0, 0, 1], [1, 0, 1], [0, 1, 0], [0, 0, 1]],
                   (1, 1, 1), [0.1, 0.1, 0.1, 0.2])  # fmt: skip
    assert set(copies(faces).of.tolist()) == {0, 3}, "another radius is another bar"


def test_the_period_is_part_of_the_digest() -> None:
    bars = CELLS["random"]
    others = [replace(bars, period=None), replace(bars, period=(8.0, 11.0, 10.5))]
    assert len({b.digest for b in (bars, *others)}) == 3


@pytest.mark.parametrize("name", CELLS)
def test_nothing_jumps_where_cells_meet(name: str) -> None:
    """Over a small box about a face of a cell the distance is bounded as over any other, and by one bar as often."""
    bars = CELLS[name]
    w = np.array(bars.period)[:, None]
    on_faces = np.rint(RNG.uniform(-3, 3, (3, 600))) * w + w / 2 * RNG.integers(0, 2, (3, 600))
    free = RNG.integers(0, 2, (3, 600)).astype(bool)
    p = np.where(free, around(bars, 600), on_faces)
    at = [interval(v - 1e-7, v + 1e-7) for v in p]
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, *at), strict=True))
    assert (bounds["distance"].hi - bounds["distance"].lo < 5e-7).all()
    inside = [interval(v - 1e-7, v + 1e-7) for v in around(bars, 600)]
    if name in ("random", "off the origin", "flat"):
        one = ~ops.jumps_nearest(bars, *inside)[-1]
        face = ~ops.jumps_nearest(bars, *at)[-1]
        assert one.mean() > 0.9
        assert face.mean() > (0.5 if name == "random" else 0.2)


@pytest.mark.parametrize("name", CELLS)
def test_no_sample_leaves_its_bound(name: str) -> None:
    bars = CELLS[name]
    count = 150
    side = 10 ** RNG.uniform(-6, 1.5, (3, count)) * RNG.integers(0, 2, (3, count))
    centre = around(bars, count)
    lo, hi = centre - side / 2, centre + side / 2
    at = [interval(a, b) for a, b in zip(lo, hi, strict=True)]
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, *at), strict=True))
    for t in RNG.uniform(-0.2, 1.2, (12, 3, 1)).clip(0, 1):
        got = dict(zip(ops.RESULTS, ops.nearest(bars, *(lo + t * (hi - lo))), strict=True))
        for result, bound in bounds.items():
            assert (got[result] >= bound.lo - 1e-11).all(), result
            assert (got[result] <= bound.hi + 1e-11).all(), result
    wide = (side / 2 > 0.26 * np.array(bars.period)[:, None]).any(0)
    assert wide.any()
    assert np.ptp(bounds["distance"].hi[wide]) < 1e-9, "what is wider than a period has the range of everything"
    assert (bounds["distance"].lo[wide] <= -bars.radii.max()).all()


def test_bounds_of_all_of_space_and_far_away() -> None:
    bars = CELLS["random"]
    whole = Interval(np.array([-np.inf, 1e17, 1e19]), np.array([np.inf, 1e17, 1e19]), np.zeros(3, bool))
    bounds = dict(zip(ops.RESULTS, ops.enclose_nearest(bars, whole, whole, whole), strict=True))
    assert bounds["distance"].hi[0] == np.inf
    assert bounds["distance"].hi[2] == np.inf
    assert bounds["distance"].nan.tolist() == [False] * 3
    got = dict(zip(ops.RESULTS, ops.nearest(bars, np.inf, 0.0, 1.0), strict=True))
    assert got["distance"] == np.inf
    assert np.isnan(got["nx"])
    assert all(np.isnan(v) for v in ops.nearest(bars, np.nan, 0.0, 1.0))
    x, *_ = ops.narrow_distance(interval(-np.inf, 0.7), bars, whole, whole, whole)
    assert (x.lo == -np.inf).all(), "they have no end"


@pytest.mark.parametrize("name", CELLS)
def test_float32_stays_within_the_rounding_that_is_said(name: str) -> None:
    bars = CELLS[name]
    p = np.concatenate([around(bars, 800), 100 * around(bars, 800)], axis=1).astype(np.float32)
    at = [interval(v.astype(float)) for v in p]
    want = dict(zip(ops.RESULTS, ops.nearest(bars, *p.astype(float)), strict=True))
    bounds = dict(zip(ops.RESULTS, ops.rounding_nearest(bars, *at), strict=True))
    jumps = dict(zip(ops.RESULTS, ops.jumps_nearest(bars, *at), strict=True))
    got = dict(zip(ops.RESULTS, ops.nearest(bars, *p), strict=True))
    for result in ops.RESULTS:
        steady = ~jumps[result]
        far = np.abs(got[result] - want[result])[steady]
        assert (far <= bounds[result][steady] * 2.0**-23).all(), result
    assert np.isfinite(bounds["distance"]).all()
    assert (np.abs(got["distance"] - want["distance"]) / bounds["distance"] / 2.0**-23).max() > 0.002


@pytest.fixture(scope="module")
def gpu() -> Iterator[Gpu]:
    try:
        opened = open_gpu("egl")
    except GpuMissing as missing:
        pytest.skip(f"no OpenGL here: {missing.reason}")
    with opened:
        yield opened


WALK = "PoreNearest v = pore_nearest0(x, y, z);" + "".join(f"o[at + {k}] = v.{r};" for k, r in enumerate(ops.RESULTS))


@pytest.mark.parametrize("name", CELLS)
def test_shaders_find_what_numpy_finds_in_float32(gpu: Gpu, name: str) -> None:
    bars = CELLS[name]
    p = around(bars, 2000).astype(np.float32)
    p[:, ::2] = np.rint(p[:, ::2] * 4) / 4  # places where bars tie, on faces of cells
    p[0, :3], p[1, 3], p[2, 4:6], p[0, 6], p[0, 7] = np.nan, np.inf, -np.inf, 1e30, 3e38
    got = at_points(gpu, bars, "pore_nearest", WALK, len(ops.RESULTS), p)
    for result, values, want in zip(ops.RESULTS, got, ops.nearest(bars, *p), strict=True):
        np.testing.assert_array_equal(values, want, err_msg=result)
