"""Writes hole.vtu as a finite element program would: `python examples/hole.py`, with the package meshio.

A plate of 80 x 40 x 12 mm with a hole of 16 mm, pulled along x by 20 MPa: stresses at the nodes of its hexahedra, in
Pa, as many programs write them. They are those of a plate without end: E. G. Kirsch, Die Theorie der Elasticitaet und
die Beduerfnisse der Festigkeitslehre, 1898.
"""

from pathlib import Path

import meshio
import numpy as np

LENGTH, WIDTH, HEIGHT, RADIUS, PULL = 80.0, 40.0, 12.0, 8.0, 20e6
AROUND, OUTWARD, UP = 48, 9, 2


def mesh():
    """Points (n, 3) and hexahedra (m, 8), in rings from the hole to the rim."""
    angle = np.arange(AROUND) * 2 * np.pi / AROUND + np.pi / AROUND
    direction = np.stack([np.cos(angle), np.sin(angle)], -1)
    hole = RADIUS * direction
    rim = direction * np.min([LENGTH, WIDTH] / (2 * np.abs(direction)), axis=1)[:, None]
    for x, y in np.array(np.meshgrid([-1, 1], [-1, 1])).reshape(2, -1).T * [LENGTH / 2, WIDTH / 2]:
        rim[np.argmin(np.hypot(*(rim - [x, y]).T))] = [x, y]  # a node at each corner
    share = (np.arange(OUTWARD + 1) / OUTWARD)[:, None, None] ** 1.3  # finer at the hole
    plane = (hole + share * (rim - hole)).reshape(-1, 2)
    levels = np.linspace(-HEIGHT / 2, HEIGHT / 2, UP + 1)
    points = np.concatenate([np.column_stack([plane, np.full(len(plane), z)]) for z in levels])
    j, i, k = (a.ravel() for a in np.meshgrid(np.arange(OUTWARD), np.arange(AROUND), np.arange(UP), indexing="ij"))
    number = lambda j, i, k: (k * (OUTWARD + 1) + j) * AROUND + i % AROUND  # noqa: E731
    face = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return points, np.stack([number(j + a, i + b, k + c) for c in (0, 1) for a, b in face], -1)


def stress(points):
    """The components xx, yy, zz, xy, yz, xz (n, 6) about a hole in a plate that is pulled along x."""
    x, y, _ = points.T
    a, t = (RADIUS / np.hypot(x, y)) ** 2, np.arctan2(y, x)
    c2, c4, s2, s4 = np.cos(2 * t), np.cos(4 * t), np.sin(2 * t), np.sin(4 * t)
    xx = 1 - a * (1.5 * c2 + c4) + 1.5 * a**2 * c4
    yy = -a * (0.5 * c2 - c4) - 1.5 * a**2 * c4
    xy = -a * (0.5 * s2 + s4) + 1.5 * a**2 * s4
    return PULL * np.stack([xx, yy, 0 * x, xy, 0 * x, 0 * x], -1)


if __name__ == "__main__":
    points, cells = mesh()
    six = stress(points)
    xx, yy, zz, xy, yz, xz = six.T
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + xz**2))
    values = {"von_mises": mises.astype(np.float32), "stress": six.astype(np.float32)}
    made = meshio.Mesh(points.astype(np.float32), [("hexahedron", cells.astype(np.int32))], point_data=values)
    meshio.write(Path(__file__).parent / "hole.vtu", made)
