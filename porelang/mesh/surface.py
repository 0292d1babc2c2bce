"""A closed surface of triangles, what it encloses, and what could be wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from porelang.mesh import topology

if TYPE_CHECKING:
    import trimesh

#: What becomes of places (n, 3) in a file.
Stored = Callable[[NDArray[np.float64]], NDArray[Any]]
AT_ONCE = 2**15  # triangles worked on together, so that they stay in the cache


@dataclass(frozen=True, eq=False)
class Pieces:
    """The surfaces of a mesh that are not joined: the number of the piece that each vertex (n,) is on, and of each
    piece the volume that it encloses (mm3; negative: a void in the solid), the corners of its box (mm), and its
    triangles."""

    label: NDArray[np.int32]
    volume: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    triangles: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surface:
    """`vertices` (n, 3) float64 in mm and `faces` (m, 3), counter-clockwise seen from outside."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]

    @cached_property
    def volume(self) -> float:
        """The enclosed volume, mm3: negative if the surface is inside out."""
        middle = self.vertices.mean(axis=0)
        return sum(
            float(np.einsum("ij,ij->", self.vertices[faces[:, 0]] - middle, _normals(self.vertices, faces)))
            for faces in self._pieces()
        ) / 6  # fmt: skip

    @cached_property
    def area(self) -> float:
        """The area of the surface, mm2."""
        return sum(float(np.linalg.norm(_normals(self.vertices, f), axis=1).sum()) for f in self._pieces()) / 2

    @cached_property
    def euler(self) -> int:
        """Vertices - edges + triangles: 2 (components - handles) for a closed surface."""
        return self._used() - len(self.faces) // 2

    @cached_property
    def components(self) -> int:
        """The number of surfaces that are not joined: each island and each closed cavity is one."""
        return len(self.pieces.volume)

    @cached_property
    def pieces(self) -> Pieces:
        """The surfaces that are not joined, one by one."""
        faces = np.ascontiguousarray(self.faces, np.int32)
        label, count = topology.components(faces, len(self.vertices))
        return Pieces(label, *topology.sums(self.vertices, faces, label, count))

    def without(self, gone: NDArray[np.bool_]) -> Surface:
        """The surface without the pieces that are `gone`, in the order of `pieces`; this one is used up, its arrays
        packed."""
        kept = np.append(~gone, False)[self.pieces.label]  # the last for vertices of no piece
        number = np.cumsum(kept, dtype=np.int32) - 1
        m = _pack(self.faces, lambda rows: kept[rows[:, 0]], lambda rows: number[rows])
        at = iter(range(0, len(kept), AT_ONCE))
        n = _pack(self.vertices, lambda rows: kept[(i := next(at)) : i + len(rows)], lambda rows: rows)
        return Surface(self.vertices[:n], self.faces[:m])

    def normals(self) -> NDArray[np.float64]:
        """The outward normal of each triangle, (m, 3), as long as twice its area, mm2."""
        return np.concatenate([np.zeros((0, 3)), *(_normals(self.vertices, faces) for faces in self._pieces())])

    def _pieces(self) -> Iterator[NDArray[np.int32]]:
        return (self.faces[i : i + AT_ONCE] for i in range(0, len(self.faces), AT_ONCE))

    def areas(self) -> NDArray[np.float64]:
        """The area of each triangle, (m,), mm2."""
        normals = self.normals()
        areas: NDArray[np.float64] = np.sqrt(np.einsum("ij,ij->i", normals, normals)) / 2
        return areas

    def rounded(self, scale: float = 1.0) -> Surface:
        """The same surface, scaled, with its vertices rounded to float32, as a binary STL or glTF file stores them."""
        return Surface((scale * self.vertices).astype(np.float32).astype(np.float64), self.faces)

    def check(self) -> list[str]:
        """What keeps this from being a closed, outward-facing surface; empty if it is sound."""
        if not len(self.faces):
            return ["it has no triangles"]
        if self.faces.min() < 0 or self.faces.max() >= len(self.vertices):
            return ["a triangle names a vertex that does not exist"]
        defects = self.check_vertices()
        repeated, unmatched, fans = topology.joints(np.ascontiguousarray(self.faces, np.int32), len(self.vertices))
        if repeated:
            defects.append(f"{repeated} edges have two triangles on the same side")
        if unmatched:
            defects.append(f"{unmatched} edges have no triangle on one side")
        if not repeated and not unmatched and fans != self._used():
            defects.append(f"the surface touches itself at {fans - self._used()} vertices")
        if self.volume <= 0:
            defects.append(f"it is inside out (its volume is {self.volume:g} mm3)")
        return defects

    def check_vertices(self, stored: Stored | None = None) -> list[str]:
        """The defects that lie in where the vertices are, as `stored` in a file, not in how they are joined."""
        places: NDArray[Any] = self.vertices
        if stored is not None:
            places = np.empty((len(places), 3), stored(self.vertices[:1]).dtype)
        for i in range(0, len(places), AT_ONCE):
            rows = self.vertices[i : i + AT_ONCE]
            if not np.isfinite(rows).all():
                return ["a vertex is not a number"]
            if stored is not None:
                places[i : i + AT_ONCE] = stored(rows)
        defects = []
        flat = sum(int((~_normals(places, faces).any(axis=1)).sum()) for faces in self._pieces())
        if flat:
            defects.append(f"{flat} triangles have no area")
        same = len(places) - _distinct(places)
        if same:
            defects.append(f"{same} vertices lie exactly on another")
        return defects

    def _used(self) -> int:
        """The number of vertices that triangles name."""
        used = np.zeros(len(self.vertices), np.bool_)
        used[self.faces] = True
        return int(used.sum())

    def to_trimesh(self) -> trimesh.Trimesh:
        """The same surface as a `trimesh.Trimesh`, vertices and faces in the same order."""
        import trimesh  # takes 0.7 s: only who asks for it waits for it

        return trimesh.Trimesh(self.vertices, self.faces, process=False)


def single(scale: float) -> Stored:
    """Places scaled, then rounded to float32."""
    return lambda rows: (scale * rows).astype(np.float32)


def decimal(digits: int) -> Stored:
    """Places rounded to so many decimal digits."""

    def rounded(rows: NDArray[np.float64]) -> NDArray[np.float64]:
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = 10.0 ** (np.floor(np.log10(np.abs(rows))) + 1 - digits)
            return np.where(rows == 0, 0.0, np.rint(rows / unit) * unit)

    return rounded


def _normals(places: NDArray[np.floating[Any]], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """The normals of some triangles, twice as long as their areas."""
    corners = places.take(faces.T.ravel(), axis=0).astype(np.float64, copy=False).reshape(3, -1, 3)
    u, v = corners[1] - corners[0], corners[2] - corners[0]
    normals = np.empty((len(faces), 3))
    for n in range(3):
        j, k = (n + 1) % 3, (n + 2) % 3
        normals[:, n] = u[:, j] * v[:, k] - u[:, k] * v[:, j]
    return normals


def _pack(rows: NDArray[Any], stay: Callable[[NDArray[Any]], NDArray[np.bool_]], made: Callable[[Any], Any]) -> int:
    """Rows that stay, made anew, at the beginning of their own array; how many they are."""
    end = 0
    for i in range(0, len(rows), AT_ONCE):
        some = rows[i : i + AT_ONCE]
        some = made(some[stay(some)])
        rows[end : end + len(some)] = some
        end += len(some)
    return end


def _hashes(rows: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """A number for each place, the same for the same place."""
    bits = (rows.astype(np.float64) + 0.0).view(np.int64)  # -0 and 0 are one place
    mixed = bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64).view(np.int64)
    hashes: NDArray[np.int64] = np.bitwise_xor.reduce(mixed ^ mixed >> 29, axis=1)
    return hashes


def _distinct(places: NDArray[np.floating[Any]]) -> int:
    """The number of different places."""
    pieces = [slice(i, i + AT_ONCE) for i in range(0, len(places), AT_ONCE)]
    hashes = np.empty(len(places), np.int64)
    for piece in pieces:
        hashes[piece] = _hashes(places[piece])
    hashes.sort()
    twice = np.unique(hashes[:-1][hashes[1:] == hashes[:-1]])
    if not len(twice):
        return len(places)
    suspects = np.concatenate([places[piece][np.isin(_hashes(places[piece]), twice)] for piece in pieces])
    return len(places) - len(suspects) + len(np.unique(suspects + 0.0, axis=0))
