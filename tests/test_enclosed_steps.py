"""Enclosures of what counts and repeats: at whole multiples, and of remainders; and the numbers that hang on them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import porelang
from porelang.analysis.enclose import EXACT, F32, F64, Precision, boxes, enclose
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import Node, X, const, node


def range_of(root: Node, low: float, high: float, precision: Precision = EXACT) -> tuple[Interval, bool]:
    (found,) = enclose(Formula.of(root), boxes(np.array([[low, 0, 0]]), np.array([[high, 0, 0]])), precision)
    return found.range, bool(np.any(found.jumps))


@pytest.mark.parametrize("precision", [EXACT, F64])
@pytest.mark.parametrize("times", [-7.0, -2.0, 0.0, 3.0, 1e6])
def test_a_whole_multiple_is_one_in_float64(precision: Precision, times: float) -> None:
    r, jumps = range_of(node("mod", X, const(2.0)), 2 * times, 2 * times, precision)
    assert abs(float(r.lo[0])) <= 1e-9 >= abs(float(r.hi[0]))
    assert not jumps
    r, jumps = range_of(node("mod", X, const(2.0)), 2 * times, 2 * times, F32)
    assert float(r.hi[0]) >= 2.0
    assert jumps


def test_remainders_are_within_their_bounds() -> None:
    for precision in (EXACT, F64, F32):
        r, _ = range_of(X - node("floor", X), 2.9, 3.2, precision)
        assert (float(r.lo[0]), float(r.hi[0])) == (0.0, 1.0)
        r, _ = range_of(X - node("round", X), 2.4, 2.7, precision)
        assert (float(r.lo[0]), float(r.hi[0])) == (-0.5, 0.5)
        r, _ = range_of(node("mod", node("floor", X), const(3.0)), 0.0, 50.0, precision)
        assert (float(r.lo[0]), float(r.hi[0])) == (0.0, 2.0)
        r, _ = range_of(node("mod", node("floor", X), const(2.5)), 0.0, 50.0, precision)
        assert float(r.hi[0]) >= 2.0
        r, _ = range_of(X - node("floor", X), 2.2, 2.3, precision)
        assert float(r.hi[0]) < 0.31


#: Slabs of 2 mm: of a box of 8 mm the faces of two and their rims; of a ball its zones, and discs at each face.
DISCS = math.pi * sum(n * (100 - x * x) for x, n in ((8, 2), (6, 2), (4, 2), (2, 2), (0, 1)))


@pytest.mark.parametrize(
    ("call", "exact", "most"),
    [
        ("area(floor(x/2)%2 - 0.5 & box([8, 8, 8]))", 2 * 2 * 64 + 2 * 2 * 4 * 8, 5e-3),
        ("area(floor(x/2)%2 - 0.5 & sphere(10))", 200 * math.pi + DISCS, 5e-3),
        ("volume(floor(x/2)%2 - 0.5 & box([8, 8, 8]))", 256.0, 2e-3),
        ("minimum(fract(x / 3.3), sphere(10))", 0.0, 2e-4),
        ("maximum(floor(x/2) % 2, sphere(10))", 1.0, 1e-3),
        ("maximum(mod(x, 3), sphere(10))", 3.0, 4e-4),
    ],
)
@pytest.mark.slow
def test_steps_have_true_numbers(call: str, exact: float, most: float) -> None:
    (found,) = porelang.compile(f"x + {call}").reduced().values()
    assert abs(found.value - exact) <= found.error <= most * max(abs(exact), 1.0)
