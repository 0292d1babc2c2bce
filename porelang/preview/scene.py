"""What a page needs to draw outputs of a design: shaders' texts, and the values and textures that they read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import Box, around
from porelang.backends.glsl import Form, Shader, shader
from porelang.diagnostics import fail
from porelang.field import make_field
from porelang.formula import Formula
from porelang.gpu.fields import LONGEST, resident
from porelang.ir import Node
from porelang.program import Design, Program
from porelang.progress import checkpoint
from porelang.render.cells import BUDGET, VOID, Cells, bound_cells
from porelang.render.march import MATERIAL, SECTION
from porelang.render.painting import BODIES
from porelang.render.picture import bodies_of, field_of, legend_of
from porelang.render.planes import BEYOND
from porelang.render.scale import Colouring, fitting
from porelang.render.studied import is_result, studied
from porelang.tape import operations

#: How far the box reaches beyond the part, in its longest side: rays begin outside of the part.
ROOM = 1e-3
#: Enclosures that cells may cost which are drawn with while a slider moves: some 20 ms.
QUICK = 1_000_000
#: Words in a row of a texture of data; the shader reads word i at (i % ROW, i / ROW).
ROW = 2048
#: Places that are looked at for the range of a scale.
SURVEYED = 20_000


@dataclass(frozen=True, slots=True)
class Wish:
    """What of a design is drawn: outputs by name (none: `part`, or the first that may be solid), in the colours of a
    field that a text names or says (none: their own), and whether a plane through them shows it."""

    outputs: tuple[str, ...] = ()
    paint: str = ""
    plane: bool = False


@dataclass(frozen=True, slots=True)
class Layer:
    """A shader for WebGL 2 and what it reads: `numbers` are its array `u`, `data` the textures of words.

    Two whose `text` is the same differ in nothing that has to be compiled.
    """

    name: str
    text: str
    numbers: NDArray[np.float32]
    data: tuple[NDArray[np.uint32], ...]


@dataclass(frozen=True, slots=True)
class Body:
    """An output: its layer, its box in mm, what is proven of the field in parts of the box, and its colours in the
    light and where it is cut (red, green, blue, 0 to 1)."""

    layer: Layer
    box: Box
    cells: Cells
    colour: tuple[float, ...]
    section: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Scene:
    """What a page draws. `plane` is the layer of a plane, drawn within `stage`; `scale` is that of the colours, of
    `shown`, and `unit` what it is in. Something is `shown` and has no scale where it is nowhere a number."""

    bodies: tuple[Body, ...]
    plane: Layer | None
    stage: Box
    scale: Colouring | None
    shown: str
    unit: str


def scene(design: Design, wish: Wish | None = None, budget: int = BUDGET) -> Scene:
    """The scene of what is wished of a design. With a small `budget` of enclosures it is there sooner, and drawn more
    slowly.

    Errors: E100-E103 about the outputs, E111 where nothing is solid, E121 for a program that no driver compiles, those
    of the field that is shown.
    """
    wish = wish or Wish()
    program = design.program
    names = list(dict.fromkeys(program.output(n) for n in wish.outputs)) or [usual(program)]
    if len(names) > len(BODIES):
        raise fail("E108", f"{len(names)} outputs are to be drawn, and there are {len(BODIES)} colours for them",
                   hint=f"choose {len(BODIES)} at a time")  # fmt: skip
    paint, called, unit = None, "", ""
    if wish.paint:
        found = field_of(program, wish.paint, "colour by")
        called, unit = found.text, legend_of(found)
        paint = found.roots[0]
        of_study = studied(design, found.roots) if is_result(found) else None
        paint = paint if of_study is None else of_study.known_root(paint)
    bodies = []
    for name in names:
        bodies.append(_body(design, name, paint, budget, many=len(names) > 1))
        checkpoint()
    stage = around([b.box for b in bodies])
    if not wish.plane and paint is None:
        return Scene(tuple(bodies), None, stage, None, "", "")
    if paint is None:  # the part's own field is seen around it too
        stage = stage.grown(BEYOND)
    root = program.solid(names[0])
    shown = root if paint is None else paint
    formulas = [design.formula(shown, program.solid(name)) for name in names]
    plane = _layer(names[0], formulas[0], design, "plane") if wish.plane else None
    values = [make_field(formula, program.ranges, "numpy", "f32") for formula in formulas]
    scale = _scale(values, bodies, within=paint is not None)
    if scale is None:  # nor does it give colours
        return replace(scene(design, Wish(wish.outputs), budget), shown=called or names[0])
    return Scene(tuple(bodies), plane, stage, scale, called or names[0], unit)


def usual(program: Program) -> str:
    """The output that is drawn unless told: `part`, or the first that may be solid. Errors: E100."""
    bodies = bodies_of(program)
    return program.output(bodies[0] if bodies and "part" not in program.outputs else None)


def _body(design: Design, name: str, paint: Node | None, budget: int, many: bool) -> Body:
    root = design.program.solid(name)
    part = design.formula(root)
    box = design.bounds(name).grown(ROOM)
    cells = bound_cells(part, box, budget)
    if cells.empty:
        raise fail("E111", f"nothing of `{name}` is solid", hint="solid is negative: look at the sign of its field")
    layer = _layer(name, part if paint is None else design.formula(root, paint), design, "webgl")
    if paint is not None:
        return Body(layer, box, cells, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    if not many:
        return Body(layer, box, cells, _floats(MATERIAL), _floats(SECTION))
    known = bodies_of(design.program)
    own = _floats(np.array(BODIES[known.index(name) % len(BODIES)]) / 255)
    return Body(layer, box, cells, own, own)


def _layer(name: str, formula: Formula, design: Design, form: Form) -> Layer:
    if (length := operations(formula.roots)) > LONGEST:
        raise fail("E121", f"the program is too long for a shader: {length:,} operations, where drivers manage "
                   f"{LONGEST:,}", hint="`pore mesh --backend numpy` has no such limit")  # fmt: skip
    root, *others = formula.roots
    if form == "webgl":
        made = shader((root,), dict(design.program.ranges), form, others[0] if others else None)
    else:
        made = shader(formula.roots, dict(design.program.ranges), form)
    return Layer(name, made.text, _numbers(formula, made), tuple(np.ravel(w()) for _, w in resident(formula, made)))


def _numbers(formula: Formula, made: Shader) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        return np.array(formula.with_roots(*made.uniforms).numbers, dtype=np.float32)


def _scale(values: Sequence[Callable[[Any], Any]], bodies: Sequence[Body], within: bool) -> Colouring | None:
    """The scale that takes in a field `within` the bodies, or in the cells around them: farther out the field of a part
    goes on to many times what it is there. None where it is nowhere a number. `values` of each body are those of the
    field, and of the body."""
    random = np.random.default_rng(1)
    inside, beside = [], []
    for of_body, body in zip(values, bodies, strict=True):
        full = np.argwhere(body.cells.values != VOID)
        some = full[random.integers(len(full), size=SURVEYED)]
        edge = np.array(body.box.size) / body.cells.counts
        places = np.array(body.box.lo) + (some + random.uniform(size=some.shape)) * edge
        shown, solid = np.asarray(of_body(places)).T
        known = np.isfinite(shown)
        inside.append(shown[known & (solid <= 0)])
        beside.append(shown[known])
    # walls may be so thin that no place is in one
    found = np.concatenate(inside if within and any(map(len, inside)) else beside)
    return fitting(found.astype(np.float64)) if len(found) else None


def _floats(colour: NDArray[Any]) -> tuple[float, ...]:
    return tuple(float(c) for c in colour)
