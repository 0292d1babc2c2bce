"""Every figure as a picture: python examples/figures/draw.py docs/figures [fig08*], all of them or those that match."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import porelang
from porelang.field import Bounds
from porelang.render.cuts import HalfSpace
from porelang.render.picture import render_output
from porelang.render.planes import Plane
from porelang.render.wishes import Wishes

HERE = Path(__file__).parent
COLOURS = 256  # of a picture's palette; planes behind glass have more
THREE_PLANES = tuple(Plane(axis, 0.0) for axis in range(3))

# Pictures that are compared have one frame.
SAMPLE = Wishes(size=(560, 560), view=(-65, 25), frame="bounds")
FIELD = Wishes(size=(640, 560), view=(-60, 28), slices=THREE_PLANES, solid="glass", legend="mm")
# The paper cuts its cylinders along the planes XY and XZ: a quarter is taken out, and both sections are seen.
QUARTER = (HalfSpace(1, True, 0.0), HalfSpace(2, False, 0.0))
SPECIMEN = Wishes(size=(480, 800), view=(-68, 22), cuts=(QUARTER,), frame="bounds")
FRAMES = Wishes(size=(480, 390), view=(-90, 90), projection="orthographic", slices=(Plane(2, 7.0),), field="lattice")


@dataclass(frozen=True, slots=True)
class Drawing:
    """How a figure is drawn: what is shown of which output, and the bounds where it is cut."""

    wishes: Wishes
    bounds: Bounds | None = None
    output: str | None = None


SHEET = (-75.0, -60.0, 0.0, 75.0, 60.0, 8.0)

#: By the first letters of a figure's name.
DRAWINGS = {
    "fig01": Drawing(SAMPLE),
    "fig04": Drawing(SAMPLE),
    "fig05": Drawing(FIELD, (-50.0, -50.0, -50.0, 50.0, 50.0, 50.0)),
    "fig05f": Drawing(replace(FIELD, legend=""), (-50.0, -50.0, -50.0, 50.0, 50.0, 50.0)),
    "fig06": Drawing(replace(FIELD, size=(480, 720), field="modifier", legend="")),
    "fig07a": Drawing(replace(FRAMES, solid="none"), SHEET),
    "fig07b": Drawing(replace(FRAMES, field="distance", legend="mm"), SHEET),
    "fig07c": Drawing(replace(FRAMES, field="distance"), SHEET),
    "fig07d": Drawing(FRAMES, SHEET, "distance"),
    "fig08": Drawing(SPECIMEN),
    "fig09": Drawing(SPECIMEN),
    "fig10": Drawing(SPECIMEN),
    "fig11": Drawing(Wishes(size=(112, 112), view=(-60, 28), frame="bounds")),
}


def drawing(path: Path) -> Drawing:
    """How a figure is drawn: as its part (a letter) is, or its number."""
    return DRAWINGS.get(path.stem[:6]) or DRAWINGS[path.stem[:5]]


def drawn(path: Path) -> Image.Image:
    """The picture of a program."""
    design, how = porelang.compile(path=path).design(), drawing(path)
    return Image.fromarray(render_output(design, how.output, how.wishes, how.bounds).pixels).convert("RGB")


def sheet(path: Path, across: str = "w", up: str = "d", unit: float = 10.0) -> Image.Image:
    """The samples of a grid search over two params, the first along x (in `unit`), the second along y, upward."""
    program, wishes = porelang.compile(path=path), drawing(path).wishes
    xs, ys = (steps_of(program, name) for name in (across, up))
    (width, height), left, foot = wishes.size, 60, 30
    page = Image.new("RGB", (left + width * len(xs), height * len(ys) + foot), "white")
    pen, letters = ImageDraw.Draw(page), ImageFont.load_default(13)
    for (i, a), (j, b) in product(enumerate(xs), enumerate(ys)):
        pixels = render_output(program.design({across: a, up: b}), None, wishes).pixels
        page.paste(Image.fromarray(pixels).convert("RGB"), (left + width * i, height * (len(ys) - 1 - j)))
    for i, a in enumerate(xs):
        pen.text((left + width * (i + 0.5), page.height - foot / 2), f"W {a / unit:.1f}", "black", letters, anchor="mm")
    for j, b in enumerate(ys):
        pen.text((left / 2, height * (len(ys) - j - 0.5)), f"D {b:+.1f}", "black", letters, anchor="mm")
    return page


def steps_of(program: porelang.Program, name: str) -> list[float]:
    """The values of a param, from one end of its range to the other, a step apart."""
    info = program.params[name]
    count = round((info.high - info.low) / info.step) if info.step else 1
    return [float(v) for v in np.linspace(info.low, info.high, count + 1).round(9)]


def main(folder: Path, wanted: str = "*") -> None:
    """Draw the figures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(HERE.glob(f"{wanted}.pore")):
        picture = sheet(path) if path.stem.startswith("fig11") else drawn(path)
        if drawing(path).wishes.solid != "glass":
            picture = picture.quantize(COLOURS, dither=Image.Dither.NONE)
        target = folder / f"{path.stem}.png"
        picture.save(target, optimize=True)
        print(f"{target}  {target.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(Path(sys.argv[1]), *sys.argv[2:])
