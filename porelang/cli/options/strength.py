"""The options of studies, of the loop and of unit cells."""

from __future__ import annotations

from porelang import values
from porelang.cli.options.option import Option

STRENGTH: dict[str, Option] = {
    "cell": (
        ("--cell",),
        {
            "metavar": "A,B,C",
            "type": values.cell,
            "help": "the sides of the period along x, y and z, in mm, or one (default: the period of its lattices)",
        },
    ),
    "nu": (
        ("--nu",),
        {
            "metavar": "NU",
            "type": values.poisson,
            "default": 0.3,
            "help": "Poisson's ratio of the solid (default: 0.3)",
        },
    ),
    "voxels": (
        ("--resolution",),
        {
            "metavar": "N",
            "type": values.voxels,
            "default": 64,
            "help": "voxels along the longest side of the finest grid, in eights; 3/4, 1/2 and 3/8 of them are "
            "solved too (default: 64)",
        },
    ),
    "sweep": (
        ("--sweep",),
        {
            "metavar": "NAME=LO..HI:N",
            "type": values.swept,
            "help": "at N values of a param: the density, what resists, and the power C rho^n through it",
        },
    ),
    "reports": (
        ("-o", "--output"),
        {
            "metavar": "FILE",
            "type": values.output,
            "action": "append",
            "default": [],
            "dest": "outputs",
            "help": ".png Young's modulus by direction, .csv the same as numbers, .json all; of a sweep its plot, its "
            "table, all; repeat it for several",
        },
    ),
    "result": (
        ("-o", "--output"),
        {
            "metavar": "FILE.vtu",
            "type": values.output,
            "help": "write the elements with stresses and displacements, as ParaView opens them",
        },
    ),
    "study": (
        ("--study",),
        {
            "metavar": "NAME",
            "help": "which study of the program (default: the only one); or one of the output, as a program calls it: "
            "'compress(part, 10kN, axis=z, material=\"PA12\")'",
        },
    ),
    "refine": (
        ("--refine",),
        {"action": "store_true", "help": "solve again with finer elements where stresses err most"},
    ),
    "iterate": (("--iterate",), {"metavar": "NAME", "help": "the output that adapts (default: part)"}),
    "until": (
        ("--until",),
        {
            "metavar": "CHANGE",
            "type": values.until,
            "default": 0.005,
            "help": "end where the compliance changes by less, as in 'change<0.5%%' (default)",
        },
    ),
    "most": (
        ("--max",),
        {
            "metavar": "N",
            "type": values.steps,
            "default": 15,
            "dest": "most",
            "help": "steps at most after the uniform start (default: 15); 0 solves that alone",
        },
    ),
    "rule": (
        ("--rule",),
        {
            "metavar": "RULE",
            "choices": ("energy", "von_mises", "optimum"),
            "default": "energy",
            "help": "energy, the strain energy of the solid (default), von_mises, the designer's, or optimum, found on "
            "the homogenised lattice by its own law and then made real",
        },
    ),
    "early": (
        ("--early",),
        {
            "metavar": "WHERE",
            "choices": ("homogenised",),
            "help": "homogenised: go the first steps on voxels of the homogenised lattice, the last ones in tetrahedra",
        },
    ),
    "limits": (
        ("--limits",),
        {
            "metavar": "LOW..HIGH",
            "type": values.limits,
            "default": (0.2, 0.8),
            "help": "the least and the greatest density (default: 0.2..0.8)",
        },
    ),
    "porosity": (
        ("--porosity",),
        {
            "metavar": "SHARE",
            "type": values.share,
            "help": "the porosity to be kept, as in 50%% (default: that of the program as it stands)",
        },
    ),
    "adapt": (
        ("--adapt",),
        {"metavar": "NAME", "help": "the param that adapts (default: the only one with data that the output reads)"},
    ),
    "which": (
        ("--study",),
        {"metavar": "NAME", "help": "which study of the output (default: the only one)"},
    ),
    "averaged": (
        ("--cell",),
        {
            "metavar": "LENGTH",
            "type": values.length,
            "help": "what all is averaged over (default: the period of the lattice)",
        },
    ),
    "damping": (
        ("--damping",),
        {
            "metavar": "SHARE",
            "type": values.share,
            "default": 1.0,
            "help": "the share of each change that is made (default: 1)",
        },
    ),
    "resume": (("--resume",), {"action": "store_true", "help": "go on with the record in the folder, if there is one"}),
    "anew": (
        ("--force",),
        {"action": "store_true", "help": "begin anew in a folder that holds the record of a loop, which is removed"},
    ),
    "loop": (
        ("-o", "--output"),
        {
            "metavar": "DIR",
            "type": values.output,
            "help": "the folder of record, samples, table and picture (default: FILE with .loop for its ending)",
        },
    ),
}
