"""A study, solved: the part as elements, its stresses and displacements, and the numbers that it comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced
from porelang.fea import Problem, Solution, scaled, solve
from porelang.progress import activity
from porelang.tasks.study.asked import Question, solid_of, valued
from porelang.tasks.study.ends import Setting, setting
from porelang.tasks.study.numbers import numbers_of
from porelang.tasks.study.sized import Sized, sized
from porelang.tet.direct import direct
from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]
MESHING, SOLVING = "making elements", "solving for stresses"


@dataclass(frozen=True, slots=True)
class Solved:
    """A study in elements: where displacements and stresses are, of what they come, and the numbers of
    `porelang.ops.studies` by name, with their errors. `lost` is the share of the part in `pieces` that are left out."""

    asked: Question
    mesh: TetMesh
    setting: Setting
    solution: Solution
    sized: Sized
    numbers: Mapping[str, Reduced]
    lost: float
    pieces: int


def solved(asked: Question) -> Solved:
    """Elements, made as fine as the study asks for, and what is solved on them.

    Errors: those of the part (E091, E092), of its elements (E160-), of what holds and loads it (E170-, E185-E189).
    """
    part = solid_of(asked)
    with activity(MESHING):
        found = sized(part, asked.size, asked.order)
        made = direct(part, found.size)
    return on(asked, part, made, found)


def problem(asked: Question, mesh: TetMesh, acting: Setting) -> Problem:
    """What is solved on a mesh. Errors: E185 where a field of the material is no such number."""
    middles = mesh.vertices[mesh.tets].mean(axis=1)
    young = valued(asked.young, middles, "Young's modulus", 0.0, np.inf, "it is above 0, and finite, in all of a part")
    poisson = valued(asked.poisson, middles, "Poisson's ratio", -1.0, 0.5, "it lies between -1 and 0.5: 0.49 at most")
    density = valued(asked.density, middles, "the density", -1e-300, np.inf, "it is 0 or more in all of a part")
    return Problem(mesh, young, poisson, density, acting.supports, acting.loads, 1 if asked.order == 1 else 2,
                   acting.balanced)  # fmt: skip
