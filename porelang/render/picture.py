"""The picture of outputs: parts, field planes, a legend and marks put together, averaged to its final size."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import around
from porelang.diagnostics import Diagnostic, fail
from porelang.elaborate.values import Scalar
from porelang.expression import Expression, expression
from porelang.field import Backend, Bounds, checked_bounds, make_field
from porelang.formula import Formula
from porelang.gpu import Gpu
from porelang.ir import Node, Stage, node
from porelang.picture import Picture
from porelang.program import Design, Program
from porelang.progress import activity
from porelang.render import planes
from porelang.render.camera import Camera, look
from porelang.render.cells import bound_cells
from porelang.render.compositing import LEAP, averaged, lay_deformed, lay_glass, with_outlines
from porelang.render.cuts import Shown, take_away, whole
from porelang.render.deform import displacement, of_field
from porelang.render.deformed import draw
from porelang.render.frame import ROUNDS, SMALL, closer, coarse, met, touches_rim, zoomed
from porelang.render.legend import legend, strip_of
from porelang.render.march import Distances, Marcher, Scene
from porelang.render.marks import Colour, axes_mark, key, lay, scale_bar_mark, words_mark
from porelang.render.painting import BODIES, colour, patches_of, ramp_of, surveyed
from porelang.render.scale import fitting
from porelang.render.studied import GREY, is_result, studied
from porelang.render.wishes import Wishes
from porelang.units import RATIO, STRESS

Light = NDArray[np.float32]
#: Samples of a picture, all pixels and all samples of a pixel counted, that are held in memory at once.
MOST_SAMPLES = 40_000_000
#: How far the box reaches beyond the part, in its longest side: rays begin outside of the part.
ROOM = 1e-3


def render_output(
    design: Design,
    name: str | Sequence[str] | None = None,
    wishes: Wishes | None = None,
    bounds: Bounds | None = None,
) -> Picture:
    """A picture of an output of a design, or of several in colours of their own, and of fields on planes or on it.

    Where `bounds` (mm) are given, the part is cut at them, and they are what the picture takes in; else that is the
    surface that is seen. Errors: E100-E103 about the output, E107 where bounds and cuts leave nothing, E111 where they
    hold nothing solid, E114 for a picture too large, E120-E122 about OpenGL, E108 for wishes that contradict another.
    """
    wishes = wishes or Wishes()
    begun = time.perf_counter()
    program = design.program
    names = _names(program, name, wishes)
    part = _together(design, names)
    coloured = field_shown(program, wishes)
    shown_field = part if coloured is None else design.formula(*coloured.roots)
    box = checked_bounds(bounds) if bounds is not None else around([design.bounds(n) for n in names]).grown(ROOM)
    shown = take_away(whole(box, bounds is not None), wishes.cuts)
    painted = wishes.field is not None and not wishes.slices
    named = _coloured(program, names)
    strip, names_beside = _beside(wishes, named, painted)
    size, samples = _samples(wishes, strip)
    stage = planes.stage(box, wishes.slices) if wishes.slices else shown.box
    camera = look(stage, wishes.view, size, wishes.projection, wishes.zoom)
    width, height = size
    over = np.zeros((height, width, 4), np.float32)  # red, green, blue times alpha, and alpha
    far = np.full((height, width), np.inf, np.float32)
    covered, steps, scale, backend, deformed = 0.0, 0.0, None, "", None
    backing: Backend = "auto" if wishes.deform is None else "numpy"
    field = make_field(shown_field, program.ranges, backing, "f32") if wishes.slices or painted else None
    of_study = studied(design, coloured.roots) if coloured is not None and is_result(coloured) else None
    paint = field if field is None or of_study is None else of_study.known(field)
    told: list[Diagnostic] = []
    if wishes.slices and field is not None:
        within = None
        if coloured is not None and coloured.dimension == STRESS:  # there is none beside the part
            within = make_field(part, program.ranges, "auto", "f32")
        seen = planes.cross(wishes.slices, stage, camera, size, field if within is None else paint or field, within)
        found = seen.value[np.isfinite(seen.value)].astype(np.float64)
        scale = wishes.scale or (fitting(found) if within else planes.reach(wishes.slices, stage, field))
        if within is not None and of_study is not None:
            told = of_study.told(surveyed(camera, size, seen.distance), GREY)
        on = seen.which >= 0
        over[on, :3] = planes.colours(seen, scale, 1.4 * samples)[on]
        over[on, 3] = 1.0
        far, backend = seen.distance, field.backend
    deform = of_field(program, wishes.deform, () if coloured is None else coloured.roots)
    if deform is not None:
        moved = draw(design, part, box, bounds is not None, deform, wishes, size, paint if painted else None)
        lay_deformed(over, moved, LEAP * moved.camera.pixel(size, moved.box), samples)
        camera, stage, scale, deformed, told = moved.camera, moved.box, moved.scale, moved.deformed, moved.told
        covered, backend = float(np.isfinite(moved.distance).mean()), "numpy"
    elif wishes.solid != "none":
        several = len(names) > 1
        scene = _scene(part, program, shown)
        tight = wishes.frame == "surface" and not wishes.slices and bounds is None
        with activity("drawing"):
            camera, marcher, distance = _met(scene, camera, size, samples, wishes, tight, bare=several or painted)
            # where a plane lies in a cut face, the plane is seen
            far = far - 4 * np.float32(marcher.nearest)
            if wishes.solid == "glass":
                lay_glass(over, marcher, far, distance)
            else:
                light = marcher.light(distance, (1, 2, 3))  # this round over the picture takes twice as long
                if paint is not None and painted:
                    places = surveyed(camera, size, distance)
                    scale = wishes.scale or fitting(np.asarray(paint(places), np.float64))
                    colour(light, camera, distance, size, ramp_of(paint, scale))
                    told = [] if of_study is None else of_study.told(places, GREY)
                elif several:
                    outputs = [make_field(design.of(n), program.ranges, "auto", "f32") for n in names]
                    colour(
                        light,
                        camera,
                        distance,
                        size,
                        patches_of(outputs, [c for _, c in named], marcher.nearest, camera),
                    )
                front = distance < far
                over[front] = with_outlines(light, distance, marcher.pixel * LEAP)[front]
        covered, steps, backend = float(np.isfinite(distance).mean()), marcher.steps, "glsl"
    pixels = averaged(over, samples, wishes.transparent)
    pixel = samples * camera.pixel(size, stage)
    marks = [axes_mark(camera, wishes.size)] if wishes.axes else []
    if deformed is not None:  # nobody is to take the picture for the part's true shape
        marks.append(words_mark(str(deformed), wishes.size))
    if wishes.scale_bar:
        drawn = (pixels.shape[1], pixels.shape[0])
        marks.append(scale_bar_mark(pixel, drawn, " in the middle" if camera.perspective else ""))
    if marks:
        pixels = lay(pixels, marks, over[::samples, ::samples, 3] > 0)
    if names_beside is not None:
        pixels = np.concatenate([pixels, names_beside], axis=1)
    elif strip and scale is not None:
        said = wishes.legend or legend_of(coloured or expression(program, names[0], "--out"))
        beside = legend(scale, said, strip_of(wishes.size), pixels.shape[0], wishes.transparent)
        pixels = np.concatenate([pixels, beside], axis=1)
    seconds = time.perf_counter() - begun
    return Picture(pixels, camera, pixel, covered, steps, scale, backend, seconds, wishes.transparent, tuple(named),
                   deformed, tuple(told))  # fmt: skip


def field_shown(program: Program, wishes: Wishes) -> Expression | None:
    """The field in colours: an output, a `let`, or an expression of these, that is a number. Errors: E100, E101, those
    of an expression."""
    return None if wishes.field is None else field_of(program, wishes.field, "--field")


def field_of(program: Program, text: str, option: str) -> Expression:
    """What is to be shown in colours, by a text that was given at `option`. Errors: those of `field_shown`."""
    if text in program.outputs:
        program.solid(text)
    found = expression(program, text, option)
    if not isinstance(found.value, Scalar):
        what, hint = "a condition", f"as in {option} 'if {found.text} then 1 else 0'"
        if len(found.roots) > 1:
            what, hint = "a vector", f"colours are of one number: length({found.text}), or {found.text}.z"
        raise fail("E101", f"`{found.text}` is {what}", hint=hint)
    if "." in found.text and found.value.node.stage is not Stage.FIELD:
        study = found.text.rpartition(".")[0]
        raise fail("E101", f"`{found.text}` is one number, and no field", hint=f"`pore fea` says it; a field is "
                   f"`{study}.von_mises`")  # fmt: skip
    return found


def legend_of(field: Expression) -> str:
    """What stands above the scale of a field: what it is called, unless that takes a calculation, and its unit, where
    that is known."""
    d = field.dimension
    unit = "" if d is None or d == RATIO else d.called
    named = field.text.replace("_", "").replace(".", "").isalnum()
    return f"{field.text} {unit}".strip() if named and "." in field.text else unit


def roots_shown(program: Program, name: str | Sequence[str] | None, wishes: Wishes) -> list[Node]:
    """The flat roots of all that a picture shows: its outputs and the field in colours. Errors: E100, E101, E108."""
    roots = [program.solid(n) for n in _names(program, name, wishes)]
    field = field_shown(program, wishes)
    roots += [] if field is None else field.roots
    deform = of_field(program, wishes.deform, () if field is None else field.roots)
    return roots + list(() if deform is None else displacement(program, deform.what)[1])


def bodies_of(program: Program) -> list[str]:
    """The outputs that are solids, as far as their kind tells: numbers that vary in space."""
    return [name for name, o in program.outputs.items() if isinstance(o.value, Scalar) and o.value.node.axes]


def _names(program: Program, name: str | Sequence[str] | None, wishes: Wishes) -> list[str]:
    """The outputs to be drawn, each once. Errors: E100, E108."""
    given = [name] if name is None or isinstance(name, str) else name
    names = list(dict.fromkeys(program.output(n) for n in given)) or [program.output(None)]
    if wishes.field in names and not wishes.slices:
        raise fail("E108", f"the surface of `{wishes.field}` is where `{wishes.field}` is zero: it has one colour",
                   hint="name another output or a `let` as the field, or add a plane: --slice x=0")  # fmt: skip
    if len(names) > len(BODIES):
        raise fail("E108", f"{len(names)} outputs are to be drawn, and there are {len(BODIES)} colours for them",
                   hint=f"draw {len(BODIES)} at a time")  # fmt: skip
    if len(names) > 1 and wishes.solid == "glass":
        raise fail("E108", "glass has no colours for several outputs", hint="draw one, or draw them opaque and cut")
    if len(names) > 1 and wishes.field and not wishes.slices:
        raise fail("E108", "a field's colours leave none for several outputs", hint="draw one output with a field")
    return names


def _coloured(program: Program, names: Sequence[str]) -> list[tuple[str, Colour]]:
    """Outputs with their colours, where there are several: each has the same in every picture of a program."""
    if len(names) < 2:
        return []
    known = bodies_of(program)
    places = [known.index(n) for n in names if n in known]
    if len(places) < len(names) or max(places) >= len(BODIES):
        places = list(range(len(names)))
    return [(n, BODIES[i]) for n, i in zip(names, places, strict=True)]


def _together(design: Design, names: Sequence[str]) -> Formula:
    """What lies in any of some outputs, as a formula."""
    formula = design.formula(*(design.program.solid(n) for n in names))
    root = formula.roots[0]
    for other in formula.roots[1:]:
        root = node("min", root, other)
    return formula.with_roots(root)


def _beside(wishes: Wishes, named: Sequence[tuple[str, Colour]], painted: bool) -> tuple[int, NDArray[np.uint8] | None]:
    """The width of what is drawn beside a picture; and that, where it is the names of outputs."""
    if wishes.legend is None:
        return 0, None
    if wishes.slices or painted:
        return strip_of(wishes.size).width, None
    if not named:
        return 0, None
    made = key(named, wishes.size, wishes.transparent)
    return made.shape[1], made


def _scene(part: Formula, program: Program, shown: Shown) -> Scene:
    """What is shown of a part, ready to be drawn. Errors: E111."""
    scene = Scene(part, program.ranges, bound_cells(part, shown.box), shown)
    if scene.cells.empty:
        raise fail("E111", "nothing solid lies in what is to be shown",
                   hint="solid is negative: widen --bounds, or take a --cut away")  # fmt: skip
    return scene


def _met(
    scene: Scene, camera: Camera, size: tuple[int, int], samples: int, wishes: Wishes, tight: bool, bare: bool
) -> tuple[Camera, Marcher, Distances]:
    """Where rays meet a part, and from where they are cast: from `camera`, or if `tight` from as near as it can be."""
    from porelang.gpu.fields import gpu

    device = gpu("person")
    nearer = _nearer(scene, camera, size, device, wishes) if tight else camera
    marcher = Marcher(scene, nearer, size, device, samples, bare)
    distance = marcher.distances((0, 1, 3))
    if nearer is not camera and wishes.zoom <= 1 and touches_rim(distance):  # so thin that the coarse picture missed it
        marcher = Marcher(scene, camera, size, device, samples, bare)
        return camera, marcher, marcher.distances((0, 1, 3))
    return nearer, marcher, distance


def _nearer(scene: Scene, camera: Camera, size: tuple[int, int], device: Gpu, wishes: Wishes) -> Camera:
    """The camera that just takes in the surface that is seen, as far as a coarse picture shows it."""
    small = coarse(size)
    found = look(scene.box, wishes.view, size, wishes.projection)
    for _ in range(ROUNDS):
        marcher = Marcher(scene, found, small, device)
        places = met(found, small, marcher.distances())
        if not len(places):
            return camera
        before, found = found, closer(found, size, places, marcher.pixel)
        if found.pixel(small, scene.box) > SMALL * before.pixel(small, scene.box):
            break
    return zoomed(found, wishes.zoom)


def _samples(wishes: Wishes, strip: int) -> tuple[tuple[int, int], int]:
    """The size that is drawn beside a strip, and its samples along a pixel's side: fewer where it is large.

    Errors: E114.
    """
    width, height = max(1, wishes.size[0] - strip), wishes.size[1]
    for n in range(wishes.samples, 0, -1):
        if width * height * n * n <= MOST_SAMPLES:
            return (width * n, height * n), n
    raise fail("E114", f"a picture of {width} x {height} pixels is too large",
               hint=f"{MOST_SAMPLES // 1_000_000} million pixels are the most")  # fmt: skip
