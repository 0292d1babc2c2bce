"""The passes: what each does to a graph, how large graphs stay, and golden texts of graphs and shaders.

`PORELANG_GOLDEN=1` writes the golden texts anew; read the difference before it is committed.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import porelang as pore
from porelang.analysis.notes import NOTES
from porelang.backends.glsl import shader
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import PoreError
from porelang.formula import Formula
from porelang.ir import FALSE, ONE, TRUE, ZERO, Node, Stage, X, Y, Z, const, node, order, param, show
from porelang.rewrites import PIPELINE, Graph, run
from porelang.rewrites.gradient import derivatives
from porelang.rewrites.place import place
from porelang.rewrites.simplify import fold, share, simplify
from porelang.rewrites.verify import verify
from porelang.tape import lower

GOLDEN = Path(__file__).parent / "golden"
PROGRAMS = {
    "specimen": "param w = 30 in 10..60\nlet specimen = cylinder(75, 300)\n"
    "gyroid(w) |> thicken((torus(60, 20) - sphere(40)) / 100, 0.3) & specimen",
    "twisted": "box([10, 20, 30]) |> rotate([0, 0, 1], 30deg) |> twist(0.05)",
    "gradient": "grad(sin(x * 2) @ [x + y, y, z]).y",
    "conditions": "param n = 3 in 1..6\nif x < n and not y <= 0 then mod(x, n) else atan2(y, x)",
    "vector": "grad(gyroid(20)) * x",
    "data": 'param t = 2 in 1..4\nlet truss = frame("frame.json")\n'
    'load("grid.npz", "value") / 10 + grad(truss).x | truss - t',
}


def named(graph: Graph) -> dict[str, Node]:
    """The roots of the outputs, those of a vector by its axes, and what is required of params."""
    outputs = {
        name if len(roots) == 1 else f"{name}.{axis}": root
        for name, roots in graph.outputs.items()
        for axis, root in zip("xyz", roots, strict=False)
    }
    return outputs | {f"require {i}": root for i, root in enumerate(graph.requirements)}


def count(*roots: Node) -> int:
    return len(order(roots))


def golden(name: str, text: str) -> None:
    """Compare with the golden text of this name, or write it where that is asked for."""
    path = GOLDEN / name
    if os.environ.get("PORELANG_GOLDEN"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8"), f"{path.name} differs; PORELANG_GOLDEN=1 writes it anew"


@pytest.mark.parametrize("name", PROGRAMS)
def test_golden_graphs(name: str) -> None:
    program = pore.compile(PROGRAMS[name])
    previous = show(named(program.written))
    out = [f"---- as written\n{previous}\n"]
    for step in PIPELINE:
        graph = run(program.written, after=step.name)
        text = show(named(graph))
        out.append(f"---- after {step.name}\n{'as before' if text == previous else text}\n")
        previous = text
    roots = named(program.graph)
    for noted, of in NOTES.items():
        out.append(f"---- note {noted}\n{show(roots, of([*roots.values()], program.ranges))}\n")
    golden(f"{name}.txt", "".join(out))


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("form", ["points", "grid"])
def test_golden_shaders(name: str, form: str) -> None:
    program = pore.compile(PROGRAMS[name])
    made = shader(program.roots("part"), program.ranges, form)  # type: ignore[arg-type]  # one of the forms
    assert made.text.count("{") == made.text.count("}")
    if form == "points":
        golden(f"{name}.glsl", made.text)


def test_every_pass_has_its_name_and_doc() -> None:
    assert len({p.name for p in PIPELINE}) == len(PIPELINE)
    assert all(p.doc for p in PIPELINE)


# ---- place ----------------------------------------------------------------------------------------------------------


def test_nested_transforms_cost_what_their_parts_cost() -> None:
    """Each further transform adds the same number of operations: linear in depth, not doubled by it."""
    sizes = []
    for depth in (1, 2, 3, 10, 20, 40):
        moves = " |> ".join(["rotate([1, 2, 3], 0.1)", "translate([1, 0, 0])"] * depth)
        sizes.append(count(*pore.compile(f"sphere(3) |> {moves}").roots("part")))
    step = sizes[1] - sizes[0]
    assert sizes[2] - sizes[1] == step
    assert sizes[3] - sizes[2] == 7 * step
    assert sizes[5] - sizes[4] == 20 * step


def test_a_field_placed_where_it_is_is_itself() -> None:
    f = node("sin", X * Y)
    assert place([node("at", f, X, Y, Z)])[0] is f
    assert place([node("at", f, Y, X, Z)])[0] is node("sin", Y * X)
    assert place([node("at", node("at", X, Y, Z, X), Z, X, Y)])[0] is X


def test_coordinates_that_a_field_does_not_read_are_not_computed() -> None:
    f = node("at", node("sin", X), Y, node("exp", Z), node("log", Z))
    assert place([f])[0] is node("sin", Y)
    assert f.axes == Y.axes


def test_place_sees_through_shared_parts_once() -> None:
    """A chain f = g + g, fifty deep and moved at every level, stays as short as it is written."""
    f: Node = node("sin", X)
    for _ in range(50):
        f = node("at", f + f, X + 1.0, Y, Z)
    assert count(place([f])[0]) < 160


@pytest.mark.slow
def test_a_graph_that_doubles_without_end_is_an_error() -> None:
    """f @ a + f @ b, twenty-one levels deep with all places distinct, is two million operations."""
    f: Node = node("sin", X)
    for k in range(21):
        f = node("at", f, X + 3.0**k, Y, Z) + node("at", f, X * (1.0 + 2.0**-k), Y, Z)
    with pytest.raises(PoreError, match="E070"):
        place([f])


# ---- gradient -------------------------------------------------------------------------------------------------------


def test_derivatives_of_what_does_not_vary_are_zero() -> None:
    assert derivatives(const(3.0)) == (ZERO, ZERO, ZERO)
    assert derivatives(param("w")) == (ZERO, ZERO, ZERO)
    assert derivatives(X)[0] is ONE
    assert derivatives(node("floor", X)) == (ZERO, ZERO, ZERO)
    assert derivatives(X + Y)[2] is ZERO


def test_derivatives_share_their_parts() -> None:
    """The gradient of a long product of sines grows with its length, not with the square of it."""

    def size(n: int) -> int:
        f: Node = ONE
        for k in range(n):
            f = f * node("sin", X * float(k + 2) + Y)
        return count(*derivatives(f))

    assert size(80) - size(40) == 2 * (size(40) - size(20))


def test_second_derivatives() -> None:
    root = pore.compile("grad(grad(x ^ 4 * y).x).y").roots("part")[0]
    points = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    assert np.allclose(NumpyField(Formula.of(root)).at(points), 4 * points[:, 0] ** 3)


# ---- fold, simplify, share ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "made"),
    [
        (X + ZERO, X),
        (ZERO - X, -X),
        (X * ONE, X),
        (X * const(-1.0), -X),
        (X * X, node("square", X)),
        (X / const(4.0), X * 0.25),
        (X / const(3.0), X / const(3.0)),
        (node("neg", -X), X),
        (-(X - Y), Y - X),
        (X + -Y, X - Y),
        (node("pow", X, const(1.0)), X),
        (node("pow", X, const(2.0)), node("square", X)),
        (node("pow", X, const(0.5)), node("pow", X, const(0.5))),
        (node("abs", -X), node("abs", X)),
        (node("sqrt", node("square", X)), node("abs", X)),
        (node("min", X, X), X),
        (node("max", node("max", X, Y), X), node("max", X, Y)),
        (node("select", TRUE, X, Y), X),
        (node("select", node("lt", X, Y), Z, Z), Z),
        (node("select", node("not", node("lt", X, Y)), X, Z), node("select", node("lt", X, Y), Z, X)),
        (node("not", node("not", node("lt", X, Y))), node("lt", X, Y)),
        (node("and", TRUE, node("lt", X, Y)), node("lt", X, Y)),
        (node("or", TRUE, node("lt", X, Y)), TRUE),
        (node("and", FALSE, node("lt", X, Y)), FALSE),
        (node("cos", -X), node("cos", X)),
        (node("sin", -X), -node("sin", X)),
        (node("sin", X * const(2 * np.pi)), node("sin_turns", X)),
        (X * ZERO, ZERO),  # coordinates are finite
        (node("exp", X) * ZERO, node("exp", X) * ZERO),  # kept: infinity times 0 is not 0
        (X - X, X - X),  # kept: so is infinity less itself
    ],
    ids=str,
)
def test_rules(given: Node, made: Node) -> None:
    assert simplify([given])[0] is made


def test_folding_is_the_numpy_form() -> None:
    sine, quotient = fold([node("sin", const(2.0) * const(3.0)) + X, node("div", ONE, ZERO)])
    assert sine is const(float(np.sin(6.0))) + X
    assert quotient is const(np.inf)


def test_sharing_finds_equals() -> None:
    a, b, c, d = share([X * Y, Y * X, node("max", Z, X), node("max", X, Z)])
    assert a is b
    assert c is d


def test_stages() -> None:
    program = pore.compile("param w = 3 in 1..9\nsin(w * w) * x + exp(2) * cos(w)")
    (root,) = program.roots("part")
    assert root.stage is Stage.FIELD
    tape = lower([root])
    found = [tape.nodes[i] for i in tape.frontier]
    assert all(n.stage is Stage.UNIFORM for n in found)
    assert not any(n.op == "exp" for n in order([root])), "a constant is folded"
    assert len(found) == 2


def test_verify_refuses_what_no_backend_knows() -> None:
    for wrong in (node("at", X, Y, Z, X), node("add", X, TRUE), node("add", X), node("select", X, Y, Z)):
        with pytest.raises(AssertionError):
            verify([wrong])
    good = [node("select", node("lt", X, Y), X, ZERO)]
    assert verify(good) == good


# ---- size -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_eight_hundred_primitives_stay_linear() -> None:
    """A union of n struts costs n times one strut, and one operation each to join them."""

    def size(n: int) -> int:
        text = f"union([for i in range({n}): capsule([i, 0, 0], [i + 0.5, 3, 1], 0.3)])"
        return count(*pore.compile(text).roots("part"))

    small, large = size(100), size(800)
    each = (large - small) / 700
    assert 10 < each < 60
    assert abs(large - 800 * each) < 200


def test_the_depth_of_a_union_is_logarithmic() -> None:
    (root,) = pore.compile("union([for i in range(1024): translate(sphere(1), [3 * i, 0, 0])])").roots("part")
    depth: dict[Node, int] = {}
    for n in order([root]):
        depth[n] = 1 + max((depth[a] for a in n.args), default=0)
    assert depth[root] < 30


def test_outputs_share_what_they_have_in_common() -> None:
    program = pore.compile("let g = gyroid(9) & sphere(20)\nout a = g\nout b = ~g\nout c = g + 1")
    alone = count(*program.roots("a"))
    assert count(*(program.roots(n)[0] for n in "abc")) == alone + 3
    assert set(program.graph.outputs) == {"a", "b", "c"}
