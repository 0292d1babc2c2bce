"""No step of a ray passes over a part: pictures at grazing angles against samples along each ray in NumPy.

The page draws with the same steps, and with cells that were bounded within a smaller budget while a slider moves.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.analysis.box import Box
from porelang.gpu.fields import gpu
from porelang.preview.scene import QUICK, ROOM
from porelang.render.camera import Camera, look
from porelang.render.cells import BUDGET, bound_cells
from porelang.render.cuts import whole
from porelang.render.march import Marcher, Scene

EXAMPLES = Path(__file__).parent.parent / "examples"
SIZE = (96, 72)
#: Azimuth and elevation: along walls, floors and the axes of lattices, but for a few degrees.
GRAZING = (2.0, 1.5)
#: Examples of each kind: a sheet, a metric wall, a blend, what is bent, a frame, data. `python tests/test_grazing.py`
#: looks at all of them.
SOME = ("specimen", "metric", "morph", "conformal", "frame", "twist")


def entered(
    camera: Camera, field: porelang.Field, box: Box, step: float, asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Whether rays that are asked for meet the solid, by samples in float64 a `step` (mm) apart."""
    origin, way = camera.rays(SIZE)
    origin = np.broadcast_to(origin, way.shape)[asked]
    way = way[asked]
    middle, reach = np.add(box.lo, box.hi) / 2, math.hypot(*box.size) / 2
    nearest = ((middle - origin) * way).sum(axis=-1)
    aside = np.linalg.norm(origin + nearest[:, None] * way - middle, axis=-1)
    half = np.sqrt(np.maximum(reach**2 - aside**2, 0.0))
    hit = np.zeros(len(way), bool)
    for t in np.arange(-reach, reach, step):
        left = ~hit & (np.abs(t) < half)
        if left.any():
            hit[left] = field(origin[left] + (nearest[left] + t)[:, None] * way[left]) <= 0
    found = np.zeros(asked.shape, bool)
    found[asked] = hit
    return found


def thick(camera: Camera, field: porelang.Field, box: Box, asked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the rays that are asked for are in solid for more than a quarter of a pixel."""
    found = np.zeros(asked.shape, bool)
    origin, way = camera.rays(SIZE)
    pixel = camera.pixel(SIZE, box)
    for i, j in np.argwhere(asked):
        start = np.broadcast_to(origin, way.shape)[i, j]
        t = np.arange(0, np.linalg.norm(camera.eye) + math.hypot(*box.size), pixel / 200)
        found[i, j] = (field(start + t[:, None] * way[i, j]) <= 0).sum() > 50
    return found


def rim(shape: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pixels beside one of the other kind."""
    wide = np.pad(shape, 1, mode="edge")
    near = [wide[1 + a : wide.shape[0] - 1 + a, 1 + b : wide.shape[1] - 1 + b] for a in (-1, 0, 1) for b in (-1, 0, 1)]
    return np.asarray(~np.all([n == shape for n in near], axis=0))


def differing(path: Path, budget: int) -> tuple[float, int]:
    """The share of pixels that differ, and how many of them are not at the rim."""
    program = porelang.compile(path=path)
    name = "part" if "part" in program.outputs else next(iter(program.outputs))
    design = program.design()
    box = design.bounds(name).grown(ROOM)
    camera = look(box, GRAZING, SIZE)
    part = design.of(name)
    made = Marcher(Scene(part, program.ranges, bound_cells(part, box, budget), whole(box)), camera, SIZE, gpu())
    seen = np.isfinite(made.distances())
    step = camera.pixel(SIZE, box) / 8
    known = entered(camera, design.field(name), box, step, np.ones(seen.shape, bool))
    # walls that rays meet for less than a step: those that the picture has are looked for again, more closely
    known |= entered(camera, design.field(name), box, step / 16, seen & ~known)
    # a wall that a ray meets for less than a quarter of a pixel float32 may not know: it is a rim along the ray
    known &= ~(known & ~seen & ~rim(known)) | thick(camera, design.field(name), box, known & ~seen & ~rim(known))
    differ = seen != known
    return float(differ.mean()), int((differ & ~rim(known)).sum())


@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize("name", SOME)
def test_nothing_is_passed_over(name: str) -> None:
    share, inner = differing(EXAMPLES / f"{name}.pore", QUICK if name in ("specimen", "morph") else BUDGET)
    assert share < 0.005
    assert inner == 0


if __name__ == "__main__":
    for path in sorted(EXAMPLES.glob("*.pore")):
        for word, budget in (("quick", QUICK), ("whole", BUDGET)):
            share, inner = differing(path, budget)
            print(f"{path.stem:14} {word} {100 * share:.2f} % differ, {inner} not at the rim", flush=True)
