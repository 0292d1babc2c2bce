"""The period of a part: how long it is, where it lies, whether it is one, and the field in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import part_box, unbounded_axes
from porelang.backends.numpy import NumpyField
from porelang.data import coordinates
from porelang.diagnostics import Diagnostic, fail
from porelang.formula import Formula
from porelang.ir import Node, node, order, within
from porelang.ops import kind
from porelang.program import Design
from porelang.progress import checkpoint
from porelang.rewrites import flatten
from porelang.unitcell.period import DIFFERENT, Mismatch, middles, mismatches

Floats = NDArray[np.float64]
_WAVES = frozenset({"sin", "cos", "sin_turns", "cos_turns"})


def cell_of(design: Design, name: str, part: Formula, given: Sequence[float] | None) -> Floats:
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


def period_doubts(part: Formula, low: Floats, sides: Floats) -> list[Diagnostic]:
    """What is doubtful of a box as a period. Errors: E181 where it is none, E182 where an envelope cuts it."""
    cutting = _cut_by(part, low, sides)
    if cutting is not None:
        raise fail("E182", f"the part is cut by its envelope within the cell, as at {place(cutting)}",
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
    seen = f"the field is {odd.below:.4g} at {place(odd.at)} and {odd.above:.4g} at {place(there)}"
    across = "xyz"[odd.axis]
    return f"across {across}, {odd.share:.2g} of the points of a face are solid here and void there; {seen}"


def place(point: Any) -> str:
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


def lattice_of(part: Formula) -> Formula:
    """The lattice of a part without the envelope that cuts it: of an intersection what has waves, else the part."""
    members = _members(part.root)
    lattice = [n for n in members if _waves(n)]
    if not lattice or len(lattice) == len(members):
        return part
    whole = lattice[0]
    for n in lattice[1:]:
        whole = node("max", whole, n)
    return part.with_roots(whole)


def _members(n: Node) -> list[Node]:
    """What a solid is the intersection of."""
    return [m for a in n.args for m in _members(a)] if n.op == "max" else [n]


def _waves(n: Node) -> bool:
    return any(m.op in _WAVES and m.axes for m in order([n], within))


def sampled(part: Formula, low: Floats, sides: Floats, voxels: tuple[int, int, int], fine: int) -> Floats:
    """The field in the middle of fine^3 parts of each voxel. Errors: E182 where it is not a number."""
    nx, ny, nz = (fine * n for n in voxels)
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
        raise fail("E182", f"the field is not a number at {place(at)}",
                   hint="look for the square root or the logarithm of something negative")  # fmt: skip
    return values
