"""A param swept: the density of a lattice and what it does at each value, and the law that follows from them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.homogenize.found import Homogenized
from porelang.homogenize.table import table_of
from porelang.homogenize.whole import RESOLUTION, homogenize
from porelang.picture import Picture
from porelang.program import Design
from porelang.progress import activity, tell
from porelang.settings import Setting
from porelang.unitcell import moduli
from porelang.unitcell.law import Law, Power, law, power

#: What is fitted, and listed for each value: a name of `Homogenized.numbers`, and what it is called in tables.
FITTED = {"E.100": "E", "shear": "shear", "bulk": "bulk", "conductivity": "conductivity"}
#: Most values of a sweep.
MOST = 100


@dataclass(frozen=True)
class Swept:
    """What a lattice does at values (base units) of a param, in their order."""

    param: str
    values: tuple[float, ...]
    shown: tuple[str, ...]
    found: tuple[Homogenized, ...] = field(repr=False)

    @property
    def density(self) -> list[float]:
        """The densities, by value."""
        return [one.density for one in self.found]

    @cached_property
    def law(self) -> Law:
        """Its cubic stiffness as a function of the density. Errors: E183 where densities do not differ, or a stiffness
        is more than a per cent away from a cubic one."""
        found = law(self.density, [one.stiffness for one in self.found], [one.stiffness_error for one in self.found],
                    self.found[0].nu)  # fmt: skip
        if found.away > moduli.CUBIC:
            raise fail("E183", f"a stiffness of this sweep is {found.away:.1%} away from a cubic one, and a law has "
                       "the three constants of that alone",
                       hint="read what is wanted from the cells, `.found`: E along 100, 010, 001, ...")  # fmt: skip
        return found

    @cached_property
    def fits(self) -> dict[str, Power]:
        """C rho^n of Young's modulus along 100, the shear and bulk modulus and the conductivity, of those that there
        are at two densities at least. Errors: E183 where none is."""
        values = {called: [one.numbers[name] for one in self.found] for name, called in FITTED.items()}
        there = {called: found for called, found in values.items() if np.count_nonzero(np.array(found) > 0) > 1}
        return {called: power(self.density, found) for called, found in (there or values).items()}

    @property
    def doubts(self) -> list[Diagnostic]:
        """The warnings of all, each with the value that it is for."""
        return [replace(d, message=f"with {self.param} = {text}, {d.message}")
                for text, one in zip(self.shown, self.found, strict=True) for d in one.doubts]  # fmt: skip

    def __str__(self) -> str:
        return "\n".join(table_of(self))

    def picture(self) -> Picture:
        """Young's modulus, shear and bulk modulus over the density on logarithmic axes, with their powers."""
        from porelang.render.plot import powers_picture

        one = self.found[0]
        lines = {
            called: ([f.numbers[name] for f in self.found], [f.errors[name] for f in self.found], self.fits[called])
            for name, called in FITTED.items()
            if called != "conductivity" and called in self.fits
        }
        rho = np.geomspace(0.5 * min(self.density), 1.0, 60)
        bound = [moduli.upper_bounds(float(r), one.nu)["E"] for r in rho]
        title = (
            f"Moduli of {one.name} over its density, E along 100; {self.param} from {self.shown[0]} to {self.shown[-1]}"
        )
        return powers_picture(self.density, lines, (rho, np.array(bound)), title)

    def _repr_png_(self) -> bytes:
        return self.picture()._repr_png_()

    def rows(self) -> list[dict[str, Any]]:
        """The table: for each value the density and what it does, with errors."""
        out = []
        for value, one in zip(self.values, self.found, strict=True):
            row: dict[str, Any] = {self.param: value, "density": one.density, "density_error": one.density_error}
            for name, called in FITTED.items():
                row |= {called: one.numbers[name], f"{called}_error": one.errors[name]}
            numbers = one.numbers
            for name in ("E.010", "E.001", "E.110", "E.111", "zener"):
                row |= {name: numbers[name], f"{name}_error": one.errors[name]}
            out.append(row | {"nu": numbers["nu.100"], "nu_error": one.errors["nu.100"]})
        return out

    def report(self) -> dict[str, Any]:
        """What `pore homogenize --sweep --json` prints."""
        fits = {
            called: {"factor": fit.factor, "exponent": fit.exponent, "r2": fit.r2, "miss": fit.miss,
                     "range": list(fit.range)}
            for called, fit in self.fits.items()
        }  # fmt: skip
        return {"param": self.param, "rows": self.rows(), "fits": fits,
                "cells": [one.report() for one in self.found]}  # fmt: skip


def sweep(
    design: Design,
    param: str,
    low: Setting,
    high: Setting,
    count: int,
    name: str | None = None,
    cell: Any = None,
    nu: float = 0.3,
    resolution: int = RESOLUTION,
    fixed: Collection[str] = (),
) -> Swept:
    """A lattice at `count` values of a param from `low` to `high`, evenly spaced; see `homogenize` for the rest.
    `fixed` are the params that are set, among which it must not be. What was solved is kept: a sweep that was
    interrupted goes on.

    Errors: those of the settings and of each cell, with the value that it is; E108 for a range that is none, or a param
    that is set as well.
    """
    if param in fixed:
        raise fail("E108", f"`{param}` is swept, and set to one value as well", hint="leave out one of the two")
    if not isinstance(count, int) or isinstance(count, bool) or not 2 <= count <= MOST:
        raise fail("E108", f"a sweep over {count!r:.40} values is none", hint=f"take from 2 to {MOST}: t=0.2..1.2:6")
    ends = [design.design({param: end}).settings[param] for end in (low, high)]
    if not ends[0] < ends[1]:
        told = "goes down" if ends[0] > ends[1] else "is one value"
        raise fail("E108", f"the range of the sweep over `{param}` {told}",
                   hint="give two ends, the lower first: t=0.2..1.2:6")  # fmt: skip
    values = [float(v) for v in np.linspace(ends[0], ends[1], count)]
    shown = [design.program.params[param].shown(v) for v in values]
    found = []
    for i, (value, text) in enumerate(zip(values, shown, strict=True)):
        with activity("sweeping"):
            tell(i, count)
        try:
            found.append(homogenize(design.design({param: value}), name, cell, nu, resolution))
        except PoreError as error:
            raise PoreError(
                [replace(d, message=f"{d.message}, with {param} = {text}") for d in error.diagnostics]
            ) from None
    return Swept(param, tuple(values), tuple(shown), tuple(found))
