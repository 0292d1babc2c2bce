"""tpmslab's tetrahedra of a block of a gyroid sheet, half solid: `python tpmslab_block.py OUT.npz CELLS RESOLUTION`.

CELLS are its cells along x, y and z, `3,3,6`; RESOLUTION the samples to a cell. What it took is a line of JSON.
"""

import json
import sys
import time
from importlib.metadata import version

import numpy as np
from tpmslab import Config, generate

EDGE = 25.0  # of a cell, mm


def main() -> None:
    cells = tuple(int(n) for n in sys.argv[2].split(","))
    config = Config(
        family="Gyroid",
        mode="sheet",
        size=tuple(EDGE * n for n in cells),
        cells=cells,
        density_start=0.5,
        density_end=0.5,
        phase_degrees=(0.0, 0.0, 0.0),
        resolution=int(sys.argv[3]),
    )
    start = time.perf_counter()
    made = generate(config)
    seconds = time.perf_counter() - start
    np.savez(sys.argv[1], vertices=np.asarray(made["points"], float), tets=np.asarray(made["tetra"], np.int32))
    print(json.dumps({"seconds": seconds, "versions": f"tpmslab {version('tpmslab')}"}))


if __name__ == "__main__":
    main()
