"""E140-E144, W232, W233 and W242: meshes that a program reads as shapes."""

from __future__ import annotations

from porelang.error_codes.page import Code

SHAPES = (
    Code(
        "E140",
        "a mesh that is damaged, or holds no triangles",
        "The file is not what its ending says (.stl, .obj, .ply, .off, .glb, .3mf or .step), was cut short, or holds\n"
        "points and curves without triangles. Export it again, as a mesh of triangles.",
        "",
        "",
    ),
    Code(
        "E141",
        "a mesh whose corners are no places of a part",
        "Corners are finite numbers within 100,000 mm of the origin, and not all at one place. Lengths are read as\n"
        "mm, which STL, OBJ, PLY and OFF do not say; glTF (.glb) is in metres by its standard.",
        "",
        "",
    ),
    Code(
        "E142",
        "a mesh that encloses nothing",
        "A solid needs an inside. Holes are closed, each by a fan of triangles from the middle of its rim; where that\n"
        "leaves no volume, as of a flat sheet, there is none. Give the sheet a thickness where it was made.",
        "",
        "",
    ),
    Code(
        "E143",
        "a mesh that cannot be sampled, or not with this error, margin or unit",
        "The distance to a mesh is sampled on a grid whose cells follow `error`: half the diagonal of a cell, by\n"
        "which a lookup between exact samples errs at most. It is above 0, and large enough for the samples to fit\n"
        "into memory: half the error takes eight times as many. A .step file says its unit itself. And triangles\n"
        "that hang together nowhere, or cross each other everywhere, are no surface for samples to follow: mend them\n"
        "in the program that made them.",
        "",
        "",
    ),
    Code(
        "E144",
        "a mesh that could not be measured",
        "Meshes are measured in a process of their own, so that one which is damaged harms nothing else. That process\n"
        "could not be started, crashed, or ran out of memory. Or the file is a .step, which takes the package\n"
        "cascadio: `pip install cascadio`.",
        "",
        "",
    ),
    Code(
        "W232",
        "a mesh that is not watertight",
        "There are edges at which no triangle follows. Each hole that they make is closed by a fan of triangles from\n"
        "the middle of its rim: exact where the rim is flat, a guess elsewhere, and the distance is to that as well.\n"
        "The message says how many edges there are, and where the largest hole is. Look at the place in a section,\n"
        "`pore render part.pore --section z=10mm`; where its shape matters, close it where the mesh was made.",
        "",
        "",
    ),
    Code(
        "W233",
        "a mesh whose sizes do not fit",
        "Either the whole of it is much smaller or larger than parts are: files of meshes hold numbers without a\n"
        "unit, which are read as mm, and `unit=1in` says otherwise. Or it has walls or gaps that are thinner than the\n"
        "samples of its distance are apart, so that they are missing or have holes: its `error` is 1/128 of the\n"
        "longest side unless given, and walls need one of half their thickness.",
        "",
        "",
    ),
    Code(
        "W242",
        "a mesh that is known less well than was asked",
        "The distance to a mesh is that to its outer surface. Where triangles cross each other in many places, as\n"
        "in scans that lie over one another, some of what lies within is counted as surface: the error that is stated\n"
        "holds for it too. Unite the shells in the program that made the mesh, or see that walls are much thicker.",
        "",
        "",
    ),
)
