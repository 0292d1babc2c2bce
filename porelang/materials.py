"""A small table of materials: elastic constants and densities with where they are from.

Moduli of what is printed depend on the machine, the direction and the powder: for a part that matters, measure, and
give `E` and `nu`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Material:
    """Young's modulus (MPa), Poisson's ratio, density (g/cm3), the stress (MPa) at which it yields, or breaks where
    it does not yield before; None where none is stated; and the source of these."""

    young: float
    poisson: float
    density: float
    strength: float | None
    source: str


MATERIALS: dict[str, Material] = {
    "PA12": Material(1650, 0.4, 0.93, 48,
                     "laser-sintered, EOS PA 2200 data sheet (tensile modulus and strength by ISO 527); "
                     "Poisson's ratio as of polyamides in general"),
    "Ti-6Al-4V": Material(113_800, 0.342, 4.43, 880,
                          "annealed, ASM Materials Properties Handbook: Titanium Alloys, 1994"),
    "316L": Material(200_000, 0.3, 8.0, 220,
                     "1.4404, EN 10088-1 (modulus, density), EN 1993-1-4 (Poisson's ratio, 0.2 % proof stress)"),
    "6061-T6": Material(70_000, 0.3, 2.7, 240, "extruded, EN 1999-1-1, 3.2.2 and 3.2.5"),
    "S235": Material(210_000, 0.3, 7.85, 235, "EN 1993-1-1, 3.2.3 and 3.2.6; density from EN 1991-1-1, table A.4"),
}  # fmt: skip
