"""What a phase got of what was asked for: periods, stretch, turns and folds, from the Jacobian of what is looked up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.data import SampledField, Triple
from porelang.ops.grid import lookup_cubic
from porelang.progress import checkpoint
from porelang.tasks.phase.turning import determinant, rotations

Values = NDArray[np.float64]
#: A field of x, y and z in mm, as arrays that broadcast.
Field = Callable[[Values, Values, Values], Values]


@dataclass(frozen=True, slots=True)
class Got:
    """Of the points looked at within a part: periods in mm, angles in degrees.

    `off` is by how much the number of cells per mm along an axis of the cells misses 1 / w, relative to it; `stretch`
    how much longer a cell is than wide (the largest by the smallest singular value of the Jacobian); `turn` the angle
    by which cells are turned from the axes of the part.
    """

    asked_least: float
    asked_most: float
    least: float
    most: float
    off_median: float
    off_95: float
    off_most: float
    stretch_95: float
    stretch_most: float
    turn_median: float
    turn_most: float

    @property
    def facts(self) -> tuple[float, ...]:
        """As numbers, in the order of the fields above."""
        return tuple(float(v) for v in astuple(self))

    def __str__(self) -> str:
        turn = f"turned by up to {self.turn_most:.0f} degrees" if self.turn_most >= 0.5 else "not turned"
        return (
            f"asked {self.asked_least:.1f}..{self.asked_most:.1f} mm, got {self.least:.1f}..{self.most:.1f}; "
            f"stretch at most {self.stretch_most:.2f}; {turn}; no folds"
        )


@dataclass(frozen=True, slots=True)
class Fold:
    """A place within the part where a phase folds: its cells would be turned inside out there."""

    place: Triple


def got(phase: SampledField, period: Field, inside: Field, centres: tuple[Values, Values, Values]) -> Got | Fold | None:
    """What a phase got at the points of a grid of `centres` that lie within the part; None if no point does.

    `inside` is negative within. Every point is looked at for folds.
    """
    x, y, z = np.meshgrid(*centres, indexing="ij")
    keep = np.asarray(inside(x, y, z)) < 0
    at = (x[keep], y[keep], z[keep])
    if not len(at[0]):
        return None
    checkpoint()
    slopes = np.stack(
        [
            np.stack([lookup_cubic(phase, *at, (c, int(a == 0), int(a == 1), int(a == 2))) for a in range(3)])
            for c in range(3)
        ]
    )
    folded = ~(determinant(slopes) > 0)
    if folded.any():
        n = int(np.argmax(folded))
        return Fold((float(at[0][n]), float(at[1][n]), float(at[2][n])))
    checkpoint()
    asked = np.asarray(period(*at), np.float64)
    numbers = np.sqrt((slopes**2).sum(1))  # cells per mm along each axis of the cells
    off = np.abs(numbers * asked - 1)
    lengths = np.linalg.eigvalsh(np.einsum("can,cbn->nab", slopes, slopes))
    stretch = np.sqrt(lengths[:, 2] / lengths[:, 0])
    turns = rotations(slopes)
    cosine = (turns[0, 0] + turns[1, 1] + turns[2, 2] - 1) / 2
    turn = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    found = (
        *(asked.min(), asked.max(), 1 / numbers.max(), 1 / numbers.min()),
        *(np.median(off), np.quantile(off, 0.95), off.max()),
        *(np.quantile(stretch, 0.95), stretch.max(), np.median(turn), turn.max()),
    )
    return Got(*(float(v) for v in found))
