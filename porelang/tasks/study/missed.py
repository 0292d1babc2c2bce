"""What elements miss of a part, and what they hold beyond it: counted on the nodes of a grid, by place.

A signed sum of volumes, or of distances over the boundary of the elements, sees neither what is cut off altogether nor
that too much here and too little there do not make up for each other. Nor does a volume tell of a thin neck that is
cut: holes through a part do, of which elements then have fewer.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from porelang.compiled import compiled
from porelang.progress import tell
from porelang.solid import Solid
from porelang.tet.tetmesh import TetMesh, boundary, volumes

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: Nodes of the grid in the box of a part: so many for each element, no fewer than this and no more than that; and of a
#: slab of it that is asked at once.
_FOR_EACH, _FEWEST, _MOST, _AT_ONCE = 100, 100_000, 1_000_000, 200_000
#: Of an element and of the box of all, how far beyond that the part is looked for.
_MARGIN = 0.1
#: Where between the sides of the box nodes begin, in steps: in no plane in which parts or elements have faces.
_BESIDE = np.array([0.381966, 0.271828, 0.577216])
#: Nodes that lie so little outside of a tetrahedron, in barycentric coordinates, lie on a face of it.
_ON = 1e-12
#: So many standard deviations of a count are its error.
_SIGMAS = 3.0
#: So many of the elements that are nearest to a place before a face are asked whether they hold it.
_BESIDE_A_FACE = 16
#: What is wrong deeper than this share of an element, and deeper than so many steps, is no sag of a face.
_DEEP, _STEPS = 0.1, 1.5


@dataclass(frozen=True, slots=True)
class Missed:
    """What elements lack of a part, and what they hold `beyond` it (mm3, both together counted to `unsure`), of a
    `volume`; what they lack of `crumbs`, which hang on nothing, is counted by itself.

    `handles` is how many more or fewer holes run through the elements than through the part, whose own are `of`: as
    far as the grid can tell, and 0 where it cannot. `necks` are the sections that make them so, times the length of the
    part, as a share of its volume: of necks that the grid sees, and of cracks without width, which it does not. `lost`
    (n, 3) mm are places that are wrong by more than the sag of a face, or cracked, `deep` (mm3) is what hangs together
    with them; `at` is the middle of what is wrong most deeply.
    """

    lacking: float
    crumbs: float
    beyond: float
    unsure: float
    volume: float
    handles: int
    of: int
    necks: float
    lost: Floats
    deep: float
    at: tuple[float, float, float]

    @property
    def share(self) -> float:
        """Of the volume, what is wrong: too little and too much do not make up for each other."""
        return (self.lacking + self.beyond + self.unsure) / self.volume

    @property
    def off(self) -> float:
        """By which share the volume is wrong: that of a part counts its crumbs."""
        return (abs(self.lacking + self.crumbs - self.beyond) + self.unsure) / self.volume

    @property
    def section(self) -> float:
        """By which share the sections of a part are wrong: the sag of a face on one side makes up for that on another,
        what is lost or bridged makes up for nothing."""
        return self.off + self.deep / self.volume

    @property
    def unconnected(self) -> float:
        """Of what holds a part together, how much is cut, or bridged."""
        return min(1.0, self.handles / (1 + max(self.of, 0)))


def missed(part: Solid, mesh: TetMesh, size: float) -> Missed:
    """Compare elements of a size (mm) with the field that they stand for."""
    least, most = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = _MARGIN * (size + most - least)
    low = np.minimum(least, np.maximum(least - margin, part.lo))
    high = np.maximum(most, np.minimum(most + margin, part.hi))
    nodes = min(max(_FOR_EACH * len(mesh.tets), _FEWEST), _MOST)
    step = float((np.prod(high - low) / nodes) ** (1 / 3))
    counts = np.maximum(np.ceil((high - low) / step).astype(int), 8)
    spacing = (high - low) / counts
    axes = [lo + (np.arange(n) + b) * s for lo, n, s, b in zip(low, counts, spacing, _BESIDE, strict=True)]
    solid = _solid(part, axes)
    origin = np.array([axis[0] for axis in axes])
    held = _held(mesh, origin, spacing, solid.shape)
    piece = _largest(solid)
    lacking, beyond = piece & ~held, held & ~solid
    handles, of = _handles(mesh, piece)
    cut, area = _necks(piece, lacking | beyond, spacing) if handles else (np.zeros_like(piece), 0.0)
    open_, crack = _cracks(mesh, float(spacing.min()) / 8) if handles else (np.zeros((0, 3)), 0.0)
    deep = max(_DEEP * size, _STEPS * float(spacing.max()))
    lost, at, deepest = _deepest((lacking, beyond), deep, spacing, cut)
    lost, at = origin + lost * spacing, origin + at * spacing
    if crack > area:
        at = open_[0]
    cell, few, many = float(np.prod(spacing)), int(lacking.sum()), int(beyond.sum())
    crumbs = int((solid & ~held).sum()) - few
    # a web that lies along the axes has a step more or less; of what is bent that evens out
    unsure = _SIGMAS * cell * (few + many) ** 0.5 + area * float(spacing.max())
    x, y, z = (float(c) for c in at)
    volume = float(volumes(mesh).sum())
    return Missed(
        lacking=few * cell, crumbs=crumbs * cell, beyond=many * cell, unsure=unsure,
        volume=volume, handles=handles, of=of, necks=(area + crack) * float((most - least).max()) / volume,
        lost=np.concatenate([lost, open_]), deep=deepest * cell, at=(x, y, z),
    )  # fmt: skip


def _solid(part: Solid, axes: list[Floats]) -> Flags:
    """Which nodes of a grid are solid."""
    x, y, z = axes
    out = np.empty((len(x), len(y), len(z)), np.bool_)
    rows = max(1, _AT_ONCE // (len(y) * len(z)))
    for first in range(0, len(x), rows):
        tell(first, len(x))
        out[first : first + rows] = part.on([x[first : first + rows], y, z])
    return out


def _held(mesh: TetMesh, origin: Floats, spacing: Floats, shape: tuple[int, ...]) -> Flags:
    """Which nodes of a grid lie in elements."""
    out = np.zeros(shape, np.bool_)
    mark((mesh.vertices - origin) / spacing, mesh.tets, out)
    return out


def _deepest(wrong: tuple[Flags, Flags], deep: float, spacing: Floats, cut: Flags) -> tuple[Floats, Floats, int]:
    """The nodes (n, 3) that are wrong deeper than so many mm, or where something is `cut`, the one that is the deepest
    of these, and how many are wrong with them, no farther from one than that."""
    from scipy.ndimage import distance_transform_edt

    depths = [(one, distance_transform_edt(one, spacing)) for one in wrong if one.any()]
    if not depths:
        return np.zeros((0, 3)), np.zeros(3), 0
    among = [np.where(cut, depth, 0.0) if cut.any() else depth for _, depth in depths]
    deepest = max(among, key=lambda depth: float(depth.max()))
    found, count = [], 0
    for one, depth in depths:
        core = depth > deep
        found.append(np.argwhere(core | (one & cut)))
        around = distance_transform_edt(~core, spacing) <= deep if core.any() else core
        count += int((one & (around | cut)).sum())
    at = np.array(np.unravel_index(np.argmax(deepest), deepest.shape), np.float64)
    return np.concatenate(found).astype(np.float64), at, count


def _necks(piece: Flags, wrong: Flags, spacing: Floats) -> tuple[Flags, float]:
    """Which of the nodes that are wrong change how a part hangs together, as Euler's number of what lies around them
    tells; and the sections (mm2) of these necks in all: of a web or a strut of that volume and depth, at most."""
    from scipy.ndimage import distance_transform_edt, find_objects, label

    pieces, _ = label(wrong, np.ones((3, 3, 3)))
    depth = distance_transform_edt(wrong, spacing)
    cut, area = np.zeros_like(wrong), 0.0
    for n, box in enumerate(find_objects(pieces), 1):
        around = tuple(slice(max(0, side.start - 1), side.stop + 1) for side in box)
        mine = pieces[around] == n
        one, other = piece[around], piece[around] ^ mine
        if _both_euler(one) != _both_euler(other):
            cut[around] |= mine
            area += float(np.prod(spacing)) * int(mine.sum()) / (2 * float(depth[around][mine].max()))
    return cut, area


def _cracks(mesh: TetMesh, width: float) -> tuple[Floats, float]:
    """Where elements touch, or nearly (a width in mm), that are not joined: middles (n, 3) mm of the faces that look at
    another element, and the area (mm2) of one side of all. Where two shapes of a union end in one plane of cubes a mesh
    may be open, and no node of a grid lies in what has no width."""
    from scipy.spatial import cKDTree

    faces, _ = boundary(mesh)
    a, b, c = (mesh.vertices[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    twice = np.linalg.norm(normal, axis=1)
    middle = (a + b + c) / 3
    before = middle + width * normal / np.maximum(twice, 1e-300)[:, None]
    corners = mesh.vertices[mesh.tets]
    _, near = cKDTree(corners.mean(axis=1)).query(before, k=min(_BESIDE_A_FACE, len(corners)))
    facing = np.zeros(len(faces), np.bool_)
    for some in np.atleast_2d(near.T):  # each in turn is little to hold
        first = corners[some, 0]
        sides = np.swapaxes(corners[some, 1:] - first[:, None], 1, 2)
        share = np.linalg.solve(sides, (before - first)[..., None])[..., 0]
        facing |= (share.min(axis=1) >= 0) & (share.sum(axis=1) <= 1)
    return middle[facing], float(twice[facing].sum()) / 4


def _largest(solid: Flags) -> Flags:
    """The largest of the pieces of what is solid."""
    from scipy.ndimage import label

    pieces, count = label(solid)
    return solid if count <= 1 else np.asarray(pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:])))


def _handles(mesh: TetMesh, piece: Flags) -> tuple[int, int]:
    """By how many the holes through elements differ from those through the part, and how many that has.

    Both are 1 less Euler's number. A grid has two of the field: of nodes that hang together over faces, and over
    corners too. The truth lies between them, or what parts them is as thin as a step, and then nothing is said.
    """
    low, high = sorted(_both_euler(piece))
    own = euler(mesh)
    return max(0, own - high, low - own), max(1 - low, 1 - own)


def _both_euler(nodes: Flags) -> tuple[int, int]:
    """Euler's number of what hangs together over faces, and over corners too."""
    return _euler(nodes, np.logical_and), _euler(np.pad(nodes, 1), np.logical_or, -1)


def _euler(nodes: Flags, joined: np.ufunc, sign: int = 1) -> int:
    """Euler's number of the nodes of a grid: as points, with edges, squares and cubes where all of these are there; or
    (`logical_or`, with a layer of nothing around) as cubes, with faces, edges and corners where any of them is."""

    def pairs(of: Flags, axis: int) -> Flags:
        n = of.shape[axis]
        return np.asarray(joined(of.take(range(n - 1), axis), of.take(range(1, n), axis)))

    total = 0
    for dimension in range(4):
        for axes in combinations(range(3), dimension):
            total += (-1) ** dimension * int(np.count_nonzero(reduce(pairs, axes, nodes)))
    return sign * total


def euler(mesh: TetMesh) -> int:
    """Euler's number of a mesh: its pieces and closed voids less the holes through it."""
    corners = mesh.tets.astype(np.int64)
    counted = len(np.unique(corners)) - len(corners)
    for size, sign in ((2, -1), (3, 1)):
        some = np.sort(corners[:, list(combinations(range(4), size))].reshape(-1, size), axis=1)
        order = np.lexsort(some.T)
        counted += sign * (1 + int((np.diff(some[order], axis=0) != 0).any(axis=1).sum()))
    return counted


@compiled
def mark(points: Floats, tets: NDArray[np.int32], inside: Flags) -> None:
    """Mark the nodes of a grid that lie in tetrahedra of points (n, 3), which are in steps of it."""
    a, b, c, n = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for e in range(len(tets)):
        for i in range(3):
            base = points[tets[e, 0], i]
            least, most = base, base
            for k in range(1, 4):
                least, most = min(least, points[tets[e, k], i]), max(most, points[tets[e, k], i])
            low[i] = max(0, int(np.ceil(least)))
            high[i] = min(inside.shape[i] - 1, int(np.floor(most)))
            a[i] = points[tets[e, 1], i] - base
            b[i] = points[tets[e, 2], i] - base
            c[i] = points[tets[e, 3], i] - base
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            n[0, i] = b[j] * c[k] - b[k] * c[j]
            n[1, i] = c[j] * a[k] - c[k] * a[j]
            n[2, i] = a[j] * b[k] - a[k] * b[j]
        six = a[0] * n[0, 0] + a[1] * n[0, 1] + a[2] * n[0, 2]
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    u, v, w = x - points[tets[e, 0], 0], y - points[tets[e, 0], 1], z - points[tets[e, 0], 2]
                    p = n[0, 0] * u + n[0, 1] * v + n[0, 2] * w
                    q = n[1, 0] * u + n[1, 1] * v + n[1, 2] * w
                    r = n[2, 0] * u + n[2, 1] * v + n[2, 2] * w
                    if min(p, q, r) >= -_ON * six and p + q + r <= (1 + _ON) * six:
                        inside[x, y, z] = True
