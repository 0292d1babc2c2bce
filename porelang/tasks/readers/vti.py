"""`.vti`: a regular grid as VTK writes it (ImageData), of values at its nodes or in its cells."""

from __future__ import annotations

from typing import BinaryIO
from xml.etree.ElementTree import Element

import numpy as np

from porelang.data import MOST_COUNTED
from porelang.tasks.readers.asked import Array, Asked, layered
from porelang.tasks.readers.grid import Grid, grid_of
from porelang.tasks.readers.tensors import are_named, components
from porelang.tasks.readers.vtkxml import Document, names_of, opened

HINT = "export it as .vti or .vtu with ParaView, VTK or meshio"


def read(asked: Asked, file: BinaryIO, size: int) -> Grid:
    """The array of that name, of points or else of cells; cells are sampled at their middles. Errors: E131-E135."""
    document = opened(asked, file, size)
    pieces = document.pieces("ImageData")
    section, arrays = document.named(pieces)
    image = document.root.find("ImageData")
    assert image is not None
    _upright(asked, image)
    origin, spacing = (
        _numbers(asked, image, name, 3, default) for name, default in (("Origin", 0.0), ("Spacing", 1.0))
    )
    ends = _extent(asked, image, "WholeExtent")
    shape = ends[:, 1] - ends[:, 0] + (1 if section == "PointData" else 0)
    if max(shape) > MOST_COUNTED:
        raise asked.too_large(f"it claims {max(shape):,} nodes along an axis; float32 counts {MOST_COUNTED:,}")
    layered(asked, shape.tolist(), "nodes" if section == "PointData" else "cells")
    whole = _whole(document, pieces, arrays, ends, shape, section == "PointData")
    first, spacing = asked.mm * (origin + spacing * ends[:, 0]), asked.mm * spacing
    x, y, z = first.tolist()
    dx, dy, dz = spacing.tolist()
    names = names_of(arrays[0])
    values = components(asked, whole, names)
    return grid_of(asked, values, (x, y, z), (dx, dy, dz), section == "CellData", are_named(names, whole.shape[-1]))


def _whole(
    document: Document, pieces: list[Element], arrays: list[Element], ends: Array, shape: Array, nodes: bool
) -> Array:
    """The values of all pieces (nx, ny, nz, k), which together cover the whole."""
    out: Array | None = None
    covered = 0
    for piece, element in zip(pieces, arrays, strict=True):
        part = _extent(document.asked, piece, "Extent")
        own = part[:, 1] - part[:, 0] + (1 if nodes else 0)
        if (part[:, 0] < ends[:, 0]).any() or (part[:, 1] > ends[:, 1]).any() or (own < 1).any():
            raise document.asked.damaged("a piece of it reaches beyond the whole")
        values = document.array(element, int(np.prod(own, dtype=object)), f"`{document.asked.name}`")
        nx, ny, nz = own.tolist()
        values = values.reshape(nz, ny, nx, -1).transpose(2, 1, 0, 3)
        if len(pieces) == 1 and (own == shape).all():
            return values
        if out is None:
            if np.prod(shape, dtype=object) * values.shape[3] * 8 > 4 * 2e9 or len(pieces) > 10_000:
                raise document.asked.too_large(f"it claims {np.prod(shape, dtype=object):,} nodes")
            out = np.full((*shape.tolist(), values.shape[3]), np.nan)
        if values.shape[3] != out.shape[3]:
            raise document.asked.damaged("its pieces have different numbers of components")
        i, j, k = (part[:, 0] - ends[:, 0]).tolist()
        place = out[i : i + nx, j : j + ny, k : k + nz]
        covered += int(np.isnan(place[..., 0]).sum())
        place[...] = values
    if out is None or covered < int(np.prod(shape, dtype=object)):
        raise document.asked.damaged("its pieces do not cover the whole")
    return out


def _upright(asked: Asked, image: Element) -> None:
    turned = _numbers(asked, image, "Direction", 9, None)
    if len(turned) and not np.allclose(turned.reshape(3, 3), np.eye(3), atol=1e-9):
        text = f"the grid of `{asked.path}` is turned: its axes are not x, y and z"
        raise asked.fail("E133", text, "resample it on an upright grid (in ParaView: Resample To Image)")


def _extent(asked: Asked, element: Element, name: str) -> Array:
    """First and last node along each axis (3, 2)."""
    text = element.get(name, "").split()
    try:
        ends = np.array([int(t[:19]) for t in text], np.int64).reshape(3, 2)
    except (ValueError, OverflowError):
        raise asked.damaged(f"`{name}` is `{' '.join(text)}`") from None
    if (np.abs(ends) > 2**40).any() or (ends[:, 1] < ends[:, 0]).any():
        raise asked.damaged(f"`{name}` is `{' '.join(text)}`")
    return ends


def _numbers(asked: Asked, element: Element, name: str, count: int, default: float | None) -> Array:
    text = element.get(name)
    if text is None:
        return np.full(count, default) if default is not None else np.empty(0)
    try:
        return np.array([float(t) for t in text.split()]).reshape(count)
    except ValueError:
        raise asked.damaged(f"`{name}` is `{text}`") from None
