"""Fields that repeat: those that read the point through sines and cosines of linear forms alone, as lattices do.

What such a field can be anywhere it can be in one period, so that its extremes over a thousand cells cost those of one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from porelang.backends.uniform import uniform_values
from porelang.ir import Node, Stage, X, Y, Z, const, node, order

_WAVES = {"sin_turns": 1.0, "cos_turns": 1.0, "sin": 1 / math.tau, "cos": 1 / math.tau}
_SLACK = 1e-9  # turns


def periods(root: Node, params: Mapping[str, float]) -> NDArray[np.float64] | None:
    """Three independent vectors (rows, mm) by which a flat field may be moved without a change; None if none show."""
    reached = order([root], lambda n: () if n.op in _WAVES else n.args)
    if any(n.op in ("x", "y", "z") for n in reached):
        return None
    waves = [n for n in reached if n.op in _WAVES and n.stage is Stage.FIELD]
    forms = _linear([n.args[0] for n in waves], params)
    slopes: list[NDArray[np.float64]] = []
    for n in waves:
        form = forms.get(n.args[0])
        if form is None:
            return None
        slopes.append(form * _WAVES[n.op])
    return _lattice(slopes)


def _lattice(slopes: list[NDArray[np.float64]]) -> NDArray[np.float64] | None:
    """Vectors along which every wave advances a whole number of turns."""
    base: list[NDArray[np.float64]] = []
    for s in sorted(slopes, key=lambda s: float(np.linalg.norm(s))):
        if np.linalg.matrix_rank(np.array([*base, s]), tol=1e-9 * max(float(np.linalg.norm(s)), 1e-300)) > len(base):
            base.append(s)
        if len(base) == 3:
            break
    if not base:
        return None
    free = np.linalg.svd(np.array(base))[2][len(base) :]  # directions along which nothing changes
    rows = np.array([*base, *(free * np.linalg.norm(base[0]))])
    moves = np.linalg.inv(rows).T
    turns = np.array(slopes) @ moves.T
    return moves if np.abs(turns - np.rint(turns)).max() < _SLACK else None


def _linear(roots: list[Node], params: Mapping[str, float]) -> dict[Node, NDArray[np.float64]]:
    """The factors of x, y and z in each node that is a linear form of them."""
    nodes = order(roots, lambda n: n.args if n.stage is Stage.FIELD else ())
    numbers = uniform_values([n for n in nodes if n.stage is not Stage.FIELD], params)
    forms: dict[Node, NDArray[np.float64]] = {n: np.zeros(3) for n in numbers}
    for n in nodes:
        if n in forms:
            continue
        if n.op in ("x", "y", "z"):
            forms[n] = np.eye(3)["xyz".index(n.op)]
        elif all(a in forms for a in n.args):
            f = [forms[a] for a in n.args]
            if n.op in ("add", "sub"):
                forms[n] = f[0] + f[1] if n.op == "add" else f[0] - f[1]
            elif n.op == "neg":
                forms[n] = -f[0]
            elif n.op == "mul" and (n.args[0] in numbers or n.args[1] in numbers):
                by, of = (0, 1) if n.args[0] in numbers else (1, 0)
                forms[n] = f[of] * float(numbers[n.args[by]])
            elif n.op == "div" and n.args[1] in numbers and numbers[n.args[1]]:
                forms[n] = f[0] / float(numbers[n.args[1]])
    return forms


def one_period(root: Node, moves: NDArray[np.float64]) -> Node:
    """The field over its period: x, y, z from 0 to 1 are shares of the three moves."""
    shares = (X, Y, Z)
    at = {axis: _sum([s * const(float(moves[i, k])) for i, s in enumerate(shares)]) for k, axis in enumerate((X, Y, Z))}
    new: dict[Node, Node] = {}
    for n in order([root]):
        new[n] = at[n] if n in at else node(n.op, *(new[a] for a in n.args), value=n.value)
    return new[root]


def _sum(terms: list[Node]) -> Node:
    total = terms[0]
    for t in terms[1:]:
        total = total + t
    return total
