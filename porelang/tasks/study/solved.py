"""A study, solved: the part as elements, its stresses and displacements, and the numbers that it comes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced, SampledField
from porelang.fea import Problem, Solution, scaled, solve
from porelang.formula import Formula
from porelang.ops.studies import NUMBERS
from porelang.progress import activity
from porelang.solid import Solid
from porelang.tasks.bake import region
from porelang.tasks.study.asked import Question, question, valued
from porelang.tasks.study.ends import Setting, Side, setting
from porelang.tasks.study.got import Got
from porelang.tasks.study.samples import sampled
from porelang.tasks.study.sized import Sized, sized
from porelang.tet.direct import direct
from porelang.tet.tetmesh import TetMesh, boundary, volumes

Floats = NDArray[np.float64]
