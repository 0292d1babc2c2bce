"""Runs one peer in an environment of its own: `python serve.py vtk_by_hand MESH.npz`.

The peer makes its mesh once, for the check of what it makes. Then every line on standard input runs it once more and is
answered with a line of JSON: wall and CPU seconds. So peers can take turns, and what else the machine does falls on all
of them alike.
"""

import importlib
import json
import sys
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np


def main() -> None:
    sys.path.insert(0, str(Path(__file__).parent))
    peer = importlib.import_module(sys.argv[1])
    answers, sys.stdout = sys.stdout, sys.stderr  # what a peer prints is not an answer
    vertices, faces = peer.arrays(peer.run())
    np.savez(sys.argv[2], vertices=vertices, faces=faces)
    versions = ", ".join(f"{name} {version(name)}" for name in peer.PACKAGES)
    print(json.dumps({"versions": versions}), file=answers, flush=True)
    for _ in sys.stdin:
        wall, cpu = time.perf_counter(), time.process_time()
        made = peer.run()
        taken = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}
        del made
        print(json.dumps(taken), file=answers, flush=True)


if __name__ == "__main__":
    main()
