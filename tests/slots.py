"""A shader that calls one function of a data slot at a list of points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from test_glsl_lib import library

from porelang.data import Data
from porelang.gpu import Gpu
from porelang.ops.words import words

HEAD = "#version 430\n"
ES = "#version 310 es\nprecision highp float;\nprecision highp int;\n#define precise\n"


def at_points(
    gpu: Gpu, data: Data, function: str, statements: str, results: int, points: NDArray[Any], head: str = HEAD
) -> NDArray[np.float32]:
    """What `statements` write into o[at], o[at + 1] ... at points (3, n) called x, y, z; an array (results, n).

    `function` is the library function that they call, in slot 0.
    """
    text = library(f"{function}(").replace("@", "0")
    shader = f"""{head}layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Out {{ float o[]; }};
layout(std430, binding = 1) readonly buffer Points {{ float points[]; }};
layout(std430, binding = 2) readonly buffer Words {{ uint words[]; }};
uniform int count;
uint pore_word0(int i) {{ return words[i]; }}
{text}
void main() {{
    int i = int(gl_GlobalInvocationID.x);
    if (i >= count) return;
    float x = points[3 * i];
    float y = points[3 * i + 1];
    float z = points[3 * i + 2];
    int at = {results} * i;
    {statements}
}}
"""
    count = points.shape[1]
    flat = np.ascontiguousarray(points.T, np.float32).reshape(-1)
    groups = (-(-count // 64), 1, 1)
    got = gpu.compute(
        shader, output=results * count, inputs=[flat, words(data)], uniforms={"count": count}, groups=groups
    )
    return got.reshape(count, results).T
