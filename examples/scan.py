"""Make grip.ply as a scanner would: python examples/scan.py

A grip that was pressed into shape by hand, stood on a table and scanned: its surface is noisy, its foot was never seen,
nor were some places in its dents, and triangles are of any size.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

import porelang

#: What was scanned: a knob on a stem, with four dents where fingers lie.
GRIP = """
let knob = translate(ellipsoid([27mm, 21mm, 17mm]), [0, 4mm, 74mm])
let stem = capsule([0, 0, -10mm], [0, 2mm, 70mm], 15mm)
let fingers = [for i in range(4): translate(ellipsoid([16mm, 8mm, 8.5mm]), [0, -18mm, 13mm + 14.5mm * i])]
out part = smooth_difference(smooth_union(knob, stem, 12mm), union(fingers), 5mm) & plane([0, 0, -1])
"""
NOISE = 0.06  # mm, of a place that is measured, along its normal
UNSEEN = [([9.0, -15.0, 34.0], 3.0), ([-10.0, -14.5, 49.0], 4.0), ([25.0, 4.0, 71.0], 2.0)]  # places and radii, mm


def scan() -> trimesh.Trimesh:
    random = np.random.default_rng(9)
    body = porelang.compile(GRIP).mesh(voxel="1.1mm", simplify="0.012mm")
    corners = body.vertices + body.vertex_normals * random.normal(0, NOISE, (len(body.vertices), 1))
    seen = body.triangles_center[:, 2] > 0.4
    for place, radius in UNSEEN:
        seen &= np.linalg.norm(body.triangles_center - place, axis=1) > radius * random.uniform(0.8, 1.2, len(seen))
    found = trimesh.Trimesh(corners.astype(np.float32), body.faces[seen], process=False)
    found.remove_unreferenced_vertices()
    return found


if __name__ == "__main__":
    scan().export(Path(__file__).parent / "grip.ply", vertex_normal=False)
