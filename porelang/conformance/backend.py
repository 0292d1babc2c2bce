"""The backends under one signature, so that each check is written once and run on all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F32, F64, Precision
from porelang.backends.numpy import NumpyField
from porelang.formula import Formula
from porelang.gpu import Gpu
from porelang.gpu.fields import DeviceField

Points = NDArray[Any]
Ranges = Mapping[str, tuple[float, float]]
Evaluate = Callable[[Formula, Points, Ranges], NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Backend:
    """A backend to be examined: its name, the type it computes in, and how it is asked for values at points (n, 3)."""

    name: str
    precision: Precision
    evaluate: Evaluate

    @property
    def dtype(self) -> type[np.float32] | type[np.float64]:
        return np.float64 if self.precision is F64 else np.float32


def _f64(formula: Formula, points: Points, ranges: Ranges) -> NDArray[Any]:
    return NumpyField(formula, "f64", threads=1).at(points)


def _f32(formula: Formula, points: Points, ranges: Ranges) -> NDArray[Any]:
    return NumpyField(formula, "f32", threads=1).at(points)


NUMPY: tuple[Backend, ...] = (Backend("numpy f64", F64, _f64), Backend("numpy f32", F32, _f32))


def glsl(device: Gpu) -> Backend:
    """The GLSL backend on a device."""

    def evaluate(formula: Formula, points: Points, ranges: Ranges) -> NDArray[Any]:
        return DeviceField(formula, ranges, device).at(points)

    return Backend("glsl", F32, evaluate)
