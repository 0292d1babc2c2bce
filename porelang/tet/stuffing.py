"""A mesh made of cubes: stuffed, without its islands, with sharp rims and the volume of its part, and looked over.

Of a whole part, or of a region of it: then nothing beyond that is meshed, and what lies beside its ends is no part of
what is found.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.branches import Branches
from porelang.diagnostics import PoreError, fail
from porelang.progress import activity, tell
from porelang.solid import Solid
from porelang.tet.balance import balance
from porelang.tet.cut import Background, cut
from porelang.tet.frame import Frame, Value
from porelang.tet.gaps import Spanned, spanned
from porelang.tet.grading import Grading, Region
from porelang.tet.islands import sorted_pieces
from porelang.tet.lattice import Lattice
from porelang.tet.missed import Missed, missed
from porelang.tet.moving import stars
from porelang.tet.octree import Cells
from porelang.tet.quality import Sound, sound
from porelang.tet.sharp import Sharpened, branches_on, sharpen
from porelang.tet.sizes import Sizes
from porelang.tet.slivers import without_kites
from porelang.tet.tetmesh import Indices, TetMesh, boundary, interfaces

Floats = NDArray[np.float64]
#: Cubes of a frame, and so many of their edges round them.
Around = tuple[Cells, Frame, float]

#: What is nearer to 0 than this share of a coordinate (of 1 mm at least) is 0, but for rounding.
TOUCH = 1e-9
#: How far to either side of a face that solids share they are looked for, of a quarter of a cube: a ball that touches a
#: plane has left it by more, a quarter of a cube aside, unless its radius is a thousand cubes.
_HAIR = 1e-4
BESIDE = 1e-6  # cubes: a field is read as far before a plane in which the part ends, where it may be 0
MESHED, MOVED = 2.0, 1.0  # cubes round those that are looked at: so far all is meshed, and rims are sharpened


@dataclass(frozen=True, slots=True)
class Asked:
    """What is to be meshed, and how: with the void, with islands, with sharp rims."""

    solid: Solid
    sizes: Sizes
    void: bool
    islands: bool
    sharp: bool


@dataclass(frozen=True, slots=True)
class Made:
    """A mesh, the lattice it was cut from, facts of it, what it misses, which void it spans, and whether it is sound;
    `poor` (n, 3) mm are the middles of edges in which it touches itself or that span void, and of slivers."""

    mesh: TetMesh
    lattice: Lattice
    facts: dict[str, Any]
    missed: Missed
    spanned: Spanned
    sound: Sound
    poor: Floats


def made(asked: Asked, grading: Grading, around: Around | None = None) -> Made:
    """The mesh of a part with such cubes; or what lies `around` some. Errors: E110 the field is not a number, E162 the
    cubes hold nothing of the part."""
    with activity("meshing"):
        return _made(asked, grading, around)


def _made(asked: Asked, grading: Grading, around: Around | None) -> Made:
    solid = asked.solid
    near = moves = at = None  # what is meshed, what is sharpened, what is looked at
    if around is not None:
        cells, frame, edges = around
        near, moves, at = (Region(cells, frame, edges + far) for far in (MESHED, MOVED, 0.0))
    lattice = Lattice(grading.cells(asked.sizes, solid.decided, asked.void, near), grading.frame)
    value = before_ends(solid.value, grading.frame)
    background = stood_on(lattice, value)
    tell(1, 5)
    done = cut(background, value, asked.void)
    if around is None and not (done.side == 0).any():
        raise unusable(asked.sizes.finest, "hold nothing of the part")
    stuffed = TetMesh(done.vertices, done.tets, done.side)
    mesh, beside, dropped, facts = sorted_pieces(stuffed, asked.islands or near is not None)
    tell(2, 5)
    slivers = mesh.tets[:0]
    if asked.sharp and len(mesh.tets):
        facts |= sharpened(mesh, solid, lattice, beside, moves)
        mesh, beside, slivers = without_kites(mesh, beside)
    tell(4, 5)
    found = missed((mesh, dropped), middles_of(mesh, beside), lattice, background.values, solid, at)
    looked = sound(mesh, beside)
    void = spanned(solid, mesh)
    some = np.concatenate([void.middle, *(mesh.vertices[of].mean(axis=1) for of in (looked.touching, slivers))])
    return Made(mesh, lattice, facts, found, void, looked, some if at is None else some[at.meets(some, some)])


def sharpened(
    mesh: TetMesh, solid: Solid, lattice: Lattice, beside: Indices, near: Region | None = None
) -> dict[str, float]:
    """Move the vertices of a mesh, in place, so that its rims are sharp and its volume is that of the part:
    `rim_vertices`, how many were moved onto rims, `rim_triangles_left`, how many triangles still cut rims off, and
    `moved`, how far (mm) vertices left the surface at most. Only those in a region are, if what is `near` is given.
    """
    field, cube = Branches(solid.formula), lattice.cube_at(mesh.vertices)
    frame = lattice.frame
    held = frame.held(mesh.vertices)
    free = np.stack([(held >> (2 * k)) & 3 for k in range(3)], axis=1) == 0
    triangles, _ = interfaces(mesh, beside) if len(mesh.phases) > 1 else boundary(mesh, beside)
    triangles = triangles[(held[triangles[:, 0]] & held[triangles[:, 1]] & held[triangles[:, 2]]) == 0]
    if near is not None:
        middles = mesh.vertices[triangles].mean(axis=1)
        triangles = triangles[near.meets(middles, middles)]
    on, around = branches_on(mesh.vertices, triangles, field, frame, cube), stars(mesh.tets, len(mesh.vertices))
    surface = mesh.vertices, mesh.tets, around, triangles, on, free, field, cube
    with activity("sharpening"):
        done = sharpen(*surface) if field.count else Sharpened(0, 0)
        off = balance(*surface)
    return {"rim_vertices": done.moved, "rim_triangles_left": done.left, "moved": off}


def middles_of(mesh: TetMesh, beside: Indices) -> Floats:
    """The middles (n, 3) of the triangles that bound a mesh's solid."""
    triangles, owner = boundary(mesh, beside)
    between, _ = interfaces(mesh, beside)
    mine = np.concatenate([triangles[mesh.phase[owner] == 0], between])
    middles: Floats = mesh.vertices[mine].mean(axis=1)
    return middles


def before_ends(value: Value, frame: Frame) -> Value:
    """A field that is read just before the planes in which the part ends."""
    return lambda points: value(frame.before_ends(points, BESIDE))


def stood_on(lattice: Lattice, value: Value) -> Background:
    """A lattice with the field at its vertices. Errors: E110."""
    vertices = lattice.vertices
    values = -lattice.known.astype(np.float64)
    unknown = np.flatnonzero(lattice.known == 0)
    values[unknown] = value(vertices[unknown])
    wrong = unknown[np.isnan(values[unknown])]
    if len(wrong):
        x, y, z = vertices[wrong[0]]
        raise fail(
            "E110",
            f"the field is not a number at ({x:.6g}, {y:.6g}, {z:.6g}) mm",
            hint="find what has no value there: a root of what is below 0, a division by 0",
        )
    touching = unknown[np.abs(values[unknown]) <= TOUCH * np.maximum(1, np.abs(vertices[unknown]).max(axis=1))]
    if len(touching):
        at = vertices[touching]
        values[touching] = within_unions(at, values[touching], value, lattice.cube_at(at))
    return Background(vertices, lattice.tets, values, lattice.kind, lattice.rank, lattice.held)


def within_unions(points: Floats, values: Floats, value: Value, cube: Floats) -> Floats:
    """The values (n,) of places where a field is 0, as if solids that share a face there were one: where both sides of
    such a place are solid, it lies within them, and no crack without width runs through it.

    A face goes on from the place to some side along both of its axes. Solids that touch in a point or along a line part
    there, and are not joined.
    """

    def between(places: Floats, axis: Floats, step: Floats) -> Floats:
        return np.maximum(value(places + step * axis), value(places - step * axis))

    joined, axes = values.copy(), np.eye(3)
    for axis in range(3):
        depth = between(points, axes[axis], cube[:, None] / 4)
        some = np.flatnonzero(depth < 0)
        for along in (axes[(axis + 1) % 3], axes[(axis + 2) % 3]):
            at, wide = points[some], cube[some, None] / 4
            goes_on = [between(at + side * wide * along, axes[axis], _HAIR * wide) < 0 for side in (-1, 1)]
            some = some[np.any(goes_on, axis=0)]
        joined[some] = np.minimum(joined[some], depth[some])
    return joined


def unusable(size: float, what: str) -> PoreError:
    """E162: of cubes of a size (mm) no mesh comes."""
    hint = "take smaller ones: two are to fit into its walls"
    return fail("E162", f"cubes of {size:g} mm {what}", hint=hint)
