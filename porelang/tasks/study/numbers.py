"""The numbers that a study comes to, with their errors: stiffness, work, the greatest stress, mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced
from porelang.fea.shares import percentile
from porelang.solid import Solid
from porelang.tet.tetmesh import TetMesh, boundary, volumes

Floats = NDArray[np.float64]
#: How much of the error of a section is that of a stiffness: in bending it goes by the third power of a thickness.
_SECTIONS = 3.0
#: The estimate of the error in energy is itself not sure: for what it says of numbers it is doubled.
_SURELY = 2.0
_FIRST_ORDER = 1.25
#: No number is sure to more than this share.
_LEAST = 1e-6
#: What the greatest stress is at a rim that is bonded, where it has no bound, says little: this share stays below.
_PERCENT = 99.0
_MIDDLES = ((0, 1), (1, 2), (2, 0))


def surface_error(mesh: TetMesh, part: Solid) -> float:
    """By which share the volume of elements differs from that of the part: the distance to the field's surface, to
    first order, over the boundary, by the middles of the edges of its triangles (exact where it is quadratic), and a
    quarter more for what that leaves out: the surface is larger, or smaller, than the boundary."""
    triangles, _ = boundary(mesh)
    a, b, c = (mesh.vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    total = np.zeros(len(triangles))
    for i, j in _MIDDLES:
        value, slope = part.slope((mesh.vertices[triangles[:, i]] + mesh.vertices[triangles[:, j]]) / 2)
        steep = np.linalg.norm(slope, axis=1)
        off = np.divide(value, steep, out=np.zeros_like(value), where=steep > 0)
        total += np.where(np.isfinite(off), off, 0.0) / 3
    return max(_LEAST, float(_FIRST_ORDER * abs((total * area).sum()) / volumes(mesh).sum()))


@dataclass(frozen=True, slots=True)
class Measured:
    """What numbers are found from: displacements (n, 3) mm and von Mises' stress (n,) MPa at vertices, the work of the
    loads (N mm), the stiffness (N/mm, or N mm a radian; None where there is no one), and by which share the stresses
    err in energy: of the whole, and of each tetrahedron (m,)."""

    displacement: Floats
    von_mises: Floats
    work: float
    stiffness: float | None
    error: float
    errors: Floats


def numbers_of(mesh: TetMesh, density: Floats, found: Measured, section: float) -> Mapping[str, Reduced]:
    """The numbers of `porelang.ops.studies` by name, with their errors; `density` (m,) in g/cm3, `section` the share
    by which the volume of elements differs from that of the part.

    Displacements and work err by the square of the error in energy, as elements of least energy do; the greatest
    stress by that of the elements where it is. What the surface of the elements misses of the part comes to that: the
    facets of a round surface also disturb the stress along it, by about as much as they do a stiffness.
    """
    share = volumes(mesh)
    volume = float(share.sum())
    length = np.linalg.norm(found.displacement, axis=1)
    mean = float((length[mesh.tets].mean(axis=1) * share).sum()) / volume
    loose = _SURELY * found.error**2 + _SECTIONS * section
    top = int(np.argmax(found.von_mises))
    there = found.errors[(mesh.tets == top).any(axis=1)]
    peak = max(found.error, float(there.max(initial=0.0)))
    mass = float((share * density).sum()) / 1000  # g/cm3 to g/mm3
    stiffness = found.stiffness or 0.0
    return {
        "stiffness": Reduced(stiffness, loose * abs(stiffness)),
        "compliance": Reduced(found.work, loose * abs(found.work)),
        "max_von_mises": _within(float(found.von_mises[top]), _SURELY * peak + _SECTIONS * section),
        "von_mises_99": _percentile(mesh, found, share, section),
        "max_displacement": _within(float(length.max()), loose),
        "mean_displacement": _within(mean, loose),
        "volume": _within(volume, section),
        "mass": _within(mass, section),
        "error": Reduced(found.error, 0.0),
    }


def _percentile(mesh: TetMesh, found: Measured, share: Floats, section: float) -> Reduced:
    """The stress that 99 % of the volume stay below, and how far it may be off: as far as it moves where every stress
    is higher, or every one lower, by twice the estimate of the error around it, and where the 1 % are more or fewer by
    the volume that the elements miss of the part, or have too much."""
    corners, count = mesh.tets.ravel(), len(mesh.vertices)
    weights = np.bincount(corners, np.repeat(share, 4), count)
    # at a vertex the mean of the elements there, in squares, as estimates in energy add up
    squares = np.bincount(corners, np.repeat(share * found.errors**2, 4), count)
    off = _SURELY * np.sqrt(squares / np.maximum(weights, 1e-300)) + _SECTIONS * section
    stress, more = found.von_mises, 100 * section
    value = percentile(stress, mesh.tets, share, _PERCENT)
    low = percentile(stress * np.maximum(1 - off, 0), mesh.tets, share, max(_PERCENT - more, 0.0))
    high = percentile(stress * (1 + off), mesh.tets, share, min(_PERCENT + more, 100.0))
    return Reduced(value, max(high - value, value - low, _LEAST * abs(value)))


def _within(value: float, share: float) -> Reduced:
    return Reduced(value, share * abs(value))
