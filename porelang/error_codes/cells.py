"""E180-E183 and W260-W263: unit cells that are homogenised."""

from __future__ import annotations

from porelang.error_codes.page import Code

CELLS = (
    Code(
        "E180",
        "a cell that is not known",
        "`pore homogenize` takes one period of the part and asks what it does as a material. The sides of the period\n"
        "are those of the lattices in the part, where each is given one length; else say them: `--cell 10,10,15` in\n"
        "mm, along x, y and z. They may be several periods, but not a part of one. It is solved on voxels, 64 along\n"
        "its longest side unless `--resolution` says otherwise, from 8 to 256.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "E181",
        "a cell that is no period",
        "What is homogenised repeats: the field on a face of the cell has to agree with that on the face opposite. A\n"
        "lattice that is turned, twisted, graded or made by a phase has no period along the axes, nor has one in a\n"
        "cell that is no whole number of its periods long. The message says across which axis it differs, how much\n"
        "of a face, and where most.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "E182",
        "a cell without a material of its own",
        "The cell holds no solid, the field is not a number in it, or an envelope ends within it: a part that is cut\n"
        "is no period, though its faces may be alike. Homogenize the lattice alone, as an output of its own.\n"
        "The cell is centred at the origin, or at the middle of a part that is just as large.",
        "",
        "out cell = gyroid(30) |> shell(0.5)\nout part = cell & cylinder(75, 300)",
    ),
    Code(
        "E183",
        "a material that cannot be computed",
        "Poisson's ratio lies between -1 and 0.5, both excluded: at 0.5 a solid cannot be compressed, its pressure\n"
        "does not follow from displacements. A law of the density needs two different densities, and says nothing\n"
        "beyond the densest. Walls that are a small share of a voxel may keep a cell from coming to rest: take more\n"
        "voxels.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "W260",
        "a cell that is nearly a period",
        "A few points of opposite faces differ, less than a thousandth: the sides of `--cell` may be rounded, or the\n"
        "lattice is graded a little. What is found holds for the cell repeated as it is, with its small steps.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "W261",
        "pieces that hang by nothing",
        "Part of the solid touches the rest neither in the cell nor through its faces. It carries nothing, and is\n"
        "density. Printed, it would be loose powder.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "W262",
        "a cell that hangs together one way only",
        "No solid leads from a cell into the next along an axis. Pulled that way the part comes apart: stiffness is\n"
        "0 there, and so is its modulus. A rod along z, a stack of plates, balls that do not touch are such cells.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "W263",
        "voxels too coarse for a cell",
        "The numbers are extrapolated from several resolutions to voxels that vanish, and their error is what is not\n"
        "certain about that. It is more than 5 % here. Walls of less than three voxels are the usual reason: take\n"
        "twice the `--resolution`, at eight times the work.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
)
