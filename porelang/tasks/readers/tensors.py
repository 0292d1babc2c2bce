"""How many numbers an array has in each place, and which component of a tensor each of them is.

A tensor's components are those of VTK here: xx, yy, zz, xy, yz, xz. Files have them in other orders, Abaqus in xx, yy,
zz, xy, xz, yz, Voigt in xx, yy, zz, yz, xz, xy; where a file names them, they are taken by their names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from porelang.tasks.readers.asked import Array, Asked

#: The components of a symmetric tensor, in VTK's order, and all nine, row by row.
SIX = ("xx", "yy", "zz", "xy", "yz", "xz")
_NINE = tuple(a + b for a in "xyz" for b in "xyz")
#: Two axes in a name, as in `S12`, `stress_xz`, `xx (MPa)` or `Stress 11 component`: no letter or digit follows.
_AXES = re.compile(r"(?<![xyz0-9])(?:[xyz]{2}|[1-3]{2})(?![a-z0-9])")
#: Of the nine, where those of a symmetric tensor stand, each twice.
_SYMMETRIC = ((0, 0), (4, 4), (8, 8), (1, 3), (5, 7), (2, 6))
#: How far the halves of a symmetric tensor may lie apart, as a share of its largest number: rounding of float32.
_ROUNDED = 1e-5


def order_of(names: Sequence[str]) -> list[int] | None:
    """Where SIX stand among so many named components, or all nine; None where the names do not say."""
    meant = [_meant(name) for name in names]
    if len(meant) == 6:
        meant = [m if m in SIX else m[::-1] for m in meant]
        return [meant.index(c) for c in SIX] if set(meant) == set(SIX) else None
    return [meant.index(c) for c in _NINE] if len(meant) == 9 and set(meant) == set(_NINE) else None


def are_named(names: Sequence[str], count: int) -> bool:
    """Whether a file says which component is which: of nine, row by row, there is one order."""
    return count == 9 or order_of(names) is not None


def _meant(name: str) -> str:
    found = _AXES.findall(name.lower())
    return str(found[-1]).translate(str.maketrans("123", "xyz")) if found else ""


def components(asked: Asked, array: Array, names: Sequence[str] = ()) -> Array:
    """Values (..., k) with k of 1, 3 or 6, tensors in the order of SIX: by the `names` that a file gives them, if it
    does; of nine numbers the six of a symmetric tensor.

    Errors: E133 for another number of components, and for a tensor that is not symmetric.
    """
    count = array.shape[-1]
    if len(names) == count and (order := order_of(names)) is not None:
        array = array[..., order]
    if count == 9:
        halves = [(array[..., i], array[..., j]) for i, j in _SYMMETRIC]
        with np.errstate(all="ignore"):
            apart = max(float(np.nanmax(np.abs(a - b), initial=0)) for a, b in halves)
            largest = float(np.nanmax(np.abs(array), initial=0))
        if apart > _ROUNDED * largest:
            text = f"the tensors `{asked.name}` in `{asked.path}` are not symmetric: two halves differ by {apart:.3g}"
            raise asked.fail("E133", text, "stresses and strains are; of a gradient write the symmetric part")
        with np.errstate(all="ignore"):
            return np.stack([(a + b) / 2 for a, b in halves], axis=-1)
    if count not in (1, 3, 6):
        text = f"`{asked.name}` in `{asked.path}` has {count} numbers in each place"
        raise asked.fail("E133", text, "there are 1 for a number, 3 for a vector, 6 or 9 for a symmetric tensor")
    return array
