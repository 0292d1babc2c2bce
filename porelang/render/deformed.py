"""The deformed part: its surface as triangles, each vertex moved, drawn as the camera sees them.

Triangles are about as large as pixels. Colours are those of the field at the place that is seen, before it moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.bounds import box_test
from porelang.analysis.box import Box
from porelang.analysis.enclose import F32, F64
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.field import number_type
from porelang.formula import Formula
from porelang.ir import Node, X, Y, Z, const, node
from porelang.mesh import Grid, Surface, extract
from porelang.parallel import workers
from porelang.program import Design
from porelang.progress import activity, tell
from porelang.render.camera import Camera, look
from porelang.render.cuts import Cut
from porelang.render.deform import Deform, Deformed, displacement, magnified
from porelang.render.frame import closer, zoomed
from porelang.render.painting import AMBIENT, Evaluate
from porelang.render.raster import Seen, seen
from porelang.render.scale import Colouring, fitting, scale_colours
from porelang.render.shade import lit, open_sky, vertex_normals
from porelang.render.studied import studied
from porelang.render.wishes import Wishes
from porelang.solid import Solid
from porelang.walls import chosen

Floats = NDArray[np.float64]
#: Samples of the field at most: a surface of some million triangles.
AFFORDABLE = 24_000_000
#: How far around a place light is looked for, of the part's diagonal; as in `march`.
REACH = 0.1
#: What is as near to a cut, in voxels, lies in its face.
IN_FACE = 0.05
#: Neighbours whose normals differ by more than this cosine have an edge between them.
EDGE = 0.8


@dataclass(frozen=True, slots=True)
class Ghost:
    """How far from the eye an undeformed part is seen (height, width), mm, and where its edges and outlines are."""

    distance: NDArray[np.float32]
    edges: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Drawn:
    """A deformed part as it is seen: colours (height, width, 3) in 0..1 and distances from the eye in mm, of the
    undeformed part too where it is a ghost; the scale of the colours, where they are those of a field; what is doubtful
    about it."""

    colours: NDArray[np.float32]
    distance: NDArray[np.float32]
    ghost: Ghost | None
    camera: Camera
    box: Box
    scale: Colouring | None
    deformed: Deformed
    told: list[Diagnostic]


def draw(
    design: Design, part: Formula, box: Box, cut_flat: bool, wish: Deform, wishes: Wishes, size: tuple[int, int],
    field: Evaluate | None,
) -> Drawn:  # fmt: skip
    """The deformed part in a picture of `size` samples, in the colours of a field. `cut_flat`: the part goes on
    beyond its box.

    Errors: E107, E111 where cuts leave nothing, E179 about the deformation.
    """
    pixel = wishes.samples * look(box, wishes.view, size, wishes.projection, wishes.zoom).pixel(size, box)
    surface, voxel = _surface(part, box, cut_flat, wishes.cuts, pixel)
    with activity("drawing"):
        moved, deformed = magnified(design, wish, surface.vertices)
        camera, stage = _camera(np.concatenate([moved, surface.vertices]) if wishes.ghost else moved, wishes, size)
        front = seen(moved, surface.faces, camera, size)
        normals = _normals(front, moved, camera)
        sky = open_sky(front.distance, normals, camera, REACH * float(np.linalg.norm(stage.size)))
        values, section = _looked_at(front, surface, wishes.cuts, IN_FACE * voxel, field)
        scale = None if field is None else wishes.scale or fitting(values[np.isfinite(values)].astype(np.float64))
        colours = np.zeros((*front.which.shape, 3), np.float32)
        for rows, hit, *_ in front.bands():
            light = lit(normals[rows][hit].astype(np.float64), sky[rows][hit], section[rows][hit], scale is not None)
            if scale is not None:
                light = (AMBIENT + (1 - AMBIENT) * light) * scale_colours(values[rows][hit], scale)
            colours[rows][hit] = light
        ghost = _ghost(surface, camera, size) if wishes.ghost else None
    found = studied(design, displacement(design.program, wish.what)[1])
    what = "it is drawn as if it moved with the nearest place of that" + (", and is grey" if scale is not None else "")
    told = [] if found is None else found.told(surface.vertices, what)
    return Drawn(colours, front.distance, ghost, camera, stage, scale, deformed, told)


def _surface(part: Formula, box: Box, cut_flat: bool, cuts: Sequence[Cut], pixel: float) -> tuple[Surface, float]:
    """What cuts leave of a part, as triangles of about a pixel (mm), or smaller where walls are thin; and its voxel."""
    finest = float(np.prod(box.size) / AFFORDABLE) ** (1 / 3)
    voxel = max(min(pixel, chosen(Solid(part, (box.lo, box.hi)), AFFORDABLE).voxel), finest)
    root = part.root
    for cut in cuts:
        root = node("max", root, node("neg", _region(cut)))
    left = part.with_roots(root)
    h = 0.0 if cut_flat else voxel  # a part that ends of itself is not cut by a plane through its surface
    lo, hi = tuple(v - h for v in box.lo), tuple(v + h for v in box.hi)
    ends = ((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))
    grid = Grid.cover(*ends, spacing=voxel)
    numbers = number_type(left, Box(*ends), voxel, "numpy", "f32")
    sampled = NumpyField(left, numbers, 1)
    test = box_test(left, F32 if numbers == "f32" else F64)
    try:
        with activity("meshing"):
            made = extract(grid, ends, sampled.on_grid(grid.axes()).block, test,
                           field=NumpyField(left.taken, numbers, 1).at, threads=workers())  # fmt: skip
    except PoreError as error:
        if cuts and error.diagnostics[0].code == "E111":
            said = " and ".join(" & ".join(map(str, cut)) for cut in cuts)
            raise fail("E107", f"the cut {said} leaves nothing of the part", hint="take less away") from None
        raise
    return made, voxel


def _region(cut: Cut) -> Node:
    """What a cut takes away, as a solid."""
    sides = []
    for side in cut:
        axis = (X, Y, Z)[side.axis]
        sides.append(node("sub", *((axis, const(side.at)) if side.below else (const(side.at), axis))))
    root = sides[0]
    for other in sides[1:]:
        root = node("max", root, other)
    return root


def _camera(places: Floats, wishes: Wishes, size: tuple[int, int]) -> tuple[Camera, Box]:
    """The camera that just takes in places (n, 3), and the box round them."""
    lo, hi = (tuple(end.tolist()) for end in (places.min(axis=0), places.max(axis=0)))
    stage = Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))
    camera = look(stage, wishes.view, size, wishes.projection)
    if wishes.frame == "surface":
        camera = closer(camera, size, places, camera.pixel(size, stage))
    return zoomed(camera, wishes.zoom), stage


def _at(front: Seen, of: Floats, one: NDArray[np.int32], weights: Floats) -> Floats:
    """What is (n, 3) at vertices, where samples show triangles (k,) with the weights (k, 3) of their corners."""
    return np.asarray(np.einsum("kc,kcd->kd", weights, of[front.faces[one]]))


def _normals(front: Seen, vertices: Floats, camera: Camera) -> NDArray[np.float32]:
    """Unit normals (height, width, 3) toward the viewer, in the viewer's axes: right, up, forward."""
    at_vertices = vertex_normals(vertices, front.faces) @ np.stack([camera.right, camera.up, camera.forward], axis=-1)
    out = np.zeros((*front.which.shape, 3), np.float32)
    for rows, hit, one, weights in front.bands():
        found = _at(front, at_vertices, one, weights)
        found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-300)
        out[rows][hit] = found
    return out


def _looked_at(
    front: Seen, surface: Surface, cuts: Sequence[Cut], near: float, field: Evaluate | None
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """The field (height, width) where samples look, at the places as they were before they moved, and which of them lie
    in the faces of cuts."""
    values = np.full(front.which.shape, np.nan, np.float32)
    section = np.zeros(front.which.shape, np.bool_)
    regions = [NumpyField(Formula((_region(cut),), {}), "f64", 1) for cut in cuts]
    for rows, hit, one, weights in front.bands():
        tell(rows.stop, front.which.shape[0])
        places = _at(front, surface.vertices, one, weights)
        if field is not None:
            values[rows][hit] = field(places)
        for region in regions:
            section[rows][hit] |= np.abs(np.asarray(region.at(places))) <= near
    return values, section


def _ghost(surface: Surface, camera: Camera, size: tuple[int, int]) -> Ghost:
    """The undeformed part: how far it is, and where edges and outlines of it are seen."""
    before = seen(surface.vertices, surface.faces, camera, size)
    normals = _normals(before, surface.vertices, camera)
    there = before.which >= 0
    edge = np.zeros(there.shape, np.bool_)
    for axis in (0, 1):
        n = np.moveaxis(normals, axis, 0)
        here = np.moveaxis(there, axis, 0)
        turns = ((n[1:] * n[:-1]).sum(axis=-1) < EDGE) & (here[1:] | here[:-1])
        along = np.moveaxis(edge, axis, 0)
        along[1:] |= turns & here[1:]
        along[:-1] |= turns & here[:-1]
    return Ghost(before.distance, edge)
