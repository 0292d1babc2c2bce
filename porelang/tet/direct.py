"""A part's tetrahedra straight from its field: isosurface stuffing on an octree of cubes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import extent_of
from porelang.diagnostics import Diagnostic, fail
from porelang.formula import Formula
from porelang.progress import activity
from porelang.solid import Solid
from porelang.tet.frame import Frame, framed
from porelang.tet.gaps import beside_gaps, closed
from porelang.tet.grading import Grading
from porelang.tet.halving import refined
from porelang.tet.lattice import Lattice
from porelang.tet.quality import figures
from porelang.tet.sizes import asked, thin
from porelang.tet.stuffing import Asked, unusable
from porelang.tet.tetmesh import TetMesh, volumes

Floats = NDArray[np.float64]

SOLID, BOTH = ("solid",), ("solid", "void")
FEW = 3  # places that are told
LACKS = 0.1  # of the part: a mesh that misses more is none of it
CRUMBS = 0.5  # of the volume: where more would be dropped as islands, there is no part left


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
    one size and small against its bend, all dihedral angles are within 10.7 .. 164.8 degrees. Where cubes of two sizes
    meet at a surface that is not proven: such slivers are halved away, as far as cubes may be.
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
        done = refined(
            Asked(solid, sizes, both, keep_islands, sharp), Grading(frame, sizes.coarsest, frame.edges.min())
        )
        mesh, facts = done.mesh, done.facts
        if facts["dropped_volume_fraction"] > CRUMBS:
            share = 100 * facts["dropped_volume_fraction"]
            raise unusable(sizes.finest, f"break the part up: {share:.0f} % of it hangs together with nothing")
        lacks = done.missed.missing / float(volumes(mesh)[mesh.phase == 0].sum() + done.missed.missing)
        if sharp and lacks > LACKS:
            raise unusable(sizes.finest, f"miss {100 * lacks:.0f} % of the part")
        if done.sound.faults:  # the mesher is at fault, not the part; nobody is to compute with that
            raise unusable(sizes.finest, f"came out as a damaged mesh: {'; '.join(done.sound.faults)}")
        facts |= figures(mesh) | {"touching_edges": len(done.sound.touching), "cube": tuple(frame.edges.tolist())}
        facts |= {"missing": done.missed.missing, "extra": done.missed.extra} | smaller(done.lattice, frame)
        if sharp:
            facts["told"] += done.missed.told(facts["volumes"]["solid"])
        hinges = beside_gaps(mesh.vertices[done.sound.touching], done.spanned)
        facts["told"] += [*touching(hinges), *thin(solid, sizes)]
        facts["told"] += closed(done.spanned, min(sizes.even or sizes.finest, sizes.surface))
    return mesh, facts


def smaller(lattice: Lattice, frame: Frame) -> dict[str, float]:
    """How many cubes were `halved` that a frame has, and how large (mm) the `finest_cube` is."""
    edge, least = float(lattice.frame.edges.min()), float(frame.edges.min())
    cube = edge * 2.0**lattice.cells.level
    fine = cube < least * (1 - 1e-9)
    return {"halved": round(float(((cube[fine] / least) ** 3).sum())), "finest_cube": float(cube.min())}


def touching(edges: Floats) -> list[Diagnostic]:
    """W252 where a mesh touches itself along edges (n, 2, 3) mm alone, with the places of some."""
    if not len(edges):
        return []
    places = ", ".join(f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in edges.mean(axis=1)[:FEW])
    many = f"{len(edges)} edges" if len(edges) > 1 else "an edge"
    message = f"the mesh touches itself along {many}, as at {places}: a hinge of no width"
    hint = "take a smaller --size: the part is thin there, or touches itself"
    return [Diagnostic("W252", message, hint=hint, severity="warning")]


def _box(solid: Solid) -> tuple[Floats, Floats, float]:
    """The box (mm) that holds a part, within that of the solid, and by how much it may be too large."""
    extent = extent_of(solid.formula)
    if extent is None:
        return solid.lo, solid.hi, 0.0
    lo, hi = np.maximum(solid.lo, extent.outer.lo), np.minimum(solid.hi, extent.outer.hi)
    if not (lo < hi).all():
        return solid.lo, solid.hi, 0.0
    return lo, hi, float(min(extent.error, (hi - lo).max()))
