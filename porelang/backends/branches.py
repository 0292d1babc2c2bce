"""The branches of a field: which argument of each max, min, abs or choice a point is on, and the field with them held.

A rim of a part is where the active branch changes on its surface: the surfaces of two branches meet there, and each
goes on beyond the rim, smoothly, where it is not the part's. So a rim can be found as two equations, not guessed.
A branch has a number, the same for all points whose *active* choices agree: what is computed in an argument that is
not taken does not count. floor, round, mod and sign hold the step that they are on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import workers
from porelang.backends.uniform import take_branches, uniform_values
from porelang.ir import Node, Stage, is_const, node, order
from porelang.ops import TABLE
from porelang.passes.bounds import slopes
from porelang.passes.simplify import share, simplify

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
PIECE = 2**14
_SWITCHES = frozenset({"max", "min", "abs", "select", "floor", "round", "mod", "sign"})
_AXIS = {"x": 0, "y": 1, "z": 2}


class Branches:
    """A flat root with its params set, its gradient and its branches, all in float64 at points (n, 3) in mm.

    `count` is the number of choices in the graph: without any, the surface has no rims.
    """

    def __init__(self, root: Node, params: Mapping[str, float], threads: int | None = None):
        self.root = share(simplify({"f": take_branches(root, params)}))["f"]
        self.roots = (self.root, *slopes(self.root))
        self.nodes = order(self.roots, lambda n: n.args if n.stage is Stage.FIELD else ())
        self.scalars: dict[Node, Any] = dict(
            uniform_values([n for n in self.nodes if n.stage is not Stage.FIELD], params)
        )
        self.own = order([self.root], lambda n: n.args if n.stage is Stage.FIELD else ())
        switches = [n for n in self.own if n.op in _SWITCHES and n.stage is Stage.FIELD]
        self.switches = {n: k for k, n in enumerate(switches)}
        self.count = len(self.switches)
        self.above: list[Node] = []  # nodes with a switch below them, the root first
        reach = set(self.switches)
        for n in self.own:
            if n in reach or any(a in reach for a in n.args):
                reach.add(n)
                self.above.insert(0, n)
        self.tests = self._tests()
        self.threads = workers(threads)
        self._known: dict[int, int] = {}
        self._rows = np.zeros((0, self.count))
        self._lock = Lock()

    def _tests(self) -> dict[Node, tuple[int, bool]]:
        """The comparisons that derivatives make: the choice each must agree with, and whether it is its contrary."""
        tests: dict[Node, tuple[int, bool]] = {}
        for n, k in self.switches.items():
            match n.op, n.args:
                case "max", (a, b):
                    tests |= {node("le", b, a): (k, True), node("lt", a, b): (k, False)}
                case "min", (a, b):
                    tests |= {node("le", a, b): (k, True), node("lt", b, a): (k, False)}
        for n, k in self.switches.items():
            if n.op == "select":
                tests[n.args[0]] = (k, True)
        return tests

    def value(self, points: Floats) -> Floats:
        """The field (n,)."""
        out = np.empty((len(points), 1))
        self._over(len(points), lambda s: self._evaluate(points[s], out[s]))
        return out[:, 0]

    def slope(self, points: Floats) -> tuple[Floats, Floats]:
        """The field (n,) and its gradient (n, 3)."""
        out = np.empty((len(points), 4))
        self._over(len(points), lambda s: self._evaluate(points[s], out[s]))
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
        choices = self._rows
        self._over(len(points), lambda s: self._evaluate(points[s], out[s], choices[numbers[s]].T))
        return out[:, 0], out[:, 1:]

    def _over(self, count: int, work: Callable[[slice], None]) -> None:
        def quiet(start: int) -> None:
            with np.errstate(all="ignore"):
                work(slice(start, start + PIECE))

        starts = range(0, count, PIECE)
        if self.threads == 1 or len(starts) < 4:
            for start in starts:
                quiet(start)
            return
        with ThreadPoolExecutor(self.threads) as pool:
            for done in pool.map(quiet, starts):
                assert done is None

    def _evaluate(self, points: Floats, out: Floats, choices: Floats | None = None) -> None:
        values = self._values(self.nodes if out.shape[1] > 1 else self.own, points, choices)
        for i in range(out.shape[1]):
            out[:, i] = values[self.roots[i]]

    def _values(self, nodes: list[Node], points: Floats, choices: Floats | None = None) -> dict[Node, Any]:
        values = dict(self.scalars)
        for n in nodes:
            if n in self.scalars:
                continue
            if n.op in _AXIS:
                values[n] = np.ascontiguousarray(points[:, _AXIS[n.op]])
            elif choices is not None and n in self.switches:
                values[n] = _chosen(n, [values[a] for a in n.args], choices[self.switches[n]])
            elif choices is not None and n in self.tests:
                k, straight = self.tests[n]
                values[n] = (choices[k] > 0) == straight
            elif choices is not None and n.op == "sign" and (of := node("abs", n.args[0])) in self.switches:
                values[n] = choices[self.switches[of]]
            else:
                values[n] = TABLE[n.op].numpy(*(values[a] for a in n.args))
                if choices is not None and n.op in ("hypot", "direction"):
                    values[n] = self._unfolded(n, values, choices)
        return values

    def _unfolded(self, n: Node, values: dict[Node, Any], choices: Floats) -> Any:
        """hypot(a, b) with max(u, 0) for b on its 0 is a, which may be below 0 now: not |a|, which has a kink there.

        The distance from a box is made of these. A `direction` is that of such a hypot.
        """
        if n.op == "direction":
            a, whole = n.args
            if whole.op != "hypot" or a not in whole.args:
                return values[n]
            other = whole.args[1] if a is whole.args[0] else whole.args[0]
            alone = self._nought(other, choices) & ~self._nought(a, choices)
            return np.where(alone, 1.0, values[n])
        a, b = n.args
        no_a, no_b = self._nought(a, choices), self._nought(b, choices)
        return np.where(no_b, values[a], np.where(no_a, values[b], values[n]))

    def _nought(self, n: Node, choices: Floats) -> Any:
        """Where a node is 0 by the choices that are held."""
        if n.op == "hypot":
            return self._nought(n.args[0], choices) & self._nought(n.args[1], choices)
        if n.op == "max" and n in self.switches:
            choice = choices[self.switches[n]]
            if is_const(n.args[1], 0.0):
                return choice < 0
            if is_const(n.args[0], 0.0):
                return choice > 0
        return np.zeros(choices.shape[1], np.bool_)

    def _number(self, points: Floats, numbers: Ints) -> None:
        values = self._values(self.own, points)
        rows = np.zeros((self.count, len(points)))
        active: dict[Node, Any] = {self.root: np.ones(len(points), np.bool_)}
        for n in self.above:
            on = active.get(n)
            if on is None:
                continue
            ways = [(a, on) for a in n.args]
            if n in self.switches:
                choice = _choice(n, [values[a] for a in n.args])
                rows[self.switches[n]] = np.where(on, choice, 0.0)
                if n.op in ("max", "min"):
                    ways = [(n.args[0], on & (choice > 0)), (n.args[1], on & (choice < 0))]
                elif n.op == "select":
                    ways = [(n.args[1], on & (choice > 0)), (n.args[2], on & (choice < 0))]
            for a, way in ways:
                active[a] = active[a] | way if a in active else way
        mixed = np.random.default_rng(0).integers(-(2**62), 2**62, (self.count, 1))
        keys = (np.nan_to_num(rows).astype(np.int64) * mixed).sum(axis=0)
        different, first, which = np.unique(keys, return_index=True, return_inverse=True)
        with self._lock:
            for key, i in zip(different.tolist(), first, strict=True):
                if key not in self._known:
                    self._known[key] = len(self._rows)
                    self._rows = np.concatenate([self._rows, rows[None, :, i]])
            found = np.array([self._known[key] for key in different.tolist()])
        numbers[:] = found[which.ravel()]


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


def _chosen(n: Node, args: list[Any], choice: Floats) -> Any:
    """The value of a switch whose choice is held."""
    match n.op:
        case "max" | "min":
            return np.where(choice > 0, args[0], args[1])
        case "abs":
            return args[0] * choice
        case "select":
            return np.where(choice > 0, args[1], args[2])
        case "mod":
            return args[0] - args[1] * choice
        case _:
            return choice
