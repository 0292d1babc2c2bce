"""The process that fTetWild runs in.

`python -m porelang.tet.wildchild EDGE EPSILON ENERGY PASSES THREADS IN OUT`

IN and OUT are descriptors of .npz files: the surface, and what became of it. What fTetWild says of its progress goes to
standard output as it says it. Standard input is a lifeline: when the parent ends in whatever way, it closes, and this
process ends. fTetWild holds Python's lock all the time, so that no thread could see to that: the system does.
"""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import os
import select
import signal
import sys
import tempfile
import types
from contextlib import suppress
from typing import Any

import numpy as np

PACKAGE, MODULE = "pytetwild", "pytetwild.pytetwild"
_STAGES = 2  # what fTetWild logs: passes and their energies, not every step


def main(edge: float, epsilon: float, energy: float, passes: int, threads: int, source: int, target: int) -> None:
    with os.fdopen(source, "rb") as file, np.load(file, allow_pickle=False) as given:
        vertices, faces = given["vertices"], given["faces"]
    found = _library().tetrahedralize(
        vertices,
        faces,
        edge_length_abs=edge,
        epsilon=epsilon,
        stop_energy=energy,
        num_opt_iter=passes,
        num_threads=threads,
        loglevel=_STAGES,
        quiet=False,
        vtk_ordering=True,  # otherwise volumes are negative
    )
    with os.fdopen(target, "wb") as out:
        np.savez(out, allow_pickle=False, vertices=np.asarray(found[0], np.float64), tets=np.asarray(found[1]))


def _library() -> Any:
    """The module of pytetwild that calls fTetWild. The package itself would import pyvista to register itself there,
    which is not needed and often not installed (pytetwild 0.4)."""
    spec = importlib.util.find_spec(PACKAGE)
    if spec is not None and spec.submodule_search_locations and importlib.util.find_spec("pyvista") is None:
        bare = types.ModuleType(PACKAGE)
        bare.__path__ = list(spec.submodule_search_locations)
        bare.__spec__ = spec
        sys.modules[PACKAGE] = bare
        return importlib.import_module(MODULE)
    return importlib.import_module(PACKAGE)


def hold_lifeline() -> None:
    """Have the system end this process when standard input closes (SIGIO, whose default is to end)."""
    import fcntl

    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(0, fcntl.F_SETFL, fcntl.fcntl(0, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([0], [], [], 0)[0]:  # it closed before
        os._exit(1)


def work_nowhere() -> None:
    """Work in a folder that is gone, so that fTetWild leaves its files nowhere: it says that it cannot, and goes on."""
    folder = tempfile.mkdtemp()
    os.chdir(folder)
    os.rmdir(folder)


def speak_by_lines() -> None:
    """Let what native code prints pass a pipe line by line, and not by the block."""
    name = "__stdoutp" if sys.platform == "darwin" else "stdout"
    with suppress(ValueError, AttributeError, OSError):  # another C library: then progress comes late
        library = ctypes.CDLL(None)
        library.setvbuf(ctypes.c_void_p.in_dll(library, name), None, 1, ctypes.c_size_t(0))


if __name__ == "__main__":
    hold_lifeline()
    work_nowhere()
    speak_by_lines()
    edge, epsilon, energy, passes, threads, source, target = sys.argv[1:]
    main(float(edge), float(epsilon), float(energy), int(passes), int(threads), int(source), int(target))
