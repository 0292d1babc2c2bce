"""A slice of a field as text: two samples to a character, in true colour, or signs where colours are not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.program import Design
from porelang.render.scale import fitting, scale_colours

#: From the depth of the solid to far away; the surface lies between the fourth and the fifth.
SIGNS = "@%#*+=-:. "
_HALF = "\u2580"


def slice_of(design: Design, name: str, width: int = 60, colours: bool = True, axis: int = 2, at: float = 0.0) -> str:
    """A field on the plane where an axis has a value (mm), across the part that it bounds: a picture of so many
    columns. Solid is negative, and red; void is blue. Errors: those of the field and of the part's bounds."""
    box = design.bounds(name)
    across, up = [k for k in range(3) if k != axis]
    lo, hi = np.array(box.lo), np.array(box.hi)
    middle, half = (lo + hi) / 2, (hi - lo) / 2 * 1.05
    height = max(2, 2 * round(width * half[up] / half[across] / 2)) if half[across] else 2
    points = np.zeros((height, width, 3))
    points[..., axis] = at
    points[..., across] = middle[across] + half[across] * (2 * (np.arange(width) + 0.5) / width - 1)
    points[..., up] = (middle[up] + half[up] * (1 - 2 * (np.arange(height) + 0.5) / height))[:, None]
    values = np.asarray(design.field(name)(points.reshape(-1, 3)), np.float64).reshape(height, width)
    lines = _in_colour(values) if colours else _in_signs(values)
    plane = f"{'xyz'[axis]} = {at:g} mm, {2 * half[across]:.4g} x {2 * half[up]:.4g} mm"
    return "\n".join([*lines, plane])


def _in_colour(values: NDArray[np.float64]) -> list[str]:
    shades = np.round(255 * scale_colours(values, fitting(values))).astype(int)
    lines = []
    for row in range(0, len(values), 2):
        line = ""
        for above, below in zip(shades[row], shades[row + 1], strict=True):
            line += f"\033[38;2;{';'.join(map(str, above))};48;2;{';'.join(map(str, below))}m{_HALF}"
        lines.append(f"{line}\033[0m")
    return lines


def _in_signs(values: NDArray[np.float64]) -> list[str]:
    """One sign for the two samples of a place, by the deeper of them."""
    deeper = np.minimum(values[::2], values[1::2])
    depth, away = max(float(-deeper.min()), 1e-12), max(float(deeper.max()), 1e-12)
    inside = np.clip((4 * (1 + deeper / depth)).astype(int), 0, 3)
    outside = np.clip(4 + np.ceil(5 * deeper / away).astype(int), 5, len(SIGNS) - 1)
    which = np.where(deeper < 0, inside, outside)
    return ["".join(SIGNS[i] for i in row).rstrip() for row in which]
