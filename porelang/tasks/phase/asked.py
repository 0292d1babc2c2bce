"""A phase for a period and a part that are formulas."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.ir import X, Y, Z, order
from porelang.tasks.bake import region
from porelang.tasks.phase.find import Fit, find
from porelang.tasks.phase.look import Field

#: Two directions whose angle has a smaller sine are taken for one.
ALONG = 1e-6


def phase_of(
    period: Formula,
    within: Formula,
    free: bool,
    volume: bool = False,
    direction: Formula | None = None,
    cells: Fit | None = None,
) -> SampledField:
    """The phase, in turns, for a field of periods in mm, over the box of a solid; its facts are those of `Got`.

    `period` has one root, or three for the axes of the cells; `free` lets cells turn, or they stand along a
    `direction` (three roots, of any length but 0; six for the first two axes of a frame); `volume` gives up shape for
    size, `cells` says how many there are.
    Errors: E091 and E092 of the solid, and those of `find`.
    """
    box = region(within, "this phase")
    bits = [root.axes for root in period.roots]
    apart = len(bits) == 3 and all(bits[a] & ~(1 << a) == 0 for a in range(3)) and direction is None
    solid = _values(within)
    way = None if direction is None else _unit(_values(direction))
    inside: Field = lambda x, y, z: solid(x, y, z)[0]  # noqa: E731
    axes = functools.reduce(int.__or__, bits)
    return find(_values(period), inside, box.lo, box.hi, free, volume, way, apart, cells, axes, _nodes(period))[0]


def _nodes(fields: Formula) -> list[list[NDArray[Any]]]:
    """Where the nodes of the data lie that fields read at the point itself, along each axis."""
    read = {n.args[0]: fields.bindings.get(n.args[0]) for n in order(fields.roots)
            if n.op in ("lookup", "lookup_cubic") and n.args[1:] == (X, Y, Z)}  # fmt: skip
    return [
        [
            start + step * np.arange(count, dtype=np.float64)
            for start, step, count in zip(g.origin, g.spacing, g.shape, strict=True)
        ]
        for g in read.values()
        if isinstance(g, SampledField)
    ]


def _values(fields: Formula) -> Field:
    """The roots of a formula at points, (roots, ...)."""
    evaluated = NumpyField(fields, "f64")

    def at(x: NDArray[Any], y: NDArray[Any], z: NDArray[Any]) -> NDArray[np.float64]:
        points = np.stack(np.broadcast_arrays(x, y, z), -1)
        values = np.asarray(evaluated.at(points.reshape(-1, 3)), np.float64)
        return np.moveaxis(values.reshape(*points.shape[:-1], -1), -1, 0)

    return at


def _unit(direction: Field) -> Field:
    """A field of directions (3, ...) with the length 1, 0 where there is none; of two (6, ...), the second at right
    angles to the first, in their plane, and 0 where it lies along it."""

    def at(x: NDArray[Any], y: NDArray[Any], z: NDArray[Any]) -> NDArray[np.float64]:
        values = direction(x, y, z)
        first = _of_length_one(values[:3])
        if len(values) == 3:
            return first
        second = _of_length_one(values[3:])
        return np.concatenate([first, _of_length_one(second - (second * first).sum(0) * first, ALONG)])

    return at


def _of_length_one(values: NDArray[Any], least: float = 1e-12) -> NDArray[np.float64]:
    size = np.sqrt((values**2).sum(0))
    known = np.isfinite(size) & (size > least)
    return np.where(known, values, 0.0) / np.where(known, size, 1.0)
