"""What the rules of `simplify` change: nothing, for numbers, infinities and what is no number, but a zero's sign."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
import pytest

import porelang
from porelang.backends.numpy import NumpyField
from porelang.formula import Formula
from porelang.ir import FALSE, ONE, TRUE, Node, X, Y, Z, const, node, order, param
from porelang.rewrites.simplify import RULES, share, simplify

SPECIAL = (0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 3.0, 1e-3, 30.0, math.inf, -math.inf, math.nan)
#: Fields that are anything, infinite and no number too, as coordinates are not.
A, B, K = node("div", ONE, Y), node("div", ONE, Z), param("k")
with np.errstate(all="ignore"):
    PLACES = np.array([
        [x, 1 / np.float64(a), 1 / np.float64(b)]
        for x, a, b in itertools.product(SPECIAL, repeat=3)
        if math.isfinite(x)
    ])  # fmt: skip
CONSTANTS = [const(v) for v in (0.0, -0.0, 1.0, -1.0, 2.0, 3.0, 4.0, 0.5, math.tau, math.inf, math.nan)]
UNARY = ("neg", "abs", "square", "sqrt", "sin", "cos", "sin_turns", "cos_turns")
BINARY = ("add", "sub", "mul", "div", "pow", "min", "max")
#: What tells one zero from the other, and a number from an infinity.
TELLING = {"div", "pow", "atan2"}


def graphs() -> Iterator[Node]:
    leaves = [A, B, X]
    inner = [node(op, a) for op in UNARY for a in (A, X)]
    inner += [node(op, a, b) for op in BINARY for a, b in [(A, B), (X, A), (A, X), (A, const(2.0)), (const(2.0), X)]]
    yield from inner
    yield from (
        node(op, node("div", n, d)) for op in ("sin", "cos") for n in (X, K * A, X * 2.0) for d in (K, const(3.0))
    )
    yield from (node(op, K * n) for op in ("sin", "cos") for n in (X, A))
    for op in UNARY:
        yield from (node(op, n) for n in inner)
    for op in BINARY:
        for n in [*leaves, *inner]:
            for other in [*CONSTANTS, *leaves, node("neg", n), n, *inner[::5]]:
                yield node(op, n, other)
                yield node(op, other, n)
    c, d = node("lt", A, B), node("le", X, A)
    for truth in (TRUE, FALSE, c, d, node("not", c), node("not", node("not", c)), node("and", c, c), node("or", d, d),
                  node("and", TRUE, d), node("or", d, FALSE), node("and", d, FALSE), node("or", TRUE, c)):  # fmt: skip
        yield node("select", truth, A, X)
        yield node("select", truth, X, X)


def values(root: Node) -> np.ndarray:
    """A graph where its fields have all special values."""
    with np.errstate(all="ignore"):
        return np.broadcast_to(NumpyField(Formula.of(root, k=3.0), "f64", 1).at(PLACES), len(PLACES)).astype(np.float64)


@pytest.mark.slow
def test_no_rule_changes_a_value() -> None:
    for root in graphs():
        (made,) = share(simplify([root]))
        if made is root:
            continue
        before, after = values(root), values(made)
        assert (np.isnan(before) == np.isnan(after)).all(), root
        telling = any(n.op in TELLING for n in order([root]) if n not in (A, B))
        if telling:  # by the sign of a zero: one infinity for the other, and of those no more is known
            assert (np.isinf(before) == np.isinf(after)).all(), root
        else:
            assert (before[np.isinf(before)] == after[np.isinf(before)]).all(), root
        finite = np.isfinite(before) & np.isfinite(after)
        size = np.abs(before[finite])
        assert (np.abs(before[finite] - after[finite]) <= 2.0**-22 + 2.0**-50 * size).all(), root


def test_every_rule_is_tried() -> None:
    tried: set[str] = set()
    rules = [r for r in RULES if not r.name.startswith("fold")]
    for root in graphs():
        for n in order([root]):
            tried |= {f"{r.name} of {r.op}" for r in rules if r.op == n.op and r.apply(n) is not None}
    assert tried == {f"{r.name} of {r.op}" for r in rules}


def test_zero_times_what_overflows_is_not_zero() -> None:
    """In float32 the hypotenuse of 1e24 is infinite."""
    far = X * const(1e3) * const(1e3) * const(1e3) * const(1e3) * const(1e3)
    long = node("hypot", far, far)
    assert simplify([long * const(0.0)])[0] is not const(0.0)
    assert simplify([node("hypot", X, X * const(50.0)) * const(0.0)])[0] is const(0.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1 / (-(x - x))", "infinite"),
        ("1 / (x - x)", "infinite"),
        ("(x - x) / (x - x)", "nan"),
        ("-1 / (0 * x)", "infinite"),
    ],
)
def test_a_quotient_by_zero_is_infinite_of_either_sign(text: str, words: str) -> None:
    found = porelang.compile(text).field()([[1.0, 2.0, 3.0]])
    assert np.isinf(found).all() if words == "infinite" else np.isnan(found).all()
