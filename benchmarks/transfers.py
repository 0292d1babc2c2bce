"""What a call of the GPU costs: inputs that travel at every call, data that stay, and a picture beside long work."""

from __future__ import annotations

import contextlib
import sys
import threading
from concurrent.futures import CancelledError
from typing import Any

import numpy as np
from timing import Case, in_turn

import porelang
from porelang.gpu import GpuMissing, shared_gpu
from porelang.render.picture import Wishes, render_output

COUNT = 128**3
GROUPS = (-(-COUNT // 64), 1, 1)
SUM = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
layout(std430, binding = 1) readonly buffer Grid { float grid[]; };
void main() { uint i = gl_GlobalInvocationID.x; if (i < uint(o.length())) o[i] = 2.0 * grid[i]; }
"""
# days of work: loops that are long, in many groups
LONG = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
uniform uint seed;
void main() {
    uint h = seed + gl_GlobalInvocationID.x;
    for (uint j = 0u; j < 60000u; j++) { h = h * 747796405u + 2891336453u; h ^= h >> 13; }
    o[gl_LocalInvocationIndex] = float(h);
}
"""


def transfers(rounds: int) -> list[dict[str, Any]]:
    try:
        work, person = shared_gpu(), shared_gpu(lane="person")
    except GpuMissing as missing:
        print(missing, file=sys.stderr)
        return []
    grid = np.random.default_rng(1).random(COUNT, dtype=np.float32)
    kept = ("a grid of 128^3", lambda: grid)
    part = porelang.compile("gyroid(10) |> shell(0.8) & sphere(15)")
    cases: dict[str, Case] = {
        "a call": lambda: work.compute(SUM, output=1, inputs=[grid[:1]], groups=(1, 1, 1)),
        "a call, 128^3 floats sent": lambda: work.compute(SUM, output=1, inputs=[grid], groups=(1, 1, 1)),
        "a call, 128^3 floats kept": lambda: work.compute(SUM, output=1, data=[kept], groups=(1, 1, 1)),
        "2.0 x grid, sent": lambda: work.compute(SUM, output=COUNT, inputs=[grid], groups=GROUPS),
        "2.0 x grid, kept": lambda: work.compute(SUM, output=COUNT, data=[kept], groups=GROUPS),
    }
    rows = [{"case": n, "ms": 1e3 * t.wall} for n, t in in_turn(cases, rounds, work.pid).items()]
    picture: dict[str, Case] = {"a picture": lambda: render_output(part.design(), None, Wishes((320, 240), samples=1))}
    alone = in_turn(picture, rounds, person.pid)["a picture"]
    stop = threading.Event()

    def long() -> None:
        with contextlib.suppress(CancelledError):
            groups = (65535, 65535, 1)
            work.compute(LONG, output=64, uniforms={"seed": 1}, groups=groups, timeout=600, cancel=stop.is_set)

    thread = threading.Thread(target=long)
    thread.start()
    beside = in_turn(picture, rounds, person.pid)["a picture"]
    stop.set()
    thread.join()
    return [
        *rows,
        {"case": "a picture", "ms": 1e3 * alone.wall},
        {"case": "a picture beside a long shader", "ms": 1e3 * beside.wall, "x": beside.wall / alone.wall},
    ]
