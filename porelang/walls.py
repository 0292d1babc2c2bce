"""The voxel that holds a part: found from how thick its walls are, and how narrow its gaps, along their normals, at
points all over its surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.solid import Solid, onto

Floats = NDArray[np.float64]
RESOLUTION = 128  # samples along the longest side, where nothing asks for more
TO_A_WALL = 2.5  # voxels: fewer than two may miss a wall, and three cost twice as much
AFFORDABLE = 16_000_000  # samples: seconds, and a file of some 100 MB
MOST_TRIANGLES = 5_000_000  # a flat part has many for its samples: a file of 250 MB
MANY_SAMPLES, MOST_SAMPLES = 1e8, 1e9  # half a minute or more, and more than anybody waits for
A_PART = "take a part of it, with --bounds"
POINTS = 1 << 16  # at which the surface is estimated
STARTS = 4096  # places from which the surface is looked for
STEPS, SCAN = 5, 40
ON = 1e-3  # of the distance between places: what is nearer to the surface is on it
PARALLEL = -0.9  # cosine between the outward directions of the two sides of a wall; a wedge has others
#: The same, 7 degrees, of walls that elements are to fit through. Where a shape cuts a lattice at a small angle a
#: feather is left, which runs out in an edge: no size of elements fits through that. Measured, of gyroids, diamonds,
#: IWPs and Schwarz P cut by boxes, cylinders and balls: with this the thinnest is a wall of the lattice; sheets,
#: plates, struts and webs are found as without it.
BEARING = -0.9925
ALIKE = 0.8  # walls down to this part of a thickness are as thick
FEW = 0.01  # of the walls: fewer are no walls, but where something runs out


@dataclass(frozen=True, slots=True)
class Chosen:
    """A voxel (mm), how thick the thinnest walls are (mm; None: there are none to tell), the voxel that walls and gaps
    ask for (mm), and how wide the narrowest gaps are (mm; None: none ask for a finer voxel than the walls do)."""

    voxel: float
    wall: float | None
    wanted: float
    gap: float | None = None


def chosen(part: Solid, affordable: float = AFFORDABLE) -> Chosen:
    """The voxel for a part in its box: RESOLUTION samples along the longest side, or as fine as its thinnest walls and
    narrowest gaps ask for, as long as no more samples are taken than are `affordable` and about MOST_TRIANGLES are
    made."""
    size = part.hi - part.lo
    usual = float(size.max()) / RESOLUTION
    at = on_surface(part)
    found = walls_at(part, at)
    wall = None if found is None else found.wall
    least_wall = min(math.inf if wall is None else wall, usual * TO_A_WALL)
    gaps = gaps_at(part, at, least_wall)  # wider ones change nothing
    gap = None if gaps is None else gaps.wall
    narrow = min(least_wall, math.inf if gap is None else gap)
    if narrow / TO_A_WALL >= usual:
        return Chosen(usual, wall, usual)
    wanted = narrow / TO_A_WALL
    finest = float(np.prod(size) / affordable) ** (1 / 3)
    finest = max(finest, math.sqrt(triangles(part, narrow / 4) / MOST_TRIANGLES))
    return Chosen(max(wanted, min(usual, finest)), wall, wanted, gap)


def takes(size: Floats, voxel: float, most: float = MOST_SAMPLES) -> str:
    """How many samples a voxel (mm) takes of a box of a size (3,), mm, and above the `most` what to do instead; "" for
    so few that they are nothing to speak of."""
    samples = float(np.prod(size / voxel + 2))
    if samples <= MANY_SAMPLES:
        return ""
    many = f"some {float(f'{samples:.2g}') / 1e6:,.0f} million" if samples < 1e10 else f"{samples:.1g}"
    return f"that takes {many} samples{f': {A_PART}' if samples > most else ''}"


def rounded(length: float) -> str:
    """A length with two figures, not rounded up."""
    step = 10.0 ** (np.floor(np.log10(length)) - 1)
    return f"{np.floor(length / step * (1 + 1e-9)) * step:.2g}"


def triangles(part: Solid, near: float) -> float:
    """About how many triangles marching cubes makes of a part at a voxel of 1 mm: so many times the voxel's inverse
    square at others.

    Every line of the grid that crosses the surface makes a vertex, and a vertex two triangles. The surface is
    estimated from the share of points by chance that are `near` it (mm), to first order.
    """
    lo, hi = part.lo - near, part.hi + near
    at = lo + np.random.default_rng(0).random((POINTS, 3)) * (hi - lo)
    value, slope = part.slope(at)
    with np.errstate(all="ignore"):
        steep = np.linalg.norm(slope, axis=1)
        lines = np.abs(slope).sum(axis=1) / steep  # of the three axes, that cross a piece of the surface
        beside = np.abs(value) < near * steep
    return float(2 * lines[beside].sum() / POINTS * np.prod(hi - lo) / (2 * near))


@dataclass(frozen=True, slots=True)
class Thinnest:
    """How thick the thinnest walls of a part are, or how wide its narrowest gaps (mm), and a place on one (3,)."""

    wall: float
    at: Floats


def thinnest(part: Solid) -> float | None:
    """How thick the thinnest walls of a part are, in mm, or None where no walls are found."""
    found = walls_at(part, on_surface(part))
    return None if found is None else found.wall


def on_surface(part: Solid, seed: int = 0) -> Floats:
    """Points (n, 3) mm on the surface of a part: those spread over its box, by chance of a seed, brought there."""
    size = part.hi - part.lo
    apart = float(np.prod(size) / STARTS) ** (1 / 3)
    counts = np.clip(np.ceil(size / apart), 1, STARTS).astype(np.int64)
    while np.prod(counts) > 4 * STARTS:
        counts = np.maximum(1, counts * 3 // 4)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    random = np.random.default_rng(seed)
    at = onto(part, part.lo + (cells + random.random(cells.shape)) * size / counts, STEPS, float((size / counts).max()))
    at = at[np.isfinite(at).all(axis=1)]
    at = at[part.within(at)]
    value, slope = part.slope(at)
    with np.errstate(all="ignore"):
        found: Floats = at[np.abs(value) <= ON * apart * np.linalg.norm(slope, axis=1)]
    return found


def walls_at(part: Solid, at: Floats, parallel: float = PARALLEL) -> Thinnest | None:
    """The thinnest walls that some points (n, 3) mm on the surface of a part stand on, or None where there are none.

    A wall counts where its sides are parallel: the cosine between their outward directions is below `parallel`. The
    thinnest is the least thickness that is not just the end of a tail: most walls that are no thicker are about as
    thick.
    """
    return _thinnest(part, at, float((part.hi - part.lo).max()), False, parallel)


def walls_of(part: Solid) -> tuple[Thinnest | None, Thinnest | None]:
    """The thinnest walls of a part, and the thinnest that bear (BEARING): the same where these are as thick."""
    at = on_surface(part)
    narrow, bearing = walls_at(part, at), walls_at(part, at, BEARING)
    if narrow is not None and bearing is not None and ALIKE < narrow.wall / bearing.wall < 1 / ALIKE:
        return narrow, narrow
    return narrow, bearing


def gaps_at(part: Solid, at: Floats, reach: float) -> Thinnest | None:
    """The narrowest gaps, less than `reach` (mm) wide, that some points (n, 3) mm on the surface of a part look into:
    void between parallel sides of the part. Pores of a lattice have all widths from 0 on, the most of them wide: of
    gaps that count there are more than of those a little wider."""
    return _thinnest(part, at, reach, True, PARALLEL)


def _thinnest(part: Solid, at: Floats, reach: float, void: bool, parallel: float) -> Thinnest | None:
    if not len(at):
        return None
    points = len(at)
    thick, facing, _ = part.walls(at, reach / ALIKE if void else reach, SCAN, void)
    at, thick = at[facing < parallel], thick[facing < parallel]
    wall = least(np.sort(thick), points, reach if void else None)
    if wall is None:
        return None
    return Thinnest(wall, at[int(np.abs(thick - wall).argmin())])


def least(thick: Floats, points: int, most: float | None = None) -> float | None:
    """The least thickness, of those in order, that is no tail of thicker walls; where there is a `most` (mm) it is no
    more, and of those a little thicker there are fewer."""
    found = alike(thick, points, most)
    return None if found is None else float(np.median(found))


def alike(thick: Floats, points: int, most: float | None = None) -> Floats | None:
    """The thicknesses, of those in order, of which the median is the `least`."""
    for i in range(max(0, math.ceil(FEW * points) - 1), len(thick)):
        first = int(np.searchsorted(thick, ALIKE * thick[i]))
        if most is not None:
            if thick[i] >= most:
                return None
            if int(np.searchsorted(thick, thick[i] / ALIKE)) - (i + 1) > i + 1 - first:
                continue
        if i + 1 - first >= max(FEW * points, (i + 1) / 2):
            return thick[first : i + 1]
    return None
