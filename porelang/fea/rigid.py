"""Rigid motions: the six of a free part, which of them supports leave free, and what these are called.

Pieces that share faces move as one; pieces that meet only in an edge or a vertex are hinged there. All motions of all
pieces, held by supports and hinges, are one small dense system: what is left in its kernel would be a singular
stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints, Mask
from porelang.fea.surface import place, vector

#: A motion is free if supports hold it with less than this of what they hold the best held one (singular values, with
#: turns measured at the part's half size).
_FREE = 1e-6


def motions(points: Floats, centre: Floats, size: float = 1.0) -> Floats:
    """The displacements (n, 3, 6) of three translations and three rotations about x, y, z through `centre`, over
    `size`."""
    x, y, z = ((points - centre) / size).T
    out = np.zeros((len(points), 3, 6))
    out[:, [0, 1, 2], [0, 1, 2]] = 1.0
    out[:, 1, 3], out[:, 2, 3] = -z, y
    out[:, 0, 4], out[:, 2, 4] = z, -x
    out[:, 0, 5], out[:, 1, 5] = -y, x
    return out


@dataclass(frozen=True, slots=True)
class Pieces:
    """`of` (m,) says of each tetrahedron in which piece it is, by shared faces; `body` (p,) which pieces touch at
    all."""

    of: Ints
    body: Ints

    @property
    def bodies(self) -> int:
        return int(self.body.max()) + 1 if len(self.body) else 0


def pieces(nodes: Nodes) -> Pieces:
    """The pieces of a mesh, and the bodies that they make where they touch in an edge or a vertex."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(nodes.elements)
    pairs = nodes.pairs
    of = connected_components(
        coo_matrix((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(m, m)), directed=False
    )[1]
    count = int(of.max()) + 1
    shape = (count, nodes.vertices)
    touch = coo_matrix((np.ones(4 * m, np.int8), (np.repeat(of, 4), nodes.corners.ravel())), shape=shape).tocsr()
    touch.data[:] = 1
    return Pieces(of.astype(np.int32), connected_components(touch @ touch.T, directed=False)[1].astype(np.int32))


@dataclass(frozen=True, slots=True)
class Free:
    """What supports leave free: `fields` (r, k, 3) are orthonormal displacements of all nodes. `named` (r, k, 3), of no
    component above 1, are motions that span the same, `words` what each is called, `turns` (r,) 1/mm by how much it
    turns."""

    fields: Floats
    named: Floats
    words: tuple[str, ...]
    turns: Floats


def free(nodes: Nodes, parts: Pieces, held: Mask) -> Free:
    """The rigid motions of all bodies that the held components (k, 3) do not hold."""
    named: list[Floats] = []
    words: list[str] = []
    turns: list[float] = []
    body_of = parts.body[parts.of]
    for body in range(parts.bodies):
        mine = body_of == body
        points = np.unique(nodes.elements[mine])
        where = nodes.points[points]
        low, high = where.min(0), where.max(0)
        centre, size = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
        local = np.unique(parts.of[mine])
        kernel = _kernel(nodes, parts, local, points, held, centre, size)
        if not kernel.shape[1]:
            continue
        whose = "" if parts.bodies == 1 else f"the piece round {place(centre)}: "
        for word, motion in _named(kernel, len(local), centre, size):
            field = _moved(nodes, parts, local, motion, centre, size)
            most = float(np.abs(field).max())
            named.append(field / most)
            words.append(whose + word)
            turns.append(float(np.linalg.norm(motion.reshape(-1, 6)[:, 3:], axis=1).max()) / size / most)
    if not named:
        none = np.zeros((0, len(nodes.points), 3))
        return Free(none, none, (), np.zeros(0))
    fields = np.linalg.qr(np.stack([f.ravel() for f in named]).T)[0].T
    return Free(fields.reshape(-1, len(nodes.points), 3), np.stack(named), tuple(words), np.array(turns))


def unheld(nodes: Nodes, parts: Pieces, held: Mask) -> str:
    """Where there are several bodies, which of them no support holds at all; "" where each is held somewhere."""
    if parts.bodies < 2:
        return ""
    body_of = parts.body[parts.of]
    volumes = np.bincount(body_of, nodes.volumes, parts.bodies)
    touched = np.zeros(parts.bodies, bool)
    np.logical_or.at(
        touched, np.repeat(body_of, nodes.elements.shape[1]), np.asarray(held.any(axis=1))[nodes.elements.ravel()]
    )
    bare = np.flatnonzero(~touched)
    if not len(bare):
        return ""
    largest = bare[np.argmax(volumes[bare])]
    where = nodes.points[nodes.corners[body_of == largest]].mean(axis=(0, 1))
    others = f", nor {len(bare) - 1} others" if len(bare) > 1 else ""
    return (
        f"the one round {place(where)}, {volumes[largest] / volumes.sum():.2%} of the volume, is held nowhere{others}"
    )


def _kernel(nodes: Nodes, parts: Pieces, local: Ints, points: Ints, held: Mask, centre: Floats, size: float) -> Floats:
    """The free motions (6 p, r) of the pieces of a body."""
    gram = np.zeros((6 * len(local), 6 * len(local)))
    owners: dict[int, list[int]] = {}
    sets = []
    for i, piece in enumerate(local):
        mine = np.unique(nodes.elements[parts.of == piece])
        sets.append(mine)
        rows = motions(nodes.points[mine], centre, size)[held[mine]]
        part = slice(6 * i, 6 * i + 6)
        gram[part, part] += rows.T @ rows / max(len(mine), 1)
    if len(local) > 1:
        every = np.concatenate(sets)
        which = np.concatenate([np.full(len(s), i) for i, s in enumerate(sets)])
        numbers, counts = np.unique(every, return_counts=True)
        for node in numbers[counts > 1]:
            owners[int(node)] = [int(i) for i in which[every == node]]
        for node, both in owners.items():
            at = motions(nodes.points[node : node + 1], centre, size)[0]
            first = both[0]
            for other in both[1:]:
                rows = np.zeros((3, gram.shape[0]))
                rows[:, 6 * first : 6 * first + 6], rows[:, 6 * other : 6 * other + 6] = at, -at
                gram += rows.T @ rows
    values, vectors = np.linalg.eigh(gram)
    limit = max(values[-1], 1e-300) * _FREE**2
    # the Gram matrix is exact to its rounding: a motion whose square share is below that is free
    return vectors[:, values <= max(limit, values[-1] * 1e-13)]


def _moved(nodes: Nodes, parts: Pieces, local: Ints, motion: Floats, centre: Floats, size: float) -> Floats:
    """The displacement (k, 3) of all nodes in a motion (6 p,) of the pieces of a body."""
    out = np.zeros((len(nodes.points), 3))
    for i, piece in enumerate(local):
        mine = np.unique(nodes.elements[parts.of == piece])
        out[mine] = motions(nodes.points[mine], centre, size) @ motion[6 * i : 6 * i + 6]
    return out


def _named(kernel: Floats, count: int, centre: Floats, size: float) -> list[tuple[str, Floats]]:
    """Motions (6 p,) that span a kernel (6 p, r), the simplest first, and what they are called."""
    first = kernel[:6]
    whole = all(np.allclose(kernel[6 * i : 6 * i + 6], first, atol=1e-6) for i in range(1, count))
    if not whole:
        return [("parts that meet only in an edge or a vertex turn about it", motion) for motion in kernel.T]
    slides = _span(_without(first, slice(3, 6))[:3])
    found = [(f"translation along {direction(v)}", np.tile([*v, 0.0, 0.0, 0.0], count)) for v in slides]
    basis = np.array(slides).reshape(-1, 3)
    turns = _span(first[3:])
    for turn in turns:
        whole_motion = first @ np.linalg.lstsq(first[3:], turn, rcond=1e-9)[0]
        shift, spin = whole_motion[:3] * size, whole_motion[3:]
        shift = shift - basis.T @ (basis @ shift)
        pitch = float(spin @ shift / (spin @ spin))
        through = np.round((centre + np.cross(spin, shift) / (spin @ spin)) / size, 9) * size
        text = f"rotation about {direction(spin)} through {place(through)}"
        if abs(pitch) > 1e-6 * size:
            text += f", with a shift of {2 * np.pi * pitch:.3g} mm a turn along it"
        found.append((text, np.tile([*shift / size, *spin], count)))
    return found


def _without(vectors: Floats, rows: slice) -> Floats:
    """Those combinations of columns whose given rows are 0."""
    _, values, right = np.linalg.svd(vectors[rows])
    rank = int((values > 1e-6).sum())
    return np.asarray(vectors @ right[rank:].T)


def _span(vectors: Floats) -> list[Floats]:
    """An orthonormal basis of the span of columns (3, r), with the axes x, y, z in it where they lie in the span."""
    left, values, _ = np.linalg.svd(vectors, full_matrices=False)
    inside = left[:, values > 1e-6]
    found: list[Floats] = []
    candidates = [*np.eye(3), *inside.T]
    for v in candidates:
        if len(found) == inside.shape[1]:
            break
        if np.linalg.norm(inside @ (inside.T @ v) - v) < 1e-5:
            for f in found:
                v = v - f * (f @ v)
            if np.linalg.norm(v) > 0.1:
                found.append(v / np.linalg.norm(v))
    return found


def direction(along: Floats) -> str:
    """A direction in a sentence: an axis by its name."""
    v = along / np.linalg.norm(along)
    for name, axis in zip("xyz", np.eye(3), strict=True):
        if abs(abs(v @ axis) - 1) < 1e-9:
            return name
    v = v * np.sign(v[np.argmax(np.abs(v))])
    return vector(np.round(v, 3))
