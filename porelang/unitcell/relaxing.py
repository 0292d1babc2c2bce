"""How a periodic cell of voxels relaxes under a mean strain: conjugate gradients, preconditioned by Fourier transforms.

The unknown is the periodic part of the displacement (or temperature) at the nodes. The preconditioner is a sum. One
part is the exact inverse of the same elements in a homogeneous cell, a block of 3 x 3 for each frequency in Fourier
space: a discrete Green operator, for what is smooth. The other is a share of the inverse of the diagonal, for nodes
that only cut voxels hold, which the first takes for many times as stiff as they are. Voids are voids, not soft: nothing
pushes a node without solid. Steps hardly grow in number with the resolution: 31 at 32^3 and 38 at 64^3 for a gyroid
sheet of a tenth, where Green's operator alone takes 84, and between the roots of the diagonal 202
(docs/decisions/0018). It works in float32, at half the price; the gradients themselves are in float64.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail
from porelang.progress import checkpoint
from porelang.unitcell.hexahedron import CORNERS, Element
from porelang.unitcell.loops import answered, forces, inner, product, step, turn

Floats = NDArray[np.float64]
#: The residual, relative to that of the unrelaxed cell, at which the gradients stop. The energy errs by its square.
TOLERANCE = 1e-5
#: How much of the inverse of the diagonal is added to Green's operator.
LOCAL = 0.2
#: More steps than this are a sign of something else.
MOST_STEPS = 3000


@dataclass(frozen=True, slots=True)
class Relaxed:
    """Nodal values (d, nx, ny, nz) of a case, the steps that it took and the relative residual that is left."""

    values: Floats
    steps: int
    residual: float


class Cell:
    """A periodic grid of voxels with an element and a density (nx, ny, nz) in 0..1, ready to be relaxed."""

    def __init__(self, density: Floats, element: Element):
        self.density, self.element = np.ascontiguousarray(density, np.float64), element
        self.shape = (element.parts, *density.shape)
        around = sum(np.roll(self.density, tuple(c), (0, 1, 2)) for c in CORNERS) / 8
        solid = around > 0
        stiff = 8 * float(element.matrix.diagonal().mean())
        self.local = np.where(solid, LOCAL / (stiff * np.where(solid, around, 1.0)), 0.0).ravel()
        self.green = _green(element, density.shape)

    def forces(self, values: Floats) -> Floats:
        """The nodal forces of nodal values (d, nx, ny, nz)."""
        out = np.empty_like(values)
        element = self.element
        forces(values, self.density, element.rows, element.cols, element.entries, out)
        return out

    def loads(self, case: int) -> Floats:
        """The nodal forces (d, nx, ny, nz) of a unit mean strain (or gradient) that nothing relaxes."""
        out = np.zeros(self.shape)
        source = self.element.source.reshape(8, self.element.parts, -1)
        for corner, at in enumerate(CORNERS):
            moved = np.roll(self.density, tuple(at), (0, 1, 2))
            out += source[corner, :, case][:, None, None, None] * moved
        return out

    def relaxed(self, case: int, tolerance: float = TOLERANCE) -> Relaxed:
        """The cell under a unit mean strain. Errors: E183 where it does not converge."""
        import scipy.fft

        d, n = self.shape[0], int(np.prod(self.shape[1:]))
        residual = -self.loads(case)
        flat = residual.reshape(d, n)
        values, along, out = np.zeros(self.shape), np.zeros((d, n)), np.empty(self.shape)
        # forces of neighbours cancel where nothing varies along an axis: what rounding leaves of them is no load
        rounding = 1e-12 * float(np.abs(self.element.source[:, case]).max()) * float(np.linalg.norm(self.density))
        first = inner(flat.ravel(), flat.ravel())
        if first <= rounding**2:
            return Relaxed(values, 0, 0.0)
        given = np.empty(self.shape, np.float32)
        element = self.element
        left, energy = 1.0, 1.0
        for steps in range(MOST_STEPS):
            if left <= tolerance:
                return Relaxed(values, steps, left)
            checkpoint()
            given[:] = residual
            spectrum = scipy.fft.rfftn(given, axes=(1, 2, 3))
            answered(spectrum.reshape(d, -1), self.green)
            found: Any = scipy.fft.irfftn(spectrum, s=self.shape[1:], axes=(1, 2, 3))
            found = found.reshape(d, n)
            before, energy = energy, product(found, self.local, flat)
            turn(found, self.local, flat, energy / before if steps else 0.0, along)
            forces(along.reshape(self.shape), self.density, element.rows, element.cols, element.entries, out)
            length = energy / inner(along.ravel(), out.ravel())
            left = (step(along.ravel(), out.ravel(), length, values.ravel(), flat.ravel()) / first) ** 0.5
        raise fail("E183", f"the cell did not come to rest in {MOST_STEPS} steps: a residual of {left:.1g} is left",
                   hint="take another --resolution; walls of a tenth of a voxel may be the reason")  # fmt: skip


@lru_cache(8)
def _cached(parts: int, matrix: bytes, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """The inverse of the homogeneous cell by frequency: the upper triangles (d (d + 1) / 2, frequencies)."""
    block = np.frombuffer(matrix).reshape(8, parts, 8, parts)
    spectrum = 0.0
    turns = [np.exp(-2j * np.pi * np.arange(n) / n) for n in shape[:2]]
    turns.append(np.exp(-2j * np.pi * np.arange(shape[2] // 2 + 1) / shape[2]))
    phase = [turns[0][:, None, None], turns[1][None, :, None], turns[2][None, None, :]]
    apart: dict[tuple[int, ...], Any] = {}
    for a, at in enumerate(CORNERS):
        for b, to in enumerate(CORNERS):
            key = tuple(int(v) for v in at - to)
            apart[key] = apart.get(key, 0.0) + block[a, :, b, :]
    for key, part in apart.items():
        wave = phase[0] ** key[0] * phase[1] ** key[1] * phase[2] ** key[2]
        spectrum = spectrum + (wave[..., None, None] * part).real
    whole: Any = spectrum
    whole[0, 0, 0] = np.eye(parts)  # a rigid motion meets no resistance, and none is looked for
    inverse = np.linalg.inv(whole)
    inverse[0, 0, 0] = 0.0
    rows, cols = np.triu_indices(parts)
    return np.ascontiguousarray(inverse[..., rows, cols].reshape(-1, len(rows)).T, np.float32)


def _green(element: Element, shape: tuple[int, ...]) -> NDArray[np.float32]:
    return _cached(element.parts, np.ascontiguousarray(element.matrix).tobytes(), tuple(shape))
