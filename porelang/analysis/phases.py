"""What a lattice can be anywhere: its sines and cosines as functions of three free phases, however those run in space.

A field that reads the point through sines and cosines alone, of no more than three independent quantities, is nowhere
greater than over one turn of each, whether they are coordinates (a lattice of a thousand cells), turned, twisted or
stretched. So the extremes of such a field are those of one cell, if they are met within the solid.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from porelang.formula import Formula
from porelang.ir import Node, Stage, X, Y, Z, const, node, order, substitute, within
from porelang.rewrites.simplify import tidy
from porelang.tape import AXES

_WAVES = {"sin_turns": 1.0, "cos_turns": 1.0, "sin": math.tau, "cos": math.tau}  # and what makes a turn of each
_SLACK = 1e-12  # of a turn
_FARTHEST = 64.0  # harmonics


@dataclass(frozen=True, slots=True)
class _Linear:
    """A sum of quantities times factors, and a constant."""

    factors: dict[Node, float]
    rest: float

    def plus(self, other: _Linear, by: float) -> _Linear:
        factors = dict(self.factors)
        for n, f in other.factors.items():
            factors[n] = factors.get(n, 0.0) + by * f
        return _Linear({n: f for n, f in factors.items() if f}, self.rest + by * other.rest)

    def times(self, by: float) -> _Linear:
        return _Linear({n: by * f for n, f in self.factors.items() if by}, by * self.rest)


def over_phases(formula: Formula) -> Formula | None:
    """The field as a function of phases x, y, z in turns, each from 0 to 1; None if it is no such field."""
    reached = order([formula.root], lambda n: () if n.op in _WAVES else within(n))
    if any(n.op in AXES for n in reached):
        return None
    waves = [n for n in reached if n.op in _WAVES and n.stage is Stage.FIELD]
    forms = {
        n: f.times(1 / _WAVES[n.op])
        for n, f in zip(waves, _linear(formula.with_roots(*(n.args[0] for n in waves))), strict=True)
    }
    phases = _phases(forms)
    if phases is None:
        return None
    by = {n: node(n.op.removesuffix("_turns") + "_turns", phase) for n, phase in phases.items()}
    return formula.with_roots(*tidy(substitute(formula.roots, by)))


def _phases(forms: Mapping[Node, _Linear]) -> dict[Node, Node] | None:
    """The argument of each wave as whole multiples of no more than three phases, if all of them are."""
    atoms = list(dict.fromkeys(a for f in forms.values() for a in f.factors))
    if not atoms:
        return None
    column = {a: i for i, a in enumerate(atoms)}
    rows: dict[Node, np.ndarray[tuple[int], np.dtype[np.float64]]] = {}
    for n, f in forms.items():
        rows[n] = np.zeros(len(atoms))
        for a, factor in f.factors.items():
            rows[n][column[a]] = factor
    base: list[Node] = []
    for n in sorted(rows, key=lambda n: float(np.abs(rows[n]).sum())):
        tried = np.array([rows[b] / np.linalg.norm(rows[b]) for b in [*base, n] if rows[b].any()])
        if rows[n].any() and np.linalg.matrix_rank(tried, tol=1e-9) > len(base):
            base.append(n)
    if not 1 <= len(base) <= 3:
        return None
    basis = np.array([rows[b] for b in base])
    out: dict[Node, Node] = {}
    for n, row in rows.items():
        shares = np.linalg.lstsq(basis.T, row, rcond=None)[0]
        whole = np.rint(shares)
        if np.abs(shares - whole).max() > _SLACK * _FARTHEST or np.abs(whole).max() > _FARTHEST:
            return None
        shift = forms[n].rest - sum(float(w) * forms[b].rest for w, b in zip(whole, base, strict=True))
        total = const(shift)
        for w, phase in zip(whole, (X, Y, Z), strict=False):
            total = total + phase * const(float(w))
        out[n] = total
    return out


def _linear(formula: Formula) -> list[_Linear]:
    """Roots as sums of quantities that are themselves no sums."""
    tape = formula.tape
    numbers = {i: float(v) for i, v in formula.known.items() if tape.kinds[i] == "real"}
    forms: dict[int, _Linear] = {i: _Linear({}, v) for i, v in numbers.items()}
    for i, op in enumerate(tape.ops):
        if i in formula.known:
            continue
        inputs = tape.inputs[i]
        if any(a not in forms for a in inputs):  # it reads a condition, or data
            forms[i] = _Linear({tape.nodes[i]: 1.0}, 0.0)
            continue
        f = [forms[a] for a in inputs]
        if op in ("add", "sub"):
            forms[i] = f[0].plus(f[1], 1.0 if op == "add" else -1.0)
        elif op == "neg":
            forms[i] = f[0].times(-1.0)
        elif op == "mul" and (inputs[0] in numbers or inputs[1] in numbers):
            by, of = (0, 1) if inputs[0] in numbers else (1, 0)
            forms[i] = f[of].times(f[by].rest)
        elif op == "div" and inputs[1] in numbers and f[1].rest:
            forms[i] = f[0].times(1 / f[1].rest)
        else:
            forms[i] = _Linear({tape.nodes[i]: 1.0}, 0.0)
    return [forms[r] for r in tape.roots]
