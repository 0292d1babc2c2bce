"""Loads narrower than a face of an element: the part gives way under them more than its elements can."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from porelang.fea.loads import Applied
from porelang.fea.problem import Floats
from porelang.fea.system import System

#: Along the surface a half-space gives way by up to so much more than into it: (1 - nu/2) / (1 - nu) for nu to .33.
_ALONG = 1.25
#: A load on more than this share of faces is on all of them.
_COVERED = 0.95
#: A piece with less than this share of a load is a rim of what is selected.
_PIECE = 0.02


@dataclass(frozen=True, slots=True)
class Narrow:
    """A load on `area` (mm2), or on pieces of it, `wide` (mm) across, which is less than an element's `face` (mm); the
    part gives way under it by up to so much `more` (mm) than its elements, which is so much `work` (N mm)."""

    name: str
    area: float
    wide: float
    face: float
    more: float
    work: float

    @property
    def size(self) -> float:
        """Elements (mm) that feel how narrow it is: half as large."""
        return self.wide / 2


def narrow(system: System) -> list[Narrow]:
    """The loads of a system that are. Elements spread a load over at least one of their faces: measured, discs of .3
    and .5 mm on elements of 5 and 4 mm give way as ones of 1.5 and 1.3 mm."""
    whole = system.boundary.areas.sum(axis=1)
    found = []
    for load in system.loads:
        if load.on is None or not load.on.area > 0:
            continue
        faces = np.unique(load.on.faces)
        face = float(whole[faces].mean()) ** 0.5
        owners = system.nodes.owner[faces]
        soft = float(((1 - system.poisson[owners] ** 2) / system.young[owners]).max())
        force = float(np.linalg.norm(load.forces.sum(axis=0)))
        more, wide = 0.0, math.inf
        for share, sides in _pieces(load, system, whole):
            if share > _PIECE and sides[1] < face:
                wide = min(wide, sides[1])
                lacking = pressed(*sides) - pressed(max(sides[0], face), max(sides[1], face))
                more += share * _ALONG * soft * share * force * lacking
        if more > 0:
            found.append(Narrow(load.name, load.on.area, wide, face, more, more * force))
    return found


def pressed(a: float, b: float) -> float:
    """The mean displacement of a rectangle with sides a and b (mm) on a half-space that a force F presses evenly, in
    (1 - nu^2) F / E per mm: the mean of 1 / (pi r) over all pairs of its places (A. E. H. Love, The stress produced in
    a semi-infinite solid by pressure on part of the boundary, 1929; integrated once more).

    >>> round(pressed(1, 1) / (16 / (3 * math.pi**1.5)), 3)  # a disc of the same area: 16 / (3 pi^2 a)
    0.988
    """
    d = math.hypot(a, b)
    across, along = math.asinh(a / b), math.asinh(b / a)
    inner = a * along + b * across
    x, y = (b * d + a * a * along - b * b) / 2, (a * d + b * b * across - a * a) / 2
    both = (d**3 - a**3 - b**3) / 3
    return 4 * (a * b * inner - a * y - b * x + both) / (math.pi * a * a * b * b)


def _pieces(load: Applied, system: System, whole: Floats) -> list[tuple[float, tuple[float, float]]]:
    """The pieces that a load acts on of faces that have more, of `whole` (f,) mm2: the share of its area that each is,
    and its sides, the longer first, as those of a rectangle that is as far spread. Where a load takes all of a face, as
    at the end of a thin wall, elements feel how wide that is."""
    assert load.on is not None
    corners = system.nodes.faces[load.on.faces, :3]
    rows = np.repeat(np.arange(len(corners)), 3)
    at = coo_matrix((np.ones(rows.size), (rows, corners.ravel())), (len(corners), len(system.nodes.points)))
    _, which = connected_components(at @ at.T, directed=False)
    points, areas = load.on.points, load.on.areas
    found = []
    for k in range(which.max() + 1):
        here = points[which == k].reshape(-1, 3)
        weights: Floats = areas[which == k].ravel()
        if not 0 < weights.sum() < _COVERED * whole[np.unique(load.on.faces[which == k])].sum():
            continue
        middle = np.average(here, axis=0, weights=weights)
        spread = np.linalg.eigvalsh(np.cov((here - middle).T, aweights=weights, ddof=0))
        long, short = (float(12 * max(v, 0.0)) ** 0.5 for v in spread[:0:-1])
        # what is bent is no rectangle: its area is kept, and how far it reaches
        long = max(long, float(weights.sum()) ** 0.5)
        short = float(weights.sum()) / long if short > 0 else 0.0
        if short > 0:
            found.append((float(weights.sum()) / load.on.area, (long, short)))
    return found
