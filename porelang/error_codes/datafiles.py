"""E130-E139 and E150-E159: files of data that a program reads, and data that are handed to it."""

from __future__ import annotations

from porelang.error_codes.page import Code

DATAFILES = (
    Code(
        "E130",
        "a data file that cannot be read",
        "There is no such file, it is a folder, a device or a pipe, its permissions forbid it, or it changed while it\n"
        "was read. Only regular files are opened.",
        "",
        "",
    ),
    Code(
        "E131",
        "a data file of another kind, or a damaged one",
        "Grids are .npz files as numpy.savez and numpy.savez_compressed write them, .vti, .nrrd; cells are .vtu and\n"
        ".vtk, as VTK writes them, without compression or with that of zlib; frames are .json files in UTF-8.\n"
        "A file that was cut short, or whose checksum is wrong, is not used at all.",
        "",
        "",
    ),
    Code(
        "E132",
        "data that are not in the file",
        "A grid needs its array, by the name that the program gives, and beside it `origin` (the place of the first\n"
        "node, three numbers) and `spacing` (one number or three), in mm:\n"
        "    numpy.savez(path, stress=values, origin=[0, 0, 0], spacing=0.5)\n"
        "A frame needs `nodes`, `bars` and `radii`, or one `radius` for all:\n"
        '    {"nodes": [[0, 0, 0], [10, 0, 0]], "bars": [[0, 1]], "radii": [1]}',
        "",
        "",
    ),
    Code(
        "E133",
        "data of a form that cannot be used",
        "The values of a grid are numbers in an array (nx, ny, nz), (nx, ny, nz, 3) for vectors or (nx, ny, nz, 6)\n"
        "for symmetric tensors, with two nodes or more along each axis. Objects, text and complex numbers are not\n"
        "read; to read objects could run code. A frame is lists of numbers, one radius for each bar.",
        "",
        "",
    ),
    Code(
        "E134",
        "numbers that data cannot have",
        "Values are finite, and 1e37 at most, for shaders compute in float32: NaN and infinity have no place in a\n"
        "field. Spacings and radii are above 0, and all lies within 100,000 mm of the origin. Lengths are in mm.",
        "",
        "",
    ),
    Code(
        "E135",
        "data that are too large",
        "An array takes 2 GB at most once it is read, a frame 256 MB as text. Keep every second node, a part of the\n"
        "grid, or float32 in place of float64.",
        "",
        "",
    ),
    Code(
        "E136",
        "a bar without two ends",
        "A bar joins two nodes, which it names by their numbers, counted from 0. Its nodes exist and lie apart: a bar\n"
        "that joins a node with itself, or two nodes at one place, has no direction.",
        "",
        "",
    ),
    Code(
        "E150",
        "cells that have no values inside",
        "A field inside a part comes from cells with a volume: tetrahedra, hexahedra, wedges and pyramids, of first\n"
        "or second order. Triangles and quadrangles are a surface; they and bars are left out where there are others.\n"
        "Polyhedra with any number of faces are not read: most programs can cut them into tetrahedra.",
        "",
        "",
    ),
    Code(
        "E151",
        "data of several times",
        "A field has one value in each place. A file that holds several time steps does not say which is meant: write\n"
        "the step that counts, or the greatest value of all of them, as a file of its own.",
        "",
        "",
    ),
    Code(
        "E152",
        "a spacing that cells cannot be sampled with",
        "Cells are sampled on a grid: every `voxel` mm, or where that is not given every half of the median edge of\n"
        "the cells. It is a length above 0; what it makes of the box of the cells has room in 2 GB. A file that is a\n"
        "grid already (.npz, .vti, .nrrd) is read as it is, and takes no `voxel`.",
        "",
        "",
    ),
    Code(
        "E153",
        "a unit that data cannot be in",
        "Data in a file are numbers. `unit=` says what one of them is: values are multiplied by it, and carry its\n"
        "dimension from then on. There names of units stand alone, `unit=MPa` or `unit=N/mm^2`; a text and an amount\n"
        'do as well, `unit="MPa"` and `unit=1MPa`.',
        "",
        "",
    ),
    Code(
        "E154",
        "a param for data that is not declared as one",
        "A param with a kind takes data, from Python or from a file: `field` is one number in each place, `vector`\n"
        "three, `tensor` six. Its default holds where nothing is bound, and says what the data are measured in.\n"
        "A param that is a number has a range instead.",
        "param stress: stress = 0MPa",
        'param stress: field = 0MPa "von Mises"',
    ),
    Code(
        "E155",
        "data that cannot be bound",
        "Data are bound to params that are declared for it, `param stress: field = 0MPa`: by the option\n"
        "`--bind stress=FILE:ARRAY`, or from Python, `program.bind(stress=data)`. There they are a SampledField, an\n"
        "array (nx, ny, nz) whose nodes span the box `within`, or a function of points (n, 3), which is sampled every\n"
        "`voxel` over `within`. A vector has three numbers in each place, a tensor six: xx, yy, zz, xy, yz, xz. All\n"
        "are finite, in base units: mm, rad, N and MPa.",
        "",
        "",
    ),
    Code(
        "E156",
        "a blur that cannot be made",
        "`blur` averages a field about each point by a Gaussian: `sigma` is its standard deviation, a length above 0.\n"
        "It is made from samples, which lie half of sigma apart unless `voxel` is given. Samples that are farther\n"
        "apart than sigma say nothing of what lies between them.",
        "blur(x, 1mm, cube(20), voxel=2mm)",
        "blur(x, 1mm, cube(20), voxel=0.5mm)",
    ),
)
