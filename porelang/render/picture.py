"""The picture of an output: the part, field planes and a legend put together, averaged to its final size."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box
from porelang.atomic import save
from porelang.diagnostics import fail, suggest
from porelang.field import Bounds, checked_bounds, make_field
from porelang.ir import Node
from porelang.program import Design, Program
from porelang.progress import activity
from porelang.render import planes
from porelang.render.camera import VIEWS, Camera, Projection, look
from porelang.render.cells import bound_cells
from porelang.render.cuts import Cut, take_away, whole
from porelang.render.legend import legend, strip_of
from porelang.render.march import Distances, Marcher, Scene
from porelang.render.planes import Plane, Scale
from porelang.units import RATIO

Solid = Literal["none", "opaque", "glass"]
Light = NDArray[np.float32]
#: Samples of a picture, all pixels and all samples of a pixel counted, that are held in memory at once.
MOST_SAMPLES = 40_000_000
#: How far the box reaches beyond the part, in its longest side: rays begin outside of the part.
ROOM = 1e-3
#: How dark an outline is drawn, and by how many pixels depth has to leap for one.
OUTLINE, LEAP = 0.42, 6.0
#: The colour of glass, and how many of its surfaces, one behind the other, are drawn.
GLASS, LAYERS = np.array((0.86, 0.87, 0.90), np.float32), 8


@dataclass(frozen=True, slots=True)
class Wishes:
    """What a picture should show: `view` is azimuth and elevation in degrees, `samples` squared make a pixel.

    `scale` is found from the field where it is None. `legend` is the text above the scale's numbers, "" for the unit
    of the field where that is known, None for no legend.
    """

    size: tuple[int, int] = (800, 600)
    view: tuple[float, float] = VIEWS["iso"]
    projection: Projection = "perspective"
    zoom: float = 1.0
    samples: int = 3
    cuts: tuple[Cut, ...] = ()
    slices: tuple[Plane, ...] = ()
    field: str | None = None
    scale: Scale | None = None
    legend: str | None = None
    solid: Solid = "opaque"
    transparent: bool = False


@dataclass(frozen=True, slots=True)
class Picture:
    """Pixels (height, width, 4), 8 bits, top row first, colours not multiplied by alpha; and how they came about.

    `pixel` is the size of one in mm at the middle of the part, `covered` the share of the picture where the part is
    seen, `steps` the samples of the field for a ray on average, `scale` that of the colours of planes.
    """

    pixels: NDArray[np.uint8]
    camera: Camera
    pixel: float
    covered: float
    steps: float
    scale: Scale | None
    backend: str
    seconds: float


def render_output(
    design: Design,
    name: str | None = None,
    wishes: Wishes | None = None,
    bounds: Bounds | None = None,
) -> Picture:
    """A picture of an output of a design, and of fields on planes.

    Where `bounds` (mm) are given, the part is cut at them. Errors: E100-E103 about the output, E107 where bounds and
    cuts leave nothing, E111 where they hold nothing solid, E114 for a picture too large, E120-E122 about OpenGL.
    """
    wishes = wishes or Wishes()
    begun = time.perf_counter()
    part, program = design.of(name), design.program
    shown_on_planes = design.formula(_field_named(program, wishes.field)) if wishes.field else part
    box = checked_bounds(bounds) if bounds is not None else _roomy(design.bounds(name))
    shown = take_away(whole(box, bounds is not None), wishes.cuts)
    strip = strip_of(wishes.size) if wishes.legend is not None and wishes.slices else None
    size, samples = _samples(wishes, strip.width if strip else 0)
    stage = planes.stage(box, wishes.slices) if wishes.slices else shown.box
    camera = look(stage, wishes.view, size, wishes.projection, wishes.zoom)
    width, height = size
    over = np.zeros((height, width, 4), np.float32)  # red, green, blue times alpha, and alpha
    far = np.full((height, width), np.inf, np.float32)
    covered, steps, scale, backend = 0.0, 0.0, None, ""
    if wishes.slices:
        field = make_field(shown_on_planes, program.ranges, "auto", "f32")
        scale = wishes.scale or planes.reach(wishes.slices, stage, field)
        seen = planes.cross(wishes.slices, stage, camera, size, field)
        on = seen.which >= 0
        over[on, :3] = planes.colours(seen, scale, 1.4 * samples)[on]
        over[on, 3] = 1.0
        far, backend = seen.distance, field.backend
    if wishes.solid != "none":
        from porelang.gpu.fields import gpu

        scene = Scene(part, program.ranges, bound_cells(part, shown.box), shown)
        if scene.cells.empty:
            raise fail("E111", "nothing solid lies in what is to be shown",
                       hint="solid is negative: widen --bounds, or take a --cut away")  # fmt: skip
        marcher = Marcher(scene, camera, size, gpu("person"), samples)
        # where a plane lies in a cut face, the plane is seen
        far = far - 4 * np.float32(marcher.nearest)
        lay = _lay_glass if wishes.solid == "glass" else _lay_solid
        with activity("drawing"):
            covered, steps, backend = lay(over, marcher, far), marcher.steps, "glsl"
    pixels = _averaged(over, samples, wishes.transparent)
    if strip is not None and scale is not None:
        unit = wishes.legend or _unit_of(program, wishes.field or program.output(name))
        beside = legend(scale, unit, strip, pixels.shape[0], wishes.transparent)
        pixels = np.concatenate([pixels, beside], axis=1)
    pixel, seconds = samples * camera.pixel(size, box), time.perf_counter() - begun
    return Picture(pixels, camera, pixel, covered, steps, scale, backend, seconds)


def write_png(picture: Picture, path: str, transparent: bool = False) -> None:
    """Write a picture, whole or not at all. Errors: E113."""
    from PIL import Image

    image = Image.fromarray(picture.pixels if transparent else np.ascontiguousarray(picture.pixels[..., :3]))

    def put(file: BinaryIO) -> None:
        image.save(file, "PNG")

    save(path, put)


def _field_named(program: Program, name: str) -> Node:
    """The flat root of an output, or of a `let` at the top of the file, that is a number. Errors: E100, E101."""
    found = program.named(name)
    if found is None:
        known = [*program.outputs, *program.elaborated.lets]
        near = suggest(name, known)
        raise fail("E100", f"the program has no output and no number called `{name}`",
                   hint=f"did you mean `{near}`?" if near else f"it has {', '.join(known)}")  # fmt: skip
    return found


def _roomy(box: Box) -> Box:
    more = ROOM * max(box.size)
    lo, hi = (tuple(v + s * more for v in end) for end, s in ((box.lo, -1), (box.hi, 1)))
    return Box((lo[0], lo[1], lo[2]), (hi[0], hi[1], hi[2]))


def _unit_of(program: Program, name: str) -> str:
    """The unit of an output or `let`; "" where it has none, or none that is known."""
    outputs = program.elaborated.outputs
    value = outputs[name].value if name in outputs else program.elaborated.lets[name]
    dimension = getattr(value, "dimension", None)
    return "" if dimension is None or dimension == RATIO else dimension.unit


def _samples(wishes: Wishes, strip: int) -> tuple[tuple[int, int], int]:
    """The size that is drawn beside a strip, and its samples along a pixel's side: fewer where it is large.

    Errors: E114.
    """
    width, height = wishes.size[0] - strip, wishes.size[1]
    for n in range(wishes.samples, 0, -1):
        if width * height * n * n <= MOST_SAMPLES:
            return (width * n, height * n), n
    raise fail("E114", f"a picture of {width} x {height} pixels is too large",
               hint=f"{MOST_SAMPLES // 1_000_000} million pixels are the most")  # fmt: skip


def _lay_solid(over: Light, marcher: Marcher, far: Distances) -> float:
    """Lay the part over what is there, where it is nearer than `far`. Returns the share of the picture it covers."""
    distance = marcher.distances((0, 1, 3))
    light = marcher.light(distance, (1, 2, 3))  # this round over the picture takes twice as long
    front = distance < far
    over[front] = _with_outlines(light, distance, marcher.pixel * LEAP)[front]
    return float(np.isfinite(distance).mean())


def _lay_glass(over: Light, marcher: Marcher, far: Distances) -> float:
    """Lay the surface over what is there as clear glass, each time a ray meets or leaves the part.

    What lies behind `far` is hidden. Returns the share of the picture that the part covers.
    """
    through = np.ones_like(far)
    colour = np.zeros((*far.shape, 3), np.float32)
    distance, covered = None, 0.0
    for layer in range(LAYERS):
        distance = marcher.distances((layer, 1, LAYERS), distance, leaving=layer % 2 == 1)
        covered = covered or float(np.isfinite(distance).mean())
        distance[distance >= far] = np.inf
        if not np.isfinite(distance).any():
            break
        light = marcher.light(distance, glass=True).astype(np.float32) / 255
        alpha = light[..., 3] * through
        colour += (alpha * light[..., 0])[..., None] * GLASS
        through -= alpha
    over[..., :3] = colour + through[..., None] * over[..., :3]
    over[..., 3] = (1 - through) + through * over[..., 3]
    return covered


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
