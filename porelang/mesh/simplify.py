"""Fewer triangles within a stated deviation: edges collapsed by an estimate, then proven, and mended where that fails.

The estimate errs on the safe side, by four times where a surface is curved; one triangle in ten thousand cannot be
proven all the same. Round those the mesh is left as it was, and made again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.mesh.collapse import collapse
from porelang.mesh.crossed import crossed
from porelang.mesh.surface import Surface
from porelang.mesh.within import within

Progress = Callable[[int, int], None]
ATTEMPTS = 5
REACH = 4.0  # mean edges: how far round what could not be proven nothing is collapsed, times the attempts so far


@dataclass(frozen=True, slots=True)
class Simplified:
    """A surface with fewer triangles: no point of it or of the original is over `deviation` (mm) from the other."""

    surface: Surface
    deviation: float


def simplify(
    surface: Surface,
    deviation: float,
    *,
    threads: int = 1,
) -> Simplified:
    """The surface with fewer triangles, proven to stay within `deviation` (mm) of the original, and closed as before.

    If no attempt can be proven, the surface is given back as it is.
    """
    from scipy.spatial import cKDTree

    allowed = np.full(len(surface.vertices), deviation)
    mean = float(np.sqrt(2.3 * surface.area / len(surface.faces)))  # the side of a triangle of that size
    tree: Any = None
    whole = not crossed(surface, threads=threads).any()
    for attempt in range(1, ATTEMPTS + 1):
        made = collapse(surface, allowed)
        there, lost = within(surface, made, deviation, threads)
        back, wrong = within(made, surface, deviation, threads)
        if whole:  # what does not run through itself stays so
            wrong = np.union1d(wrong, np.flatnonzero(crossed(made, threads=threads)))
        if not len(lost) and not len(wrong):
            return Simplified(made, max(there, back))
        corners = np.concatenate([surface.vertices[surface.faces[lost]], made.vertices[made.faces[wrong]]])
        middle = corners.mean(axis=1)
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1) + deviation + attempt * REACH * mean
        tree = cKDTree(surface.vertices) if tree is None else tree
        balls = tree.query_ball_point(middle, reach)
        allowed[np.unique(np.concatenate([np.array(ball, np.int64) for ball in balls]))] = 0.0
    return Simplified(surface, 0.0)
