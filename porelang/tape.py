"""The tape: a graph lowered once, for all its roots, to a straight list of operations; what every evaluator reads.

A position of the tape holds one value: the result of an operation on values of earlier positions, a constant, a
coordinate, or a *slot*: a param, an unknown, or a task (a number found from fields, a loaded grid). Slots have values
only when they are bound (`porelang.formula`), so a tape is lowered once, whatever is set or loaded later, and a shader
made of it keeps its text. The fields that a task looks into are no part of the tape: they have tapes of their own.

An operation with several results (the nearest bar: its distance, its direction) is one position, and each result that
the graph uses is a `pick` from it: one walk through the data finds them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

from porelang.ir import ALL_AXES, SLOTS, Node, Stage, Value, node, order, within
from porelang.ops import TABLE, Kind, kind

AXES = {"x": 0, "y": 1, "z": 2}
PICK = "pick"
#: Tapes that are kept: a `solve` asks for the same one many times.
_KEPT = 128


@dataclass(frozen=True, eq=False)
class Tape:
    """Operations in order, arguments first. All tuples have an item for each position.

    `ops` are names from the table of operations, `const`, `x`, `y`, `z`, `pick` or a slot's (`param`, `unknown`, a
    task's); `inputs` are positions; `values` are what the node holds besides its arguments: a constant, a payload, of a
    pick the name of the result, of a walk the names of all that are picked. `nodes` are those of the graph, for whoever
    needs one; a walk has one of its own. `roots` are positions.
    """

    ops: tuple[str, ...]
    inputs: tuple[tuple[int, ...], ...]
    values: tuple[Value, ...]
    nodes: tuple[Node, ...]
    kinds: tuple[Kind, ...]
    roots: tuple[int, ...]

    def __repr__(self) -> str:
        return f"<tape of {len(self)} operations>"

    def __len__(self) -> int:
        return len(self.ops)

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """The coordinates that each position depends on, as a set of bits."""
        return tuple(n.depends & ALL_AXES for n in self.nodes)

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """When the value of each position is known."""
        return tuple(n.stage for n in self.nodes)

    @cached_property
    def slots(self) -> tuple[int, ...]:
        """The positions that are bound from outside, in order."""
        return tuple(i for i, op in enumerate(self.ops) if op in SLOTS)

    @cached_property
    def choices(self) -> frozenset[int]:
        """The positions of choices that settings decide, so that one branch alone is read."""
        positions = (i for i, op in enumerate(self.ops) if op == "select")
        return frozenset(i for i in positions if self.stages[self.inputs[i][0]] is not Stage.FIELD)

    @cached_property
    def position(self) -> dict[Node, int]:
        """Where a node stands."""
        return {n: i for i, n in enumerate(self.nodes)}

    @cached_property
    def last(self) -> tuple[int, ...]:
        """The last position that reads each: beyond the end of the tape for a root."""
        out = list(range(len(self)))
        for i, inputs in enumerate(self.inputs):
            for a in inputs:
                out[a] = i
        for root in self.roots:
            out[root] = len(self)
        return tuple(out)

    @cached_property
    def dying(self) -> tuple[tuple[int, ...], ...]:
        """Of each position the earlier ones that nobody reads after it."""
        out: list[list[int]] = [[] for _ in self.ops]
        for a, i in enumerate(self.last):
            if a < i < len(self):
                out[i].append(a)
        return tuple(tuple(d) for d in out)

    @cached_property
    def frontier(self) -> tuple[int, ...]:
        """The positions known before any point that a field position reads, and roots that are no fields."""
        found: dict[int, None] = {}
        for i, inputs in enumerate(self.inputs):
            if self.stages[i] is Stage.FIELD:
                found.update((a, None) for a in inputs if self.stages[a] is not Stage.FIELD)
        found.update((r, None) for r in self.roots if self.stages[r] is not Stage.FIELD)
        return tuple(sorted(found))

    @cached_property
    def field(self) -> tuple[int, ...]:
        """The positions of operations that run at every point, in order."""
        return tuple(i for i, s in enumerate(self.stages) if s is Stage.FIELD and self.inputs[i])


def lower(roots: Sequence[Node]) -> Tape:
    """The tape of flat roots (no `at`, `d` or `ensure` is left); the same roots give the same tape."""
    return _lowered(tuple(roots))


@lru_cache(maxsize=_KEPT)
def _lowered(roots: tuple[Node, ...]) -> Tape:
    ops: list[str] = []
    inputs: list[tuple[int, ...]] = []
    values: list[Value] = []
    nodes: list[Node] = []
    kinds: list[Kind] = []
    place: dict[Node, int] = {}

    def put(op: str, args: tuple[int, ...], value: Value, n: Node) -> int:
        ops.append(op)
        inputs.append(args)
        values.append(value)
        nodes.append(n)
        kinds.append(kind(n))
        return len(ops) - 1

    listed = order(roots, within)
    picked: dict[Node, set[str]] = {}
    for n in listed:
        if n.op in TABLE and TABLE[n.op].results:
            picked.setdefault(node(n.op, *n.args), set()).add(str(n.value))
    for n in listed:
        args = tuple(place[a] for a in within(n))
        results = TABLE[n.op].results if n.op in TABLE else ()
        if not results:
            place[n] = put(n.op, args, n.value, n)
            continue
        walk = node(n.op, *n.args)
        if walk not in place:
            place[walk] = put(n.op, args, tuple(r for r in results if r in picked[walk]), walk)
        place[n] = put(PICK, (place[walk],), n.value, n)
    last = tuple(place[r] for r in roots)
    return Tape(tuple(ops), tuple(inputs), tuple(values), tuple(nodes), tuple(kinds), last)


def operations(roots: Sequence[Node]) -> int:
    """How many operations it takes to evaluate roots."""
    return len(lower(roots))
