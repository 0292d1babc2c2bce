"""A small table of materials, each value with its source: numbers to begin with, not to sign with.

What is printed depends on the machine, the direction and what was done afterwards: where a source says how much, it is
here. Poisson's ratios of plastics are seldom on data sheets; those here are said to be assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

from porelang.diagnostics import suggest


@dataclass(frozen=True, slots=True)
class Material:
    """An isotropic material: `young` MPa, `poisson`, `density` g/cm3, and `yields` MPa where it yields in tension, if a
    source says so; `source` names where that is from, `doubt` what of it is uncertain.

    >>> MATERIALS["steel"].young
    210000.0
    """

    young: float
    poisson: float
    density: float
    yields: float | None
    source: str
    doubt: str


@dataclass(frozen=True, slots=True)
class Limit:
    """More than any material has, of a number called `what` in its `unit`; `most` says what has the most; who meant
    another unit gave so many times as much, `times`, and writes it as in `example`."""

    what: str
    value: float
    unit: str
    why: str
    times: float
    example: str

    def said(self, value: float) -> str:
        """What is doubtful about a value."""
        return f"{self.what} of {value:.4g} {self.unit} is more than any material has"

    def hint(self, value: float) -> str:
        """What it was meant to be, perhaps."""
        return f"a bare number is in {self.unit}: {self.example.format(value / self.times)}"


#: Diamond has 1053 to 1208 GPa by direction (by the constants of H. McSkimin and P. Andreatch, J. Applied Physics 43,
#: 1972), osmium, the densest element, 22.59 g/cm3 (J. Arblaster, Platinum Metals Review 57, 2013).
STIFFEST = Limit(
    "Young's modulus", 1.5e6, "MPa", "diamond has 1.2e+06 MPa", 1e9, "if it was given in Pa, `E={:.4g}GPa`"
)
DENSEST = Limit("a density", 25.0, "g/cm3", "osmium has 22.6", 1e3, "if it was given in kg/m3, `density={:.4g}`")

MATERIALS: dict[str, Material] = {
    "PLA": Material(
        3600, 0.36, 1.24, 60, "NatureWorks Ingeo 4043D, technical data sheet (ASTM D882, D792)",
        "of film; prints have less, by direction and infill; Poisson's ratio is assumed",
    ),
    "PA12": Material(
        1650, 0.4, 0.93, None, "EOS PA 2200 Balance 1.0, material data sheet (ISO 527, laser sintered)",
        "dry, along x; parts that take up water have less; Poisson's ratio is assumed",
    ),
    "ABS": Material(
        2000, 0.35, 1.04, None, "Wohlers Report 2011, appendix E (ASTM D638, moulded)",
        "prints have less across layers; Poisson's ratio and density are assumed",
    ),
    "Ti-6Al-4V": Material(
        110000, 0.34, 4.41, 825, "EOS Titanium Ti64, material data sheet; yield: the minimum of ASTM F2924",
        "modulus +- 10 GPa; yield of heat-treated parts; Poisson's ratio of wrought alloy",
    ),
    "316L": Material(
        200000, 0.3, 8.0, 205, "EN 10088-1, 1.4404; yield: the minimum of ASTM F3184",
        "printed parts have less by direction, and yield above that minimum as built",
    ),
    "AlSi10Mg": Material(
        70000, 0.33, 2.67, 240, "EOS Aluminium AlSi10Mg (9011-0024), material data sheet: z, as built",
        "modulus +- 10 GPa, 75 GPa in the plane; 60 to 70 GPa after stress relief; Poisson's ratio is assumed",
    ),
    "6061-T6": Material(
        70000, 0.3, 2.7, 240, "EN 1999-1-1, 3.2.2 and 3.2.5: extruded", "yield depends on thickness and heat treatment",
    ),
    "steel": Material(
        210000, 0.3, 7.85, 235, "EN 1993-1-1, 3.2.6; density EN 1991-1-1, table A.4; yield: S235",
        "yield depends on grade and thickness",
    ),
    "concrete": Material(
        33000, 0.2, 2.4, None, "EN 1992-1-1, table 3.1, C30/37, quartzite aggregates; density EN 1991-1-1, table A.1",
        "secant modulus in compression, uncracked; 10 to 30 % less with limestone or sandstone, 20 % more with basalt",
    ),
    "bone": Material(
        17000, 0.3, 1.9, None, "D. Reilly and A. Burstein, J. Biomechanics 8 (1975): human femur, along the bone",
        "11500 MPa across it, which is no isotropic material; Poisson's ratio and density are assumed",
    ),
}  # fmt: skip


def named(name: str) -> Material | None:
    """A material of the table by its name, whatever its case, with hyphens and spaces or without."""
    return _BY_WORD.get(_word(name))


def nearest(name: str) -> str | None:
    """The name in the table that is likely to be meant by another."""
    near = suggest(_word(name), _NAMES)
    return None if near is None else _NAMES[near]


def _word(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


_NAMES = {_word(name): name for name in MATERIALS}
_BY_WORD = {_word(name): found for name, found in MATERIALS.items()}
