"""A part as a function in a 3MF file: a level set of the Volumetric extension, over a graph of the Implicit one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from porelang.analysis.box import Box
from porelang.atomic import replace_file
from porelang.backends.implicit import IMAGES, STEPS, Function, Image, Unwritable, function
from porelang.diagnostics import PoreError, fail
from porelang.field import Bounds, checked_bounds
from porelang.interval import Interval
from porelang.ir import Node
from porelang.mesh.part import notes_of
from porelang.program import Design
from porelang.progress import activity, tell
from porelang.solid import Solid
from porelang.threemf.package import box_mesh, grey, package
from porelang.threemf.places import place_of, roomy
from porelang.walls import thinnest

WRITING = "writing the function"
VOLUMETRIC = "http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01"
IMPLICIT = "http://schemas.3mf.io/3dmanufacturing/implicit/2023/12"
#: What operations that cannot be written are in the language.
_CALLED = {
    "nearest": "the nearest bar",
    "joined": "bars that are joined",
    "sites": "random sites",
    "random": "noise",
    "principal": "principal values",
    "lookup": "the gradient of samples",
    "lookup_cubic": "samples with a smooth gradient",
}
_BARS = frozenset({"nearest", "joined"})


def write_field(
    design: Design, path: str | Path, *, name: str | None = None, bounds: Bounds | None = None
) -> dict[str, Any]:
    """Write an output as a function of the place, in mm: solid where it is negative, in its box or in `bounds`.

    The file appears whole or not at all. Returns how many nodes there are, in which box, and which images.
    Errors: E197 for what no function can say, E113 for a file that cannot be written, those of outputs and bounds.
    """
    box = checked_bounds(bounds) if bounds is not None else roomy(design.bounds(name))
    name = design.program.output(name)
    formula = design.of(name)
    space = [Interval(np.array([a]), np.array([b]), np.array([False])) for a, b in zip(*roomy(box), strict=True)]
    try:
        made = function(formula, space, quoteattr(name))
    except Unwritable as error:
        raise _refused(design, name, error.node) from None
    wall = thinnest(Solid(formula, (box.lo, box.hi)))
    with (
        replace_file(path) as file,
        activity(WRITING),
        package(
            file, notes_of(design, name), build=made.id + 1, extensions={"v": VOLUMETRIC, "i": IMPLICIT},
            required=("v", "i"), pictures=_pictures(made),
        ) as model,
    ):  # fmt: skip
        for text in _resources(made, box, wall):
            model.write(text.encode())
    return {
        "output": name,
        "nodes": made.nodes,
        "lo": list(box.lo),
        "hi": list(box.hi),
        "wall": wall,
        "images": [{"nodes": list(image.field.shape), "error": image.error} for image in made.images],
        "bytes": Path(path).stat().st_size,
    }


def _resources(made: Function, box: Box, wall: float | None) -> Iterator[str]:
    """The box, the images, the function that reads them, and the level set of that: each before it is referred to."""
    yield f'\n<object id="1" type="model" name="box">{box_mesh(box.lo, box.hi)}</object>\n'
    for k, image in enumerate(made.images):
        columns, rows, sheets = image.field.shape
        listed = "".join(f'<v:imagesheet path="/{_sheet(k, i)}"/>' for i in range(sheets))
        yield (
            f'<v:image3d id="{IMAGES + 2 * k}"><v:imagestack rowcount="{rows}" columncount="{columns}" '
            f'sheetcount="{sheets}">{listed}</v:imagestack></v:image3d>\n'
            f'<v:functionfromimage3d id="{IMAGES + 2 * k + 1}" image3did="{IMAGES + 2 * k}" filter="linear" '
            'tilestyleu="clamp" tilestylev="clamp" tilestylew="clamp"/>\n'
        )
    yield made.text
    # What is undefined is outside: a value of 0 would be surface.
    least = f' minfeaturesize="{wall:.3g}"' if wall else ""
    yield (
        f'<object id="{made.id + 1}" type="model"><v:levelset functionid="{made.id}" channel="shape" meshid="1" '
        f'meshbboxonly="true" fallbackvalue="1"{least}/></object>\n'
    )


def _sheet(image: int, sheet: int) -> str:
    return f"3D/volumetric/image{image}/sheet{sheet:05d}.png"


def _pictures(made: Function) -> Iterator[tuple[str, bytes]]:
    """The sheets of all images, from below; in each columns go along x, and rows from the last y to the first: the
    rows of a picture go down, and v goes up."""
    of = sum(image.field.shape[2] for image in made.images)
    done = 0
    for k, image in enumerate(made.images):
        for i in range(image.field.shape[2]):
            yield _sheet(k, i), grey(_greys(image, i))
            done += 1
            tell(done, of)


def _greys(image: Image, sheet: int) -> np.ndarray[Any, np.dtype[np.uint16]]:
    values = image.field.values[:, ::-1, sheet, image.component].T.astype(np.float64)
    return np.rint((values - image.low) / image.span * STEPS).astype(np.uint16)


def _refused(design: Design, name: str, n: Node) -> PoreError:
    """E197 at the place that asks for what the extension cannot say."""
    what = _CALLED.get(n.op, f"`{n.op}`")
    # samples can be written, their derivatives cannot
    span = place_of(design, name, "d" if n.op == "lookup" else n.op)
    wanted = span.text if "\n" not in span.text and len(span.text) < 40 else "f"
    # samples lose what is thin between them, and nothing later could tell: so it is told here
    sampled = (
        f"`sample({wanted}, 1mm, body)` makes an image of it, over the box of a solid, here called `body`; with "
        "fewer than some four samples to the thinnest wall (`min_wall`) that is lost or thinner"
    )
    ways = {
        "lookup_cubic": "leave out `smooth=true`: images are read linearly",
        **dict.fromkeys(_BARS, f"{sampled}; `pore mesh FILE -o part.3mf --beams` writes bars alone as bars"),
    }
    return fail(
        "E197", f"{what}: no function of 3MF can say that", span, label="asked for here", hint=ways.get(n.op, sampled)
    )
