"""THE TABLE OF STUDIES: what holds and loads a part, and what a study gives, as the graph has them.

A study is a task (`porelang.ops.tasks`) whose arguments are the part, its material and its options (`HEAD`), and then
for each thing that holds or loads it a number that says which row of `ACTIONS` it is, a condition, and so many numbers.
Its result is a grid of `COMPONENTS`, and with it as facts the `NUMBERS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from porelang.ir import Node
from porelang.units import ANGLE, FORCE, LENGTH, RATIO, STRESS, Dimension

#: The first arguments: Young's modulus (MPa), Poisson's ratio and density (g/cm3, 0: not known) are fields; `size` is
#: the edge of elements (mm, 0: found from the part), `order` that of their polynomials; `yields` is the stress (MPa) at
#: which a material that is named yields (0: not known), `balanced` 1 where loads balance each other.
HEAD = ("part", "E", "nu", "density", "size", "order", "yields", "balanced")


@dataclass(frozen=True, slots=True)
class Action:
    """What holds or loads a part: its name in the language, and what its numbers are.

    `whole`: it is a test between two ends of the part, which holds it as well.
    """

    name: str
    numbers: tuple[str, ...]
    does: Literal["holds", "loads", "whole"]


ACTIONS = (
    Action("held", ("along_x", "along_y", "along_z"), "holds"),
    Action("moved", ("along_x", "along_y", "along_z", "dx", "dy", "dz"), "holds"),
    Action("force", ("fx", "fy", "fz"), "loads"),
    Action("pressure", ("p",), "loads"),
    Action("torque", ("mx", "my", "mz"), "loads"),
    Action("weight", ("gx", "gy", "gz"), "loads"),
    Action("compress", ("force", "axis", "bonded"), "whole"),
    Action("shear", ("force", "axis", "toward", "sign"), "whole"),
    Action("bend", ("force", "axis", "toward", "sign", "points", "span", "pads"), "whole"),
    Action("twist_load", ("torque", "axis"), "whole"),
)
CODE = {action.name: float(i) for i, action in enumerate(ACTIONS)}

#: The components of a symmetric tensor in VTK's order, those of the strain by their names beside those of the stress.
TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")
STRAIN = tuple(f"strain_{c}" for c in TENSOR)
#: What each place has: von Mises' stress, energy density (N mm/mm3), displacement (mm), stress (MPa), strain.
COMPONENTS = ("von_mises", "energy", "ux", "uy", "uz", *TENSOR, *STRAIN)
#: One component more: how far outside of the elements a place lies, in mm, below 0 inside.
DEPTH = len(COMPONENTS)

#: What a study gives that is one number, each with its error, in what it is measured. Masses have no unit here: grams.
NUMBERS: dict[str, Dimension | None] = {
    "stiffness": FORCE / LENGTH,
    "compliance": FORCE * LENGTH,
    "max_von_mises": STRESS,
    "von_mises_99": STRESS,
    "max_displacement": LENGTH,
    "mean_displacement": LENGTH,
    "volume": LENGTH * LENGTH * LENGTH,
    "mass": None,
    "error": RATIO,
}
#: The stiffness of what turns: torque over angle.
TURNING = FORCE * LENGTH / ANGLE


def number_of(n: Node) -> str:
    """The name of the number that a node (`of_study`) reads from a study; "" for other nodes."""
    if n.op != "of_study":
        return ""
    code = n.args[1].value
    assert isinstance(code, float)
    return list(NUMBERS)[int(code)]
