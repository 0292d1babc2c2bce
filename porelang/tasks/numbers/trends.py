"""Whether a number only rises or only falls with what a `solve` looks for, proven by the signs of slopes.

A volume falls where the field of its solid rises everywhere, a porosity rises with it, and so on; a formula of such
numbers goes the way that all of them push it. Where ways differ, or a slope changes its sign, nothing is proven.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from porelang.analysis.enclose import EXACT, enclose, everywhere
from porelang.formula import Bindings, Formula, Slot
from porelang.interval import interval
from porelang.ir import DATA, TASKS, Node, order, within
from porelang.ops import TABLE
from porelang.rewrites.gradient import derivative_by
from porelang.rewrites.simplify import tidy

#: How a number goes with each field that it is found from; by the others it goes as is not known.
_WITH: Mapping[str, tuple[int, ...]] = {
    "volume": (-1,),
    "porosity": (1,),
    "minimum": (1,),
    "maximum": (1,),
    "mean": (1,),
    "to_porosity": (1, -1),
    "shell_to_porosity": (0, -1),
}
_LEAST: Mapping[str, float] = {"volume": 0.0, "area": 0.0, "porosity": 0.0, "shell_to_porosity": 0.0, "min_wall": 0.0}
_MOST: Mapping[str, float] = {"porosity": 1.0}
#: What is known of a number that is yet to be found, where no more is.
_FARTHEST = 1e30


def trend(root: Node, sought: Node, low: float, high: float, bindings: Bindings) -> int:
    """1 where a flat root never falls as `sought` goes from `low` to `high`, at no point of space, -1 where it never
    rises; 0 where nothing is proven."""
    known: dict[Node, Slot] = {**bindings, sought: interval(low, high)}
    signs = {s for s in _pushes(root, sought, low, high, known) if s is not None}
    return signs.pop() if len(signs) == 1 else 0


def _pushes(root: Node, sought: Node, low: float, high: float, known: dict[Node, Slot]) -> list[int | None]:
    """The ways in which a root is pushed by all that it reads and that depends on what is sought; None for none."""
    read = [n for n in order([root], within) if n.op in TASKS or n is sought]
    moved = [n for n in read if n is sought or n.depends & sought.depends]
    for n in read:
        if n.op in TASKS and n not in known:
            known[n] = None if n.op in DATA else interval(_LEAST.get(n.op, -_FARTHEST), _MOST.get(n.op, _FARTHEST))
    if _may_jump(root, moved, known):
        return [0]
    return [_pushed(root, n, known, 1 if n is sought else _of_task(n, sought, low, high, known)) for n in moved]


def _of_task(n: Node, sought: Node, low: float, high: float, known: dict[Node, Slot]) -> int:
    """How a number goes with what is sought."""
    ways = _WITH.get(n.op, ())
    signs = set()
    for i, field in enumerate(n.args):
        if field.depends & sought.depends:
            way = ways[i] if i < len(ways) else 0
            pushes = {p for p in _pushes(field, sought, low, high, known) if p is not None} if way else {0}
            signs |= {way * p for p in pushes}
    return signs.pop() if len(signs) == 1 else 0


def _pushed(root: Node, slot: Node, known: dict[Node, Slot], way: int) -> int | None:
    """The way in which a root goes with a slot, times the way of the slot; None if it does not depend on it."""
    (slope,) = tidy([derivative_by(root, slot)])
    if not way:
        return None if slope.op == "const" and slope.value == 0.0 else 0
    r = enclose(Formula((slope,), known), everywhere(), EXACT)[0].range
    if bool((r.nan | r.empty).any()):
        return 0
    least, most = float(r.lo.min()), float(r.hi.max())
    return None if least == most == 0 else way if least >= 0 else -way if most <= 0 else 0


def one_way(root: Node, slot: Node, low: float, high: float, bindings: Bindings) -> bool:
    """Whether a flat root is proven to rise or to fall throughout, at each point of space, as a slot that it reads goes
    from `low` to `high`."""
    known: dict[Node, Slot] = {**bindings, slot: interval(low, high)}
    return not _may_jump(root, [slot], known) and _pushed(root, slot, known, 1) != 0


def _may_jump(root: Node, moved: list[Node], known: dict[Node, Slot]) -> bool:
    """Whether an operation on something that depends on what is moved may jump there."""
    doubtful: list[Node] = []
    follows = set(moved)
    for n in order([root], within):
        if n in follows or not any(a in follows for a in within(n)):
            continue
        follows.add(n)
        row = TABLE.get(n.op)
        decided = n.args[:1] if n.op == "select" else n.args
        if row is not None and row.jumps is not None and any(a in follows for a in decided):
            doubtful.append(n)
    found = enclose(Formula(tuple(doubtful), known), everywhere()) if doubtful else []
    return any(bool(np.any(e.jumps)) for e in found)
