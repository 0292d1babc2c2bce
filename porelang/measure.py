"""What a part measures: volume, porosity, area, components, topology, each with an error.

Volumes, the porosity and the area are found from the fields themselves (`porelang.tasks.numbers`), not from a mesh.
The Euler number and the pieces of solid are those of the mesh, without the crumbs that sampling makes; pieces of void,
and those of solid within another envelope, are counted among samples at the voxel. Their errors are the change from a
voxel 1.5 times as large, and what is torn off in the mesh. They are infinite (JSON: null) where a gap or a wall lies
between the samples that could make others of them, for no two voxels that are both larger than it show that, and where
samples miss much of the part. A count with an error is not certain. Pieces of solid and closed voids are described one
by one (`pieces`). The share of the void that is open errs by the voxel: twice the change is what is left (Richardson,
order 1), or the chance of voxels at its edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box, block, extent_of, part_box, unbounded_axes
from porelang.backends.numpy import Dtype, NumpyField
from porelang.data import Reduced
from porelang.diagnostics import PoreError, fail, suggest
from porelang.field import Backend, Bounds, checked_bounds, make_field, number_type
from porelang.formula import Formula
from porelang.ir import NUMBERS, TASKS, Node, node, order
from porelang.ir import within as below
from porelang.mesh.crumbs import settle
from porelang.mesh.doubts import lost_doubts
from porelang.mesh.grid import chosen_voxel
from porelang.mesh.part import Placed, grid_of, surface_of
from porelang.mesh.parted import parted
from porelang.ops import kind
from porelang.pieces import Pieces, pieces_of, refuse_too_many, sampled
from porelang.program import Design, Program
from porelang.solid import Solid
from porelang.tasks.numbers.thickness import Wall, thinnest_wall
from porelang.walls import chosen

_COARSER = 1.5
#: Samples among which is counted, where no voxel is given: three times as many as along the sides of a cube.
COUNTED = 6_000_000
#: What is counted at a voxel.
COUNTS = ("solid_components", "void_components", "open_void_fraction", "euler")
#: What the envelope is called where the part has none of its own.
BOUNDS = "the bounds"
#: And where it has: a body that nothing but cuts is done to is that body; a lattice or spheres are within the others.
CUT, INTERSECTED = "the shape that is cut", "the shapes that the part is intersected with"
#: Points of the part's box, and the share of them where a field is infinite that is none.
_LOOKS, _INFINITE = 4096, 0.5
#: Samples that miss more than this of the part's volume do not show how it hangs together.
_MISSED = 0.1
_WAVES = frozenset({"sin", "cos", "sin_turns", "cos_turns"})
_COPIES = frozenset({"round", "floor"})


@dataclass(frozen=True, slots=True)
class Counts:
    """What samples tell of the topology: pieces of solid, pieces of void, and the share of the void that is open.

    `grain` is what the share may owe to where the grid happens to lie: the voxels at the edge of the void, each in or
    out by chance, taken together.
    """

    solid: int
    void: int
    open: float
    grain: float


def measure(
    design: Design,
    name: str | None = None,
    within: str | None = None,
    voxel: float | None = None,
    resolution: int | None = None,
    bounds: Bounds | None = None,
    backend: Backend = "numpy",
    dtype: Dtype = "f32",
) -> dict[str, Any]:
    """The report of an output: lengths in mm, areas in mm^2, volumes in mm^3.

    The envelope is the solid `within` (an output or a let), else the shapes with an end that the part is intersected
    with, all together, or the one that it is cut out of, else the box of the bounds, as of several bodies that are cut;
    `envelope` says which. With `within`, volume and porosity are those
    of the part inside it, area and counts of surfaces those of the whole. Errors: those of a mesh, E110
    also where the field is infinite in most of its box, E109 for an unknown `within`. Where the voxel is too coarse for
    a count, `voxel_for_wall` is the one that the thinnest walls ask for; else it is None.
    """
    part = design.of(name)
    box = checked_bounds(bounds) if bounds is not None else design.bounds(name)
    envelope, called = envelope_of(design, part, within, box)
    root = part.root
    if bounds is not None:
        root, envelope = node("max", root, block(box)), node("max", envelope, block(box))
    extent = design.extent(name) if bounds is None else extent_of(part.with_roots(root))
    if extent is None:
        raise fail("E103", f"`{design.program.output(name)}` holds no material within the bounds",
                   hint="solid is negative: widen --bounds")  # fmt: skip
    _refuse_infinite(design, name, extent.outer)
    choice = chosen(Solid(part, box), COUNTED) if voxel is None and resolution is None else None
    voxel = choice.voxel if choice is not None else voxel
    h = chosen_voxel(max(box.size), voxel, resolution)
    formulas = [design.formula(r) for r in (root, envelope)]
    dtype = number_type(formulas[0], extent.outer, h, backend, dtype)
    fields = [make_field(f, design.program.ranges, backend, dtype) for f in formulas]
    grids = [grid_of(design, name, s, None, bounds) for s in (h, _COARSER * h)]
    refuse_too_many(extent.outer, h)  # before anything is computed
    inside, whole, share, surface = (
        design.number(n)
        for n in (
            node("volume", node("max", root, envelope)),
            node("volume", envelope),
            node("porosity", root, envelope),
            node("area", root),
        )
    )
    read = set(design.reads(root, envelope, *design.program.graph.checks))  # not what only another output reads
    around = part_box(formulas[1]) or box
    fine, coarse = (_counts(fields[0], fields[1], around, s) for s in (h, _COARSER * h))
    pieces, voids = pieces_of(fields[0], extent.outer, h, _COARSER * h)
    # an envelope that is found from the part holds all of it
    all_of_it = inside if within is None else design.number(node("volume", root))
    there = all_of_it.value > all_of_it.error
    meshed, larger = (_meshed(there, design, name, grid, backend, dtype, grid is grids[0]) for grid in grids)
    seen = abs(meshed.volume - all_of_it.value) <= max(_MISSED * all_of_it.value, all_of_it.error)
    seen = seen and not meshed.lacks
    unsure = float(meshed.torn) if seen else math.inf
    several = [fine.solid, coarse.solid] if within is not None else [meshed.solids, larger.solids]
    # what the box of the bounds may be too large by is an error of all that is relative to it
    loose = 1 - extent.inner.volume / extent.outer.volume if extent.inner is not None else 1.0
    loose = loose if called == BOUNDS and bounds is None else 0.0
    wall = _wall(part.with_roots(root))
    report: dict[str, Any] = {
        "bounds": [list(extent.outer.lo), list(extent.outer.hi)],
        "voxel": h,
        "volume": inside.value,
        "envelope": called,
        "envelope_volume": whole.value,
        "porosity": share.value,
        "area": surface.value,
        "solid_components": several[0],
        "void_components": fine.void,
        "open_void_fraction": fine.open,
        "euler": meshed.euler,
        "pieces": _listed(pieces, not unsure),
        "voids": _listed(voids, not unsure),
        "closed_voids": voids.count,
        "min_wall": wall.thickness.value if wall is not None else None,
        "min_wall_at": wall.at.tolist() if wall is not None else None,
        "error": {
            "bounds": extent.error,
            "bounds_by_axis": list(extent.errors),
            "volume": inside.error,
            "envelope_volume": whole.error + loose * whole.value,
            "porosity": share.error + loose * (1 - share.value),
            "area": surface.error,
            "min_wall": wall.thickness.error if wall is not None else None,
            "solid_components": abs(several[0] - several[1]) + unsure,
            "void_components": abs(fine.void - coarse.void) + unsure,
            "open_void_fraction": _of_a_share(max(2 * abs(fine.open - coarse.open), fine.grain), seen),
            "euler": abs(meshed.euler - larger.euler) + (math.inf if unsure else 0.0),
        },
        "reduced": {
            text: _told(design.number(n)) | {"unit": design.program.units.get(n, "")}
            for n, text in design.program.numbers.items()
            if n in read
        },
        "numbers": {text: _told(design.valued(n)) for text, n in _made_of(design.program, read).items()},
        "voxel_for_wall": None,
    }
    if any(math.isinf(report["error"][count]) for count in COUNTS):
        choice = choice or chosen(Solid(part, box))
        report["voxel_for_wall"] = choice.wanted if choice.wall is not None and choice.wanted < h else None
    return report


def _wall(part: Formula) -> Wall | None:
    """The thinnest walls of a part; None where it has none to measure."""
    try:
        return thinnest_wall(part)
    except PoreError as error:
        if error.diagnostics[0].code != "E139":
            raise
        return None


def _made_of(program: Program, read: set[Node]) -> dict[str, Node]:
    """The flat roots of lets and outputs that are made of numbers found from fields, by name: of those found anyway."""
    named = {name: program.named(name) for name, let in program.elaborated.lets.items() if not let.node.axes}
    named |= {name: roots[0] for name, roots in program.graph.outputs.items() if len(roots) == 1}
    out: dict[str, Node] = {}
    for name, root in named.items():
        if root is None or root.axes or kind(root) != "real":
            continue
        asked = [n for n in order([root], below) if n.op in TASKS]
        if asked and all(n in read and n.op in NUMBERS for n in asked):
            out[name] = root
    return out


def _refuse_infinite(design: Design, name: str | None, box: Box) -> None:
    """Refuse a field that was divided by 0: it has a sign, and no surface that could be found by its values."""
    points = np.random.default_rng(1).uniform(box.lo, box.hi, (_LOOKS, 3))
    if np.isinf(NumpyField(design.of(name), "f64", 1).at(points)).mean() > _INFINITE:
        chosen = design.program.output(name)
        raise fail("E110", f"the field of `{chosen}` is infinite nearly everywhere",
                   design.program.outputs[chosen].span, hint="look for a division by zero")  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Meshed:
    """What of a mesh without crumbs is told: the volume that it holds (mm3), its Euler number, its pieces of solid, how
    many pieces are or may be torn off, and whether it `lacks` something of the part that lies between its samples."""

    volume: float = 0.0
    euler: int = 0
    solids: int = 0
    torn: int = 0
    lacks: bool = False


def _meshed(
    there: bool, design: Design, name: str | None, placed: Placed, backend: Backend, dtype: Dtype, doubted: bool
) -> _Meshed:
    """The mesh at a voxel, and if it is to be `doubted` what it lacks; nothing at all where no sample meets a part that
    is `there`."""
    part = Solid(design.of(name), placed.cut)
    try:
        settled = settle(surface_of(design, name, placed, backend, dtype), placed.grid, part)
    except PoreError as error:
        if not there or error.diagnostics[0].code != "E111":
            raise
        return _Meshed()
    surface = settled.surface
    solids = int(np.count_nonzero(surface.pieces.volume >= 0))
    lacks = doubted and (
        parted(surface, placed.grid, part) or bool(lost_doubts(design, name, surface, surface, placed.grid, part))
    )
    return _Meshed(surface.volume, surface.euler, solids, settled.torn + settled.pending, lacks)


def _listed(found: Pieces, sure: bool) -> list[dict[str, Any]]:
    """Pieces as they are told; where samples miss something of the part, or tear it, nothing about them is certain."""
    return [piece.told() | {"certain": piece.certain and sure} for piece in found.described]


def _of_a_share(error: float, seen: bool) -> float:
    """The error of a share: one of the whole tells nothing."""
    return error if seen and error < 1 else math.inf


def _told(found: Reduced) -> dict[str, Any]:
    return {"value": found.value, "error": found.error}


def envelope_of(design: Design, part: Formula, within: str | None, box: Box) -> tuple[Node, str]:
    """What the porosity is relative to, and how that was chosen."""
    if within is not None:
        return _named(design.program, within), within
    shapes = _shapes(part, part.root)
    infill = any(_waves(n) for n in _members(part.root))
    # Several bodies may be the infill itself, spheres in a box, and so may what has waves: each is the envelope only
    # where nothing else is. Several bodies with waves are none, but a lattice in its skin; and several bodies that are
    # cut are the part, unless it is a lattice within them.
    whole = [n for n in shapes if not _several(part, n)]
    plain = [n for n in whole if not _waves(n)] or [n for n in shapes if not _waves(n) and infill] or whole
    if not plain:
        return block(box), BOUNDS
    chosen = plain[0]
    for n in plain[1:]:
        chosen = node("max", chosen, n)
    cut = all(n in plain or n.op == "neg" for n in _members(part.root))
    return chosen, CUT if cut and len(plain) == 1 else INTERSECTED


def _members(n: Node) -> list[Node]:
    """What a solid is the intersection of, cuts included."""
    return [m for a in n.args for m in _members(a)] if n.op == "max" else [n]


def _several(part: Formula, n: Node) -> bool:
    """Whether a shape is several bodies: a union of solids with an end, also one that is blended or offset, or copies
    in a row."""
    todo, seen = [n], {n}
    while todo:
        m = todo.pop()
        if m.op in _COPIES and m.axes:
            return True
        if m.op == "min" and len([a for a in m.args if a.axes and _ends(part, a)]) > 1:
            return True
        if m.op != "neg":  # what is cut out of a body may be several
            todo += [a for a in below(m) if a not in seen]
            seen.update(below(m))
    return False


def _ends(part: Formula, n: Node) -> bool:
    """Whether a node is a solid with an end."""
    box = part_box(part.with_roots(n)) if kind(n) == "real" else None
    return box is not None and not unbounded_axes(box)


def _shapes(part: Formula, n: Node) -> list[Node]:
    """The shapes with an end that a part is the intersection of, however it is written.

    An intersection is a shape of its own (a cone, a tetrahedron) where none of its members has an end and it holds no
    waves: with waves it is a lattice that planes cut.
    """
    if n.op == "max":
        found = [shape for a in n.args for shape in _shapes(part, a)]
        if found or n is part.root or _waves(n):
            return list(dict.fromkeys(found))
    elif n is part.root:
        return []
    if not n.axes or kind(n) != "real":
        return []
    return [n] if _ends(part, n) else []


def _waves(n: Node) -> bool:
    return any(m.op in _WAVES and m.axes for m in order([n], below))


def _named(program: Program, name: str) -> Node:
    """An output or a let of the file, flat. Errors: E109."""
    found = program.named(name)
    if found is None:
        known = [*program.outputs, *program.elaborated.lets]
        near = suggest(name, known)
        hint = f"did you mean `{near}`?" if near else f"the file binds {', '.join(known) or 'nothing'}"
        raise fail("E109", f"there is no `{name}` to measure within", hint=hint)
    if not found.axes:
        hint = "name a solid: an output or a let"
        raise fail("E109", f"`{name}` is one number, and no solid to measure within", hint=hint)
    return found


def _counts(part: Any, envelope: Any, box: Box, h: float) -> Counts:
    """Components of samples at the middle of voxels: solid by faces, edges and corners, void by faces."""
    from scipy import ndimage

    inside, axes = sampled(part, box, h)
    within = envelope.on_grid(axes).all() < 0
    solid = inside & within
    void = within & ~solid
    pieces = ndimage.label(solid, np.ones((3, 3, 3)))[1]
    labels, holes = ndimage.label(void)
    rim: NDArray[np.bool_] = within & ~ndimage.binary_erosion(within)
    touching = np.unique(labels[rim & void])
    total = int(np.count_nonzero(void))
    share = float(np.count_nonzero(np.isin(labels, touching[touching > 0]))) / total if total else 0.0
    edge = np.count_nonzero(void & ~ndimage.binary_erosion(void)) if 0 < share < 1 else 0
    return Counts(int(pieces), int(holes), share, math.sqrt(edge) / max(total, 1))
