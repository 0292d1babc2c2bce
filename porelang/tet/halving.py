"""Cubes that are too large for what is there are halved, and once more if that does not do: found before all is meshed.

What stuffing misses it misses at rims, where a wall meets an envelope at a small angle: so the cubes that rims pass are
meshed by themselves, with some round them, and looked at; then what lies round those that were halved. The whole is
meshed with all of them at once, and looked at too: what no rim explains, as a wall thinner than a cube or a slit that
is closed, shows then.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.branches import Branches
from porelang.progress import activity, tell
from porelang.tet.gaps import closed_gap
from porelang.tet.grading import Grading
from porelang.tet.octree import EIGHT, Cells
from porelang.tet.stuffing import Around, Asked, Made, made

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

TURNS = 4  # as halved cubes may show what larger ones did not
MANY = 0.25  # of the cubes at a surface: where more miss it the size is too large for the part, not for some places
MANY_JOINED = 0.75  # the same where what is apart is joined: a slit through a small part passes many of its cubes
ENOUGH = 5e-4  # of the volume: a mesh that misses less is not made anew
CORNER = 1e-3  # of a cube: branches are asked as far within its corners
REACH = 1.0  # edges: so far from a cube's middle the surface is within it, or next to it
#: The edges of a cube, by its corners.
SIDES = [(i, j) for i in range(8) for j in range(i) if (EIGHT[i] != EIGHT[j]).sum() == 1]
NONE = np.zeros(0, np.int64)


def refined(asked: Asked, grading: Grading) -> Made:
    """The mesh of a part, with cubes halved where it would miss something."""
    if not asked.sharp:
        return made(asked, grading)
    surface, rims = at_rims(asked, grading)
    if len(rims.level):
        grading = halved(asked, grading, (rims, grading.frame, 0.0), MANY * surface)
    mesh = made(asked, grading)
    some = wrong(grading, mesh, mesh.missed.cells)
    most, needed = (MANY_JOINED, True) if spans(mesh) else (MANY, matters(asked, mesh))
    if not len(some.level) or len(some.level) > most * mesh.missed.of or not needed:
        return mesh
    return made(asked, halved(asked, grading.parting(some), (some, mesh.lattice.frame, 1.0)))


def halved(asked: Asked, grading: Grading, around: Around, most: float = np.inf) -> Grading:
    """Cubes that are smaller where a mesh of what lies around some is wrong.

    What is found first is halved, however little it is: a tongue that ends in a cube shows in smaller ones alone. Where
    more than `most` cubes are wrong then, none is. After that what is missed has to matter.
    """
    for turn in range(TURNS):
        with activity("meshing rims"):
            tell(turn, TURNS)
        mesh = made(asked, grading, around)
        some = wrong(grading, mesh, mesh.missed.cells if not turn or matters(asked, mesh) else NONE)
        if not len(some.level) or (not turn and len(some.level) > most):
            break
        grading, around = grading.parting(some), (some, grading.frame, 1.0)
    return grading


def wrong(grading: Grading, mesh: Made, missed: Ints) -> Cells:
    """The cubes that have `missed` something of a part, or have hinges or slivers, and may be halved."""
    some = np.union1d(missed, mesh.lattice.cell_at(mesh.poor))
    found = mesh.lattice.cells.taken(some[some >= 0])
    return found.taken(grading.large(found))


def matters(asked: Asked, mesh: Made) -> bool:
    """Whether what a mesh misses is worth a finer one."""
    return mesh.missed.missing + mesh.missed.extra > ENOUGH * asked.solid.guess[0]


def spans(mesh: Made) -> bool:
    """Whether a mesh joins what is apart, however narrow the gap is."""
    return closed_gap(mesh.spanned) is not None


def at_rims(asked: Asked, grading: Grading) -> tuple[int, Cells]:
    """How many cubes a surface may pass, and those of them that a rim passes: the surfaces of two branches, on which
    corners of theirs are, meet there."""
    field, frame = Branches(asked.solid.formula), grading.frame
    cells = grading.cells(asked.sizes, asked.solid.decided, asked.void)
    cells = cells.taken(cells.known == 0)
    low, high = cells.boxes(frame)
    middle, edge = frame.before_ends((low + high) / 2, CORNER), (high - low).max(axis=1)
    value, slope = field.slope(middle)
    near = np.flatnonzero(~(np.abs(value) > REACH * np.linalg.norm(slope, axis=1) * edge))
    low, side = low[near], (high - low)[near]
    corners = low[:, None] + (CORNER + (1 - 2 * CORNER) * EIGHT) * side[:, None]
    branch = field.of(frame.before_ends(corners.reshape(-1, 3), CORNER)).reshape(-1, 8)
    several = np.flatnonzero((branch != branch[:, :1]).any(axis=1))
    some = near[several]
    return len(near), cells.taken(some[_meeting(middle[some], branch[several], edge[some], field)])


def _meeting(middle: Floats, branch: Ints, edge: Floats, field: Branches) -> Flags:
    """Whether the tangent planes of two of the branches (n, 8) meet near the middles (n, 3) of cubes: those on the two
    sides of a sheet do not, however thin it is."""
    value, gradient = field.held(np.repeat(middle, 8, axis=0), branch.ravel())
    with np.errstate(all="ignore"):
        steep = np.linalg.norm(gradient, axis=1)
        off, normal = (value / steep).reshape(-1, 8), (gradient / steep[:, None]).reshape(-1, 8, 3)
        found = np.zeros(len(middle), np.bool_)
        for i, j in SIDES:
            both = np.einsum("nk,nk->n", normal[:, i], normal[:, j])
            far2 = (off[:, i] ** 2 + off[:, j] ** 2 - 2 * both * off[:, i] * off[:, j]) / (1 - both**2)
            found |= (branch[:, i] != branch[:, j]) & ~(far2 > (REACH * edge) ** 2)
    return found
