"""Layers of a picture, one over another: glass, outlines, a deformed part with its ghost; and the mean of samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.render.deformed import Drawn
from porelang.render.march import Distances, Marcher

Light = NDArray[np.float32]
#: How dark an outline is drawn, and by how many pixels depth has to leap for one.
OUTLINE, LEAP = 0.42, 6.0
#: The colour of glass, and how many of its surfaces, one behind the other, are drawn.
GLASS, LAYERS = np.array((0.86, 0.87, 0.90), np.float32), 8
#: The colour of the ghost's lines, how much they hide, and how much a ghost darkens the page.
GHOST, LINE, VEIL = np.array((0.36, 0.38, 0.44), np.float32), 0.75, 0.10
#: How much its lines hide of the deformed part: of a lattice there are many.
FAINT = 0.3


def lay_glass(over: Light, marcher: Marcher, far: Distances, first: Distances) -> None:
    """Lay the surface over what is there as clear glass, each time a ray meets or leaves the part, first at `first`.

    What lies behind `far` is hidden.
    """
    through = np.ones_like(far)
    colour = np.zeros((*far.shape, 3), np.float32)
    distance = first.copy()
    for layer in range(LAYERS):
        if layer:
            distance = marcher.distances((layer, 1, LAYERS), distance, leaving=layer % 2 == 1)
        distance[distance >= far] = np.inf
        if not np.isfinite(distance).any():
            break
        light = marcher.light(distance, glass=True).astype(np.float32) / 255
        alpha = light[..., 3] * through
        colour += (alpha * light[..., 0])[..., None] * GLASS
        through -= alpha
    over[..., :3] = colour + through[..., None] * over[..., :3]
    over[..., 3] = (1 - through) + through * over[..., 3]


def with_outlines(light: NDArray[Any], distance: Distances, leap: float) -> Light:
    """The part's colours times alpha, and alpha, darker where what lies behind is much farther. Bytes become 0..1."""
    out: Light = light.astype(np.float32)
    if light.dtype == np.uint8:
        out *= np.float32(1 / 255)
    out[_leaps(distance, leap) & np.isfinite(distance), :3] *= 1 - OUTLINE
    return out


def averaged(over: Light, n: int, transparent: bool) -> NDArray[np.uint8]:
    """The samples of each pixel as one, on white or on nothing."""
    height, width = over.shape[0] // n, over.shape[1] // n
    mean: Any = over.reshape(height, n, width, n, 4).mean(axis=(1, 3))
    alpha = mean[..., 3:]
    if transparent:
        colour = np.divide(mean[..., :3], alpha, out=np.zeros_like(mean[..., :3]), where=alpha > 0)
        mean = np.concatenate([colour, alpha], axis=2)
    else:
        mean = np.concatenate([mean[..., :3] + (1 - alpha), np.ones_like(alpha)], axis=2)
    pixels: NDArray[np.uint8] = np.rint(np.clip(mean, 0, 1) * 255).astype(np.uint8)
    return pixels


def lay_deformed(over: Light, drawn: Drawn, leap: float, samples: int) -> None:
    """Lay a deformed part over what is there, and its ghost, where it has one, in front or beside it."""
    there = np.isfinite(drawn.distance)
    light = np.concatenate([drawn.colours, there[..., None].astype(np.float32)], axis=-1)
    over[there] = with_outlines(light, drawn.distance, leap)[there]
    if drawn.ghost is None:
        return
    distance = drawn.ghost.distance
    free = np.isfinite(distance) & (distance <= drawn.distance)
    outline = _wider(drawn.ghost.edges | _leaps(distance, leap) & np.isfinite(distance), samples // 2)
    free_line = outline & (np.where(np.isfinite(distance), distance, -np.inf) <= drawn.distance + leap)
    line = np.where(there, FAINT, LINE)
    alpha = np.where(free_line, line, np.where(free & ~there, VEIL, 0.0)).astype(np.float32)[..., None]
    over[..., :3] = GHOST * alpha + (1 - alpha) * over[..., :3]
    over[..., 3:] = alpha + (1 - alpha) * over[..., 3:]


def _leaps(distance: Distances, leap: float) -> NDArray[np.bool_]:
    """Where what lies behind is much farther."""
    padded = np.pad(np.nan_to_num(distance, posinf=1e9), 1, mode="edge")
    middle = padded[1:-1, 1:-1]
    edge = np.zeros(distance.shape, np.bool_)
    for a, b in ((padded[:-2, 1:-1], padded[2:, 1:-1]), (padded[1:-1, :-2], padded[1:-1, 2:])):
        edge |= (a + b - 2 * middle) > leap
    return edge


def _wider(line: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Lines, wider by so many samples on each side."""
    for _ in range(by):
        padded = np.pad(line, 1)
        line = padded[1:-1, 1:-1] | padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]
    return line
