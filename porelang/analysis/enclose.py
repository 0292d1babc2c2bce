"""Enclosures: ranges that hold what the graph can return, over boxes of space and ranges of params.

With `EXACT` the ranges hold the mathematical value. With `F32` or `F64` they also hold what a backend of that precision
returns, because every operation's result is widened by its tolerance from the table. Over a box this decides whether a
surface can pass through it; over a single point it is the running error bound against which backends are compared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.formula import Formula
from porelang.interval import INF, Array, Interval, Mask, interval, meet, truth
from porelang.ir import SLOTS, Stage, constant
from porelang.ops import TABLE, Op
from porelang.ops.segments import FARTHEST
from porelang.tape import AXES, PICK, Tape

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Precision:
    """A floating-point type: its epsilon, its least normal number and its greatest number."""

    name: str
    eps: float
    tiny: float
    huge: float


EXACT = Precision("exact", 0.0, 0.0, INF)
F64 = Precision("f64", 2.0**-52, 2.0**-1022, 1.7976931348623157e308)
F32 = Precision("f32", 2.0**-23, 2.0**-126, 3.4028234663852886e38)


@dataclass(frozen=True, slots=True)
class Enclosure:
    """The range of one root over every box, and where the root may jump inside the box."""

    range: Interval
    jumps: Mask


NOWHERE = np.zeros((), np.bool_)
#: What is known of a value that comes from data which are not bound: any finite number.
ANYTHING = Interval(np.array(-F32.huge), np.array(F32.huge), NOWHERE)


def enclose(formula: Formula, box: Sequence[Interval] = (), precision: Precision = EXACT) -> list[Enclosure]:
    """Ranges of a formula's roots over boxes.

    `box` gives x, y and z as intervals of n boxes (arrays of shape (n,)); it may be left out where no root is a field.
    Memory is n times the widest cut through the graph.
    """
    found = _enclosed(formula, box, precision, keep=False, held={})
    return [found[r] for r in formula.tape.roots]


def enclose_all(
    formula: Formula,
    box: Sequence[Interval] = (),
    precision: Precision = EXACT,
    held: Mapping[int, Interval] | None = None,
) -> dict[int, Enclosure]:
    """Ranges of every position of a formula's tape that holds numbers or conditions, each within what it is `held` to:
    of the points of the boxes where all of that is so."""
    return {i: e for i, e in _enclosed(formula, box, precision, True, held or {}).items() if isinstance(e, Enclosure)}


def _enclosed(
    formula: Formula, box: Sequence[Interval], precision: Precision, keep: bool, held: Mapping[int, Interval]
) -> dict[int, Any]:
    """What is known of each position: an enclosure, data, or of a walk with several results one enclosure for each."""
    tape = formula.tape
    exact: dict[int, Any] = {}  # of const and uniform positions, before they are rounded for the field stage
    found: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for i, op in enumerate(tape.ops):
            early = tape.stages[i] < Stage.FIELD
            known = exact if early else found
            made: Any
            if op == PICK or op in TABLE:
                here = precision if not early or not precision.eps else F64  # uniforms are float64
                made = enclosed_operation(tape, i, known, here)
            else:
                made = enclosed_leaf(formula, i, box, precision)
            if i in held and isinstance(made, Enclosure):
                made = Enclosure(meet(made.range, held[i]), made.jumps)
            if early:
                exact[i] = made
                made = Enclosure(_rounded(made.range, precision), made.jumps) if isinstance(made, Enclosure) else made
            found[i] = made
            if not keep:
                for a in tape.dying[i]:
                    if tape.stages[a] is Stage.FIELD:
                        del found[a]
    return found


def enclosed_operation(tape: Tape, i: int, known: Mapping[int, Any], precision: Precision = EXACT) -> Any:
    """What is known of the result of an operation at a position, by what is `known` of what it reads."""
    op = tape.ops[i]
    if op == PICK:
        walk = tape.inputs[i][0]
        return known[walk][_names(tape.values[walk]).index(str(tape.values[i]))]
    made = _operation(TABLE[op], [known[a] for a in tape.inputs[i]], tape.values[i], precision)
    return _remainder(tape, i, made, known) if op in ("sub", "mod") else made


#: What is left of a number without a whole one that is made of it, on every backend: rounding is monotone.
_LEFT = {"floor": (0.0, 1.0), "round": (-0.5, 0.5)}
_COUNTED = 2.0**24  # float32 has all whole numbers up to here


def _remainder(tape: Tape, i: int, made: Enclosure, known: Mapping[int, Any]) -> Enclosure:
    """a - floor(a) and a - round(a), whose range does not show in those of both; and whole numbers modulo one."""
    a, b = tape.inputs[i]
    if tape.ops[i] == "sub" and tape.ops[b] in _LEFT and tape.inputs[b] == (a,):
        least, most = _LEFT[tape.ops[b]]
    elif tape.ops[i] == "mod" and tape.ops[a] in _LEFT and tape.ops[b] == "const":
        whole, divisor = known[a].range, float(constant(tape.nodes[b]))
        counted = bool(np.all((whole.lo > -_COUNTED) & (whole.hi < _COUNTED)))
        if not counted or divisor < 1 or divisor != round(divisor):
            return made
        least, most = 0.0, divisor - 1.0
    else:
        return made
    r = made.range
    within = meet(r, interval(least, most))
    return Enclosure(
        Interval(np.where(r.empty, r.lo, within.lo), np.where(r.empty, r.hi, within.hi), r.nan), made.jumps
    )


def _operation(row: Op, inputs: list[Any], payload: object, precision: Precision) -> Any:
    """The enclosure of an operation's result, or a tuple of them where it has several."""
    ranges = [e.range if isinstance(e, Enclosure) else e for e in inputs]
    jumps = NOWHERE
    for e in inputs:
        if isinstance(e, Enclosure):
            jumps = jumps | e.jumps
    if None in ranges:  # it reads data that are not bound
        free = _anything_at([r for r in ranges if isinstance(r, Interval)])
        one = Enclosure(truth(~NOWHERE, ~NOWHERE) if row.result == "bool" else free, ~NOWHERE)
        return (one,) * len(_names(payload)) if row.results else one
    more = [*ranges, payload] if row.payload or row.results else ranges
    closer = row.doubles if precision is not F32 else None
    enclosed, jumping_at = closer or (row.enclose, row.jumps)
    out: Any = enclosed(*more)  # of several results a tuple, as are `jumps` and the tolerance's `extra`
    if not row.results:
        over = jumps | jumping_at(*more) if jumping_at is not None else jumps
        return Enclosure(_widen(row, out, row.tolerance.extra, more, precision), over)
    jumping: Any = row.jumps(*more) if row.jumps is not None else (NOWHERE,) * len(out)
    slack: Any = row.tolerance.extra(*more) if row.tolerance.extra is not None and precision.eps else None
    return tuple(
        Enclosure(_widen(row, r, None if slack is None else _given(slack[k]), more, precision), jumps | jumping[k])
        for k, r in enumerate(out)
    )


def _anything_at(place: list[Interval]) -> Interval:
    """What data that are not bound may give at a place: any finite number, and beyond `FARTHEST` anything at all."""
    nan, far = NOWHERE, NOWHERE
    for r in place:
        nan = nan | r.nan
        far = far | ~((r.lo >= -FARTHEST) & (r.hi <= FARTHEST))
    lo, hi = np.where(far, -INF, ANYTHING.lo), np.where(far, INF, ANYTHING.hi)
    return Interval(lo, hi, np.broadcast_to(nan | far, lo.shape))


def _names(wanted: object) -> tuple[str, ...]:
    """What is picked from a walk."""
    assert isinstance(wanted, tuple)
    return wanted


def _given(values: Array) -> Callable[..., Array]:
    return lambda *_: values


def enclosed_leaf(formula: Formula, i: int, box: Sequence[Interval], precision: Precision = EXACT) -> Any:
    """What is known of a constant, a coordinate, or what is bound to a slot."""
    n = formula.tape.nodes[i]
    if n.op == "const":
        value = n.value
        if isinstance(value, bool):
            return Enclosure(truth(np.array(not value), np.array(value)), NOWHERE)
        return Enclosure(interval(value), NOWHERE)
    if n.op in AXES:
        return Enclosure(_flushed(box[AXES[n.op]], precision), NOWHERE)
    if n.op not in SLOTS:
        raise ValueError(f"an unresolved `{n.op}` cannot be enclosed")
    bound = formula.bindings[n]
    if formula.tape.kinds[i] != "real":
        return bound
    return Enclosure(ANYTHING if bound is None else bound if isinstance(bound, Interval) else interval(bound), NOWHERE)


def _flushed(r: Interval, precision: Precision) -> Interval:
    """Numbers too small for the type may count as 0."""
    tiny = precision.tiny
    if not tiny:
        return r
    lo = np.where((r.lo > 0) & (r.lo < tiny), 0.0, r.lo)
    hi = np.where((r.hi < 0) & (r.hi > -tiny), 0.0, r.hi)
    return Interval(lo, hi, r.nan)


def _rounded(r: Interval, precision: Precision) -> Interval:
    """A number handed to a backend is rounded to its type once; numbers the type holds stay exact."""
    if precision is not F32:
        return r
    with np.errstate(over="ignore"):
        down, up = r.lo.astype(np.float32).astype(np.float64), r.hi.astype(np.float32).astype(np.float64)
    return _flushed(Interval(np.minimum(down, r.lo), np.maximum(up, r.hi), r.nan), precision)


def _widen(
    row: Op, r: Interval, extra: Callable[..., Array] | None, arguments: list[Any], precision: Precision
) -> Interval:
    """The range after a backend's own error in this operation; `extra` is the tolerance's, of the arguments."""
    t = row.tolerance
    if row.result == "bool" or not precision.eps:
        return r
    if not (t.ulp or t.absolute or extra):
        return r
    more = np.asarray(precision.eps * t.absolute + precision.tiny)
    if extra is not None:
        more = more + precision.eps * extra(*arguments)
    relative = precision.eps * t.ulp
    if _are_numbers(r.lo, r.hi, INF):  # mostly: then there is nothing infinite, empty or too large to be handed on
        lo, hi = r.lo - (np.abs(r.lo) * relative + more), r.hi + (np.abs(r.hi) * relative + more)
        if _are_numbers(lo, hi, precision.huge):
            if not t.absolute and extra is None:
                lo, hi = _of_their_sign(r, lo, hi)
            return Interval(lo, hi, r.nan)
    lo = r.lo - np.where(np.isinf(r.lo), 0.0, np.abs(r.lo) * relative + more)
    hi = r.hi + np.where(np.isinf(r.hi), 0.0, np.abs(r.hi) * relative + more)
    if not t.absolute and extra is None:  # what is wrong by a part of itself, or counts as 0, keeps its sign
        lo, hi = _of_their_sign(r, lo, hi)
    unbounded = np.isposinf(more) & ~np.isinf(r.lo) & ~np.isinf(r.hi)  # it overflows on the way: inf - inf may follow
    empty = r.empty
    lo = np.where(empty, r.lo, np.where(lo < -precision.huge, -INF, np.minimum(lo, precision.huge)))
    hi = np.where(empty, r.hi, np.where(hi > precision.huge, INF, np.maximum(hi, -precision.huge)))
    return Interval(lo, hi, r.nan | (unbounded & ~empty))


def _are_numbers(lo: Array, hi: Array, most: float) -> bool:
    """Whether ranges are not empty, and their ends numbers of at most so much, or less than infinite."""
    width = hi - lo
    return bool(((width >= 0) & (width < INF) & (lo >= -most) & (hi <= most)).all())


def _of_their_sign(r: Interval, lo: Array, hi: Array) -> tuple[Array, Array]:
    return np.where(r.lo >= 0, np.maximum(lo, 0.0), lo), np.where(r.hi <= 0, np.minimum(hi, 0.0), hi)


def at_points(points: Points, precision: Precision) -> list[Interval]:
    """Points (n, 3) as boxes of no size, after their own rounding to the type."""
    return [_rounded(interval(points[:, i]), precision) for i in range(3)]


def boxes(lo: Points, hi: Points) -> list[Interval]:
    """Boxes given by their corners (n, 3), as the ranges of x, y and z."""
    return [interval(lo[:, i], hi[:, i]) for i in range(3)]


def everywhere() -> list[Interval]:
    """Space as one box: 1000 km each way, so that no product of coordinates overflows."""
    return [interval(np.array([-1e9]), np.array([1e9])) for _ in range(3)]
