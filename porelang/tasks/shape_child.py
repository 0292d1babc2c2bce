"""The process that measures distances to a mesh: `python -m porelang.tasks.shape_child ENDING ERROR MARGIN IN OUT`.

libigl and the readers of mesh files are native code, or trust what a file claims: what they do to this process is no
harm to a program. IN and OUT are descriptors of files: the mesh, and an .npz of what was made of it. On standard output
stand lines `done total`. Standard input is a lifeline: when the parent ends, it closes.
"""

from __future__ import annotations

import io
import json
import os
import sys
import threading
from collections.abc import Iterator
from typing import Any

import igl
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from porelang.data import FARTHEST, NEAREST
from porelang.tasks.shape_file import UnusableError, check_count

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
#: Trilinear interpolation of what changes by 1 mm a mm errs by half a cell's diagonal at most, where nodes are exact.
HALF_DIAGONAL = 0.75**0.5
#: Cells on both sides of the surface at whose nodes the distance is exact.
BAND = 3.0
#: 512 MB of float32, and a few minutes.
MOST_NODES = 128_000_000
AT_ONCE = 1 << 19  # nodes between two looks at the parent
CHECKED = 4000  # nodes beyond the band at which its error is measured
METRE = 1000.0


def main(ending: str, error: float, margin: float, source: int, target: int) -> None:
    try:
        with os.fdopen(source, "rb") as file:
            vertices, faces = soup(io.BytesIO(file.read()), ending)
        found = distances(vertices, faces, error, margin)
    except UnusableError as reason:
        found = {"refused": np.array(json.dumps(reason.args))}
    with os.fdopen(target, "wb") as out:
        np.savez(out, allow_pickle=False, **found)


def soup(file: Any, ending: str) -> tuple[Points, Faces]:
    """The corners (n, 3) in mm and triangles (m, 3) of a file, corners at one place being one. Errors: UnusableError"""
    try:
        scene = trimesh.load_scene(file, file_type=ending[1:], process=False)
        mesh = scene.to_mesh()
        vertices, faces = np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64)
        unit = METRE if ending == ".glb" else 1.0  # glTF is in metres, by its standard
    except MemoryError:
        raise
    except Exception as error:  # readers of files that are damaged raise whatever they like
        text = " ".join(str(error).split())[:120] or type(error).__name__
        raise UnusableError("E140", f"is damaged or no {ending} file: {text}", "export it again") from None
    if faces.size == 0 or vertices.size == 0:
        raise UnusableError("E140", "holds no triangles", "export the part as a mesh of triangles")
    check_count(len(faces))
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise UnusableError("E140", f"is damaged: a triangle names corner {faces.max():,} of {len(vertices):,}",
                            "export it again")  # fmt: skip
    vertices = unit * vertices
    used = vertices[np.unique(faces)]
    if bad := int((~np.isfinite(used)).any(axis=1).sum()):
        raise UnusableError("E141", f"has {bad:,} corners that are no place: not a number, or infinite",
                            "export it again, or mend it where it was made")  # fmt: skip
    if (largest := float(np.abs(used).max())) > FARTHEST:
        raise UnusableError("E141", f"reaches to {largest:g} mm from the origin",
                            f"parts lie within {FARTHEST:,.0f} mm of it: lengths are in mm")  # fmt: skip
    places, numbers = np.unique(vertices + 0.0, axis=0, return_inverse=True)
    faces = numbers.reshape(-1)[faces]
    apart = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    if not apart.any():
        raise UnusableError("E140", "holds no triangles that have an area", "export it again")
    return places, np.ascontiguousarray(faces[apart], np.int64)


def rim(faces: Faces) -> Faces:
    """The directed edges (n, 2) which the triangles pass more often one way than the other: those of holes."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    lower = edges[:, 0] < edges[:, 1]
    pairs, numbers = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    passes = np.zeros(len(pairs), np.int64)
    np.add.at(passes, numbers.reshape(-1), np.where(lower, 1, -1))
    forth, back = np.repeat(pairs, np.maximum(passes, 0), axis=0), np.repeat(pairs, np.maximum(-passes, 0), axis=0)
    return np.concatenate([forth, back[:, ::-1]])


def turned_alike(faces: Faces) -> Faces:
    """The triangles, turned so that neighbours agree where two of them pass their common edge the same way."""
    edges = rim(faces)
    _, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return np.ascontiguousarray(igl.bfs_orient(faces)[0]) if (count > 1).any() else faces


def closed(vertices: Points, faces: Faces) -> tuple[Points, Faces, list[tuple[int, Points]]]:
    """A mesh with each hole closed by a fan of triangles from the middle of its rim, which is exact where it is flat.

    So sign and distance are of one surface, also across a hole. With it come each hole's number of edges and middle,
    the largest first.
    """
    edges = rim(faces)
    if not len(edges):
        return vertices, faces, []
    corners, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    linked = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (len(corners),) * 2)
    count, hole = connected_components(linked, directed=False)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    of_edge = hole[ends[:, 0]]
    halves = 0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]])
    whole = np.bincount(of_edge, lengths, count)
    middles = np.stack([np.bincount(of_edge, lengths * halves[:, k], count) / whole for k in range(3)], axis=1)
    fans = np.stack([edges[:, 1], edges[:, 0], len(vertices) + of_edge], axis=1)
    sizes = np.bincount(of_edge, minlength=count)
    order = np.argsort(-sizes, kind="stable")
    holes = [(int(sizes[i]), middles[i]) for i in order]
    return np.concatenate([vertices, middles]), np.concatenate([faces, fans]), holes


def distances(vertices: Points, faces: Faces, error: float, margin: float) -> dict[str, NDArray[Any]]:
    """Signed distances at the nodes of a grid over the box of a mesh and `margin` mm more; NaN for what is not given.

    The values (nx, ny, nz) are float32; `facts` are as `porelang.tasks.shape` tells them.
    """
    count = len(faces)
    vertices, faces, holes = closed(vertices, turned_alike(faces))
    lo, hi = vertices[faces].min(axis=(0, 1)), vertices[faces].max(axis=(0, 1))
    longest = float((hi - lo).max())
    if longest < NEAREST:
        raise UnusableError("E141", f"is {longest:g} mm long", "lengths are in mm: scale it where it was made")
    error = error if np.isfinite(error) else longest / 128
    margin = margin if np.isfinite(margin) else longest / 16
    h = error / HALF_DIAGONAL
    margin = max(margin, 2 * h)
    nodes = [int(np.ceil((b - a + 2 * margin) / h)) + 1 for a, b in zip(lo, hi, strict=True)]
    if (total := float(np.prod(np.array(nodes, float)))) > MOST_NODES:
        enough = 1.05 * error * (total / MOST_NODES) ** (1 / 3)
        raise UnusableError("E143", f"takes {total:.2g} samples for an error of {error:g} mm",
                            f"`error={enough:.2g}mm` would do, {MOST_NODES:,} are the most")  # fmt: skip
    origin = 0.5 * (lo + hi) - 0.5 * h * (np.array(nodes) - 1)
    axes = [o + h * np.arange(n) for o, n in zip(origin, nodes, strict=True)]
    values, beyond = sampled(vertices, faces, axes, h)
    if not (values < 0).any() and not encloses(vertices, faces):
        raise UnusableError("E142", "encloses nothing: it is a sheet, not a body", "close it, or give it a thickness")
    first = holes[0][1] if holes else np.zeros(3)
    opened = sum(n for n, _ in holes)
    facts = [count, opened, len(holes), *first, error, beyond, *lo, *hi]
    return {"values": values, "origin": origin, "spacing": np.array(h), "facts": np.array(facts, np.float64)}


def encloses(vertices: Points, faces: Faces) -> bool:
    """Whether a closed mesh holds a volume that is more than its rounding."""
    a, b, c = np.moveaxis(vertices[faces] - vertices[faces].mean(axis=(0, 1)), 1, 0)
    volume = abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6
    return volume > 1e-9 * float(np.ptp(vertices, axis=0).max()) ** 3


def sampled(vertices: Points, faces: Faces, axes: list[Points], h: float) -> tuple[NDArray[np.float32], float]:
    """Signed distances at the nodes of a grid, and by how much they err beyond the band, measured at some of them.

    The sign is that of the winding number (Barill et al., Fast winding numbers for soups and clouds, 2018), either way
    round. Near the surface the distance is exact. Beyond, it is that to the nearest place of the surface from the
    nearest node which is near.
    """
    shape = tuple(map(len, axes))
    near = close_by(vertices, faces, axes, h)
    places = np.argwhere(near)
    found = np.zeros(len(places))
    feet = np.zeros((len(places), 3))
    total = len(places) + near.size
    for i, some in pieces(len(places)):
        squares, _, foot = igl.point_mesh_squared_distance(nodes_at(axes, places[some]), vertices, faces)
        found[some], feet[some] = np.sqrt(squares), foot
        told(i, total)
    index = distance_transform_edt(~near, return_distances=False, return_indices=True)
    number = np.zeros(shape, np.int32)
    number[near] = np.arange(len(places))
    number = number[tuple(index)].reshape(-1)
    del index
    flat = np.empty(near.size)
    for i, some in pieces(near.size):
        here = nodes_at(axes, np.stack(np.unravel_index(np.arange(some.start, some.stop), shape), axis=1))
        flat[some] = np.linalg.norm(here - feet[number[some]], axis=1)
        told(len(places) + i, total)
    values = flat.reshape(shape)
    values[near] = found
    values[inside(vertices, faces, axes, near, places)] *= -1
    return values.astype(np.float32), checked(vertices, faces, axes, values, near)


def inside(
    vertices: Points, faces: Faces, axes: list[Points], near: NDArray[np.bool_], places: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which nodes the surface winds round. All of one region without nodes near it lie on one side of it."""
    regions, count = label(~near)
    _, first = np.unique(regions, return_index=True)
    asked = np.concatenate([places, np.stack(np.unravel_index(first, near.shape), axis=1)])
    winding = np.zeros(len(asked))
    for i, some in pieces(len(asked)):
        winding[some] = igl.fast_winding_number(vertices, faces, nodes_at(axes, asked[some]))
        told(i, len(asked))
    within = np.abs(winding) > 0.5
    of_region = np.zeros(count + 1, np.bool_)
    of_region[regions.reshape(-1)[first]] = within[len(places) :]
    found: NDArray[np.bool_] = of_region[regions]
    found[near] = within[: len(places)]
    return found


def close_by(vertices: Points, faces: Faces, axes: list[Points], h: float) -> NDArray[np.bool_]:
    """The nodes within BAND cells of the surface, and some more."""
    shape = tuple(map(len, axes))
    touched = np.zeros(shape, np.bool_)
    origin = np.array([a[0] for a in axes])
    corners = vertices[faces]
    while len(corners):  # triangles are halved along their longest sides until their samples leave no cell out
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        longest = sides.argmax(axis=1)
        small = sides.max(axis=1) <= h
        middle = corners[small].mean(axis=1)
        touched[tuple(np.rint((middle - origin) / h).astype(int).T)] = True
        corners, longest = corners[~small], longest[~small]
        row = np.arange(len(corners))
        a, b, c = (corners[row, (longest + k) % 3] for k in range(3))
        half = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, half, c], axis=1), np.stack([half, b, c], axis=1)])
        told(0, 1)
    # A sample lies within h / sqrt(3) of all of its triangle, and its node within half a diagonal of it.
    return np.asarray(distance_transform_edt(~touched) <= BAND + HALF_DIAGONAL + 3**-0.5)


def checked(vertices: Points, faces: Faces, axes: list[Points], values: Points, near: NDArray[np.bool_]) -> float:
    """The largest error of the distances at some nodes beyond the band."""
    far = np.flatnonzero(~near)
    if not len(far):
        return 0.0
    some = np.random.default_rng(1).choice(far, min(CHECKED, len(far)), replace=False)
    here = nodes_at(axes, np.stack(np.unravel_index(some, near.shape), axis=1))
    squares = igl.point_mesh_squared_distance(here, vertices, faces)[0]
    return float(np.abs(np.abs(values.reshape(-1)[some]) - np.sqrt(squares)).max())


def nodes_at(axes: list[Points], index: NDArray[Any]) -> Points:
    return np.ascontiguousarray(np.stack([a[index[:, k]] for k, a in enumerate(axes)], axis=1))


def pieces(count: int) -> Iterator[tuple[int, slice]]:
    for i in range(0, count, AT_ONCE):
        yield i, slice(i, min(i + AT_ONCE, count))


def told(done: int, total: int) -> None:
    print(done, total, flush=True)


def hold_lifeline() -> None:
    """End this process when the parent closes its standard input, which it does when it ends in whatever way."""

    def wait() -> None:
        os.read(0, 1)
        os._exit(0)

    threading.Thread(target=wait, daemon=True).start()


if __name__ == "__main__":
    hold_lifeline()
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5]))
