"""What the prelude promises, computed in float64 NumPy straight from the literature and from geometry.

Nothing here is taken from the `.pore` files: lattices are sums over cyclic permutations in radians, distances to shapes
are found from corners, edges and meridians, regular solids from the convex hull of their corners.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]
Lattice = Callable[[Array, Array, Array], Array]


# ---- lattices: functions of X, Y, Z in radians ----------------------------------------------------------------------


def cyclic(term: Lattice) -> Lattice:
    """term(x, y, z) + term(y, z, x) + term(z, x, y)."""
    return lambda x, y, z: term(x, y, z) + term(y, z, x) + term(z, x, y)


def c(x: Array, n: int = 1) -> Array:
    return np.cos(n * x)


def s(x: Array, n: int = 1) -> Array:
    return np.sin(n * x)


_c = cyclic(lambda x, y, z: c(x))
_c2 = cyclic(lambda x, y, z: c(x, 2))
_cc = cyclic(lambda x, y, z: c(x) * c(y))
_c2c2 = cyclic(lambda x, y, z: c(x, 2) * c(y, 2))
_s2cs = cyclic(lambda x, y, z: s(x, 2) * c(y) * s(z))
_s2s = cyclic(lambda x, y, z: s(x, 2) * s(y))
_s2c = cyclic(lambda x, y, z: s(x, 2) * c(z))


def _ccc(x: Array, y: Array, z: Array) -> Array:
    return c(x) * c(y) * c(z)


def _sss(x: Array, y: Array, z: Array) -> Array:
    return s(x) * s(y) * s(z)


def _c_d(x: Array, y: Array, z: Array) -> Array:
    return (
        np.cos(3 * x + y) * c(z) - np.sin(3 * x - y) * s(z) + np.cos(x + 3 * y) * c(z)
        + np.sin(x - 3 * y) * s(z) + np.cos(x - y) * c(z, 3) - np.sin(x + y) * s(z, 3)
    )  # fmt: skip


LATTICES: dict[str, Lattice] = {
    "gyroid": cyclic(lambda x, y, z: s(x) * c(y)),
    "schwarz_p": _c,
    "diamond": lambda x, y, z: _sss(x, y, z) + cyclic(lambda u, v, w: s(u) * c(v) * c(w))(x, y, z),
    "neovius": lambda *q: 3 * _c(*q) + 4 * _ccc(*q),
    "fischer_koch_s": cyclic(lambda x, y, z: c(x, 2) * s(y) * c(z)),
    "lidinoid": lambda *q: 0.5 * _s2cs(*q) - 0.5 * _c2c2(*q) + 0.15,
    "iwp": lambda *q: 2 * _cc(*q) - _c2(*q),
    "frd": lambda *q: 4 * _ccc(*q) - _c2c2(*q),
    "split_p": lambda *q: 1.1 * _s2cs(*q) - 0.2 * _c2c2(*q) - 0.4 * _c2(*q),
    "octo": lambda *q: 0.6 * _cc(*q) - 0.4 * _c(*q) + 0.25,
    "pmy": lambda *q: 2 * _ccc(*q) + _s2s(*q),
    "c_pmy": lambda *q: -2 * _ccc(*q) + _s2s(*q),
    "fischer_koch_y": lambda *q: _ccc(*q) + _sss(*q) + _s2s(*q) + _s2c(*q),
    "c_y": lambda *q: -_ccc(*q) - _sss(*q) + _s2s(*q) + _s2c(*q),
    "c_s": lambda *q: _c2(*q) + 2 * cyclic(lambda x, y, z: s(x, 3) * s(y, 2) * c(z) + s(x, 2) * c(y, 3) * s(z))(*q),
    "c_d": _c_d,
    "d_prime": lambda *q: (
        0.5 * _ccc(*q) + 0.5 * cyclic(lambda x, y, z: c(x) * s(y) * s(z))(*q)
        - 0.5 * cyclic(lambda x, y, z: s(x, 2) * s(y, 2))(*q) - 0.2
    ),
    "g_prime": lambda *q: _s2cs(*q) + 0.32,
    "karcher_k": lambda *q: 0.3 * _c(*q) + 0.3 * _cc(*q) - 0.4 * _c2(*q) + 0.2,
    "w_surface": cyclic(lambda x, y, z: c(x, 2) * c(y) - c(x) * c(y, 2)),
    "double_gyroid": lambda *q: 2.75 * _s2cs(*q) - _c2c2(*q),
    "double_diamond": lambda *q: 0.5 * cyclic(lambda x, y, z: s(x) * s(y))(*q) + 0.5 * _ccc(*q),
    "double_primitive": lambda *q: 0.5 * _cc(*q) + 0.2 * _c2(*q),
}  # fmt: skip

#: The reference tool's lattices, functions of pi p / w; the second term of its Lidinoid reads sin 2Y cos Z sin Y.
AXOLOTL: dict[str, Lattice] = {
    "gyroid": LATTICES["gyroid"],
    "schwarz_p": LATTICES["schwarz_p"],
    "diamond": LATTICES["diamond"],
    "fischer_koch": LATTICES["fischer_koch_s"],
    "lidinoid": lambda x, y, z: LATTICES["lidinoid"](x, y, z) + 0.5 * s(y, 2) * c(z) * (s(y) - s(x)),
    "neovius": LATTICES["neovius"],
}


def cell(n: int) -> tuple[Array, Array, Array]:
    """Sample places in one period, in radians, off every plane of symmetry."""
    axes = [(np.arange(n) + o) / n * math.tau for o in (0.37, 0.81, 0.13)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    return x, y, z


def gradient(f: Lattice, q: Array, h: float = 1e-4) -> Array:
    """The gradient (3, n) at points (3, n), by central differences of fourth order."""
    steps = np.eye(3)[:, :, None] * h
    return np.stack([(8 * (f(*(q + e)) - f(*(q - e))) - f(*(q + 2 * e)) + f(*(q - 2 * e))) / (12 * h) for e in steps])


def climb(f: Callable[[Array], Array], starts: Array, step: float) -> float:
    """The greatest value of f (points (3, n) to values (n,)) reached from the best of some starting points.

    A compass search: each point takes the best of its 26 neighbours, or halves its step. No derivatives, no library.
    """
    best = f(starts)
    q = starts[:, np.argsort(-best)[:12]]
    here, size = f(q), np.full(q.shape[1], step)
    ways = np.array([w for w in itertools.product((-1, 0, 1), repeat=3) if any(w)], dtype=float).T
    for _ in range(60):
        tried = q[:, :, None] + size[None, :, None] * ways[:, None, :]
        values = f(tried.reshape(3, -1)).reshape(q.shape[1], -1)
        pick = values.argmax(axis=1)
        value = values[np.arange(len(pick)), pick]
        better = value > here
        q = np.where(better, tried[:, np.arange(len(pick)), pick], q)
        here = np.where(better, value, here)
        size = np.where(better, size, size / 2)
    return float(here.max())


def value_range(f: Lattice) -> tuple[float, float]:
    """The least and greatest value of a lattice."""
    starts = np.stack([a.ravel() for a in cell(30)])
    return -climb(lambda q: -f(*q), starts, 0.1), climb(lambda q: f(*q), starts, 0.1)


def steepest(f: Lattice) -> float:
    """The largest length of the gradient."""
    starts = np.stack([a.ravel() for a in cell(18)])
    return climb(lambda q: np.linalg.norm(gradient(f, q), axis=0), starts, 0.1)


def solid_fraction(f: Lattice, n: int = 64) -> float:
    """The fraction of space where f < 0: each sample counts as a cube cut by the tangent plane, so the error is O(h^2).

    A plane at distance v/|g| cuts a cube of side h; the cut is smoothed over the cube's three extents h |g_i| by adding
    up 3^3 places in it.
    """
    q = np.stack([a.ravel() for a in cell(n)])
    values, slopes = f(*q), gradient(f, q) * (math.tau / n)
    places = (np.arange(3) + 0.5) / 3 - 0.5
    inside = 0.0
    for u in itertools.product(places, repeat=3):
        inside += float(np.mean(values + np.tensordot(u, slopes, 1) < 0))
    return inside / len(places) ** 3


# ---- distances ------------------------------------------------------------------------------------------------------


def to_segment(q: Array, a: Sequence[float], b: Sequence[float]) -> Array:
    """Distances of points (n, k) from the segment ab in k dimensions."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    along = end - start
    size = float(along @ along)
    t = np.zeros(len(q)) if size == 0 else np.clip((q - start) @ along / size, 0, 1)
    return np.asarray(np.linalg.norm(q - start - t[:, None] * along, axis=1))


def winding(q: Array, corners: Array) -> Array:
    """How often an outline in the plane runs round each of the points (n, 2): the angles it is seen under, added up."""
    turned = np.zeros(len(q))
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        u, v = a - q, b - q
        turned += np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], np.sum(u * v, axis=1))
    return np.rint(turned / math.tau)


def polygon(q: Array, corners: Sequence[Sequence[float]]) -> Array:
    """Signed distances of points (n, 2) from a polygon."""
    outline = np.asarray(corners, float)
    near = np.min([to_segment(q, a, b) for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True)], axis=0)
    return np.asarray(np.where(winding(q, outline) != 0, -near, near))


def meridian(points: Array, corners: Sequence[Sequence[float]]) -> Array:
    """Signed distances from a solid of revolution about z, given its half outline (rho, z) from axis to axis."""
    q = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=1)
    near = np.min([to_segment(q, a, b) for a, b in itertools.pairwise(corners)], axis=0)
    whole = np.array([*corners, *[(-r, z) for r, z in reversed(corners)]])
    return np.asarray(np.where(winding(q, whole) != 0, -near, near))


def box(points: Array, size: Sequence[float], radius: float = 0.0) -> Array:
    """Signed distances from a box whose edges are rounded: those from a smaller box, less the radius."""
    half = np.asarray(size) / 2 - radius
    outside = np.linalg.norm(points - np.clip(points, -half, half), axis=1)
    within = np.min(half - np.abs(points), axis=1)
    return np.asarray(np.where(outside > 0, outside, -within) - radius)


def over(profile: Array, heights: Array, h: float) -> Array:
    """Signed distances from a profile extruded to the height h, from those in the plane and the coordinates z."""
    above = np.maximum(np.abs(heights) - h / 2, 0)
    inside = np.minimum(-profile, h / 2 - np.abs(heights))
    return np.where(inside > 0, -inside, np.hypot(np.maximum(profile, 0), above))


G = (1 + math.sqrt(5)) / 2


def _signed(*corners: tuple[float, float, float]) -> Array:
    """All corners with all signs, and their cyclic permutations."""
    signs = list(itertools.product((-1, 1), repeat=3))
    turned = [np.roll(q, r) for q in corners for r in range(3)]
    return np.unique(np.round([np.array(sign) * q for q in turned for sign in signs], 15) + 0.0, axis=0)


#: The corners of the regular solids in some size, oriented as the prelude says.
SOLIDS: dict[str, Array] = {
    "tetrahedron": np.array([(1, 1, -1), (1, -1, 1), (-1, 1, 1), (-1, -1, -1)], float),
    "octahedron": _signed((1, 0, 0)),
    "dodecahedron": _signed((1, 1, 1), (1 / G, 0, G)),
    "icosahedron": _signed((0, 1, G)),
}


def faces(corners: Array) -> tuple[Array, Array]:
    """Unit normals (m, 3) of the convex hull's faces and their distances (m,) from the origin."""
    planes = ConvexHull(corners).equations
    return planes[:, :3], -planes[:, 3]


def regular(name: str, points: Array, inradius: float) -> Array:
    """The greatest of the signed distances from the face planes of a regular solid."""
    normals, distances = faces(SOLIDS[name])
    return np.asarray(np.max(points @ normals.T, axis=1) - inradius * distances[0] / distances.min())


def ellipsoid(points: Array, axes: Sequence[float]) -> Array:
    """True signed distances, by bisection for the multiplier of the nearest point, in the first octant."""
    a = np.asarray(axes, float)
    q = np.abs(points)
    inside = np.sum((q / a) ** 2, axis=1) < 1
    lo, hi = np.full(len(q), -(float(a.min()) ** 2)), np.full(len(q), 1e6)
    for _ in range(200):
        t = (lo + hi) / 2
        outer = np.sum((a * q / (t[:, None] + a**2)) ** 2, axis=1) > 1
        lo, hi = np.where(outer, t, lo), np.where(outer, hi, t)
    nearest = a**2 * q / (((lo + hi) / 2)[:, None] + a**2)
    far = np.linalg.norm(q - nearest, axis=1)
    return np.asarray(np.where(inside, -far, far))


def spheres(points: Array, centres: Array, r: float) -> Array:
    """Signed distances from a union of balls, from the outside."""
    return np.asarray(np.min(np.linalg.norm(points[:, None, :] - centres[None], axis=2), axis=1) - r)
