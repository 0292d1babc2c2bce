"""A mesh of 100,000 triangles as a field of 128^3 samples, against libigl asked for every sample, in seconds."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import igl
import numpy as np
import trimesh
from timing import in_turn

from porelang import store
from porelang.data import SampledField
from porelang.tasks import datafile
from porelang.tasks.shape import read_shape

TRIANGLES, NODES = 100_000, 128
OURS = "mesh to field, from file to samples"


def shapes(rounds: int) -> list[dict[str, Any]]:
    """Each case, with how long it takes as a ratio to ours."""
    body = bumpy(TRIANGLES)
    corners, faces = np.array(body.vertices), np.array(body.faces, np.int64)
    longest = float(np.ptp(corners, axis=0).max())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "body.stl"
        body.export(path)

        def ours() -> SampledField:
            datafile.forget()
            store.forget()
            store.clear()
            return read_shape(str(path), error=longest / (NODES - 1), margin=0.06 * longest)

        kept = os.environ.get("PORELANG_CACHE")
        os.environ["PORELANG_CACHE"] = str(Path(folder) / "cache")  # what a run before has kept is no measure
        field = ours()
        axes = [o + h * np.arange(n) for o, h, n in zip(field.origin, field.spacing, field.shape, strict=True)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

        def theirs(kind: Any) -> Any:
            return lambda: igl.signed_distance(nodes, corners, faces, sign_type=kind)[0]

        kinds = igl.SignedDistanceType
        cases = {
            OURS: ours,
            "igl.signed_distance, winding number": theirs(kinds.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER),
            "igl.signed_distance, pseudonormal": theirs(kinds.SIGNED_DISTANCE_TYPE_PSEUDONORMAL),
        }
        try:
            times = in_turn(cases, rounds)
        finally:
            os.environ.pop("PORELANG_CACHE")
            if kept is not None:
                os.environ["PORELANG_CACHE"] = kept
    size = " x ".join(map(str, field.shape))
    return [
        {"case": name, "samples": size, "seconds": t.wall, "/ ours": t.wall / times[OURS].wall}
        for name, t in times.items()
    ]


def bumpy(triangles: int) -> trimesh.Trimesh:
    """A ball with bumps, of about so many triangles."""
    rings = round((triangles / 4) ** 0.5)
    around, down = np.meshgrid(
        np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False), np.linspace(0, np.pi, rings + 1)[1:-1], indexing="ij"
    )
    radius = 20 * (1 + 0.05 * np.sin(7 * around) * np.sin(5 * down))
    flat = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=-1)
    points = (radius[..., None] * flat).reshape(-1, 3)
    a = np.arange(len(points)).reshape(around.shape)
    b = np.roll(a, -1, axis=0)
    squares = [(a[:, :-1], a[:, 1:], b[:, 1:]), (a[:, :-1], b[:, 1:], b[:, :-1])]
    faces = [np.stack([corner.ravel() for corner in corners], axis=1) for corners in squares]
    for pole, ring in ((0, 0), (1, -1)):
        sides = (a[:, ring], b[:, ring]) if pole == 0 else (b[:, ring], a[:, ring])
        faces.append(np.stack([np.full(len(a), len(points) + pole), *sides], axis=1))
    return trimesh.Trimesh(np.concatenate([points, [[0, 0, 20], [0, 0, -20]]]), np.concatenate(faces), process=False)
