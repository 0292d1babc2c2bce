"""Coordinates from the ranges of what is linear in them, and from turns by an angle that varies in space.

A rotated box says that three sums of coordinates are small; one at a time that says nothing about any coordinate, so
they are solved together. A twist makes sums of products with a cosine and a sine, and these say nothing either, but a
turn keeps lengths, whatever the angle: of u = a cos t - b sin t and v = a sin t + b cos t, u^2 + v^2 = a^2 + b^2. So u
and v are unknowns as coordinates are, and their ranges tell how large a and b can be.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.formula import Formula
from porelang.interval import Interval, interval
from porelang.ir import Node, node, substitute
from porelang.ops import TABLE
from porelang.tape import AXES, Tape

Floats = NDArray[np.float64]
#: What a linear form is of: a position, or a turned pair's first or second (the pair's number, 0 or 1).
Atom = int | tuple[int, int]
Form = dict[Atom, float]  # the constant is the factor of `_ONE`
_ONE = -1
_WAVES = {"cos": 0, "sin": 1, "cos_turns": 0, "sin_turns": 1}
#: Unknowns that are solved for together, at most; and what is too near to a combination of others to be of use.
_MOST, _DEPENDENT = 9, 1e-3
_ROUNDING = 1e-12
#: What inverting rows that are `_DEPENDENT` by no less rounds, to the largest of the inverse.
_INVERTED = 1e-13


@dataclass(frozen=True, slots=True)
class _Product:
    """`factor` times an amplitude (a position) times the cosine (0) or the sine (1) of an angle (a position)."""

    amplitude: int
    angle: tuple[int, bool]
    wave: int
    factor: float


@dataclass(frozen=True, slots=True)
class Pair:
    """Two amplitudes (positions; the second None where there is one), turned by an angle that varies."""

    first: int
    second: int | None


@dataclass(frozen=True, slots=True)
class Linear:
    """The positions that are linear, by what they are of, and the turned pairs among that."""

    forms: dict[int, Form]
    pairs: tuple[Pair, ...]


def turns(tape: Tape) -> bool:
    """Whether anything is to be solved for: something is linear in several quantities, or in one several times over."""
    plain = [False] * len(tape)  # what is one quantity, scaled and moved
    linear = ("add", "sub", "neg")
    for i, op in enumerate(tape.ops):
        if not tape.axes[i]:
            continue
        varying = [a for a in tape.inputs[i] if tape.axes[a]]
        plain[i] = op in AXES or (op in (*linear, "mul", "div") and len(varying) == 1 and plain[varying[0]])
        if op in ("add", "sub") and len(varying) == 2 and all(plain[a] for a in varying):
            return True
        if op == "mul" and len(varying) == 2 and len([a for a in varying if _wave(tape, a)]) == 1:
            return True
    return False


def solved(tape: Tape, known: Mapping[int, Interval], universe: float) -> dict[int, tuple[float, float]]:
    """Ranges of coordinates and of amplitudes, from those of one solid that are known (arrays of one item)."""
    linear = _linear(tape, known)
    rows: list[tuple[float, Form, float, float]] = []
    for i, form in linear.forms.items():
        factors = {a: f for a, f in form.items() if a != _ONE}
        size = float(np.linalg.norm(list(factors.values()))) if factors else 0.0
        lo, hi = _ends(known, i)
        if size > 0 and np.isfinite([lo, hi]).all() and hi - lo < universe * size:
            rest = form.get(_ONE, 0.0)
            slack = _ROUNDING * (max(abs(lo), abs(hi)) + abs(rest))
            rows.append(((hi - lo) / size, {a: f / size for a, f in factors.items()}, (lo - rest - slack) / size,
                         (hi - rest + slack) / size))  # fmt: skip
    found: dict[Atom, tuple[float, float]] = {}
    for some in _apart(rows):
        found |= _solved_together(some)
    out = {a: ends for a, ends in found.items() if isinstance(a, int)}
    for k, pair in enumerate(linear.pairs):
        u, v = found.get((k, 0)), found.get((k, 1))
        if u is None or v is None:
            continue
        radius = math.hypot(max(-u[0], u[1]), max(-v[0], v[1])) * (1 + _ROUNDING)
        for a in (pair.first, pair.second):
            if a is not None:
                lo, hi = out.get(a, (-np.inf, np.inf))
                out[a] = max(lo, -radius), min(hi, radius)
    return out


def unturned(formula: Formula) -> Formula:
    """The same field with the length of each turned pair as that of what is turned: hypot(a, b), not hypot(u, v) of
    u = a cos t - b sin t and v = a sin t + b cos t, which enclosures are loose of."""
    tape = formula.tape
    hypots = [i for i in tape.field if tape.ops[i] == "hypot"]
    if not hypots or not turns(tape):
        return formula
    numbers = {i: interval(v) for i, v in formula.known.items() if tape.kinds[i] == "real"}
    linear = _linear(tape, numbers)
    new: dict[Node, Node] = {}
    for i in hypots:
        forms = [linear.forms.get(a, {}) for a in tape.inputs[i]]
        (first, one), (second, other) = (next(iter(f.items()), (_ONE, 0.0)) for f in forms)
        if [len(f) for f in forms] != [1, 1] or not isinstance(first, tuple) or not isinstance(second, tuple):
            continue
        if first[0] == second[0] and first[1] != second[1] and abs(one) == abs(other):
            pair = linear.pairs[first[0]]
            a = tape.nodes[pair.first]
            length = node("abs", a) if pair.second is None else node("hypot", a, tape.nodes[pair.second])
            new[tape.nodes[i]] = length if abs(one) == 1 else length * abs(one)
    return formula.with_roots(*substitute(formula.roots, new)) if new else formula


def _ends(known: Mapping[int, Interval], i: int) -> tuple[float, float]:
    return float(known[i].lo.flat[0]), float(known[i].hi.flat[0])


def _linear(tape: Tape, known: Mapping[int, Interval]) -> Linear:
    """What is linear in coordinates, in turned pairs and in whatever else is not linear itself."""
    forms: dict[int, Form] = {}
    products: dict[int, _Product] = {}
    first: dict[Hashable, tuple[int, float]] = {}
    for i, op in enumerate(tape.ops):
        if tape.kinds[i] != "real" or (not tape.axes[i] and i not in known):
            continue
        if op in TABLE and TABLE[op].results:  # a walk is no number: what is picked from it is
            continue
        if not tape.axes[i]:
            lo, hi = _ends(known, i)
            if lo == hi and np.isfinite(lo):
                forms[i] = {_ONE: lo}
            continue
        inputs = tape.inputs[i]
        made = _combined(op, [forms.get(a) for a in inputs])
        if made is None:
            made = {i: 1.0}
            if op == "mul" and (product := _product(tape, inputs, forms, first)) is not None:
                products[i] = product
        forms[i] = {a: f for a, f in made.items() if f}
    return _with_pairs(forms, products)


def _combined(op: str, f: Sequence[Form | None]) -> Form | None:
    """The form of a linear operation on forms; None where it is not linear."""
    if op == "neg" and f[0] is not None:
        return {a: -v for a, v in f[0].items()}
    if len(f) != 2 or f[0] is None or f[1] is None:
        return None
    if op in ("add", "sub"):
        sign = 1.0 if op == "add" else -1.0
        made = f[0] | {a: f[0].get(a, 0.0) + sign * v for a, v in f[1].items()}
        # a factor that all but cancels is rounding, and would be taken for what an unknown hangs on
        cancelled = any(a != _ONE and 0 < abs(made[a]) <= _ROUNDING * abs(v) for a, v in f[1].items())
        return None if cancelled else made
    if op == "mul":
        for by, of in (f, f[::-1]):
            if by is not None and of is not None and set(by) <= {_ONE}:
                return {a: v * by.get(_ONE, 0.0) for a, v in of.items()}
    if op == "div" and set(f[1]) == {_ONE} and f[1][_ONE] != 0:
        return {a: v / f[1][_ONE] for a, v in f[0].items()}
    return None


def _wave(tape: Tape, i: int) -> tuple[int, float] | None:
    """A cosine or sine that varies, as its position, and its sign."""
    if tape.ops[i] == "neg":
        found = _wave(tape, tape.inputs[i][0])
        return None if found is None else (found[0], -found[1])
    return (i, 1.0) if tape.ops[i] in _WAVES and tape.axes[i] else None


def _product(
    tape: Tape, inputs: Sequence[int], forms: Mapping[int, Form], first: dict[Hashable, tuple[int, float]]
) -> _Product | None:
    """A product of an amplitude and a wave; of amplitudes that are multiples of each other it names the `first`."""
    for w, a in ((inputs[1], inputs[0]), (inputs[0], inputs[1])):
        found = _wave(tape, w)
        if found is None or _wave(tape, a) is not None or not forms.get(a):
            continue
        wave, sign = found
        angle = tape.inputs[wave][0], tape.ops[wave].endswith("_turns")
        key, factor = _scaled(forms[a])
        same, unit = first.setdefault(key, (a, factor))
        return _Product(same, angle, _WAVES[tape.ops[wave]], sign * factor / unit)
    return None


def _scaled(form: Form) -> tuple[Hashable, float]:
    """What a form is but for a factor, and that."""
    listed = sorted(form.items(), key=repr)
    factor = listed[-1][1]
    return tuple((a, round(f / factor, 12)) for a, f in listed), factor


def _with_pairs(forms: Mapping[int, Form], products: Mapping[int, _Product]) -> Linear:
    """Forms of products with waves as forms of turned pairs."""
    numbers: dict[Hashable, int] = {}
    listed: list[Pair] = []
    out: dict[int, Form] = {}
    for i, form in forms.items():
        waves: dict[tuple[int, bool], dict[int, list[float]]] = {}  # by angle, by amplitude: of the cosine, the sine
        made: Form = {}
        for a, f in form.items():
            p = products.get(a) if isinstance(a, int) else None
            if p is None:
                made[a] = f
            else:
                waves.setdefault(p.angle, {}).setdefault(p.amplitude, [0.0, 0.0])[p.wave] += f * p.factor
        for angle, by in waves.items():
            for pair, sense, first, second in _turned(by):
                k = numbers.setdefault((angle, sense, pair), len(listed))
                if k == len(listed):
                    listed.append(pair)
                made[k, 0], made[k, 1] = first, second
        out[i] = {a: f for a, f in made.items() if f}
    return Linear(out, tuple(listed))


def _turned(by: Mapping[int, Sequence[float]]) -> list[tuple[Pair, int, float, float]]:
    """What amplitudes times cosine and sine are of turned pairs: the pair, the sense, and factors of u and of v.

    Of (a, b) turned one way, u = a c - b s and v = a s + b c; the other way, u = a c + b s and v = b c - a s; of (a, 0)
    u = a c and v = a s.
    """
    if len(by) == 2:
        (a, (ac, sa)), (b, (bc, sb)) = sorted(by.items())
        near = _ROUNDING * max(abs(ac), abs(sa), abs(bc), abs(sb))
        if abs(sb + ac) <= near and abs(bc - sa) <= near:
            return [(Pair(a, b), 1, ac, sa)]
        if abs(sb - ac) <= near and abs(bc + sa) <= near:
            return [(Pair(a, b), -1, ac, bc)]
    return [(Pair(a, None), 0, c, s) for a, (c, s) in by.items()]


def _apart(rows: Sequence[tuple[float, Form, float, float]]) -> Iterator[list[tuple[float, Form, float, float]]]:
    """Rows that have unknowns in common, together."""
    groups: list[tuple[set[Atom], list[tuple[float, Form, float, float]]]] = []
    for row in rows:
        atoms, some = set(row[1]), [row]
        apart = []
        for group in groups:
            if group[0] & atoms:
                atoms |= group[0]
                some = group[1] + some
            else:
                apart.append(group)
        groups = [*apart, (atoms, some)]
    for atoms, some in groups:
        if len(atoms) <= _MOST:
            yield some


def _solved_together(rows: list[tuple[float, Form, float, float]]) -> dict[Atom, tuple[float, float]]:
    """The unknowns that rows determine, from the narrowest rows that are independent."""
    atoms = list(dict.fromkeys(a for row in rows for a in row[1]))
    column = {a: k for k, a in enumerate(atoms)}
    picked: list[Floats] = []
    across: list[Floats] = []  # the same, each at right angles to those before it
    low, high = [], []
    for _, form, lo, hi in sorted(rows, key=lambda r: r[0]):
        line = np.zeros(len(atoms))
        for a, f in form.items():
            line[column[a]] = f
        rest = line.copy()
        for other in across:
            rest -= (rest @ other) * other
        size = float(np.linalg.norm(rest))
        if size > _DEPENDENT:
            picked.append(line)
            across.append(rest / size)
            low.append(lo)
            high.append(hi)
        if len(picked) == len(atoms):
            break
    inverse = np.linalg.pinv(np.array(picked))
    told = np.abs(inverse @ np.array(picked) - np.eye(len(atoms))).max(axis=1) < _ROUNDING
    ends = np.array(low), np.array(high)
    middle, half = inverse @ (ends[0] + ends[1]) / 2, np.abs(inverse) @ (ends[1] - ends[0]) / 2
    # the inverse is rounded as a whole: an unknown that is 0 has a part in its row of what all others are
    rounded = float(np.abs(inverse).max() * np.maximum(np.abs(ends[0]), np.abs(ends[1])).sum())
    half = half * (1 + _ROUNDING) + _INVERTED * rounded
    return {a: (float(middle[k] - half[k]), float(middle[k] + half[k])) for k, a in enumerate(atoms) if told[k]}
