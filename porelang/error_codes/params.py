"""E080-E099, W201 to W207: params, their settings, and contracts that depend on them."""

from __future__ import annotations

from porelang.error_codes.page import Code

PARAMS = (
    Code(
        "E080",
        "a default outside its range",
        "The default of a param is one of the values it may have.",
        "param w = 5mm in 10mm..60mm\ngyroid(w) & sphere(20)",
        "param w = 15mm in 10mm..60mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "E081",
        "a range that holds nothing",
        "The lower end of a range comes first, and the step fits into it.",
        "param w = 30mm in 60mm..10mm\ngyroid(w) & sphere(20)",
        "param w = 30mm in 10mm..60mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "E082",
        "choices of different kinds",
        "A param chooses among numbers, texts, conditions or functions, all of one kind.",
        "param kind = gyroid in {gyroid, 5}\nkind(10) & sphere(20)",
        "param kind = gyroid in {gyroid, diamond}\nkind(10) & sphere(20)",
    ),
    Code(
        "E083",
        "a setting for a param that does not exist",
        "`--set NAME=VALUE`, or a keyword in Python, names a param of the program. The params of a used file are\n"
        "written with its name before them: `plates.t`.",
        "",
        "param w = 30mm in 10mm..60mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "E084",
        "a setting that is no value of its param",
        "A setting is a number, with or without a unit (`25`, `2.5cm`), or the name of one of the choices. A bare\n"
        "number is in base units: mm, rad, N, MPa.",
        "",
        "param w = 30mm in 10mm..60mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "E085",
        "a setting outside its range",
        "The range of a param is a promise of the program: within it the program was checked. Widen the range in the\n"
        "program if the value makes sense.",
        "",
        "param w = 30mm in 10mm..60mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "E086",
        "a contract that some setting breaks",
        "What a function asks of its arguments is proven for every value that the params may take; the message names\n"
        "settings that break it. Narrow the range, or change the formula so that it holds.",
        "param r = 10mm in 0mm..20mm\nsphere(r)",
        "param r = 10mm in 1mm..20mm\nsphere(r)",
    ),
    Code(
        "E087",
        "a preset of what is no param",
        "A preset names values of params, of this file or of one it uses (`plates.t = 2mm`). What is bound with `let`\n"
        "is not set from outside.",
        'param w = 30mm in 10mm..60mm\npreset "fine": v = 12mm\ngyroid(w) & sphere(20)',
        'param w = 30mm in 10mm..60mm\npreset "fine": w = 12mm\ngyroid(w) & sphere(20)',
    ),
    Code(
        "E088",
        "a preset that does not exist",
        "`--preset NAME`, or `preset=` in Python, names a `preset` of the program.",
        "",
        'param w = 30mm in 10mm..60mm\npreset "fine": w = 12mm\ngyroid(w) & sphere(20)',
    ),
    Code(
        "E089",
        "a preset that does not read",
        "A preset has a name in quotes, then `:`, then params with their values, with commas between. It may go on\n"
        "over lines that end with a comma.",
        "param w = 30mm in 10mm..60mm\npreset fine: w = 12mm\ngyroid(w) & sphere(20)",
        'param w = 30mm in 10mm..60mm\npreset "fine": w = 12mm\ngyroid(w) & sphere(20)',
    ),
    Code(
        "W201",
        "a contract that a field breaks somewhere",
        "What a function asks of a field could not be proven within the part's box, and a point was found where it is\n"
        "broken; the message names it. The program runs, but at such points its values mean nothing.",
        "gyroid(x) & sphere(20)",
        "gyroid(20 + x / 20) & sphere(20)",
    ),
    Code(
        "W202",
        "a mesh that is not the part",
        "The volume of the mesh differs from that of the part by more than 3 % and more than the error of the\n"
        "latter. Most often walls are thinner than a voxel: they come out torn, as specks, or not at all. Or it was\n"
        "--simplify that took too much: the message says so. Mesh again with a smaller --voxel; a few voxels to the\n"
        "thinnest wall give a sound mesh.",
        "",
        "",
    ),
    Code(
        "W203",
        "a check that its numbers do not decide",
        "A number found from whole fields has an error. This check holds for some numbers within the error, and for\n"
        "others not: `porosity(...) >= 50%` of a part that was made to have 50 %. The message says what was compared,\n"
        "with its error, and on which side the number itself lies. Nothing is refused for it. Leave a margin.",
        "",
        "",
    ),
    Code(
        "W204",
        "a surface that float32 cannot place",
        "Far from the origin, or where large numbers cancel, rounding moves the surface by more than an eighth of the\n"
        "voxel. NumPy then computes in float64 by itself; GLSL has no such numbers. Move the part to the origin, or\n"
        "use `--backend numpy`.",
        "",
        "sphere(10)",
    ),
    Code(
        "W205",
        "a mesh that lacks something of the part",
        "Something of the part lies between the samples: pins, ribs, walls or gaps thinner than the voxel, or whole\n"
        "pieces and voids smaller than it, of which the message names a place; or narrow gaps are bridged here and\n"
        "there, and thin walls have holes; or pieces of the mesh hang together in the part, by necks thinner than the\n"
        "voxel. The field was followed to that place: the part is there. Use the voxel that the message\n"
        "names, or `--voxel auto`.",
        "",
        "",
    ),
    Code(
        "W206",
        "an answer beside which there may be others",
        "`solve` found an answer, but the function was seen to rise in one part of the range and to fall in another.\n"
        "It asks for numbers found from whole fields, each of which takes a while, so that it was looked at in a few\n"
        "places only: it may pass its target between them too. Narrow the range to where it rises or falls throughout.",
        "",
        "let r = solve(t => volume(sphere(t)), 100, 1..10)\nsphere(r)",
    ),
    Code(
        "W207",
        "a mesh that runs through itself",
        "Triangles cross others. Sheets less than a voxel apart, or the tips of wedges that are cut sharp or\n"
        "simplified, may pass each other. Slicers mostly cope with it, programs that fill a mesh with tetrahedra do\n"
        "not. Use a smaller --voxel, or mesh without --sharp and --simplify.",
        "",
        "",
    ),
)
