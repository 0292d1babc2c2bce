"""What a lattice does as a material: a period of a design, homogenised at several resolutions and extrapolated.

The work on arrays is in `porelang.unitcell`; here a design becomes voxels, and numbers become a report.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.backwards import UNIVERSE
from porelang.analysis.box import part_box, unbounded_axes
from porelang.backends.numpy import NumpyField
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, fail
from porelang.formula import Formula
from porelang.ir import Node, node, order, within
from porelang.ops import kind
from porelang.program import Design
from porelang.progress import activity, checkpoint
from porelang.rewrites import flatten
from porelang.unitcell import moduli
from porelang.unitcell.effective import Effective, checked_ratio, conducted, homogenized
from porelang.unitcell.extrapolate import limit
from porelang.unitcell.fractions import fractions
from porelang.unitcell.period import DIFFERENT, Mismatch, middles, mismatches, voxels_of
from porelang.unitcell.pieces import Piece, pieces_of

Floats = NDArray[np.float64]
#: Voxels along the longest side of the finest grid, and of the others in units of that.
FINEST, SHARES = 64, (3 / 8, 1 / 2, 3 / 4, 1)
#: Samples along a side of a voxel; fewest and most voxels of the finest grid along a side.
FINE, FEWEST, MOST = 2, 8, 256
#: A relative error above which is said that the voxels are too coarse.
COARSE = 0.05
_WAVES = frozenset({"sin", "cos", "sin_turns", "cos_turns"})


@dataclass(frozen=True, slots=True)
class Level:
    """What one resolution gave: its voxels, and the effective properties of them."""

    voxels: tuple[int, int, int]
    stiffness: Effective
    conductivity: Effective


@dataclass(frozen=True)
class Homogenized:
    """What a period does as a material, for a solid of unit Young's modulus and unit conductivity.

    `cell` are its sides and `low` its lower corner (mm); `stiffness` (6, 6) is by Voigt with engineering shear (xx yy zz
    yz xz xy), `conductivity` (3, 3); each with an error of the same shape. All are extrapolated from the `levels`, with
    the `order` by the voxel. The `pieces` are those of the finest samples; `doubts` are warnings about it.
    """

    name: str
    cell: tuple[float, float, float]
    low: tuple[float, float, float]
    nu: float
    levels: tuple[Level, ...]
    density: float
    density_error: float
    stiffness: Floats = field(repr=False)
    stiffness_error: Floats = field(repr=False)
    conductivity: Floats = field(repr=False)
    conductivity_error: Floats = field(repr=False)
    order: float
    pieces: tuple[Piece, ...]
    doubts: tuple[Diagnostic, ...]
    seconds: float

    def young(self, directions: Any) -> Floats:
        """Young's modulus (n,) along directions (n, 3)."""
        return moduli.young(self.stiffness, directions)

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The moduli by their names: E.100, nu.100, zener, bulk, shear and so on; NaN where there is none."""
        return _numbers(self.stiffness, self.conductivity)

    @cached_property
    def errors(self) -> dict[str, float]:
        """The errors of the `numbers`: each extrapolated by itself, and what that differs by from theirs."""
        series = [_numbers(level.stiffness.matrix, level.conductivity.matrix) for level in self.levels]
        sizes = _sizes(self.levels)
        out = {}
        for name, value in self.numbers.items():
            found = limit(sizes, np.array([numbers[name] for numbers in series]))
            out[name] = max(float(found.error), abs(float(found.value) - value)) if len(self.levels) > 1 else np.inf
        return out

    def report(self) -> dict[str, Any]:
        """What `pore homogenize --json` prints."""
        numbers, errors = self.numbers, self.errors
        mean = moduli.averages(self.stiffness)
        bounds = moduli.upper_bounds(self.density, self.nu)
        heat = float(self.conductivity.trace() / 3)
        share = {"bulk": mean.bulk / bounds["bulk"], "shear": mean.shear / bounds["shear"],
                 "conductivity": heat / bounds["conductivity"]}  # fmt: skip
        return {
            "output": self.name,
            "cell": list(self.cell),
            "low": list(self.low),
            "solid": {"E": 1.0, "nu": self.nu, "conductivity": 1.0},
            "density": self.density,
            "stiffness": self.stiffness.tolist(),
            "E": {key: numbers[f"E.{key}"] for key in moduli.NAMED},
            "nu": {"100": numbers["nu.100"]},
            "G": {key: numbers[f"G.{key}"] for key in _SHEARS},
            "zener": numbers["zener"],
            "bulk": mean.bulk,
            "shear": mean.shear,
            "voigt": {"bulk": mean.bulk_voigt, "shear": mean.shear_voigt},
            "reuss": {"bulk": mean.bulk_reuss, "shear": mean.shear_reuss},
            "anisotropy": mean.anisotropy,
            "away_from_cubic": moduli.away_from_cubic(self.stiffness),
            "conductivity": self.conductivity.diagonal().tolist(),
            "conductivity_tensor": self.conductivity.tolist(),
            "hashin_shtrikman": {**bounds, "share": share},
            "error": {
                "density": self.density_error,
                "stiffness": self.stiffness_error.tolist(),
                "conductivity_tensor": self.conductivity_error.tolist(),
                "conductivity": self.conductivity_error.diagonal().tolist(),
                "E": {key: errors[f"E.{key}"] for key in moduli.NAMED},
                "nu": {"100": errors["nu.100"]},
                "G": {key: errors[f"G.{key}"] for key in _SHEARS},
                **{key: errors[key] for key in ("zener", "bulk", "shear")},
            },
            "order": self.order,
            "levels": [
                {"voxels": list(at.voxels), "density": at.stiffness.density, "stiffness": at.stiffness.matrix.tolist(),
                 "conductivity_tensor": at.conductivity.matrix.tolist(), "cases": at.stiffness.solved,
                 "steps": at.stiffness.steps, "residual": at.stiffness.residual}
                for at in self.levels
            ],
            "pieces": [{"share": p.share, "at": self.place(p.at), "leads": [a for a, on in zip("xyz", p.leads, strict=True) if on]}
                       for p in self.pieces[:10]],
            "piece_count": len(self.pieces),
            "seconds": self.seconds,
        }  # fmt: skip

    def place(self, index: Sequence[int]) -> list[float]:
        """The place (mm) of a sample of the finest level."""
        counts = [FINE * n for n in self.levels[-1].voxels]
        return [lo + (i + 0.5) * c / n for lo, c, i, n in zip(self.low, self.cell, index, counts, strict=True)]


_SHEARS = {"yz": 3, "xz": 4, "xy": 5}


def _numbers(stiffness: Floats, conductivity: Floats) -> dict[str, float]:
    s, mean = moduli.compliance(stiffness), moduli.averages(stiffness)
    along = moduli.young(stiffness, list(moduli.NAMED.values()))
    out = {f"E.{key}": float(e) for key, e in zip(moduli.NAMED, along, strict=True)}
    out["nu.100"] = float(-(s[0, 1] + s[0, 2]) / 2 / s[0, 0]) if out["E.100"] else np.nan
    shears = {key: float(1 / s[i, i]) for key, i in _SHEARS.items()}
    out |= {f"G.{key}": g if g > moduli.NOTHING else 0.0 for key, g in shears.items()}
    return out | {"zener": moduli.zener(stiffness), "bulk": mean.bulk, "shear": mean.shear,
                  "conductivity": float(conductivity.trace() / 3)}  # fmt: skip


def homogenize(
    design: Design,
    name: str | None = None,
    cell: Sequence[float] | None = None,
    nu: float = 0.3,
    finest: int = FINEST,
    threads: int | None = None,
) -> Homogenized:
    """A period of an output of a design as a material; `cell` are its sides in mm, else those of its lattices.

    The period is centred at the origin, or where the part is as large as that and ends, at its middle. It is solved at
    `finest` voxels along its longest side, and at 3/4, 1/2 and 3/8 of them. Errors: those of the output; E180 where the
    cell is not known, E181 where it is no period, E182 where it is empty or an envelope cuts it, E183 for a Poisson's
    ratio that no solid has.
    """
    begun = time.perf_counter()
    name = design.program.output(name)
    checked_ratio(nu)
    if not isinstance(finest, int | np.integer) or isinstance(finest, bool) or not FEWEST <= finest <= MOST:
        raise fail("E180", f"a finest grid of {finest!r:.40} voxels is not to be had",
                   hint=f"take from {FEWEST} to {MOST} along the longest side, as by --resolution 64")  # fmt: skip
    part = design.of(name)
    sides = _cell(design, name, part, cell)
    low = _corner(part, sides)
    doubts = _is_period(part, low, sides)
    levels, pieces = [], []
    for n in dict.fromkeys(max(4, round(share * finest)) for share in SHARES):
        voxels = voxels_of(sides, n)
        values = _sampled(part, low, sides, voxels)
        density = fractions(values, FINE)
        if not density.any():
            raise fail("E182", f"the cell from {_place(low)} to {_place(low + sides)} holds no material",
                       hint="solid is negative; the cell is looked at round the origin")  # fmt: skip
        with activity(f"homogenizing {' x '.join(map(str, voxels))} voxels"):
            levels.append(Level(voxels, homogenized(density, sides, nu, threads=threads), conducted(density, sides)))
        pieces = pieces_of(values < 0) if n == finest else pieces
    sizes = _sizes(levels)
    stiff = limit(sizes, np.array([at.stiffness.matrix for at in levels]))
    heat = limit(sizes, np.array([at.conductivity.matrix for at in levels]))
    share = limit(sizes, np.array([at.stiffness.density for at in levels]))
    found = Homogenized(
        name, tuple(map(float, sides)), tuple(map(float, low)), nu, tuple(levels),  # type: ignore[arg-type]
        float(np.clip(share.value, 0, 1)), float(share.error), _tidy(stiff.value), stiff.error, _tidy(heat.value),
        heat.error, stiff.order, tuple(pieces), (), 0.0,
    )  # fmt: skip
    doubts += _doubts(found)
    return replace(found, doubts=tuple(doubts), seconds=round(time.perf_counter() - begun, 3))


def _tidy(matrix: Floats) -> Floats:
    """A matrix without what is rounding beside its largest entry."""
    return np.where(np.abs(matrix) < 1e-10 * np.abs(matrix).max(), 0.0, matrix)


def _sizes(levels: Sequence[Level]) -> Floats:
    return np.array([1 / max(level.voxels) for level in levels])


def _cell(design: Design, name: str, part: Formula, given: Sequence[float] | None) -> Floats:
    """The sides (mm) of the period that is asked for, or that the lattices of the part have. Errors: E180."""
    if given is not None:
        try:
            sides = np.array([float(v) for v in given])
        except (TypeError, ValueError):
            sides = np.zeros(0)
        if sides.shape != (3,) or not (np.isfinite(sides).all() and sides.min() > 1e-6 and sides.max() < 1e5):
            raise fail("E180", f"a cell of {given!r:.60} has no volume", hint="give its sides in mm: --cell 10,10,15")
        if sides.max() > 32 * sides.min():
            raise fail("E180", f"a cell of {' x '.join(f'{s:g}' for s in sides)} mm is too long for its width",
                       hint="take a shorter period: along an axis where nothing varies any length is one")  # fmt: skip
        return sides
    output = design.program.outputs[name]
    known = design.program.elaborated.lattices
    used = {n: known[n][1] for n in order(output.nodes, within) if n in known}
    periods = sorted({_length(design, w) for w in used.values() if w is not None})
    how = "say how long a period is along x, y and z, as by --cell 10,10,15"
    if not used:
        raise fail("E180", f"`{name}` has no lattice whose period could be its cell", output.span, hint=how)
    if any(w is None for w in used.values()):
        raise fail("E180", f"a lattice of `{name}` has not one period", output.span, hint=how,
                   label="given as a phase, as three lengths or as a field")  # fmt: skip
    longest = periods[-1]
    if any(abs(longest / w - round(longest / w)) > 1e-9 for w in periods):
        told = " and ".join(f"{w:g} mm" for w in periods)
        raise fail("E180", f"`{name}` has lattices of periods {told}, of which none is that of all", output.span,
                   hint=how)  # fmt: skip
    return np.full(3, longest)


def _length(design: Design, period: Node) -> float:
    return float(design.formula(*flatten(period)).numbers[0])


def _corner(part: Formula, sides: Floats) -> Floats:
    """The lower corner of the period: that of the part along axes where it is just as long, else half a side below 0."""
    box = part_box(part)
    low = -sides / 2
    if box is None:
        return low
    free = unbounded_axes(box)
    size, corner = np.array(box.size), np.array(box.lo)
    same = np.abs(size - sides) < 1e-3 * sides
    return np.where([axis not in free for axis in "xyz"] & same, corner + (size - sides) / 2, low)


def _is_period(part: Formula, low: Floats, sides: Floats) -> list[Diagnostic]:
    """What is doubtful of a box as a period of a part. Errors: E181 where it is none, E182 where an envelope cuts it."""
    cutting = _cut_by(part, low, sides)
    if cutting is not None:
        raise fail("E182", f"the part is cut by its envelope within the cell, as at {_place(cutting)}",
                   hint="homogenize the lattice alone: make an output of it, and name that by --out NAME")  # fmt: skip
    evaluated = NumpyField(part, "f64")
    with np.errstate(all="ignore"):
        odd = mismatches(lambda p: np.asarray(evaluated.at(p), np.float64), low, sides)
    if not odd:
        return []
    worst = max(odd, key=lambda m: m.share)
    told = _told(worst, sides)
    if worst.share > DIFFERENT:
        many = "the period of its lattices" if len(odd) > 1 else f"its period along {'xyz'[worst.axis]}"
        raise fail("E181", f"a cell of {' x '.join(f'{s:g}' for s in sides)} mm is no period of the part: {told}",
                   hint=f"give {many} by --cell; a lattice that is turned, graded or cut has none")  # fmt: skip
    return [Diagnostic("W260", f"the cell is only nearly a period of the part: {told}",
                       hint="check the sides of --cell", severity="warning")]  # fmt: skip


def _told(odd: Mismatch, sides: Floats) -> str:
    there = np.array(odd.at)
    there[odd.axis] += sides[odd.axis]
    return (f"across {'xyz'[odd.axis]}, {odd.share:.2g} of the points of a face are solid on one side and void on the "
            f"other; the field is {odd.below:.4g} at {_place(odd.at)} and {odd.above:.4g} at {_place(there)}")  # fmt: skip


def _place(point: Any) -> str:
    return f"({coordinates(point, 4)}) mm"


def _cut_by(part: Formula, low: Floats, sides: Floats) -> Floats | None:
    """A place within a cell where a body with an end cuts off the lattice, if there is one."""
    members = _members(part.root)
    plain = [n for n in members if n.axes and n.op != "neg" and kind(n) == "real" and not _waves(n)]
    if not plain or not any(map(_waves, members)):
        return None
    envelope = plain[0]
    for n in plain[1:]:
        envelope = node("max", envelope, n)
    around = part_box(part.with_roots(envelope))
    if around is None or unbounded_axes(around):
        return None
    axes = middles(low, sides, (24, 24, 24))
    with np.errstate(all="ignore"):
        outside = np.argwhere(np.asarray(NumpyField(part.with_roots(envelope), "f64").on_grid(axes).all()) > 0)
    return np.array([axis[i] for axis, i in zip(axes, outside[0], strict=True)]) if len(outside) else None


def _members(n: Node) -> list[Node]:
    """What a solid is the intersection of."""
    return [m for a in n.args for m in _members(a)] if n.op == "max" else [n]


def _waves(n: Node) -> bool:
    return any(m.op in _WAVES and m.axes for m in order([n], within))


def _sampled(part: Formula, low: Floats, sides: Floats, voxels: tuple[int, int, int]) -> Floats:
    """The field in the middle of FINE^3 parts of each voxel. Errors: E182 where it is not a number."""
    nx, ny, nz = (FINE * n for n in voxels)
    axes = middles(low, sides, (nx, ny, nz))
    grid = NumpyField(part, "f64").on_grid(axes)
    values = np.empty((nx, ny, nz))
    with np.errstate(all="ignore"):
        for i in range(nx):
            checkpoint()
            values[i] = grid.block((i, 0, 0), (i + 1, ny, nz))[0]
    bad = np.argwhere(np.isnan(values))
    if len(bad):
        at = [axis[i] for axis, i in zip(axes, bad[0], strict=True)]
        raise fail("E182", f"the field is not a number at {_place(at)}",
                   hint="look for the square root or the logarithm of something negative")  # fmt: skip
    return values


def _doubts(found: Homogenized) -> list[Diagnostic]:
    """Warnings about what was found."""
    out = []
    islands = [p for p in found.pieces if not any(p.leads)]
    if islands:
        share = sum(p.share for p in islands)
        many = "a piece" if len(islands) == 1 else f"{len(islands)} pieces"
        hangs = "hangs" if len(islands) == 1 else "hang"
        out.append(Diagnostic(
            "W261", f"{many} of the solid, {share:.2g} of it, {hangs} by nothing: the largest at "
            f"{_place(found.place(islands[0].at))}", severity="warning",
            hint="they carry nothing and count as density; take them off, or join them to the rest"))  # fmt: skip
    closed = [axis for i, axis in enumerate("xyz") if not any(p.leads[i] for p in found.pieces)]
    if closed:
        along = " and ".join(closed)
        out.append(Diagnostic(
            "W262", f"no solid leads from one cell to the next along {along}: there is no stiffness that way",
            hint="a thicker wall may join them; or the cell is not the period that is meant", severity="warning"))  # fmt: skip
    worst = max(("100", "010", "001"), key=lambda k: found.errors[f"E.{k}"] / max(found.numbers[f"E.{k}"], 1e-300)
                if found.numbers[f"E.{k}"] else 0.0)  # fmt: skip
    e, error = found.numbers[f"E.{worst}"], found.errors[f"E.{worst}"]
    if e and error > COARSE * e:
        finest = max(found.levels[-1].voxels)
        out.append(Diagnostic(
            "W263", f"{finest} voxels along the cell are too coarse: E along {worst} is {e:.3g} +- {error:.2g}",
            hint=f"use --resolution {min(MOST, 2 * finest)}: a wall wants three voxels", severity="warning"))  # fmt: skip
    return out
