"""THE TABLE: every kernel operation, declared once.

The checker, the folder, both backends, the enclosures, the gradient, the error oracle, the table tests, the generator
of random programs and the reference manual all read these rows. To add an operation is to add a row.

Tolerances hold for NumPy in float32 and float64 and for GLSL with the functions of shaders/lib alike; they were
measured by `pore doctor` and are asserted by tests/test_table.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from porelang import interval as iv
from porelang.interval import Array, Interval, Mask
from porelang.ir import ONE, ZERO, Node, const, node
from porelang.ops import forms, grid, joints, principal, random, segments, sites
from porelang.ops.row import Kind, Op, Tolerance
from porelang.ops.tasks import TASK_TABLE, Task

__all__ = ["CALLABLE", "OPERATORS", "TABLE", "TASK_TABLE", "Kind", "Op", "Task", "Tolerance", "kind"]

R: tuple[Kind, ...] = ("real",)
RR: tuple[Kind, ...] = ("real", "real")
BB: tuple[Kind, ...] = ("bool", "bool")


GRID: tuple[Kind, ...] = ("grid", "real", "real", "real")


def _slopes(f: Node, most: int) -> list[Node | None]:
    """The derivatives of a lookup along x, y, z: lookups of one order more, until it is flat between samples."""
    assert isinstance(f.value, tuple)
    component, *orders = (int(v) for v in f.value)
    raised = [tuple(o + (a == axis) for a, o in enumerate(orders)) for axis in range(3)]
    return [node(f.op, *f.args, value=(component, *r)) if max(r) <= most else None for r in raised]


def _away(bars: Node, x: Node, y: Node, z: Node, f: Node) -> list[Node | None]:
    """The derivatives of what is known of the nearest bar, along x, y, z.

    Of the distance it is n, the direction away from the bar; of n = (q - t (t.q)) / |.| it is (1 - n n - t t) / d where
    the foot lies on the bar, (1 - n n) / d where it lies at an end; of the place along it t / length, or 0 at an end.
    """

    def result(name: str) -> Node:
        return node("nearest", bars, x, y, z, value=name)

    if f.value == "distance":
        return [result(n) for n in ("nx", "ny", "nz")]
    t, along = [result(d) for d in ("dx", "dy", "dz")], result("along")
    on_bar = node("and", node("lt", ZERO, along), node("lt", along, ONE))
    if f.value == "along":
        return [node("select", on_bar, d / result("length"), ZERO) for d in t]
    if f.value in ("nx", "ny", "nz"):
        n = [result(d) for d in ("nx", "ny", "nz")]
        k, d = ("nx", "ny", "nz").index(str(f.value)), result("distance") + result("radius")
        return [
            node("select", node("lt", ZERO, d),
                 ((ONE if i == k else ZERO) - n[i] * n[k] - node("select", on_bar, t[i] * t[k], ZERO)) / d, ZERO)
            for i in range(3)
        ]  # fmt: skip
    return [None] * 3


def _joint(bars: Node, x: Node, y: Node, z: Node, k: Node, f: Node) -> list[Node | None]:
    """The derivatives of bars that are joined, along x, y, z and by k: results of the same walk. Those of second
    derivatives are not known."""

    def results(*names: str) -> list[Node | None]:
        return [node("joined", bars, x, y, z, k, value=name) for name in names]

    rows = {
        "distance": ("nx", "ny", "nz", "dk"), "nx": ("hxx", "hxy", "hxz", "gx"), "ny": ("hxy", "hyy", "hyz", "gy"),
        "nz": ("hxz", "hyz", "hzz", "gz"), "dk": ("gx", "gy", "gz", "kk"),
    }  # fmt: skip
    return results(*rows[str(f.value)]) if f.value in rows else [None] * 4


def _flat(*_: Node) -> tuple[Node | None, ...]:
    """The derivative of a piecewise constant operation."""
    return (None,) * 3


def _size(*args: Interval) -> Array:
    """The largest magnitude of the first argument."""
    return np.where(args[0].empty, 0.0, np.maximum(np.abs(args[0].lo), np.abs(args[0].hi)))


def _reduction(a: Interval) -> Array:
    """What an angle loses in its reduction to a turn, which GLSL does with 48 bits: |x| 2^-46 in float32."""
    return _size(a) * 2.0**-23


def _steps(at: Callable[[Array], Array]) -> Callable[[Interval], Mask]:
    return lambda a: at(a.lo) != at(a.hi)


def _positive(a: Node) -> Node:
    return node("lt", ZERO, a)


def _where(holds: Node, slope: Node) -> Node:
    """A slope where it is one, and 0 elsewhere: a length is level where it is 0, over all of the inside of a box."""
    return node("select", holds, slope, ZERO)


def _turning(y: Node, x: Node, f: Node) -> tuple[Node, Node]:
    """The derivatives of the angle of a point, which at the axis has none."""
    r2 = node("square", x) + node("square", y)
    return _where(_positive(r2), x / r2), _where(_positive(r2), -y / r2)


_ROWS = (
    # ---- arithmetic -------------------------------------------------------------------------------------------------
    Op("neg", R, "real", "The negative.", np.negative, "(-{0})", iv.neg, lambda a, f: (const(-1.0),), "-",
       ("-(2)", -2.0), tolerance=Tolerance(0.0), facts=frozenset({"odd"}),
       narrow=lambda w, a: (iv.neg(w),)),
    Op("add", RR, "real", "The sum.", np.add, "({0} + {1})", iv.add, lambda a, b, f: (ONE, ONE), "+",
       ("1.5 + 2", 3.5), facts=frozenset({"commutative"}),
       narrow=lambda w, a, b: (iv.sub(w, b), iv.sub(w, a))),
    Op("sub", RR, "real", "The difference.", np.subtract, "({0} - {1})", iv.sub,
       lambda a, b, f: (ONE, const(-1.0)), "-", ("1.5 - 2", -0.5),
       narrow=lambda w, a, b: (iv.add(w, b), iv.sub(a, w))),
    Op("mul", RR, "real", "The product.", np.multiply, "({0} * {1})", iv.mul, lambda a, b, f: (b, a), "*",
       ("1.5 * 2", 3.0), units="product", facts=frozenset({"commutative"}),
       narrow=lambda w, a, b: (iv.div(w, b), iv.div(w, a))),
    Op("square", R, "real", "The product of a number with itself.", np.square, "({0} * {0})", iv.square,
       lambda a, f: (2.0 * a,), "square", ("square(-3)", 9.0), units="square", facts=frozenset({"even"}),
       narrow=lambda w, a: (iv.up_to(iv.on_domain(np.sqrt, 0.0, math.inf)(w)),)),
    Op("div", RR, "real", "The quotient; x / 0 is infinite, 0 / 0 is not a number.", np.divide,
       "pore_div({0}, {1})", iv.div, lambda a, b, f: (1.0 / b, -f / b), "/", ("3 / 2", 1.5), units="quotient",
       tolerance=Tolerance(2.5), domain="divisor not 0", jumps=lambda a, b: b.contains(0.0),
       guarded="({0} / {1})", calm="divisor",
       narrow=lambda w, a, b: (iv.mul(w, b), b)),
    Op("mod", RR, "real", "a - b floor(a / b): the remainder, with the sign of the divisor.", forms.mod,
       "pore_mod({0}, {1})", iv.mod, lambda a, b, f: (ONE, (f - a) / b), "%", ("mod(-1, 3)", 2.0),
       tolerance=Tolerance(0.5, extra=lambda a, b: 2.0 * _size(a)), domain="divisor not 0, magnitudes below 1e37",
       jumps=lambda a, b: ~iv.one_period(iv.div(a, b)),
       doubles=(lambda a, b: iv.mod(a, b, False), lambda a, b: ~iv.one_period(iv.div(a, b), False))),
    Op("pow", RR, "real", "a to the power b; a negative base takes whole exponents only.", np.power,
       "pore_pow({0}, {1})", iv.power,
       lambda a, b, f: (b * node("pow", a, b - 1.0), node("select", _positive(a), f * node("log", a), ZERO)), "^",
       ("2 ^ 10", 1024.0), units="power", tolerance=Tolerance(2.0),
       domain="base positive, or exponent whole", jumps=lambda a, b: a.contains(0.0) & (b.lo < 0)),
    Op("min", RR, "real", "The lesser; not a number if either is none.", np.minimum, "pore_min({0}, {1})",
       iv.minimum, lambda a, b, f: (_pick("le", a, b), _pick("lt", b, a)), "min", ("min(1, 2)", 1.0),
       tolerance=Tolerance(0.0), guarded="min({0}, {1})", calm="numbers",
       facts=frozenset({"commutative", "idempotent"}),
       narrow=lambda w, a, b: (iv.at_least(w), iv.at_least(w))),
    Op("max", RR, "real", "The greater; not a number if either is none.", np.maximum, "pore_max({0}, {1})",
       iv.maximum, lambda a, b, f: (_pick("le", b, a), _pick("lt", a, b)), "max", ("max(1, 2)", 2.0),
       tolerance=Tolerance(0.0), guarded="max({0}, {1})", calm="numbers",
       facts=frozenset({"commutative", "idempotent"}),
       narrow=lambda w, a, b: (iv.at_most(w), iv.at_most(w))),
    Op("abs", R, "real", "The magnitude.", np.absolute, "abs({0})", iv.absolute,
       lambda a, f: (node("sign", a),), "abs", ("abs(-2)", 2.0), tolerance=Tolerance(0.0), facts=frozenset({"even"}),
       narrow=lambda w, a: (iv.up_to(w),)),
    Op("sign", R, "real", "-1, 0 or 1.", np.sign, "pore_sign({0})", iv.sign, _flat, "sign", ("sign(-2)", -1.0),
       units="pure", tolerance=Tolerance(0.0), jumps=_steps(np.sign), facts=frozenset({"odd"})),
    Op("floor", R, "real", "The greatest whole number that is not greater.", np.floor, "floor({0})",
       iv.monotone(np.floor), _flat, "floor", ("floor(-1.5)", -2.0), tolerance=Tolerance(0.0), jumps=_steps(np.floor)),
    Op("round", R, "real", "The nearest whole number; halves go to the even one.", np.rint, "roundEven({0})",
       iv.monotone(np.rint), _flat, "round", ("round(2.5)", 2.0), tolerance=Tolerance(0.0), jumps=_steps(np.rint),
       facts=frozenset({"odd"})),
    # ---- roots, exponentials ----------------------------------------------------------------------------------------
    Op("sqrt", R, "real", "The square root; not a number below 0. Its derivative at 0 is taken as 0.", np.sqrt,
       "pore_sqrt({0})", iv.on_domain(np.sqrt, 0.0, math.inf),
       lambda a, f: (_where(_positive(a), 0.5 / f),), "sqrt", ("sqrt(9)", 3.0), units="root",
       tolerance=Tolerance(2.5), domain="not negative", guarded="sqrt({0})", calm="not negative",
       narrow=lambda w, a: (iv.at_most(iv.square(w)),)),
    Op("hypot", RR, "real", "sqrt(a^2 + b^2), the length of a side; its derivative at 0 is taken as 0.", forms.hypot,
       "sqrt({0} * {0} + {1} * {1})",
       lambda a, b: iv.on_domain(np.sqrt, 0.0, math.inf)(iv.add(iv.square(a), iv.square(b))),
       lambda a, b, f: (node("direction", a, f), node("direction", b, f)), "hypot", ("hypot(3, 4)", 5.0),
       tolerance=Tolerance(3.5, 1e-12, extra=lambda a, b: np.where(np.maximum(_size(a), _size(b)) > 1e19, np.inf, 0.0)),
       domain="magnitudes below 1e19", facts=frozenset({"commutative"}),
       narrow=lambda w, a, b: (iv.up_to(w), iv.up_to(w))),
    Op("direction", RR, "real", "a / r, for |a| <= r: a cosine; it and its derivative are 0 where r is 0.",
       forms.direction, "({1} == 0.0 ? 0.0 : {0} / {1})", lambda a, r: _cosine(a, r),
       lambda a, r, f: (_where(_positive(r), 1.0 / r), _where(_positive(r), -f / r)), "",
       ("hypot(3, 4) / 5", 1.0), units="quotient", tolerance=Tolerance(2.5), domain="|a| <= r, r below 8e37",
       jumps=lambda a, r: r.contains(0.0)),
    Op("exp", R, "real", "e to the power a.", np.exp, "pore_exp({0})", iv.monotone(np.exp), lambda a, f: (f,), "exp",
       ("exp(0)", 1.0), units="pure", tolerance=Tolerance(3.0)),
    Op("log", R, "real", "The natural logarithm; -infinity at 0, not a number below.", np.log, "pore_log({0})",
       iv.on_domain(np.log, 0.0, math.inf), lambda a, f: (1.0 / a,), "log", ("log(1)", 0.0), units="pure",
       tolerance=Tolerance(4.0), domain="not negative"),
    # ---- angles -----------------------------------------------------------------------------------------------------
    Op("sin", R, "real", "The sine of an angle in radians.", np.sin, "pore_sin({0})",
       iv.sin, lambda a, f: (node("cos", a),), "sin", ("sin(0)", 0.0), units="angle",
       tolerance=Tolerance(1.5, 1.6, extra=_reduction), domain="finite",
       facts=frozenset({"odd"})),
    Op("cos", R, "real", "The cosine of an angle in radians.", np.cos, "pore_cos({0})",
       iv.cos, lambda a, f: (-node("sin", a),), "cos", ("cos(0)", 1.0), units="angle",
       tolerance=Tolerance(1.5, 1.6, extra=_reduction), domain="finite",
       facts=frozenset({"even"})),
    Op("sin_turns", R, "real", "The sine of an angle in turns: sin(tau u), reduced exactly before the product.",
       forms.sin_turns, "pore_sin_turns({0})", iv.sin_turns, lambda a, f: (math.tau * node("cos_turns", a),),
       "sin_turns", ("sin_turns(0.25)", 1.0), units="turns", tolerance=Tolerance(1.0, 2.0), domain="finite",
       facts=frozenset({"odd", "periodic"})),
    Op("cos_turns", R, "real", "The cosine of an angle in turns: cos(tau u), reduced exactly before the product.",
       forms.cos_turns, "pore_cos_turns({0})", iv.cos_turns, lambda a, f: (-math.tau * node("sin_turns", a),),
       "cos_turns", ("cos_turns(0.5)", -1.0), units="turns", tolerance=Tolerance(1.0, 2.0), domain="finite",
       facts=frozenset({"even", "periodic"})),
    Op("reduced", R, "real", "u turns in radians, less whole turns: what a sine and a cosine of one angle share.",
       forms.reduced, "pore_reduced({0})", iv.reduced, lambda a, f: (const(math.tau),), "", None, units="turns",
       tolerance=Tolerance(1.0), domain="finite", jumps=_steps(np.rint), facts=frozenset({"odd"})),
    Op("asin", R, "real", "The angle (-pi/2 to pi/2) whose sine is a.", np.arcsin, "pore_asin({0})",
       iv.on_domain(np.arcsin, -1.0, 1.0), lambda a, f: (1.0 / node("sqrt", 1.0 - node("square", a)),), "asin",
       ("asin(0)", 0.0), units="angle of", tolerance=Tolerance(4.0), domain="-1 to 1",
       facts=frozenset({"odd"})),
    Op("acos", R, "real", "The angle (0 to pi) whose cosine is a.", np.arccos, "pore_acos({0})",
       iv.on_domain(np.arccos, -1.0, 1.0, rising=False),
       lambda a, f: (-1.0 / node("sqrt", 1.0 - node("square", a)),), "acos", ("acos(1)", 0.0), units="angle of",
       tolerance=Tolerance(4.0), domain="-1 to 1"),
    Op("atan2", RR, "real", "The angle (-pi to pi) of the point (x, y), given y first; its derivative at 0, 0 is 0.",
       np.arctan2, "pore_atan2({0}, {1})", iv.atan2,
       _turning,
       "atan2", ("atan2(0, 1)", 0.0), units="angle of", tolerance=Tolerance(4.0), domain="not both 0",
       jumps=lambda y, x: (x.lo <= 0) & y.contains(0.0)),
    # ---- truth ------------------------------------------------------------------------------------------------------
    Op("lt", RR, "bool", "Whether a is less than b.", np.less, "({0} < {1})", iv.less, _flat, "<", ("1 < 2", True),
       tolerance=Tolerance(0.0)),
    Op("le", RR, "bool", "Whether a is not greater than b.", np.less_equal, "({0} <= {1})", iv.less_equal, _flat,
       "<=", ("2 <= 2", True), tolerance=Tolerance(0.0)),
    Op("eq", RR, "bool", "Whether a equals b.", np.equal, "({0} == {1})", iv.equal, _flat, "==", ("2 == 2", True),
       tolerance=Tolerance(0.0), facts=frozenset({"commutative"})),
    Op("and", BB, "bool", "Whether both hold.", np.logical_and, "({0} && {1})", iv.conjunction, _flat, "and",
       ("true and false", False), units="none", tolerance=Tolerance(0.0), facts=frozenset({"commutative"})),
    Op("or", BB, "bool", "Whether either holds.", np.logical_or, "({0} || {1})", iv.disjunction, _flat, "or",
       ("true or false", True), units="none", tolerance=Tolerance(0.0), facts=frozenset({"commutative"})),
    Op("not", ("bool",), "bool", "Whether it does not hold.", np.logical_not, "pore_not({0})", iv.negation, _flat,
       "not", ("not true", False), units="none", tolerance=Tolerance(0.0)),
    Op("select", ("bool", "any", "any"), "any", "a where the condition holds, else b.", forms.select,
       "({0} ? {1} : {2})", iv.select, _flat, "if",  # its slope is a choice, no sum: `rewrites/gradient.py`
       ("if 1 < 2 then 5 else 6", 5.0), tolerance=Tolerance(0.0),
       jumps=lambda c, a, b: (c.lo < 1) & (c.hi > 0)),
    # ---- tensors ----------------------------------------------------------------------------------------------------
    Op("principal", ("real",) * 6, "real", "The principal values of a symmetric tensor (xx, yy, zz, xy, yz, xz), the "
       "largest first, and their directions.", principal.principal,
       "pore_principal({0}, {1}, {2}, {3}, {4}, {5})", principal.enclose, principal.slopes, "", None,
       tolerance=Tolerance(0.0, extra=principal.rounding), domain="finite", jumps=principal.jumps,
       results=principal.RESULTS),
    # ---- chance -----------------------------------------------------------------------------------------------------
    Op("random", ("real",) * 4, "real", "Four random numbers, 0 to 1, of the cell of size 1 that a place lies in and "
       "of a seed.", random.random, "pore_random({0}, {1}, {2}, {3})", random.enclose, _flat, "", None,
       tolerance=Tolerance(0.0), domain="magnitudes below 2^23", jumps=random.jumps,
       results=random.RESULTS),
    Op("sites", ("real",) * 5, "real", "Random sites, one in each cell of size 1, of a seed and a jitter: the "
       "distances from the three nearest and from the wall half way to another, their gradients, and a number of "
       "the nearest.",
       sites.sites, "pore_sites({0}, {1}, {2}, {3}, {4}, {wanted})", sites.enclose, sites.slopes, "", None,
       tolerance=Tolerance(0.0, extra=sites.rounding), domain="magnitudes below 2^23, jitter 0 to 1",
       jumps=sites.jumps, results=sites.RESULTS),
    # ---- data -------------------------------------------------------------------------------------------------------
    Op("lookup", GRID, "real", "Samples on a grid, trilinear between them and held at the border: a component, or a "
       "derivative of it.", grid.lookup, "pore_lookup{0}({1}, {2}, {3}, {payload})",
       lambda g, x, y, z, p: grid.enclose(g, x, y, z, p, False), lambda g, x, y, z, f: (None, *_slopes(f, 1)), "", None,
       tolerance=Tolerance(0.0, extra=lambda g, x, y, z, p: grid.rounding(g, x, y, z, p, False)), payload=True,
       jumps=lambda g, x, y, z, p: grid.jumps(g, x, y, z, p, False),
       narrow=lambda w, g, x, y, z, p: (None, *grid.narrow(w, g, p))),
    Op("lookup_cubic", GRID, "real", "Samples on a grid, tricubic between them (Catmull-Rom) with a smooth gradient.",
       grid.lookup_cubic, "pore_cubic{0}({1}, {2}, {3}, {payload})",
       lambda g, x, y, z, p: grid.enclose(g, x, y, z, p, True), lambda g, x, y, z, f: (None, *_slopes(f, 3)), "", None,
       tolerance=Tolerance(0.0, extra=lambda g, x, y, z, p: grid.rounding(g, x, y, z, p, True)), payload=True,
       jumps=lambda g, x, y, z, p: grid.jumps(g, x, y, z, p, True)),
    Op("covers", GRID, "bool", "Whether a point lies within the box of a grid.", grid.covers,
       "pore_covers{0}({1}, {2}, {3})", grid.enclose_covers, _flat, "", None, tolerance=Tolerance(0.0)),
    Op("nearest", ("segments", "real", "real", "real"), "real", "The bar whose surface is nearest: its distance, the "
       "direction away from it, its own direction, and more.", segments.nearest, "pore_nearest{0}({1}, {2}, {3})",
       segments.enclose_nearest, lambda b, x, y, z, f: (None, *_away(b, x, y, z, f)), "", None,
       tolerance=Tolerance(0.0, extra=segments.rounding_nearest),
       jumps=segments.jumps_nearest, results=segments.RESULTS,
       narrow=lambda w, b, x, y, z: (None, *segments.narrow_distance(w, b, x, y, z))),
    Op("joined", ("segments", "real", "real", "real", "real"), "real", "Bars joined smoothly where they are less than "
       "k apart: the distance, its gradient, its derivative by k, and more.", joints.joined,
       "pore_joined{0}({1}, {2}, {3}, {4})", joints.enclose_joined,
       lambda b, x, y, z, k, f: (None, *_joint(b, x, y, z, k, f)), "", None,
       tolerance=Tolerance(0.0, extra=joints.rounding_joined), jumps=joints.jumps_joined, results=joints.RESULTS,
       narrow=lambda w, b, x, y, z, k: (None, *joints.narrow_joined(w, b, x, y, z, k))),
)  # fmt: skip


def _pick(test: str, a: Node, b: Node) -> Node:
    return node("select", node(test, a, b), ONE, ZERO)


def _cosine(a: Interval, r: Interval) -> Interval:
    """a / r clipped to -1..1, with room for its own rounding, 0 where r is 0; r is never negative."""
    q = iv.div(a, r)
    infinite = (np.isinf(a.lo) | np.isinf(a.hi)) & np.isinf(r.hi)
    least = np.where((a.lo >= 0) & (r.lo >= 0), 0.0, -1.0)
    most = np.where((a.hi <= 0) & (r.lo >= 0), 0.0, 1.0)
    return Interval(np.maximum(q.lo, least), np.minimum(q.hi, most), a.nan | r.nan | infinite)


TABLE: dict[str, Op] = {op.name: op for op in _ROWS}
#: Operations that the language calls by a name, and those it writes with an operator.
CALLABLE: dict[str, Op] = {op.symbol: op for op in _ROWS if op.symbol.isidentifier() and op.result == "real"}
CALLABLE |= {"pow": TABLE["pow"], "mod": TABLE["mod"]}
OPERATORS: dict[str, Op] = {op.symbol: op for op in _ROWS if op.symbol and not op.symbol.isidentifier()}
OPERATORS["-"] = TABLE["sub"]


def kind(n: Node) -> Kind:
    """Whether a node is a real number, a truth value, or data."""
    while True:
        if n.op == "const":
            return "bool" if isinstance(n.value, bool) else "real"
        if n.op in TASK_TABLE:
            return TASK_TABLE[n.op].result
        row = TABLE.get(n.op)
        if row is not None and row.result != "any":
            return row.result
        if not n.args:
            return "real"  # a coordinate, a param, an unknown
        n = n.args[1] if n.op == "select" else n.args[0]  # `at`, `d` and `ensure` are of the kind of their field
