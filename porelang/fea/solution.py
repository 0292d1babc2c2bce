"""What a solve gives."""

from __future__ import annotations

from dataclasses import dataclass

from porelang.fea.nodes import Floats, Nodes
from porelang.fea.problem import Problem


@dataclass(frozen=True, slots=True)
class Reaction:
    """The force (3,) N with which a support holds the part, and its moment (3,) N mm about the origin."""

    name: str
    force: Floats
    moment: Floats


@dataclass(frozen=True, slots=True)
class Solution:
    """A part in equilibrium.

    `displacement` (k, 3) mm is that of all `nodes.points`, the mesh's n vertices first. `compliance` is twice the strain
    energy, N mm: what forces times displacements are.
    """

    problem: Problem
    nodes: Nodes
    young: Floats
    poisson: Floats
    density: Floats
    displacement: Floats
    reactions: tuple[Reaction, ...]
    applied: Floats
    rest: Floats
    compliance: float
    residual: float
    iterations: int
    unknowns: int
