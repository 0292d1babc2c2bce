"""Constants folded, and identities that change no value.

That 0 is 0 is all that is kept of it: x + 0 and x, -(a - b) and b - a, 0 x and 0 differ in the sign of a zero, by which
a quotient is one infinity or the other and an angle pi or -pi. The language leaves that sign open (docs/language.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from porelang.ir import ZERO, Into, Node, Stage, Value, const, constant, is_const, node, rebuild, whole, within
from porelang.ops import TABLE
from porelang.rewrite import Rule, rewrite

#: What a pass has made of nodes before: for passes that make the same of the same node, whatever reads it.
Known = dict[Any, Any]


def computed(op: str, values: Sequence[float | bool], wanted: Value = None) -> float | bool:
    """An operation on constants, computed in float64 by its NumPy form; of several results the one that is wanted."""
    arguments = [v if isinstance(v, bool) else np.float64(v) for v in values]
    with np.errstate(all="ignore"):
        if TABLE[op].results:
            (result,) = TABLE[op].numpy(*arguments, (wanted,))
        else:
            result = TABLE[op].numpy(*arguments)
    return bool(result) if isinstance(result, bool | np.bool_) else float(result)


def fold(roots: Sequence[Node], known: Known | None = None) -> list[Node]:
    """Every operation on constants replaced by its value."""
    return rebuild(roots, lambda n: n if n.op not in TABLE else _fold(n) or n, whole, known)


def _fold(n: Node) -> Node | None:
    if any(a.op != "const" for a in n.args):
        return None
    return const(computed(n.op, [constant(a) for a in n.args], n.value))


def simplify(roots: Sequence[Node], known: Known | None = None, into: Into = whole) -> list[Node]:
    """The graph after the rules below, with constants that appear folded at once."""
    return rewrite(roots, RULES, into, known)


def _same(n: Node) -> Node | None:
    """f(a, a) = a."""
    return n.args[0] if n.args[0] is n.args[1] else None


def _add_zero(n: Node) -> Node | None:
    a, b = n.args
    return b if is_const(a, 0.0) else a if is_const(b, 0.0) else None


def _add_negative(n: Node) -> Node | None:
    a, b = n.args
    return a - b.args[0] if b.op == "neg" else b - a.args[0] if a.op == "neg" else None


def _subtract_zero(n: Node) -> Node | None:
    a, b = n.args
    return a if is_const(b, 0.0) else -b if is_const(a, 0.0) else a + b.args[0] if b.op == "neg" else None


def _times_one(n: Node) -> Node | None:
    a, b = n.args
    for one, other in ((a, b), (b, a)):
        if is_const(one, 1.0):
            return other
        if is_const(one, -1.0):
            return -other
    return None


def _times_zero(n: Node) -> Node | None:
    """0 a = 0 where a is surely finite: what a rotation about an axis is full of."""
    a, b = n.args
    return ZERO if (is_const(a, 0.0) and _most(b) < _SAFE) or (is_const(b, 0.0) and _most(a) < _SAFE) else None


#: Below its square even float32 has room.
_SAFE = 1e18


def _most(n: Node, depth: int = 6) -> float:
    """The greatest magnitude of a node at any point (coordinates are finite, and at most 1e9), by a look a few levels
    down; infinity where none is known, or where it may overflow on the way."""
    if n.op in ("x", "y", "z"):
        return 1e9
    if n.op == "const":
        return abs(n.value) if isinstance(n.value, float) and math.isfinite(n.value) else math.inf
    if not depth or n.op not in _BOUNDED:
        return math.inf
    below = [_most(a, depth - 1) for a in n.args]
    if not max(below) < _SAFE:
        return math.inf
    return _BOUNDED[n.op](*below)


_BOUNDED: Mapping[str, Callable[..., float]] = {
    **dict.fromkeys(("neg", "abs"), lambda a: a),
    **dict.fromkeys(("add", "sub", "hypot"), lambda a, b: a + b),
    **dict.fromkeys(("min", "max"), max),
    **dict.fromkeys(("sin", "cos", "sin_turns", "cos_turns"), lambda a: 1.0),
    "mul": lambda a, b: a * b,
    "floor": lambda a: a + 1,
}


def _times_itself(n: Node) -> Node | None:
    return node("square", n.args[0]) if n.args[0] is n.args[1] else None


def _divide_by_power_of_two(n: Node) -> Node | None:
    """a / c as a * (1 / c) where 1 / c is exact."""
    a, b = n.args
    c = b.value
    if b.op != "const" or not isinstance(c, float) or not math.isfinite(c) or c == 0:
        return None
    mantissa, exponent = math.frexp(c)
    return a * (1.0 / c) if abs(mantissa) == 0.5 and abs(exponent) < 100 else None


def _small_power(n: Node) -> Node | None:
    a, b = n.args
    if b.op != "const":
        return None
    if b.value == 1.0:
        return a
    if b.value == 2.0:
        return node("square", a)
    if b.value == 3.0:
        return node("square", a) * a
    if b.value == 4.0:
        return node("square", node("square", a))
    if b.value == 0.5 and a.op in ("abs", "square", "hypot"):  # elsewhere they differ at -infinity and -0
        return node("sqrt", a)
    return None


def _double_negative(n: Node) -> Node | None:
    a = n.args[0]
    return a.args[0] if a.op == "neg" else a.args[1] - a.args[0] if a.op == "sub" else None


def _sign_is_lost(n: Node) -> Node | None:
    """|-a| = |a|, (-a)^2 = a^2, ||a|| = |a|."""
    a = n.args[0]
    return node(n.op, a.args[0]) if a.op in ("neg", "abs") else None


def _root_of_square(n: Node) -> Node | None:
    return node("abs", n.args[0].args[0]) if n.args[0].op == "square" else None


def _absorbed(n: Node) -> Node | None:
    """max(max(a, b), a) = max(a, b)."""
    a, b = n.args
    return a if a.op == n.op and b in a.args else b if b.op == n.op and a in b.args else None


def _taken(n: Node) -> Node | None:
    c, a, b = n.args
    if c.op == "const":
        return a if c.value else b
    if a is b:
        return a
    return node("select", c.args[0], b, a) if c.op == "not" else None


def _double_not(n: Node) -> Node | None:
    return n.args[0].args[0] if n.args[0].op == "not" else None


def _truth(n: Node) -> Node | None:
    """and / or with a constant."""
    a, b = n.args
    for fixed, other in ((a, b), (b, a)):
        if fixed.op == "const":
            return other if bool(fixed.value) is (n.op == "and") else fixed
    return None


def _in_turns(n: Node) -> Node | None:
    """sin(k u) = sin_turns((k / tau) u): the argument is reduced before it is multiplied, so far less is rounded."""
    a, turned = n.args[0], f"{n.op}_turns"
    if a.op == "mul":
        for k, u in (a.args, a.args[::-1]):
            if k.op == "const" and isinstance(k.value, float):
                return node(turned, u * (k.value / math.tau))
            if k.stage < Stage.FIELD <= u.stage:
                return node(turned, u * (k / math.tau))
    if a.op == "div" and a.args[1].stage < Stage.FIELD:
        above, below = a.args
        if above.op == "mul":
            for k, u in (above.args, above.args[::-1]):
                if k.op == "const":
                    return node(turned, u * (k / math.tau / below))
        return node(turned, above / (below * math.tau))
    return None


def _odd(n: Node) -> Node | None:
    a = n.args[0]
    return -node(n.op, a.args[0]) if a.op == "neg" else None


RULES = (
    *(Rule(f"fold {name}", name, _fold) for name in TABLE),
    Rule("add zero", "add", _add_zero),
    Rule("add negative", "add", _add_negative),
    Rule("subtract zero", "sub", _subtract_zero),
    Rule("times one", "mul", _times_one),
    Rule("times zero", "mul", _times_zero),
    Rule("times itself", "mul", _times_itself),
    Rule("divide by a power of two", "div", _divide_by_power_of_two),
    Rule("small power", "pow", _small_power),
    Rule("double negative", "neg", _double_negative),
    Rule("sign is lost", "abs", _sign_is_lost),
    Rule("sign is lost", "square", _sign_is_lost),
    Rule("root of square", "sqrt", _root_of_square),
    Rule("same", "min", _same),
    Rule("same", "max", _same),
    Rule("absorbed", "min", _absorbed),
    Rule("absorbed", "max", _absorbed),
    Rule("taken", "select", _taken),
    Rule("double not", "not", _double_not),
    Rule("truth", "and", _truth),
    Rule("truth", "or", _truth),
    Rule("same", "and", _same),
    Rule("same", "or", _same),
    Rule("in turns", "sin", _in_turns),
    Rule("in turns", "cos", _in_turns),
    *(Rule("odd", name, _odd) for name in ("sin", "sin_turns")),
    *(Rule("even", name, lambda n: node(n.op, n.args[0].args[0]) if n.args[0].op == "neg" else None)
      for name in ("cos", "cos_turns")),
)  # fmt: skip


def share(roots: Sequence[Node], _: Known | None = None, into: Into = whole) -> list[Node]:
    """Arguments of commutative operations in one order, so that a + b and b + a are one node; which, the whole graph
    decides."""
    rank: dict[Node, int] = {}

    def step(n: Node) -> Node:
        if n.op in TABLE and "commutative" in TABLE[n.op].facts:
            # constants last, as a reader expects; the rest by first appearance, the same in every run
            args = tuple(sorted(n.args, key=lambda a: (a.op == "const", rank[a])))
            n = n if args == n.args else node(n.op, *args, value=n.value)
        rank.setdefault(n, len(rank))
        return n

    return rebuild(roots, step, into)


def tidy(roots: Sequence[Node]) -> list[Node]:
    """What was made of a flat graph, simplified and shared; its tasks stay the same nodes, as they are bound."""
    return share(simplify(roots, into=within), into=within)
