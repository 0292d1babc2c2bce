"""Has every loop compiled once, so that no first use waits for it: `make` does this after it has installed porelang."""

from pathlib import Path

import porelang

for name in ("frame", "bending"):
    program = porelang.compile(path=Path(__file__).parent / f"{name}.pore")
    for dtype in ("f32", "f64"):
        program.mesh(resolution=8, dtype=dtype, sharp=True)
        program.field(dtype=dtype)([[0.0, 0.0, 0.0]])
smooth = porelang.compile("grad(sample(x * y, 1mm, sphere(3), smooth=true))")
for dtype in ("f32", "f64"):
    smooth.field(dtype=dtype)([[0.0, 0.0, 0.0]])
