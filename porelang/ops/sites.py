"""Random sites, one in each cell of size 1, and what is nearest among them: cellular noise, and the cells of foams.

A site lies anywhere in its cell where the jitter is 1, in its middle where it is 0. The cell of a site, in the sense of
Voronoi, is what is nearer to it than to any other; its walls lie half way between two sites. The distance from the
nearest wall, min over j of (|r_j|^2 - |r_1|^2) / (2 |r_j - r_1|), is exact, unlike half of F2 - F1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from porelang.interval import Array, Interval, Mask
from porelang.ir import ONE, ZERO, Node, node
from porelang.ops.points import FARTHEST, places

Values = NDArray[Any]
#: The distances from the three nearest sites and from the nearest wall; the gradients of each, which are unit vectors
#: away from the sites and from the wall; a random number (0..1) of the nearest site.
RESULTS = ("f1", "f2", "f3", "wall", *(a + k for k in ("1", "2", "3", "w") for a in "xyz"), "number")
_AT = {"f1": "1", "f2": "2", "f3": "3", "wall": "w"}
_WALLS = frozenset({"wall", "xw", "yw", "zw"})
#: No place is farther from the third site than this, whatever the jitter.
MOST = 2.5
#: Of float32.
EPSILON = 2.0**-23
#: Errors of distances in epsilons, measured 2.6 and 5.6 (walls); a unit vector turns by as much over the distance.
OF_DISTANCE, OF_WALL, OF_LENGTH = 5.0, 10.0, 4.0


def sites(x: Any, y: Any, z: Any, seed: Any, jitter: Any, wanted: Sequence[str] = RESULTS) -> tuple[Values, ...]:
    """The wanted results (in the order of RESULTS) at places in cells; none beyond 2^23 cells."""
    from porelang.ops import site_loops as loops

    at, shape = places(x, y, z, seed, jitter)
    out = np.empty((len(RESULTS), at.shape[1]))
    loops.sites(at.astype(np.float64, copy=False), not _WALLS.isdisjoint(wanted), False, out)
    return tuple(out[RESULTS.index(name)].astype(at.dtype, copy=False).reshape(shape)[()] for name in wanted)


def slopes(x: Node, y: Node, z: Node, seed: Node, jitter: Node, f: Node) -> tuple[Node | None, ...]:
    """The derivatives by x, y, z: of a distance its unit vector n, of that (1 - n n) / distance; walls are planes."""

    def result(name: str) -> Node:
        return node("sites", x, y, z, seed, jitter, value=name)

    name = str(f.value)
    if name in _AT:
        return (*(result(a + _AT[name]) for a in "xyz"), None, None)
    if name == "number" or name[1] == "w":
        return (None,) * 5
    which, k = name[1], "xyz".index(name[0])
    distance, n = result("f" + which), [result(a + which) for a in "xyz"]
    away = node("lt", ZERO, distance)
    turns = [node("select", away, ((ONE if i == k else ZERO) - n[i] * n[k]) / distance, ZERO) for i in range(3)]
    return (*turns, None, None)


# ---- bounds ----------------------------------------------------------------------------------------------------------
_DISTANCE, _VECTOR, _NUMBER = (0.0, MOST), (-1.0, 1.0), (0.0, 1.0)


def enclose(*asked: Any) -> tuple[Interval, ...]:
    """Ranges over boxes: no distance changes by more than the place does (all are Lipschitz with 1)."""
    *place, wanted = asked
    over = _over(place)
    vectors = any(name not in _AT for name in wanted)
    values = _values(over, not _WALLS.isdisjoint(wanted) or vectors, vectors)
    out = []
    for name in wanted:
        (least, most), reach, loose = _DISTANCE, over.reach, over.wide
        if name == "number":
            (least, most), reach, loose = _NUMBER, 0.0 * reach, _leaps(over, values, name)
        elif name not in _AT:
            (least, most), reach, loose = _VECTOR, _turn(over, values, name), _leaps(over, values, name)
        lo, hi = np.maximum(values[name] - reach, least), np.minimum(values[name] + reach, most)
        lo, hi = np.where(loose, least, lo), np.where(loose, most, hi)
        out.append(Interval(np.where(over.none, np.inf, lo), np.where(over.none, -np.inf, hi), over.nan))
    return tuple(out)


def jumps(*asked: Any) -> tuple[Mask, ...]:
    """Over which boxes each result may jump: unit vectors and numbers where sites are as near as each other."""
    *place, wanted = asked
    over = _over(place)
    values = _values(over, True, True) if any(name not in _AT for name in wanted) else {}
    return tuple(over.several if name in _AT else _leaps(over, values, name) for name in wanted)


def rounding(*asked: Any) -> tuple[Array, ...]:
    """How far evaluation may be from the exact results, in units of the type's epsilon.

    Sites are exact. The place in its cell is off by half an epsilon, the vector to a site by one more, its length by
    1.5 more; a wall's distance is the product of the vector to the middle between two sites with a unit vector. A
    vector that is off by e turns by e over its length.
    """
    *place, wanted = asked
    over = _over(place)
    turning = [name for name in wanted if name not in _AT and name != "number" and name[1] != "w"]
    values = _values(over, False, False) if turning else {}
    found = []
    for name in wanted:
        if name in turning:
            least = values["f" + name[1]] - over.reach
            with np.errstate(all="ignore"):
                turned = 2 * OF_DISTANCE / least + OF_LENGTH
            found.append(np.where((least > 0) & (turned * EPSILON < 0.1), turned, np.inf))
        else:
            constant = {"wall": OF_WALL, "number": 0.0}.get(name, OF_DISTANCE if name in _AT else OF_LENGTH)
            found.append(np.full(over.shape, constant))
    return tuple(found)


class _Over(NamedTuple):
    """Boxes: their middles with the seed and the jitter (5, n), how far they reach, whether they are of several seeds
    or jitters, whether nothing is known, whether they may hold no place, and whether they are empty."""

    at: Array
    reach: Array
    several: Mask
    wide: Mask
    nan: Mask
    none: Mask
    shape: tuple[int, ...]


def _over(place: Sequence[Interval]) -> _Over:
    shape = np.broadcast_shapes(*(np.shape(r.lo) for r in place))
    lo, hi = ([np.broadcast_to(v, shape) for v in ends] for ends in ([r.lo for r in place], [r.hi for r in place]))
    none, nan = np.zeros(shape, np.bool_), ~((lo[4] >= 0) & (hi[4] <= 1))
    for r in place:
        none = none | r.empty
        nan = nan | r.nan | ~(np.maximum(np.abs(r.lo), np.abs(r.hi)) < FARTHEST)
    several = (np.floor(lo[3]) != np.floor(hi[3])) | (np.rint(256 * lo[4]) != np.rint(256 * hi[4]))
    with np.errstate(all="ignore"):
        reach = np.sqrt(sum(((hi[a] - lo[a]) / 2) ** 2 for a in range(3))) * (1 + 1e-14) + 1e-14
        wide = several | nan | ~(reach < MOST)
        middle = [np.where(wide, np.nan, lo[a] / 2 + hi[a] / 2) for a in range(3)]
    at, _ = places(*middle, np.where(wide, 0.0, lo[3]), np.where(wide, 0.0, lo[4]))
    return _Over(at, np.asarray(reach), several, wide, nan, none, shape)


def _values(over: _Over, walls: bool, margins: bool) -> dict[str, Array]:
    """The results at the middles of boxes, and with `margins` the distances of the fourth site and the second wall."""
    from porelang.ops import site_loops as loops

    found = np.empty((len(RESULTS) + 2, over.at.shape[1]))
    loops.sites(over.at, walls, margins, found)
    return {name: row.reshape(over.shape) for name, row in zip((*RESULTS, "f4", "wall2"), found, strict=True)}


def _leaps(over: _Over, v: dict[str, Array], name: str) -> Mask:
    """Where the site or the wall that a vector or a number is of may be another one within the box, or in it."""
    slack = 2 * over.reach + 2 * OF_WALL * EPSILON
    with np.errstate(invalid="ignore"):
        same = v["f2"] - v["f1"] > slack
        if name != "number" and name[1] == "w":
            same = same & (v["wall2"] - v["wall"] > slack)
        elif name != "number":
            k = int(name[1])
            same = (v[f"f{k + 1}"] - v[f"f{k}"] > slack) & (v[f"f{k}"] > slack)
            same = same & (v[f"f{k}"] - v[f"f{k - 1}"] > slack) if k > 1 else same
    return np.asarray(over.wide | ~same)


def _turn(over: _Over, v: dict[str, Array], name: str) -> Array:
    """By how much a unit vector changes within the box: twice the way over the distance; a wall's not at all."""
    if name[1] == "w":
        return np.full(over.shape, 1e-14)
    with np.errstate(all="ignore"):
        return np.asarray(2 * over.reach / np.maximum(v["f" + name[1]] - over.reach, 0.0))
