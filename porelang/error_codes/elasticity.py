"""E170-E178, W255-W259, W280-W281, W286, W288-W289: parts under load."""

from __future__ import annotations

from porelang.error_codes.page import Code

ELASTICITY = (
    Code(
        "E170",
        "a support or a load that selects nothing",
        "Supports act on the nodes of the boundary that are selected, loads on its area. Nothing was selected, and\n"
        "a load on nothing would be no load. The message says how near the boundary comes to what is selected in\n"
        "twice the part's box. Leave some room: a face at z = -150 mm is `z < -149mm`. What is small beside elements\n"
        "is looked at more closely, a load to about a sixtieth of an element. A support that holds no node is smaller\n"
        "than an element, and a load of which only some could be seen is refused: make it wider, or take finer\n"
        "elements.",
        "",
        "",
    ),
    Code(
        "E171",
        "a motion that nothing holds",
        "A part that can move as a rigid body has no displacement that could be found. The message names each\n"
        "such motion: translations, rotations about an axis through a point, and rotations with a shift along\n"
        "their axis. Add a support against it. Where loads do not drive the motion, as between frictionless\n"
        "platens, the problem may be balanced, `balanced=true`: then the motion is taken out of the result, with\n"
        "no mean displacement along it. Loads that do drive it are refused all the same: those motions are named\n"
        "which they drive by more than what elements make of the areas that they are on (W289).",
        "",
        "",
    ),
    Code(
        "E172",
        "a material that there is not",
        "Young's modulus is above 0, Poisson's ratio between -1 and 0.5, the density not below 0, everywhere in\n"
        "the part. At 0.5 a material keeps its volume, and displacements alone do not say what its pressure is. A\n"
        "field that has no value somewhere (nan) is refused with the place.",
        "",
        "",
    ),
    Code(
        "E173",
        "a part without a load",
        "All loads are 0 or there are none, a load is no finite number, a support holds no axis, or what a\n"
        "solution is to be scaled by or refined to is no number that it could be. Nor does a load do anything of\n"
        "which every node is held: supports take it at once, and nothing is strained. One on an area is refused where\n"
        "supports take more than nine tenths of it, and doubted above one tenth (W286).",
        "",
        "",
    ),
    Code(
        "E174",
        "a field of a study that gives no numbers",
        "What selects nodes and area gives True or False for each point, what gives forces and displacements\n"
        "three finite numbers. A condition in a program has no answer where it compares what is not a number: the\n"
        "message says at which place of the surface. `and` and `or` have one where the other side decides: x > 0\n"
        "and sqrt(x) < 1.",
        "",
        "",
    ),
    Code(
        "E175",
        "a mesh that is none",
        "A solve takes tetrahedra of positive volume that share their vertices, with no vertex left over.",
        "",
        "",
    ),
    Code(
        "E176",
        "a solve that does not converge",
        "The conjugate gradients made no progress. Very flat tetrahedra, moduli that differ by more than a million\n"
        "and a Poisson's ratio next to 0.5 are the common reasons; the hint says which of them are there. Where\n"
        "displacements are found all the same, and forces balance to a thousandth, the result is given, with W281.",
        "",
        "",
    ),
    Code(
        "E177",
        "supports that contradict each other",
        "Two supports prescribe different displacements for one node along one axis.",
        "",
        "",
    ),
    Code(
        "E178",
        "a piece that nothing holds",
        "The mesh is in several pieces that do not touch, and one of them is held by no support. Islands are\n"
        "common where a lattice is cut by its envelope: keep the largest piece.",
        "",
        "",
    ),
    Code(
        "W255",
        "a part in several pieces",
        "The mesh is in pieces that do not touch. Each is supported, and each deforms by itself.",
        "",
        "",
    ),
    Code(
        "W256",
        "walls of one element",
        "Much of the part is one element thick. Order 2 bends well even so; order 1 is far too stiff, and stresses\n"
        "vary across a wall in a way that one element cannot show. Two or three elements across are wanted.",
        "",
        "",
    ),
    Code(
        "W257",
        "a coarse mesh",
        "The estimate of Zienkiewicz and Zhu says that stresses are wrong by a fifth or more, in the mean of\n"
        "squares over the part. Take smaller elements, or refine where the error is.",
        "",
        "",
    ),
    Code(
        "W258",
        "a force on a point",
        "A support that selects a single node, or nodes of one line, carries a force. The stress under a point\n"
        "force has no bound: every finer mesh shows a higher one.",
        "",
        "",
    ),
    Code(
        "W259",
        "nearly incompressible",
        "Near a Poisson's ratio of 0.5 elements cannot deform without changing their volume, and are too stiff:\n"
        "those of order 1 from 0.45 on, those of order 2 from 0.495.",
        "",
        "",
    ),
    Code(
        "W280",
        "a pressure on a ragged area",
        "A pressure acts on the area that its condition selects. Where the condition follows the surface itself, as\n"
        "`length(p) < 10mm` inside a hollow sphere of that radius, the faces of elements lie on both sides of it,\n"
        "and what is left out bears no load. Give it room: `length(p) < 11mm`. The report says the area that each\n"
        "load found, and what it comes to.",
        "",
        "",
    ),
    Code(
        "W281",
        "an equilibrium that rounding ends early",
        "Forces on nodes balance to what is said, and no further in this arithmetic: where moduli differ by orders,\n"
        "stiff parts move as a whole, and small forces are the difference of large ones; where a slender part\n"
        "bends, the forces within its elements are larger than those that act by the square of how slender it is.\n"
        "The share that displacements, stiffness and compliance may be off for that is said, and is in their errors:\n"
        "the length of all displacements times what is left of forces, over the work. Above a hundredth, or where\n"
        "displacements are not found to a millionth in energy, the solve is refused (E176).",
        "",
        "",
    ),
    Code(
        "W286",
        "a load that falls on a support",
        "What of a load is on nodes that are held against it, supports take at once: the part is not strained by it,\n"
        "and stresses and displacements are those of the rest. Conditions of a load and a support overlap, as\n"
        "`z < -8mm` does with `z < -9.9mm`. Above nine tenths it is refused (E173). A load all round a part that is\n"
        "held at one end has a little of that, and a tenth is not spoken of.",
        "",
        "",
    ),
    Code(
        "W288",
        "a support that ends within elements",
        "Supports hold nodes. Where one ends within an element, what it holds reaches to its last node and no\n"
        "further: a strip of 3 mm in elements of 2.5 mm is one row of them, or two. The area that its nodes have\n"
        "is another by more than a quarter than the one that the condition holds of the surface, which is how much\n"
        "the stiffness of what is held depends on the elements. Where no more than a line of nodes is left, or a\n"
        "point, that is said too, unless the condition selects less than a twentieth of the elements there: then a\n"
        "line is meant (W258). With the size that is proposed it is a quarter at most.",
        "",
        "",
    ),
    Code(
        "W289",
        "loads that do not quite balance",
        "With `balanced=true` loads are to do no work on what is free to move. In elements an area, and its middle,\n"
        "are not quite those of the part: two forces along one line are then a little aside of each other. Up to a\n"
        "twentieth of an element aside, 0.2 % of a pressure or a weight, and of a pressure what the rim of its area\n"
        "shows by how it turns from edge to edge, that rest is taken by a force on all of the volume, which varies as\n"
        "the rigid motion does that it answers (inertia relief); the message says what it comes to, and its share of\n"
        "the loads is in the errors of displacements, stiffness and compliance. Forces and couples are given, and\n"
        "have no such error: where these do not add up to 0 the loads are refused (E171).",
        "",
        "",
    ),
    Code(
        "W291",
        "a load that is narrower than an element",
        "A part gives way under a load the more the narrower it presses: the mean displacement of a disc of radius a\n"
        "on a half-space is .54 (1 - nu^2) F / (E a). Elements do not feel how narrow a load is that covers less than\n"
        "one of their faces, or a strip of them; they take it for one as wide as a face. By how much that may be too\n"
        "little, of a rectangle on a half-space, is in the errors of displacements, stiffness and compliance.\n"
        "Stresses under such a load say nothing.",
        "",
        "",
    ),
)
