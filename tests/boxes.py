"""Meshes for tests of elasticity: boxes of cubes in six tetrahedra each, bent into cylinders and shells."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from porelang.tet.tetmesh import TetMesh

Floats = NDArray[np.float64]


def mesh_of(points: Floats, tets: NDArray[np.int64]) -> TetMesh:
    """A mesh of all that, each tetrahedron turned so that its volume is positive."""
    corners = points[tets]
    inside_out = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    tets[inside_out] = tets[inside_out][:, [1, 0, 2, 3]]
    return TetMesh(points, tets.astype(np.int32), np.zeros(len(tets), np.int8))


def box(
    cells: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    bend: Callable[[Floats], Floats] | None = None,
    jitter: float = 0.0,
) -> TetMesh:
    """A box from the origin; `bend` moves its points, `jitter` those within, by a part of a cell."""
    nx, ny, nz = cells
    axes = [np.linspace(0, s, k + 1) for s, k in zip(size, cells, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corners = np.stack([number[i : nx + i, j : ny + j, k : nz + k].ravel()
                        for i in (0, 1) for j in (0, 1) for k in (0, 1)], axis=1)  # fmt: skip
    tets = np.concatenate([corners[:, np.cumsum((0, *steps))] for steps in permutations((4, 2, 1))])
    if jitter:
        inner = ((points > 1e-9) & (points < np.array(size) - 1e-9)).all(axis=1)
        moves = np.random.default_rng(3).uniform(-jitter, jitter, points.shape) * np.array(size) / cells
        points = points + moves * inner[:, None]
    return mesh_of(points if bend is None else bend(points), tets)


def cylinder(radius: float, height: float, across: int, along: int) -> TetMesh:
    """A prism on a disc, along z from 0: a square pressed into a circle."""

    def bend(p: Floats) -> Floats:
        q = p[:, :2]
        longest = np.abs(q).max(axis=1)
        length = np.linalg.norm(q, axis=1)
        return np.column_stack([q * (longest / np.where(length > 0, length, 1.0))[:, None], p[:, 2]])

    return box((across, across, along), (2 * radius, 2 * radius, height), lambda p: bend(p - [radius, radius, 0.0]))


def octant(inner: float, outer: float, across: int, along: int, grade: float = 1.0) -> TetMesh:
    """An eighth of a shell between two spheres round the origin: three patches of cubes, radii in a geometric row."""
    meshes = []
    ratio = np.log(outer / inner)
    for axis in range(3):

        def bend(p: Floats, axis: int = axis) -> Floats:
            # a third of the octant: where coordinate `axis` is the largest of the three, in plane a + b + c = 1
            third = np.full(3, 1 / 3)
            e, f, g = np.eye(3)[[axis, (axis + 1) % 3, (axis + 2) % 3]]
            u, v = p[:, :1], p[:, 1:2]
            flat = (1 - u) * (1 - v) * e + u * (1 - v) * (e + f) / 2 + (1 - u) * v * (e + g) / 2 + u * v * third
            radius = inner * np.exp(ratio * p[:, 2:] ** grade)
            return flat / np.linalg.norm(flat, axis=1, keepdims=True) * radius

        meshes.append(box((across, across, along), bend=bend))
    points = np.concatenate([m.vertices for m in meshes])
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    _, first, same = np.unique(np.round(points, 7), axis=0, return_index=True, return_inverse=True)
    tets = np.concatenate([same.ravel()[m.tets + s] for m, s in zip(meshes, starts[:-1], strict=True)])
    return mesh_of(points[first], tets)
