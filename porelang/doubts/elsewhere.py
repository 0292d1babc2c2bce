"""Where what is read beyond samples counts: where other values there would change what is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.sampled import Points, sampler
from porelang.data import SampledField
from porelang.formula import Bindings
from porelang.ir import Node, const, node, order, within

LOOKUPS = ("lookup", "lookup_cubic")
#: What is known beyond samples counts where it changes this part of what it would be with the least or the greatest.
_PART = 0.01


@dataclass(frozen=True, slots=True)
class Reading:
    """Fields that are read within a solid, what is bound in them, and the task that reads them: None for a part."""

    fields: tuple[Node, ...]
    body: Node
    bindings: Bindings
    task: Node | None = None


def sources(grid: Node) -> tuple[Node, ...]:
    """The fields that samples were taken of in the program, which are known beyond them too."""
    return grid.args[: {"sample": -2, "blur": -3}[grid.op]] if grid.op in ("sample", "blur") else ()


def counts_of(
    reading: Reading, grid: Node, at: tuple[Node, ...], data: SampledField, points: Points
) -> NDArray[np.bool_]:
    """At which points (n,) other values of some samples, which they may have elsewhere, change what is asked for.

    What was sampled in the program is known elsewhere: there it has to change it by a part of what any other would.
    """
    every = [_changed(reading, grid, at, partial(_extreme, data=data, greatest=greatest)) for greatest in (False, True)]
    now = _values(reading.fields, reading.bindings, points)
    any_other = [_values(changed, reading.bindings, points) for changed in every]
    if now is None or any(other is None for other in any_other):
        return np.zeros(len(points), np.bool_)
    least, greatest = (np.asarray(other) for other in any_other)
    out = np.zeros(len(points), np.bool_)
    for other in (least, greatest):
        out |= (~np.isclose(now, other, rtol=1e-9, atol=1e-12, equal_nan=True)).any(axis=0)
    if fields := sources(grid):
        ends = zip(at, data.origin, data.end, strict=True)
        nearest = tuple(node("min", node("max", c, const(low)), const(high)) for c, low, high in ends)
        ways = (_changed(reading, grid, at, partial(_slope, fields=fields, place=place)) for place in (nearest, at))
        here, there = (_values(way, reading.bindings, points) for way in ways)
        if here is not None and there is not None:
            room = np.maximum(np.abs(least - now), np.abs(greatest - now)).max(axis=1, keepdims=True)
            out &= (~(np.abs(there - here) <= _PART * room)).any(axis=0)
    return out


def _values(roots: Sequence[Node], bindings: Bindings, points: Points) -> Points | None:
    at = sampler(roots, bindings)
    return None if at is None else np.array(at(points))


def _changed(reading: Reading, grid: Node, at: tuple[Node, ...], by: Callable[[Node], Node]) -> list[Node]:
    """Fields with others in the place of what is looked up among some samples."""
    new: dict[Node, Node] = {}
    for n in order(reading.fields, within):
        if n.op in LOOKUPS and n.args == (grid, *at):
            new[n] = by(n)
        else:
            new[n] = node(n.op, *(new.get(a, a) for a in n.args), value=n.value) if within(n) else n
    return [new[root] for root in reading.fields]


def _asked(lookup: Node) -> tuple[int, list[int]]:
    """Which component a lookup reads, and how often it is differentiated along each axis."""
    assert isinstance(lookup.value, tuple)
    component, *slopes = (int(v) for v in lookup.value)
    return component, slopes


def _extreme(lookup: Node, data: SampledField, greatest: bool) -> Node:
    """The least or the greatest that a lookup may find."""
    component, slopes = _asked(lookup)
    least, most = (float(end) for end in (data.values[..., component].min(), data.values[..., component].max()))
    if not any(slopes):
        return const(most if greatest else least)
    steps = float(np.prod([s**k for s, k in zip(data.spacing, slopes, strict=True)]))
    return const((most - least) / steps * (1 if greatest else -1))


def _slope(lookup: Node, fields: Sequence[Node], place: Sequence[Node]) -> Node:
    """What a lookup would find at a place in the fields that were sampled."""
    component, slopes = _asked(lookup)
    field = fields[component]
    for axis, times in enumerate(slopes):
        for _ in range(times):
            field = node("d", field, value=axis)
    return node("at", field, *place) if field.axes else field
