"""E145-E146: fields whose values are no distances, and what is asked of them in mm."""

from __future__ import annotations

from porelang.error_codes.page import Code

WALLS = (
    Code(
        "E145",
        "a length given to a raw lattice",
        "The values of a lattice are raw: a gyroid runs from -1.5 to 1.5 whatever its period. So `shell(0.4mm)`\n"
        "would make a wall of 0.4 of those units, which is 0.4 mm times something that depends on the lattice, its\n"
        "period and the place. `metric(gyroid(30))` is the distance to its surface in mm: walls, offsets and fillets\n"
        "are then what they say. It costs about four times the lattice, and is true as far as the bend of the sheets\n"
        "allows: up to a fifth of the period for most, as the manual says. A number without a unit stays a number of\n"
        "the lattice; for a porosity there are `to_porosity` and `shell_to_porosity`.",
        "gyroid(30) |> shell(0.4mm) & cube(60)",
        "metric(gyroid(30)) |> shell(0.4mm) & cube(60)",
    ),
)
