"""Studies: a part as elements, what holds and loads it, its stresses and displacements, and these as samples.

What takes long to import is imported by who solves one.
"""

from __future__ import annotations

from porelang.formula import Formula
from porelang.ir import Node, constant
from porelang.ops.studies import NUMBERS
from porelang.tasks.study.asked import question, solid_of
from porelang.tasks.study.sized import Sized, sized


def estimate(asked: Formula) -> Sized:
    """What a study of the arguments of its task takes, before anything is meshed. Errors: E091, E092, E186-E188."""
    asked_for = question(asked.taken)
    return sized(solid_of(asked_for), asked_for.size, asked_for.order)


def number_of(n: Node) -> str:
    """Which number a task takes from a study."""
    return list(NUMBERS)[int(constant(n.args[1]))]
