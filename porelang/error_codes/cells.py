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
        "its longest side unless `--resolution` says otherwise, from 8 to 256; the shortest side that something\n"
        "varies along has 24 at least, or what is asked for, so that a cell may be too long for its width.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
    Code(
        "E181",
        "a cell that is no period",
        "What is homogenised repeats: the field on a face of the cell has to agree with that on the face opposite,\n"
        "and all of the part, as far as its envelope reaches, with the cell whole numbers of sides away. A lattice\n"
        "that is turned, twisted, graded or made by a phase has no period along the axes, nor has one in a cell that\n"
        "is no whole number of its periods long. The message says where it differs most, and how much of\n"
        "it. Of a graded lattice homogenize what it is at one place, as an output of its own with a constant; a cell\n"
        "that stands for itself is cut out by a box.",
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
        "does not follow from displacements. A law of the density needs two different densities and cubic cells, and\n"
        "says nothing beyond the densest. Walls that are a small share of a voxel may keep a cell from coming to\n"
        "rest: take more voxels.",
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
        "Part of the solid touches the rest neither in the cell nor through its faces, as voxels hang together, by\n"
        "common corners. It carries nothing, and is density. Printed, it would be loose powder. Where walls are so\n"
        "thin that samples may miss them it is not said, but W263.",
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
        "certain about that. It is more than 10 % here, of a modulus or the conductivity; of moduli that are less\n"
        "than a tenth of the stiffest E it is more than 10 % of that (of G and E across the axes, of half the E along\n"
        "them). Walls of less than three voxels are the usual reason, and struts that bend: take the `--resolution`\n"
        "that is proposed; twice of it is eight times the work.\n"
        "It is also said where samples and voxels do not agree on whether the solid hangs together: a gap narrower\n"
        "than a voxel is bridged by voxels, and a wall thinner than a sample comes apart in samples.",
        "",
        "(gyroid(30) |> shell(0.5)) & cylinder(75, 300)",
    ),
)
