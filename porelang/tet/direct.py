"""A part's tetrahedra straight from its field: isosurface stuffing on an octree of cubes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import extent_of
from porelang.analysis.branches import Branches
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.formula import Formula
from porelang.progress import activity, tell
from porelang.solid import Solid
from porelang.tet.balance import balance
from porelang.tet.cut import Background, cut
from porelang.tet.finer import MANY, ROUND, TOO, TURNS, Grading, Region
from porelang.tet.frame import Frame, Value, framed
from porelang.tet.islands import sorted_pieces
from porelang.tet.lattice import Lattice
from porelang.tet.missed import missed
from porelang.tet.moving import stars
from porelang.tet.quality import figures, sound
from porelang.tet.sharp import Sharpened, branches_on, sharpen
from porelang.tet.sizes import Sizes, asked, thin
from porelang.tet.tetmesh import Indices, TetMesh, boundary, interfaces, neighbours

Floats = NDArray[np.float64]

SOLID, BOTH = ("solid",), ("solid", "void")
FEW = 3  # places that are told
CRUMBS = 0.5  # of the volume: where more would be dropped as islands, there is no part left
BESIDE = 1e-6  # cubes: a field is read as far before a plane in which the part ends, where it may be 0


def direct(
    solid: Solid,
    size: float | Formula,
    *,
    surface_size: float | None = None,
    sharp: bool = True,
    phases: tuple[str, ...] = SOLID,
    keep_islands: bool = False,
) -> tuple[TetMesh, dict[str, Any]]:
    """A conforming mesh of tetrahedra of a solid, twelve to a cube with edges of `size` (mm); and what is to be known
    of it: figures, `islands`, `dropped_volume_fraction`, and diagnostics, `told`.

    A size that is a field (mm) gives every place cubes that are no larger, by factors of two; with a `surface_size`
    (mm) they are no larger than that at the surface. With the `phases` ("solid", "void") the void within the box of
    the solid is meshed too, networks that do not meet as phases of their own; they share the triangles between them.
    If it is to be `sharp`, the mesh has rims where branches of the field meet, but where angles would be too small
    (`rim_triangles_left`), and vertices on bent walls leave them (by `moved` mm at most) so that the volume is that of
    the part. Where the mesh would still miss something of it, cubes are halved, twice at most; what is `missing` and
    what is `extra` after that, by more than a bend, is told in mm3.
    F. Labelle & J. R. Shewchuk, Isosurface Stuffing, SIGGRAPH 2007: where the surface is smooth and the cubes are of
    one size and small against its bend, all dihedral angles are within 10.7 .. 164.8 degrees; at rims and where cubes
    of two sizes meet, smaller and larger ones are left only where stuffing has them already.
    Errors: E160 the size, E161 too many tetrahedra, E162 no mesh at this size, E110 the field is not a number.

    >>> from porelang.compiler import compile
    >>> design = compile("sphere(10)").design()
    >>> mesh, facts = direct(Solid(design.of("part"), design.bounds("part")), 2.0)
    >>> facts["volume"] > 4000 and facts["min_dihedral"] > 10.7
    True
    """
    if phases not in (SOLID, BOTH):
        hint = 'give ("solid",) or ("solid", "void")'
        raise fail("E160", f"{', '.join(map(repr, phases))} are no phases to be meshed", hint=hint)
    both = phases == BOTH
    sizes = asked(solid, size, surface_size)
    with activity("meshing"):
        lo, hi, slack = (solid.lo, solid.hi, 0.0) if both else _box(solid)
        frame = framed(solid.value, lo, hi, sizes.finest, slack, even=1 << sizes.coarsest, whole=both)
        grading = Grading(frame, sizes.coarsest, float(frame.edges.min()))
        near = at = None  # the whole; then what lies round the cubes that were parted, and the whole again
        for turn in range(TURNS + 2):
            tell(3 * turn, 3 * TURNS + 6)
            lattice, values, made = _stuffed(solid, sizes, grading, both, near)
            tell(3 * turn + 1, 3 * TURNS + 6)
            mesh, dropped, facts = sorted_pieces(made, keep_islands or near is not None)
            beside = neighbours(mesh)
            if sharp:
                facts |= sharpened(mesh, solid, lattice, beside, near)
            tell(3 * turn + 2, 3 * TURNS + 6)
            found = missed((mesh, dropped), middles_of(mesh, beside), lattice, values, solid, at)
            looked = sound(mesh, beside)
            if not sharp or (turn and near is None) or (not turn and len(found.cells) > MANY * found.of):
                break
            hinges = mesh.vertices[looked.touching].mean(axis=1)
            if at is not None:
                hinges = hinges[at.meets(hinges, hinges)]
            large = grading.large(lattice, np.union1d(found.cells, lattice.cell_at(hinges)))
            if not len(large) and not turn:
                break
            near = at = None
            if len(large):
                if turn < TURNS:
                    near, at = Region(lattice, large, ROUND), Region(lattice, large, TOO)
                grading = grading.parting(lattice, large)
        if facts["dropped_volume_fraction"] > CRUMBS:
            share = 100 * facts["dropped_volume_fraction"]
            raise _unusable(sizes.finest, f"break the part up: {share:.0f} % of it hangs together with nothing")
        if looked.faults:  # the mesher is at fault, not the part; nobody is to compute with that
            raise _unusable(sizes.finest, f"came out as a damaged mesh: {'; '.join(looked.faults)}")
        facts |= figures(mesh) | {"touching_edges": len(looked.touching), "cube": tuple(frame.edges.tolist())}
        facts |= {"missing": found.missing, "extra": found.extra}
        if sharp:
            facts["told"] += found.told(facts["volumes"]["solid"])
        facts["told"] += [*touching(mesh.vertices[looked.touching]), *thin(solid, sizes)]
    return mesh, facts


def _stuffed(
    solid: Solid, sizes: Sizes, grading: Grading, both: bool, near: Region | None
) -> tuple[Lattice, Floats, TetMesh]:
    """Cubes, the field at their corners and centres, and what stuffing makes of them. Errors: E110, E162."""
    lattice = Lattice(grading.cells(sizes, solid.decided, both, near), grading.frame)
    value = _before_ends(solid.value, grading.frame)
    background = _background(lattice, value)
    made = cut(background, value, both)
    if not (made.side == 0).any():
        raise _unusable(sizes.finest, "hold nothing of the part")
    return lattice, background.values, TetMesh(made.vertices, made.tets, made.side)


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


def touching(edges: Floats) -> list[Diagnostic]:
    """W252 where a solid touches itself along edges (n, 2, 3) mm alone, with the places of some."""
    if not len(edges):
        return []
    places = ", ".join(f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in edges.mean(axis=1)[:FEW])
    many = f"{len(edges)} edges" if len(edges) > 1 else "an edge"
    message = f"the solid touches itself along {many}, as at {places}: a hinge of no width"
    hint = "take a smaller --size; or the part itself touches itself there"
    return [Diagnostic("W252", message, hint=hint, severity="warning")]


def middles_of(mesh: TetMesh, beside: Indices) -> Floats:
    """The middles (n, 3) of the triangles that bound a mesh's solid."""
    triangles, owner = boundary(mesh, beside)
    between, _ = interfaces(mesh, beside)
    mine = np.concatenate([triangles[mesh.phase[owner] == 0], between])
    middles: Floats = mesh.vertices[mine].mean(axis=1)
    return middles


def _box(solid: Solid) -> tuple[Floats, Floats, float]:
    """The box (mm) that holds a part, within that of the solid, and by how much it may be too large."""
    extent = extent_of(solid.formula)
    if extent is None:
        return solid.lo, solid.hi, 0.0
    lo, hi = np.maximum(solid.lo, extent.outer.lo), np.minimum(solid.hi, extent.outer.hi)
    if not (lo < hi).all():
        return solid.lo, solid.hi, 0.0
    return lo, hi, float(min(extent.error, (hi - lo).max()))


def _before_ends(value: Value, frame: Frame) -> Value:
    """A field that is read just before the planes in which the part ends."""
    return lambda points: value(frame.before_ends(points, BESIDE))


def _background(lattice: Lattice, value: Value) -> Background:
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
    return Background(vertices, lattice.tets, values, lattice.kind, lattice.rank, lattice.held)


def _unusable(size: float, what: str) -> PoreError:
    hint = "take smaller ones: two are to fit into its walls"
    return fail("E162", f"cubes of {size:g} mm {what}", hint=hint)
