"""Frames: every `at(f, qx, qy, qz)` replaced by f with its coordinates substituted.

A node is placed once per frame it is seen from, and a frame counts only the coordinates that the node depends on, so
that a chain of nested transforms costs no more than the graph it results in. The fields of a task are whole: they are
seen from where they were written, whatever frame reads the task.
"""

from __future__ import annotations

from collections.abc import Sequence

from porelang.diagnostics import fail
from porelang.ir import X_AXIS, Y_AXIS, Z_AXIS, Node, X, Y, Z, node

Frame = tuple[Node, Node, Node]
HERE: Frame = (X, Y, Z)
#: More operations than this are not a design but an accident (a doubling of a doubling ...).
MOST_NODES = 300_000


def place(roots: Sequence[Node], known: dict[tuple[Node, Frame], Node] | None = None) -> list[Node]:
    """The graph without `at` nodes; `known` are nodes that were placed before, and is added to."""
    done: dict[tuple[Node, Frame], Node] = {} if known is None else known
    for root in roots:
        _place(root, done)
    return [done[_seen(root, HERE)] for root in roots]


def _seen(n: Node, frame: Frame) -> tuple[Node, Frame]:
    """A node and the part of a frame that it can tell apart."""
    return n, (
        frame[0] if n.axes & X_AXIS else X,
        frame[1] if n.axes & Y_AXIS else Y,
        frame[2] if n.axes & Z_AXIS else Z,
    )


def _place(root: Node, done: dict[tuple[Node, Frame], Node]) -> None:
    stack = [_seen(root, HERE)]
    while stack:
        key = stack[-1]
        if key in done:
            stack.pop()
            continue
        if len(done) > MOST_NODES:
            raise fail(
                "E070",
                f"the program grows to more than {MOST_NODES:,} operations",
                hint="a transform of a transform doubles its content each time; use `repeat` or fewer levels",
            )
        n, frame = key
        inputs = [_seen(a, frame) for a in (n.args[1:] if n.op == "at" else n.args)]
        if n.op == "at" and all(i in done for i in inputs):
            qx, qy, qz = (done[i] for i in inputs)
            inputs.append(_seen(n.args[0], (qx, qy, qz)))
        missing = [i for i in inputs if i not in done]
        if missing:
            stack.extend(missing)
            continue
        if n.op == "at":
            done[key] = done[inputs[-1]]
        elif n.op in ("x", "y", "z"):
            done[key] = frame[("x", "y", "z").index(n.op)]
        else:
            done[key] = node(n.op, *(done[i] for i in inputs), value=n.value)
        stack.pop()
