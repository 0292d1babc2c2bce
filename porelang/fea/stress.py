"""Strains and stresses of a displacement, and what engineers read off them.

Tensors are rows (..., 6) in the order xx, yy, zz, xy, yz, xz (that of VTK and ParaView), with tensor shear strains,
half of the engineers'.
"""

from __future__ import annotations

import numpy as np

from porelang.compiled import compiled
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints

#: How often each component stands in the full tensor.
TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])


def strains(nodes: Nodes, displacement: Floats) -> Floats:
    """The strains of a displacement (k, 3): those at the corners of each tetrahedron (m, 4, 6) for order 2, between
    which they are linear, and (m, 1, 6) for order 1, where they are constant.
    """
    from porelang.fea.elements import slopes_at, terms

    places = np.eye(4) if nodes.order == 2 else np.full((1, 4), 0.25)
    out = np.empty((len(nodes.elements), len(places), 6))
    strains_at(
        nodes.elements, nodes.gradients, terms(nodes.order)[0], slopes_at(places, nodes.order), displacement, out
    )
    return out


@compiled
def strains_at(
    elements: Ints, gradients: Floats, corners: Ints, factors: Floats, displacement: Floats, out: Floats
) -> None:
    """The strains (m, q, 6) where `factors` (q, w, 2) belong."""
    m, width = elements.shape
    own, slope = np.empty(3), np.empty((3, 3))
    for e in range(m):
        for q in range(len(factors)):
            for i in range(3):
                for j in range(3):
                    slope[i, j] = 0.0
            for a in range(width):
                for j in range(3):
                    own[j] = factors[q, a, 0] * gradients[e, corners[a, 0], j]
                    if corners[a, 1] >= 0:
                        own[j] += factors[q, a, 1] * gradients[e, corners[a, 1], j]
                for i in range(3):
                    for j in range(3):
                        slope[i, j] += displacement[elements[e, a], i] * own[j]
            for i in range(3):
                out[e, q, i] = slope[i, i]
            out[e, q, 3] = (slope[0, 1] + slope[1, 0]) / 2
            out[e, q, 4] = (slope[1, 2] + slope[2, 1]) / 2
            out[e, q, 5] = (slope[0, 2] + slope[2, 0]) / 2


def stresses(strain: Floats, young: Floats, poisson: Floats) -> Floats:
    """Hooke's law: the stresses MPa of strains (..., 6), with moduli that broadcast to (...)."""
    mu = young / (2 * (1 + poisson))
    lam = 2 * mu * poisson / (1 - 2 * poisson)
    out = 2 * mu[..., None] * strain
    out[..., :3] += (lam * strain[..., :3].sum(axis=-1))[..., None]
    return out


def strains_of(stress: Floats, young: Floats, poisson: Floats) -> Floats:
    """Hooke's law the other way round."""
    out = (1 + poisson)[..., None] / young[..., None] * stress
    out[..., :3] -= (poisson / young * stress[..., :3].sum(axis=-1))[..., None]
    return out


def von_mises(stress: Floats) -> Floats:
    """The equivalent stress (...) MPa of von Mises of stresses (..., 6).

    >>> import numpy as np
    >>> von_mises(np.array([[100.0, 0, 0, 0, 0, 0]]))
    array([100.])
    """
    x, y, z, xy, yz, xz = np.moveaxis(stress, -1, 0)
    squares = (x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2 + 6 * (xy**2 + yz**2 + xz**2)
    return np.asarray(np.sqrt(squares / 2))


def principal(stress: Floats) -> tuple[Floats, Floats]:
    """The principal values (n, 3), largest first, and their directions (n, 3, 3), one a row: unit vectors,
    right-handed, signs as in
    `porelang.ops.principal`.
    """
    from porelang.ops.principal import principal as found

    results = np.stack(found(*np.moveaxis(stress, -1, 0)), axis=-1)
    return results[..., :3], results[..., 3:].reshape(*stress.shape[:-1], 3, 3)


def energy_density(stress: Floats, young: Floats, poisson: Floats) -> Floats:
    """The strain energy (...) N mm/mm3 that goes with stresses (..., 6)."""
    squares = (stress**2 * TWICE).sum(axis=-1)
    trace = stress[..., :3].sum(axis=-1)
    return np.asarray(((1 + poisson) * squares - poisson * trace**2) / (2 * young))
