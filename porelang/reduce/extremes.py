"""The least and the greatest value of a field within a solid, by branch and bound on enclosures: the gap is proven."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from porelang.backends.numpy import NumpyField
from porelang.diagnostics import fail
from porelang.ir import Node, node
from porelang.passes.bounds import box_test
from porelang.passes.enclose import EXACT
from porelang.reduce.integrals import Reduced, region

#: The proven gap, relative to the range of values met.
ACCURACY = 1e-4
_LEVELS = 24
_MOST = 120_000  # cells at once; beyond it the most promising are kept and the gap says what was given up
_PROBES = 8


def minimum(root: Node, within: Node, params: Mapping[str, float]) -> Reduced:
    """The least value of `root` where `within <= 0`, attained at a point; the error is one-sided."""
    found = maximum(node("neg", root), within, params)
    return Reduced(-found.value, found.error)


def maximum(root: Node, within: Node, params: Mapping[str, float]) -> Reduced:
    """The greatest value of `root` where `within <= 0`, attained at a point; the error is one-sided."""
    where = region(within, params, "the region `within`")
    low, size = np.concatenate([where.inside, where.undecided]), where.size
    above, fence = box_test(root, params, EXACT), box_test(within, params, EXACT)
    field, inside = NumpyField(root, params, "f64"), NumpyField(within, params, "f64")
    random = np.random.default_rng(7)
    best, least, given_up = -np.inf, np.inf, -np.inf
    for level in range(_LEVELS):
        each = _PROBES if level == 0 else 1
        probes = (low[:, None, :] + random.random((len(low), each, 3)) * size).reshape(-1, 3)
        probes = np.concatenate([probes, low + size / 2])
        values = field.at(probes[inside.at(probes) <= 0])
        if np.isnan(values).any():
            raise fail(
                "E093", "the field of this number is not a number in places", hint="`pore mesh` names the first place"
            )
        if len(values):
            best, least = max(best, float(values.max())), min(least, float(values.min()))
        highs = above(low, low + size)[1]
        goal = ACCURACY * max(best - least, 1e-12 * abs(best)) if np.isfinite(best) else np.inf
        keep = (highs > best + goal) & (fence(low, low + size)[0] <= 0)
        if not keep.any():
            break
        low, highs = low[keep], highs[keep]
        if len(low) > _MOST // 8:
            order = np.argsort(-highs)
            given_up = max(given_up, float(highs[order[_MOST // 8 :]].max()))
            low = low[order[: _MOST // 8]]
        size = size / 2
        corners = np.stack(np.meshgrid(*([0, 1],) * 3, indexing="ij"), -1).reshape(1, 8, 3)
        low = (low[:, None, :] + corners * size).reshape(-1, 3)
    if not np.isfinite(best):
        raise fail(
            "E092",
            "the region `within` of this number holds no point that could be found",
            hint="it is far thinner than it is wide",
        )
    last = above(low, low + size)[1]
    top = max(float(last.max(initial=-np.inf)), given_up, best + ACCURACY * (best - least))
    return Reduced(best, max(top - best, 0.0))
