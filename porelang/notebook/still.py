"""A still picture of a program or a design, and the tables: what is seen of it where no widgets run."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.preview.scene import usual
from porelang.program import Design, Program
from porelang.session.jobs import Jobs
from porelang.settings import Setting

#: Seconds that a picture may take: nobody has asked for it.
PATIENCE = 4.0
#: Of a still picture, in pixels; it is kept in the notebook twice.
SIZE = (400, 300)
COLOURS = 64


def fallback(
    shown: Program | Design,
    settings: Mapping[str, Setting],
    outputs: Sequence[str] = (),
    known: bytes | None = None,
) -> tuple[dict[str, str], bytes]:
    """What is seen where no widgets run, by MIME type, and the picture in it, which may be `known`; none where there
    can be none."""
    png = still(shown, settings, outputs) if known is None else known
    data = {"text/plain": repr(shown), "text/html": shown._repr_html_()}
    if png:
        text = base64.b64encode(png).decode()
        # readers take HTML rather than a picture, and see one, or a picture alone, as LaTeX does
        data["text/html"] = f'<img alt="the part" src="data:image/png;base64,{text}">{data["text/html"]}'
        data["image/png"] = text
    return data, png


def still(shown: Program | Design, settings: Mapping[str, Setting], outputs: Sequence[str] = ()) -> bytes:
    """A small picture, as PNG; none where it cannot be had, or would take long."""
    from porelang.render.picture import render_output
    from porelang.render.wishes import Wishes

    def work() -> bytes:
        design = shown.design(settings)
        names = list(outputs) or usual(design.program)
        return small(render_output(design, names, Wishes(size=SIZE, samples=2)).array)

    job = Jobs().submit("still", work)
    try:
        return job.result(PATIENCE)
    except Exception:  # no OpenGL, nothing solid, too slow: there are the tables
        job.cancel()
        return b""


def small(pixels: NDArray[np.uint8], colours: int = COLOURS) -> bytes:
    """A picture (height, width, 3) as PNG, in few colours: it is a quarter as long, and looks the same."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).quantize(colours).save(file, "PNG", optimize=True)
    return file.getvalue()
