"""E100-E119, E196-E198: what is asked of a program: its outputs, bounds, points, meshes and files, its names."""

from __future__ import annotations

from porelang.error_codes.page import Code

REQUESTS = (
    Code(
        "E100",
        "an output that does not exist",
        "A program has the outputs that it names with `out`, and `part`, its last bare expression. With several, and\n"
        "none called part, say which with `--out NAME`.",
        "",
        "out solid = sphere(20)\nout skin = shell(sphere(20), 2)",
    ),
    Code(
        "E101",
        "an output that has no surface",
        "A surface is where a number passes zero: a vector and a condition have none. They can be evaluated at points.",
        "",
        "out direction = grad(sphere(20))\nout part = sphere(20)",
    ),
    Code(
        "E102",
        "a part without an end",
        "A lattice fills all of space. Intersect it with a shape, or say with `--bounds` which box you want of it.\n"
        "Of some formulas no end can be proven though they have one: then it is said how far samples found material,\n"
        "and which `--bounds` hold that with some room.",
        "",
        "gyroid(30) & cylinder(75, 300)",
    ),
    Code(
        "E103",
        "a part without material",
        "The field is positive everywhere: solid is negative. Perhaps a sign is turned, an offset is too large, or\n"
        "two parts that are intersected do not meet.",
        "",
        "sphere(20) & translate(sphere(20), [30, 0, 0])",
    ),
    Code(
        "E104",
        "points that are none",
        "Points are rows of three finite numbers, x, y, z in mm: an array of shape (n, 3), or lines of CSV. A first\n"
        "line that names the columns x, y and z picks them out of more.",
        "",
        "",
    ),
    Code(
        "E105",
        "a file that cannot be read",
        "The file is not there, is a folder, or may not be read. The path of a `use` starts at the file that uses it.",
        'use "nowhere.pore" as parts\nparts.a',
        "sphere(20)",
    ),
    Code(
        "E106",
        "a file that is no text",
        "A program is a text in UTF-8.",
        "",
        "sphere(20)",
    ),
    Code(
        "E107",
        "bounds that hold nothing",
        "Bounds are the lower corner and the upper corner of a box, in mm: x0,y0,z0,x1,y1,z1.",
        "",
        "",
    ),
    Code(
        "E108",
        "a command line that cannot be read",
        "A command, an option or its value is not known, or options contradict each other, on the command line or in\n"
        "a call from Python. `pore --help` lists the commands and `pore COMMAND --help` the options of one.",
        "",
        "",
    ),
    Code(
        "E109",
        "an envelope that does not exist",
        "`--within NAME` names an output or a `let` of the program: the solid whose share of void is the porosity. It\n"
        "is a plain shape, which does not itself depend on numbers found from fields.",
        "",
        "",
    ),
    Code(
        "E110",
        "a field that is not a number",
        "At the point named the field is undefined: a division of zero by zero, the root or logarithm of a negative\n"
        "number, a power of a negative number. Such a place has no inside and no outside. A field that is infinite\n"
        "nearly everywhere was divided by zero, and has no surface that could be measured.",
        "",
        "sqrt(max(x, 0)) - 2 & sphere(10)",
    ),
    Code(
        "E111",
        "a part without a surface",
        "Within the box that was sampled the field does not pass zero. The message gives the range of its values and\n"
        "the place where it came nearest. Solid is negative; walls thinner than the voxel are missed.",
        "",
        "shell(sphere(20), 2)",
    ),
    Code(
        "E112",
        "a file format that is not known",
        "The ending of a file's name says how it is written: .stl, .obj, .ply, .3mf, .glb, .vtp for\n"
        "meshes, .npy for values.",
        "",
        "",
    ),
    Code(
        "E113",
        "a file that cannot be written",
        "The folder is not there, is full, or may not be written to; or what is there is no file to be replaced: a\n"
        "device, a pipe, a folder that holds more than layers, a file that was made read-only. A file is written\n"
        "whole or not at all.",
        "",
        "",
    ),
    Code(
        "E114",
        "a grid that cannot be",
        "The voxel, the resolution or the bounds make no grid, or one of more samples than anybody waits for. The\n"
        "message says which voxel would do; `--bounds` meshes a part of the whole.",
        "",
        "",
    ),
    Code(
        "E115",
        "a mesh that is too fine for its format",
        "STL stores seven digits: two corners that lie closer together become one. .ply and .obj keep more.",
        "",
        "",
    ),
    Code(
        "E116",
        "what a function modifies does not read",
        "`pore notation` writes each step as the paper does, and takes what a function modifies from its\n"
        "documentation: `## Modifies:`, then type, space, wavelength, distance or ratio, `by` and a parameter, or\n"
        "several (`by w or phase`). Where the argument does not show what it amounts to, `, as a local frame` or\n"
        "`, as a vector field` follows.",
        "",
        "## Walls that grow with d.\n"
        "## Modifies: distance by d\n"
        "def walls(f: field, d: field) = shell(f, 1) - d\n"
        "walls(sphere(20), z / 40) & sphere(40)",
    ),
    Code(
        "E117",
        "beyond 100 m from the origin",
        "Parts and bounds lie within 100 m (100 000 mm) of the origin. Beyond, float32 tells no places apart that are\n"
        "nearer to each other than 0.008 mm, and printers end long before. Lengths are in mm: perhaps a unit slipped.",
        "",
        "translate(sphere(10), [90000, 0, 0])",
    ),
    Code(
        "E118",
        "a mesh that lost too much of the part",
        "The volume of the mesh differs from that of the part by more than a fifth: most of what is thinner than the\n"
        "voxel is gone, the rest is in pieces. The message names a voxel that would hold the walls. With `--force`\n"
        "(in Python `force=True`) it is written as it is, with a warning.",
        "",
        "",
    ),
    Code(
        "E119",
        "a mesh that would not be sound",
        "Every mesh is closed, faces outward, has no triangle without area and no two vertices in one place; what\n"
        "broke that could not be mended. Such places come from fields that jump, or are flat where they are 0. Use\n"
        "another voxel, or leave out --sharp, --smooth or --simplify.",
        "",
        "",
    ),
    Code(
        "E196",
        "a name that cannot be changed to that",
        "An editor changes a name in all places where it stands for the same. The language's own names are in all\n"
        "files; a new name is letters, digits and _, and is bound to nothing else in the file.",
        "",
        "",
    ),
    Code(
        "E197",
        "what no function of 3MF can say",
        "`pore volume part.pore -o part.3mf` writes the field as a graph of the nodes that the Volumetric and\n"
        "Implicit extensions of 3MF have. They have none that searches bars or random sites, draws numbers by chance\n"
        "or finds principal values, and their images are read linearly. `sample(f, 1mm, body)` evaluates such a field\n"
        "on a grid over the box of a solid: that is written as an image. The error that is stated then is that of the\n"
        "image: what is thinner than some four samples is lost or changed before. Or write a mesh.",
        "",
        "let body = box([20, 20, 20])\nbody & sample(voronoi_cells(8mm, 1mm), 0.5mm, body)",
    ),
    Code(
        "E198",
        "a part that is no union of bars",
        "`pore mesh part.pore -o part.3mf --beams` writes bars as bars: their ends and radii, in place of triangles.\n"
        "The part has to be `truss(...)` or `frame(...)`, moved or turned if need be, or several of these joined by\n"
        "`|`, alone or within a solid, `truss(...) & box([50, 50, 50])`. Fillets, walls, other shapes, radii that\n"
        "vary and places that are bent or scaled are no bars: leave out --beams for a mesh.",
        "",
        'truss("octet", 10mm, 0.6mm) & box([50, 50, 50])',
    ),
)
