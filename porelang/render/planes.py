"""Fields on planes, as in Figure 5 of the paper: red where negative, yellow near zero, blue where positive.

A plane reaches a little beyond the part, so that one sees the field outside of it. Its line of zero is drawn dark.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.render.camera import Camera
from porelang.render.scale import Colouring, Scale, around_zero, scale_colours

Points = NDArray[np.float64]
Values = NDArray[np.float32]
#: A field as a function of points (n, 3) in mm.
Evaluate = Callable[[Points], NDArray[Any]]
LINE = np.array((0.13, 0.12, 0.12), np.float32)
#: How far a plane reaches beyond the part, in its longest side.
BEYOND = 0.04
#: Samples along a plane's sides from which its range of colours is taken; odd, so that its middle is one.
SURVEY = 97
ROWS = 64


@dataclass(frozen=True, slots=True)
class Plane:
    """The plane where the coordinate `axis` (0, 1 or 2) is `at` mm."""

    axis: int
    at: float


@dataclass(frozen=True, slots=True)
class Cross:
    """What rays see of planes: distance in mm (infinite where there is none), value, and which plane (-1: none)."""

    distance: Values
    value: Values
    which: NDArray[np.int8]


def stage(box: Box, planes: Sequence[Plane]) -> Box:
    """The box that planes are drawn in: that of the part and a little beyond."""
    more = BEYOND * max(box.size)
    lo, hi = np.array(box.lo) - more, np.array(box.hi) + more
    for p in planes:
        lo[p.axis], hi[p.axis] = min(lo[p.axis], p.at), max(hi[p.axis], p.at)
    return Box((float(lo[0]), float(lo[1]), float(lo[2])), (float(hi[0]), float(hi[1]), float(hi[2])))


def cross(
    planes: Sequence[Plane], within: Box, camera: Camera, size: tuple[int, int], field: Evaluate,
    part: Evaluate | None = None,
) -> Cross:  # fmt: skip
    """Where the rays of a picture meet the nearest of the planes, and the field there; or of what of them lies in a
    `part`."""
    width, height = size
    out = Cross(np.full((height, width), np.inf, np.float32), np.full((height, width), np.nan, np.float32),
                np.full((height, width), -1, np.int8))  # fmt: skip
    lo, hi = np.array(within.lo), np.array(within.hi)
    for top in range(0, height, ROWS):
        rows = slice(top, min(top + ROWS, height))
        origin, way = camera.rays(size, rows)
        nearest = np.full(origin.shape[:2], np.inf)
        which = np.full(origin.shape[:2], -1, np.int8)
        for i, p in enumerate(planes):
            with np.errstate(all="ignore"):
                t = (p.at - origin[..., p.axis]) / way[..., p.axis]
                place = origin + way * t[..., None]
            there = np.isfinite(t) & (t > 0) & (t < nearest)
            for axis in {0, 1, 2} - {p.axis}:
                there &= (place[..., axis] >= lo[axis]) & (place[..., axis] <= hi[axis])
            if part is not None and there.any():
                there[there] = np.asarray(part(place[there])) <= 0
            nearest[there], which[there] = t[there], i
        hit = which >= 0
        if hit.any():
            out.value[rows][hit] = field((origin + way * np.where(hit, nearest, 0.0)[..., None])[hit])
        out.distance[rows], out.which[rows] = nearest, which
    return out


def reach(planes: Sequence[Plane], within: Box, field: Evaluate) -> Scale:
    """The scale that takes in what the field attains on planes, on either side of zero, in two digits."""
    found = []
    for p in planes:
        ends = [np.linspace(a, b, SURVEY) for a, b in zip(within.lo, within.hi, strict=True)]
        ends[p.axis] = np.array([p.at])
        places = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)
        found.append(np.asarray(field(places), dtype=np.float64))
    return around_zero(np.concatenate(found))


def colours(seen: Cross, scale: Colouring, width: float) -> Values:
    """Red, green and blue (height, width, 3) in 0..1; the line of zero is `width` pixels wide."""
    line = zero_line(seen, width)[..., None]
    mixed: Values = (scale_colours(seen.value, scale) * (1 - line) + LINE * line).astype(np.float32)
    return mixed


def zero_line(seen: Cross, width: float) -> Values:
    """How much of each pixel the line of zero covers: from the value over its change from pixel to pixel."""
    steep = np.zeros_like(seen.value)
    with np.errstate(all="ignore"):
        for axis in (0, 1):
            if seen.value.shape[axis] < 2:
                continue
            step = np.abs(np.diff(seen.value, axis=axis))
            apart = np.diff(seen.which, axis=axis) != 0
            step = np.where(apart | ~np.isfinite(step), 0.0, step).astype(np.float32)
            pad = [(0, 0), (0, 0)]
            pad[axis] = (1, 1)
            step = np.pad(step, pad)
            ends = (step[:-1], step[1:]) if axis == 0 else (step[:, :-1], step[:, 1:])
            steep += np.maximum(*ends) ** 2
        away = np.abs(seen.value) / np.sqrt(steep)
        share = np.clip(width / 2 + 0.5 - away, 0, 1)
    return np.where(np.isfinite(share), share, 0.0).astype(np.float32)
