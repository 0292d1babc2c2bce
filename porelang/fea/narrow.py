"""Loads on less than a face of an element: the part gives way under them more than its elements can."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.fea.system import System

#: The mean displacement of a disc of radius a on a half-space that a force F presses evenly is so many times
#: (1 - nu^2) F / (E a) (S. Timoshenko, J. N. Goodier, Theory of Elasticity, 3rd ed., 1970, article 139).
_DISC = 16 / (3 * np.pi**2)
#: Along the surface it gives way by up to so much more: (1 - nu/2) / (1 - nu) for nu to .33.
_ALONG = 1.25


@dataclass(frozen=True, slots=True)
class Narrow:
    """A load on `area` (mm2), less than the `face` of an element; the part gives way under it by up to so much `more`
    (mm) than its elements, which is so much `work` (N mm)."""

    name: str
    area: float
    face: float
    more: float
    work: float

    @property
    def size(self) -> float:
        """Elements (mm) that feel how narrow it is: as large as its radius."""
        return float(np.sqrt(self.area / np.pi))


def narrow(system: System) -> list[Narrow]:
    """The loads of a system that are. Elements spread a load over a disc of the area of one of their faces: measured,
    discs of .3 and .5 mm on elements of 5 and 4 mm give way as ones of 1.5 and 1.3 mm."""
    whole = system.boundary.areas.sum(axis=1)
    found = []
    for load in system.loads:
        if load.on is None or not load.on.area > 0:
            continue
        faces = np.unique(load.on.faces)
        area, face = load.on.area, float(whole[faces].mean())
        if area >= face:
            continue
        owners = system.nodes.owner[faces]
        soft = float(((1 - system.poisson[owners] ** 2) / system.young[owners]).max())
        force = float(np.linalg.norm(load.forces.sum(axis=0)))
        more = _ALONG * _DISC * soft * force * np.sqrt(np.pi) * (area**-0.5 - face**-0.5)
        found.append(Narrow(load.name, area, face, float(more), float(more * force)))
    return found
