"""What supports and loads come to: the area that each found, its force, its moment."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from porelang.fea.covered import Patch
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats
from porelang.fea.supports import Held

#: What is less than this of the forces that it is the sum of is rounding.
_ROUNDED = 1e-12


@dataclass(frozen=True, slots=True)
class Resultant:
    """What acts on a part in one place: of a support, that with which it holds the part.

    `area` mm2 is that of the boundary which was selected, 0 of what acts on the volume, on an edge or in a point;
    `centre` (3,) mm its middle. `force` (3,) N, and its `moment` (3,) N mm about the origin.
    """

    name: str
    area: float
    centre: Floats
    force: Floats
    moment: Floats

    @property
    def couple(self) -> Floats:
        """The moment (3,) N mm about the centre: what turns, beside a force there."""
        return self.moment - np.cross(self.centre, self.force)

    def scaled(self, factor: float) -> Resultant:
        return replace(self, force=self.force * factor, moment=self.moment * factor)


def of_load(name: str, forces: Floats, on: Patch | None, nodes: Nodes) -> Resultant:
    """Of a load with forces (k, 3) N on nodes, on a part of the boundary, or on the volume."""
    force, moment = forces.sum(axis=0), np.cross(nodes.points, forces).sum(axis=0)
    if on is None:
        middles = nodes.points[nodes.corners].mean(axis=1)
        centre = np.average(middles, axis=0, weights=nodes.volumes)
        return Resultant(name, 0.0, centre, *_rounded(force, moment, forces, nodes))
    return Resultant(name, on.area, on.centre, *_rounded(force, moment, forces, nodes))


def _rounded(force: Floats, moment: Floats, forces: Floats, nodes: Nodes) -> tuple[Floats, Floats]:
    """What forces come to, of which what is rounding of them is 0: a pressure in a tube comes to nothing."""
    size, span = float(np.abs(forces).sum()), float(np.abs(nodes.points).max())
    return (np.where(np.abs(force) > _ROUNDED * size, force, 0.0),
            np.where(np.abs(moment) > _ROUNDED * size * span, moment, 0.0))  # fmt: skip


def of_supports(names: tuple[str, ...], held: Held, rest: Floats, nodes: Nodes) -> tuple[Resultant, ...]:
    """Of supports, out of the forces (k, 3) N that nodes are held with. What several hold they share evenly, so that
    together they come to what the part is held with."""
    shared = rest / np.maximum(held.supports, 1)
    found = []
    for name, axes, chosen in zip(names, held.axes, held.nodes, strict=True):
        forces = shared[chosen] * np.asarray(axes)
        there = np.zeros(len(nodes.points), bool)
        there[chosen] = True
        faces = nodes.faces[there[nodes.faces].all(axis=1), :3]
        ends = nodes.points[faces]
        areas = np.linalg.norm(np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0]), axis=1) / 2
        area = float(areas.sum())
        centre = (
            nodes.points[chosen].mean(axis=0) if area <= 0 else np.average(ends.mean(axis=1), axis=0, weights=areas)
        )
        moment = np.cross(nodes.points[chosen], forces).sum(axis=0)
        found.append(Resultant(name, area, centre, forces.sum(axis=0), moment))
    return tuple(found)
