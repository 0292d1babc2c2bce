"""Every operation of the table, alone, over hard inputs, on a backend, against its exact value.

Both forms of an operation are swept: the general one on arguments that may be anything (infinities and NaN are put in
their place inside the graph), and, where a row has one, the cheaper `guarded` form on arguments that keep to its terms.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F64, Precision
from porelang.conformance.backend import Backend
from porelang.conformance.exact import exact
from porelang.conformance.inputs import CALM, STAND_IN, rows
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import ZERO, Node, X, Y, Z, const, node
from porelang.ops import TABLE, Op

Arrays = list[NDArray[Any]]
#: Random inputs per operation, beside the hard ones in all pairs.
RANDOM = 12_000
#: Numbers of ordinary size, for the errors that are told to people.
ORDINARY = (1e-9, 1e6)
#: A divisor that the cheaper quotient accepts is no smaller than this.
LEAST_DIVISOR = 2.0**-60
LARGEST_DIVISOR = 2.0**126


@dataclass(frozen=True, slots=True)
class Measurement:
    """How one operation did on one backend.

    `use` is the worst part of its tolerance, over all inputs, and `broken` counts those beyond it; `at` is where `use`
    was reached. `ulp` and `absolute` are the worst errors where all numbers are of ordinary size, in numbers and in
    units of the type's epsilon times the result (times at least 1 for sines, times the dividend for a remainder).
    """

    op: str
    backend: str
    form: str
    points: int
    use: float
    ulp: float
    absolute: float
    broken: int
    at: tuple[float, ...]
    got: float
    wanted: float

    @property
    def example(self) -> str:
        """The worst case in words."""
        arguments = ", ".join(f"{a:.9g}" for a in self.at)
        return f"{self.op}({arguments}) is {self.wanted:.9g}, {self.backend} gives {self.got:.9g}"


def sweep(
    backend: Backend, operations: Iterable[str] | None = None, seed: int = 0, count: int = RANDOM
) -> list[Measurement]:
    """Measurements of the operations named (all, if none are), one for each form of each."""
    found = []
    plain = [name for name, row in TABLE.items() if row.args[0] in ("real", "bool") and len(row.args) < 4]
    for name in plain if operations is None else operations:
        row = TABLE[name]
        found.append(_measure(row, backend, "general", seed, count))
        if row.guarded:
            found.append(_measure(row, backend, "guarded", seed, count))
    return found


def _measure(row: Op, backend: Backend, form: str, seed: int, count: int) -> Measurement:
    points = rows(backend.dtype, len(row.args), count, seed)
    if form == "guarded":
        usable = (np.abs(points[:, : len(row.args)]) <= CALM).all(axis=1)
        points = points[usable & ~np.isin(points, list(STAND_IN)).any(axis=1)]
    arguments, root = _graph(row, form, points)
    keep = _within_domain(row, arguments) & _decided(row, points)
    points, arguments = points[keep], [a[keep] for a in arguments]
    got = backend.evaluate(Formula.of(root), points, {}).astype(np.float64)
    return _judge(row, backend, form, arguments, got)


def _graph(row: Op, form: str, points: NDArray[Any]) -> tuple[Arrays, Node]:
    """The graph of one operation over coordinates, and the arguments that the operation gets in it."""
    columns = [points[:, i] for i in range(3)]
    coordinates: list[Node] = [X, Y, Z]
    if form == "guarded":
        if row.calm == "not negative":
            columns[0], coordinates[0] = np.abs(columns[0]), node("abs", X)
        elif row.calm == "divisor":
            columns[1] = np.maximum(np.abs(columns[1]), points.dtype.type(LEAST_DIVISOR))
            coordinates[1] = node("max", node("abs", Y), const(LEAST_DIVISOR))
    else:
        columns = [_opened(c) for c in columns]
        coordinates = [_opening(c) for c in coordinates]
    arguments, inputs = [], []
    for kind, column, coordinate in zip(row.args, columns, coordinates, strict=False):
        arguments.append(column > 0 if kind == "bool" else column)
        inputs.append(node("lt", ZERO, coordinate) if kind == "bool" else coordinate)
    return arguments, node(row.name, *inputs)


def _opened(values: NDArray[Any]) -> NDArray[Any]:
    for stand_in, meant in STAND_IN.items():
        values = np.where(values == stand_in, values.dtype.type(meant), values)
    return values


def _opening(n: Node) -> Node:
    for stand_in, meant in STAND_IN.items():
        n = node("select", node("eq", n, const(stand_in)), const(meant), n)
    return n


def _decided(row: Op, points: NDArray[Any]) -> NDArray[np.bool_]:
    """Where a condition is one: it is made of a coordinate above 0, and a denormal number may count as 0 there."""
    tiny = np.finfo(points.dtype).tiny
    held = [points[:, i] for i, kind in enumerate(row.args) if kind == "bool"]
    return np.all([(c == 0) | ~(np.abs(c) < tiny) for c in held], axis=0) if held else np.ones(len(points), np.bool_)


def _within_domain(row: Op, arguments: Arrays) -> NDArray[np.bool_]:
    """Where the operation is ever used: a direction's divisor is the length of a vector that its argument is part of,
    and one that a shader can divide by (2^126 at most, OpenGL 4.3 core, GLSL 4.7.1); and the parts of a remainder
    neither overflow nor vanish."""
    a, b = (v.astype(np.longdouble) for v in (arguments[0], arguments[-1]))
    with np.errstate(all="ignore"):
        if row.name == "direction":
            return np.asarray(~(np.abs(a) > b) & ~((b > LARGEST_DIVISOR) & np.isfinite(b)))
        if row.name == "mod":
            parts = np.stack([np.abs(a / b), np.abs(a), np.abs(b)])
            wild = ((parts > 1e37) & np.isfinite(parts)).any(axis=0) | ((np.abs(b) < 1e-37) & (b != 0))
            return np.asarray(~wild | np.isinf(a) | np.isinf(b))
    return np.ones(len(a), np.bool_)


def _judge(row: Op, backend: Backend, form: str, arguments: Arrays, got: NDArray[np.float64]) -> Measurement:
    precision = backend.precision
    wide: Any = np.longdouble if precision is F64 else np.float64
    arguments = [a if a.dtype == np.bool_ else a.astype(wide) for a in arguments]
    with np.errstate(all="ignore"):
        uses = []
        for choice in _flushings(arguments, precision):
            for wanted in _answers(row, precision, choice, exact(row.name, *choice).astype(wide)):
                uses.append(_use(row, precision, choice, wanted, got))
        use = np.minimum.reduce(uses)
        wanted = exact(row.name, *arguments).astype(wide)
        answers = _answers(row, precision, arguments, wanted)
        error = np.minimum.reduce([np.abs(got.astype(wide) - answer) for answer in answers])
        ordinary = np.isfinite(wanted) & np.isfinite(got)
        for a in (*(a for a in arguments if a.dtype != np.bool_), wanted):
            ordinary &= (a == 0) | ((np.abs(a) >= ORDINARY[0]) & (np.abs(a) <= ORDINARY[1]))
        error = np.where(ordinary, error, 0.0)
        size = np.abs(wanted)
        if row.tolerance.absolute >= 1:
            size = np.maximum(size, 1.0)
        elif row.name == "mod":
            size = np.maximum(size, np.abs(arguments[0]))
        ulp = np.where(error == 0, 0.0, error / (size * precision.eps))
    worst = int(np.argmax(use))
    return Measurement(
        row.name, backend.name, form, len(got), float(use[worst]), float(ulp.max()), float(error.max()),
        int((use > 1).sum()), tuple(float(a[worst]) for a in arguments), float(got[worst]), float(wanted[worst]),
    )  # fmt: skip


def _answers(row: Op, precision: Precision, arguments: Arrays, wanted: NDArray[Any]) -> Arrays:
    """The exact results; where a remainder's quotient is whole but for rounding, the neighbouring periods' as well."""
    if row.name != "mod":
        return [wanted]
    a, b = arguments
    q, r = a / b, np.fmod(a, b)
    whole = np.abs(q - np.rint(q)) <= 4 * precision.eps * np.abs(q) + precision.tiny
    return [wanted, *(np.where(whole, other, wanted) for other in (r, r + b, r - b))]


def _flushings(arguments: Arrays, precision: Precision) -> list[Arrays]:
    """The arguments, and the same with denormal numbers as zeros: a device may compute with either."""
    options = []
    for a in arguments:
        small = a.dtype != np.bool_ and (np.abs(a) < precision.tiny) & (a != 0)
        options.append([a, np.where(small, np.copysign(0, a), a)] if np.any(small) else [a])
    return [list(choice) for choice in product(*options)]


def _use(row: Op, precision: Precision, arguments: Arrays, wanted: NDArray[Any], got: NDArray[Any]) -> NDArray[Any]:
    """The part of the tolerance that each result uses; infinite where it breaks a rule that has no measure."""
    t = row.tolerance
    width = precision.eps * (t.ulp * np.abs(wanted) + t.absolute)
    if t.extra is not None:
        none = np.zeros(len(got), np.bool_)
        ranges = [Interval(a.astype(np.float64), a.astype(np.float64), none) for a in arguments]
        width = width + precision.eps * t.extra(*ranges)
    if row.result == "real":
        width = width + precision.tiny  # numbers too small for the type may count as 0, in the result or on the way
    error = np.abs(got - wanted)
    use = np.where(error == 0, 0.0, error / width)
    over = np.abs(wanted) + width >= precision.huge  # the greatest number and infinity are neighbours
    beyond = over & np.isinf(got) & (np.sign(got) == np.sign(wanted))
    at_end = np.isinf(wanted) & ~np.isinf(got)
    use = np.where(beyond | (got == wanted), 0.0, np.where(at_end, np.inf, use))
    use = np.where(np.isnan(wanted) | np.isnan(got), np.where(np.isnan(wanted) & np.isnan(got), 0.0, np.inf), use)
    return np.where(np.isnan(use), np.inf, use)
