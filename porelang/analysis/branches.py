"""The branches of a field: which argument of each max, min, abs or choice a point is on, and the field with them held.

A rim of a part is where the active branch changes on its surface: the surfaces of two branches meet there, and each
goes on beyond the rim, smoothly, where it is not the part's. So a rim can be found as two equations, not guessed.
A branch has a number, the same for all points whose *active* choices agree: what is computed in an argument that is
not taken does not count. floor, round, mod and sign hold the step that they are on. The graph of a branch has no
choices left, and is small: of a union of a thousand struts it is one strut.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import slopes
from porelang.backends.numpy import NumpyField, every_position
from porelang.formula import Formula
from porelang.ir import ZERO, Node, Stage, const, is_const, node, order, within
from porelang.ops import TABLE
from porelang.parallel import parallel_for, workers
from porelang.rewrites.simplify import tidy

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
PIECE = 2**14
_SWITCHES = frozenset({"max", "min", "abs", "select", "floor", "round", "mod", "sign"})


def switches(formula: Formula) -> list[Node]:
    """What in a formula changes from one branch to another in space."""
    return [n for n in formula.tape.nodes if n.op in _SWITCHES and n.stage is Stage.FIELD]


class Branches:
    """A formula, its gradient and its branches, all in float64 at points (n, 3) in mm.

    `count` is the number of choices in the graph: without any, the surface has no rims.
    """

    def __init__(self, formula: Formula, threads: int | None = None):
        taken = formula.taken
        self.formula = taken.with_roots(*tidy([taken.root]))
        self.root = self.formula.root
        self.threads = workers(threads)
        self.alone = NumpyField(self.formula, "f64", self.threads)
        self.sloped = self._sloped(self.root)
        tape = self.formula.tape
        self.switches = {n: k for k, n in enumerate(switches(self.formula))}
        self.count = len(self.switches)
        self.above: list[Node] = []  # nodes with a switch below them, the root first
        reach = set(self.switches)
        for n in tape.nodes:
            if n in reach or any(a in reach for a in within(n)):
                reach.add(n)
                self.above.insert(0, n)
        self.mixing = np.random.default_rng(0).integers(-(2**62), 2**62, (self.count, 1))
        self._known: dict[int, int] = {}
        self._roots: dict[Node, int] = {}
        self._held: list[NumpyField] = []
        self._lock = Lock()

    def _sloped(self, root: Node) -> NumpyField:
        """A root and its gradient, with the bindings of the formula."""
        return NumpyField(self.formula.with_roots(root, *slopes(root)), "f64", self.threads)

    def value(self, points: Floats) -> Floats:
        """The field (n,)."""
        return np.asarray(self.alone.at(points))

    def slope(self, points: Floats) -> tuple[Floats, Floats]:
        """The field (n,) and its gradient (n, 3)."""
        out = np.asarray(self.sloped.at(points))
        return out[:, 0], out[:, 1:]

    def of(self, points: Floats) -> Ints:
        """The number of the branch that each point is on, (n,)."""
        numbers = np.zeros(len(points), np.int64)
        if self.count:
            self._over(len(points), lambda s: self._number(points[s], numbers[s]))
        return numbers

    def held(self, points: Floats, numbers: Ints) -> tuple[Floats, Floats]:
        """The field and its gradient as they are on the branches `numbers` (n,), wherever the points are."""
        out = np.empty((len(points), 4))
        ranks = np.argsort(numbers, kind="stable")
        ends = np.flatnonzero(np.diff(numbers[ranks], append=-1)) + 1
        for some in np.split(ranks, ends[:-1]):
            if len(some):
                out[some] = self._held[numbers[some[0]]].at(points[some])
        return out[:, 0], out[:, 1:]

    def _over(self, count: int, work: Callable[[slice], None]) -> None:
        pieces = [slice(start, start + PIECE) for start in range(0, count, PIECE)]
        parallel_for(work, pieces, self.threads if len(pieces) >= 4 else 1)

    def _number(self, points: Floats, numbers: Ints) -> None:
        values = dict(zip(self.formula.tape.nodes, every_position(self.formula, points), strict=True))
        rows = np.zeros((self.count, len(points)))
        active: dict[Node, Any] = {self.root: np.ones(len(points), np.bool_)}
        for n in self.above:
            on = active.get(n)
            if on is None:
                continue
            ways = [(a, on) for a in within(n)]
            if n in self.switches:
                choice = _choice(n, [values[a] for a in n.args])
                rows[self.switches[n]] = np.where(on, choice, 0.0)
                if n.op in ("max", "min"):
                    ways = [(n.args[0], on & (choice > 0)), (n.args[1], on & (choice < 0))]
                elif n.op == "select":
                    ways = [(n.args[1], on & (choice > 0)), (n.args[2], on & (choice < 0))]
            for a, way in ways:
                active[a] = active[a] | way if a in active else way
        keys = (np.nan_to_num(rows).astype(np.int64) * self.mixing).sum(axis=0)
        different, first, which = np.unique(keys, return_index=True, return_inverse=True)
        with self._lock:
            for key, i in zip(different.tolist(), first, strict=True):
                if key not in self._known:
                    self._known[key] = self._numbered(rows[:, i], points[i : i + 1])
            found = np.array([self._known[key] for key in different.tolist()])
        numbers[:] = found[which.ravel()]

    def _numbered(self, row: Floats, point: Floats) -> int:
        """The number of the branch with the choices of a row, made as at a point: other choices may be the same."""
        root = self._branch(row, point)
        if root not in self._roots:
            self._roots[root] = len(self._held)
            self._held.append(self._sloped(root))
        return self._roots[root]

    def _branch(self, row: Floats, point: Floats) -> Node:
        """The graph with the choices of a row made as at a point."""
        choices = {n: float(row[k]) for n, k in self.switches.items()}
        taken = {n: _taken(n, choice) for n, choice in choices.items()}
        new: dict[Node, Node] = {}
        for n in order([self.root], lambda n: taken.get(n, n.args) if n.stage is Stage.FIELD else ()):
            if n.stage is not Stage.FIELD or not n.args:
                new[n] = n
            elif n in choices:
                new[n] = _chosen(n, [new.get(a, a) for a in n.args], choices[n])
            else:
                new[n] = _made(n, tuple(new.get(a, a) for a in n.args))
        (root,) = tidy([new[self.root]])
        (root,) = tidy([self._unfolded(root, point)])
        return root

    def _unfolded(self, root: Node, point: Floats) -> Node:
        """The graph with |u|, and hypot(u, 0), as u or -u, whichever it is at a point.

        The distance from a box or a cylinder is such a hypot once it is known which sides are nearest; beyond the
        surface u is below 0, and |u| would have a kink there.
        """
        nodes = order([root], lambda n: n.args if n.stage is Stage.FIELD else ())
        formula = self.formula.with_roots(root)
        with np.errstate(all="ignore"):
            values = dict(zip(formula.tape.nodes, every_position(formula, point), strict=True))
        new: dict[Node, Node] = {}
        for n in nodes:
            args = tuple(new.get(a, a) for a in n.args) if n.stage is Stage.FIELD else n.args
            alone = n.args[0] if n.op == "abs" else None
            if n.op == "hypot" and any(is_const(a, 0.0) for a in n.args):
                alone = n.args[0] if is_const(n.args[1], 0.0) else n.args[1]
            if alone is not None and n.stage is Stage.FIELD:
                new[n] = new[alone] if np.all(np.asarray(values[alone]) >= 0) else -new[alone]
            elif n.args and n.stage is Stage.FIELD:
                new[n] = _made(n, args)
            else:
                new[n] = n
        return new[root]


def _made(n: Node, args: tuple[Node, ...]) -> Node:
    """A node with other arguments; 0 times anything is 0 here, as a choice that was not taken has no part in it."""
    if n.op == "mul" and any(is_const(a, 0.0) for a in args):
        return ZERO
    if n.op == "neg" and is_const(args[0], 0.0):
        return ZERO
    return node(n.op, *args, value=n.value)


def _choice(n: Node, args: list[Any]) -> Any:
    """What a switch does at points: 1 or -1 for its first or second argument (a, or -a), or the step it is on."""
    match n.op:
        case "max":
            return np.where(args[1] <= args[0], 1.0, -1.0)
        case "min":
            return np.where(args[0] <= args[1], 1.0, -1.0)
        case "abs":
            return np.where(args[0] >= 0, 1.0, -1.0)
        case "select":
            return np.where(args[0], 1.0, -1.0)
        case "mod":
            return np.floor(args[0] / args[1])
        case _:
            return TABLE[n.op].numpy(*args)


def _taken(n: Node, choice: float) -> tuple[Node, ...]:
    """The arguments of a switch that its choice takes."""
    match n.op:
        case "max" | "min":
            return (n.args[0] if choice > 0 else n.args[1],)
        case "select":
            return (n.args[1] if choice > 0 else n.args[2],)
        case "abs" | "mod":
            return n.args
        case _:
            return ()


def _chosen(n: Node, args: list[Node], choice: float) -> Node:
    """A switch whose choice is held."""
    match n.op:
        case "max" | "min":
            return args[0] if choice > 0 else args[1]
        case "abs":
            return args[0] if choice > 0 else -args[0]
        case "select":
            return args[1] if choice > 0 else args[2]
        case "mod":
            return args[0] - args[1] * const(choice)
        case _:
            return const(choice)
