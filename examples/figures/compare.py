"""The paper's comparison (3.2): the specimens of Figures 8 to 10 under axial load, as a table with mesh errors.

    python examples/figures/compare.py docs/comparison.md

Each specimen is meshed at three sizes and solved between rigid platens, bonded and frictionless. What is solved is kept
in `comparison.jsonl` beside this file, so that an interrupted run goes on. What is there is not solved again: move it
away to solve all again, which takes four hours and 16 GB.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from textwrap import wrap
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

import porelang
from porelang.atomic import save
from porelang.fea import Force, Problem, Solution, Support, solve
from porelang.materials import MATERIALS
from porelang.tet.tetmesh import TetMesh

HERE = Path(__file__).parent
KEPT = HERE / "comparison.jsonl"

RADIUS, HEIGHT = 75.0, 300.0  # mm: the specimen of Figure 8
FORCE = 10_000.0  # N, along the axis
PA12 = MATERIALS["PA12"]  # only its Poisson's ratio can change a ranking
YOUNG, POISSON, DENSITY = PA12.young, PA12.poisson, PA12.density
SIZES = (4.7, 4.1, 3.5)  # mm: no parts of the period, and the shell of 4.5 mm breaks up in cubes much larger
ORDER = 2  # with which quantities are taken to converge
NEAR = 1e-6  # mm


@dataclass(frozen=True, slots=True)
class Specimen:
    """A program, the settings that a variant has, and what it is called in the table; its cubes are so much `coarser`
    than those of others."""

    name: str
    file: str
    text: str = ""
    coarser: float = 1.0

    @property
    def sizes(self) -> tuple[float, ...]:
        """The cubes (mm) that it is meshed with, the finest last."""
        return tuple(round(self.coarser * size, 2) for size in SIZES)

    @property
    def short(self) -> str:
        """Its figure: 8a."""
        number, letter, *_ = self.name.split()
        return number + letter.strip("()")


#: In the order of the figures.
SPECIMENS = (
    Specimen("8 (a) regular gyroid", "fig08a_regular.pore"),
    Specimen("8 (b) its shell", "fig08b_shell.pore"),
    Specimen("8 (c) polar gyroid", "fig08c_polar.pore"),
    Specimen("9 (a) Cartesian and polar", "fig09a_blend.pore"),
    # cells that shrink to nothing at the axis: cubes are halved there until there are as many as of half the size
    Specimen("9 (b) polar diamond", "fig09b_polar_diamond.pore", coarser=1.4),
    Specimen("9 (c) turned diamond", "fig09c_turned_diamond.pore"),
    Specimen("10 (b) adaptive thickness", "fig10b_thickness.pore"),
    Specimen("10 (c) adaptive wavelength", "fig10c_wavelength.pore"),
)
_STRESSED = 'use "fig06_field.pore" as figure6\nlet specimen = figure6.specimen\n'
#: What Figure 10 (b) could have been besides: the paper states neither its factor nor its sign.
VARIANTS = (
    Specimen("half the factor", "", _STRESSED + "let raw = gyroid(30mm) |> thicken(-figure6.stress, 0.9)\n"
             "raw |> offset(to_porosity(raw, 50%, specimen)) & specimen"),
    Specimen("the other sign", "", _STRESSED + "let raw = gyroid(30mm) |> thicken(figure6.stress, 1.8)\n"
             "raw |> offset(to_porosity(raw, 50%, specimen)) & specimen"),
    Specimen("other sign, half the factor", "", _STRESSED + "let raw = gyroid(30mm) |> thicken(figure6.stress, 0.9)\n"
             "raw |> offset(to_porosity(raw, 50%, specimen)) & specimen"),
    Specimen("other sign, half the factor, porosity not restored", "",
             _STRESSED + "gyroid(30mm) |> thicken(figure6.stress, 0.9) & specimen"),
)  # fmt: skip

#: How a specimen is loaded: what its two ends may do.
BONDED, FRICTIONLESS, SPREAD = "bonded platens", "frictionless platens", "bonded below, a force spread over the top"


def _ends(points: NDArray[np.float64], sign: int) -> NDArray[np.bool_]:
    return np.asarray(np.abs(points[:, 2] - sign * HEIGHT / 2) < NEAR)


def _problem(mesh: TetMesh, loading: str, poisson: float) -> Problem:
    bonded = loading != FRICTIONLESS
    axes = (bonded, bonded, True)
    below = Support(lambda p: _ends(p, -1), axes=axes, name="below")
    if loading == SPREAD:
        load = Force(lambda p: _ends(p, 1), (0.0, 0.0, -FORCE), name="above")
        return Problem(mesh, YOUNG, poisson, DENSITY, (below,), (load,))
    above = Support(lambda p: _ends(p, 1), axes=axes, displacement=(0.0, 0.0, -1.0), name="above")
    return Problem(mesh, YOUNG, poisson, DENSITY, (below, above), balanced=True)


def _loaded(problem: Problem, loading: str) -> Solution:
    found = solve(problem)
    return found if loading == SPREAD else found.scaled(FORCE / abs(float(found.reactions[0].force[2])))


def _figures(found: Solution, loading: str, porosity: float) -> dict[str, float]:
    points, moved = found.nodes.points, found.displacement
    top = _ends(points, 1)
    shortened = -float(moved[top, 2].mean())
    area = np.pi * RADIUS**2
    return {
        "max": float(np.linalg.norm(moved, axis=1).max()),
        "mean": found.mean_displacement,
        "modulus": FORCE / area * HEIGHT / shortened,
        "stress": found.percentile(found.von_mises, 99),
        "mass": found.mass / 1000,
        "porosity": porosity,
        "unknowns": found.unknowns,
        "zz": found.error.relative,
    }


def _design(specimen: Specimen) -> porelang.Design:
    if specimen.file:
        return porelang.compile(path=HERE / specimen.file).design()
    return porelang.compile(specimen.text, name=str(HERE / "variant.pore")).design()


def solved(specimen: Specimen, sizes: tuple[float, ...], loadings: tuple[str, ...], poisson: float = POISSON) -> None:
    """Solve what is not kept yet, and keep it."""
    kept = _kept()
    design = None
    for size in sizes:
        wanted = [loading for loading in loadings if (specimen.name, size, loading, poisson) not in kept]
        if not wanted:
            continue
        design = design or _design(specimen)
        part = design.tet(size=size)
        porosity = 1 - part.report["volume"] / (np.pi * RADIUS**2 * HEIGHT)
        for loading in wanted:
            found = _loaded(_problem(part.mesh, loading, poisson), loading)
            row = {"name": specimen.name, "size": size, "loading": loading, "poisson": poisson}
            row |= _figures(found, loading, porosity) | {"dropped": part.report["dropped_volume_fraction"]}
            with KEPT.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
            print(f"{specimen.name}, {size} mm, {loading}: {row['max']:.4f} mm", flush=True)


def _kept() -> dict[tuple[str, float, str, float], dict[str, float]]:
    if not KEPT.exists():
        return {}
    rows = [json.loads(line) for line in KEPT.read_text(encoding="utf-8").splitlines()]
    return {(row["name"], row["size"], row["loading"], row["poisson"]): row for row in rows}


@dataclass(frozen=True, slots=True)
class Converged:
    """A quantity at the finest mesh, and how far it may be from its limit."""

    value: float
    error: float

    def shown(self, digits: int) -> str:
        """As a cell of a table."""
        return f"{self.value:.{digits}f} ± {self.error:.{digits}f}"

    def overlaps(self, other: Converged) -> bool:
        """Whether the two could be the same."""
        return abs(self.value - other.value) <= self.error + other.error


def converged(values: list[float]) -> Converged:
    """What three meshes tell: the last value, and what is still to come if the steps shrink with the square of the
    size; no less than half of the larger step, so that meshes that agree by chance are not taken at their word."""
    (_, first), (_, last) = pairwise(values)
    steps = first - values[0], last - values[1]
    to_come = abs(steps[1]) / ((SIZES[1] / SIZES[2]) ** ORDER - 1)
    return Converged(values[2], max(to_come, max(abs(s) for s in steps) / 2))


COLUMNS: Mapping[str, tuple[str, int]] = {
    "max": ("max displacement, mm", 4),
    "mean": ("mean displacement, mm", 4),
    "modulus": ("effective modulus, MPa", 1),
    "stress": ("von Mises, 99 %, MPa", 2),
}


def table(loading: str) -> tuple[list[str], dict[str, Converged]]:
    """The lines of a table, and each specimen's greatest displacement."""
    kept, lines, most = _kept(), [], {}
    lines.append(
        "| specimen | " + " | ".join(title for title, _ in COLUMNS.values()) + " | mass, kg | porosity | dropped |"
    )
    lines.append("|---" * (len(COLUMNS) + 4) + "|")
    for specimen in SPECIMENS:
        rows = [kept[specimen.name, size, loading, POISSON] for size in specimen.sizes]
        found = {key: converged([row[key] for row in rows]) for key in COLUMNS}
        most[specimen.name] = found["max"]
        cells = [found[key].shown(digits) for key, (_, digits) in COLUMNS.items()]
        last = rows[-1]
        cells += [f"{last['mass']:.3f}", f"{last['porosity']:.4f}", f"{last['dropped']:.2%}"]
        lines.append(f"| {specimen.name} | {' | '.join(cells)} |")
    return lines, most


def _claims(loading: str, most: Mapping[str, Converged]) -> list[str]:
    """What becomes of the paper's three claims under a loading."""
    greatest, least = max(most, key=lambda n: most[n].value), min(most, key=lambda n: most[n].value)
    adaptive, shell = SPECIMENS[6].name, SPECIMENS[1].name

    def verdict(claimed: str, found: str) -> str:
        if claimed == found:
            return "holds"
        beside = most[claimed].overlaps(most[found])
        return f"is not resolved: {found} is within the mesh errors" if beside else f"does not hold: it is {found}"

    alike = [most[SPECIMENS[i].name] for i in (0, 2, 4)]
    spread = max(a.value for a in alike) / min(a.value for a in alike) - 1
    others = [m.value for name, m in most.items() if name != greatest]
    unsure = max(m.error / m.value for m in (most[SPECIMENS[i].name] for i in (0, 2, 4)))
    told = (
        f"*{loading}*: that adaptive thickness deforms most {verdict(adaptive, greatest)}; that the shell deforms "
        f"least {verdict(shell, least)}; regular gyroid, polar gyroid and polar diamond lie within {spread:.0%} of "
        f"each other (one of them known to {unsure:.0%}), where all but the softest lie within "
        f"{max(others) / min(others) - 1:.0%}."
    )
    return wrap(told, 118, initial_indent="- ", subsequent_indent="  ")


def _sensitivity() -> list[str]:
    kept = _kept()
    lines = ["| | greatest displacement, of the regular gyroid's | its mass |", "|---|---|---|"]
    base = kept[SPECIMENS[0].name, SPECIMENS[0].sizes[1], BONDED, POISSON]
    shown = [("10 (b) as drawn", kept[SPECIMENS[6].name, SPECIMENS[6].sizes[1], BONDED, POISSON])]
    shown += [(variant.name, kept[variant.name, variant.sizes[1], BONDED, POISSON]) for variant in VARIANTS]
    lines += [f"| {name} | {row['max'] / base['max']:.2f} | {row['mass'] / base['mass']:.2f} |" for name, row in shown]
    return lines


def _orders() -> list[str]:
    kept = _kept()
    cases = ((BONDED, POISSON), (FRICTIONLESS, POISSON), (SPREAD, POISSON), (BONDED, 0.3))
    lines = ["| loading | Poisson's ratio | from stiffest to softest: greatest displacement of a node, mm |"]
    lines.append("|---|---|---|")
    for loading, poisson in cases:
        found = {s.short: kept[s.name, s.sizes[1], loading, poisson]["max"] for s in SPECIMENS}
        order = " < ".join(f"{name} {found[name]:.3f}" for name in sorted(found, key=lambda name: found[name]))
        lines.append(f"| {loading} | {poisson:g} | {order} |")
    return lines


#: docs/comparison.md, but for its tables.
PAGE = """\
# The specimens of Figures 8 to 10, compared

Section 3.2 of the paper reports a linear elastic analysis of its compression specimens, without figures, loads,
material or supports: adaptive thickness (Figure 10 b) deforms most, the shell (8 b) least, regular gyroid, polar gyroid
and polar diamond almost alike. Here is that analysis, with what it takes to check it.

Cylinders of {diameter:g} mm x {height:g} mm, porosity 0.5, {force:g} kN along the axis; PA12, E = {young:g} MPa,
nu = {poisson:g}. A rigid platen at each end: bonded (the ends do not move sideways) or frictionless (they do).
Quadratic tetrahedra in cubes of {sizes} mm, {unknowns} million unknowns; those of the polar diamond, whose
cells shrink to wedges near the axis, are {coarser:g} times as large, and halved there. Values are those of the finest
mesh; behind ± is what finer ones may still change: the last step over r^{order} - 1, r the ratio of the sizes, or half
of the larger step if that is more. Half of the displacements are known to {typical:.1%}; where three meshes agree far
better (8 c), that is chance, and no promise. Displacements are in proportion to the force and to 1/E. *Dropped* is the
share of the volume that hung together with nothing in the finest mesh.

`python examples/figures/compare.py docs/comparison.md` writes this page from what was solved,
[comparison.jsonl](../examples/figures/comparison.jsonl); what is missing there, it solves.

{tables}
## The paper's claims

{claims}

## How sensitive that is

Adaptive thickness in other readings of the paper (bonded, cubes of {middle:g} mm): Eq 3 has the sign with which stress
*erodes*, and its factor is not stated.

{sensitivity}

The order under other loads, supports and another Poisson's ratio (cubes of {middle:g} mm). Without a plate above, the
greatest displacement is that of the loosest flap of a cut sheet at the top: it tells of the cut, not of the lattice.

{orders}
"""


def page() -> str:
    """docs/comparison.md."""
    tables, claims, errors = [], [], []
    for loading in (BONDED, FRICTIONLESS):
        lines, most = table(loading)
        tables += [f"## {loading.capitalize()}", "", *lines, ""]
        claims += _claims(loading, most)
        errors += [m.error / m.value for m in most.values()]
    unknowns = [row["unknowns"] / 1e6 for row in _kept().values()]
    return PAGE.format(
        unknowns=f"{min(unknowns):.1f} to {max(unknowns):.1f}", coarser=SPECIMENS[4].coarser,
        typical=median(errors), diameter=2 * RADIUS, height=HEIGHT, force=FORCE / 1000, young=YOUNG, poisson=POISSON,
        sizes=", ".join(f"{size:g}" for size in SIZES), middle=SIZES[1], order=ORDER, tables="\n".join(tables),
        claims="\n".join(claims), sensitivity="\n".join(_sensitivity()), orders="\n".join(_orders()),
    )  # fmt: skip


def main() -> None:
    for specimen in SPECIMENS:
        solved(specimen, specimen.sizes, (BONDED, FRICTIONLESS))
        solved(specimen, specimen.sizes[1:2], (SPREAD,))
        solved(specimen, specimen.sizes[1:2], (BONDED,), poisson=0.3)
    for variant in VARIANTS:
        solved(variant, variant.sizes[1:2], (BONDED,))
    text = page()
    save(sys.argv[1], lambda file: _write(file, text))


def _write(file: BinaryIO, text: str) -> None:
    file.write(text.encode())


if __name__ == "__main__":
    main()
