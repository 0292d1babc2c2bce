"""A small table of materials, each value with its source: numbers to begin with, not to sign with.

What is printed depends on the machine, the direction and what was done afterwards: where a source says how much, it is
here. Poisson's ratios of plastics are seldom on data sheets; those here are said to be assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

from porelang.diagnostics import fail, suggest


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


MATERIALS: dict[str, Material] = {
    "pla": Material(
        3600, 0.36, 1.24, 60, "NatureWorks Ingeo 4043D, technical data sheet (ASTM D882, D792)",
        "of film; prints have 2300 to 3500 MPa by direction and infill; Poisson's ratio is assumed",
    ),
    "pa12": Material(
        1650, 0.4, 0.93, None, "EOS PA 2200 Balance 1.0, material data sheet (ISO 527, laser sintered)",
        "dry, along x; parts that take up water have some 20 % less; Poisson's ratio is assumed",
    ),
    "abs": Material(
        2000, 0.35, 1.04, None, "Wohlers Report 2011, appendix E (ASTM D638, moulded)",
        "prints have 10 to 30 % less across layers; Poisson's ratio and density are assumed",
    ),
    "ti6al4v": Material(
        110000, 0.34, 4.41, 825, "EOS Titanium Ti64, material data sheet; yield: the minimum of ASTM F2924",
        "modulus +- 10 GPa; yield of heat-treated parts; Poisson's ratio of wrought alloy",
    ),
    "316l": Material(
        200000, 0.3, 8.0, 205, "EN 10088-1, 1.4404; yield: the minimum of ASTM F3184",
        "printed parts have 150 to 200 GPa by direction, and yield at twice that minimum as built",
    ),
    "alsi10mg": Material(
        70000, 0.33, 2.67, 240, "EOS Aluminium AlSi10Mg (9011-0024), material data sheet: z, as built",
        "modulus +- 10 GPa, 75 GPa in the plane; 60 to 70 GPa after stress relief; Poisson's ratio is assumed",
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


def material(name: str) -> Material:
    """A material of the table by its name, in any case. Errors: E172 for one that is not in it."""
    found = MATERIALS.get(name.lower()) if isinstance(name, str) else None
    if found is None:
        near = suggest(name, MATERIALS)
        hint = f"did you mean `{near}`?" if near else f"there are {', '.join(MATERIALS)}; or give the moduli themselves"
        raise fail("E172", f"there is no material {name!r} in the table", hint=hint)
    return found
