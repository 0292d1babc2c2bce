"""The numbers that a study comes to, with their errors: stiffness, work, the greatest stress, mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import Reduced
from porelang.fea.shares import percentile
from porelang.tasks.study.missed import Missed
from porelang.tet.tetmesh import TetMesh, volumes

Floats = NDArray[np.float64]
#: How much of what elements miss of a part is that of a stiffness. In bending it goes by the third power of a
#: thickness; measured, of gyroids and IWPs cut by cylinders that lose no hole, of hollow spheres: 1 to 4.
_SECTIONS = 4.0
#: Of what hangs on each of n holes, 1/n of the load in the mean; a neck that elements lose is thinner than that.
_HANDLES = 0.5
#: Nor does it bear more than so many times its share of the section, as stresses at a rim are higher than in the mean.
_NECKS = 2.0
#: The estimate of the error in energy is itself not sure: for what it says of numbers it is doubled.
_SURELY = 2.0
#: What elements leave open that two materials share is less than what the corners of the surface between them do, which
#: is one of whole elements: measured on bars of two materials, 2.4 of it in all.
_STAIRS = 3.0
#: No number is sure to more than this share.
_LEAST = 1e-6
#: Nor is an equivalent stress sure to more than this share of the stresses whose differences it is: under a pressure
#: from all sides it is 0, and what is found of it is what the solver leaves (measured: 1e-7 to 8e-7 of the pressure).
_LEFT = 3e-6
#: What the greatest stress is at a rim that is bonded, where it has no bound, says little: this share stays below.
_PERCENT = 99.0


@dataclass(frozen=True, slots=True)
class Measured:
    """What numbers are found from: the greatest displacement and the mean one with how far these may be off (mm), von
    Mises' stress (n,) MPa at vertices, the work of the loads (N mm), the stiffness (N/mm, or N mm a radian; None where
    there is no one), and by which share the stresses err in energy: of the whole, and of each tetrahedron (m,).

    `largest` is the greatest component of a stress (MPa), of whatever sign; `unsure` is by which share
    what rounding leaves of the equilibrium, or loads of their balance, may be felt in displacements and work;
    `missed` is what elements miss of the part; `shared` by which share of its energy the material within elements
    leaves it open, `jumps` (n,) by which share of it stresses next to vertices.
    """

    most: tuple[float, float]
    mean: tuple[float, float]
    von_mises: Floats
    largest: float
    work: float
    stiffness: float | None
    error: float
    errors: Floats
    unsure: float
    missed: Missed
    shared: float
    jumps: Floats


def form_error(missed: Missed) -> float:
    """By which share numbers of stiffness may be wrong for what elements miss of a part."""
    return max(_LEAST, _SECTIONS * missed.section + _cut(missed))


def place_error(missed: Missed) -> float:
    """By which share numbers of one place may be: the sag of the face that it lies on counts in full there."""
    return max(_LEAST, _SECTIONS * missed.share + _cut(missed))


def _cut(missed: Missed) -> float:
    """By which share numbers may be wrong for necks that elements cut, or bridge."""
    return min(_HANDLES * missed.unconnected, _NECKS * missed.necks)


def shared_error(shared: float) -> float:
    """By which share they may be wrong for elements that two materials share, of a share of the energy left open."""
    return _STAIRS * shared


def numbers_of(mesh: TetMesh, density: Floats, found: Measured) -> Mapping[str, Reduced]:
    """The numbers of `porelang.ops.studies` by name, with their errors; `density` (m,) in g/cm3.

    Displacements and work err by the square of the error in energy, as elements of least energy do; the greatest
    stress by that of the elements where it is. What elements miss of the part comes to that. The facets of a round
    surface lie without and within it by turns: for a stiffness that cancels, for what is read on them it does not.
    """
    share = volumes(mesh)
    volume = float(share.sum())
    form, off = form_error(found.missed), max(_LEAST, found.missed.off)
    stiff = _SURELY * found.error**2 + shared_error(found.shared) + form + found.unsure
    place = place_error(found.missed)
    loose = stiff - form + place
    top = int(np.argmax(found.von_mises))
    there = found.errors[(mesh.tets == top).any(axis=1)]
    peak = max(found.error, float(there.max(initial=0.0)))
    mass = float((share * density).sum()) / 1000  # g/cm3 to g/mm3
    stiffness = found.stiffness or 0.0
    peak_share = _SURELY * peak + place + float(found.jumps[top])
    rounding = _LEFT * found.largest
    (most, stands_out), (mean, quadrature) = found.most, found.mean
    return {
        "stiffness": Reduced(stiffness, stiff * abs(stiffness)),
        "compliance": Reduced(found.work, stiff * abs(found.work)),
        "max_von_mises": Reduced(float(found.von_mises[top]), peak_share * float(found.von_mises[top]) + rounding),
        "von_mises_99": _percentile(mesh, found, share),
        "max_displacement": Reduced(most, loose * most + stands_out),
        "mean_displacement": Reduced(mean, loose * mean + quadrature),
        "volume": _within(volume, off),
        "mass": _within(mass, off),
        "error": Reduced(found.error, 0.0),
    }


def _percentile(mesh: TetMesh, found: Measured, share: Floats) -> Reduced:
    """The stress that 99 % of the volume stay below, and how far it may be off: as far as it moves where every stress
    is higher, or every one lower, by twice the estimate of the error around it, and where the 1 % are more or fewer by
    the volume that the elements miss of the part, or have too much."""
    corners, count = mesh.tets.ravel(), len(mesh.vertices)
    weights = np.bincount(corners, np.repeat(share, 4), count)
    # at a vertex the mean of the elements there, in squares, as estimates in energy add up
    squares = np.bincount(corners, np.repeat(share * found.errors**2, 4), count)
    off = _SURELY * np.sqrt(squares / np.maximum(weights, 1e-300)) + form_error(found.missed) + found.jumps
    stress, more = found.von_mises, 100 * found.missed.section
    value = percentile(stress, mesh.tets, share, _PERCENT)
    low = percentile(stress * np.maximum(1 - off, 0), mesh.tets, share, max(_PERCENT - more, 0.0))
    high = percentile(stress * (1 + off), mesh.tets, share, min(_PERCENT + more, 100.0))
    return Reduced(value, max(high - value, value - low) + _LEFT * found.largest)


def _within(value: float, share: float) -> Reduced:
    return Reduced(value, share * abs(value))
