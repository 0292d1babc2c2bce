"""How large the cubes of a lattice are to be, what that takes, and whether they do for a part's walls."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang import walls
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.formula import Formula
from porelang.solid import Solid

Floats = NDArray[np.float64]

MOST = 40_000_000  # tetrahedra: more take some 20 GB
MANY = 1_000_000  # what is told where it is proposed
BYTES = 500  # of memory for each tetrahedron, at most, while it is made
PLACES = 32  # along a side, at which a field of sizes is looked at
COARSEST = 10  # times that a size may double
LAYERS = 5  # of the finest cubes, at a surface
ACROSS = 3.0  # cubes that a thinnest wall is to have, where they can be afforded
TWO = 2  # cubes: what is thinner bends as nothing does in a solver


@dataclass(frozen=True, slots=True)
class Sizes:
    """The edges of cubes in mm: of the `finest`, of those at the surface, of what is allowed `at` points, where that is
    the same everywhere `even`, else 0; and how many times the finest may double."""

    finest: float
    surface: float
    at: Callable[[Floats], Floats]
    coarsest: int
    even: float = 0.0


def asked(solid: Solid, size: float | Formula, surface: float | None) -> Sizes:
    """The sizes of a request. Errors: E160 a size that is none, E161 more tetrahedra than there is memory for."""
    at_surface = math.inf if surface is None else _length(surface, "--surface-size")
    if isinstance(size, Formula):
        field = NumpyField(size, "f64")
        found = _looked_at(solid, field)
        least, most, per_volume = float(found.min()), float(found.max()), float((found**-3).mean())

        def at(points: Floats) -> Floats:
            return np.asarray(np.maximum(field.at(points), finest))
    else:
        least = most = _length(size, "--size")
        per_volume = most**-3

        def at(points: Floats) -> Floats:
            return np.full(len(points), most)

        if surface is not None and at_surface > most:
            raise fail(
                "E160",
                f"cubes are to be {at_surface:g} mm at the surface and {most:g} mm within",
                hint="the size at the surface is the smaller one, or left out",
            )
    finest = min(least, at_surface)
    _refuse_too_many(solid, finest, least, per_volume, at_surface)
    even = 0.0 if isinstance(size, Formula) else most
    return Sizes(finest, at_surface, at, min(COARSEST, int(math.log2(most / finest) + 1e-9)), even)


def thin(solid: Solid, sizes: Sizes) -> list[Diagnostic]:
    """W250 where the thinnest walls are thinner than two cubes there, with a place."""
    _, found = walls.walls_of(solid)
    if found is None:
        return []
    cube = min(float(sizes.at(found.at[None])[0]), sizes.surface)
    if found.wall >= TWO * cube:
        return []
    x, y, z = found.at
    message = (
        f"the thinnest walls are {found.wall:.3g} mm thick, as at ({x:.4g}, {y:.4g}, {z:.4g}), "
        f"less than two cubes of {cube:.3g} mm"
    )
    size = float(walls.rounded(found.wall / ACROSS))
    count = 12 * solid.guess[0] / size**3
    hint = f"take a --size of {size:g} mm: a wall of one element is too stiff, and may break"
    if count > MANY:
        hint += f"; that makes some {float(f'{count / 1e6:.2g}'):g} million"
        hint += f", and {MOST / 1e6:.0f} million are the most: take a part of it, with --bounds" if count > MOST else ""
    return [Diagnostic("W250", message, hint=hint, severity="warning")]


def _length(size: object, option: str) -> float:
    if not isinstance(size, int | float | np.number) or isinstance(size, bool) or not math.isfinite(size) or size <= 0:
        raise _no_size(f"{size!r} is no size of tetrahedra", f"give a length above 0 mm, as in {option} 2mm")
    return float(size)


def _no_size(message: str, hint: str) -> PoreError:
    return fail("E160", message, hint=hint)


def _looked_at(solid: Solid, field: NumpyField) -> Floats:
    """The sizes at places all over a part. Errors: E160 where one is none."""
    cells = np.stack(np.meshgrid(*[(np.arange(PLACES) + 0.5) / PLACES] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = solid.lo + cells * (solid.hi - solid.lo)
    held = points[solid.holds(points)]
    points = held if len(held) else points
    found = np.asarray(field.at(points), np.float64)
    wrong = np.flatnonzero(~(np.isfinite(found) & (found > 0)))
    if len(wrong):
        x, y, z = points[wrong[0]]
        raise _no_size(
            f"the size is {found[wrong[0]]:g} mm at ({x:.4g}, {y:.4g}, {z:.4g})",
            "a field of sizes is above 0 all over the part: `max(0.5mm, ...)`",
        )
    return found


def _refuse_too_many(solid: Solid, finest: float, least: float, per_volume: float, at_surface: float) -> None:
    """Tell before the start what is too much: `per_volume` cubes in a mm3 within, and layers of `at_surface` (mm)."""
    volume, unsure = solid.guess
    count = 12 * (volume + unsure) * per_volume
    if at_surface < least:
        near = float((solid.hi - solid.lo).max()) / PLACES
        count += 12 * LAYERS * walls.triangles(solid, near) / 3 / at_surface**2  # a cube of surface has some 3
    if count <= MOST:
        return
    larger = f"{float(f'{finest * (count / MOST) ** (1 / 3) * 1.05:.2g}'):g} mm"
    raise fail(
        "E161",
        f"cubes of {finest:g} mm make some {count / 1e6:,.0f} million tetrahedra, "
        f"for which {count * BYTES / 1e9:,.0f} GB of memory are needed",
        hint=f"take {larger} or more, or a part of it, with --bounds",
    )
