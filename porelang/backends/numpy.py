"""The NumPy backend, in float64 and float32: the living definition of what a graph means.

Points are evaluated in pieces that stay in the cache. On a grid every node is computed on the axes it depends on and no
others: what depends on one or two coordinates is computed once for the whole grid, what depends on three tile by
tile, in
buffers that are reused as soon as their last reader has run. NumPy releases the interpreter, so tiles run on threads.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from porelang.backends.uniform import take_branches, uniform_values
from porelang.ir import Node, Stage, node, order
from porelang.ops import TABLE, forms, kind

Dtype = Literal["f32", "f64"]
TYPES: dict[str, type[np.float32] | type[np.float64]] = {"f32": np.float32, "f64": np.float64}
Item = TypeVar("Item")
Values = NDArray[Any]
Shape = tuple[int, ...]
#: Elements of a piece: its dozen buffers fit the second-level cache.
PIECE = 1 << 15
TILE = 1 << 17
#: Planes kept for a whole grid may take this many bytes; beyond it they are computed tile by tile.
PLANES = 1 << 29
_AXIS = {"x": 0, "y": 1, "z": 2}
_SPLIT = {"sin_turns": "sine of reduced", "cos_turns": "cosine of reduced"}
_PARTS: dict[str, Callable[..., Any]] = {
    "reduced": forms.reduced,
    "sine of reduced": np.sin,
    "cosine of reduced": np.cos,
}


@dataclass(frozen=True, slots=True)
class Step:
    """One operation of a tape: `registers[output] = function(*values[inputs])`."""

    function: Callable[..., Any]
    inputs: tuple[int, ...]
    output: int
    register: int


@dataclass(frozen=True, slots=True)
class Tape:
    """A straight run of steps over values numbered by their node; registers are reused by liveness."""

    steps: tuple[Step, ...]
    axes: tuple[int, ...]  # of each register: the coordinates its buffer spans
    boolean: tuple[bool, ...]


def workers(threads: int | None) -> int:
    """The number of threads to use: as asked, else as many as this process may run on."""
    if threads is not None:
        return max(1, threads)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def spread(work: Callable[[Item], None], items: Sequence[Item], threads: int) -> None:
    """Work on every item, on as many threads as that, without NumPy's warnings."""

    def quiet(item: Item) -> None:
        with np.errstate(all="ignore"):
            work(item)

    if threads == 1 or len(items) < 2:
        for item in items:
            quiet(item)
        return
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(quiet, items):  # what went wrong on a thread is raised here
            pass


def _tape(nodes: Sequence[Node], number: Mapping[Node, int], keep: set[Node], merge: bool) -> Tape:
    """Steps for `nodes` in order, with a register free again after its last reader; `merge` ignores axes."""
    last: dict[Node, int] = {}
    for i, n in enumerate(nodes):
        for a in n.args:
            last[a] = i
    free: dict[tuple[int, bool], list[int]] = {}
    place: dict[Node, int] = {}
    axes: list[int] = []
    boolean: list[bool] = []
    steps: list[Step] = []
    for i, n in enumerate(nodes):
        key = (7 if merge else n.axes, kind(n) == "bool")
        pool = free.setdefault(key, [])
        if pool:
            register = pool.pop()
        else:
            register = len(axes)
            axes.append(key[0])
            boolean.append(key[1])
        place[n] = register
        steps.append(Step(_form(n), tuple(number[a] for a in n.args), number[n], register))
        for a in {*n.args}:
            if last[a] == i and a in place and a not in keep:
                free[(7 if merge else a.axes, kind(a) == "bool")].append(place[a])
    return Tape(tuple(steps), tuple(axes), tuple(boolean))


def _share_reduction(root: Node) -> Node:
    """The sines and cosines of turns split in two, so that both of one argument reduce it once."""
    new: dict[Node, Node] = {}
    for n in order([root]):
        args = [new[a] for a in n.args]
        if n.op in _SPLIT and n.stage is Stage.FIELD:
            new[n] = node(_SPLIT[n.op], node("reduced", *args))
        else:
            new[n] = node(n.op, *args, value=n.value)
    return new[root]


def _form(n: Node) -> Callable[..., Any]:
    return _PARTS[n.op] if n.op in _PARTS else TABLE[n.op].numpy


class NumpyField:
    """A root of a flat graph with its params set, ready to be evaluated.

    Arguments: `root` (real or bool), `params` by name in base units, `dtype` of the computation.
    """

    def __init__(self, root: Node, params: Mapping[str, float], dtype: Dtype = "f64", threads: int | None = None):
        self.dtype = TYPES[dtype]
        self.threads = workers(threads)
        self.root = _share_reduction(take_branches(root, params))
        self.nodes = order([self.root], lambda n: n.args if n.stage is Stage.FIELD else ())
        self.number = {n: i for i, n in enumerate(self.nodes)}
        scalars = [n for n in self.nodes if n.stage is not Stage.FIELD]
        self.scalars = {n: self._scalar(v) for n, v in uniform_values(scalars, params).items()}
        self.boolean = kind(self.root) == "bool"

    def _scalar(self, value: float | bool) -> Any:
        with np.errstate(over="ignore"):
            return np.bool_(value) if isinstance(value, bool) else self.dtype(value)

    @cached_property
    def _points_tape(self) -> Tape:
        return _tape([n for n in self.nodes if n.args and n.axes], self.number, {self.root}, merge=True)

    def at(self, points: Values) -> Values:
        """Values at points of shape (n, 3) in mm, as an array (n,) of the field's type (bool for a condition)."""
        count = len(points)
        out = np.empty(count, np.bool_ if self.boolean else self.dtype)
        columns = [np.ascontiguousarray(points[:, i], dtype=self.dtype) for i in range(3)]
        tape, local = self._points_tape, threading.local()

        def piece(start: int) -> None:
            stop = min(start + PIECE, count)
            if not hasattr(local, "buffers"):
                local.buffers = [np.empty(min(PIECE, count), np.bool_ if b else self.dtype) for b in tape.boolean]
            values: list[Any] = [None] * len(self.nodes)
            for n, i in self.number.items():
                if n in self.scalars:
                    values[i] = self.scalars[n]
                elif n.op in _AXIS:
                    values[i] = columns[_AXIS[n.op]][start:stop]
            registers = [b[: stop - start] for b in local.buffers]
            _run(tape, values, registers)
            out[start:stop] = values[self.number[self.root]]

        spread(piece, range(0, count, PIECE), self.threads)
        return out

    def on_grid(self, axes: Sequence[Values]) -> GridField:
        """The field on the grid of three coordinate axes (mm); what needs fewer than three axes is computed now."""
        return GridField(self, [np.asarray(a, dtype=self.dtype) for a in axes])


class GridField:
    """A field on a grid: any block of it can be computed, by any thread."""

    def __init__(self, field: NumpyField, axes: Sequence[Values]):
        self.field = field
        self.shape: Shape = tuple(len(a) for a in axes)
        self._local = threading.local()
        coordinates = {name: axes[i].reshape(_spanning(1 << i, self.shape)) for name, i in _AXIS.items()}
        nodes = [n for n in field.nodes if n.args and n.axes]
        planes = sum(self._bytes(n) for n in nodes if n.axes.bit_count() == 2)
        widest = 2 if planes <= PLANES else 1
        early = [n for n in nodes if n.axes.bit_count() <= widest]
        late = [n for n in nodes if n.axes.bit_count() > widest]
        needed = {a for n in late for a in n.args} | {field.root}
        self.values: list[Any] = [None] * len(field.nodes)
        for n, i in field.number.items():
            if n in field.scalars:
                self.values[i] = field.scalars[n]
            elif n.op in _AXIS:
                self.values[i] = coordinates[n.op]
        tape = _tape(early, field.number, needed, merge=False)
        buffers = [
            np.empty(_spanning(a, self.shape), np.bool_ if b else field.dtype)
            for a, b in zip(tape.axes, tape.boolean, strict=True)
        ]
        with np.errstate(all="ignore"):
            _run(tape, self.values, buffers)
        self.tape = _tape(late, field.number, {field.root}, merge=False)
        produced = {field.number[n] for n in late}
        self.inputs = [
            (field.number[n], n.axes)
            for n in field.nodes
            if n.axes and field.number[n] not in produced and (n in needed or n is field.root)
        ]

    def _bytes(self, n: Node) -> int:
        return int(np.prod(_spanning(n.axes, self.shape))) * (1 if kind(n) == "bool" else self.field.dtype().itemsize)

    def block(self, lo: Sequence[int], hi: Sequence[int], out: Values | None = None) -> Values:
        """Values at the nodes lo <= (i, j, k) < hi, an array of that shape."""
        shape = tuple(b - a for a, b in zip(lo, hi, strict=True))
        if out is None:
            out = np.empty(shape, np.bool_ if self.field.boolean else self.field.dtype)
        with np.errstate(all="ignore"):
            for cut_lo, cut_hi in _tiles(shape):
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

        spread(work, _tiles(self.shape), self.field.threads)
        return out

    def _tile(self, lo: Sequence[int], hi: Sequence[int], out: Values) -> None:
        values = self.values.copy()
        for i, axes in self.inputs:
            window = tuple(slice(lo[k], hi[k]) if axes >> k & 1 else slice(None) for k in range(3))
            values[i] = values[i][window]
        shape = tuple(b - a for a, b in zip(lo, hi, strict=True))
        registers = self._registers(shape)
        tape, root = self.tape, self.field.number[self.field.root]
        if tape.steps and tape.axes[tape.steps[-1].register] == 7:  # the root is last: it is written in place
            registers = [*registers]
            last = tape.steps[-1]
            _run(Tape(tape.steps[:-1], tape.axes, tape.boolean), values, registers)
            last.function(*(values[i] for i in last.inputs), out=out)
            return
        _run(tape, values, registers)
        out[...] = values[root]

    def _registers(self, shape: Shape) -> list[Values]:
        """This thread's buffers, as views of the shape asked for."""
        cache: dict[Shape, list[Values]] = self._local.__dict__.setdefault("views", {})
        if shape not in cache:
            cache.clear()
            cache[shape] = [
                np.empty(_spanning(a, shape), np.bool_ if b else self.field.dtype)
                for a, b in zip(self.tape.axes, self.tape.boolean, strict=True)
            ]
        return cache[shape]


def _run(tape: Tape, values: list[Any], registers: Sequence[Values]) -> None:
    for step in tape.steps:
        values[step.output] = step.function(*[values[i] for i in step.inputs], out=registers[step.register])


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
