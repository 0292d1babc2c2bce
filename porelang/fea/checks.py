"""What a problem is refused for before anything is computed: a mesh that is none, materials that there are not."""

from __future__ import annotations

import numpy as np

from porelang.diagnostics import fail
from porelang.fea.loads import Applied
from porelang.fea.problem import Floats, Ints, Mask, Problem
from porelang.fea.supports import Held
from porelang.fea.surface import place

#: A load of which supports take more than this share at once does nothing; one that is on the volume, all but that.
_TAKEN, _ALL = 0.9, 1 - 1e-12


def checked_mesh(vertices: Floats, tets: Ints) -> tuple[Floats, Ints]:
    """The arrays of a mesh, in their types. Errors: E175."""
    points, corners = np.asarray(vertices, np.float64), np.asarray(tets)
    if points.ndim != 2 or points.shape[1:] != (3,) or corners.ndim != 2 or corners.shape[1:] != (4,):
        raise fail(
            "E175",
            f"no tetrahedra: vertices have the shape {points.shape}, tetrahedra {corners.shape}",
            hint="give (n, 3) and (m, 4)",
        )
    if not len(corners):
        raise fail(
            "E175",
            "the mesh holds no tetrahedron",
            hint="mesh a part that is not empty, with elements smaller than its walls",
        )
    somewhere = np.isfinite(points).all(axis=1)
    if not somewhere.all():
        at = int(np.argmin(somewhere))
        raise fail("E175", f"vertex {at} of the mesh is at no place: {points[at]}", hint="mesh the part anew")
    if corners.dtype.kind not in "iu" or corners.min() < 0 or corners.max() >= len(points):
        raise fail(
            "E175",
            f"a tetrahedron names a vertex that is not there: there are {len(points)}",
            hint="number vertices from 0",
        )
    used = np.zeros(len(points), bool)
    used[corners] = True
    if not used.all():
        at = int(np.argmin(used))
        raise fail(
            "E175",
            f"vertex {at} at {place(points[at])}, and {(~used).sum()} in all, belong to no tetrahedron",
            hint="take the vertices of one phase alone, and number them anew",
        )
    return points, corners.astype(np.int32)


def checked_volumes(points: Floats, corners: Ints, volumes: Floats) -> None:
    """Errors: E175 for a tetrahedron that is inside out or flat."""
    longest = np.zeros(len(corners))
    for i in range(4):
        for j in range(i):
            np.maximum(longest, np.linalg.norm(points[corners[:, i]] - points[corners[:, j]], axis=1), out=longest)
    bad = ~(volumes > 1e-12 * longest**3)
    if bad.any():
        at = int(np.argmax(bad))
        where = place(points[corners[at]].mean(axis=0))
        raise fail(
            "E175",
            f"tetrahedron {at} at {where} has the volume {volumes[at]:.3g} mm3, and {bad.sum()} in all are flat or "
            f"inside out",
            hint="mesh the part anew; of a tetrahedron (a, b, c, d), d is on the side of (b - a) x (c - a)",
        )


def of_tets(value: Floats | float, count: int, name: str) -> Floats:
    """A number for each tetrahedron, (m,). Errors: E172."""
    try:
        found = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        found = np.full((), np.nan)
    if found.shape not in ((), (count,)):
        raise fail(
            "E172",
            f"{name} has the shape {found.shape} for {count} tetrahedra",
            hint="give one number, or one for each",
        )
    return np.ascontiguousarray(np.broadcast_to(found, (count,)))


def materials(problem: Problem, centres: Floats) -> tuple[Floats, Floats, Floats]:
    """Young's modulus, Poisson's ratio and density of the tetrahedra round `centres` (m, 3). Errors: E172."""
    count = len(centres)
    young, poisson, density = (
        of_tets(value, count, name)
        for value, name in (
            (problem.young, "Young's modulus"), (problem.poisson, "Poisson's ratio"), (problem.density, "the density"),
        )
    )  # fmt: skip
    _refuse(
        ~(np.isfinite(young) & (young > 0)),
        young,
        centres,
        "Young's modulus",
        "MPa",
        "it is above 0: a void is left out of the mesh, not given a small modulus",
    )
    inside = np.isfinite(poisson) & (poisson > -1) & (poisson < 0.5)
    _refuse(
        ~inside,
        poisson,
        centres,
        "Poisson's ratio",
        "",
        "it lies between -1 and 0.5; at 0.5 a material cannot be compressed, and its pressure is not given by "
        "displacements: take 0.49 for rubber",
    )
    _refuse(~(np.isfinite(density) & (density >= 0)), density, centres, "the density", "g/cm3", "it is 0 or more")
    return young, poisson, density


def _refuse(bad: Mask, values: Floats, centres: Floats, name: str, unit: str, hint: str) -> None:
    if bad.any():
        at = int(np.argmax(bad))
        everywhere = (
            ""
            if len(np.unique(values)) == 1 and not np.isnan(values).any()
            else f" at {place(centres[at])}, and so wrong in {bad.sum()} of {len(bad)} tetrahedra"
        )
        raise fail("E172", f"{name} is {values[at]:.6g} {unit}".rstrip() + everywhere, hint=hint)


def taken(load: Applied, held: Held) -> float:
    """Which share of the forces of a load is on nodes that are held against it: supports take that at once."""
    whole = float(np.abs(load.forces).sum())
    return float(np.abs(load.forces * held.components).sum()) / whole if whole > 0 else 0.0


def loaded(problem: Problem, loads: tuple[Applied, ...], held: Held, points: Floats) -> None:
    """Errors: E173 where there is neither a load nor a prescribed displacement, or where supports hold all that a load
    acts on."""
    for load in loads:
        share = taken(load, held)
        if share > (_ALL if load.on is None else _TAKEN):
            at = int(np.argmax(np.abs(load.forces * held.components).sum(axis=1)))
            every = f"{share:.0%} of it is on nodes that are held against it"
            if share > _ALL:
                every = "every node that it acts on is held against it"
            raise fail(
                "E173",
                f"{load.name} does nothing: {every}, as at {place(points[at])}",
                hint="hold less of the part, or load it elsewhere",
            )
    if not any(load.forces.any() for load in loads) and not held.displacement.any():
        what = "all its loads are 0" if problem.loads else "it has no load"
        raise fail(
            "E173",
            f"nothing loads the part: {what}, and no support moves it",
            hint="add a force, a pressure, its weight, or a support with a displacement",
        )
