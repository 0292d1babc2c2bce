"""Has every loop compiled once, so that no first use waits for it: `make` does this after it has installed porelang."""

import tempfile
from itertools import product
from pathlib import Path

import numpy as np

import porelang
from porelang.cli import main
from porelang.fea import Problem, Support, Weight, solve
from porelang.tet.tetmesh import TetMesh

EXAMPLES = Path(__file__).parent
#: A data operation with its derivatives, which no example takes; a phase, which is much for a small example; and a
#: mesh, outside the box of whose samples its distance is made of others.
FIELDS = (
    "grad(sample(x * y, 1mm, sphere(3), smooth=true))",
    'grad(frame("truss.json"))',
    "phase(4 + x / 40, sphere(5))",
    'mesh("grip.ply", error=3mm)',
)

#: Samples are kept in float64, where the grid of bending.npz is float32.
SAMPLES = "gyroid(4) |> thicken(sample(x * y, 1mm, sphere(5)) / 50, 0.2) & sphere(5)"

with tempfile.TemporaryDirectory() as folder:
    samples = Path(folder, "samples.pore")
    samples.write_text(SAMPLES, encoding="utf-8")
    programs = [*(EXAMPLES / f"{name}.pore" for name in ("frame", "bending", "hole")), samples]
    for path, dtype in product(programs, ("f32", "f64")):
        program, out = str(path), f"{folder}/{path.stem}.stl"
        asked = ["--resolution", "8", "--force", "--sharp", "--simplify", "1mm", "--backend", "numpy", "--dtype", dtype]
        main(["mesh", program, "-o", out, "--quiet", *asked])
        main(["check", program, "--measure", "--quiet"])
for text, dtype in product(FIELDS, ("f32", "f64")):
    porelang.compile(text, name=str(EXAMPLES / "warm.pore")).field(dtype=dtype)([[0.0, 0.0, 0.0]])

#: One tetrahedron under its own weight, for the loops of elasticity.
ONE = TetMesh(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]], np.int32), np.zeros(1, np.int8))
FOOT = Support(lambda p: p[:, 2] < 1e-9)
WEIGHT = Weight((0.0, 0.0, -9810.0))
for problem in (Problem(ONE, 1000.0, 0.3, supports=(FOOT,), loads=(WEIGHT,), order=1),
                Problem(ONE, 1000.0, 0.3, supports=(FOOT,), loads=(WEIGHT,), order=2)):  # fmt: skip
    solve(problem)
