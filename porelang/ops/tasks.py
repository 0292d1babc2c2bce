"""THE TABLE OF TASKS: everything that is computed before a field, declared once.

A task is a node whose arguments are whole fields and settings. Its result is a number with an error, or data: a grid of
values, a list of bars. What reads it is `porelang.elaborate.tasks` (how it is called), the graph (what kind it is),
`porelang.tasks` (how it is computed, and kept by its content). To add a task is to add a row here, its name to the
graph's (`NUMBERS` or `DATA` in `porelang.ir`), and what computes it to `porelang.tasks.run`; a call that takes more
than fields has a function in `porelang.elaborate.tasks`. A test says which of them is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from porelang.ops.row import Kind
from porelang.units import AREA, LENGTH, RATIO, VOLUME, Dimension

#: `instant`: done by every command, `pore check` too, so that what is wrong is said at once. `seconds`: only on demand.
Cost = Literal["instant", "seconds"]
SAME = "of the field"


@dataclass(frozen=True, slots=True)
class Task:
    """All there is to know of a task but how it is computed.

    `parameters` are its arguments in the language, in order; `optional` counts the last ones that may be left out.
    `result` is the kind of its node, `dimension` what a number it gives is measured in (`SAME`: what its first field
    is; None: not known). `activity` is what is said of it while it runs.
    """

    name: str
    parameters: tuple[str, ...]
    result: Kind
    dimension: Dimension | str | None
    cost: Cost
    doc: str
    optional: int = 0
    activity: str = "finding numbers from fields"


_ROWS = (
    Task("porosity", ("f", "within"), "real", RATIO, "seconds",
         "The void fraction of a solid within another: 1 - volume(f & within) / volume(within)."),
    Task("volume", ("f",), "real", VOLUME, "seconds", "The volume of a solid, in mm^3."),
    Task("area", ("f",), "real", AREA, "seconds", "The area of a solid's surface, in mm^2."),
    Task("min_wall", ("f",), "real", LENGTH, "seconds",
         "The thickness of the thinnest walls of a solid, in mm: between parallel sides, as a hundredth of its surface "
         "has them at least; edges that run out to nothing are no walls. "
         '`check min_wall(part) > 0.4mm, "must print"` fails with the place.'),
    Task("minimum", ("f", "within"), "real", SAME, "seconds", "The least value of a field within a solid."),
    Task("maximum", ("f", "within"), "real", SAME, "seconds", "The greatest value of a field within a solid."),
    Task("mean", ("f", "within"), "real", SAME, "seconds", "The mean value of a field within a solid."),
    Task("to_porosity", ("f", "phi", "within"), "real", SAME, "seconds",
         "The offset d for which `offset(f, d)` has the porosity phi within a solid."),
    Task("shell_to_porosity", ("f", "phi", "within"), "real", SAME, "seconds",
         "The thickness t for which `shell(f, t)` has the porosity phi within a solid."),
    Task("solve", ("f", "target", "range"), "real", None, "seconds",
         "The number t in lo..hi for which a function takes a value: the only one, and none that a jump skips."),
    Task("load", ("path", "name", "outside", "smooth", "voxel", "unit", "lengths"), "grid", None, "instant",
         'A field from samples in a file beside the program, .npz, .vtu, .vtk, .vti or .nrrd: `load("stress.vtu", '
         '"von_mises")`. Between samples the field is trilinear, or with `smooth=true` tricubic, its gradient smooth; '
         "beyond what the file covers it is `outside`, or goes on as at the boundary where that is not given. Cells "
         "are sampled every `voxel`, half their shortest edge unless given. `unit=MPa` says what values are in, "
         "`lengths=m` what places are in, where that is not mm.",
         5, "reading data"),
    Task("sample", ("f", "voxel", "within", "smooth"), "grid", SAME, "seconds",
         "The field f sampled every `voxel` over the box of a solid, once, and read from the samples from then on: for "
         "what is costly to evaluate. `smooth=true` reads them with a smooth gradient.", 1, "sampling a field"),
    Task("blur", ("f", "sigma", "within", "voxel", "smooth"), "grid", SAME, "seconds",
         "The field f averaged about each point by a Gaussian of the standard deviation `sigma`, a length, in the box "
         "of a solid: what changes faster is gone. It is sampled every `voxel`, half of sigma unless given.",
         2, "blurring a field"),
    Task("frame", ("path", "joint"), "segments", None, "instant",
         'The bars of a file as a solid, round at their ends: `frame("truss.json")`, which holds {"nodes": [[x, y, z], '
         '...], "bars": [[i, j], ...], "radii": [...]}, in mm. Its value is the distance to the nearest surface. '
         "`joint=2mm` makes fillets where bars meet, of this radius where they are tightest at a right angle: they "
         "begin 1.78 of it from a corner. Where N bars are equally near the surface lies 1.78 joint (1 - N^(-1/3)) "
         "farther out, and nowhere more than 1.78 of it; where one is alone it stays where it was.",
         1, "reading data"),
    Task("cell", (), "segments", None, "instant", "The bars of a cell, in parts of it.", 0, "reading data"),
    Task("truss", ("cell", "w", "r", "phase", "joint"), "segments", None, "instant",
         'Struts of the radius `r` in cells that repeat, as a solid, round at their ends: `truss("octet", 10mm, '
         "0.6mm)`. Its value is the distance in mm to the nearest surface, true everywhere; `r` may be a field. `cell` "
         "is a name, a list of bars in parts of the cell, `[[[0, 0, 0], [1, 1, 1] / 2], ...]`, or a file of these, "
         '`"mine.json"`, which holds {"nodes": [[x, y, z], ...], "bars": [[i, j], ...]} and may hold "radii", a factor '
         "of `r` for each bar; `w` is the size of a cell, one length or three. With a field as `w`, or with a `phase` "
         "in turns instead, as of `phase(w, part)`, it is the distance in a cell times the size that cells have at the "
         "place: true where they are neither stretched nor change fast. `joint` makes fillets, as of `frame`, up to "
         "0.28 of the least side of a cell.", 4, "laying out struts"),
    Task("phase", ("w", "within", "orientation", "keep", "cells"), "grid", RATIO, "seconds",
         "The phase of a lattice whose cells have the size w, a field, within a solid: `gyroid(phase=phase(w, part))`. "
         "As near to that as can be, and it says what it got: cells of one shape whose size varies exist for few w. "
         'They may turn a little (`orientation="free"`), which gets nearest, or keep the directions of the axes '
         '(`"fixed"`), or stand along a direction, a vector field, as `align` has it, or in a frame: '
         '`orientation=[v, u]`, v and u as near as can be; `keep="volume"` gives up some of '
         "their shape for their size. `cells` fits a whole number of them into the box of the solid: `12` along its "
         'longest side, `[4, 4, 12]` along each, or `"whole"`, the nearest. Beyond that box and a sixteenth of its '
         "longest side the lattice ends.", 3, "finding a phase"),
    Task("bound", (), "grid", None, "instant", "What a param that takes data is bound to, held in memory."),
    Task("mesh", ("path", "error", "margin", "unit"), "grid", None, "seconds",
         'The mesh of a file as a solid: `mesh("part.stl")`, also .obj, .ply, .off, .glb, .3mf and .step. Lengths are '
         "in mm where the file does not say, or in the `unit` given, as 1in. The value is the signed distance to the "
         "surface, read from samples whose spacing follows `error`: near the surface it errs by that much at most, "
         "1/128 of the longest side unless given. Holes are closed. Farther than `margin` from its box, 1/16 of the "
         "longest side unless given, it is 0.7 of the distance at least.",
         3, "measuring a mesh"),
    Task("study", ("part", "fix", "load", "material", "E", "nu", "density", "size", "order", "outside", "smooth",
                   "balanced"),
         "grid", None, "seconds",
         "The stresses and displacements of a linear elastic part that is held where `fix` holds and loaded by `load`: "
         "`study(part, fix=z < 0mm, load=force(z > 9mm, [0, 0, -1kN]), material=\"PA12\")`. Fields: `.von_mises`, "
         "`.principal1` to `3`, `.direction1` to `3`, `.displacement`, `.stress`, `.strain`, `.energy`; numbers: "
         "`.stiffness`, `.compliance`, `.max_von_mises`, `.von_mises_99`, `.max_displacement`, `.mean_displacement`, "
         "`.volume`, `.mass`, `.error`. With `balanced=true` loads that balance each other need no support.",
         9, "solving for stresses"),
    Task("of_study", (), "real", None, "seconds", "A number that a study gives.", 0, "solving for stresses"),
)  # fmt: skip

TASK_TABLE: dict[str, Task] = {row.name: row for row in _ROWS}
