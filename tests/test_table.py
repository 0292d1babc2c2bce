"""The table of operations: every row whole, every form right, every rule sound, on every backend."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang as pore
from porelang.analysis.enclose import F64, enclose
from porelang.backends.glsl import field_function
from porelang.conformance import samples
from porelang.conformance.backend import NUMPY, Backend
from porelang.conformance.exact import EXACT, exact
from porelang.conformance.inputs import STAND_IN, hard
from porelang.conformance.suite import check_samples, hard_places, has_samples
from porelang.conformance.sweep import Measurement
from porelang.elaborate.dimensions import result
from porelang.elaborate.values import Scalar
from porelang.formula import Formula
from porelang.gpu import Gpu
from porelang.interval import Interval, interval
from porelang.ir import ZERO, Node, X, Y, Z, const, node
from porelang.ops import TABLE, Op
from porelang.resources import folder
from porelang.rewrites.gradient import derivatives

Swept = Callable[[str], list[Measurement]]
#: Rows over numbers and conditions, and those that read data: the latter are judged on samples of data.
PLAIN = {name: row for name, row in TABLE.items() if not has_samples(name)}
READING = {name: row for name, row in TABLE.items() if has_samples(name)}
REAL = [row for row in PLAIN.values() if row.result == "real" and "bool" not in row.args]
CONTINUOUS = [row for row in REAL if any(d is not None for d in row.derivative(*(X, Y)[: len(row.args)], ZERO))]
#: Tolerances that are promises of others rather than measurements here: GLSL's division (2.5 ulp, specification 4.7.1),
#: roots made of it, and NumPy's vectorised functions in float32 (exp 2.52, log 3.83, inverse trigonometry below 4 ulp).
PROMISED = {"div", "direction", "sqrt", "hypot", "exp", "log", "asin", "acos", "atan2"}


def values(row: Op, *arguments: Any) -> NDArray[Any]:
    """The NumPy form on float64 arrays."""
    with np.errstate(all="ignore"):
        return np.asarray(row.numpy(*(np.asarray(a) for a in arguments)))


def graph(row: Op) -> Node:
    """The operation on coordinates."""
    inputs = [node("lt", ZERO, c) if k == "bool" else c for k, c in zip(row.args, (X, Y, Z), strict=False)]
    return node(row.name, *inputs)


# ---- every column is filled -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", TABLE.values(), ids=list(TABLE))
def test_row_is_whole(row: Op) -> None:
    assert row.doc.endswith(".")
    assert row.args
    assert row.domain
    assert row.name in EXACT or row.name in READING, "no independent form to compare with"
    assert row.example or not row.symbol, "what can be written is shown"
    assert all(callable(form) for form in (row.numpy, row.enclose, row.derivative))
    assert row.tolerance.ulp >= 0
    assert row.facts <= {"commutative", "odd", "even", "idempotent", "periodic"}
    assert bool(row.guarded) == bool(row.calm)
    slots = {int(i) for i in re.findall(r"\{(\d)\}", row.glsl)}
    assert slots == set(range(len(row.args)))
    assert row.payload == ("{payload}" in row.glsl)
    assert not row.results or (row.payload is False and len(set(row.results)) == len(row.results))
    for name in re.findall(r"pore_\w+", row.glsl + row.guarded):
        assert (folder("shaders") / "lib" / f"{name}.glsl").is_file()


@pytest.mark.parametrize("row", TABLE.values(), ids=list(TABLE))
def test_units_rule_is_known(row: Op) -> None:
    if row.result != "bool" and "bool" not in row.args:
        result(row.units, [Scalar(X)] * len(row.args), 2.0)


@pytest.mark.parametrize("row", [r for r in TABLE.values() if r.example], ids=lambda r: r.name)
def test_example(row: Op, backend: Backend) -> None:
    assert row.example is not None
    text, wanted = row.example
    program = pore.compile(f"out part = {text}")
    (root,) = program.roots("part")
    got = backend.evaluate(Formula.of(root), np.zeros((3, 3)), {})
    assert np.allclose(got.astype(np.float64), float(wanted), rtol=2 * backend.precision.eps, atol=0)
    # the same with a field in it, so that the backend computes it and not the compiler
    varied = re.sub(r"(?<![\w.])\d+(\.\d+)?", lambda number: f"({number[0]} + x - x)", text)
    program = pore.compile(f"out part = {varied}")
    got = backend.evaluate(Formula.of(*program.roots("part")), np.ones((3, 3)), {})
    assert np.allclose(got.astype(np.float64), float(wanted), rtol=4 * backend.precision.eps, atol=1e-6)


# ---- every form against exact values --------------------------------------------------------------------------------


def test_sweep(backend: Backend, swept: Swept, capsys: pytest.CaptureFixture[str]) -> None:
    found = swept(backend.name)
    with capsys.disabled():
        print(f"\n{backend.name}: worst error (epsilons) and use of the tolerance")
        for m in found:
            print(f"  {m.op:<10} {m.form:<8} {m.points:>7} inputs {m.ulp:>9.3g} {100 * m.use:>6.1f} %")
    assert [m.example for m in found if m.broken] == []
    assert {m.op for m in found} == set(PLAIN)
    for name, row in PLAIN.items():
        assert bool(row.guarded) == any(m.op == name and m.form == "guarded" for m in found)


def test_tolerances_are_close(gpu: Gpu, swept: Swept) -> None:
    """A tolerance is within about twice the worst error measured on any backend, or a promise of others."""
    found = [m for name in (*(b.name for b in NUMPY), "glsl") for m in swept(name)]
    loose = {}
    for name, row in PLAIN.items():
        t = row.tolerance
        use = max(m.use for m in found if m.op == name)
        if (t.ulp or t.absolute or t.extra) and name not in PROMISED and use < 0.4:
            loose[name] = use
    assert loose == {}


def test_guarded_forms_are_those_swept() -> None:
    for name, arguments in {
        "min": (X, Y),
        "max": (X, Y),
        "sqrt": (node("abs", X),),
        "div": (X, node("max", node("abs", Y), const(2.0**-60))),
    }.items():
        text = field_function((node(name, *arguments),), {}, {}, {})
        assert f"pore_{name}" not in text
        opened = [node("div", a, Z) for a in arguments]
        text = field_function((node(name, *opened),), {}, {}, {})
        assert f"pore_{name}" in text


def test_exact_forms_agree_with_known_values() -> None:
    """The comparison's own forms, at arguments with known answers."""
    one = np.array([1.0])
    assert exact("mod", -one, 3 * one) == 2
    assert exact("mod", one, -3 * one) == -2
    assert exact("round", np.array([2.5])) == 2
    assert exact("round", np.array([-3.5])) == -4
    assert exact("round", np.array([0.49999999999999994])) == 0
    assert exact("sin_turns", np.array([1e9 + 0.25])) == 1
    assert exact("cos_turns", np.array([0.5])) == -1
    assert np.isnan(exact("min", one, np.array([np.nan])))
    assert exact("direction", one, 0 * one) == 0
    assert exact("pow", np.array([-np.inf]), np.array([-(2.0**63)])) == 0
    assert exact("sin", np.array([np.pi], np.longdouble)) == pytest.approx(1.2246467991473532e-16, rel=1e-3)


# ---- enclosures -----------------------------------------------------------------------------------------------------


def random_boxes(rng: np.random.Generator, count: int) -> list[Interval]:
    """Boxes for three arguments: of all sizes, degenerate, infinite, touching and straddling 0."""
    special = hard(np.float64)
    special = special[~np.isin(special, list(STAND_IN))]
    out = []
    for _ in range(3):
        size = 10.0 ** rng.uniform(-6, 3, count)
        lo = rng.uniform(-10, 10, count)
        hi = lo + size
        kind = rng.integers(0, 8, count)
        lo, hi = np.where(kind == 0, hi, lo), hi  # a single value
        lo = np.where(kind == 1, 0.0, lo)
        hi = np.where((kind == 1) | (kind == 2), np.maximum(np.abs(hi), lo), hi)
        lo, hi = np.where(kind == 3, -np.abs(lo), lo), np.where(kind == 3, 0.0, hi)
        lo, hi = np.where(kind == 4, -np.inf, lo), np.where(kind == 5, np.inf, hi)
        picked = np.sort(rng.choice(special, (2, count)), axis=0)
        lo, hi = np.where(kind == 6, picked[0], lo), np.where(kind == 6, picked[1], hi)
        whole = np.rint(lo)
        lo, hi = np.where(kind == 7, whole, lo), np.where(kind == 7, whole, hi)
        out.append(interval(np.minimum(lo, hi), np.maximum(lo, hi)))
    return out


def sample(rng: np.random.Generator, box: Interval, each: int) -> NDArray[np.float64]:
    """Values of each range (each, n): its ends, 0 of either sign where that lies in it, and what lies between."""
    n = len(box.lo)
    lo, hi = np.clip(box.lo, -1e300, 1e300), np.clip(box.hi, -1e300, 1e300)
    t = rng.random((each, n))
    linear = lo + (hi - lo) * t
    small = np.copysign(10.0 ** rng.uniform(-12, 6, (each, n)), linear)
    between = np.where(rng.random((each, n)) < 0.3, np.clip(small, lo, hi), np.clip(linear, lo, hi))
    between = np.clip(between, box.lo, box.hi)
    between[0], between[1] = box.lo, box.hi
    zero = box.contains(0.0)
    between[2] = np.where(zero, 0.0, between[2])
    between[3] = np.where(zero, -0.0, between[3])
    return between


@pytest.mark.parametrize("row", PLAIN.values(), ids=list(PLAIN))
def test_enclosure_holds_values(row: Op) -> None:
    rng = np.random.default_rng(11)
    boxes = random_boxes(rng, 3000)
    if row.name == "direction":  # its divisor is at least as long as its argument
        boxes[1] = interval(np.maximum(np.abs(boxes[0].lo), np.abs(boxes[0].hi)), np.full(3000, np.inf))
    found = enclose(Formula.of(graph(row)), boxes, F64)[0].range
    columns = [sample(rng, b, 24) for b in boxes]
    arguments = [c > 0 if k == "bool" else c for k, c in zip(row.args, columns, strict=False)]
    got = values(row, *arguments).astype(np.float64)
    with np.errstate(invalid="ignore"):
        inside = (got >= found.lo) & (got <= found.hi)
    bad = np.where(np.isnan(got), ~np.broadcast_to(found.nan, got.shape), ~inside)
    where = np.argwhere(bad)
    text = ""
    if len(where):
        k, i = where[0]
        text = f"{row.name}{tuple(a[k, i] for a in arguments)} = {got[k, i]}, not in {found.lo[i]}..{found.hi[i]}"
    assert not bad.any(), text


@pytest.mark.parametrize("row", PLAIN.values(), ids=list(PLAIN))
def test_enclosure_of_nan_is_nan(row: Op) -> None:
    """An argument that is certainly NaN gives what the operation gives for NaN, and nothing that it cannot give."""
    if "bool" in row.args:
        return
    nan = Interval(np.array([np.inf]), np.array([-np.inf]), np.array([True]))
    one, none = interval(np.array([2.0])), np.array([np.nan])
    for i in range(len(row.args)):
        ranges = [nan if j == i else one for j in range(len(row.args))]
        got = values(row, *(none if j == i else np.array([2.0]) for j in range(len(row.args))))
        with np.errstate(all="ignore"):
            r = row.enclose(*ranges)
        if row.result == "bool":
            assert r.lo <= float(got[0]) <= r.hi
        else:
            assert r.nan[0]
            assert np.isnan(got[0])


@pytest.mark.parametrize("row", REAL, ids=[r.name for r in REAL])
def test_enclosure_of_a_small_box_is_small(row: Op) -> None:
    """Sound is not enough: around an ordinary point the range shrinks with the box."""
    at = np.array([0.37, 0.61, -0.23])[: 3 if row.name not in ("sqrt", "log") else 2]
    other = np.full(len(at), 1.7)
    for size in (1e-3, 1e-6):
        ranges = [interval(a - size, a + size) for a in (at, other)[: len(row.args)]]
        if row.name == "pow":
            ranges[1] = interval(np.full(len(at), 2.0))
        r = row.enclose(*ranges)
        assert np.all(r.hi - r.lo <= 40 * size)


# ---- derivatives ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", CONTINUOUS, ids=[r.name for r in CONTINUOUS])
def test_derivative_is_the_central_difference(row: Op) -> None:
    """Richardson's difference of two steps, with the difference of both as its error estimate."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.95, 0.95, (400, 2)) if row.name in ("asin", "acos") else rng.uniform(-4, 4, (400, 2))
    if row.name in ("sqrt", "log", "pow"):
        points[:, 0] = np.abs(points[:, 0]) + 0.1
    if row.name == "direction":
        points[:, 1] = np.abs(points).sum(axis=1) + 0.1
    slopes = derivatives(graph(row))
    compared = 0
    for axis in range(len(row.args)):
        got = NUMPY[0].evaluate(Formula.of(slopes[axis]), np.column_stack([points, np.zeros(400)]), {})

        def difference(h: float, axis: int = axis) -> NDArray[np.float64]:
            step = np.eye(2)[axis] * h
            up, down = points + step, points - step
            n = len(row.args)
            return np.asarray((values(row, *up.T[:n]) - values(row, *down.T[:n])) / (2 * h))

        coarse, fine = difference(2e-4), difference(1e-4)
        best = fine + (fine - coarse) / 3
        size = np.abs(values(row, *points.T[: len(row.args)])) + np.abs(best) + 1
        estimate = np.abs(fine - coarse) + 4 * F64.eps * size / 1e-4
        smooth = estimate < 1e-5 * size  # elsewhere a kink lies between the samples
        if row.jumps is not None:
            boxes = [interval(v - 3e-4, v + 3e-4) for v in points.T[: len(row.args)]]
            smooth &= ~row.jumps(*boxes)
        assert np.all(np.abs(got - best)[smooth] <= 2 * estimate[smooth]), row.name
        compared += int(smooth.sum())
    assert compared >= 300 * len(row.args)


@pytest.mark.parametrize(
    ("name", "at", "axis", "slope"),
    [
        ("sqrt", (0.0, 0.0), 0, 0.0),
        ("hypot", (0.0, 0.0), 0, 0.0),
        ("hypot", (0.0, 0.0), 1, 0.0),
        ("direction", (0.0, 0.0), 0, 0.0),
        ("direction", (0.0, 0.0), 1, 0.0),
        ("atan2", (0.0, 0.0), 0, 0.0),
        ("atan2", (0.0, 0.0), 1, 0.0),
        ("abs", (0.0, 0.0), 0, 0.0),
        ("min", (2.0, 2.0), 0, 1.0),
        ("min", (2.0, 2.0), 1, 0.0),
        ("max", (2.0, 2.0), 0, 1.0),
        ("max", (2.0, 2.0), 1, 0.0),
        ("floor", (2.0, 0.0), 0, 0.0),
        ("sign", (0.0, 0.0), 0, 0.0),
    ],
)
def test_derivative_where_there_is_none(
    name: str, at: tuple[float, float], axis: int, slope: float, backend: Backend
) -> None:
    root = derivatives(graph(TABLE[name]))[axis]
    assert backend.evaluate(Formula.of(root), np.array([[*at, 0.0]]), {})[0] == slope


# ---- facts and jumps ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", [r for r in TABLE.values() if r.facts], ids=lambda r: r.name)
def test_facts_hold(row: Op) -> None:
    rng = np.random.default_rng(3)
    special = hard(np.float64)
    a = np.concatenate([special, rng.uniform(-10, 10, 2000)])
    b = np.concatenate([rng.permutation(special), rng.uniform(-10, 10, 2000)])
    if row.args[0] == "bool":
        a, b = a > 0, b > 0
    same = {"equal_nan": a.dtype != np.bool_}
    if "commutative" in row.facts:
        assert np.array_equal(values(row, a, b), values(row, b, a), **same)
    if "idempotent" in row.facts:
        assert np.array_equal(values(row, a, a), a, **same)
    if "odd" in row.facts:
        assert np.array_equal(values(row, -a), -values(row, a), **same)
    if "even" in row.facts:
        assert np.array_equal(values(row, -a), values(row, a), **same)
    if "periodic" in row.facts:  # in turns; whole numbers are added exactly
        u = rng.integers(-(2**20), 2**20, 1000) / 2.0**12
        assert np.array_equal(values(row, u + 7), values(row, u))


@pytest.mark.parametrize("row", REAL, ids=[r.name for r in REAL])
def test_jumps_are_flagged(row: Op) -> None:
    """Bisection of segments down to neighbouring numbers: where two of them still differ there is a jump."""
    rng = np.random.default_rng(17)
    count = 4000
    centre = rng.choice([0.0, 0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, 3.0, 6.0], (2, count))
    half = 10.0 ** rng.uniform(-3, 0.5, (2, count))
    a, b = centre - half * rng.random((2, count)), centre + half * rng.random((2, count))
    fixed = rng.random(count) < 0.5
    a[1] = np.where(fixed, b[1], a[1])
    if row.name == "direction":
        reach = np.maximum(np.abs(a[0]), np.abs(b[0]))
        a[1], b[1] = np.abs(a[1]) + reach * rng.choice([0.0, 1.0], count), np.abs(b[1]) + reach
        a[1] = np.maximum(a[1], np.abs(a[0]))
    n = len(row.args)
    ranges = [interval(np.minimum(a[i], b[i]), np.maximum(a[i], b[i])) for i in range(n)]
    flagged = np.zeros(count, np.bool_) if row.jumps is None else np.broadcast_to(row.jumps(*ranges), count)
    left, right = a.copy(), b.copy()
    usable = np.isfinite(values(row, *left[:n])) & np.isfinite(values(row, *right[:n]))
    for _ in range(1100):
        middle = left + (right - left) / 2
        low, mid, high = (values(row, *v[:n]) for v in (left, middle, right))
        usable &= np.isfinite(mid)
        with np.errstate(all="ignore"):
            nearer = np.abs(mid - low) >= np.abs(high - mid)
        right, left = np.where(nearer, middle, right), np.where(nearer, left, middle)
        if np.all(np.abs(right - left) <= 2 * np.spacing(np.abs(right) + np.abs(left))):
            break
    with np.errstate(invalid="ignore"):
        leap = np.abs(values(row, *right[:n]) - values(row, *left[:n]))
        size = 1 + np.abs(values(row, *left[:n]))
    jumped = usable & (leap > 1e-5 * size)
    assert not (jumped & ~flagged).any(), [v[:, np.argmax(jumped & ~flagged)] for v in (left, right)]
    if row.name in ("floor", "round", "sign", "mod", "atan2"):
        assert jumped.sum() > 100, "the search finds jumps where there are some"


@pytest.mark.parametrize("row", [r for r in PLAIN.values() if r.jumps], ids=lambda r: r.name)
def test_not_everything_is_a_jump(row: Op) -> None:
    """A box well inside a smooth stretch is not flagged."""
    if "bool" in row.args:
        yes = Interval(np.array([1.0]), np.array([1.0]), np.array([False]))
        assert not np.any(row.jumps(yes, *(interval(np.array([0.1])),) * 2))  # type: ignore[misc]  # it has jumps
        return
    ranges = [interval(np.array([0.31]), np.array([0.32])), interval(np.array([1.2]), np.array([1.2]))]
    assert not np.any(row.jumps(*ranges[: len(row.args)]))  # type: ignore[misc]


def test_pi_is_the_wide_types_own() -> None:
    assert float(exact("acos", np.array([-1.0], np.longdouble))[0]) == math.pi


# ---- operations that read data --------------------------------------------------------------------------------------


def asked(row: Op) -> list[Node]:
    """All that an operation on the samples can be asked: results, or components and their derivatives."""
    payloads: list[Any] = list(row.results) or [None]
    if row.payload:
        orders = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        payloads = [(c, *o) for c in range(samples.grid().components) for o in orders]
    return [node(row.name, *samples.arguments(row), value=p) for p in payloads]


@pytest.mark.parametrize("row", READING.values(), ids=list(READING))
def test_what_has_samples_keeps_the_law(row: Op, backend: Backend) -> None:
    found = check_samples(row.name, backend, seed=7)
    assert len(found) >= len(asked(row))
    assert not [f.failure.example for f in found if f.failure]
    assert sum(f.sharp for f in found) > 0.5 * sum(f.points for f in found), "a bound that says something"


@pytest.mark.parametrize("row", READING.values(), ids=list(READING))
def test_enclosure_of_data_holds_values(row: Op) -> None:
    rng = np.random.default_rng(12)
    count, each = 400, 30
    size = 10.0 ** rng.uniform(-5, 2, (count, 1)) * rng.uniform(0, 1, (count, 3))
    middle = rng.choice(hard_places()[:-3], count) + rng.uniform(-1, 1, (count, 3)) * (rng.random((count, 1)) < 0.7)
    lo, hi = middle - size / 2, middle + size / 2
    points = np.clip(lo + (hi - lo) * np.rint(rng.random((each, count, 3)) * 4) / 4, lo, hi)
    formula = Formula(tuple(asked(row)), samples.bindings())
    boxes = [interval(lo[:, i], hi[:, i]) for i in range(3)]
    for root, known in zip(formula.roots, enclose(formula, boxes, F64), strict=True):
        got = NUMPY[0].evaluate(formula.with_roots(root), points.reshape(-1, 3), {}).reshape(each, count)
        r = known.range
        bad = ~((got >= r.lo) & (got <= r.hi))
        k, i = np.argwhere(bad)[0] if bad.any() else (0, 0)
        assert not bad.any(), f"{root} at {points[k, i]} is {got[k, i]}, not in {r.lo[i]}..{r.hi[i]}"
        at_point = [interval(middle[:, i]) for i in range(3)]
        tight = enclose(formula.with_roots(root), at_point, F64)[0]
        still = ~np.broadcast_to(tight.jumps, count)
        if row.result == "real" and still.any():
            width = (tight.range.hi - tight.range.lo)[still]
            assert np.median(width) < 1e-3, f"{root}: the range of a point is one"


@pytest.mark.parametrize("row", READING.values(), ids=list(READING))
def test_derivative_of_data_is_the_central_difference(row: Op) -> None:
    rng = np.random.default_rng(13)
    points = rng.uniform(-12, 20, (2000, 3)) if row.args[0] == "grid" else rng.uniform(-30, 30, (2000, 3))
    root = asked(row)[0]  # a component itself, or the distance
    if row.result == "bool":
        assert derivatives(root) == (ZERO, ZERO, ZERO)
        return

    def value(n: Node, at: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(NUMPY[0].evaluate(Formula((n,), samples.bindings()), at, {}))

    for axis, slope in enumerate(derivatives(root)):
        step = np.eye(3)[axis]

        def difference(h: float, step: NDArray[np.float64] = step) -> NDArray[np.float64]:
            return (value(root, points + h * step) - value(root, points - h * step)) / (2 * h)

        coarse, fine = difference(2e-4), difference(1e-4)
        smooth = np.abs(fine - coarse) < 1e-6 * (1 + np.abs(fine))  # elsewhere a kink lies between the samples
        assert smooth.mean() > 0.9
        assert np.all(np.abs(value(slope, points) - fine)[smooth] < 1e-5 * (1 + np.abs(fine[smooth])))


def test_data_that_is_not_bound_can_be_anything() -> None:
    """A shader is made before data are read: what its cheaper forms rest on holds for all data."""
    roots = tuple(n for row in READING.values() for n in asked(row) if row.args[0] != "real")
    formula = Formula(roots, {samples.GRID: None, samples.BARS: None})
    box = [interval(np.array([-9.0, 1.0]), np.array([9.0, 1.0]))] * 3
    for root, known in zip(roots, enclose(formula, box), strict=True):
        bound = formula.with_roots(root).bind(samples.bindings())
        got = NUMPY[0].evaluate(bound, np.ones((1, 3)), {})
        assert np.all((known.range.lo <= got) & (got <= known.range.hi))
        assert np.all(known.jumps)
    # a place that may be no place, whichever coordinate it is: at infinity a bar has no direction
    ordinary, wild = interval(np.array([1.0])), interval(np.array([1.0]), np.array([np.inf]))
    lost = Interval(wild.lo, ordinary.hi, np.array([True]))
    for axis in range(3):
        for place in (wild, lost):
            box = [place if i == axis else ordinary for i in range(3)]
            for root, known in zip(roots, enclose(formula, box), strict=True):
                real = enclose(formula.with_roots(root).bind(samples.bindings()), box)[0].range
                assert np.all(known.range.nan | ~real.nan), f"{root} may be no number"
                assert np.all((known.range.lo <= real.lo) & (known.range.hi >= real.hi)), root
