"""W210 to W227: programs that compile, and that a designer almost certainly did not mean."""

from __future__ import annotations

from porelang.error_codes.page import Code

DOUBTS = (
    Code(
        "W210",
        "a part without an end",
        "A lattice fills space, and so does its wall. A mesh, layers and measures need an end: intersect the part\n"
        "with a shape, or give `--bounds`. `pore check` says so of what was made into a part; a plain field has no\n"
        "end either, and is evaluated and drawn all the same.",
        "gyroid(10) |> shell(0.5)",
        "gyroid(10) |> shell(0.5) & sphere(20)",
    ),
    Code(
        "W211",
        "an output without a surface",
        "A solid is where a number is negative that varies in space. A vector, a condition, a number that is the\n"
        "same everywhere, or one that is nowhere negative has no surface; such an output can be evaluated, and not\n"
        "meshed. `f > 0` is a condition: the solid of its points is `~f`, that of `f < 0` is `f`.",
        "gyroid(10) > 0 & cube(20)",
        "~gyroid(10) & cube(20)",
    ),
    Code(
        "W212",
        "what was made of a length, given to a raw lattice",
        "A length that meets a raw lattice is refused (E145). The product of a length and a number without a unit\n"
        "is a length most likely, as `mix(0.2mm, 1mm, ramp(z, 0, 30))` is; but that number may stand for a slope,\n"
        "and the product for a number of the lattice. Write `metric(...)` about the lattice where mm are\n"
        "meant, `bare(...)` about the length where raw units are.",
        "let t = mix(0.2mm, 1mm, ramp(z, 0, 30))\ngyroid(30) |> shell(t) & cube(60)",
        "let t = mix(0.2mm, 1mm, ramp(z, 0, 30))\nmetric(gyroid(30)) |> shell(t) & cube(60)",
    ),
    Code(
        "W213",
        "arithmetic between solids",
        "`-` and `+` work on the values of fields. The difference of two solids is `a \\ b`, their union `a | b`.\n"
        "The difference of two distances is a fine modifier; as a solid it is the region that is nearer to the one\n"
        "than to the other. Nothing is said where the two are apart, for then that may be meant.",
        "box([40, 40, 10]) & (cube(20) - sphere(9))",
        "box([40, 40, 10]) & (cube(20) \\ sphere(9))",
    ),
    Code(
        "W214",
        "radians that look like degrees",
        "A bare number as an angle is in radians: 30 is nearly five turns. Write `30deg`. A twist is an angle for\n"
        "each mm: `90deg / 50mm`. `degrees(a)` makes a number of an angle, to be shown or compared: as an angle that\n"
        "number would be radians again.",
        "rotate(box([30, 5, 5]), [0, 0, 1], 30)",
        "rotate(box([30, 5, 5]), [0, 0, 1], 30deg)",
    ),
    Code(
        "W215",
        "copies that are cut",
        "`ring` and `repeat` look the field up once, in the sector or the cell that a point lies in. What reaches\n"
        "beyond its own is cut off there, unless its neighbour fills the place. Take fewer copies or larger cells,\n"
        "or join copies that are turned or moved one by one.",
        "ring(capsule([5, 0, 0], [15, 10, 0], 1), 8)",
        "let arm = capsule([5, 0, 0], [15, 10, 0], 1)\n"
        "union([for i in range(8): rotate(arm, [0, 0, 1], i * 1turn / 8)])",
    ),
    Code(
        "W216",
        "two arguments that are exchanged",
        "Where a function takes a field and a number, the field comes first: `shell(gyroid(10), 0.5)`, or\n"
        "`gyroid(10) |> shell(0.5)`. A number counts as a field that is the same everywhere, so that the other\n"
        "order means something too, and nothing of use.",
        "shell(0.5, gyroid(10)) & cube(20)",
        "shell(gyroid(10), 0.5) & cube(20)",
    ),
    Code(
        "W217",
        "a step that takes the last shape alone",
        "`|>` binds more tightly than `&`, `|` and `\\`: in `a & b |> f` it is b that goes through f. On a line of\n"
        "its own below the whole it looks otherwise. Put what it is to take into brackets.",
        "gyroid(10) & cube(20)\n  |> translate([10, 0, 0])",
        "(gyroid(10) & cube(20))\n  |> translate([10, 0, 0])",
    ),
    Code(
        "W218",
        "a lattice with a seam",
        "In `polar(f, turn)` a full turn about the axis is `turn` mm of f. A lattice meets itself there if that is\n"
        "a whole number of its periods; else its cells are cut along a plane. The same goes for `spherical`, and for\n"
        "`along` and `wedges`, which make a whole number of cells of the length `w` fit: it has to be the period.\n"
        "A phase with an angle in it has to be a whole number of cells for a full turn, too.\n"
        "A phase that passes from one formula to another, as `sphere_map` does from square to square, is followed\n"
        "without a seam by lattices that are the same along all axes, and mirrored. In `polar`, one whose period\n"
        "varies closes where it has one period along y, a whole part of the turn: `phase([w, turn / n, w], part)`.",
        "polar(gyroid(6), turn=100) & cylinder(20, 20)",
        "polar(gyroid(6), turn=102) & cylinder(20, 20)",
    ),
    Code(
        "W219",
        "a value between two steps",
        "The step of a param says which values are meant: those that lie whole steps from the lower end of its\n"
        "range, or from 0. Another value, as a default or with `--set`, is used as it is.",
        "param w = 10.3mm in 10mm..60mm step 1mm\ngyroid(w) & sphere(20)",
        "param w = 10mm in 10mm..60mm step 1mm\ngyroid(w) & sphere(20)",
    ),
    Code(
        "W220",
        "a name that nothing reads",
        "A shape that was to be cut out and was forgotten, or what is left of an earlier version. What only an\n"
        "option names (`--within`, `--field`), or Python, begins with `_`: nothing is said about such names, nor\n"
        "about a def.",
        "let hole = cylinder(5, 40)\nsphere(10)",
        "let hole = cylinder(5, 40)\nsphere(10) \\ hole",
    ),
    Code(
        "W221",
        "a program without an output",
        "Definitions alone are a file for others to use. What is to be meshed is a last line without a name, or an\n"
        "`out`.",
        "let a = sphere(5)",
        "let a = sphere(5)\na",
    ),
    Code(
        "W222",
        "a setting with which there is no part",
        "The range of a param is a promise: whoever moves a slider expects a part at either end. `pore check\n"
        "--measure` tries both ends of each, the others as they are.",
        "",
        "param r = 5mm in 2mm..9mm\ncube(20) \\ sphere(r)",
    ),
    Code(
        "W223",
        "solids that do not meet",
        "A cut that takes nothing away, or two solids that have nothing in common: proven from the enclosures of\n"
        "both. Most often one lies elsewhere, or a unit is wrong. With params it is proven for their defaults. Where\n"
        "one of them at an end of its range brings the two together, the cut may be off on purpose: of that, and of\n"
        "ends of ranges with which a cut does nothing, only `pore check --measure` speaks. `\\` binds more tightly\n"
        "than `|`: in `core | skin \\ drains` it is the skin alone that is cut; write `(core | skin) \\ drains`.",
        "cube(20) \\ translate(cylinder(3, 40), [30, 0, 0])",
        "cube(20) \\ translate(cylinder(3, 40), [5, 0, 0])",
    ),
    Code(
        "W224",
        "a lattice that is lost",
        "The values of a lattice are raw and small: a gyroid runs from -1.5 to 1.5. A wall of more than twice that\n"
        "fills all of space, and so does an offset of more than that; the other way round nothing is left. It was\n"
        "tried with all values that the lattice has.",
        "gyroid(10) |> shell(4) & cube(40)",
        "gyroid(10) |> shell(0.4) & cube(40)",
    ),
    Code(
        "W225",
        "a period larger than the part",
        "The period of a lattice is the edge of its cell in mm, not a number of cells: of a cell that is more than\n"
        "twice the part, the part holds a single wall, or none. `pore check --measure` compares the two, and says\n"
        "nothing of a period up to twice the part: half a cell may be meant.",
        "",
        "gyroid(5) |> shell(0.3) & cube(20)",
    ),
    Code(
        "W226",
        "a share that is compared with a number of percent",
        "A porosity lies from 0 to 1, and so does a param whose range is within 0%..100%: 70 % of it is 0.7, or\n"
        "`70%`. Compared with 70 it is always less, so that a rule with it says nothing.",
        'let env = cube(20)\nout part = env \\ sphere(9)\ncheck porosity(part, env) < 70, "at most 70 % open"',
        'let env = cube(20)\nout part = env \\ sphere(9)\ncheck porosity(part, env) < 70%, "at most 70 % open"',
    ),
    Code(
        "W227",
        "an offset that leaves nothing",
        "`offset(f, -d)` takes a layer of d off a solid: of a plate of 6 mm nothing is left from 3 mm on. It is\n"
        "proven, with the params at their defaults and with each at either end of its range.",
        "cube(20) | offset(box([80, 40, 6]), -8mm)",
        "cube(20) | offset(box([80, 40, 6]), -1mm)",
    ),
    Code(
        "W230",
        "samples of cells that are too coarse",
        "Cells of a file are sampled on a grid, and lookups between its nodes are compared with what the file says\n"
        "at its points and in the middles of its cells. Where one in twenty is off by a tenth of all that the values\n"
        "range over, details are lost. With half the `voxel` a bent field is off by a quarter. Stresses that are\n"
        "infinite in theory, at a sharp notch or under a single force, are as high as their mesh is fine: no grid\n"
        "follows them.",
        "",
        "",
    ),
    Code(
        "W231",
        "data that are measured in another unit of length",
        "Lengths are in mm, and few files say in what their own are. Many programs compute in metres: a part of 50 mm\n"
        "is then 0.05 long, and lies at the origin of a lattice as a speck. It is doubted where the data hold nothing\n"
        "of the part that reads them and would hold it in another unit, or lie within a millimetre. Say what it is:\n"
        '    let stress = load("stress.vtu", "von_mises", lengths=m)',
        "",
        "",
    ),
    Code(
        "W235",
        "a direction that is 0",
        "`align(f, v)` turns the cells along v. Where v is 0 there is no direction, and the cells stay as they are:\n"
        "each value is a number, but where v sets in the pattern breaks. A gradient is 0 where its field is level, as\n"
        "a clamped one is. Of single points nothing is said: around each source or sink of v there is one.",
        "let heat = clamp(x, 0, 10)\nalign(gyroid(6), grad(heat)) & sphere(12)",
        "align(gyroid(6), [20, x, 0]) & sphere(12)",
    ),
    Code(
        "W236",
        "a lattice that is not the same after a turn",
        "`align(f, v, symmetry=2)` takes v and -v for one direction: no break is seen where v turns round, but there\n"
        "is one where directions pass from the one that is taken to its opposite, unless f is the same after half a\n"
        "turn about an axis along z. `about` says where that axis runs: through the origin for Schwarz P, through\n"
        "[0, w/4, 0] for a gyroid, through [w/8, w/8, 0] for a diamond. With `symmetry=4` it is a quarter of a turn.",
        "let way = [20, x - 60, 0]\nalign(gyroid(6), way, symmetry=2) & cylinder(12, 8)",
        "let way = [20, x - 60, 0]\nalign(gyroid(6), way, symmetry=2, about=[0, 1.5, 0]) & cylinder(12, 8)",
    ),
    Code(
        "W238",
        "a length that is added to what is a distance no longer",
        "A distance rises by 1 mm in each mm, so that `shell(0.8mm)` of it is a wall of 0.8 mm. What is stretched,\n"
        "twisted or bent round, a mixture of two, and a solid with a texture rise by more or less: the wall is\n"
        "thinner or thicker. So is one that is stretched after it was made; what is scaled as a whole is meant.\n"
        "It is measured where the length moves a surface of the part, and said of the places that are off by more\n"
        "than a tenth; of a twentieth of the surface or less, and of fillets, nothing is said. `metric` stands\n"
        "outermost: about the twist, the blend or the crossfade, not within.\n"
        "Of a wall of `metric` itself it is said where the sheets of the lattice leave no room for it: there the\n"
        "value is a guess. The manual says up to which part of its period the walls of each lattice are what they say.",
        "twist(metric(gyroid(10)), 0.1) |> shell(0.8mm) & cube(30)",
        "metric(twist(gyroid(10), 0.1)) |> shell(0.8mm) & cube(30)",
    ),
    Code(
        "W239",
        "cells that are stretched or folded",
        "`align`, `along`, `beside` and `between` give a lattice other coordinates than x, y and z. Where these\n"
        "change by more in one direction than in another, its cells are longer than wide; where they turn back, cells\n"
        "are folded over, mirrored. More than a twentieth of the part has cells of over 2:1, or such that are folded.\n"
        "`align` turns the cells about `about`: near it they keep their size, and where v turns by an angle over the\n"
        "distance from it they are stretched by about as much; where v runs nearly along `up` the frame turns\n"
        "quickly, and another `up` may mend it. Round a centre that v points away from are none: `polar`,\n"
        "`spherical`, `cylinder_map` and `sphere_map` are for that, and `phase(w, part, orientation=v)` finds cells\n"
        "along any direction that has some, and says what it got. `along` narrows cells on the inside of a bend that\n"
        "is not much wider than the part; `between` flattens them where there are many for the room.\n"
        "`polar` and `spherical` are told of where most of the part has such cells, and fewer or more to a full turn\n"
        "would be as wide as long in its middle.",
        "align(gyroid(6), grad(sphere(20))) & sphere(12)",
        "align(gyroid(6), grad(sphere(60)), about=[60, 0, 0]) & translate(sphere(12), [60, 0, 0])",
    ),
    Code(
        "W240",
        "a curve that misses its points, or bends within the part",
        "`along` rounds the corners of its points by arcs, the greatest that fit unless `bend=` says a radius. At one\n"
        "that turns back sharply the curve then lies far from the corner: it says by how much. And where the part\n"
        "reaches the centre of a bend, on its inside, all sections of the curve meet in a line, and cells break. A\n"
        "`pipe` through the same points, with another `bend=`, is not the rod that the cells follow.",
        "let q = [[0, 0, 0], [40, 0, 0], [0, 20, 0]]\nalong(gyroid(6), q) & pipe(q, 4)",
        "let q = [[0, 0, 0], [40, 0, 0], [40, 20, 0]]\nalong(gyroid(6), q) & pipe(q, 4)",
    ),
    Code(
        "W241",
        "a part that lies beyond the data that it reads",
        "Samples go on beyond their box as at its faces. That is right for a skin a little larger than what was\n"
        "computed, and wrong where the file has another origin, another unit, its axes in another order, or holds\n"
        "half of the part. It is said where a hundredth of the part, or of the solid within which a `mean` looks,\n"
        "lies farther beyond than two steps and a fiftieth of the box, along an axis along which the data change, and\n"
        "would be another with other values there: move the data with `@`, or say what holds beyond them.\n"
        'Of a mesh, `mesh("part.stl")`, it is said where the part grows farther than its `margin`: beyond that the\n'
        "distance is known to 0.7 of it only, and an offset of 9 mm may be one of 13.\n"
        '    let stress = load("stress.vtu", "von_mises") @ (p - [0, 0, 20mm])\n'
        '    let other = load("stress.vtu", "von_mises", outside=0MPa)',
        "",
        "",
    ),
    Code(
        "W287",
        "a stress that is added to a field as it is",
        "`thicken` adds f * b to a field. The values of a lattice have no unit and those of a solid are mm: a stress\n"
        "times a bare number is neither, and 12 MPa count as 12 units, where walls are one or two. And what is added\n"
        "above 0 makes them thinner, for a solid is negative: handed over as it is, a stress takes material away\n"
        "where it is high. Divide by the stress that counts as 1, and take the sign that is meant. A factor with a\n"
        "unit, `-0.1 / 1MPa`, says it too.",
        'let body = cylinder(9mm, 20mm)\nlet s = compress(body, force=1kN, material="PA12")\n'
        "body & gyroid(6mm) |> thicken(s.von_mises, 0.3)",
        'let body = cylinder(9mm, 20mm)\nlet s = compress(body, force=1kN, material="PA12")\n'
        "body & gyroid(6mm) |> thicken(1 - s.von_mises / 3.9MPa, 0.3)",
    ),
)
