"""What a page of `pore view` waits for in Python, in ms: a slider's scene, the better one after it, both afresh."""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import Any

from porelang.compiler import compile
from porelang.preview.scene import QUICK, Scene, scene
from porelang.preview.wire import packed, texts
from porelang.program import Program
from porelang.render.cells import BUDGET

EXAMPLES = Path(__file__).parent.parent / "examples"
#: A param of each example, and values that a slider takes in turn.
SLIDERS = {"specimen": ("t", (1.5, 1.6)), "twist": ("turns", (0.25, 0.3)), "graded": ("coarse", (16.0, 17.0))}


def preview(rounds: int) -> list[dict[str, Any]]:
    """Each slider goes to and fro. Afresh is the program compiled, and the scene of a page that knows nothing."""
    return [_case(name, *slider, rounds) for name, slider in SLIDERS.items()]


def _case(name: str, param: str, values: tuple[float, float], rounds: int) -> dict[str, Any]:
    path = str(EXAMPLES / f"{name}.pore")
    program = compile(path=path)
    known = texts(scene(program.design()))
    times: dict[str, list[float]] = {"quick": [], "whole": [], "afresh": []}
    sent = 0
    for k in range(rounds):
        setting = {param: values[k % 2]}
        for what, budget in (("quick", QUICK), ("whole", BUDGET)):
            begun = time.perf_counter()
            sent = len(packed(_scene(program, setting, budget), known))
            times[what].append(1e3 * (time.perf_counter() - begun))
        begun = time.perf_counter()
        packed(_scene(compile(path=path), setting, BUDGET), [])
        times["afresh"].append(1e3 * (time.perf_counter() - begun))
    quick, whole, afresh = (statistics.median(t) for t in times.values())
    return {"case": f"{name}, {param}", "ms": quick, "whole, ms": whole, "afresh, ms": afresh, "kB": sent / 1e3,
            "ratio": afresh / quick}  # fmt: skip


def _scene(program: Program, setting: dict[str, float], budget: int) -> Scene:
    return scene(program.design(setting), budget=budget)
