"""E184-E189, W264-W267, W273-W275, W282-W284: studies of strength in a program."""

from __future__ import annotations

from porelang.error_codes.page import Code

STUDIES = (
    Code(
        "E184",
        "a material that is not known",
        "A study takes Young's modulus and Poisson's ratio: of a material by its name, or given as `E` and `nu`.\n"
        "These may be fields, so that core and skin differ. What is given beside a name counts before the table.\n"
        "A weight takes a density too, in g/cm^3. The table is small, and says where each number is from.",
        'let s = compress(cylinder(9mm, 20mm), force=1kN, material="nylon 99")\nsphere(s.max_von_mises / 1MPa * 1mm)',
        'let s = compress(cylinder(9mm, 20mm), force=1kN, material="PA12")\n'
        "cylinder(9mm, 20mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "E185",
        "elastic constants that no material has",
        "Young's modulus is above 0, and Poisson's ratio between -1 and 0.5: beyond them a material would give out\n"
        "energy when it is deformed. At 0.5 it keeps its volume, and displacements do not tell its pressure: rubber\n"
        "is 0.49 at most here, with elements of order 2. Of fields the message says where.",
        "let s = compress(cylinder(9mm, 20mm), force=1kN, E=2GPa, nu=0.5)\nsphere(s.max_von_mises / 1MPa * 1mm)",
        "let s = compress(cylinder(9mm, 20mm), force=1kN, E=2MPa, nu=0.49)\n"
        "cylinder(9mm, 20mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "E186",
        "a study in which nothing is done",
        "A part that nothing loads has no stresses, and one that nothing holds flies away. A load of 0 is taken for a\n"
        "slip. Where a param may make a load 0, let its range begin above it.",
        'let s = compress(cylinder(9mm, 20mm), force=0kN, material="PA12")\nsphere(s.max_von_mises / 1MPa * 1mm)',
        'param load = 1kN in 0.1kN..5kN\nlet s = compress(cylinder(9mm, 20mm), force=load, material="PA12")\n'
        "cylinder(9mm, 20mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "E187",
        "an argument that a study cannot have",
        "What holds a part (`fix`) is a condition, true where it is held, `held(...)` or `moved(...)`; what loads it\n"
        "(`load`) is `force(...)`, `pressure(...)`, `torque(...)`, `weight(...)` or `moved(...)`: or a list of them.\n"
        "Axes are x, y and z; platens are frictionless or bonded. A beam's pads have to fit under it. Elements have a\n"
        "size above 0, no larger than the part is long, and not so small a one that there are four million unknowns:\n"
        "these take some 5 GB. Without `size` elements are found from the walls of a part, as fine as about a\n"
        "minute allows, or finer where they would be larger than the walls.",
        'let s = study(cube(9mm), fix=z < -4mm, load=[0, 0, -1kN], material="PA12")\n'
        "sphere(s.max_von_mises / 1MPa * 1mm)",
        'let s = study(cube(9mm), fix=z < -4mm, load=force(z > 4mm, [0, 0, -1kN]), material="PA12")\n'
        "cube(9mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "E188",
        "a part in several pieces",
        "What is in pieces that hang together with nothing is no part, and no study of one: what the loads do to it\n"
        "depends on how the pieces touch. Small ones, as a lattice leaves where it is cut, are left out, with a word\n"
        "where they are more than a thousandth (W266). Join the pieces, or study each by itself. Where the part is in\n"
        "one piece, its elements are too coarse to see what joins it: the message says how large they are, how thin\n"
        "the walls, and what size makes two elements through them.",
        "",
        'let s = compress(cylinder(9mm, 20mm), force=1kN, material="PA12")\n'
        "cylinder(9mm, 20mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "E189",
        "an end that no platen can press",
        "`compress`, `shear`, `twist_load` and a cantilever hold and load the flat ends of a part along an axis. A\n"
        "ball has none: what is pressed there would be a point. Cut it flat, or say where it is held and loaded.",
        "",
        'let s = compress(sphere(9mm) & slab([0, 0, 1], 12mm), force=1kN, material="PA12")\n'
        "sphere(9mm) & slab([0, 0, 1], 12mm) & gyroid(6mm) |> thicken(-clamp(s.von_mises / 9MPa, 0, 1), 0.5)",
    ),
    Code(
        "W264",
        "a study whose stresses are rough",
        "Stresses jump from element to element, and by how much tells how far they are from the true ones\n"
        "(Zienkiewicz and Zhu, A simple error estimator, 1987): in the energy of the whole part, where this is above\n"
        "10 %. Finer elements help, but at sharp inner corners and at the edges of what is bonded, where the true\n"
        "stress is infinite.\n"
        "Such elements are told by W284 now, with all else that is too coarse.",
        "",
        "",
    ),
    Code(
        "W265",
        "walls thinner than two elements",
        "Of a wall that one element spans stiffness and stresses are unsure. The message says how thick the thinnest "
        "walls\nare, and where one is; the hint what size makes two elements of it, and what that takes. Without "
        "`size` elements\nare as fine as about a minute allows.\n"
        "Such elements are told by W284 now, with all else that is too coarse.",
        "",
        "",
    ),
    Code(
        "W266",
        "pieces of a part that hang on nothing",
        "A lattice that is cut by a shape leaves pieces that nothing holds: they carry no load, and a study leaves\n"
        "them out. That is said where they are more than a thousandth of the part; where they are more than a\n"
        "twentieth it is an error (E188). `pore measure` lists pieces.",
        "",
        "",
    ),
    Code(
        "W267",
        "samples too coarse for the stress in the elements",
        "What a study gives a program is sampled on a grid that follows its elements, of 800 000 nodes at most.\n"
        "Where elements are finer than that can show, a lookup in twenty misses the stress by a tenth of the greatest\n"
        "or more; or where the material jumps, for a sample there lies between the stresses of both sides; or where\n"
        "elements are so large that stress changes much within them. The hint says which. `pore fea` writes the\n"
        "elements themselves.",
        "",
        "",
    ),
    Code(
        "W273",
        "a number of a material in another unit",
        "Young's modulus is in MPa where it has no unit, and a density in g/cm^3. One above what diamond has, or\n"
        "osmium, was probably given in Pa, or in kg/m^3. The study is solved with what was given.",
        "",
        "",
    ),
    Code(
        "W274",
        "a part that changes its shape too much for linear elasticity",
        "Displacements are found as proportional to the load, with equilibrium on the shape before it is loaded.\n"
        "That holds while displacements and turns are small against the part. Here they are more than a tenth of\n"
        "its longest side, or strains are more than a tenth in the mean. Often a unit is wrong: a bare force is\n"
        "in N, a bare modulus in MPa.",
        "",
        "",
    ),
    Code(
        "W275",
        "a stress above what the material bears",
        "A material of the table has a yield stress, if its source says one, and von Mises' stress is above it by\n"
        "more than its error: what is found there is what an elastic material would have. At sharp inner corners\n"
        "and at the rims of what is bonded the elastic stress is infinite, and grows with every finer mesh: look\n"
        "where it is.",
        "",
        "",
    ),
    Code(
        "W282",
        "elements that are not the part",
        "What elements lack of the part and hold beyond it is counted on a grid, and so are the holes through both:\n"
        "a neck that is cut, or a gap that is bridged, changes their number. Where a lattice meets its envelope at a\n"
        "sharp angle elements of one size lose such necks, and with them stiffness. The errors of numbers contain\n"
        "it; smaller elements, or `--refine`, which makes them smaller there, mend it.\n"
        "Such elements are told by W284 now, with all else that is too coarse.",
        "",
        "",
    ),
    Code(
        "W283",
        "a material that changes within elements",
        "Each element has one material, that of its middle, and where `E` or `nu` jump the surface between materials\n"
        "becomes one of whole elements. Between Voigt's mean of their moduli and Reuss's lies what an element may be\n"
        "that is made of two; the errors of numbers contain thrice that, by the energy that such elements bear.\n"
        "Stresses next to a jump are surer the smaller elements are, but for those in the corners of that surface.",
        "",
        "",
    ),
    Code(
        "W284",
        "elements too coarse for a study",
        "What is too coarse is said, in one warning with one size. Three things may be so. Elements miss the part:\n"
        "what they lack of it and hold beyond it is counted on a grid, by place, and so are the holes through\n"
        "both, for a neck that is cut, or a gap that is bridged, changes their number; where that is more than 6 %\n"
        "of a stiffness it is doubted. Lattices that meet their envelope at a sharp angle lose such necks. Walls\n"
        "are thinner than two elements: those between sides that are parallel to 7 degrees, so that the feather\n"
        "that a shape leaves where it cuts a lattice is none. Stresses jump from element to element, and by how\n"
        "much tells how far they are from the true ones (Zienkiewicz and Zhu, A simple error estimator, 1987), in\n"
        "the energy of the whole part: where this is above 10 %. At sharp inner corners and at the edges of what\n"
        "is bonded the true stress is infinite. The errors of numbers contain what elements miss and how stresses\n"
        "jump. The size that is proposed is one that takes about a minute, where that helps. `--refine` makes\n"
        "elements smaller where stresses err, and where they missed the part.",
        "",
        "",
    ),
)
