"""The NumPy backend, in float64 and float32: the living definition of what a graph means.

Points are evaluated in pieces that stay in the cache. On a grid every operation is computed on the axes it depends on
and no others: what depends on one or two coordinates is computed once for the whole grid, what depends on three tile by
tile, in buffers that are reused as soon as their last reader has run. NumPy and the compiled loops that read data
release the interpreter, so tiles run on threads.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from operator import itemgetter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField, Segments
from porelang.formula import Formula, perform
from porelang.ir import Node, Stage, node, order, within
from porelang.ops import TABLE
from porelang.parallel import parallel_for, workers
from porelang.progress import checkpoint
from porelang.tape import AXES, PICK, Tape

Dtype = Literal["f32", "f64"]
TYPES: dict[str, type[np.float32] | type[np.float64]] = {"f32": np.float32, "f64": np.float64}
Values = NDArray[Any]
Shape = tuple[int, ...]
#: Elements of a piece: its dozen buffers fit the second-level cache.
PIECE = 1 << 15
TILE = 1 << 17
#: Planes kept for a whole grid may take this many bytes; beyond it they are computed tile by tile.
PLANES = 1 << 29
_SPLIT = {"sin_turns": "sin", "cos_turns": "cos"}


@dataclass(frozen=True, slots=True)
class Step:
    """One operation: `values[output] = function(*values[inputs])`, into a register; None: it makes its own arrays."""

    function: Callable[..., Any]
    inputs: tuple[int, ...]
    output: int
    register: int | None


@dataclass(frozen=True, slots=True)
class Plan:
    """Positions of a tape in order, with buffers that are reused by liveness."""

    steps: tuple[Step, ...]
    axes: tuple[int, ...]  # of each register: the coordinates its buffer spans
    boolean: tuple[bool, ...]


def _plan(tape: Tape, positions: Sequence[int], keep: Collection[int], merge: bool) -> Plan:
    """Steps for positions in order, with a register free again after its last reader; `merge` ignores axes."""
    last: dict[int, int] = {}
    for step, i in enumerate(positions):
        for a in tape.inputs[i]:
            last[a] = step
    free: dict[tuple[int, bool], list[int]] = {}
    place: dict[int, int] = {}
    axes: list[int] = []
    boolean: list[bool] = []
    steps: list[Step] = []
    for step, i in enumerate(positions):
        register: int | None = None
        if tape.ops[i] != PICK and not TABLE[tape.ops[i]].results:
            key = (7 if merge else tape.axes[i], tape.kinds[i] == "bool")
            pool = free.setdefault(key, [])
            if pool:
                register = pool.pop()
            else:
                register = len(axes)
                axes.append(key[0])
                boolean.append(key[1])
            place[i] = register
        steps.append(Step(_form(tape, i), tape.inputs[i], i, register))
        for a in {*tape.inputs[i]}:
            if last[a] == step and a in place and a not in keep:
                free[(7 if merge else tape.axes[a], tape.kinds[a] == "bool")].append(place[a])
    return Plan(tuple(steps), tuple(axes), tuple(boolean))


def _form(tape: Tape, i: int) -> Callable[..., Any]:
    """The NumPy form of a position's operation, its payload included."""
    value = tape.values[i]
    if tape.ops[i] == PICK:
        wanted = tape.values[tape.inputs[i][0]]
        assert isinstance(wanted, tuple)
        return itemgetter(wanted.index(str(value)))
    row = TABLE[tape.ops[i]]
    if row.results:
        return partial(_walk, row.numpy, value)
    return partial(_with_payload, row.numpy, value) if row.payload else row.numpy


def _walk(form: Callable[..., Any], wanted: Any, *arguments: Any) -> Any:
    return form(*arguments, wanted)


def _with_payload(form: Callable[..., Any], payload: Any, *arguments: Any, out: Any = None) -> Any:
    return form(*arguments, payload, out=out)


def _share_reduction(formula: Formula) -> Formula:
    """The sines and cosines of turns split in two, so that both of one argument reduce it once."""
    nodes = order(formula.roots, within)
    if not any(n.op in _SPLIT for n in nodes):
        return formula
    new: dict[Node, Node] = {}
    for n in nodes:
        args = [new[a] for a in within(n)]
        if n.op in _SPLIT and n.stage is Stage.FIELD:
            new[n] = node(_SPLIT[n.op], node("reduced", *args))
        else:
            new[n] = node(n.op, *args, value=n.value) if args else n
    return formula.with_roots(*(new[r] for r in formula.roots))


class NumpyField:
    """A formula ready to be evaluated in the type `dtype`. Several roots share what they have in common."""

    def __init__(self, formula: Formula, dtype: Dtype = "f64", threads: int | None = None):
        self.dtype = TYPES[dtype]
        self.threads = workers(threads)
        self.formula = _share_reduction(formula.taken)
        self.tape = self.formula.tape
        self.known = {i: self._cast(self.formula.known[i]) for i in self.tape.frontier}
        self.boolean = self.tape.kinds[self.tape.roots[0]] == "bool"

    def _cast(self, value: Any) -> Any:
        """A number that is known before any point, in the type of the computation; data and conditions as they are."""
        if isinstance(value, SampledField | Segments | tuple):
            return value
        if np.asarray(value).dtype == np.bool_:
            return np.bool_(value)
        with np.errstate(over="ignore"):
            return self.dtype(value)

    @cached_property
    def _points_plan(self) -> Plan:
        return _plan(self.tape, self.tape.field, self.tape.roots, merge=True)

    def at(self, points: Values) -> Values:
        """Values at points (n, 3) in mm, in the field's type (bool for a condition): (n,), or (n, k) for k roots."""
        count, tape = len(points), self.tape
        several = len(tape.roots) > 1
        out = np.empty((count, len(tape.roots)) if several else count, np.bool_ if self.boolean else self.dtype)
        plan, local = self._points_plan, threading.local()

        def piece(start: int) -> None:
            stop = min(start + PIECE, count)
            if not hasattr(local, "buffers"):
                local.buffers = [np.empty(min(PIECE, count), np.bool_ if b else self.dtype) for b in plan.boolean]
            values = self._leaves([np.ascontiguousarray(points[start:stop, i], dtype=self.dtype) for i in range(3)])
            _run(plan, values, [b[: stop - start] for b in local.buffers])
            for k, root in enumerate(tape.roots):
                (out[:, k] if several else out)[start:stop] = values[root]

        parallel_for(piece, range(0, count, PIECE), self.threads)
        return out

    def _leaves(self, coordinates: Sequence[Values]) -> list[Any]:
        """A value for each position, of those that need no computing."""
        values: list[Any] = [None] * len(self.tape)
        for i, known in self.known.items():
            values[i] = known
        for i, op in enumerate(self.tape.ops):
            if op in AXES:
                values[i] = coordinates[AXES[op]]
        return values

    def on_grid(self, axes: Sequence[Values]) -> GridField:
        """The field on the grid of three coordinate axes (mm); what needs fewer than three axes is computed now."""
        return GridField(self, [np.asarray(a, dtype=self.dtype) for a in axes])


class GridField:
    """A field (its first root) on a grid: any block of it can be computed, by any thread."""

    def __init__(self, field: NumpyField, axes: Sequence[Values]):
        self.field = field
        self.shape: Shape = tuple(len(a) for a in axes)
        self.root = field.tape.roots[0]
        self._local = threading.local()
        tape = field.tape
        planes = sum(self._bytes(i) for i in tape.field if tape.axes[i].bit_count() == 2)
        widest = 2 if planes <= PLANES else 1
        early = [i for i in tape.field if tape.axes[i].bit_count() <= widest]
        late = [i for i in tape.field if tape.axes[i].bit_count() > widest]
        needed = {a for i in late for a in tape.inputs[i]} | {self.root}
        self.values = field._leaves([a.reshape(_spanning(1 << k, self.shape)) for k, a in enumerate(axes)])
        first = _plan(tape, early, needed, merge=False)
        with np.errstate(all="ignore"):
            _run(first, self.values, self._buffers(first, self.shape))
        self.plan = _plan(tape, late, {self.root}, merge=False)
        made = {*late}
        self.inputs = [
            (i, tape.axes[i])
            for i in range(len(tape))
            if tape.axes[i] and i not in made and (i in needed or i == self.root) and _is_array(self.values[i])
        ]

    def _bytes(self, i: int) -> int:
        tape = self.field.tape
        size = 1 if tape.kinds[i] == "bool" else self.field.dtype().itemsize
        return int(np.prod(_spanning(tape.axes[i], self.shape))) * size

    def _buffers(self, plan: Plan, shape: Shape) -> list[Values]:
        return [
            np.empty(_spanning(a, shape), np.bool_ if b else self.field.dtype)
            for a, b in zip(plan.axes, plan.boolean, strict=True)
        ]

    def block(self, lo: Sequence[int], hi: Sequence[int], out: Values | None = None) -> Values:
        """Values at the nodes lo <= (i, j, k) < hi, an array of that shape."""
        shape = tuple(b - a for a, b in zip(lo, hi, strict=True))
        if out is None:
            out = np.empty(shape, np.bool_ if self.field.boolean else self.field.dtype)
        with np.errstate(all="ignore"):
            for cut_lo, cut_hi in _tiles(shape):
                checkpoint()
                window = tuple(slice(a, b) for a, b in zip(cut_lo, cut_hi, strict=True))
                self._tile(
                    [a + c for a, c in zip(lo, cut_lo, strict=True)],
                    [a + c for a, c in zip(lo, cut_hi, strict=True)],
                    out[window],
                )
        return out

    def all(self) -> Values:
        """Values at every node of the grid, computed on the field's threads."""
        out = np.empty(self.shape, np.bool_ if self.field.boolean else self.field.dtype)

        def work(tile: tuple[Shape, Shape]) -> None:
            window = tuple(slice(a, b) for a, b in zip(*tile, strict=True))
            self._tile(tile[0], tile[1], out[window])

        parallel_for(work, _tiles(self.shape), self.field.threads)
        return out

    def _tile(self, lo: Sequence[int], hi: Sequence[int], out: Values) -> None:
        values = self.values.copy()
        for i, axes in self.inputs:
            window = tuple(slice(lo[k], hi[k]) if axes >> k & 1 else slice(None) for k in range(3))
            values[i] = values[i][window]
        registers = self._registers(tuple(b - a for a, b in zip(lo, hi, strict=True)))
        plan = self.plan
        last = plan.steps[-1] if plan.steps else None
        if (
            last is not None
            and last.register is not None
            and last.output == self.root
            and plan.axes[last.register] == 7
        ):
            _run(Plan(plan.steps[:-1], plan.axes, plan.boolean), values, registers)  # the root is written in place
            last.function(*(values[i] for i in last.inputs), out=out)
            return
        _run(plan, values, registers)
        out[...] = values[self.root]

    def _registers(self, shape: Shape) -> list[Values]:
        """This thread's buffers, as views of the shape asked for."""
        cache: dict[Shape, list[Values]] = self._local.__dict__.setdefault("views", {})
        if shape not in cache:
            cache.clear()
            cache[shape] = self._buffers(self.plan, shape)
        return cache[shape]


def every_position(formula: Formula, points: Values) -> list[Any]:
    """The value of every position of a formula's tape at points (n, 3), in float64, data and constants as they are."""
    tape = formula.tape
    values: list[Any] = [formula.known.get(i) for i in range(len(tape))]
    columns = [np.ascontiguousarray(points[:, i], np.float64) for i in range(3)]
    for i, op in enumerate(tape.ops):
        if op in AXES:
            values[i] = columns[AXES[op]]
        elif i not in formula.known:
            values[i] = perform(tape, i, [values[a] for a in tape.inputs[i]])
    return values


def _is_array(value: Any) -> bool:
    return isinstance(value, np.ndarray)


def _run(plan: Plan, values: list[Any], registers: Sequence[Values]) -> None:
    for step in plan.steps:
        inputs = [values[i] for i in step.inputs]
        if step.register is None:
            values[step.output] = step.function(*inputs)
        else:
            values[step.output] = step.function(*inputs, out=registers[step.register])


def _spanning(axes: int, shape: Shape) -> Shape:
    """The shape of a buffer that varies along `axes` of a grid."""
    return tuple(n if axes >> i & 1 else 1 for i, n in enumerate(shape))


def _tiles(shape: Shape) -> list[tuple[Shape, Shape]]:
    """Tiles of about TILE nodes that cover a block, whole along z where that fits."""
    nz = min(shape[2], TILE)
    ny = min(shape[1], max(1, TILE // nz))
    nx = min(shape[0], max(1, TILE // (nz * ny)))
    step = (nx, ny, nz)
    starts = [range(0, n, s) for n, s in zip(shape, step, strict=True)]
    return [
        (lo, (min(lo[0] + nx, shape[0]), min(lo[1] + ny, shape[1]), min(lo[2] + nz, shape[2])))
        for lo in product(*starts)
    ]
