"""What a study is asked, out of the arguments of its task: the part, its material, what acts on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.data import coordinates
from porelang.diagnostics import fail
from porelang.formula import Formula
from porelang.ir import constant
from porelang.ops.studies import ACTIONS, HEAD
from porelang.solid import Solid
from porelang.tasks.bake import region
from porelang.tasks.numbers.region import refuse_undefined
from porelang.tasks.study.conditions import certain_and_possible

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
_GUARD = (
    "look for a division by zero, or a root, logarithm or power of a negative number there, and say what holds then"
)


@dataclass(frozen=True, slots=True)
class Acts:
    """One thing that acts on a part: the name of its row of `ACTIONS`, where it does, its numbers in base units."""

    name: str
    where: Formula
    numbers: tuple[float, ...]

    def holds(self, points: Floats) -> Flags:
        """At which points (n, 3) mm the condition holds. Errors: E174 where what it compares is not a number."""
        if not self.where.root.axes:
            return np.full(len(points), bool(self.where.numbers[0]))
        with np.errstate(all="ignore"):
            found = np.asarray(
                NumpyField(self.where.with_roots(*certain_and_possible(self.where.root)), "f64").at(points), np.bool_
            )
        if (unknown := found[:, 0] != found[:, 1]).any():
            at = coordinates(points[int(np.argmax(unknown))])
            raise fail("E174", f"where this `{self.name}` acts is not known: its condition compares what is not a "
                       f"number at ({at}) mm, on the surface of the part", hint=_GUARD)  # fmt: skip
        return found[:, 0]


@dataclass(frozen=True, slots=True)
class Question:
    """A study: `young` (MPa), `poisson` and `density` (g/cm3, 0 everywhere where it is not known) are fields; `size`
    is the edge of elements in mm, 0 where it is to be found; `order` that of their polynomials; `yields` the stress
    (MPa) at which the material does, 0 where it is not known; `balanced` says that loads balance each other."""

    part: Formula
    young: Formula
    poisson: Formula
    density: Formula
    size: float
    order: int
    acts: tuple[Acts, ...]
    yields: float = 0.0
    balanced: bool = False

    @property
    def whole(self) -> Acts | None:
        """The test between two ends of the part that it is, if it is one."""
        return next((a for a in self.acts if a.name in _WHOLE), None)


def solid_of(asked: Question) -> Solid:
    """The part, cut at the box that holds it. Errors: E091 where it has no end, E092 where it is empty, E093 where its
    field is not a number."""
    box = region(asked.part, "this study", "part")
    refuse_undefined(asked.part, box)
    return Solid(asked.part, (box.lo, box.hi))


#: Which of the numbers of an action are its load.
_LOADS = {"holds": slice(3, None), "loads": slice(None), "whole": slice(1)}
_WHOLE = frozenset(row.name for row in ACTIONS if row.does == "whole")


def question(asked: Formula) -> Question:
    """The study of the arguments of a task. Errors: E186 for a load of 0, E187 for a size that is none."""
    given = dict(zip(HEAD, map(asked.with_roots, asked.roots[: len(HEAD)]), strict=True))
    acts: list[Acts] = []
    rest = list(asked.roots[len(HEAD) :])
    while rest:
        row = ACTIONS[int(constant(rest[0]))]
        numbers = tuple(float(asked.with_roots(n).numbers[0]) for n in rest[2 : 2 + len(row.numbers)])
        acts.append(Acts(row.name, asked.with_roots(rest[1]), numbers))
        del rest[: 2 + len(row.numbers)]
    edge = float(given["size"].numbers[0])
    if not 0 <= edge < np.inf:
        raise fail("E187", f"elements of {edge:g} mm cannot be had", hint="as in `size=4mm`, or leave it out")
    for act in acts:
        _checked(act)
    return Question(
        given["part"], given["E"], given["nu"], given["density"], edge, int(given["order"].numbers[0]), tuple(acts),
        float(given["yields"].numbers[0]), bool(given["balanced"].numbers[0]),
    )  # fmt: skip


def _checked(act: Acts) -> None:
    """Errors: E186 for a load of 0, or one that is no number."""
    row = next(row for row in ACTIONS if row.name == act.name)
    loads = act.numbers[_LOADS[row.does]]
    what = f"a `{act.name}`"
    if not all(np.isfinite(loads)):
        raise fail("E186", f"{what} of {', '.join(f'{v:g}' for v in loads)} cannot be had", hint="it takes numbers")
    if row.does != "holds" and not any(loads):
        raise fail("E186", f"{what} of 0 does nothing", hint="give it a value, or leave it out")


#: What a number of the material is, its unit, between which it lies, and what is said where it does not.
YOUNG = "Young's modulus", "MPa", 0.0, np.inf, "it is above 0, and finite, in all of a part"
POISSON = "Poisson's ratio", "", -1.0, 0.5, "it lies between -1 and 0.5: 0.49 at most"
DENSITY = "the density", "g/cm3", -1e-300, np.inf, "it is 0 or more in all of a part"


def valued(field: Formula, points: Floats, what: str, unit: str, least: float, most: float, hint: str) -> Floats:
    """A number of the material at points (n, 3) mm, in a unit, between two others. Errors: E185 where it is not, and
    where."""
    if not field.root.axes:
        values = np.full(len(points), float(field.numbers[0]))
    else:
        with np.errstate(all="ignore"):
            values = np.asarray(NumpyField(field, "f64").at(points), np.float64)
    bad = ~((values > least) & (values < most))
    if bad.any():
        at = int(np.flatnonzero(bad)[0])
        is_ = "not a number" if np.isnan(values[at]) else f"{values[at]:.4g} {unit}".rstrip()
        place = f" at ({coordinates(points[at])}) mm" if field.root.axes else ""
        raise fail("E185", f"{what} is {is_}{place}", hint=hint)
    return values
