"""E190-E195, W268-W272, W277, W278, W290: the loop from stress back to geometry."""

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
        "E193",
        "nothing that a loop can adapt",
        "A loop hands samples to a param that takes data, `param t: field = 1.5`, which makes the output thicker or\n"
        "thinner, and solves a study of that output: the study is of what is iterated, not of the solid round it.\n"
        "The param is found if the output reads one alone, and so are the study and the period of the lattice; where\n"
        "they are not, name them: --adapt, --study, --cell. The density of the part has to reach the limits.\n"
        "A study is loaded by forces, under which the stiffer of two parts takes less work, or by displacements,\n"
        "under which it takes more; under both at once no single number says which is stiffer. A cell is no larger\n"
        "than the part.\n"
        "The optimum and early steps are found on the homogenised lattice. It takes forces and torques, or a test\n"
        "between two ends; no pressure, weight or displacement that is prescribed, and one Poisson's ratio.",
        "",
        "param t: field = 1.5\n"
        "let lattice = gyroid(10mm) |> shell(t) & box([60mm, 20mm, 20mm])\n"
        "let s = bend(lattice, force=100N, axis=x, toward=-z, E=1GPa, nu=0.3, size=2mm)\n"
        "lattice",
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
        "it was begun. Where a file of a step is damaged or missing, it goes on from the last step before that, and\n"
        "says so. Without `--resume` a folder that holds a record is left as it is; `--force` begins anew there: the\n"
        "older record is removed once the new one has its first step, and nothing else in the folder. Nor does a loop\n"
        "begin in a folder without a record that holds files of the names that it writes, but with `--force`.",
        "",
        "",
    ),
    Code(
        "W268",
        "what a part bears is uniform",
        "A rule of the loop thickens where more is borne than elsewhere. Here that differs by less than it is known\n"
        "to: a column between frictionless platens, say. Iterating would follow the noise of the mesh, so the uniform\n"
        "part is kept. Where it varies by less than 5 %, and a step gains less than was asked, it is nearly uniform,\n"
        "which finer elements do not change. It need not be the stiffest of its mass: where stiffness rises faster\n"
        "than density, a dense core in a light skin is stiffer.",
        "",
        "",
    ),
    Code(
        "W269",
        "a loop that gained nothing",
        "Every step was softer than the uniform part, which is kept. The rule takes too much of each change, or the\n"
        "param thins where it should thicken; or there is nothing to be had between these limits. An optimum of the\n"
        "homogenised lattice is one of many cells: where few bear the load, the energy rule on the lattice itself\n"
        "sees them as they are.",
        "",
        "",
    ),
    Code(
        "W270",
        "a gain within the noise",
        "Two meshes of a lattice differ a little in stiffness, and no step was stiffer than the uniform part by\n"
        "more: so that is kept. They differ by what each misses of its part, or joins otherwise, and by an eighth of\n"
        "what elements leave of stresses. That is less than either stiffness is known to, as the table says it: most\n"
        "of what both meshes err by is the same, and cancels. Finer elements tell more.",
        "",
        "",
    ),
    Code(
        "W272",
        "a record that was damaged",
        "A file of a step was missing, or not what was written, or a line of loop.jsonl was cut: by a disk, or a copy\n"
        "that was stopped. The loop went on from the last step that was whole, and solved those after it again.",
        "",
        "",
    ),
    Code(
        "W277",
        "a step that could not be solved",
        "The study of a later step was refused, for the reason that is told with it: walls that became thinner than\n"
        "elements no longer hang together, a pad touches nothing. The loop ended there. The best of the steps before\n"
        "it is kept, with its table and picture. Finer elements, or limits from a greater density, help: that is\n"
        "another loop, in another folder or begun anew with --force.",
        "",
        "",
    ),
    Code(
        "W278",
        "a porosity that is not kept",
        "After each step the thickness is moved until the part has the porosity that is to be kept. It could not be\n"
        "reached within the limits of the density, so that this step is heavier or lighter than the start, and what\n"
        "it gains is not at equal mass. Widen the limits, or ask for a porosity farther from them.",
        "",
        "",
    ),
    Code(
        "W290",
        "a gain that costs displacement or stress",
        "The rules of the loop make the work of the loads less, which is the mean of where these act. What moves or\n"
        "is stressed most may lie elsewhere, and become more: a corner of a lighter skin, the rim of a load. It is\n"
        "told where the greatest displacement of the best step is more than that of the uniform part by a tenth, or\n"
        "its greatest von Mises' stress by half, and by twice the share that was gained.",
        "",
        "",
    ),
    Code(
        "W271",
        "a lattice that is not cubic",
        "The law of a homogenised lattice has three constants, those of a cubic material along x, y and z. The cell\n"
        "of this one resists otherwise, as when it is longer along one axis, and what is nearest to it was taken. So\n"
        "the density that was found need not be the best; what its solution in tetrahedra says is of the real lattice.",
        "",
        "",
    ),
)
