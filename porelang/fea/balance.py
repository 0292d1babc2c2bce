"""Loads that are to balance each other on what supports leave free: whether they do, and what is left of them.

In elements an area, and its middle, are not quite those of the part: what balances on the part leaves a little on its
mesh. A force on the volume that varies as a rigid motion takes that (inertia relief: the part as it would be while
that rest accelerates it, of a density that is the same everywhere).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.diagnostics import fail
from porelang.fea.chords import area_off
from porelang.fea.loads import Applied
from porelang.fea.means import weighed
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Force, Load, Moment
from porelang.fea.rigid import Free
from porelang.fea.surface import place, vector

#: Loads that drive a free motion with less than this of their size are taken to do no work on it.
_ROUNDED = 1e-6
#: By how much of an edge of its triangles the middle of an area may be aside (measured: the ends of a gyroid .03, of
#: bent pipes .0005), and by which share an area or a volume may be another besides what its rim shows.
_ASIDE, _ANOTHER = 0.05, 0.002
#: What is smaller than this of its size is 0 in a sentence.
_NONE = 1e-9


@dataclass(frozen=True, slots=True)
class Rest:
    """What is left of loads: `forces` (k, 3) N on nodes that balance it, what it comes to (`said`), and which
    `share` of the loads it is at most."""

    forces: Floats
    said: str
    share: float


def rest_of(loads: tuple[Load, ...], acting: tuple[Applied, ...], nodes: Nodes, free: Free) -> Rest | None:
    """What loads leave on free motions that they are said not to drive; None where that is rounding. Errors: E171 where
    it is more than what elements make of the areas."""
    if not acting:
        return None
    forces = np.sum([load.forces for load in acting], axis=0)
    size = float(np.abs(forces).sum())
    works = np.abs(np.einsum("rkd,kd->r", free.named, forces))
    if not (works > _ROUNDED * size).any():
        return None
    open_ = np.sum([_open(load, on, nodes, free) for load, on in zip(loads, acting, strict=True)], axis=0)
    driven = works > np.maximum(open_, _ROUNDED * size)
    left = _added(forces, nodes)
    if driven.any():
        raise fail(
            "E171",
            f"the loads drive a motion that nothing holds ({listed(free.words, driven)}): they add up to {left}",
            hint="add a support against it, or a load that balances it",
        )
    weights = weighed(nodes, free.fields)
    inner = np.einsum("rkd,skd->rs", weights, free.fields)
    share = np.linalg.solve(inner, np.einsum("rkd,kd->r", free.fields, forces))
    balancing = -np.einsum("r,rkd->kd", share, weights)
    return Rest(balancing, left, float(works.max()) / size)


def listed(words: tuple[str, ...], which: np.ndarray | None = None) -> str:
    """Some of these words as a list, each once."""
    some = list(dict.fromkeys(w for w, told in zip(words, np.ones(len(words)) if which is None else which, strict=True)
                              if told))  # fmt: skip
    return some[0] if len(some) == 1 else ", ".join(some[:-1]) + " and " + some[-1]


def _open(load: Load, acting: Applied, nodes: Nodes, free: Free) -> Floats:
    """How much work (r,) a load may do on each motion for what elements make of where it acts. What it adds up to is
    given of a force, and of a couple its moment."""
    size = float(np.abs(acting.forces).sum())
    if isinstance(load, Moment):
        return np.zeros(len(free.named))
    if acting.on is None:
        return np.full(len(free.named), _ANOTHER * size)
    faces = np.unique(acting.on.faces)
    corners = nodes.points[nodes.faces[faces, :3]]
    edge = float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean())
    aside = np.asarray(size * _ASIDE * edge * free.turns)
    if isinstance(load, Force):
        return aside
    return aside + (_ANOTHER + area_off(nodes, faces) / acting.on.area) * size


def _added(forces: Floats, nodes: Nodes) -> str:
    """What forces add up to, in a sentence."""
    low, high = nodes.points.min(axis=0), nodes.points.max(axis=0)
    centre, size = (low + high) / 2, float(np.abs(forces).sum())
    force, moment = forces.sum(axis=0), np.cross(nodes.points - centre, forces).sum(axis=0)
    force, moment = (
        np.where(np.abs(v) > _NONE * scale, v, 0.0)
        for v, scale in ((force, size), (moment, size * float((high - low).max())))
    )
    return f"{vector(force)} N and {vector(moment)} N mm about {place(centre)}"
