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
#: What is smaller than this of its size is 0 in a sentence: meshes are no more exact.
_NONE = 1e-6


@dataclass(frozen=True, slots=True)
class Rest:
    """What is left of loads: `forces` (k, 3) N on nodes that balance it, what it comes to (`said`), and which
    `share` of the loads it is at most; `open` is the share that elements leave open: what the loads are wrong by may
    be as much, whatever is left."""

    forces: Floats
    said: str
    share: float
    open: float


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
    open_ = _aside(loads, acting, nodes, free) + _areas(loads, acting, nodes, free)
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
    most = int(works.argmax())
    return Rest(balancing, left, float(works[most]) / size, float(open_[most]) / size)


def listed(words: tuple[str, ...], which: np.ndarray | None = None) -> str:
    """Some of these words as a list, each once."""
    some = list(dict.fromkeys(w for w, told in zip(words, np.ones(len(words)) if which is None else which, strict=True)
                              if told))  # fmt: skip
    return some[0] if len(some) == 1 else ", ".join(some[:-1]) + " and " + some[-1]


def _aside(loads: tuple[Load, ...], acting: tuple[Applied, ...], nodes: Nodes, free: Free) -> Floats:
    """How much work (r,) loads may do on each motion for where elements have the middles of their areas. A couple has
    none."""
    found = np.zeros(len(free.named))
    for load, on in zip(loads, acting, strict=True):
        if on.on is not None and not isinstance(load, Moment):
            corners = nodes.points[nodes.faces[np.unique(on.on.faces), :3]]
            edge = float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).mean())
            found += float(np.abs(on.forces).sum()) * _ASIDE * edge * free.turns
    return found


def _areas(loads: tuple[Load, ...], acting: tuple[Applied, ...], nodes: Nodes, free: Free) -> Floats:
    """How much work (r,) loads may do on each motion for how large elements make what they act on. What it adds up to
    is given of a force, and of a couple its moment.

    Areas that are the same in elements are the same area, whatever their rims leave to chance: they are another
    together, and what balances on them does so still. By what they do on a motion for their pressure they may differ,
    as their surface in elements leans.
    """
    some = [on for load, on in zip(loads, acting, strict=True) if not isinstance(load, Force | Moment)]
    found = np.full(len(free.named), _ANOTHER * sum(float(np.abs(on.forces).sum()) for on in some))
    on_areas = [(on.on, on.forces) for on in some if on.on is not None]
    areas = np.array([on.area for on, _ in on_areas])
    off = np.array([area_off(nodes, np.unique(on.faces)) for on, _ in on_areas])
    works = np.array([np.einsum("rkd,kd->r", free.named, forces) for _, forces in on_areas])
    pressures = np.array([np.abs(forces).sum() for _, forces in on_areas]) / areas
    left = np.ones(len(areas), bool)
    while left.any():
        area = areas[left][0]
        alike = left & (np.abs(areas - area) <= _ANOTHER * area)
        left &= ~alike
        share = off[alike].max() / area
        each = works[alike] / pressures[alike, None]
        each = np.where(np.abs(each) > share * area, each, 0)  # the rest may be how elements lean
        same = pressures[alike] @ (np.sign(each) * np.abs(each).mean(axis=0))  # were they the same on each motion too
        apart = np.minimum(np.abs(works[alike].sum(axis=0) - same), share * float(pressures[alike] @ areas[alike]))
        found += apart + share * np.abs(same)
    return found


def _added(forces: Floats, nodes: Nodes) -> str:
    """What forces add up to, in a sentence."""
    low, high = nodes.points.min(axis=0), nodes.points.max(axis=0)
    centre, size = (low + high) / 2, float(np.abs(forces).sum())
    centre = np.where(np.abs(centre) > _NONE * float((high - low).max()), centre, 0.0)
    force, moment = forces.sum(axis=0), np.cross(nodes.points - centre, forces).sum(axis=0)
    force, moment = (
        np.where(np.abs(v) > _NONE * scale, v, 0.0)
        for v, scale in ((force, size), (moment, size * float((high - low).max())))
    )
    return f"{vector(force)} N and {vector(moment)} N mm about {place(centre)}"
