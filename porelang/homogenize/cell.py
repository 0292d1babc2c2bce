"""The period of a part: how long it is, where it lies, whether it is one, and the field in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box, part_box, unbounded_axes
from porelang.backends.numpy import NumpyField
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, fail
from porelang.formula import Formula
from porelang.ir import ZERO, Node, node, order, within
from porelang.ops import kind
from porelang.program import Design
from porelang.progress import tell
from porelang.rewrites import flatten
from porelang.unitcell.effective import checked_sides
from porelang.unitcell.fractions import averaged, creases, fractions, shares
from porelang.unitcell.grids import Grids
from porelang.unitcell.period import DIFFERENT, Mismatch, middles, mismatches, strayed

Floats = NDArray[np.float64]
#: Signs of samples that pieces are counted of: so many along a side at most.
MOST_SIGNS = 192
#: What the density of every third sample errs by, in units of what that of all does: between orders 1 and 2.
_SPREAD = 4.0
#: How far a lattice without an end is looked at, in sides of its cell to each side.
FAR = 32
#: What repeats: a lattice has one of these in it, or the bars of a truss.
_WAVES = frozenset({"sin", "cos", "sin_turns", "cos_turns"})
_BARS = frozenset({"nearest", "joined"})


def sides_of(design: Design, name: str, given: Any) -> Floats:
    """The sides (mm) of the period that is asked for, or that the lattices of the part have. Errors: E180."""
    if given is not None:
        return checked_sides(given)
    output = design.program.outputs[name]
    known = design.program.elaborated.lattices
    used = {n: known[n][1] or _phased(n) for n in order(output.nodes, within) if n in known}
    periods = sorted({_length(design, w) for w in used.values() if w is not None})
    how = "say how long a period is along x, y and z, as by --cell 10,10,15"
    if not used:
        raise fail("E180", f"`{name}` has no lattice whose period could be its cell", output.span, hint=how)
    if any(w is None for w in used.values()):
        raise fail("E180", f"a lattice of `{name}` has not one period", output.span, hint=how,
                   label="given as a phase of several sizes, as three lengths or as a field")  # fmt: skip
    longest = periods[-1]
    if any(abs(longest / w - round(longest / w)) > 1e-9 for w in periods):
        told = " and ".join(f"{w:g} mm" for w in periods)
        raise fail("E180", f"`{name}` has lattices of periods {told}, of which none is that of all", output.span,
                   hint=how)  # fmt: skip
    return np.full(3, longest)


def _phased(lattice: Node) -> Node | None:
    """The one size of the cells of the phases that a lattice reads, where it is the same everywhere and kept as it is;
    None where there is none such."""
    sizes = set()
    for phase in (n for n in order([lattice], within) if n.op == "phase"):
        size, body, *_ = phase.args
        # three sizes, one for each axis, have no place yet either; and a number of cells makes others of them
        if size.axes or not body.axes or phase.args[4] is not ZERO:
            return None
        sizes.add(size)
    return sizes.pop() if len(sizes) == 1 else None


def _length(design: Design, period: Node) -> float:
    return float(design.formula(*flatten(period)).numbers[0])


def corner_of(part: Formula, sides: Floats, middle: Sequence[float] = (0.0, 0.0, 0.0)) -> Floats:
    """The lower corner of the period: that of the part along axes where it is as long, else half a side below a middle
    (3,)."""
    box = part_box(part)
    low: Floats = np.asarray(middle, np.float64) - sides / 2
    if box is None:
        return low
    free = unbounded_axes(box)
    size, corner = np.array(box.size), np.array(box.lo)
    same = np.abs(size - sides) < 1e-3 * sides
    return np.where([axis not in free for axis in "xyz"] & same, corner + (size - sides) / 2, low)


def period_doubts(part: Formula, low: Floats, sides: Floats, reach: Box | None = None) -> list[Diagnostic]:
    """What is doubtful of a box as a period of a part, in the box `reach` or as far as it goes. Errors: E181 where it
    is none, E182 where an envelope cuts it."""
    envelope, lattice = _apart(part)
    cutting = _cut_by(envelope, low, sides)
    if cutting is not None:
        raise fail("E182", f"the part is cut by its envelope within the cell, as at {place(cutting)}",
                   hint="homogenize the lattice alone: make an output of it, and name that by --out NAME")  # fmt: skip
    cell = f"a cell of {' x '.join(f'{s:g}' for s in sides)} mm is no period of the part"
    odd = mismatches(_asked(part), low, sides)
    worst = max(odd, key=lambda m: m.share, default=None)
    if worst is not None and worst.share > DIFFERENT:
        many = "the period of its lattices" if len(odd) > 1 else f"its period along {'xyz'[worst.axis]}"
        raise fail("E181", f"{cell}: {_told(worst, sides)}",
                   hint=f"give {many} by --cell; a lattice that is turned, graded or cut has none")  # fmt: skip
    away = None
    if lattice is not None:
        cut = None if envelope is None else _asked(envelope)
        away = strayed(_asked(lattice), cut, low, sides, *_reach(reach or part_box(part), low, sides))
    if away is not None:
        seen = f"the field is {away.here:.4g} at {place(away.at)} and {away.home:.4g} at {place(away.within)}"
        told = f"{away.share:.2g} of the points of the part are solid and void in the cell, or the reverse; {seen}"
        # of a side that is a little off, as the faces show, more and more is different from cell to cell
        if away.share > DIFFERENT * (FAR if odd else 1):
            raise fail("E181", f"{cell}, whole numbers of sides away: {told}",
                       hint=_elsewhere(part))  # fmt: skip
    if worst is not None:
        told = _told(worst, sides)
    elif away is None:
        return []
    return [Diagnostic("W260", f"the cell is only nearly a period of the part: {told}",
                       hint="check the sides of --cell", severity="warning")]  # fmt: skip


def _elsewhere(part: Formula) -> str:
    if part.root.op == "min":
        return ("what is joined by | has to have this period as far as each of it goes; & binds before |: what is cut "
                "as a whole stands in brackets, (a | b) & body")  # fmt: skip
    return ("a lattice that is graded or blended is another material at every place: make an output of it as it is at "
            "one; or cut one period out, as by & box(...)")  # fmt: skip


def _asked(part: Formula) -> Callable[[Floats], Floats]:
    """The field at points (n, 3)."""
    evaluated = NumpyField(part, "f64")

    def at(points: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return np.asarray(evaluated.at(points), np.float64)

    return at


def _reach(box: Box | None, low: Floats, sides: Floats) -> tuple[Floats, Floats]:
    """The corners (mm) of the box of a part; along axes that it has no end, FAR sides of the cell to
    both sides of it."""
    lo, hi = low - FAR * sides, low + (FAR + 1) * sides
    if box is None:
        return lo, hi
    ends = [axis not in unbounded_axes(box) for axis in "xyz"]
    return np.where(ends, box.lo, lo), np.where(ends, box.hi, hi)


def _told(odd: Mismatch, sides: Floats) -> str:
    there = np.array(odd.at)
    there[odd.axis] += sides[odd.axis]
    seen = f"the field is {odd.below:.4g} at {place(odd.at)} and {odd.above:.4g} at {place(there)}"
    across = "xyz"[odd.axis]
    return f"across {across}, {odd.share:.2g} of the points of a face are solid here and void there; {seen}"


def place(point: Any) -> str:
    return f"({coordinates(point, 4)}) mm"


def _apart(part: Formula) -> tuple[Formula | None, Formula | None]:
    """The envelope of a part, which is what of an intersection has no waves in it, and its lattice, which has."""
    members = _members(part.root)
    if not any(map(_waves, members)):
        return None, None
    plain = [n for n in members if n.axes and n.op != "neg" and kind(n) == "real" and not _waves(n)]
    return (part.with_roots(_met(plain)) if plain else None), lattice_of(part)


def _met(nodes: list[Node]) -> Node:
    """The intersection of solids."""
    out = nodes[0]
    for n in nodes[1:]:
        out = node("max", out, n)
    return out


def _cut_by(envelope: Formula | None, low: Floats, sides: Floats) -> Floats | None:
    """A place within a cell where a body with an end cuts off the lattice, if there is one."""
    around = None if envelope is None else part_box(envelope)
    if envelope is None or around is None or unbounded_axes(around):
        return None
    axes = middles(low, sides, (24, 24, 24))
    with np.errstate(all="ignore"):
        outside = np.argwhere(np.asarray(NumpyField(envelope, "f64").on_grid(axes).all()) > 0)
    return np.array([axis[i] for axis, i in zip(axes, outside[0], strict=True)]) if len(outside) else None


def lattice_of(part: Formula) -> Formula:
    """The lattice of a part without the envelope that cuts it: of an intersection what has waves, else the part."""
    lattice = [n for n in _members(part.root) if _waves(n)]
    return part.with_roots(_met(lattice)) if lattice else part


def _members(n: Node) -> list[Node]:
    """What a solid is the intersection of."""
    return [m for a in n.args for m in _members(a)] if n.op == "max" else [n]


def _waves(n: Node) -> bool:
    return any(m.axes and (m.op in _WAVES or (m.op in _BARS and m.args[0].op == "truss")) for m in order([n], within))


@dataclass(frozen=True, slots=True)
class Sampled:
    """A cell on grids: the shares of solid of the voxels of each, where samples are `solid` (every one, or one in
    several, so that pieces can be counted), the error of the density, and the shares of the surface that have an edge
    leading into the solid, and that lie with the voxels."""

    densities: list[Floats]
    solid: NDArray[np.bool_]
    error: float
    creased: float
    flat: float


def sampled(part: Formula, low: Floats, sides: Floats, grid: Grids) -> Sampled:
    """A part in a cell on all of its grids.

    Samples lie in the middle of equal parts of the cell. All grids are made from the same ones, so that they have the
    same solid, and what they differ by is not how it was sampled. What that does is seen from every third sample along
    each axis: their density errs 9 times as much where walls are smooth, 3 times where they are thin.
    Errors: E182 where the field is not a number.
    """
    nx, ny, nz = grid.samples
    axes = middles(low, sides, grid.samples)
    field = NumpyField(part, "f64").on_grid(axes)
    out = [np.empty(voxels) for voxels in grid.voxels]
    every = tuple(-(-n // MOST_SIGNS) for n in grid.samples)
    solid = np.empty(tuple(-(-n // e) for n, e in zip(grid.samples, every, strict=True)), bool)
    slabs = math.gcd(*(voxels[0] for voxels in grid.voxels))
    thick = nx // slabs
    third = tuple(3 if n % 3 == 0 else 1 for n in grid.samples)
    coarse = np.empty(tuple(n // t for n, t in zip(grid.samples, third, strict=True)))
    values = np.empty((thick + 2, ny, nz))
    cut = creased = flat = 0
    for slab in range(slabs):
        first = slab * thick
        tell(slab, slabs)
        with np.errstate(all="ignore"):
            for i in range(-1, thick + 1):
                at = (first + i) % nx
                values[i + 1] = field.block((at, 0, 0), (at + 1, ny, nz))[0]
        bad = np.argwhere(np.isnan(values[1:-1]))
        if len(bad):
            i, j, k = bad[0]
            raise fail("E182", f"the field is not a number at {place((axes[0][first + i], axes[1][j], axes[2][k]))}",
                       hint="look for the square root or the logarithm of something negative")  # fmt: skip
        share = shares(values)
        more = creases(values)
        cut, creased, flat = cut + more[0], creased + more[1], flat + more[2]
        for voxels, density in zip(grid.voxels, out, strict=True):
            layers = voxels[0] // slabs
            density[slab * layers : (slab + 1) * layers] = averaged(share, (layers, *voxels[1:]))
        mine = range(-(-first // every[0]), -(-(first + thick) // every[0]))
        for i in mine:
            solid[i] = values[1 + i * every[0] - first, :: every[1], :: every[2]] < 0
        rows = values[1:-1][third[0] // 2 :: third[0], third[1] // 2 :: third[1], third[2] // 2 :: third[2]]
        coarse[first // third[0] : (first + thick) // third[0]] = rows
    off = abs(float(fractions(coarse, 1).mean() - out[-1].mean()))
    # at a third of the samples too, which sees edges that are a little rounded
    wide = creases(np.concatenate([coarse[-1:], coarse, coarse[:1]]))
    edges = max(creased / max(cut, 1), wide[1] / max(wide[0], 1))
    return Sampled(out, solid, off / _SPREAD, edges, flat / max(cut, 1))
