"""From an output of a design to tetrahedra, by either mesher."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from porelang.analysis.box import Box, block
from porelang.data import Reduced, Triple
from porelang.diagnostics import Diagnostic, PoreError, fail, suggest
from porelang.field import Bounds, checked_bounds
from porelang.ir import node
from porelang.mesh.made import Made, make
from porelang.mesh.part import notes_of
from porelang.program import Design
from porelang.progress import activity
from porelang.solid import Solid
from porelang.tet.described import described, distances
from porelang.tet.direct import direct
from porelang.tet.ftetwild import TIME_LIMIT, ftetwild, installed
from porelang.tet.sizes import asked, thin
from porelang.tet.tetmesh import TetMesh
from porelang.tetrahedra.doubts import refuse_loss, volume_doubts
from porelang.tetrahedra.fineness import Fineness, fineness
from porelang.tetrahedra.result import Tetrahedra
from porelang.walls import rounded

Mesher = Literal["direct", "ftetwild"]
MESHERS: tuple[Mesher, ...] = ("direct", "ftetwild")
PHASES = ("solid", "void")
#: Voxels of the surface that fTetWild is given: on the edge of a tetrahedron, and on the thinnest wall.
ON_AN_EDGE, ON_A_WALL = 2.0, 2.5
#: Samples for that surface, at most, that nobody has asked for.
MOST_SAMPLES = 16e6
#: What is doubtful of a surface and not of its tetrahedra: its volume, for they have their own, and that it runs
#: through itself, which fTetWild mends.
_NO_MATTER = frozenset({"W202", "W207"})


def tetrahedra(
    design: Design,
    name: str | None = None,
    size: float | str | None = None,
    mesher: Mesher = "direct",
    phases: Sequence[str] = ("solid",),
    *,
    surface_size: float | None = None,
    bounds: Bounds | None = None,
    keep_islands: bool = False,
    time_limit: float | None = None,
    force: bool = False,
) -> Tetrahedra:
    """Tetrahedra that fill an output, in mm.

    `size` is how long their edges are (mm), or the name of an output or a `let` that says it at every place; where it
    is not given it is found from the walls. At the surface it is `surface_size`. `phases` ("solid", "void") also fills
    what is not solid within the box of the part or of `bounds`. Pieces that do not hang together with the largest are
    left out unless `keep_islands`. `time_limit` (s) is for fTetWild.

    Errors: those of bounds; E108, E114 for wishes that cannot be; E118 where more than a fifth of the part is lost,
    unless `force`; E160-E162 of the direct mesher, E163-E165 of fTetWild.
    """
    start = time.perf_counter()
    wanted = wishes(mesher, phases, size, surface_size, time_limit)
    box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
    part = Solid(design.of(name), (box.lo, box.hi))
    with activity("looking at walls"):
        fine = fineness(design, part, size, mesher, len(wanted) > 1)
    if mesher == "ftetwild":
        given = _surface(design, name, fine, surface_size, bounds, force)
        mesh, facts = _by_ftetwild(given, part, fine, keep_islands, time_limit or TIME_LIMIT)
    else:
        ends = bounds is not None or len(wanted) > 1  # else the part ends of itself, and is not cut
        solid = part if ends else Solid(part.formula, _roomy(box))
        try:
            mesh, facts = direct(solid, fine.size, surface_size=surface_size, phases=wanted, keep_islands=keep_islands)
        except PoreError as error:
            raise PoreError([_with_walls(d, part, fine, bounds) for d in error.diagnostics]) from None
    meshing = time.perf_counter() - start
    with activity("looking at tetrahedra"):
        report = _report(design, name, mesh, box if bounds is not None else None)
    report |= {
        "mesher": mesher,
        "size": fine.size if isinstance(fine.size, float) else size,
        "surface_size": surface_size,
        "wall": None if fine.wall is None else fine.wall.wall,
        "size_for_wall": fine.wanted,
        "size_told": fine.told(),
        **{key: value for key, value in facts.items() if key not in report and key != "told"},
        "seconds_meshing": round(meshing, 3),
        "seconds": round(time.perf_counter() - start, 3),
    }
    doubts: list[Diagnostic] = facts["told"]
    span = design.program.outputs[design.program.output(name)].span
    lost = report["dropped_volume_fraction"]
    if not force:
        refuse_loss(report["islands"], lost, span)
    true, islands = Reduced(report["field_volume"], report["field_volume_error"]), 0.0
    if len(wanted) == 1:
        islands = report["volume"] * lost / (1 - lost)
    doubts += volume_doubts(report["volume"], true, fine, force, span, islands)
    return Tetrahedra(mesh, report, doubts, notes_of(design, name))


def wishes(mesher: str, phases: Sequence[str], size: Any, surface_size: Any, time_limit: Any) -> tuple[str, ...]:
    """The phases that are wanted, the other wishes looked over. Errors: E108, E114; E163 where there is no fTetWild."""
    if mesher not in MESHERS:
        near = suggest(mesher, MESHERS)
        hint = f"did you mean {near}?" if near else f"choose from {', '.join(MESHERS)}"
        raise fail("E108", f"mesher cannot be {mesher!r:.60}", hint=hint)
    for what, given in (("size", size), ("surface_size", surface_size), ("time_limit", time_limit)):
        if given is None or (what == "size" and isinstance(given, str)):
            continue
        if not isinstance(given, int | float | np.number) or isinstance(given, bool) or not 0 < given < math.inf:
            unit = "seconds" if what == "time_limit" else "mm"
            raise fail("E114", f"{what}={given!r:.60} is none", hint=f"give a number of {unit} above 0")
    if time_limit is not None and mesher != "ftetwild":
        raise fail("E108", "--time-limit is for fTetWild", hint="leave it out, or use --mesher ftetwild")
    wanted = tuple(dict.fromkeys(phases))
    if unknown := [phase for phase in wanted if phase not in PHASES]:
        raise fail("E108", f"there is no phase {unknown[0]!r:.60}", hint="phases are solid, or solid,void")
    if "solid" not in wanted:
        hint = "write solid,void; or for the void alone an output that is `box \\ part`"
        raise fail("E108", "tetrahedra of the void come with those of the solid", hint=hint)
    if mesher == "ftetwild":
        if len(wanted) > 1:
            hint = "leave --mesher out: the direct mesher makes both, with the triangles between them shared"
            raise fail("E108", "fTetWild makes tetrahedra of the solid alone", hint=hint)
        installed()
    return tuple(phase for phase in PHASES if phase in wanted)


def _with_walls(d: Diagnostic, part: Solid, fine: Fineness, bounds: Bounds | None) -> Diagnostic:
    """What is said where there is no mesh at a size, with the walls that it did not see, or an empty box."""
    if d.code != "E162":
        return d
    if bounds is not None and not part.guess[0]:
        return replace(d, hint="the bounds are beside the part, or hold hardly any of it: leave them out, or move them")
    if fine.wall is None:
        return replace(d, hint="take a smaller --size: two are to fit into its walls")
    size = rounded(fine.wall.wall / 2)
    return replace(d, hint=f"the thinnest walls are about {fine.wall.wall:.2g} mm, and two are to fit into them: "
                           f"--size {size}mm")  # fmt: skip


def _roomy(box: Box) -> tuple[Triple, Triple]:
    """A box with so much room that it cuts nothing off what is in it."""
    room = 0.05 * max(box.size)
    (x, y, z), (u, v, w) = box
    return (x - room, y - room, z - room), (u + room, v + room, w + room)


def _surface(
    design: Design,
    name: str | None,
    fine: Fineness,
    surface_size: float | None,
    bounds: Bounds | None,
    force: bool,
) -> Made:
    """The surface that fTetWild is given: its voxel is `surface_size`, or else fits the size and the walls."""
    assert isinstance(fine.size, float)
    voxel = fine.size / ON_AN_EDGE
    if fine.wall is not None:
        voxel = min(voxel, fine.wall.wall / ON_A_WALL)
    size = (
        np.subtract(bounds[3:], bounds[:3]) if bounds is not None else np.array(design.bounds(name).size)
    ) + 4 * voxel
    voxel = max(voxel, float(np.prod(size) / MOST_SAMPLES) ** (1 / 3))
    try:
        return make(design, name, surface_size or voxel, bounds=bounds, sharp=True, force=force, dtype="f64")
    except PoreError as error:
        raise PoreError([_said_of_tetrahedra(d) for d in error.diagnostics]) from None


def _by_ftetwild(
    given: Made, part: Solid, fine: Fineness, keep_islands: bool, time_limit: float
) -> tuple[TetMesh, dict[str, Any]]:
    """fTetWild's tetrahedra of a surface, and their facts, with what is doubtful of either."""
    assert isinstance(fine.size, float)
    vertices, faces = given.surface.vertices, given.surface.faces
    mesh, facts = ftetwild(vertices, faces, fine.size, keep_islands=keep_islands, time_limit=time_limit)
    walls = [replace(d, message=d.message.replace("cubes of", "edges of"))
             for d in thin(part, asked(part, fine.size, None))]  # fmt: skip
    surface = [_said_of_tetrahedra(d) for d in given.doubts if d.code not in _NO_MATTER]
    facts |= {"surface_triangles": len(faces), "surface_voxel": given.facts["voxel"]}
    return mesh, facts | {"told": [*surface, *facts["told"], *walls]}


def _said_of_tetrahedra(d: Diagnostic) -> Diagnostic:
    """What is said of a surface, in the words of `pore tet`, whose voxel is its size at the surface."""
    return replace(d, hint=d.hint.replace("--voxel", "--surface-size"))


def _report(design: Design, name: str | None, mesh: TetMesh, cut: Box | None) -> dict[str, Any]:
    """What the tetrahedra are, and what of the part they are to be; `cut` is the box that it is cut at, if it is."""
    root = design.program.solid(name)
    if cut is not None:
        root = node("max", root, block(cut))
    true = design.number(node("volume", root))
    formula = design.formula(root)
    solid = Solid(formula, ((-math.inf,) * 3, (math.inf,) * 3))
    found = described(mesh)
    return found | {
        "field_volume": true.value,
        "field_volume_error": true.error,
        "volume_error": (found["volume"] - true.value) / true.value if true.value else None,
        "distance": distances(mesh, solid),
    }
