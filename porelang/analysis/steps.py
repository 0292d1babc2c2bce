"""The members of a solid whose formula counts: copies in a ring or in a row, each with the number of its copy held.

A ring asks at every point which copy is nearest, an angle rounded to a whole number, and an enclosure of that over a
box is loose as long as the box sees more than one copy. With the whole number held it is the copy alone, moved, where
the number is that: a union of as many members as it has values. The coordinates that `ring` looks a copy up at are
clamped to its sector, where they are; a copy alone goes on beyond its sector without.
"""

from __future__ import annotations

import math

import numpy as np

from porelang.analysis.backwards import UNIVERSE
from porelang.analysis.enclose import enclose_all
from porelang.analysis.kin import members
from porelang.formula import Formula
from porelang.interval import interval
from porelang.ir import Node, const, constant, is_const, node, order, substitute, within
from porelang.tape import Tape

#: Values of one number that are told apart, and members in all: a wheel of a thousand spokes is taken as it is.
MOST_VALUES, MOST_MEMBERS = 128, 256
_NEARLY = 1 + 1e-12
_ROUNDING = frozenset({"round", "floor"})
_KEEPING = frozenset({"min", "max", "neg"})


def held(formula: Formula) -> list[Node] | None:
    """The members of a solid with every whole number in them held; None where there are none, or too many."""
    found: list[Node] = []
    counted_any = False
    (root,) = substitute([formula.root], _clamped(formula.root))
    waiting: list[tuple[Node, frozenset[Node]]] = [(m, frozenset()) for m in members(root)]
    while waiting:
        member, done = waiting.pop()
        counted = _counted(formula.with_roots(member), done)
        if counted is None:
            found.append(member)
        else:
            number, values = counted
            counted_any = True
            for k in values:
                (copy,) = substitute([member], {number: const(k)})
                here = node("abs", number - k) - 0.5
                waiting += [(node("max", m, here), done | {number}) for m in members(copy)]
        if len(found) + len(waiting) > MOST_MEMBERS:
            return None
    return found if counted_any else None


def _counted(formula: Formula, done: frozenset[Node]) -> tuple[Node, list[float]] | None:
    """A whole number in a formula with few values, and these; the last one that there is."""
    tape = formula.tape
    whole = _whole(tape)
    if not any(whole[i] and tape.nodes[i] not in done for i in tape.field):
        return None
    space = [interval(np.array([-UNIVERSE]), np.array([UNIVERSE]))] * 3
    known = enclose_all(formula, space)
    for i in reversed(tape.field):
        if not whole[i] or tape.nodes[i] in done:
            continue
        r = known[i].range
        low, high = float(np.min(r.lo)), float(np.max(r.hi))
        if not bool(np.any(r.nan)) and high - low < MOST_VALUES:
            return tape.nodes[i], [float(k) for k in range(math.ceil(low), math.floor(high) + 1)]
    return None


def _whole(tape: Tape) -> list[bool]:
    """Which positions are whole numbers that vary in space, or constants that are whole."""
    whole = [False] * len(tape)
    for i, op in enumerate(tape.ops):
        inputs = tape.inputs[i]
        if op == "const":
            value = tape.values[i]
            whole[i] = isinstance(value, float) and value.is_integer()
        else:
            whole[i] = op in _ROUNDING or (op in _KEEPING and all(whole[a] for a in inputs))
    return whole


def _clamped(root: Node) -> dict[Node, Node]:
    """What is clamped to a sector (prelude/space.pore, `ring`) and lies in it anyway, by what it is without the clamp.

    Where k = round(n phi / tau), the point turned back by k / n turns lies within half a sector of +x: its x is between
    rho cos(pi / n) and rho, and its y between -+rho sin(pi / n).
    """
    listed = order([root], within)
    found: dict[Node, Node] = {}
    for k in listed:
        if (sector := _sector(k)) is None:
            continue
        a, b, n = sector
        turn = node("div", k, const(n))
        c, s, rho = node("cos_turns", turn), node("sin_turns", turn), node("hypot", a, b)
        along, across = a * c + b * s, b * c - a * s
        for m in listed:
            if m.op != "min" or m.args[1].op != "max" or m.args[1].args[0] not in (along, across):
                continue
            most, inner = m.args[0], m.args[1]
            if inner.args[0] is along and most is rho and _times(inner.args[1], rho) <= math.cos(math.pi / n) * _NEARLY:
                found[m] = along
            if inner.args[0] is across and inner.args[1] is -most:
                wide = _times(most, rho)
                if math.isfinite(wide) and wide * _NEARLY >= math.sin(math.pi / n):
                    found[m] = across
    return found


def _sector(k: Node) -> tuple[Node, Node, float] | None:
    """a, b and n of round(atan2(b, a) / tau * n), n whole."""
    if k.op != "round" or k.args[0].op != "mul" or not is_const(k.args[0].args[1]):
        return None
    turns, n = k.args[0].args[0], float(constant(k.args[0].args[1]))
    if turns.op != "div" or turns.args[0].op != "atan2" or not is_const(turns.args[1], math.tau) or n < 2 or n % 1:
        return None
    b, a = turns.args[0].args
    return a, b, n


def _times(m: Node, rho: Node) -> float:
    """How many times a length a node is; infinite where it is none of it."""
    return float(constant(m.args[1])) if m.op == "mul" and m.args[0] is rho and is_const(m.args[1]) else math.inf
