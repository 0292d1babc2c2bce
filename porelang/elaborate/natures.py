"""What is known of a field by how it was made: whether its values are mm, and whether it is a solid at all.

Numbers have dimensions, but shapes and lattices are bare, so that they combine with anything: `sphere(10)` is a
distance in mm, `gyroid(10)` a number from -1.5 to 1.5, and both have no unit. What a function gives stands beside it,
in a line of its documentation, in a user's too:

    ## Gives: a distance            mm, negative inside
    ## Gives: a raw lattice         negative inside, but in units of its own
    ## Gives: as f                  what its argument f is

From there it follows the graph: a moved solid is one, and a lattice that was made thicker still is raw. What cannot be
told is not known, and nothing is doubted about it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from porelang.elaborate.values import Scalar, Value
from porelang.ir import Node, X, Y, Z, constant, order
from porelang.syntax import tree
from porelang.units import RATIO

_GIVES = re.compile(r"a (distance|raw lattice)|as (\w+)")
#: Operations that keep what their first argument is.
_KEPT = frozenset({"neg", "abs", "at", "ensure"})
#: Operations that fold the values of a lattice at its surface, so that they do not pass through 0 there.
_FOLDING = frozenset({"abs", "square", "sqrt", "pow", "hypot"})
#: Tasks whose data are values of their fields.
_SAMPLING = frozenset({"sample", "blur"})
_NOTHING: frozenset[Node] = frozenset()


@dataclass(frozen=True, slots=True)
class Nature:
    """What is known of a field that bounds a solid.

    `raw`: a raw lattice is in it, so that its values are no mm. `total`: it is a sum or a difference of two distances
    (this node), which bounds none of them. `plain`: it is as a function gave it, perhaps moved, and nothing was made of
    it yet. `period` is that of the lattice it is, where that is known. `scaled`: a raw lattice times a number, which is
    a texture where it is added to a distance. `folded`: it is a magnitude, which is 0 at a
    surface and not negative beside. `uneven`: the nodes by which what was made of distances may be none any more.
    """

    raw: bool = False
    total: Node | None = None
    plain: bool = False
    period: Node | None = None
    scaled: bool = False
    folded: bool = False
    uneven: frozenset[Node] = frozenset()


#: What is known of nodes so far; None where it was found that nothing is.
Natures = dict[Node, Nature | None]


def note(known: Natures, definition: tree.Def, arguments: Mapping[str, Value], result: Value) -> Nature | None:
    """Note what a call has given, by the documentation of its function; None where that says nothing."""
    if not isinstance(result, Scalar) or not result.node.axes:
        return None
    fact = _GIVES.fullmatch(definition.fact("Gives") or "")
    if fact is None:
        return None
    if fact[2]:
        given = arguments.get(fact[2])
        same = nature(known, given.node) if isinstance(given, Scalar) else None
        if same is None:
            return None
        own = nature(known, result.node)  # what it does inside says more than that it does something
        by = frozenset() if same.raw else frozenset({result.node}) if own is None or own.raw else own.uneven
        found = replace(same, period=None, uneven=by)
    else:
        w = arguments.get("w")
        raw = fact[1] == "raw lattice"
        period = w.node if raw and isinstance(w, Scalar) and not w.node.axes else None
        found = Nature(raw, None, True, period)
    if found is not None:
        known[result.node] = found
    return found


def note_scaled(known: Natures, op: str, numbers: Sequence[Value], made: Value) -> None:
    """Note that a raw lattice times a bare number, which may vary, is one still; so is one over a number. A distance
    times a number is none any more."""
    if len(numbers) != 2 or not isinstance(made, Scalar) or made.dimension not in (None, RATIO):
        return
    for one, other in (numbers, (numbers[1], numbers[0])) if op == "mul" else (numbers,):
        if not (isinstance(one, Scalar) and isinstance(other, Scalar)) or other.dimension not in (None, RATIO):
            continue  # somebody makes a length of it
        if op == "div" and other.node.axes:
            continue
        lattice, factor = nature(known, one.node), nature(known, other.node)
        if lattice is not None and (factor is None or (lattice.raw and factor.raw)):
            folded = lattice.folded or (factor is not None and (factor.folded or other.node is one.node))
            known.setdefault(made.node, None)
            if known[made.node] is None and (lattice.raw or lattice.total is None):
                uneven = _by(made.node, not lattice.raw)
                known[made.node] = Nature(lattice.raw, None, lattice.raw, None, True, folded, uneven)


def nature(known: Natures, n: Node) -> Nature | None:
    """What is known of a node; None where nothing is."""
    if n not in known:
        for m in order([n], lambda m: () if m in known else _parts(m)):
            if m not in known:
                known[m] = _made(m, [known.get(a) for a in _parts(m)])
    return known[n]


def _parts(n: Node) -> tuple[Node, ...]:
    """The arguments that decide what a node is."""
    if not n.axes:
        return ()
    if n.op in _KEPT or n.op == "pow":
        return n.args[:1]
    if n.op in ("add", "sub", "max", "min", "hypot"):
        return n.args
    if n.op in ("square", "sqrt"):
        return n.args
    if n.op in ("lookup", "lookup_cubic"):
        grid, (component, *orders) = n.args[0], _payload(n)
        return (grid.args[component],) if grid.op in _SAMPLING and not any(orders) else ()
    return n.args[1:] if n.op == "select" else ()


def _payload(n: Node) -> tuple[int, ...]:
    assert isinstance(n.value, tuple)
    return tuple(v for v in n.value if isinstance(v, int))


def _made(n: Node, parts: list[Nature | None]) -> Nature | None:
    if n.op == "select" and n.args[0].op == "covers" and n.args[0].args[0].op == "mesh":  # its samples, and beyond them
        return Nature(plain=True)
    if not parts or all(p is None for p in parts):
        return None
    if n.op in _KEPT:
        (a,) = parts
        assert a is not None
        if n.op == "abs" and a.total is not None:
            return None
        same = n.op in ("at", "ensure")
        folded = n.op == "abs" or a.folded
        uneven = _NOTHING if a.raw else a.uneven | _by(n, n.op == "at" and not moves(n.args[1:]))
        period = None if n.op == "at" else a.period
        return Nature(a.raw, a.total, a.plain and same, period, a.scaled, folded, uneven)
    if len(parts) == 1 or n.op == "hypot":  # of a distance they are numbers to be used as such
        lattice = next((p for p in parts if p is not None and p.raw), None)
        return None if lattice is None else Nature(raw=True, folded=lattice.folded or n.op in _FOLDING)
    a, b = parts
    total = any(p is not None and p.total is not None for p in parts)
    if n.op in ("add", "sub"):
        if a is None or b is None:  # grown, shrunk, or with a texture
            one = a or b
            return None if total or one is None else replace(one, plain=False, folded=False)
        if not (a.raw or b.raw) and (a.scaled or b.scaled) and not total:  # (1 - t) * a + t * b
            return Nature(scaled=True, uneven=_by(n))
        if total or not (a.raw or b.raw):
            return Nature(total=n)
        if a.raw != b.raw and (a.scaled or b.scaled):
            return replace(b if a.raw else a, plain=False)
        if a.raw != b.raw:
            return Nature(uneven=_by(n))
        mixed = a.scaled or b.scaled  # (1 - t) * a + t * b is a lattice as they are
        return Nature(raw=True, plain=mixed, scaled=mixed) if a.raw and b.raw else None
    if total:
        return None
    if a is None or b is None:
        one, other = a or b, n.args[parts.index(None)]
        if n.op == "select" or (not other.axes and not _clamps(n.op, one, other)):
            return None  # a clamped distance, or a share from 0 to 1, is a number to be used as one
        return Nature(one.raw, folded=one.folded, uneven=one.uneven) if one is not None else None
    raw = a.raw or b.raw
    plain, folded = n.op == "select" and a.plain and b.plain, a.folded or b.folded  # the greater of magnitudes is one
    return Nature(raw, plain=plain, folded=folded, uneven=_NOTHING if raw else a.uneven | b.uneven)


def _by(n: Node, uneven: bool = True) -> frozenset[Node]:
    """That it is a node by which a distance may be none any more."""
    return frozenset({n}) if uneven else _NOTHING


def moves(point: Sequence[Node]) -> bool:
    """Whether a point is the one that is looked from, moved by as much everywhere. Whether others are turned, values
    tell."""
    for here, axis in zip(point, (X, Y, Z), strict=True):
        moved = here.op in ("add", "sub") and here.args[0] is axis and not here.args[1].axes
        if here is not axis and not moved:
            return False
    return True


def _clamps(op: str, field: Nature | None, end: Node) -> bool:
    """Whether a raw lattice is held above or below an end beyond its surface, where it is as it was."""
    if field is None or not field.raw or end.op != "const":
        return False
    return constant(end) < 0 if op == "max" else constant(end) > 0
