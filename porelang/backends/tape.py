"""A straight run of NumPy calls over values numbered by their node; buffers are used again after their last reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.ir import Node, Stage, node, order
from porelang.ops import TABLE, forms, kind

Values = NDArray[Any]
Shape = tuple[int, ...]
_SPLIT = {"sin_turns": "sine of reduced", "cos_turns": "cosine of reduced"}
_PARTS: dict[str, Callable[..., Any]] = {
    "reduced": forms.reduced,
    "sine of reduced": np.sin,
    "cosine of reduced": np.cos,
}


@dataclass(frozen=True, slots=True)
class Step:
    """One operation of a tape: `registers[register] = values[output] = function(*values[inputs])`."""

    function: Callable[..., Any]
    inputs: tuple[int, ...]
    output: int
    register: int


@dataclass(frozen=True, slots=True)
class Tape:
    """Steps in order, and what each register holds: the axes its buffer spans, and whether it is of truth values."""

    steps: tuple[Step, ...]
    axes: tuple[int, ...]
    boolean: tuple[bool, ...]


def tape(
    nodes: Sequence[Node],
    number: Mapping[Node, int],
    keep: set[Node],
    merge: bool = False,
    args: Callable[[Node], tuple[Node, ...]] = lambda n: n.args,
) -> Tape:
    """Steps for `nodes` in order, with a register free again after its last reader unless it is one of those to keep.

    `number` is where each node's value stands. `merge` gives every register all axes. `args` are a node's arguments.
    """
    last: dict[Node, int] = {}
    for i, n in enumerate(nodes):
        for a in args(n):
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
        steps.append(Step(_form(n), tuple(number[a] for a in args(n)), number[n], register))
        for a in {*args(n)}:
            if last[a] == i and a in place and a not in keep:
                free[(7 if merge else a.axes, kind(a) == "bool")].append(place[a])
    return Tape(tuple(steps), tuple(axes), tuple(boolean))


def run(steps: Sequence[Step], values: list[Any], registers: Sequence[Values]) -> None:
    """Run steps over values, into registers."""
    for step in steps:
        values[step.output] = step.function(*[values[i] for i in step.inputs], out=registers[step.register])


def share_reduction(root: Node) -> dict[Node, Node]:
    """The graph with the sines and cosines of turns split in two, so that both of one argument reduce it once: what
    every node of it becomes."""
    new: dict[Node, Node] = {}
    for n in order([root]):
        args = [new[a] for a in n.args]
        if n.op in _SPLIT and n.stage is Stage.FIELD:
            new[n] = node(_SPLIT[n.op], node("reduced", *args))
        else:
            new[n] = node(n.op, *args, value=n.value)
    return new


def _form(n: Node) -> Callable[..., Any]:
    return _PARTS[n.op] if n.op in _PARTS else TABLE[n.op].numpy
