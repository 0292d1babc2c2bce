"""The backends under one signature, so that each check is written once and run on all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.enclose import F32, F64, Precision
from porelang.backends.numpy import NumpyField
from porelang.gpu import Gpu
from porelang.gpu.fields import DeviceField
from porelang.ir import Node

Points = NDArray[Any]
Params = Mapping[str, float]
Ranges = Mapping[str, tuple[float, float]]
Evaluate = Callable[[Node, Points, Params, Ranges], NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Backend:
    """A backend to be examined: its name, the type it computes in, and how it is asked for values at points (n, 3)."""

    name: str
    precision: Precision
    evaluate: Evaluate

    @property
    def dtype(self) -> type[np.float32] | type[np.float64]:
        return np.float64 if self.precision is F64 else np.float32


def _f64(root: Node, points: Points, params: Params, ranges: Ranges) -> NDArray[Any]:
    return NumpyField(root, params, "f64", threads=1).at(points)


def _f32(root: Node, points: Points, params: Params, ranges: Ranges) -> NDArray[Any]:
    return NumpyField(root, params, "f32", threads=1).at(points)


NUMPY: tuple[Backend, ...] = (Backend("numpy f64", F64, _f64), Backend("numpy f32", F32, _f32))


def glsl(device: Gpu) -> Backend:
    """The GLSL backend on a device."""

    def evaluate(root: Node, points: Points, params: Params, ranges: Ranges) -> NDArray[Any]:
        return DeviceField(root, params, ranges, device).at(points)

    return Backend("glsl", F32, evaluate)
