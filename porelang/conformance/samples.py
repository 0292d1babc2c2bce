"""What operations are judged on that are not swept over numbers: a grid of values, a frame of bars, small, and hard as
data can be, a field of tensors, and cells of random sites."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np

from porelang.data import NEAREST, Data, SampledField, Segments
from porelang.formula import Bindings
from porelang.ir import ZERO, Node, X, Y, Z, const, node
from porelang.ops import Op
from porelang.ops.joints import WIDER

#: The files that generated programs name, and the slots that stand for them in graphs.
GRID_FILE, GRID_NAME, FRAME_FILE = "grid.npz", "value", "frame.json"
GRID: Node = node("load", value=(GRID_FILE, GRID_FILE, GRID_NAME, 1))
#: The radius of fillets between bars of the frame, and what the operation that joins them takes for it.
FILLET = 1.25
JOINT: Node = const(FILLET * WIDER)
BARS: Node = node("frame", value=(FRAME_FILE, FRAME_FILE))


@cache
def grid() -> SampledField:
    """Values of all sizes on 7 x 5 x 9 nodes, unevenly spaced and off the origin: smooth, level, rough and jumping."""
    rng = np.random.default_rng(8)
    i, j, k = np.meshgrid(np.arange(7), np.arange(5), np.arange(9), indexing="ij")
    values = np.sin(0.7 * i) * np.cos(0.5 * j) + 0.1 * k
    values[:, :, 4] = 0.25  # level
    values[4:, :, 5:] += rng.uniform(-1, 1, (3, 5, 4))  # rough
    values[:, 3:, :2] += 100.0  # a jump
    return SampledField.from_array(
        np.stack([values, rng.uniform(-3, 3, values.shape)], -1), (-17.3, -9.1, -25.7), (5.5, 4.3, 6.1)
    )


@cache
def bars() -> Segments:
    """Forty bars of unlike lengths and radii within 25 mm, some that cross, some along the axes, some of no radius."""
    rng = np.random.default_rng(9)
    starts, ends = rng.uniform(-25, 25, (2, 40, 3))
    ends[:6] = starts[:6] + np.eye(3)[[0, 1, 2, 0, 1, 2]] * 7.5
    ends[6:10] = starts[6:10] + rng.uniform(-0.05, 0.05, (4, 3))
    starts[10:14] = ends[14:18]
    radii = rng.uniform(0.2, 3.0, 40)
    radii[18:22] = 0.0
    return Segments(starts, ends, radii)


def bindings() -> Bindings:
    """The slots of the samples, bound."""
    return {GRID: grid(), BARS: bars()}


def write(folder: Path) -> None:
    """The files that generated programs name, for whoever compiles one in this folder; no bar is thinner than a file
    may say."""
    values, bars_ = grid(), bars()
    level = np.ones(values.shape)
    with (folder / GRID_FILE).open("wb") as file:
        np.savez(file, value=values.values[..., 0], level=level, origin=values.origin, spacing=values.spacing)
    nodes = np.concatenate([bars_.starts, bars_.ends]).tolist()
    joined = [[i, i + len(bars_)] for i in range(len(bars_))]
    frame = {"nodes": nodes, "bars": joined, "radii": np.maximum(bars_.radii, NEAREST).tolist()}
    (folder / FRAME_FILE).write_text(json.dumps(frame), encoding="utf-8")


def slot(kind: str) -> Node:
    """The slot of data of a kind."""
    return GRID if kind == "grid" else BARS


def tensor() -> tuple[Node, ...]:
    """The components of a tensor field: where x <= y <= z <= 0 along the axes, on the diagonals with values that are
    one, at the origin 0; nowhere smooth everywhere, and beyond the grid great."""
    xy, yz = node("max", X - Y, ZERO), node("max", Y - Z, ZERO)
    return (X, Y, Z, 0.5 * xy, 0.25 * node("min", xy, yz), 0.125 * node("max", Z, ZERO))


def arguments(row: Op) -> tuple[Node, ...]:
    """What an operation is judged on: a tensor, a place with a seed and more, or the slot of its data and a place."""
    match row.name:
        case "principal":
            return tensor()
        case "random":
            return (X, Y, Z, const(7.0))
        case "sites":
            return (0.25 * X, 0.25 * Y, 0.25 * Z, const(7.0), const(0.875))
    return (slot(row.args[0]), X, Y, Z, *(JOINT,) * (len(row.args) - 4))


def data(kind: str) -> Data:
    """Data of a kind."""
    return grid() if kind == "grid" else bars()
