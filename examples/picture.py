"""A mesh as a picture, drawn with NumPy alone: python examples/picture.py out/specimen.stl out/specimen.png

A parallel projection, a depth buffer, two lights, and hollows darkened by how far they lie behind what is around them.
"""

from __future__ import annotations

import sys

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter, minimum_filter

HEIGHT = 1100  # pixels
FINER = 2  # the picture is drawn this many times larger and then averaged, so that edges are smooth
MARGIN = 0.06
TURN, LIFT = np.radians(35.0), np.radians(24.0)  # where the viewer stands: about z, above the horizon
KEY, FILL = np.array([-0.45, 0.62, 0.64]), np.array([0.75, -0.1, 0.65])  # lights, in the viewer's axes
PAPER, MATERIAL = np.array([0.975, 0.972, 0.965]), np.array([0.93, 0.80, 0.62])
FAR = np.uint64(2**64 - 1)


def viewed(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points in the viewer's axes: right, up, and toward the viewer."""
    out = np.array([np.cos(TURN) * np.cos(LIFT), np.sin(TURN) * np.cos(LIFT), np.sin(LIFT)])
    right = np.array([-np.sin(TURN), np.cos(TURN), 0.0])
    turned: NDArray[np.float64] = vertices @ np.stack([right, np.cross(out, right), out], axis=1)
    return turned


def nearest(corners: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.uint64]:
    """For each pixel, the depth (upper 32 bits) and the number (lower 32) of the triangle in front.

    `corners` (n, 3, 3) holds pixel coordinates and a depth between 0 (near) and 1. Triangles of about one size are
    drawn together: all of them at the first pixel of their frames, then at the second, and so on.
    """
    buffer = np.full(shape[0] * shape[1], FAR)
    low = np.floor(corners[:, :, :2].min(axis=1)).astype(np.int64)
    size = np.ceil(corners[:, :, :2].max(axis=1)).astype(np.int64) - low
    extent = size.max(axis=1)
    edges = np.unique(np.minimum(extent, 2 ** np.ceil(np.log2(np.maximum(extent, 1))).astype(np.int64)))
    before = -1
    for edge in edges:
        some = np.flatnonzero((extent > before) & (extent <= edge))
        before = edge
        (a, b, c), start = corners[some].transpose(1, 0, 2), low[some]
        u, v = (b - a)[:, :2], (c - a)[:, :2]
        area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / area
        for i in range(edge + 1):
            for j in range(edge + 1):
                x, y = start[:, 0] + i, start[:, 1] + j
                dx, dy = x + 0.5 - a[:, 0], y + 0.5 - a[:, 1]
                s, t = (dx * v[:, 1] - dy * v[:, 0]) * scale, (u[:, 0] * dy - u[:, 1] * dx) * scale
                hit = np.flatnonzero((s >= 0) & (t >= 0) & (s + t <= 1))
                depth = a[hit, 2] + s[hit] * (b - a)[hit, 2] + t[hit] * (c - a)[hit, 2]
                key = (np.clip(depth, 0, 1) * (2**32 - 1)).astype(np.uint64) << np.uint64(32) | some[hit].astype(
                    np.uint64
                )
                np.minimum.at(buffer, y[hit] * shape[1] + x[hit], key)
    return buffer.reshape(shape)


def shading(points: NDArray[np.float64], normals: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """A unit normal for each triangle: smooth, but the triangle's own where the surface has an edge."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
    smooth = normals[faces].mean(axis=1)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-30)
    bent = np.einsum("ij,ij->i", flat, smooth)[:, None] < 0.9
    out: NDArray[np.float64] = np.where(bent, flat, smooth)
    return out


def picture(mesh: trimesh.Trimesh) -> Image.Image:
    """The mesh seen from above and aside, on a light ground."""
    points, normals = viewed(mesh.vertices), viewed(mesh.vertex_normals)
    lo, hi = points.min(axis=0), points.max(axis=0)
    tall = HEIGHT * FINER
    scale = tall * (1 - 2 * MARGIN) / (hi[1] - lo[1])
    margin = MARGIN * tall
    wide = int((hi[0] - lo[0]) * scale + 2 * margin) // FINER * FINER
    pixels = np.column_stack([
        (points[:, 0] - lo[0]) * scale + margin,
        tall - margin - (points[:, 1] - lo[1]) * scale,
        (hi[2] - points[:, 2]) / (hi[2] - lo[2]) * 0.999,
    ])  # fmt: skip
    faces = mesh.faces[(normals[mesh.faces, 2].mean(axis=1) > -0.2)]
    front = nearest(pixels[faces], (tall, wide))
    hit = front != FAR
    depth = np.where(hit, (front >> np.uint64(32)) / 2**32, 1.0) * (hi[2] - lo[2])  # mm
    normal = shading(points, normals, faces)[(front[hit] & np.uint64(2**32 - 1)).astype(np.int64)]
    light = 0.34 + 0.62 * np.clip(normal @ (KEY / np.linalg.norm(KEY)), 0, 1)
    light += 0.22 * np.clip(normal @ (FILL / np.linalg.norm(FILL)), 0, 1)
    shade = np.ones((tall, wide))
    for radius, strength in ((4 * FINER, 0.05), (14 * FINER, 0.035), (40 * FINER, 0.012)):
        around = gaussian_filter(minimum_filter(depth, size=3), radius)
        shade *= np.exp(-strength * np.clip(depth - around, 0, 40))
    image = np.broadcast_to(PAPER, (tall, wide, 3)).copy()
    image[hit] = MATERIAL * (light * shade[hit])[:, None]
    image = image.reshape(tall // FINER, FINER, wide // FINER, FINER, 3).mean(axis=(1, 3))
    return Image.fromarray((255 * np.clip(image, 0, 1) ** (1 / 1.15)).astype(np.uint8))


if __name__ == "__main__":
    source, target = sys.argv[1:]
    picture(trimesh.load_mesh(source)).save(target)
    print(f"{target}\n  picture of {source}")
