"""`.vtu`: cells as VTK writes them (UnstructuredGrid), with values at their points or in them."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from porelang.tasks.readers.asked import Array, Asked
from porelang.tasks.readers.cells import Block, Cells, blocks, cells
from porelang.tasks.readers.tensors import are_named, components
from porelang.tasks.readers.vtkxml import names_of, opened


def read(asked: Asked, file: BinaryIO, size: int) -> Cells:
    """The array of that name, of points or else of cells, in all pieces. Errors: E131-E135, E150, E151."""
    document = opened(asked, file, size)
    pieces = document.pieces("UnstructuredGrid")
    section, arrays = document.named(pieces)
    points: list[Array] = []
    values: list[Array] = []
    listed: list[Block] = []
    before = of_cells = 0
    for piece, element in zip(pieces, arrays, strict=True):
        point_count, cell_count = document.count(piece, "NumberOfPoints"), document.count(piece, "NumberOfCells")
        kinds = document.array(piece.find("Cells/DataArray[@Name='types']"), cell_count, "the list of kinds of cells")
        ends = document.array(piece.find("Cells/DataArray[@Name='offsets']"), cell_count, "the list of offsets")
        ends = ends[:, 0].astype(np.int64)
        length = int(ends[-1]) if cell_count else 0
        named = document.array(piece.find("Cells/DataArray[@Name='connectivity']"), max(length, 0), "the list of cells")
        place = document.array(piece.find("Points/DataArray"), point_count, "the list of points")
        count = point_count if section == "PointData" else cell_count
        value = document.array(element, count, f"`{asked.name}`")
        if place.shape[1] != 3:
            raise asked.damaged(f"its points have {place.shape[1]} coordinates")
        offsets = np.concatenate([np.zeros(1, np.int64), ends])
        for block in blocks(asked, kinds[:, 0].astype(np.int64), offsets, named[:, 0].astype(np.int64)):
            if block.points.size and not 0 <= int(block.points.min()) <= int(block.points.max()) < point_count:
                raise asked.damaged(f"a cell names point {int(block.points.max()):,} of {point_count:,}")
            listed.append(Block(block.kind, block.points + before, block.numbers + of_cells))
        points.append(place.astype(np.float64) * asked.mm)
        values.append(value)
        before, of_cells = before + point_count, of_cells + cell_count
    if len({v.shape[1] for v in values}) > 1:
        raise asked.damaged("its pieces have different numbers of components")
    names = names_of(arrays[0])
    listed_values = np.concatenate(values)
    whole, in_order = components(asked, listed_values, names), are_named(names, listed_values.shape[-1])
    return cells(asked, np.concatenate(points), listed, whole, section == "CellData", in_order)
