"""E160-E162, W250-W254: tetrahedra straight from a field."""

from __future__ import annotations

from porelang.error_codes.page import Code

DIRECT = (
    Code(
        "E160",
        "a size of tetrahedra that is none",
        "The size of tetrahedra is the edge of the cubes that they are made from, twelve to a cube: a length\n"
        "above 0 mm, or a field that is above 0 all over the part. A size at the surface is no larger than that\n"
        "within: the surface is where stresses are largest and walls are to be met.",
        "",
        "gyroid(10) |> shell(1.2) & cube(20)  # pore tet --size 0.6mm",
    ),
    Code(
        "E161",
        "too many tetrahedra",
        "Half the size makes eight times the tetrahedra, and a solver takes some kB for each. Before it begins,\n"
        "the mesher estimates from the volume of the part, and from its surface where that has cubes of its own,\n"
        "how many there will be. A part of the specimen often tells as much: `--bounds` cuts it, flat, along its\n"
        "box. Larger cubes within (`--size 3mm --surface-size 1mm`) cost little where walls are thick.",
        "",
        "gyroid(10) |> shell(1.2) & cube(20)  # pore tet --size 0.6mm",
    ),
    Code(
        "E162",
        "no mesh of tetrahedra at this size",
        "Tetrahedra are made where corners or centres of the cubes lie in the part. Where its walls are thinner\n"
        "than the cubes they fall between them: nothing is left, or crumbs that hang together with nothing, and a\n"
        "solver would compute another part than yours. Two cubes across a wall are the least that should be used.",
        "",
        "gyroid(10) |> shell(1.2) & cube(20)  # pore tet --size 0.6mm",
    ),
    Code(
        "W250",
        "a wall of fewer than two elements",
        "Walls are measured across, along the normals of the surface at places all over the part, where their\n"
        "sides are parallel to 7 degrees: the feather that an envelope leaves where it cuts a lattice is none. In\n"
        "a wall that is thinner than two cubes most tetrahedra have all of their corners on one side or the other,\n"
        "it is too stiff in bending, and it may have holes. Take smaller cubes; the message says which.",
        "",
        "gyroid(10) |> shell(1.2) & cube(20)  # pore tet --size 0.6mm",
    ),
    Code(
        "W251",
        "islands: pieces of a mesh that hang together with nothing",
        "Where a lattice is cut by its envelope, pieces of its walls are left that are held by nothing; and where\n"
        "walls are thin, the cubes miss what joins them. A solver finds such a piece free to move, and ends. So\n"
        "only the largest piece is kept, and the share of the volume that was dropped is told. `keep_islands`\n"
        "keeps them all, for a part that is meant to be several bodies. Pieces hang together by faces: an edge or\n"
        "a corner holds nothing.",
        "",
        "gyroid(10) |> shell(1.2) & cube(20)  # pore tet --size 0.6mm",
    ),
    Code(
        "W252",
        "a mesh touches itself along an edge",
        "Two pieces of the surface meet in an edge of no width, as two bodies that touch in a line: four triangles\n"
        "share it. What is above hangs together with what is below by a hinge there, or is held apart by nothing,\n"
        "and a solver computes one of both. Cubes were halved there and did not part them: take a smaller size,\n"
        "or look whether the part itself touches itself.",
        "",
        "box([4, 4, 4]) | box([4, 4, 4]) @ (p - [4, 4, 0])  # pore tet --size 1mm",
    ),
    Code(
        "W253",
        "the mesh of tetrahedra lacks something of the part",
        "All over the cubes at its surface a mesh is compared with the field. Where they differ by more than flat\n"
        "triangles do from a bend, cubes are halved, twice at most. What is still missing then, or too much, is told\n"
        "where it is more than 0.3 % of the volume, with the worst place: walls that are thinner than the cubes, or\n"
        "so many of them that the size is too large for the whole part. Take a smaller size.",
        "",
        "gyroid(10) & cylinder(10, 20)  # pore tet --size 3mm",
    ),
    Code(
        "W254",
        "a gap that tetrahedra have closed",
        "A slit that is narrower than a cube may lie between the corners of cubes, where the mesher never looks into\n"
        "it. What is on both sides of it is then joined, and a part that is sawn almost through is as stiff as one\n"
        "that is whole. It is told where edges of tetrahedra span void between surfaces that face each other, with\n"
        "how wide it is and over how much: the one that is closed the most. Cubes of twice the width leave a gap\n"
        "open; what touches in a point or along a line is joined by a neck at any size.",
        "",
        "box([40, 20, 10]) \\ translate(box([3, 21, 8]), [0.5, 0, 2])  # pore tet --size 1mm",
    ),
)
