"""Linear forms hold what a field is over boxes, and what they forget of it falls with the square of the box."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.analysis.enclose import boxes, enclose
from porelang.analysis.linear import has_rules, linear
from porelang.backends.numpy import NumpyField
from porelang.conformance.generate import RANGES
from porelang.conformance.suite import random_graphs
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.ir import ONE, Node, X, Y, Z, node, param
from porelang.rewrites import flatten

Points = NDArray[np.float64]
MIDDLE = {param(name): (lo + hi) / 2 for name, (lo, hi) in RANGES.items()}


def formula(n: Node) -> Formula:
    return Formula(flatten(n), MIDDLE)


def some_boxes(seed: int, count: int, reach: float, largest: float) -> tuple[Points, Points]:
    """Boxes of all sizes, also flat ones and lines."""
    random = np.random.default_rng(seed)
    low = random.uniform(-reach, reach, (count, 3))
    size = (
        largest
        * 10 ** random.uniform(-4, 0, (count, 1))
        * random.choice([0.0, 0.3, 1.0], (count, 3), p=[0.2, 0.4, 0.4])
    )
    return low, low + size


def outside(f: Formula, low: Points, high: Points, seed: int, tries: int = 30) -> int:
    """How many samples, also at corners, lie outside the range that is proven."""
    random = np.random.default_rng(seed)
    (found,) = linear(f, boxes(low, high))
    field, wrong = NumpyField(f, "f64", 1), 0
    for k in range(tries):
        share = random.random(low.shape) if k % 2 else random.integers(0, 2, low.shape)
        with np.errstate(all="ignore"):
            value = field.at(low + share * (high - low))
        slack = 1e-12 * (1 + np.abs(value))  # of the sample's own rounding, and of its place
        inside = (value >= found.range.lo - slack) & (value <= found.range.hi + slack)
        wrong += int(np.count_nonzero(~inside & ~(np.isnan(value) & found.range.nan)))
    return wrong


RULES = {
    "neg": -(X * Y),
    "add": X * Y + Z,
    "sub": X * Y - X,
    "mul": (X + Y) * (Z - X),
    "square": node("square", X - Y),
    "div": (X + Y) / (Z * Z + 1.0),
    "div by what may be 0": X / (Y + 0.3),
    "sqrt": node("sqrt", X * X + Y + 4.0),
    "hypot": node("hypot", X - 1.0, Y * Z),
    "direction": node("direction", X, node("hypot", X, Y)),
    "abs": node("abs", X * Y - 1.0),
    "min": node("min", X * Y, Y + Z),
    "max": node("max", node("square", X), Y * Z),
    "clamp": node("min", node("max", X * Y, -X * Y), X * Y + 0.5),
    "sin": node("sin", 3.0 * X + Y),
    "cos": node("cos", X * Y),
    "sin_turns": node("sin_turns", X + 0.3 * Y),
    "cos_turns": node("cos_turns", X * Z),
    "exp": node("exp", X - Y),
    "log": node("log", X * X + 0.5),
    "atan2": node("atan2", Y, X),
    "select": node("select", node("lt", X, Y), X * Y, Z - 1.0),
    "floor": X * Y - node("floor", X),
}


@pytest.mark.parametrize("name", RULES)
def test_each_rule_holds(name: str) -> None:
    f = formula(RULES[name])
    assert has_rules(f.tape)
    assert outside(f, *some_boxes(3, 4000, 2.5, 2.0), seed=4) == 0


@pytest.mark.parametrize("name", [n for n in RULES if n not in ("floor", "div by what may be 0", "atan2", "select")])
def test_what_each_rule_forgets_falls_with_the_square(name: str) -> None:
    """Beyond the spread that the slope at the middle makes; where a kink lies in the box nothing is claimed."""
    f = formula(RULES[name])
    low = np.random.default_rng(5).uniform(0.5, 2.0, (500, 3))
    for size in (1e-2, 1e-3):
        (found,) = linear(f, boxes(low, low + size))
        field, middle, step = NumpyField(f, "f64", 1), low + size / 2, 1e-5
        slope = [(field.at(middle + step * e) - field.at(middle - step * e)) / (2 * step) for e in np.eye(3)]
        spread = size * np.abs(slope).sum(axis=0)
        assert np.median(found.range.hi - found.range.lo - spread) < 150 * size**2 + 1e-9


def smooth(payload: tuple[int, int, int, int], size: int = 12) -> Formula:
    """A lookup of smooth samples where they are looked for by what is bent, also beyond them."""
    i, j, k = np.meshgrid(*(np.arange(size) * 5.0 / (size - 1) - 2.5,) * 3, indexing="ij")
    samples = SampledField.from_array(np.sin(i + 0.3 * j) * np.cos(k), (-2.5,) * 3, 5.0 / (size - 1))
    grid = node("sample", X, ONE, Y)
    return Formula((node("lookup_cubic", grid, X + 0.1 * (Y * Z), Y, Z - X, value=payload),), {grid: samples})


@pytest.mark.parametrize("orders", [(0, 0, 0), (1, 0, 0), (0, 1, 1), (0, 0, 2), (0, 3, 0)])
def test_the_rule_of_a_smooth_lookup_holds(orders: tuple[int, int, int]) -> None:
    f = smooth((0, *orders))
    assert has_rules(f.tape)
    assert outside(f, *some_boxes(8, 3000, 4.0, 3.0), seed=9) == 0


@pytest.mark.parametrize("orders", [(0, 0, 0), (1, 0, 0), (0, 1, 1)])
def test_what_a_smooth_lookup_forgets_falls_with_the_square(orders: tuple[int, int, int]) -> None:
    f = smooth((0, *orders))
    low = np.random.default_rng(5).uniform(-1, 1, (500, 3))
    for size in (1e-2, 1e-3):
        (found,) = linear(f, boxes(low, low + size))
        field, middle, step = NumpyField(f, "f64", 1), low + size / 2, 1e-5
        slope = [(field.at(middle + step * e) - field.at(middle - step * e)) / (2 * step) for e in np.eye(3)]
        spread = size * np.abs(slope).sum(axis=0)
        assert np.median(found.range.hi - found.range.lo - spread) < 50 * size**2 + 1e-9


@pytest.mark.parametrize("seed", range(60))
def test_linear_forms_hold_random_programs(seed: int) -> None:
    for f in map(formula, random_graphs(3, seed)):
        if any(f.tape.nodes[i] not in f.bindings for i in f.tape.slots):  # data have no rules
            continue
        (found,) = linear(f, boxes(*some_boxes(seed, 10, 40.0, 20.0)))  # whatever has no rule is known by its range
        assert found.range.lo.shape in ((), (10,))
        assert outside(f, *some_boxes(seed, 200, 40.0, 20.0), seed=seed, tries=10) == 0


@pytest.mark.parametrize(
    "text",
    [
        "metric(gyroid(10)) |> shell(1mm) & cylinder(20, 30)",
        "metric(iwp(10), 3)",
        "gyroid(10) |> twist(90deg / 50mm) |> shell(0.4)",
        "polar(gyroid(10), turn=100) & cylinder(20, 20)",
        "ring(translate(sphere(3), [12, 0, 0]), 6)",
        "smooth_union([sphere(8), translate(box([8, 8, 8]), [7, 0, 0])], 3)",
    ],
)
def test_linear_forms_hold_programs(text: str) -> None:
    f = porelang.compile(text).design().of("part")
    assert has_rules(f.tape)
    assert outside(f, *some_boxes(6, 2000, 15.0, 3.0), seed=7) == 0


def test_a_true_distance_is_enclosed_as_tightly_as_it_rises() -> None:
    """Over a box of size h a distance changes by sqrt(3) h at most; ranges alone allow 12 h."""
    f = porelang.compile("metric(gyroid(10))").design().of("part")
    d = porelang.compile("metric(gyroid(10))").field()
    low = np.random.default_rng(8).uniform(-10, 10, (4000, 3))
    low = low[np.abs(d(low)) < 1]
    place = boxes(low, low + 0.01)
    natural, close = (e[0].range for e in (enclose(f, place), linear(f, place)))
    assert np.median(natural.hi - natural.lo) > 0.1
    assert np.quantile(close.hi - close.lo, 0.9) < 0.025
