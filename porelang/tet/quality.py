"""Whether a mesh of tetrahedra is sound, and how good it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.compiled import compiled
from porelang.tet.tetmesh import (
    CROWDED,
    Indices,
    TetMesh,
    boundary,
    dihedral_angles,
    interfaces,
    neighbours,
    volumes,
)

BINS = np.arange(0, 181, 10)


@dataclass(frozen=True, slots=True)
class Sound:
    """What keeps a mesh from being used, in counts: tetrahedra without a volume above 0; faces that belong to more than
    two; edges of the boundary with a triangle on one side alone; vertices that no tetrahedron has. And, which keeps
    none from it, edges (k, 2) at which the solid touches itself, as where two bodies meet in a line."""

    flat: int
    crowded: int
    open: int
    unused: int
    touching: Indices

    @property
    def faults(self) -> list[str]:
        """What is wrong, in words; [] of a sound mesh."""
        told = [
            (self.flat, "tetrahedra have no volume or are turned over"),
            (self.crowded, "faces belong to more than two tetrahedra"),
            (self.open, "edges of the boundary have no triangle on one side"),
            (self.unused, "vertices belong to no tetrahedron"),
        ]
        return [f"{count:,} {what}" for count, what in told if count]


def sound(mesh: TetMesh, beside: Indices | None = None) -> Sound:
    """Look a mesh over: that all volumes are positive, that it conforms, and that its boundary is closed."""
    beside = neighbours(mesh) if beside is None else beside
    triangles, owner = boundary(mesh, beside)
    open_, touching = _edges(triangles, len(mesh.vertices))
    if len(mesh.phases) > 1:
        outside = triangles[mesh.phase[owner] == 0]
        between, pair = interfaces(mesh, beside)
        _, touching = _edges(np.concatenate([outside, between[mesh.phase[pair[:, 0]] == 0]]), len(mesh.vertices))
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.tets] = True
    return Sound(int((~(volumes(mesh) > 0)).sum()), int((beside == CROWDED).sum()), open_, int((~used).sum()), touching)


def figures(mesh: TetMesh) -> dict[str, object]:
    """The figures of a report: `tets`, `vertices`, `volume` (mm3, of all phases, and of each in `volumes`), the
    smallest and largest dihedral angle in degrees, and `dihedral_histogram`, how many there are in every ten."""
    angles = dihedral_angles(mesh)
    counts, _ = np.histogram(angles, BINS)
    of = np.bincount(mesh.phase, volumes(mesh), len(mesh.phases))
    return {
        "tets": len(mesh.tets),
        "vertices": len(mesh.vertices),
        "volume": float(of.sum()),
        "volumes": dict(zip(mesh.phases, of.tolist(), strict=True)),
        "min_dihedral": float(angles.min()),
        "max_dihedral": float(angles.max()),
        "dihedral_histogram": counts.tolist(),
    }


@compiled
def _edges(triangles: Indices, count: int) -> tuple[int, Indices]:
    """How many edges have not as many triangles on one side as on the other, and those (k, 2) with more than a pair."""
    start = np.zeros(count + 1, np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            start[min(triangles[t, k], triangles[t, k - 1]) + 1] += 1
    for v in range(count):
        start[v + 1] += start[v]
    put = start[:-1].copy()
    most = np.empty(3 * len(triangles), np.int64)
    way = np.empty(3 * len(triangles), np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            a, b = triangles[t, k - 1], triangles[t, k]
            i = put[min(a, b)]
            put[min(a, b)] += 1
            most[i], way[i] = max(a, b), 1 if a < b else -1
    open_ = many_pairs = 0
    touching = np.empty((len(triangles), 2), np.int32)
    for v in range(count):
        for i in range(start[v], start[v + 1]):
            total, many, first = way[i], 1, True
            for j in range(start[v], start[v + 1]):
                if j != i and most[j] == most[i]:
                    first &= j > i
                    total += way[j]
                    many += 1
            if first:
                open_ += total != 0
                if many > 2:
                    touching[many_pairs, 0], touching[many_pairs, 1] = v, most[i]
                    many_pairs += 1
    return open_, touching[:many_pairs].copy()
