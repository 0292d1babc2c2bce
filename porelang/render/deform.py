"""How a part is deformed in a picture: by which displacements, and how many times as large as they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.data import coordinates
from porelang.diagnostics import fail, suggest
from porelang.elaborate.values import Vector
from porelang.expression import expression
from porelang.ir import Node, X, Y, Z, node, order, within
from porelang.ops.studies import COMPONENTS
from porelang.program import Design, Program
from porelang.units import LENGTH

Floats = NDArray[np.float64]
#: Without a magnification the greatest displacement is so much of the part's longest side.
SHOWN = 0.1
#: Slopes of displacements are asked at so many places of the surface, over so much of the part's longest side.
PLACES, APART = 20_000, 2e-3
#: A surface may be turned inside out at so many of them: at a rim where the stress has no bound it always is.
INSIDE_OUT = 0.01
OPTION = "--deform"


@dataclass(frozen=True, slots=True)
class Deform:
    """What was asked for: the name of a study, or an expression of a displacement ("": the only study there is), and
    by how much it is magnified (None: so that the greatest displacement is a tenth of the part)."""

    what: str = ""
    factor: float | None = None


@dataclass(frozen=True, slots=True)
class Deformed:
    """By how much displacements of `what` are magnified in a picture, and the greatest of them, in mm, as it is."""

    what: str
    factor: float
    greatest: float

    def __str__(self) -> str:
        return f"displacements x {self.factor:.4g}"


def of_field(program: Program, wish: Deform | None, shown: Sequence[Node]) -> Deform | None:
    """The wish, with the study that a field in colours reads where it names none of several and the field reads one."""
    if wish is None or wish.what or len(program.studies) < 2:
        return wish
    read = set(order(shown, within))
    named = [name for name, task in program.studies.items() if task in read]
    return replace(wish, what=named[0]) if len(named) == 1 else wish


def displacement(program: Program, what: str) -> tuple[str, tuple[Node, ...]]:
    """The name and the three flat roots of a displacement in mm. Of a study they are those in its samples, whatever it
    is told to be outside of its part. Errors: E100 for no study, or several; E108 for what is no displacement; those
    of an expression."""
    studies = program.studies
    name = what.removesuffix(".displacement")
    if not what:
        if not studies:
            hint = 'name one with `let`: `let s = compress(part, force=10kN, axis=z, material="PA12")`'
            raise fail("E100", "the program has no study, so nothing deforms its part", hint=hint)
        if len(studies) > 1:
            listed = ", ".join(f"`{s}`" for s in studies)
            raise fail("E100", f"the program has several studies: {listed}",
                       hint=f"choose one with {OPTION} {next(iter(studies))}")  # fmt: skip
        (name,) = studies
    if name in studies:
        places = (COMPONENTS.index(c) for c in ("ux", "uy", "uz"))
        return name, tuple(node("lookup", studies[name], X, Y, Z, value=(i, 0, 0, 0)) for i in places)
    if what.isidentifier() and what not in (*program.outputs, *program.elaborated.lets):
        near = suggest(what, studies)
        hint = f"did you mean `{near}`?" if near else f"its studies are {', '.join(studies) or 'none'}"
        raise fail("E100", f"the program has no study called `{what}`", hint=hint)
    found = expression(program, what, OPTION)
    if not isinstance(found.value, Vector) or found.dimension not in (None, LENGTH):
        is_ = "a vector" if isinstance(found.value, Vector) else "no vector"
        if found.dimension not in (None, LENGTH):
            is_ += f", {found.dimension}"
        hint = f"a displacement is a vector of lengths, or a study: {OPTION} {next(iter(studies), 's')}"
        raise fail("E108", f"`{what}` is no displacement: it is {is_}", hint=hint)
    return what, found.roots


def magnified(design: Design, wish: Deform, vertices: Floats) -> tuple[Floats, Deformed]:
    """The vertices (n, 3) mm of a part where they are in the picture, and by how much they moved.

    Errors: E179 where nothing moves, where displacements are no numbers, or where they turn the part inside out.
    """
    name, roots = displacement(design.program, wish.what)
    field = NumpyField(design.formula(*roots), "f64")
    moved = np.asarray(field.at(vertices), np.float64)
    bad = ~np.isfinite(moved).all(axis=1)
    if bad.any():
        raise fail("E179", f"the displacements of `{name}` are no numbers at ({coordinates(vertices[bad][0])})",
                   hint="where they are known all over the part it can be drawn deformed")  # fmt: skip
    size = float(np.ptp(vertices, axis=0).max())
    greatest = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    if greatest == 0:
        raise fail("E179", f"`{name}` moves nothing of the part: there is no deformation to be drawn",
                   hint=f"leave {OPTION} out, or see whether the study is of this part")  # fmt: skip
    few = vertices[:: max(1, len(vertices) // PLACES)]
    most, at = _most(field, few, APART * size)
    if wish.factor is None:
        factor = _two_digits(min(SHOWN * size / greatest, most))
    else:
        factor = wish.factor
        if factor > most:
            hint = f"take {_two_digits(most):g} or less, or `{OPTION} auto`"
            raise fail("E179", f"displacements of `{name}` x {factor:g} turn the part inside out, as at "
                               f"({coordinates(few[at])})", hint=hint)  # fmt: skip
    return vertices + factor * moved, Deformed(name, factor, greatest)


def _most(field: NumpyField, places: Floats, step: float) -> tuple[float, int]:
    """Up to which factor k a displacement u maps a part onto its image one to one: det(I + k grad u) > 0 at all but few
    of some places; and the place where that is the tightest but for these."""
    slope = np.empty((len(places), 3, 3))
    for axis in range(3):
        aside = np.zeros(3)
        aside[axis] = step
        with np.errstate(all="ignore"):
            slope[:, :, axis] = (np.asarray(field.at(places + aside)) - field.at(places - aside)) / (2 * step)
    slope[~np.isfinite(slope).all(axis=(1, 2))] = 0
    # det(I + k G) is the product of 1 + k e over the eigenvalues e: it is 0 first where k = -1/e of the least real one
    values = np.linalg.eigvals(slope)
    real = np.where(np.abs(values.imag) <= 1e-9 * np.abs(values), values.real, 0.0).min(axis=1)
    with np.errstate(divide="ignore"):
        most = np.where(real < 0, -1 / real, math.inf)
    at = int(np.argsort(most)[int(INSIDE_OUT * len(most))])
    return float(most[at]), at


def _two_digits(value: float) -> float:
    """In two digits, not rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / unit * (1 + 1e-9)) * unit:.6g}")
