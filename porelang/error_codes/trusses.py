"""E137-E138: cells of struts."""

from __future__ import annotations

from porelang.error_codes.page import Code

TRUSSES = (
    Code(
        "E137",
        "a cell of struts that is none",
        "The first argument of `truss` says where struts run in a cell that repeats: a name in quotes (the message\n"
        "lists them, or the one that is nearest), a list of bars with both ends of each in parts of the cell, or\n"
        "a file that ends in .json. The numbers of a list are known when the program is compiled, and each bar has\n"
        "a length.",
        'truss("octett", 10mm, 0.6mm) & cube(30)',
        'truss("octet", 10mm, 0.6mm) & cube(30)',
    ),
    Code(
        "E138",
        "a cell of struts that cannot be laid out",
        "A cell may be a hundred times as long as it is wide. The radii in a file of a cell are factors: the distance\n"
        "is then true for one radius `r` and one size `w`, which may be params, but no fields, and not with `phase`.\n"
        "Fillets, `joint`, take 0.28 of the least side of a cell at most: wider ones would reach over whole cells.",
        'truss("octet", [1mm, 1mm, 200mm], 0.1mm) & cube(3)',
        'truss("octet", [1mm, 1mm, 50mm], 0.1mm) & cube(3)',
    ),
)
