"""A box made smaller round a solid that may fill all of it: layers at its faces, and cells, that are proven void are
dropped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.backwards import UNIVERSE
from porelang.analysis.enclose import boxes, enclose
from porelang.formula import Formula

Points = NDArray[np.float64]

_TURNS = 4  # of layers looked at, each time between those that were void and the first that was not
_DEPTHS = 32  # layers looked at in one turn
_COARSE, _FINEST = 8, 32  # cells along each side


def shaved(formula: Formula, lo: Points, hi: Points) -> tuple[Points, Points] | None:
    """The box `lo..hi` of a solid that reaches the end of the universe by its formula, made smaller: so that it does
    not, if that can be proven, and not tight. None where the solid is empty."""
    finest = _FINEST if len(formula.tape) < 300 else _FINEST // 2 if len(formula.tape) < 3000 else _COARSE
    for axis in range(3):
        for side in (-1, 1):
            _shave(formula, lo, hi, axis, side)
    cells = _COARSE
    for _ in range(60):
        low, high = _split(lo, hi, cells)
        kept = _possible(formula, low, high)
        if not kept.any():
            return None
        before = np.prod(hi - lo)
        lo, hi = low[kept].min(axis=0), high[kept].max(axis=0)
        if np.prod(hi - lo) < 0.9 * before:
            continue
        if cells >= finest or max(-lo.min(), hi.max()) < UNIVERSE:
            break
        cells *= 2
    return lo, hi


def _possible(formula: Formula, lo: Points, hi: Points) -> NDArray[np.bool_]:
    """Whether any material is possible in each of n boxes, given by their corners (n, 3)."""
    r = enclose(formula, boxes(lo, hi))[0].range
    return np.broadcast_to(~(r.lo >= 0), len(lo))


def _split(lo: Points, hi: Points, cells: int) -> tuple[Points, Points]:
    """The corners (n, 3) of the cells of a box."""
    index = np.stack(np.meshgrid(*3 * [np.arange(cells)], indexing="ij"), axis=-1).reshape(-1, 3)
    step = (hi - lo) / cells
    return lo + index * step, np.where(index + 1 == cells, hi, lo + (index + 1) * step)


def _shave(formula: Formula, lo: Points, hi: Points, axis: int, side: int) -> None:
    """Move a face of the box inward as far as the layer before it is proven void, as a whole."""
    end, width = (hi if side > 0 else lo)[axis], side * (hi - lo)[axis]
    proven, failed = 0.0, 1.0  # shares of the width
    for _ in range(_TURNS):
        shares = proven + (failed - proven) * (np.arange(1, _DEPTHS + 1) / (_DEPTHS + 1))
        low, high = np.tile(lo, (_DEPTHS, 1)), np.tile(hi, (_DEPTHS, 1))
        (low if side > 0 else high)[:, axis] = end - shares * width
        solid = _possible(formula, low, high)
        deepest = int(solid.argmax()) if solid.any() else _DEPTHS
        proven = shares[deepest - 1] if deepest else proven
        failed = shares[deepest] if deepest < _DEPTHS else failed
    (hi if side > 0 else lo)[axis] = end - proven * width
