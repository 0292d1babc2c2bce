"""A picture as it is handed on: pixels, how they came about, and how they are written and shown."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from porelang.diagnostics import Diagnostic, fail


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Picture:
    """Pixels (height, width, 4), 8 bits, top row first, colours not multiplied by alpha; and how they came about.

    `pixel` is the size of one in mm at the middle of the part, `covered` the share of the picture where the part is
    seen, `steps` the samples of the field for a ray on average, `scale` that of the field's colours, `colours` that of
    each output where there are several, `deformed` by how much displacements are magnified where they are drawn, `told`
    what is doubtful about what it shows.
    """

    pixels: NDArray[np.uint8]
    camera: Any  # a `porelang.render.Camera`
    pixel: float
    covered: float
    steps: float
    scale: Any  # a `porelang.render.scale.Colouring`, or None
    backend: str
    seconds: float
    transparent: bool = False
    colours: tuple[tuple[str, tuple[int, int, int]], ...] = ()
    deformed: Any = None  # a `porelang.render.deform.Deformed`, or None
    told: tuple[Diagnostic, ...] = ()

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"<picture of {width} x {height} pixels of {self.pixel:.3g} mm>"

    @property
    def array(self) -> NDArray[np.uint8]:
        """Red, green and blue (height, width, 3), 8 bits, top row first; on white where it is transparent."""
        share = self.pixels[..., 3:].astype(np.float32) / 255
        mixed = self.pixels[..., :3] * share + 255 * (1 - share)
        return np.asarray(np.rint(mixed), np.uint8)

    def save(self, path: str | Path) -> None:
        """Write it as PNG, whole or not at all. Errors: E112 for another ending, E113."""
        if Path(path).suffix.lower() != ".png":
            raise fail("E112", f"{path}: pictures are written as .png", hint="end the name with .png")
        write_png(self, str(path), self.transparent)

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        _put_png(self, file, self.transparent)
        return file.getvalue()


def write_png(picture: Picture, path: str, transparent: bool = False) -> None:
    """Write a picture, whole or not at all. Errors: E113."""
    from porelang.atomic import save  # `pore check` starts without it

    save(path, lambda file: _put_png(picture, file, transparent))


def _put_png(picture: Picture, file: BinaryIO, transparent: bool) -> None:
    from PIL import Image

    Image.fromarray(picture.pixels if transparent else np.ascontiguousarray(picture.pixels[..., :3])).save(file, "PNG")
