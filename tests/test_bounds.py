"""What is proven about a field over a box holds at every sample of it: ranges, slopes, the box of the part."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang as pore
from porelang.analysis.bounds import box_test, lipschitz, slopes
from porelang.analysis.box import part_box
from porelang.analysis.branches import Branches
from porelang.analysis.enclose import EXACT, F32, F64, enclose
from porelang.backends.numpy import NumpyField
from porelang.conformance import samples as data
from porelang.conformance.generate import RANGES
from porelang.conformance.suite import random_graphs
from porelang.formula import Formula, ranges
from porelang.interval import interval
from porelang.ir import X, Y, Z, node
from porelang.rewrites import flatten

Points = NDArray[np.float64]
MIDDLE = {name: (lo + hi) / 2 for name, (lo, hi) in RANGES.items()}
SHAPES = {
    "sphere": "sphere(10)",
    "box": "box([10, 20, 30], round=2)",
    "cylinder": "cylinder(10, 25, round=1)",
    "cone": "cone(12, 3, 20)",
    "capsule": "capsule([-8, 0, 3], [9, 5, -4], 3)",
    "torus": "torus(15, 4)",
    "polyline": "polyline([[0, 0, 0], [20, 0, 0], [20, 10, 5]], 2)",
    "tetrahedron": "tetrahedron(6)",
    "dodecahedron": "dodecahedron(9)",
    "prism": "prism(5, 10, 20)",
    "turned": "rotate(box([10, 20, 30]), [1, 2, 3], 35deg)",
    "moved": "translate(sphere(4), [30, -20, 10]) | translate(sphere(6), [-10, 0, 5])",
    "ring": "ring(translate(sphere(3), [12, 0, 0]), 6)",
    "lattice": "gyroid(9) & cylinder(15, 20)",
    "graded": "gyroid(12) |> thicken(sphere(20) / 10, 0.3) & box([30, 30, 30])",
    "shelled": "shell(schwarz_p([8, 9, 10]), 0.4) & sphere(14)",
    "smooth": "smooth_union(sphere(8), translate(box([8, 8, 8]), [7, 0, 0]), 3)",
    "difference": "cube(20) \\ cylinder(6, 30)",
    "repeated": "repeat(sphere(3), 10, counts=[3, 2, 1])",
    "twisted": "twist(box([12, 8, 40]), 0.05)",
}
BOXED = {  # the true corners of what lies along the axes
    "sphere(10)": ((-10, -10, -10), (10, 10, 10)),
    "box([10, 20, 30])": ((-5, -10, -15), (5, 10, 15)),
    "box([10, 20, 30], round=2)": ((-5, -10, -15), (5, 10, 15)),
    "cylinder(75, 300)": ((-75, -75, -150), (75, 75, 150)),
    "torus(15, 4)": ((-19, -19, -4), (19, 19, 4)),
    "capsule([0, 0, -10], [0, 0, 10], 3)": ((-3, -3, -13), (3, 3, 13)),
    "translate(sphere(2), [100, 0, -50])": ((98, -2, -52), (102, 2, -48)),
    "sphere(5) | translate(sphere(3), [20, 0, 0])": ((-5, -5, -5), (23, 5, 5)),
    "sphere(10) & box([30, 6, 30])": ((-10, -3, -10), (10, 3, 10)),
    "gyroid(5) & box([30, 20, 10])": ((-15, -10, -5), (15, 10, 5)),
    "translate(cube(0.02), [0.01, 0.01, 0.01])": ((0, 0, 0), (0.02, 0.02, 0.02)),
}


def flat(text: str) -> Formula:
    return Formula.of(pore.compile(text).solid("part"))


def boxes(rng: np.random.Generator, count: int, reach: float = 25.0, scales: float = 4.0) -> tuple[Points, Points]:
    """Boxes of sizes over `scales` decades, some of them on the axes."""
    size = reach * 10.0 ** -rng.uniform(0, scales, (count, 1)) * rng.uniform(0.2, 1, (count, 3))
    middle = rng.uniform(-reach, reach, (count, 3)) * (rng.random((count, 3)) < 0.8)
    return middle - size / 2, middle + size / 2


def samples(rng: np.random.Generator, lo: Points, hi: Points, each: int) -> Points:
    """Points (each, n, 3) of boxes: corners, middles, and random ones."""
    t = rng.random((each, len(lo), 3))
    t[: each // 3] = np.rint(t[: each // 3] * 2) / 2
    return np.clip(lo + (hi - lo) * t, lo, hi)


def values(formula: Formula, points: Points, dtype: str = "f64") -> Points:
    got = NumpyField(formula, dtype, threads=1).at(points.reshape(-1, 3))  # type: ignore[arg-type]  # one of the two
    return np.asarray(got.astype(np.float64).reshape(points.shape[:-1]))


def test_enclosures_hold_the_shapes() -> None:
    rng = np.random.default_rng(2)
    for name, text in SHAPES.items():
        root = flat(text)
        lo, hi = (c.astype(np.float32).astype(np.float64) for c in boxes(rng, 300))
        low, high = box_test(root, F32)(lo, hi)
        got = values(root, samples(rng, lo, hi, 20).astype(np.float32).astype(np.float64), "f32")
        assert np.all((low <= got) & (got <= high)), name
        assert np.isfinite(low).all(), name


def test_enclosures_hold_random_programs() -> None:
    rng = np.random.default_rng(3)
    for root in random_graphs(150, 21):
        formula = Formula.of(*flatten(root), **MIDDLE).bind(data.bindings())
        lo, hi = boxes(rng, 60, 10.0)
        natural = enclose(formula, [interval(lo[:, i], hi[:, i]) for i in range(3)], F64)[0].range
        low, high = box_test(formula, F64)(lo, hi)
        got = values(formula, samples(rng, lo, hi, 20))
        with np.errstate(invalid="ignore"):
            assert np.all(np.isnan(got) | ((low <= got) & (got <= high)))
            inside = (natural.lo <= got) & (got <= natural.hi)
        assert np.all(inside | (np.isnan(got) & natural.nan))


def test_enclosures_hold_over_the_ranges_of_params() -> None:
    """Over a param's whole range, as contracts are proven: what any setting gives lies inside."""
    rng = np.random.default_rng(4)
    for root in random_graphs(80, 22):
        formula = Formula(flatten(root), {**data.bindings(), **ranges(RANGES)})
        lo, hi = boxes(rng, 30, 10.0)
        r = enclose(formula, [interval(lo[:, i], hi[:, i]) for i in range(3)], F64)[0].range
        for _ in range(4):
            settings = {name: float(rng.uniform(a, b)) for name, (a, b) in RANGES.items()}
            got = values(Formula.of(formula.root, **settings).bind(data.bindings()), samples(rng, lo, hi, 8))
            with np.errstate(invalid="ignore"):
                assert np.all(((r.lo <= got) & (got <= r.hi)) | (np.isnan(got) & r.nan))


def test_the_centred_form_is_tighter_on_small_boxes() -> None:
    """On boxes of a hundredth of a period the centred form's range is a fraction of the natural one's."""
    root = flat("gyroid(20) + schwarz_p(13) / 2 - 1.5 * sin(x / 3) * cos(y / 5)")
    rng = np.random.default_rng(5)
    middle = rng.uniform(-20, 20, (500, 3))
    lo, hi = middle - 0.1, middle + 0.1
    natural = enclose(root, [interval(lo[:, i], hi[:, i]) for i in range(3)], EXACT)[0].range
    low, high = box_test(root, EXACT)(lo, hi)
    undecided = (natural.lo <= 0) & (natural.hi >= 0)
    assert undecided.sum() > 10
    width, own = (high - low)[undecided], (natural.hi - natural.lo)[undecided]
    assert np.median(width / own) < 0.8
    assert np.all(width <= own)


def test_the_centred_form_is_not_used_across_jumps() -> None:
    """A stair has slope 0 almost everywhere; its range over a box that holds a step is that of both sides."""
    for text, at in (("floor(x / 3) - 0.5", 3.0), ("if x < 2 then -1 else 1", 2.0), ("mod(x, 5) - 2.5", 5.0)):
        root = flat(text)
        for half in (1.0, 1e-3, 1e-6):
            low, high = box_test(root, F32)(np.array([[at - half, 0, 0]]), np.array([[at + half, 1, 1]]))
            ends = values(root, np.array([[at - half / 2, 0.5, 0.5], [at + half / 2, 0.5, 0.5]]))
            assert low[0] <= ends.min()
            assert ends.max() <= high[0]
            assert np.isinf(lipschitz(root, np.array([[at - half, 0, 0]]), np.array([[at + half, 1, 1]]))[0])


def test_lipschitz_bounds_hold() -> None:
    rng = np.random.default_rng(6)
    for name, text in SHAPES.items():
        root = flat(text)
        lo, hi = boxes(rng, 150, 25.0, 2.0)
        bound = lipschitz(root, lo, hi)
        a, b = samples(rng, lo, hi, 12), samples(rng, lo, hi, 12)
        apart = np.linalg.norm(a - b, axis=-1)
        change = np.abs(values(root, a) - values(root, b))
        proven = np.isfinite(bound)
        assert np.all(change[:, proven] <= bound[proven] * apart[:, proven] + 1e-9), name
        assert np.isinf(bound).mean() < 0.7, name


@pytest.mark.parametrize(
    ("text", "steepest"),
    [
        ("sphere(10)", 1.0),
        ("box([10, 20, 30])", 1.0),
        ("torus(15, 4)", 1.0),
        ("schwarz_p(tau)", np.sqrt(3)),
        ("3 * x + 4 * y", 5.0),
        ("rotate(cube(9), [1, 1, 0], 30deg)", 1.0),
    ],
)
def test_lipschitz_bounds_are_close(text: str, steepest: float) -> None:
    """On small boxes the bound is near the true slope, never below it, and for most boxes within a fifth above."""
    rng = np.random.default_rng(7)
    middle = rng.uniform(-30, 30, (400, 3))
    bound = lipschitz(flat(text), middle - 0.05, middle + 0.05)
    assert np.median(bound) <= 1.2 * steepest
    assert bound.max() >= 0.8 * steepest


@pytest.mark.parametrize(("text", "corners"), BOXED.items(), ids=list(BOXED))
def test_the_box_of_a_part_is_tight(text: str, corners: tuple[tuple[float, ...], tuple[float, ...]]) -> None:
    box = part_box(flat(text))
    assert box is not None
    size = np.subtract(corners[1], corners[0])
    assert np.all(np.array(box.lo) <= corners[0] + 1e-12 * size)
    assert np.all(np.array(box.hi) >= corners[1] - 1e-12 * size)
    assert np.all(corners[0] - np.array(box.lo) <= 1e-3 * size)
    assert np.all(np.array(box.hi) - corners[1] <= 1e-3 * size)


@pytest.mark.parametrize(("name", "text"), SHAPES.items(), ids=list(SHAPES))
def test_the_box_of_a_part_holds_it(name: str, text: str) -> None:
    rng = np.random.default_rng(8)
    root = flat(text)
    box = part_box(root)
    assert box is not None
    points = rng.uniform(-60, 60, (60_000, 3))
    solid = points[values(root, points) <= 0]
    near = rng.uniform(np.array(box.lo) - 2, np.array(box.hi) + 2, (60_000, 3))
    solid = np.concatenate([solid, near[values(root, near) <= 0]])
    assert len(solid) > 100
    assert np.all((solid >= box.lo) & (solid <= box.hi))
    reach = solid.max(axis=0) - solid.min(axis=0)
    assert np.all(np.array(box.size) <= 1.5 * reach + 1), "a box far too large"


def test_parts_without_end_and_without_material() -> None:
    endless = part_box(flat("gyroid(20)"))
    assert endless is not None
    assert min(endless.hi) >= 1e5
    half = part_box(flat("cylinder(5, 10) | plane([0, 0, 1], -20)"))
    assert half is not None
    assert half.hi[2] == pytest.approx(5, abs=0.01)
    assert half.lo[2] <= -1e5
    assert part_box(flat("sphere(5) & translate(sphere(5), [20, 0, 0])")) is None
    assert part_box(flat("x * x + 1")) is None


def test_slopes_are_the_finite_differences_of_whole_programs() -> None:
    rng = np.random.default_rng(9)
    points = rng.uniform(-20, 20, (500, 3))
    for name, text in SHAPES.items():
        root = flat(text)
        found = slopes(root.root)
        for axis in range(3):
            step = np.eye(3)[axis]

            def difference(h: float, step: Points = step, root: Formula = root) -> Points:
                return np.asarray((values(root, points + h * step) - values(root, points - h * step)) / (2 * h))

            coarse, fine = difference(2e-4), difference(1e-4)
            smooth = np.abs(fine - coarse) < 1e-6  # elsewhere an edge lies between the samples
            got = values(root.with_roots(found[axis]), points)
            assert smooth.sum() > 400, name
            assert np.all(np.abs(got - fine)[smooth] < 1e-5), name


def test_an_enclosure_of_everything_is_everything() -> None:
    """Over boxes without end the range is still sound."""
    far = [interval(np.array([-np.inf]), np.array([np.inf]))] * 3
    for root in (X + Y, X * Y, node("sin_turns", Z), node("div", X, Y), node("hypot", X, Y), node("exp", X)):
        r = enclose(Formula.of(root), far, F64)[0].range
        got = values(Formula.of(root), np.array([[1e300, -1e300, 3.0], [0, 0, 0], [-5, 1e-9, 7]]))
        assert np.all((r.lo <= got) & (got <= r.hi) | (np.isnan(got) & r.nan))


def test_slopes_and_branches_leave_the_tasks_of_a_formula_as_they_are() -> None:
    """A task is bound as the node that it is: sharing the slopes together with its fields made another of it."""
    program = pore.compile(
        "out first = y\nlet rod = hypot(x, y) - 5\n"
        "out part = x * volume(rod & slab([0, 0, 1], 10)) + abs(z) + 0 * exp(rod)"
    )
    formula = program.design().of()
    sloped = formula.with_roots(*slopes(formula.root))
    points = np.array([[3.0, 4.0, 30.0]])
    assert NumpyField(sloped).at(points)[0] == pytest.approx((250 * np.pi, 0, 1), rel=0.01)
    low, high = box_test(formula, EXACT)(points - 0.1, points + 0.1)
    assert np.all(low <= high)
    assert Branches(formula).count > 0
