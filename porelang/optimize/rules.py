"""From what each voxel bears to how dense it is to be.

A rule looks at one solution and proposes a density; limits and the mean are kept by `spread.restored`. All of them are
blurred by one cell, for a lattice has no density below that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from porelang.optimize.record import Under
from porelang.optimize.spread import restored
from porelang.tasks.told import Doubt

Array = NDArray[np.float64]
#: Averages values (m,) over a cell.
Average = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Answer:
    """What an analysis says of a density (m,): see `loop.Analysis`.

    `energy` (m,) MPa strain energy density of the homogenised material, `saved` (m,) MPa by how much the compliance
    falls with a step of the density there, per volume; `von_mises` (m,) MPa, macroscopic. `noise` is the relative error
    of the energies, `state` what a next solution begins from, if anything.

    Of the real lattice there is more: the relative `error` of the compliance, the share `apart` by which that may
    differ from what another mesh of a part like it says, the `peak` of von Mises' stress in its solid (MPa), its
    `porosity` as it was measured, the `samples` that made it, arrays for the record, and the `doubts` of its study.
    `under` says what loads it: of `displacements` the compliance is the work that they take.
    """

    compliance: float
    largest: float
    energy: Array
    saved: Array
    von_mises: Array
    noise: float
    state: Array | None = None
    error: float | None = None
    peak: float | None = None
    porosity: float | None = None
    samples: Mapping[str, Array] = field(default_factory=dict)
    under: Under = "forces"
    doubts: tuple[Doubt, ...] = ()
    apart: float | None = None


@dataclass(frozen=True, slots=True)
class Frame:
    """What a rule has to keep: the mean density, its limits, the volumes (m,) of voxels, the average over a cell."""

    mean: float
    low: float
    high: float
    weights: Array
    average: Average


class Rule(Protocol):
    """A rule: its name for the record, what it looks at (m,), and the density (m,) that it makes of it."""

    @property
    def name(self) -> str: ...
    def driver(self, density: Array, answer: Answer, frame: Frame) -> Array: ...
    def next(self, density: Array, answer: Answer, frame: Frame) -> Array: ...


@dataclass(frozen=True, slots=True)
class Energy:
    """density *= (u / mean of u)^exponent, with u the strain energy per solid, energy over density.

    Where u is the same everywhere the density is stationary: for a stiffness that goes with density^n the optimum has
    that. The exponent is the damping: 1 oscillates.
    """

    exponent: float = 0.5

    @property
    def name(self) -> str:
        return f"energy, exponent {self.exponent:g}"

    def driver(self, density: Array, answer: Answer, frame: Frame) -> Array:
        return frame.average(answer.energy / density)

    def next(self, density: Array, answer: Answer, frame: Frame) -> Array:
        grown = density * _relative(self.driver(density, answer, frame), frame) ** self.exponent
        return _scaled(grown, frame.low, frame.high, frame)


@dataclass(frozen=True, slots=True)
class VonMises:
    """density = mean + factor (s / mean of s - 1), with s von Mises' stress: the designer's one step.

    The factor is in densities. A negative one is the reversed sign, and 2 is too strong.
    """

    factor: float = 0.5

    @property
    def name(self) -> str:
        return f"von Mises, factor {self.factor:g}"

    def driver(self, density: Array, answer: Answer, frame: Frame) -> Array:
        return frame.average(answer.von_mises)

    def next(self, density: Array, answer: Answer, frame: Frame) -> Array:
        wanted = frame.mean + self.factor * (_relative(self.driver(density, answer, frame), frame) - 1)
        lows, highs = np.full_like(density, frame.low), np.full_like(density, frame.high)
        return restored(lambda s: wanted + s, lows, highs, frame.weights, frame.mean)


@dataclass(frozen=True, slots=True)
class Optimum:
    """Optimality criteria: density *= (saved / lambda)^exponent, at most `move` in a step (Bendsoe, 1995).

    With the lattice's own law in place of SIMP's, and its sensitivities averaged over a cell (Sigmund, 1997).
    """

    exponent: float = 0.5
    move: float = 0.2

    @property
    def name(self) -> str:
        return f"optimality criteria, exponent {self.exponent:g}, move {self.move:g}"

    def driver(self, density: Array, answer: Answer, frame: Frame) -> Array:
        return frame.average(density * answer.saved) / density

    def next(self, density: Array, answer: Answer, frame: Frame) -> Array:
        grown = density * _relative(self.driver(density, answer, frame), frame) ** self.exponent
        low, high = np.maximum(frame.low, density - self.move), np.minimum(frame.high, density + self.move)
        return _scaled(grown, low, high, frame)


@dataclass(frozen=True, eq=False)
class Given:
    """A density (m,) that was found elsewhere takes the place of the uniform one; from there on goes the rule `after`,
    or none."""

    density: Array
    found: str
    after: Rule | None = None

    @property
    def name(self) -> str:
        return self.found if self.after is None else f"{self.found}, then {self.after.name}"

    def driver(self, density: Array, answer: Answer, frame: Frame) -> Array:
        return (self.after or Energy()).driver(density, answer, frame)

    def next(self, density: Array, answer: Answer, frame: Frame) -> Array:
        if np.ptp(density) < 1e-12 or self.after is None:
            return self.density
        return self.after.next(density, answer, frame)


def spread_of(values: Array, weights: Array) -> float:
    """The coefficient of variation of values (m,): their standard deviation over their mean."""
    mean = float(np.average(values, weights=weights))
    return float(np.sqrt(np.average((values - mean) ** 2, weights=weights))) / abs(mean)


def _relative(driver: Array, frame: Frame) -> Array:
    values: Array = driver / np.average(driver, weights=frame.weights)
    return values


def _scaled(grown: Array, low: Array | float, high: Array | float, frame: Frame) -> Array:
    lows, highs = np.broadcast_to(low, grown.shape), np.broadcast_to(high, grown.shape)
    return restored(lambda s: grown * np.exp(s), lows, highs, frame.weights, frame.mean)
