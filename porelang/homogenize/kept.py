"""Grids that were solved are kept by content, as tasks are: a sweep that was interrupted goes on where it was."""

from __future__ import annotations

import hashlib
from functools import cache

import numpy as np
from numpy.typing import NDArray

from porelang import __version__, resources, store
from porelang.data import Numbers
from porelang.homogenize.found import Level
from porelang.unitcell.effective import Effective, conducted, homogenized

Floats = NDArray[np.float64]


def level(density: Floats, sides: Floats, nu: float, threads: int | None = None) -> Level:
    """The effective properties of voxels: found, or what was found of the same ones before."""
    key = _key(density, sides, nu)
    known = store.numbers(key)
    x, y, z = density.shape
    if known is not None and len(known.values) == 36 + 4 + 9 + 4:
        return Level((x, y, z), _read(known.values[:40], 6), _read(known.values[40:], 3))
    found = Level(
        (x, y, z), homogenized(density, sides, nu, threads=threads), conducted(density, sides, threads=threads)
    )
    values = np.concatenate([_written(found.stiffness), _written(found.conductivity)])
    store.put(key, Numbers(values), label=f"a cell of {x} x {y} x {z} voxels, density {found.stiffness.density:.4g}")
    return found


def _written(found: Effective) -> Floats:
    rest = [found.density, found.solved, found.steps, found.residual]
    return np.concatenate([found.matrix.ravel(), np.array(rest, np.float64)])


def _read(values: Floats, n: int) -> Effective:
    density, solved, steps, residual = map(float, values[n * n : n * n + 4])
    return Effective(values[: n * n].reshape(n, n).copy(), density, int(solved), int(steps), residual)


def _key(density: Floats, sides: Floats, nu: float) -> str:
    made = hashlib.blake2b(f"cell {_code()} {density.shape}".encode(), digest_size=32)
    made.update(np.array([*(sides / sides.max()), nu], np.float64).tobytes())
    made.update(np.ascontiguousarray(density, "<f8").data)
    return made.hexdigest()


@cache
def _code() -> str:
    """A digest of the code that solves a grid, and of what it computes with."""
    made = hashlib.sha256(f"{__version__}, NumPy {np.__version__}".encode())
    for path in [*sorted((resources.PACKAGE / "unitcell").glob("*.py")), resources.PACKAGE / "homogenize" / "kept.py"]:
        made.update(path.read_bytes())
    return made.hexdigest()
