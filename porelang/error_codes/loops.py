"""E190-E195: the loop from stress back to geometry."""

from __future__ import annotations

from porelang.error_codes.page import Code

LOOPS = (
    Code(
        "E190",
        "a grid of voxels that can move freely",
        "What is solved has to be held: no rigid motion may be left. The message names those that are, such as to\n"
        "turn about z. Voxels hold each other by their faces; two that meet in an edge alone are a hinge, and count\n"
        "as two pieces. Hold the part along more axes, at more places, or use smaller voxels where a neck is thin.",
        "",
        "",
    ),
    Code(
        "E191",
        "loads and supports that select nothing",
        "A support takes nodes of the surface of the voxels, a force its faces whose middles are selected. Where\n"
        "there are none, the message says what box the voxels span. A plane wants some room: `z < -149mm` for an\n"
        "end at -150 mm. A platen, which is stiff, is the only load of its problem; and something must load the part.",
        "",
        "",
    ),
    Code(
        "E192",
        "densities that cannot be",
        "A loop keeps the mean density, and limits of it: the mean lies between them. The law of a lattice must be\n"
        "that of a material at each of its densities, and its density must rise with its thickness all along, or no\n"
        "thickness could be said to have a density. Narrow the limits to where that is so.",
        "",
        "",
    ),
    Code(
        "E194",
        "displacements that are not found",
        "The equations of the voxels are solved by steps that stop where the forces balance. They did not within the\n"
        "number that is allowed. Mostly something hangs on an edge or a corner, as on a hinge: smaller voxels\n"
        "show the neck that is there, or that there is none.",
        "",
        "",
    ),
    Code(
        "E195",
        "a record that cannot be gone on with",
        "A loop keeps a record in its folder, so that an interruption loses the step at hand and nothing else.\n"
        "`--resume` goes on with it, if the part, its study, the rule, the limits and the start are those with which\n"
        "it was begun, and its files are what was written. Without `--resume` a folder that holds a record is left\n"
        "as it is.",
        "",
        "",
    ),
)
