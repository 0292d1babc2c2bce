"""What is computed before a field and bound to it: numbers with their errors, and data that vary in space.

Data never change once they are made, and are known by a digest of their content: what was computed from them can be
kept, and a device need not be sent them twice.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Triple = tuple[float, float, float]
#: Farther than this from the origin, in mm, there are no parts: a hundred metres.
FARTHEST = 1e5
#: What to say of what lies beyond.
WORLD = (
    f"parts lie within 100 m ({FARTHEST:,.0f} mm) of the origin: beyond, float32 tells no places apart that are nearer "
    "than 0.008 mm"
)
#: Nearer to each other than this, in mm, two places are one: a nanometre.
NEAREST = 1e-6
#: The largest value at a node: float32, and so a shader, has room for some sums of such.
LARGEST_VALUE = 1e37
#: Errors that are written without an exponent.
_ORDINARY = (1e-6, 1e9)
#: A cell that repeats may be so many times as long as it is wide: of more, too many copies lie within its length.
LONGEST_CELL = 100.0
#: Nodes along an axis, and bars: float32 counts no further.
MOST_COUNTED = 2**24


@dataclass(frozen=True, slots=True)
class Reduced:
    """A number found from fields, and its error: the true value lies within `value +- error`.

    `sole` is False of what a `solve` found where its function both rises and falls: there may be another answer.
    """

    value: float
    error: float
    sole: bool = True


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers (n,) that were found together, float64 and finite; what they mean knows who asked for them."""

    values: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SampledField:
    """Values at the nodes of a regular grid, of one component or several.

    `values` is (nx, ny, nz, components), at least two nodes along each axis, finite, float32 or float64. `origin` is
    the place of the first node and `spacing` the distance between nodes, in mm. `facts` are numbers that the task that
    made it tells of it, none of which matters to what reads its values.
    """

    values: NDArray[Any]
    origin: Triple
    spacing: Triple
    facts: tuple[float, ...] = ()

    @classmethod
    def from_array(cls, values: Any, origin: Sequence[float], spacing: float | Sequence[float]) -> SampledField:
        """A field from an array (nx, ny, nz) or (nx, ny, nz, components). Errors: ValueError, which says what is wrong.

        >>> SampledField.from_array(np.zeros((2, 3, 4)), (0, 0, 0), 1.0).shape
        (2, 3, 4)
        """
        array = np.asarray(values)
        if array.dtype.kind not in "fiub":
            raise ValueError(f"the values are {array.dtype}, not numbers")
        if array.ndim == 3:
            array = array[..., None]
        if array.ndim != 4 or min(array.shape[:3]) < 2 or array.shape[3] < 1:
            raise ValueError(
                f"the values have the shape {np.shape(values)}, not (nx, ny, nz) with two nodes or more each"
            )
        array = np.array(array, dtype=np.float32 if array.dtype == np.float32 else np.float64, order="C")
        bad = ~np.isfinite(array)
        if bad.any():
            i, j, k, _ = (int(v) for v in np.argwhere(bad)[0])
            raise ValueError(f"{int(bad.sum()):,} values are not finite numbers, the first at node ({i}, {j}, {k})")
        if np.shape(origin) != (3,):
            raise ValueError(f"the origin is {origin!r:.60}, where three numbers belong")
        if np.shape(spacing) not in ((), (1,), (3,)):
            raise ValueError(f"the spacing is {spacing!r:.60}, where one number belongs, or three")
        place = np.asarray(origin, np.float64)
        step = np.broadcast_to(np.asarray(spacing, np.float64), (3,))
        if not np.isfinite(place).all():
            raise ValueError(f"the origin is {tuple(place.tolist())}, which is no place")
        if not (np.isfinite(step) & (step > 0)).all():
            raise ValueError(f"the spacing is {tuple(step.tolist())}, which must be above 0")
        array.setflags(write=False)
        return cls(array, _triple(place), _triple(step))

    def __repr__(self) -> str:
        nodes = " x ".join(map(str, self.shape))
        several = "" if self.components == 1 else f" of {self.components} components"
        return f"<sampled field of {nodes} nodes{several}, from {self.origin} to {self.end} mm>"

    @property
    def shape(self) -> tuple[int, int, int]:
        """The number of nodes along each axis."""
        nx, ny, nz, _ = self.values.shape
        return nx, ny, nz

    @property
    def components(self) -> int:
        return int(self.values.shape[3])

    @property
    def end(self) -> Triple:
        """The place of the last node."""
        return _triple(np.array(self.origin) + np.array(self.spacing) * (np.array(self.shape) - 1))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the content."""
        return _digest("sampled", self.values, np.array(self.origin), np.array(self.spacing))


@dataclass(frozen=True, eq=False)
class Segments:
    """Bars: straight pieces from `starts` to `ends` (n, 3), of `radii` (n,), in mm and float64, none without length.

    With a `period` (mm along x, y and z) they are those of one cell, which is repeated without end. What joins bars
    looks at those up to `reach` mm farther than the nearest, and no farther.
    """

    starts: NDArray[np.float64]
    ends: NDArray[np.float64]
    radii: NDArray[np.float64]
    period: Triple | None = None
    reach: float = 0.0

    def __repr__(self) -> str:
        return f"<{len(self)} bars>" if self.period is None else f"<{len(self)} bars in cells of {self.period} mm>"

    def __len__(self) -> int:
        return len(self.radii)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the content."""
        period = () if self.period is None else (np.array([*self.period, self.reach]),)
        return _digest("segments", self.starts, self.ends, self.radii, *period)


Data = SampledField | Segments


def _triple(values: NDArray[np.float64]) -> Triple:
    x, y, z = (float(v) for v in values)
    return x, y, z


def coordinates(point: Iterable[float], figures: int = 4) -> str:
    """A point as it is shown, `1.5, 0, -20`: what rounding leaves of 0 is 0."""
    return ", ".join(shown(0.0 if abs(c) < NEAREST else float(c), figures) for c in point)


def shown(length: float, figures: int = 3) -> str:
    """A length in mm as it is shown: with no exponent where parts have such, and whole beyond its figures."""
    return f"{length:.0f}" if 10**figures <= abs(length) < 10 * FARTHEST else f"{length:.{figures}g}"


def figures(value: float, error: float) -> str:
    """A number to the place of its error, which has two figures, and to two of its own at least, where it is known to
    no more than its order; without exponents where sizes are ordinary."""
    if not (_ORDINARY[0] <= error < _ORDINARY[1] and abs(value) < _ORDINARY[1]):
        return f"{value:.6g} +- {error:.2g}"
    place = math.floor(math.log10(error)) - 1
    if error > abs(value) >= _ORDINARY[0]:
        own = math.floor(math.log10(abs(value))) - 1
        return f"{round(value, -own):.{max(0, -own)}f} +- {round(error, -place):.{max(0, -place)}f}"
    decimals = max(0, -place)
    return f"{round(value, -place):.{decimals}f} +- {round(error, -place):.{decimals}f}"


def _digest(kind: str, *arrays: NDArray[Any]) -> str:
    made = hashlib.sha256(kind.encode())
    for array in arrays:
        made.update(f"{array.dtype.str}{array.shape}".encode())
        made.update(np.ascontiguousarray(array).data)
    return made.hexdigest()
