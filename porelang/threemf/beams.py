"""A part that is a union of bars as a beam lattice in a 3MF file: ends and radii, in place of triangles.

Ends are round (`cap="sphere"`), as those of `truss` and `frame` are, so that no balls are needed at nodes. What cuts
the bars is written as a clipping mesh: exactly where it is a box along the axes, else as triangles on a voxel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from porelang.analysis.bounds import box_test
from porelang.analysis.box import Box, block, extent_of
from porelang.analysis.enclose import EXACT
from porelang.atomic import save
from porelang.diagnostics import fail
from porelang.field import Bounds, checked_bounds
from porelang.formula import Formula
from porelang.ir import Node, node
from porelang.mesh.exchange import lines, write_mesh
from porelang.mesh.grid import Grid
from porelang.mesh.part import Placed, notes_of, surface_in
from porelang.mesh.surface import Surface
from porelang.program import Design
from porelang.progress import activity
from porelang.rewrites import flatten
from porelang.solid import Solid
from porelang.threemf.bars import Beams, NoBarsError, bars_of, laid_out
from porelang.threemf.package import NUMBER, box_mesh, package
from porelang.threemf.places import place_of, roomy
from porelang.walls import chosen

WRITING = "laying out bars"
BEAMS = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
#: How far inside its ends (a share of its longest side) a solid has to be full to be taken for a box.
FULL = 1e-9


@dataclass(frozen=True, slots=True)
class Clip:
    """What bars are cut by: a box, or a surface on a voxel (mm)."""

    box: Box
    surface: Surface | None = None
    voxel: float = 0.0


def write_beams(
    design: Design,
    path: str | Path,
    *,
    name: str | None = None,
    bounds: Bounds | None = None,
    voxel: float | None = None,
    resolution: int | None = None,
) -> dict[str, Any]:
    """Write an output that is a union of bars, cut by its solids and at the `bounds`, as bars. `voxel` (mm) or
    `resolution` are those of the mesh that cuts them, where that is no box; it is found from its walls if not given.

    The file appears whole or not at all. Returns how many bars and nodes there are, and what cuts them.
    Errors: E198 for what is no union of bars, E113 for a file that cannot be written, those of outputs and bounds.
    """
    name = design.program.output(name)
    formula = design.of(name)
    with activity(WRITING):
        try:
            laid, clips = bars_of(formula)
            box = checked_bounds(bounds) if bounds is not None else roomy(design.bounds(name))
            cut = _met(formula, clips, box) if clips or bounds is not None else None
            beams = laid_out(laid, box, None if cut is None else box_test(cut, EXACT))
        except NoBarsError as error:
            raise fail(
                "E198", f"`{name}` is no union of bars: {error.why}", place_of(design, name, error.op or None),
                hint="leave out --beams for a mesh; `pore explain E198` says what can be written as bars",
            ) from None  # fmt: skip
        if not len(beams.pairs):
            raise fail("E103", f"`{name}` has no bars in its box", design.program.outputs[name].span)
        clip = None if cut is None else _clip(design, cut, box, voxel, resolution)
        save(path, lambda file: _write(file, design, name, beams, clip))
    return {
        "output": name,
        "bars": len(beams.pairs),
        "nodes": len(beams.places),
        "radius": [float(beams.radii.min()), float(beams.radii.max())],
        "clip": None if clip is None else _told(clip),
        "bytes": Path(path).stat().st_size,
    }


def _met(formula: Formula, clips: Sequence[Node], box: Box) -> Formula:
    """What cuts bars in a box, as one solid: a box is never wider than the part needs, for others have no end."""
    (root,) = flatten(reduce(lambda a, b: node("max", a, b), clips, block(box)))
    return formula.with_roots(root)


def _clip(design: Design, cut: Formula, box: Box, voxel: float | None, resolution: int | None) -> Clip:
    extent = extent_of(cut)
    ends = box if extent is None else extent.outer
    (x0, y0, z0), (x1, y1, z1) = ends.lo, ends.hi
    room = FULL * max(ends.size)
    within = np.array([[x0 + room, y0 + room, z0 + room]]), np.array([[x1 - room, y1 - room, z1 - room]])
    if box_test(cut, EXACT)(*within)[1][0] < 0:
        return Clip(ends)
    if voxel is None and resolution is None:
        voxel = chosen(Solid(cut, (ends.lo, ends.hi))).voxel
    h = Grid.cover(ends.lo, ends.hi, voxel, resolution).spacing
    low, high = (x0 - h, y0 - h, z0 - h), (x1 + h, y1 + h, z1 + h)
    placed = Placed(Grid.cover(low, high, spacing=h), (low, high))
    return Clip(ends, surface_in(design, cut, placed), h)


def _told(clip: Clip) -> dict[str, Any]:
    if clip.surface is None:
        return {"lo": list(clip.box.lo), "hi": list(clip.box.hi)}
    return {"triangles": len(clip.surface.faces), "voxel": clip.voxel}


def _write(file: BinaryIO, design: Design, name: str, beams: Beams, clip: Clip | None) -> None:
    """The clipping mesh, then the bars: a mesh without triangles, whose vertices are the ends."""
    number = 1 if clip is None else 2
    values, counts = np.unique(beams.radii, return_counts=True)
    usual = float(values[counts.argmax()])
    lengths = np.linalg.norm(beams.places[beams.pairs[:, 0]] - beams.places[beams.pairs[:, 1]], axis=1)
    cuts = "" if clip is None else ' clippingmode="inside" clippingmesh="1"'
    with package(file, notes_of(design, name), build=number, extensions={"b": BEAMS}, required=("b",)) as model:
        if clip is not None and clip.surface is None:
            model.write(f'\n<object id="1" type="model">{box_mesh(clip.box.lo, clip.box.hi)}</object>'.encode())
        elif clip is not None and clip.surface is not None:
            write_mesh(model, 1, clip.surface)
        model.write(f'\n<object id="{number}" type="model"><mesh><vertices>\n'.encode())
        for piece in lines(f'<vertex x="{NUMBER}" y="{NUMBER}" z="{NUMBER}"/>\n', beams.places):
            model.write(piece)
        model.write(
            f'</vertices><b:beamlattice minlength="{min(1e-4, lengths.min() / 2):.6g}" radius="{usual!r}" '
            f'cap="sphere"{cuts}><b:beams>\n'.encode()
        )
        same = beams.radii == usual
        for piece in lines('<b:beam v1="%d" v2="%d"/>\n', beams.pairs[same].astype(np.int32)):
            model.write(piece)
        rows = np.column_stack([beams.pairs[~same], beams.radii[~same]]).astype(np.float64)
        for piece in lines(f'<b:beam v1="%d" v2="%d" r1="{NUMBER}"/>\n', rows):
            model.write(piece)
        model.write(b"</b:beams></b:beamlattice></mesh></object>")
