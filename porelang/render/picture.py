"""The picture of an output: the part, field planes and outlines put together, averaged to its final size."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import fail, suggest
from porelang.ir import Node
from porelang.passes import Graph, run
from porelang.passes.box import Box
from porelang.program import Program, make_field
from porelang.render import planes
from porelang.render.camera import VIEWS, Camera, Projection, look
from porelang.render.cells import bound_cells
from porelang.render.march import Marcher, Scene
from porelang.render.planes import Plane
from porelang.settings import Setting
from porelang.surface import Bounds, checked_bounds

Solid = Literal["none", "opaque", "glass"]
Light = NDArray[np.float32]
#: Samples of a picture, all pixels and all samples of a pixel counted, that are held in memory at once.
MOST_SAMPLES = 40_000_000
#: How far the box reaches beyond the part, in its longest side: rays begin outside of the part.
ROOM = 1e-3
#: How dark an outline is drawn, and by how many pixels depth has to leap for one.
OUTLINE, LEAP = 0.42, 6.0
GLASS, THIN = np.array((0.52, 0.53, 0.55), np.float32), 0.34


@dataclass(frozen=True, slots=True)
class Cut:
    """A half-space to be taken away: where the coordinate `axis` lies below (or above) `at` mm."""

    axis: int
    below: bool
    at: float


@dataclass(frozen=True, slots=True)
class Wishes:
    """What a picture should show: `view` is azimuth and elevation in degrees, `samples` squared make a pixel."""

    size: tuple[int, int] = (800, 600)
    view: tuple[float, float] = VIEWS["iso"]
    projection: Projection = "perspective"
    zoom: float = 1.0
    samples: int = 3
    cuts: tuple[Cut, ...] = ()
    slices: tuple[Plane, ...] = ()
    field: str | None = None
    solid: Solid = "opaque"
    transparent: bool = False


@dataclass(frozen=True, slots=True)
class Picture:
    """Pixels (height, width, 4), 8 bits, top row first, colours not multiplied by alpha; and how they came about.

    `pixel` is the size of one in mm at the middle of the part, `covered` the share of the picture where the part is
    seen, `steps` the samples of the field for a ray on average, `full` the value at which planes have full colour.
    """

    pixels: NDArray[np.uint8]
    camera: Camera
    pixel: float
    covered: float
    steps: float
    full: float | None
    backend: str
    seconds: float


def render_output(
    program: Program,
    name: str | None = None,
    wishes: Wishes | None = None,
    bounds: Bounds | None = None,
    settings: Mapping[str, Setting] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Picture:
    """A picture of an output (and of fields on planes) from a compiled program.

    Where `bounds` (mm) are given, the part is cut at them. Errors: E100-E103 about the output, E107 where bounds and
    cuts leave nothing, E111 where they hold nothing solid, E114 for a picture too large, E120-E122 about OpenGL.
    """
    wishes = wishes or Wishes()
    begun = time.perf_counter()
    root, params = program.solid(name), program.settle(**(settings or {}))
    plane_root = _field_named(program, wishes.field) if wishes.field else root
    whole = checked_bounds(bounds) if bounds is not None else _roomy(program.bounds(name, **(settings or {})))
    box, cut_lo, cut_hi = _cut(whole, wishes.cuts, bounds is not None)
    size, samples = _samples(wishes)
    shown = planes.stage(whole, wishes.slices) if wishes.slices else box
    camera = look(shown, wishes.view, size, wishes.projection, wishes.zoom)
    width, height = size
    over = np.zeros((height, width, 4), np.float32)  # red, green, blue times alpha, and alpha
    far = np.full((height, width), np.inf, np.float32)
    covered, steps, full, backend = 0.0, 0.0, None, ""
    seen = None
    if wishes.slices:
        field = make_field((plane_root,), params, program.graph.ranges, "auto", "f32")
        full, backend = planes.reach(wishes.slices, shown, field), field.backend
        seen = planes.cross(wishes.slices, shown, camera, size, field)
        on = seen.which >= 0
        over[on, :3] = planes.colours(seen, full, 1.4 * samples)[on]
        over[on, 3] = 1.0
        far = seen.distance
    if wishes.solid != "none":
        from porelang.device import gpu

        scene = Scene(root, params, program.graph.ranges, bound_cells(root, params, box), cut_lo, cut_hi)
        if scene.cells.empty:
            raise fail("E111", "nothing solid lies in what is to be shown",
                       hint="solid is negative: widen --bounds, or take a --cut away")  # fmt: skip
        marcher = Marcher(scene, camera, size, gpu(), samples)
        first, second = (None, None) if progress is None else _halves(progress)
        distance = marcher.distances(first)
        light = marcher.light(distance, second)
        covered, steps, backend = float(np.isfinite(distance).mean()), marcher.steps, "glsl"
        part = _with_outlines(light, distance, camera.pixel(size, box) * LEAP)
        # where a plane lies in a cut face, the plane is seen
        front = distance < far - 4 * marcher.nearest
        _lay(over, part, front, wishes.solid)
    pixels = _averaged(over, samples, wishes.transparent)
    pixel, seconds = samples * camera.pixel(size, box), time.perf_counter() - begun
    return Picture(pixels, camera, pixel, covered, steps, full, backend, seconds)


def write_png(picture: Picture, path: str, transparent: bool = False) -> None:
    """Write a picture, whole or not at all. Errors: E113."""
    from PIL import Image

    from porelang.mesh.export import save

    image = Image.fromarray(picture.pixels if transparent else np.ascontiguousarray(picture.pixels[..., :3]))

    def put(file: BinaryIO) -> None:
        image.save(file, "PNG")

    save(path, put)


def _field_named(program: Program, name: str) -> Node:
    """The flat root of an output, or of a `let` at the top of the file, that is a number. Errors: E100, E101."""
    if name in program.outputs:
        return program.solid(name)
    lets = program.elaborated.lets
    if name not in lets:
        known = [*program.outputs, *lets]
        near = suggest(name, known)
        raise fail("E100", f"the program has no output and no number called `{name}`",
                   hint=f"did you mean `{near}`?" if near else f"it has {', '.join(known)}")  # fmt: skip
    graph = run(Graph({name: lets[name].node}, program.lowered.ranges))
    if graph.reductions:
        raise fail("E100", f"`{name}` needs numbers that are found from fields",
                   hint=f"make it an output: `out {name} = ...`")  # fmt: skip
    return graph.roots[name]


def _roomy(box: Box) -> Box:
    more = ROOM * max(box.size)
    lo, hi = (tuple(v + s * more for v in end) for end, s in ((box.lo, -1), (box.hi, 1)))
    return Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))


Faces = tuple[bool, bool, bool]


def _cut(box: Box, cuts: tuple[Cut, ...], at_ends: bool) -> tuple[Box, Faces, Faces]:
    """What the cuts leave of a box, and which of its faces cut the part. Errors: E107 where they leave nothing."""
    ends = [list(box.lo), list(box.hi)]
    faces = [[at_ends] * 3, [at_ends] * 3]
    for c in cuts:
        end, keep = (0, max) if c.below else (1, min)
        if keep(ends[end][c.axis], c.at) != ends[end][c.axis]:
            ends[end][c.axis], faces[end][c.axis] = c.at, True
        if ends[0][c.axis] >= ends[1][c.axis]:
            sign = "<" if c.below else ">"
            lo, hi = box.lo[c.axis], box.hi[c.axis]
            raise fail("E107", f"the cut {'xyz'[c.axis]}{sign}{c.at:g} leaves nothing of the part",
                       hint=f"the part reaches from {lo:.6g} to {hi:.6g} mm along {'xyz'[c.axis]}")  # fmt: skip
    (a, b), (cut_lo, cut_hi) = ends, faces
    return (Box((a[0], a[1], a[2]), (b[0], b[1], b[2])),
            (cut_lo[0], cut_lo[1], cut_lo[2]), (cut_hi[0], cut_hi[1], cut_hi[2]))  # fmt: skip


def _samples(wishes: Wishes) -> tuple[tuple[int, int], int]:
    """The size that is drawn, and its samples along a pixel's side: fewer where the picture is large. Errors: E114."""
    width, height = wishes.size
    for n in range(wishes.samples, 0, -1):
        if width * height * n * n <= MOST_SAMPLES:
            return (width * n, height * n), n
    raise fail("E114", f"a picture of {width} x {height} pixels is too large",
               hint=f"{MOST_SAMPLES // 1_000_000} million pixels are the most")  # fmt: skip


def _halves(progress: Callable[[int, int], None]) -> tuple[Callable[[int, int], None], Callable[[int, int], None]]:
    """A progress bar for two rounds over the picture, the second of which takes longer."""
    return (lambda done, total: progress(done, 3 * total)), (lambda done, total: progress(total + 2 * done, 3 * total))


def _with_outlines(light: NDArray[np.uint8], distance: Light, leap: float) -> Light:
    """The part's colours times alpha, and alpha, darker where what lies behind is much farther."""
    out: Light = light.astype(np.float32)
    out *= np.float32(1 / 255)
    padded = np.pad(np.nan_to_num(distance, posinf=1e9), 1, mode="edge")
    middle = padded[1:-1, 1:-1]
    edge = np.zeros(distance.shape, np.bool_)
    for a, b in ((padded[:-2, 1:-1], padded[2:, 1:-1]), (padded[1:-1, :-2], padded[1:-1, 2:])):
        edge |= (a + b - 2 * middle) > leap
    out[edge & np.isfinite(distance), :3] *= 1 - OUTLINE
    return out


def _lay(over: Light, part: Light, front: NDArray[np.bool_], solid: Solid) -> None:
    """Lay the part over what is there, where it is in front."""
    if solid == "opaque":
        over[front] = part[front]
        return
    shade = part[front, :3].mean(axis=1, keepdims=True)
    below = over[front]
    alpha = np.clip(THIN + 0.5 * np.maximum(0.62 - shade, 0), 0, 0.8)
    over[front, :3] = GLASS * (0.45 + 0.75 * shade) * alpha + below[:, :3] * (1 - alpha)
    over[front, 3:] = alpha + below[:, 3:] * (1 - alpha)


def _averaged(over: Light, n: int, transparent: bool) -> NDArray[np.uint8]:
    """The samples of each pixel as one, on white or on nothing."""
    height, width = over.shape[0] // n, over.shape[1] // n
    mean: Any = over.reshape(height, n, width, n, 4).mean(axis=(1, 3))
    alpha = mean[..., 3:]
    if transparent:
        colour = np.divide(mean[..., :3], alpha, out=np.zeros_like(mean[..., :3]), where=alpha > 0)
        mean = np.concatenate([colour, alpha], axis=2)
    else:
        mean = np.concatenate([mean[..., :3] + (1 - alpha), np.ones_like(alpha)], axis=2)
    pixels: NDArray[np.uint8] = np.rint(np.clip(mean, 0, 1) * 255).astype(np.uint8)
    return pixels
