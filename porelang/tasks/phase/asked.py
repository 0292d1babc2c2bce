"""A phase for a period and a part that are formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.tasks.bake import region
from porelang.tasks.phase.find import find
from porelang.tasks.phase.got import Field


def phase_of(period: Formula, within: Formula, free: bool) -> SampledField:
    """The phase, in turns, for a field of periods in mm, over the box of a solid; its facts are those of `Got`.

    `free` lets cells turn. Errors: E091 and E092 of the solid, and those of `find`.
    """
    box = region(within, "this phase")
    return find(_values(period), _values(within), box.lo, box.hi, free)[0]


def _values(field: Formula) -> Field:
    evaluated = NumpyField(field, "f64")

    def at(x: NDArray[Any], y: NDArray[Any], z: NDArray[Any]) -> NDArray[np.float64]:
        points = np.stack(np.broadcast_arrays(x, y, z), -1)
        return np.asarray(evaluated.at(points.reshape(-1, 3)), np.float64).reshape(points.shape[:-1])

    return at
