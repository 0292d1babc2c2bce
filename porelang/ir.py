"""The intermediate representation: a directed acyclic graph of scalar operations, each distinct one made once.

A program is a set of named roots. Every node is one scalar (a real number or a truth value) that may vary in space.
Nodes are hash-consed: two nodes with the same operation and arguments are the same object, so equality is identity,
a common subexpression is shared by construction, and every pass is linear in the number of distinct nodes.

What a node knows without being evaluated: its `stage` (const < uniform < field) and its `axes`, the set of
coordinates it depends on. What an operation *means* is written in `porelang.ops`, and nowhere else.

Three operations are structural and are gone after the first passes: `at(f, qx, qy, qz)` is f evaluated at the point q,
`d(f)` with value 0, 1 or 2 is the partial derivative of f along an axis, `ensure(f, ok)` is f with a contract.
`REDUCTIONS` are numbers found from whole fields (a porosity, a volume); the pass `stages` turns each into a param that
is computed before what needs it.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from weakref import WeakValueDictionary

Value = float | int | bool | str | None
X_AXIS, Y_AXIS, Z_AXIS, PARAM = 1, 2, 4, 8
ALL_AXES = 7
REDUCTIONS = ("porosity", "volume", "area", "minimum", "maximum", "mean", "to_porosity", "shell_to_porosity", "solve")


class Stage(IntEnum):
    """When a node's value is known: at compile time, once the params are set, or only at a point."""

    CONST = 0
    UNIFORM = 1
    FIELD = 2


@dataclass(frozen=True, slots=True, eq=False, repr=False, weakref_slot=True)
class Node:
    """One operation of the graph. Make nodes with `node`, `const` and the operators, never directly.

    `depends` is a set of bits: the three axes, and `PARAM` where a param is read.
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
    depends = _depends(op, args)
    with _lock:
        found = _nodes.get(key)
        if found is None:
            found = Node(op, args, value, depends)
            _nodes[key] = found
        return found


def _depends(op: str, args: tuple[Node, ...]) -> int:
    if not args:
        return _LEAVES[op]
    if op in REDUCTIONS:
        return PARAM
    if op == "at":  # the field's own coordinates are replaced by those of the point, where it reads them
        field, *point = args
        bits = field.depends & PARAM
        args = tuple(q for i, q in enumerate(point) if field.depends >> i & 1)
    else:
        bits = 0
    for a in args:
        bits |= a.depends
    return bits


def const(value: float | bool) -> Node:
    """A constant: a real number, or a truth value if given a bool."""
    return node("const", value=value if isinstance(value, bool) else float(value))


def lift(value: Node | float) -> Node:
    return value if isinstance(value, Node) else const(value)


def param(name: str) -> Node:
    return node("param", value=name)


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


def rebuild(roots: Mapping[str, Node], step: Callable[[Node], Node]) -> dict[str, Node]:
    """The graph with `step` applied to every node, arguments first."""
    new: dict[Node, Node] = {}
    for n in order(roots.values()):
        args = tuple(new[a] for a in n.args)
        same = all(a is b for a, b in zip(args, n.args, strict=True))
        new[n] = step(n if same else node(n.op, *args, value=n.value))
    return {name: new[root] for name, root in roots.items()}


def show(roots: Mapping[str, Node], note: Callable[[Node], str] | None = None) -> str:
    """The graph as text, a line a node: `%4 = sin_turns %3`, roots last."""
    names: dict[Node, str] = {}
    lines: list[str] = []
    for n in order(roots.values()):
        if n.op == "const":
            names[n] = str(n.value).lower() if isinstance(n.value, bool) else repr(n.value)
            continue
        if n.op in ("x", "y", "z", "param"):
            names[n] = n.op if n.op != "param" else f"${n.value}"
            continue
        names[n] = f"%{len(lines)}"
        payload = "" if n.value is None else f".{n.value}"
        text = f"{names[n]} = {n.op}{payload} {', '.join(names[a] for a in n.args)}"
        lines.append(f"{text:<44} ; {note(n)}" if note else text)
    lines.extend(f"{name} = {names[root]}" for name, root in roots.items())
    return "\n".join(lines)
