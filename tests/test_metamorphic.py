"""Two ways to say the same: equal as nodes, bit by bit, or both within the law's bound of the same value."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang as pore
from porelang.analysis.enclose import F64
from porelang.backends.error import allowed
from porelang.backends.numpy import NumpyField
from porelang.conformance import samples
from porelang.conformance.backend import NUMPY, Backend
from porelang.conformance.generate import RANGES
from porelang.conformance.law import places
from porelang.conformance.suite import random_graphs
from porelang.formula import Formula
from porelang.gpu import Gpu
from porelang.gpu.fields import DeviceField, gpu
from porelang.ir import ZERO, Node, X, Y, Z, const, node
from porelang.ops import TABLE
from porelang.rewrites import PIPELINE, Graph, flatten, run

POINTS = places(400, 5)


def flat(text: str) -> Node:
    """The only root of a program."""
    return pore.compile(text).roots("part")[0]


def agree(one: Node, other: Node, backend: Backend, params: dict[str, float] | None = None, slack: float = 0.0) -> None:
    """Both graphs' values lie within the bounds of both, at every point: one answers for the other."""
    params = params or {}
    ranges = {name: (value, value) for name, value in params.items()}

    def bind(root: Node) -> Formula:
        return Formula.of(root, **params).bind(samples.bindings())

    for left, right in ((one, other), (other, one)):
        bound, own = (allowed(bind(root), POINTS, backend.precision) for root in (left, right))
        got = backend.evaluate(bind(right), POINTS, ranges).astype(np.float64)
        with np.errstate(invalid="ignore"):
            room = (own.hi - own.lo) + slack
            inside = (got >= bound.lo - room) & (got <= bound.hi + room)
        assert np.all(inside | (np.isnan(got) & bound.nan))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("~~gyroid(20)", "gyroid(20)"),
        ("-(-x)", "x"),
        ("sphere(5) & gyroid(7)", "gyroid(7) & sphere(5)"),
        ("sphere(5) | gyroid(7)", "gyroid(7) | sphere(5)"),
        ("x & x", "x"),
        ("x + y * 2", "2 * y + x"),
        ("gyroid(20) @ p", "gyroid(20)"),
        ("gyroid(20) @ [y, z, x] @ [z, x, y]", "gyroid(20)"),
        ("(x * y) @ [y, x, z]", "x * y"),
        ("x - (y - x)", "x - (y - x) + 0"),
        ("not not (x < 1) and x < 1", "x < 1"),
        ("if x < 1 then y else y", "y"),
        ("abs(-x)", "abs(x)"),
        ("abs(abs(x))", "abs(x)"),
        ("cos(-x)", "cos(x)"),
        ("sin(-x)", "-sin(x)"),
        ("x * 1 + 0 - 0", "x"),
        ("x ^ 2", "square(x)"),
        ("sqrt(square(x))", "abs(x)"),
        ("max(max(x, y), x)", "max(y, x)"),
        ("translate(sphere(5), [0, 0, 0])", "sphere(5)"),
        ("gyroid(w=20)", "gyroid(phase=p / 20)"),
        ("gyroid(2cm)", "gyroid(20mm)"),
        ("x \\ y", "x & ~y"),
        ("{ let a = x; a * a }", "x * x"),
        ("[x, y, z].y", "y"),
        ("sphere(5) |> offset(2)", "offset(sphere(5), 2)"),
        ("sum([for i in range(3): x])", "x + x + x"),
        ("(t => t + 1)(x)", "x + 1"),
        ("thicken(gyroid(20), 0.5, 1)", "gyroid(20) + 0.5"),
    ],
)
def test_the_same_node(one: str, other: str) -> None:
    program = pore.compile(f"out one = {one}\nout other = {other}")
    assert program.roots("one")[0] is program.roots("other")[0]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("gyroid(20) |> translate([3, 4, 5]) |> translate([-3, -4, -5])", "gyroid(20)"),
        ("gyroid(20) |> rotate([1, 2, 3], 40deg) |> rotate([1, 2, 3], -40deg)", "gyroid(20)"),
        ("gyroid(20) |> twist(0.03) |> twist(-0.03)", "gyroid(20)"),
        ("sphere(5) |> scale(3) |> scale(1 / 3)", "sphere(5)"),
        ("twist(gyroid(20), 0)", "gyroid(20)"),
        ("gyroid(20) |> translate([20, -40, 60])", "gyroid(20)"),
        ("diamond([8, 16, 32]) |> translate([8, 16, 32])", "diamond([8, 16, 32])"),
        ("repeat(sphere(3), 10) |> translate([10, 0, -20])", "repeat(sphere(3), 10)"),
        ("ring(translate(sphere(3), [12, 0, 0]), 6) |> rotate([0, 0, 1], 60deg)",
         "ring(translate(sphere(3), [12, 0, 0]), 6)"),
        ("mirror(gyroid(20), [1, 2, 2]) |> mirror([1, 2, 2])", "gyroid(20)"),
        ("rotate(sphere(9), [3, 1, 2], 77deg)", "sphere(9)"),
        ("schwarz_p(tau)", "cos(x) + cos(y) + cos(z)"),
        ("gyroid(tau)", "sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)"),
        ("(x + y) * (x - y)", "x ^ 2 - y ^ 2"),
        ("sin(x) ^ 2 + cos(x) ^ 2 + 0 * y", "1 + 0 * x"),
        ("exp(log(abs(x) + 1))", "abs(x) + 1"),
        ("(abs(x) + 1) ^ 2.5", "exp(2.5 * log(abs(x) + 1))"),
        ("atan2(sin(y), cos(y)) - y + floor(y / tau + 0.5) * tau", "0 * y"),
        ("smooth_union(x, y, 4)", "-smooth_intersection(-x, -y, 4)"),
        ("grad(sphere(5)).x * length(p)", "x"),
    ],
)  # fmt: skip
def test_the_same_value(one: str, other: str, backend: Backend) -> None:
    # transforms there and back pass other places on their way, whose rounding shows within the slack
    agree(flat(one), flat(other), backend, slack=1e-4 if backend.precision is not F64 else 1e-12)


def test_a_param_is_the_number_it_is_set_to(backend: Backend) -> None:
    text = "gyroid({w}) |> thicken(sphere(40) / 100, {t}) & cylinder({w} + 10, 40) |> translate([{t}, 0, 0])"
    open_ = pore.compile("param w = 30 in 10..60\nparam t = 0.3 in 0..1\n" + text.format(w="w", t="t"))
    for w, t in ((30.0, 0.3), (12.5, 0.0), (60.0, 1.0)):
        closed = flat(text.format(w=w, t=t))
        params = {"w": w, "t": t}
        agree(open_.roots("part")[0], closed, backend, params, slack=1e-4 if backend.precision is not F64 else 1e-12)


def test_a_param_never_changes_the_shader(gpu: Gpu) -> None:
    program = pore.compile("param w = 30 in 10..60\ngyroid(w) & sphere(2 * w)")
    program.field("part", backend="glsl", dtype="f32")(POINTS)
    before = gpu.compiled
    for w in np.linspace(10, 60, 7):
        program.field("part", backend="glsl", dtype="f32", w=float(w))(POINTS)
    assert gpu.compiled == before


def test_passes_change_no_value() -> None:
    """With and without simplifying and sharing, both within the bound of the graph as written."""
    for leave_out in ({"simplify"}, {"share"}, {"simplify", "share"}, {"fold", "simplify", "share"}):
        for root in random_graphs(40, 9):
            (full,) = flatten(root)
            (part,) = run(Graph({"part": (root,)}), leave_out=frozenset(leave_out)).outputs["part"]
            params = {name: (lo + hi) / 2 for name, (lo, hi) in RANGES.items()}
            for backend in NUMPY:
                agree(full, part, backend, params)


def test_passes_are_idempotent() -> None:
    """What leaves the pipeline passes through it unchanged."""
    for root in random_graphs(60, 10):
        once = flatten(root)
        assert flatten(*once) == once
    assert [p.name for p in PIPELINE][-1] == "verify"


FIELDS = [
    "gyroid(20) |> thicken(sphere(40) / 100, 0.3) & cylinder(30, 50)",
    "x + 2 * y",
    "sphere(20) & box([30, 20, 10]) | torus(15, 4)",
    "twist(diamond(9), 0.05)",
    "z",
    "if x * y < 3 then gyroid(9) else schwarz_p(7)",
    "0 * x + 4",
    "hypot(x, y) - 5",
]


def axes(dtype: Any) -> list[NDArray[Any]]:
    return [np.linspace(-31, 29, n).astype(dtype) for n in (23, 17, 41)]


def cloud(dtype: Any) -> NDArray[Any]:
    return np.stack(np.meshgrid(*axes(dtype), indexing="ij"), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("text", FIELDS)
@pytest.mark.parametrize("dtype", ["f32", "f64"])
def test_a_grid_is_its_points(text: str, dtype: str) -> None:
    field = NumpyField(Formula.of(flat(text)), dtype)  # type: ignore[arg-type]  # one of the two
    grid = field.on_grid(axes(field.dtype)).all()
    assert np.array_equal(grid.ravel(), field.at(cloud(field.dtype)))


@pytest.mark.parametrize("text", FIELDS)
def test_a_grid_on_the_device_is_its_points(gpu: Gpu, text: str) -> None:
    field = pore.compile(text).field("part", backend="glsl", dtype="f32")
    grid = field.on_grid(axes(np.float32)).all()
    assert np.array_equal(grid.ravel(), field(cloud(np.float32)))


FOUND = node("lookup", samples.GRID, const(1.0), const(2.0), const(-3.0), value=(0, 0, 0, 0))
READS = [("lookup", (0, 0, 0, 0)), ("lookup_cubic", (1, 0, 0, 0)), ("nearest", "distance")]
PLACES = {"p": (X, Y, Z), "two axes": (Y, 2 * X, ZERO), "mixed": (X, const(3.0), X + Z), "found": (FOUND, Y, Z)}


@pytest.mark.parametrize(("op", "asked"), READS)
@pytest.mark.parametrize("there", PLACES.values(), ids=PLACES)
def test_a_grid_of_data_is_its_points(op: str, asked: Any, there: tuple[Node, ...], engine: str) -> None:
    """Also where one walk gives several results, and where the place asked for depends on fewer axes."""
    read = node(op, samples.slot(TABLE[op].args[0]), *there, value=asked)
    if op == "nearest":
        read = read + node(op, *read.args, value="along") * X
    formula = Formula((read,), samples.bindings())
    field = NumpyField(formula, "f32") if engine == "numpy" else DeviceField(formula, {}, gpu())
    grid = field.on_grid(axes(np.float32))
    assert np.array_equal(grid.all().ravel(), field.at(cloud(np.float32)))
    assert np.array_equal(grid.block((1, 2, 3), (20, 9, 40)), grid.all()[1:20, 2:9, 3:40])


@pytest.mark.parametrize("text", FIELDS)
def test_blocks_are_parts_of_the_whole(text: str, engine: Any) -> None:
    grid = pore.compile(text).field("part", backend=engine, dtype="f32").on_grid(axes(np.float32))
    whole = grid.all()
    for lo, hi in (
        ((0, 0, 0), (23, 17, 41)),
        ((3, 5, 7), (4, 6, 8)),
        ((22, 0, 1), (23, 17, 2)),
        ((1, 2, 3), (20, 9, 40)),
    ):
        window = tuple(slice(a, b) for a, b in zip(lo, hi, strict=True))
        assert np.array_equal(grid.block(lo, hi), whole[window])


def test_threads_and_tiles_change_nothing() -> None:
    root = flat(FIELDS[0])
    wide = [np.linspace(-40, 40, n).astype(np.float32) for n in (61, 90, 71)]  # several tiles
    points = places(70_001, 3)  # several pieces
    grids = [NumpyField(Formula.of(root), "f32", threads=n).on_grid(wide).all() for n in (1, 2, 5)]
    values = [NumpyField(Formula.of(root), "f32", threads=n).at(points) for n in (1, 2, 5)]
    for other in range(1, 3):
        assert np.array_equal(grids[0], grids[other])
        assert np.array_equal(values[0], values[other])
    alone = np.concatenate([NumpyField(Formula.of(root), "f32").at(points[i : i + 1]) for i in range(0, 70_001, 7001)])
    assert np.array_equal(alone, values[0][::7001])


def test_composition_is_composition() -> None:
    """f @ q1 @ q2 at a point is f at q1 at q2 of that point, computed by hand."""
    program = pore.compile("""
let f = gyroid(9) + x
out whole = f @ [x + y, y - z, 2 * z] @ [y, z + 1, x]
out outer = f
""")
    q2 = np.stack([POINTS[:, 1], POINTS[:, 2] + 1, POINTS[:, 0]], axis=1)
    q1 = np.stack([q2[:, 0] + q2[:, 1], q2[:, 1] - q2[:, 2], 2 * q2[:, 2]], axis=1)
    assert np.allclose(program.field("whole")(POINTS), program.field("outer")(q1), rtol=0, atol=1e-11)


def test_equal_graphs_are_one_node() -> None:
    x, y = node("x"), node("y")
    assert node("add", x, y) is node("add", x, y)
    assert node("add", x, y) is not node("add", y, x)
