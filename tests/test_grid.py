"""Lookup in sampled fields: against SciPy and formulas of our own, its bounds against dense samples, and on the GPU."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from slots import ES, at_points

import porelang
from porelang.analysis.enclose import F32, enclose
from porelang.backends.numpy import NumpyField
from porelang.conformance.samples import GRID
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.gpu import Gpu, GpuMissing, open_gpu
from porelang.interval import Interval, interval
from porelang.ir import X, Y, Z, node
from porelang.ops import grid as ops

Values = NDArray[Any]
RNG = np.random.default_rng(7)
LINEAR = [(0, i, j, k) for i, j, k in itertools.product((0, 1), repeat=3)]
CUBIC = [(0, *o) for o in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0), (1, 1, 0), (0, 2, 1), (3, 0, 0))]
BOTH = [(p, False) for p in LINEAR] + [(p, True) for p in CUBIC]


def noise(shape: tuple[int, ...] = (6, 5, 7), dtype: Any = np.float64, **place: Any) -> SampledField:
    values = RNG.normal(size=shape).astype(dtype)
    return SampledField.from_array(
        values, place.get("origin", (-3.0, 1.0, 0.25)), place.get("spacing", (0.5, 1.5, 0.8))
    )


def inside(grid: SampledField, count: int, margin: float = 0.0) -> Values:
    """Random points in the grid's box, or as far around it as `margin` times its sides; (3, n)."""
    lo, hi = np.array(grid.origin), np.array(grid.end)
    more = margin * (hi - lo)
    return RNG.uniform((lo - more)[:, None], (hi + more)[:, None], (3, count))


def of(function: Any) -> SampledField:
    """A function sampled on a grid."""
    axes = [o + s * np.arange(n) for o, s, n in ((-3.0, 0.5, 6), (1.0, 1.5, 5), (0.25, 0.8, 7))]
    return SampledField.from_array(function(*np.meshgrid(*axes, indexing="ij")), (-3.0, 1.0, 0.25), (0.5, 1.5, 0.8))


def evaluate(grid: SampledField, p: Values, payload: ops.Payload, cubic: bool) -> Values:
    return (ops.lookup_cubic if cubic else ops.lookup)(grid, *p, payload)


def exact(grid: SampledField, p: Values, payload: ops.Payload, cubic: bool) -> Values:
    """The interpolant by its definition, in float64: weights of the nodes, padded by lines at the border."""
    values = grid.values[..., payload[0]].astype(float)
    for axis in range(3):
        v = np.moveaxis(values, axis, 0)
        v = np.concatenate([2 * v[:1] - v[1:2], v, 2 * v[-1:] - v[-2:-1]])
        values = np.moveaxis(v, 0, axis)
    result = np.zeros(p.shape[1])
    weights, cells, outside = [], [], np.zeros(p.shape[1], bool)
    for axis, order in enumerate(payload[1:]):
        n, h = grid.shape[axis], grid.spacing[axis]
        u = (p[axis].astype(float) - grid.origin[axis]) / h
        outside |= (order > 0) & ((u < 0) | (u > n - 1))
        u = np.clip(u, 0, n - 1)
        i = np.minimum(np.floor(u), n - 2).astype(int)
        rows = [[0, -0.5, 1, -0.5], [1, 0, -2.5, 1.5], [0, 0.5, 2, -1.5], [0, 0, -0.5, 0.5]]
        if not cubic:
            rows = [[0, 0], [1, -1], [0, 1], [0, 0]]
        polynomials = [np.polynomial.Polynomial(c).deriv(order) for c in rows]
        weights.append([w(u - i) / h**order for w in polynomials])
        cells.append(i)
    for a, b, c in itertools.product(range(4), repeat=3):
        w = weights[0][a] * weights[1][b] * weights[2][c]
        result += w * values[cells[0] + a, cells[1] + b, cells[2] + c]
    return np.where(outside, 0.0, result)


# ---- values ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_linear_form_is_that_of_scipy(dtype: Any) -> None:
    grid = noise((9, 8, 7, 2), dtype)
    p = inside(grid, 5000, 0.3)
    u = (p - np.array(grid.origin)[:, None]) / np.array(grid.spacing)[:, None]
    for component in (0, 1):
        want = map_coordinates(grid.values[..., component].astype(float), u, order=1, mode="nearest")
        np.testing.assert_allclose(ops.lookup(grid, *p, (component, 0, 0, 0)), want, atol=1e-12)


@pytest.mark.parametrize(("payload", "cubic"), BOTH)
def test_values_and_derivatives_are_those_of_the_definition(payload: ops.Payload, cubic: bool) -> None:
    for shape in ((6, 5, 7), (2, 3, 2)):
        grid = noise(shape)
        p = inside(grid, 3000, 0.2)
        np.testing.assert_allclose(evaluate(grid, p, payload, cubic), exact(grid, p, payload, cubic), atol=1e-10)


@pytest.mark.parametrize("cubic", [False, True])
def test_affine_fields_are_exact_everywhere(cubic: bool) -> None:
    grid = of(lambda x, y, z: 3 + 2 * x - y + 0.5 * z)
    x, y, z = p = inside(grid, 1000)
    np.testing.assert_allclose(evaluate(grid, p, (0, 0, 0, 0), cubic), 3 + 2 * x - y + 0.5 * z, atol=1e-12)
    for payload, slope in (((0, 1, 0, 0), 2), ((0, 0, 1, 0), -1), ((0, 0, 0, 1), 0.5)):
        np.testing.assert_allclose(evaluate(grid, p, payload, cubic), slope, atol=1e-12)


def test_the_cubic_form_is_exact_for_squares_away_from_the_border() -> None:
    grid = of(lambda x, y, z: x * x - 2 * x * y + z * z)
    lo = np.array(grid.origin) + np.array(grid.spacing)
    hi = np.array(grid.end) - np.array(grid.spacing)
    x, y, z = p = RNG.uniform(lo[:, None], hi[:, None], (3, 1000))
    cases = {(0, 0, 0, 0): x * x - 2 * x * y + z * z, (0, 1, 0, 0): 2 * x - 2 * y, (0, 1, 1, 0): -2 + 0 * x,
             (0, 0, 0, 2): 2 + 0 * x, (0, 3, 0, 0): 0 * x}  # fmt: skip
    for payload, want in cases.items():
        np.testing.assert_allclose(evaluate(grid, p, payload, True), want, atol=1e-9)


def test_the_gradient_of_the_cubic_form_is_that_of_its_values() -> None:
    grid = noise()
    p, step = inside(grid, 2000), 1e-6
    for axis in range(3):
        shift = step * np.eye(3)[axis][:, None]
        slope = (
            (evaluate(grid, p + shift, (0, 0, 0, 0), True) - evaluate(grid, p - shift, (0, 0, 0, 0), True)) / 2 / step
        )
        order = (0, *(int(a == axis) for a in range(3)))
        near = np.min(np.abs((p[axis] - grid.origin[axis]) / grid.spacing[axis] % 1 - 0.5) < 0.499, axis=0)
        np.testing.assert_allclose(evaluate(grid, p, order, True)[near], slope[near], atol=1e-6)  # type: ignore[arg-type]


def test_a_constant_field_comes_out_exactly() -> None:
    for dtype in (np.float32, np.float64):
        value = dtype(0.1)
        grid = SampledField.from_array(np.full((4, 4, 4), value), (0, 0, 0), 0.3)
        p = inside(grid, 1000, 0.5).astype(dtype)
        for cubic in (False, True):
            assert (evaluate(grid, p, (0, 0, 0, 0), cubic) == value).all()
            assert (evaluate(grid, p, (0, 1, 0, 0), cubic) == 0).all()


def test_places_without_a_number_and_far_away() -> None:
    grid = noise()
    inf, nan = np.inf, np.nan
    first, last = grid.values[0, 0, 0, 0], grid.values[-1, -1, -1, 0]
    for cubic in (False, True):
        p = np.array([[-inf] * 3, [inf] * 3, [nan, 2, 2], [0, nan, inf], [1e300, 1e300, 1e300]]).T
        np.testing.assert_allclose(evaluate(grid, p, (0, 0, 0, 0), cubic), [first, last, nan, nan, last])
        np.testing.assert_array_equal(evaluate(grid, p, (0, 1, 0, 0), cubic), [0, 0, nan, nan, 0])
    np.testing.assert_array_equal(ops.covers(grid, *p), [False] * 5)
    corners = np.array([grid.origin, grid.end]).T
    assert ops.covers(grid, *corners).all()
    assert not ops.covers(grid, *np.nextafter(corners, [[-9, 9]] * 3)).any()


def test_coordinates_broadcast_keep_their_type_and_fill_what_is_given() -> None:
    grid = noise()
    x, y, z = (np.linspace(a, b, n) for a, b, n in zip(grid.origin, grid.end, (4, 5, 6), strict=True))
    whole = evaluate(grid, np.array(np.meshgrid(x, y, z, indexing="ij")).reshape(3, -1), (0, 0, 0, 0), False)
    whole = whole.reshape(4, 5, 6)
    views = (x[:, None, None], y[None, :, None], z[None, None, :])
    np.testing.assert_array_equal(ops.lookup(grid, *views, (0, 0, 0, 0)), whole)
    big = np.zeros((9, 9, 9))
    window = big[1:5, ::-1, ::2][:, :5, :][:, :, :5]
    got = ops.lookup(grid, x[:, None, None], y[None, :, None], z[None, None, :5], (0, 0, 0, 0), window)
    assert got is window
    np.testing.assert_array_equal(big[1:5, ::-1, ::2][:, :5, :5], whole[:, :, :5])
    single = [v.astype(np.float32) for v in views]
    assert ops.lookup(grid, *single, (0, 0, 0, 0)).dtype == np.float32
    assert ops.lookup(grid, np.float32(0), single[1], np.float32(1), (0, 0, 0, 0)).shape == (1, 5, 1)
    assert ops.lookup(grid, 0, 2, 1.0, (0, 0, 0, 0)).shape == ()
    four = [v[None].repeat(2, 0) for v in views]
    np.testing.assert_array_equal(ops.lookup(grid, *four, (0, 0, 0, 0))[1], whole)
    np.testing.assert_array_equal(ops.lookup(grid, x[::-1], y[0], z[0], (0, 0, 0, 0)), whole[::-1, 0, 0])
    with pytest.raises(ValueError, match="out is"):
        ops.lookup(grid, *views, (0, 0, 0, 0), np.empty((4, 5, 5)))


# ---- bounds ----------------------------------------------------------------------------------------------------------
def boxes(grid: SampledField, count: int) -> tuple[Values, Values]:
    """Boxes of all sizes from a point to more than the grid, inside and around it; (3, n) each."""
    centre = inside(grid, count, 0.3)
    side = np.array(grid.spacing)[:, None] * 10 ** RNG.uniform(-4, 1.2, (3, count)) * RNG.integers(0, 2, (3, count))
    return centre - side / 2, centre + side / 2


def ranges(lo: Values, hi: Values) -> list[Interval]:
    return [interval(a, b) for a, b in zip(lo, hi, strict=True)]


@pytest.mark.parametrize(("payload", "cubic"), BOTH)
def test_no_sample_leaves_its_bound(payload: ops.Payload, cubic: bool) -> None:
    for grid in (noise(), noise((2, 3, 40)), noise((20, 20, 20), np.float32)):
        lo, hi = boxes(grid, 400)
        bound = ops.enclose(grid, *ranges(lo, hi), payload, cubic)
        assert not bound.nan.any()
        for t in [*RNG.uniform(0, 1, (60, 3, 1)), *np.array(list(itertools.product((0, 1), repeat=3)))[..., None]]:
            got = exact(grid, lo + t * (hi - lo), payload, cubic)
            slack = (
                1e-13
                * np.abs(grid.values).max()
                * np.prod([s**-o for s, o in zip(grid.spacing, payload[1:], strict=True)])
            )
            assert (got >= bound.lo - 20 * slack).all()  # rounding of the samples
            assert (got <= bound.hi + 20 * slack).all()


@pytest.mark.parametrize("payload", LINEAR)
def test_the_bound_over_a_part_of_few_cells_is_exact(payload: ops.Payload) -> None:
    grid = noise()
    cell = np.array([[1, 2, 3]]).T + np.zeros((3, 200))
    f = np.sort(RNG.uniform(0.001, 0.999, (2, 3, 200)), axis=0)
    f[1] += RNG.integers(0, 2, (3, 200)) * (np.array(payload[1:]) == 0)[:, None]  # into the next cell
    step, origin = np.array(grid.spacing)[:, None], np.array(grid.origin)[:, None]
    lo, hi = origin + step * (cell + f[0]), origin + step * (cell + f[1])
    bound = ops.enclose(grid, *ranges(lo, hi), payload, False)
    node = cell + 1
    seen = []
    for picks in itertools.product(range(3), repeat=3):  # the ends of the box, and the node between if there is one
        place = [np.choose(k, [a, b, np.clip(origin[i] + step[i] * node[i], a, b)])
                 for i, (k, a, b) in enumerate(zip(picks, lo, hi, strict=True))]  # fmt: skip
        seen.append(exact(grid, np.array(place), payload, False))
    np.testing.assert_allclose(bound.lo, np.min(seen, axis=0), atol=1e-9)
    np.testing.assert_allclose(bound.hi, np.max(seen, axis=0), atol=1e-9)


def test_the_cubic_bound_closes_in_with_the_square_of_the_box() -> None:
    grid = noise()
    centre = inside(grid, 300)
    excess = []
    for side in (0.2, 0.02):
        lo, hi = centre - side / 2, centre + side / 2
        bound = ops.enclose(grid, *ranges(lo, hi), (0, 0, 0, 0), True)
        seen = [exact(grid, lo + t[:, None] * (hi - lo), (0, 0, 0, 0), True)
                for t in np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3), -1).reshape(-1, 3)]  # fmt: skip
        excess.append(np.mean((bound.hi - bound.lo) - np.ptp(seen, axis=0)))
    assert excess[1] < excess[0] / 30


def test_a_bound_over_many_cells_holds_the_nodes_and_little_more() -> None:
    i = np.arange(200.0)
    grid = SampledField.from_array(i[:, None, None] + np.zeros((200, 4, 4)), (0, 0, 0), 1.0)
    x = interval(np.array([10.5, 0.0, -np.inf]), np.array([60.5, 199.0, np.inf]))
    y = interval(np.zeros(3), np.ones(3))
    for cubic, most in ((False, 1.4), (True, 3.0)):
        bound = ops.enclose(grid, x, y, y, (0, 0, 0, 0), cubic)
        assert (bound.hi - bound.lo <= most * np.array([52.0, 199, 199])).all()
        assert (bound.lo <= [10.5, 0, 0]).all()
        assert (bound.hi >= [60.5, 199, 199]).all()
    slope = ops.enclose(grid, x, y, y, (0, 1, 0, 0), False)
    np.testing.assert_allclose([slope.lo[0], slope.hi[0]], [1, 1])
    np.testing.assert_allclose([slope.lo[2], slope.hi[2]], [0, 1])


def test_where_a_value_is_taken_is_read_from_planes_of_nodes() -> None:
    """No place of a value lies without the ranges; those of a distance to a box end at the box."""
    grid = of(lambda x, y, z: x + 0.3 * RNG.normal(size=x.shape))
    p = inside(grid, 4000, 1.0)
    found = evaluate(grid, p, (0, 0, 0, 0), False)
    for lo, hi in ((-np.inf, -2.5), (-2.0, -1.9), (-1.0, np.inf)):
        told = ops.narrow(interval(lo, hi), grid, (0, 0, 0, 0))
        here = p[:, (found >= lo) & (found <= hi)]
        assert here.size
        for axis, r in enumerate(told):
            assert r is not None
            assert (r.contains(here[axis].min()) & r.contains(here[axis].max())).all()
    ends = np.array([1.3, 2.1, 0.4])
    nodes = np.stack(np.meshgrid(*3 * [np.linspace(-3, 3, 13)], indexing="ij"), axis=-1)
    box = SampledField.from_array((np.abs(nodes) - ends).max(axis=-1), (-3, -3, -3), 0.5)
    for most in (0.0, 0.25, np.array([0.0, 0.25])):
        told = ops.narrow(interval(-np.inf, most), box, (0, 0, 0, 0))
        for r, end in zip(told, ends, strict=True):
            assert r is not None
            np.testing.assert_allclose([r.lo, r.hi], [-end - most, end + most], atol=1e-12)
    never, always = (ops.narrow(interval(-np.inf, most), box, (0, 0, 0, 0))[0] for most in (-9.0, 9.0))
    assert never is not None
    assert never.empty
    assert always is not None
    assert (always.lo, always.hi) == (-np.inf, np.inf)
    assert ops.narrow(interval(0, 1), box, (0, 1, 0, 0)) == (None, None, None)


def test_bounds_know_of_places_that_are_no_numbers() -> None:
    grid = noise()
    nothing = Interval(np.array([np.inf, 0.0]), np.array([-np.inf, 1.0]), np.array([True, True]))
    bound = ops.enclose(grid, nothing, interval(2.0), interval(1.0), (0, 0, 0, 0), False)
    assert bound.nan.all()
    assert bound.empty.tolist() == [True, False]
    whole = Interval(np.array(-np.inf), np.array(np.inf), np.array(False))
    bound = ops.enclose(grid, whole, whole, whole, (0, 0, 0, 0), False)
    assert bound.lo.shape == ()
    assert bound.lo <= grid.values.min()
    assert bound.hi >= grid.values.max()
    inside_ = ops.enclose_covers(grid, nothing, interval(2.0), interval(1.0))
    assert inside_.hi.tolist() == [0, 0]


def test_the_bound_of_covers_is_that_of_its_samples() -> None:
    grid = noise()
    lo, hi = boxes(grid, 500)
    bound = ops.enclose_covers(grid, *ranges(lo, hi))
    for t in RNG.uniform(0, 1, (50, 3, 1)):
        got = ops.covers(grid, *(lo + t * (hi - lo)))
        assert (got >= bound.lo).all()
        assert (got <= bound.hi).all()
    assert (bound.lo == 1).sum() > 50
    assert (bound.hi == 0).sum() > 50


@pytest.mark.parametrize(("payload", "cubic"), BOTH)
def test_a_result_jumps_only_where_it_is_said_to(payload: ops.Payload, cubic: bool) -> None:
    grid = noise()
    p = inside(grid, 2000, 0.1)
    axis = RNG.integers(0, 3, 2000)
    rows = np.arange(2000)
    half = rows < 1000  # half of the places lie within rounding of a node
    u = np.rint((p[axis, rows] - np.array(grid.origin)[axis]) / np.array(grid.spacing)[axis])
    p[axis[half], rows[half]] = (np.array(grid.origin)[axis] + u * np.array(grid.spacing)[axis])[half]
    lo, hi = p - 1e-9, p + 1e-9
    mask = ops.jumps(grid, *ranges(lo, hi), payload, cubic)
    leaps = np.abs(exact(grid, hi, payload, cubic) - exact(grid, lo, payload, cubic)) > 1e-5
    assert not (leaps & ~mask).any()
    assert mask[half].any() == (sum(payload[1:]) > 0)
    assert mask[~half].mean() < 0.01


@pytest.mark.parametrize(("payload", "cubic"), BOTH)
def test_float32_stays_within_the_rounding_that_is_said(payload: ops.Payload, cubic: bool) -> None:
    most = 0.0
    for values in ("noise", "constant", "slope"):
        for origin, spacing in (((0, 0, 0), 1.0), ((1e4, -1e4, 3), 0.01), ((-17.3, 0.1, 5.5), (0.37, 2.1, 0.013))):
            grid = noise((12, 9, 10), origin=origin, spacing=spacing)
            if values == "constant":
                grid = SampledField.from_array(np.full((12, 9, 10), 123.456), origin, spacing)
            if values == "slope":
                grid = SampledField.from_array(np.arange(1080.0).reshape(12, 9, 10) + 1e4, origin, spacing)
            p = inside(grid, 3000, 0.1).astype(np.float32)
            at = [interval(v.astype(float)) for v in p]
            bound = ops.rounding(grid, *at, payload, cubic) * 2.0**-23
            far = np.abs(evaluate(grid, p, payload, cubic) - exact(grid, p, payload, cubic))
            steady = ~ops.jumps(grid, *at, payload, cubic)
            assert (far <= bound)[steady].all()
            if values != "constant":
                most = max(most, (far / bound)[steady].max())
    assert most > (0.002 if cubic else 0.02)  # it is no idle bound


# ---- shaders ---------------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def gpu() -> Iterator[Gpu]:
    try:
        opened = open_gpu("egl")
    except GpuMissing as missing:
        pytest.skip(f"no OpenGL here: {missing.reason}")
    with opened:
        yield opened


def hard_points(grid: SampledField) -> Values:
    """Places inside and outside, on nodes and beside them, without a number and infinitely far away."""
    p = inside(grid, 4000, 0.3)
    step, origin = np.array(grid.spacing)[:, None], np.array(grid.origin)[:, None]
    p[:, :1500] = origin + np.rint((p[:, :1500] - origin) / step) * step
    single = p.astype(np.float32)
    single[:, :500] = np.nextafter(single[:, :500], np.float32(np.inf))
    single[:, 500:1000] = np.nextafter(single[:, 500:1000], np.float32(-np.inf))
    single[0, 2000:2010], single[1, 2005:2015], single[2, 2012:2020] = np.nan, np.inf, -np.inf
    return single


@pytest.mark.parametrize("place", [((-3.0, 1.0, 0.25), (0.5, 1.5, 0.8)), ((1e4, -300.1, 7.7), (0.013, 0.37, 2.9))])
def test_shaders_equal_numpy_in_float32(gpu: Gpu, place: Any) -> None:
    grid = noise((9, 2, 7, 2), origin=place[0], spacing=place[1])
    p = hard_points(grid)
    inside_ = at_points(gpu, grid, "pore_covers", "o[at] = pore_covers0(x, y, z) ? 1.0 : 0.0;", 1, p)[0]
    np.testing.assert_array_equal(inside_ != 0, ops.covers(grid, *p))
    for payload, cubic in [*BOTH, ((1, 0, 0, 0), False), ((1, 0, 0, 0), True)]:
        name = "pore_cubic" if cubic else "pore_lookup"
        call = f"o[at] = {name}0(x, y, z, {', '.join(map(str, payload))});"
        got = at_points(gpu, grid, name, call, 1, p)[0]
        want = evaluate(grid, p, payload, cubic)
        np.testing.assert_array_equal(got, want, err_msg=f"{name} {payload}")


def test_lookup_is_valid_for_opengl_es(gpu: Gpu) -> None:
    grid = noise()
    p = inside(grid, 500).astype(np.float32)
    for name, cubic in (("pore_lookup", False), ("pore_cubic", True)):
        got = at_points(gpu, grid, name, f"o[at] = {name}0(x, y, z, 0, 0, 0, 0);", 1, p, ES)[0]
        np.testing.assert_allclose(got, evaluate(grid, p, (0, 0, 0, 0), cubic), atol=1e-4)


def test_bounds_of_wide_boxes_that_reach_beyond_hold() -> None:
    """They are put together from blocks that are enclosed once: of each box the least and the greatest block tell."""
    grid = noise((33, 19, 40), origin=(-10.0, -10.0, -10.0), spacing=(0.6, 1.1, 0.5))
    random = np.random.default_rng(4)
    low, size = random.uniform(-20, 5, (300, 3)), random.uniform(4, 30, (300, 3))
    root = node("lookup_cubic", GRID, X, Y, Z, value=(0, 0, 0, 0))
    formula = Formula((root,), {GRID: grid})
    found = enclose(formula, [interval(low[:, a], low[:, a] + size[:, a]) for a in range(3)])[0].range
    field = NumpyField(formula, "f64", 1)
    for _ in range(100):
        value = field.at(low + random.random((300, 3)) * size)
        assert ((value >= found.lo) & (value <= found.hi)).all()
    # and closer than by what a cubic may overshoot of all nodes: there alone is the range that of a part
    one = enclose(formula, [interval(np.array([-40.0]), np.array([e])) for e in (-8.0, 40.0, 40.0)])[0].range
    whole = enclose(formula, [interval(np.array([-40.0]), np.array([40.0]))] * 3)[0].range
    assert one.hi - one.lo < whole.hi - whole.lo <= 2 * np.ptp(grid.values)


@pytest.mark.parametrize("voxel", ["1mm", "2mm", "4mm"])
@pytest.mark.parametrize("region", ["sphere(10)", "cube(20)"])
def test_a_solid_within_its_smooth_samples_has_an_end(region: str, voxel: str) -> None:
    """A cubic may overshoot by a part of what it ranges over, but not so far out as to be solid beyond its samples."""
    program = porelang.compile(f"sample(length(p) - 6, {voxel}, {region}, smooth=true)")
    box = program.bounds()
    points = np.random.default_rng(3).uniform(-40, 40, (20_000, 3))
    solid = points[program.field()(points) <= 0]
    assert ((solid >= box.lo) & (solid <= box.hi)).all()
    assert max(box.hi) < 13


def test_a_bound_knows_where_float32_has_no_room_on_the_way() -> None:
    """Values of 1e36 at every 0.01 mm: differences of sums that overflow are no numbers."""
    grid = SampledField.from_array(np.random.default_rng(0).uniform(-1e36, 1e36, (6, 6, 6)), (0, 0, 0), 0.01)
    root = node("lookup_cubic", GRID, X, Y, Z, value=(0, 0, 0, 1))
    formula = Formula((root,), {GRID: grid})
    points = np.random.default_rng(1).uniform(0, 0.05, (2000, 3)).astype(np.float32).astype(np.float64)
    with np.errstate(all="ignore"):
        found = np.isnan(NumpyField(formula, "f32").at(points))
    assert found.any()
    assert enclose(formula, [interval(c) for c in points.T], F32)[0].range.nan[found].all()
