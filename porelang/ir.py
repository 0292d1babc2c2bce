"""The intermediate representation: a directed acyclic graph of scalar operations, each distinct one made once.

A program is a set of named roots. Every node is one scalar (a real number or a truth value) that may vary in space.
Nodes are hash-consed: two nodes with the same operation and arguments are the same object, so equality is identity,
a common subexpression is shared by construction, and every pass is linear in the number of distinct nodes.

What a node knows without being evaluated: its `stage` (const < uniform < field) and its `axes`, the set of
coordinates it depends on. What an operation *means* is written in `porelang.ops`, and nowhere else.

Three operations are structural and are gone after the first passes: `at(f, qx, qy, qz)` is f evaluated at the point q,
`d(f)` with value 0, 1 or 2 is the partial derivative of f along an axis, `ensure(f, ok)` is f with a contract.

`param` and `unknown` (what a `solve` looks for, by how many surround it) are read from outside. So are *tasks*
(`porelang.ops.tasks`): a porosity, a loaded grid, computed before the fields that read them. Their arguments are whole
fields; for what lies above, a task is a leaf, known once the params are set. These three are the *slots* of a graph.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from weakref import WeakValueDictionary

Value = float | int | bool | str | tuple[str | int | float, ...] | None
X_AXIS, Y_AXIS, Z_AXIS, PARAM, UNKNOWN = 1, 2, 4, 8, 16  # the unknown of a `solve` within n others: UNKNOWN << n
ALL_AXES = 7
#: What is computed before a field; `porelang.ops.tasks` says of each what it takes and gives.
NUMBERS = ("porosity", "volume", "area", "minimum", "maximum", "mean", "to_porosity", "shell_to_porosity", "solve",
           "of_study", "min_wall")  # fmt: skip
DATA = ("load", "sample", "blur", "frame", "cell", "truss", "phase", "mesh", "study", "bound")
TASKS = frozenset({*NUMBERS, *DATA})
SLOTS = TASKS | {"param", "unknown"}


class Stage(IntEnum):
    """When a node's value is known: at compile time, once the params are set, or only at a point."""

    CONST = 0
    UNIFORM = 1
    FIELD = 2


@dataclass(frozen=True, slots=True, eq=False, repr=False, weakref_slot=True)
class Node:
    """One operation of the graph. Make nodes with `node`, `const` and the operators, never directly.

    `depends` is a set of bits: the three axes, `PARAM` where a param is read or a task, and a bit for each unknown.
    """

    op: str
    args: tuple[Node, ...]
    value: Value
    depends: int

    @property
    def axes(self) -> int:
        """The coordinates that this node depends on, as a set of bits."""
        return self.depends & ALL_AXES

    @property
    def stage(self) -> Stage:
        """When the value of this node is known."""
        return Stage.FIELD if self.depends & ALL_AXES else Stage.UNIFORM if self.depends else Stage.CONST

    def __add__(self, other: Node | float) -> Node:
        return node("add", self, lift(other))

    def __radd__(self, other: float) -> Node:
        return node("add", lift(other), self)

    def __sub__(self, other: Node | float) -> Node:
        return node("sub", self, lift(other))

    def __rsub__(self, other: float) -> Node:
        return node("sub", lift(other), self)

    def __mul__(self, other: Node | float) -> Node:
        return node("mul", self, lift(other))

    def __rmul__(self, other: float) -> Node:
        return node("mul", lift(other), self)

    def __truediv__(self, other: Node | float) -> Node:
        return node("div", self, lift(other))

    def __rtruediv__(self, other: float) -> Node:
        return node("div", lift(other), self)

    def __neg__(self) -> Node:
        return node("neg", self)

    def __repr__(self) -> str:
        return f"<{self.op}{'' if self.value is None else f' {self.value}'} of {len(self.args)}>"

    def __reduce__(self) -> tuple[Callable[[Rows], Node], tuple[Rows]]:
        """Pickled as rows, however deep it is; what comes back is the node itself, in another process too."""
        return _last, (rows([self]),)


_nodes: WeakValueDictionary[tuple[object, ...], Node] = WeakValueDictionary()
_lock = threading.Lock()
_LEAVES = {"const": 0, "param": PARAM, "x": X_AXIS, "y": Y_AXIS, "z": Z_AXIS}


def node(op: str, *args: Node, value: Value = None) -> Node:
    """The node of this operation and arguments: the existing one, if there is one."""
    payload: object = struct.pack("<d", value) if isinstance(value, float) else value
    key = (op, payload, *map(id, args))  # ids are safe: a node keeps its arguments alive
    found = _nodes.get(key)
    if found is not None:
        return found
    depends = _depends(op, args, value)
    with _lock:
        found = _nodes.get(key)
        if found is None:
            found = Node(op, args, value, depends)
            _nodes[key] = found
        return found


def _depends(op: str, args: tuple[Node, ...], value: Value) -> int:
    if op in TASKS:
        bits = PARAM  # known once the params are set; its fields are whole: their coordinates are bound
        for a in args:
            bits |= a.depends & ~ALL_AXES
        return bits & ~(UNKNOWN << value) if op == "solve" and isinstance(value, int) else bits
    if op == "unknown":
        assert isinstance(value, int)
        return UNKNOWN << value
    if not args:
        return _LEAVES[op]
    if op == "at":  # the field's own coordinates are replaced by those of the point, where it reads them
        field, *point = args
        bits = field.depends & ~ALL_AXES
        args = tuple(q for i, q in enumerate(point) if field.depends >> i & 1)
    else:
        bits = 0
    for a in args:
        bits |= a.depends
    return bits


def const(value: float | bool) -> Node:
    """A constant: a real number, or a truth value if given a bool."""
    return node("const", value=value if isinstance(value, bool) else float(value))


def constant(n: Node) -> float | bool:
    """What a `const` node holds, to the sign of a zero."""
    assert isinstance(n.value, float | bool)
    return n.value


def lift(value: Node | float) -> Node:
    return value if isinstance(value, Node) else const(value)


def param(name: str) -> Node:
    return node("param", value=name)


def unknown(level: int) -> Node:
    """What a `solve` looks for that stands within `level` others."""
    return node("unknown", value=level)


X, Y, Z = node("x"), node("y"), node("z")
ZERO, ONE = const(0.0), const(1.0)
TRUE, FALSE = const(True), const(False)


def is_const(n: Node, value: float | None = None) -> bool:
    """Whether a node is a constant (equal to `value`, if given)."""
    return n.op == "const" and (value is None or n.value == value)


def order(roots: Iterable[Node], into: Callable[[Node], Iterable[Node]] | None = None) -> list[Node]:
    """All nodes below the roots, arguments first, each once; `into` can narrow which arguments are followed."""
    done: set[Node] = set()
    out: list[Node] = []
    for root in roots:
        if root in done:
            continue
        stack: list[tuple[Node, Iterator[Node]]] = [(root, iter(into(root) if into else root.args))]
        done.add(root)
        while stack:
            top, rest = stack[-1]
            for a in rest:
                if a not in done:
                    done.add(a)
                    stack.append((a, iter(into(a) if into else a.args)))
                    break
            else:
                stack.pop()
                out.append(top)
    return out


#: Which arguments of a node are followed.
Into = Callable[["Node"], "tuple[Node, ...]"]


def whole(n: Node) -> tuple[Node, ...]:
    """All arguments of a node, the fields of tasks too."""
    return n.args


def rebuild(
    roots: Sequence[Node], step: Callable[[Node], Node], into: Into = whole, known: dict[Node, Node] | None = None
) -> list[Node]:
    """The graph with `step` applied to every node, arguments first; what `into` does not follow stays as it is. `known`
    are nodes that the same step was applied to before, and is added to."""
    new: dict[Node, Node] = {} if known is None else known
    for n in order(roots, into if known is None else lambda n: () if n in new else into(n)):
        if n in new:
            continue
        args = tuple(new[a] for a in into(n))
        same = all(a is b for a, b in zip(args, n.args, strict=False))
        new[n] = step(n if same else node(n.op, *args, value=n.value))
    return [new[root] for root in roots]


def substitute(roots: Sequence[Node], by: Mapping[Node, Node]) -> list[Node]:
    """A flat graph with some nodes replaced; below those, and within tasks, it stays as it is."""
    new: dict[Node, Node] = {}
    for n in order(roots, lambda n: () if n in by else within(n)):
        if n in by:
            new[n] = by[n]
        else:
            new[n] = node(n.op, *(new[a] for a in n.args), value=n.value) if within(n) else n
    return [new[root] for root in roots]


def within(n: Node) -> tuple[Node, ...]:
    """The arguments of a node, but not the fields that a task looks into: what evaluates a graph stops there."""
    return () if n.op in TASKS else n.args


def unmoved(n: Node) -> Node:
    """What a node is that is seen from elsewhere: moved, turned or scaled."""
    while n.op == "at":
        n = n.args[0]
    return n


#: Nodes as rows, arguments first: operation, value, and the rows of its arguments.
Rows = tuple[tuple[str, Value, tuple[int, ...]], ...]


def rows(roots: Iterable[Node]) -> Rows:
    """All nodes below the roots as rows, to be written or sent; of a single root it is the last."""
    number: dict[Node, int] = {}
    out: list[tuple[str, Value, tuple[int, ...]]] = []
    for n in order(roots):
        number[n] = len(out)
        out.append((n.op, n.value, tuple(number[a] for a in n.args)))
    return tuple(out)


def from_rows(listed: Rows) -> list[Node]:
    """The nodes of rows, each the one that this process has."""
    made: list[Node] = []
    for op, value, args in listed:
        made.append(node(op, *(made[i] for i in args), value=value))
    return made


def _last(listed: Rows) -> Node:
    return from_rows(listed)[-1]


def show(roots: Mapping[str, Node], note: Callable[[Node], str] | None = None) -> str:
    """The graph as text, a line a node: `%4 = sin_turns %3`, roots last."""
    names: dict[Node, str] = {}
    lines: list[str] = []
    for n in order(roots.values()):
        if n.op == "const":
            names[n] = str(n.value).lower() if isinstance(n.value, bool) else repr(n.value)
            continue
        if not n.args and n.op not in TASKS:
            names[n] = {"param": f"${n.value}", "unknown": f"?{n.value}"}.get(n.op, n.op)
            continue
        names[n] = f"%{len(lines)}"
        value = (
            n.value[:1] + n.value[2:] if n.op in ("load", "frame", "mesh") and isinstance(n.value, tuple) else n.value
        )
        value = (str(value[0])[:8],) if n.op == "bound" and isinstance(value, tuple) else value
        if n.op == "cell" and isinstance(value, tuple):  # a name, a file and where it lies, or the ends of bars
            value = (value[0] or f"{len(value) // 6} bars",)
        text = f"{names[n]} = {n.op}{_payload(value)} {', '.join(names[a] for a in n.args)}".rstrip()
        lines.append(f"{text:<44} ; {note(n)}" if note else text)
    lines.extend(f"{name} = {names[root]}" for name, root in roots.items())
    return "\n".join(lines)


def _payload(value: Value) -> str:
    if value is None:
        return ""
    return f".{'.'.join(map(str, value))}" if isinstance(value, tuple) else f".{value}"
