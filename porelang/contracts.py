"""Contracts that constants alone do not decide: proven over the ranges of params, or over the part's box.

Enclosures prove a contract; where they cannot, a witness is sought among samples. Only a witness makes a
diagnostic: a doubt
without one is left to be checked with the values in use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import part_box
from porelang.analysis.enclose import EXACT, enclose, fixed
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import Diagnostic
from porelang.elaborate.results import ParamInfo, Requirement
from porelang.interval import interval
from porelang.ir import Node, Stage, node, order
from porelang.ops import TABLE
from porelang.rewrites import Graph

#: Where a part has no end, contracts are looked at within this distance of the origin, in mm.
NEAR = 200.0
_SAMPLES = 2000
_CELLS = 12


def broken_requirements(
    graph: Graph, requirements: Sequence[Requirement], params: Mapping[str, ParamInfo]
) -> list[Diagnostic]:
    """An error, with a setting that shows it, for each condition that some setting of the params breaks.

    Conditions on numbers that are yet to be found from fields are left to be checked with the settings in use.
    """
    found: list[Diagnostic] = []
    ranges = {name: interval(np.array(i.low), np.array(i.high)) for name, i in params.items()}
    for i, r in enumerate(requirements):
        condition = graph.roots[f"require {i}"]
        if any(n.op == "param" and n.value not in params for n in order([condition])):
            continue
        if bool(enclose([condition], (), ranges, EXACT)[0].range.lo >= 1):
            continue
        used = [params[str(n.value)] for n in order([condition]) if n.op == "param"]
        samples = _settings(used)
        with np.errstate(all="ignore"):
            holds = np.broadcast_to(_on_settings(condition, samples), (_SAMPLES,))
        if not holds.all():
            row = int(np.argmin(holds))
            setting = ", ".join(f"`{i.name}` = {i.shown(samples[i.name][row])}" for i in used)
            always = "" if holds.any() else ", nor with any other setting tried"
            found.append(
                Diagnostic(
                    "E086",
                    f"{r.message}, which does not hold with {setting}{always}",
                    r.span,
                    "broken for some settings",
                    r.others,
                    "narrow the param's range, or change the formula",
                )
            )
    return found


def _settings(used: Sequence[ParamInfo]) -> dict[str, NDArray[np.float64]]:
    """Settings of the params: the corners of their ranges first, the defaults, then a spread over the inside."""
    random = np.random.default_rng(1)
    out: dict[str, NDArray[np.float64]] = {}
    for bit, info in enumerate(used):
        if info.numbers:
            values = random.choice(np.array(info.numbers), _SAMPLES)
        elif info.choices:
            values = random.integers(0, len(info.choices), _SAMPLES).astype(np.float64)
        else:
            values = random.uniform(info.low, info.high, _SAMPLES)
        ends = (min(info.numbers), max(info.numbers)) if info.numbers else (info.low, info.high)
        corners = min(_SAMPLES // 2, 2 ** len(used))
        values[1 : corners + 1] = [ends[i >> bit & 1] for i in range(corners)]
        values[0] = info.default
        out[info.name] = values
    return out


def _on_settings(condition: Node, samples: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    known: dict[Node, object] = {}
    for n in order([condition]):
        if n.op == "const":
            known[n] = n.value if isinstance(n.value, bool) else np.float64(n.value or 0.0)
        elif n.op == "param":
            known[n] = samples[str(n.value)]
        else:
            known[n] = TABLE[n.op].numpy(*(known[a] for a in n.args))
    return np.asarray(known[condition], dtype=np.bool_)


def doubtful_contracts(
    graph: Graph, contracts: Sequence[Requirement], settings: Mapping[str, float]
) -> list[Diagnostic]:
    """A warning, with a place that shows it, for each contract on a field that breaks inside the part's box.

    Contracts about a number that `settings` lacks, as it is yet to be found from fields, wait until it is there.
    """
    known = [(which, condition) for which, condition in graph.contracts if _reads(condition) <= settings.keys()]
    if not known:
        return []
    lo, hi = _region(graph, settings)
    cuts = [np.linspace(lo[i], hi[i], _CELLS + 1) for i in range(3)]
    low = np.stack(np.meshgrid(*(c[:-1] for c in cuts), indexing="ij"), -1).reshape(-1, 3)
    high = np.stack(np.meshgrid(*(c[1:] for c in cuts), indexing="ij"), -1).reshape(-1, 3)
    box = [interval(low[:, i], high[:, i]) for i in range(3)]
    random = np.random.default_rng(1)
    found: dict[int, Diagnostic] = {}
    for which, condition in known:
        if which in found:
            continue
        if condition.stage is not Stage.FIELD:
            points = np.zeros((1, 3))
        else:
            sure = np.broadcast_to(enclose([condition], box, fixed(settings), EXACT)[0].range.lo >= 1, len(low))
            if sure.all():
                continue
            cells = np.nonzero(~sure)[0]
            pick = random.choice(cells, 20 * _SAMPLES)
            points = low[pick] + random.random((len(pick), 3)) * (high[pick] - low[pick])
            points = np.concatenate([low[cells], points])
        holds = NumpyField(condition, settings, "f64", 1).at(points)
        if not holds.all():
            broken = points[~holds]
            at = broken[int(np.argmin(np.abs(broken).max(axis=1)))]  # the one a user is likeliest to look at
            r = contracts[which]
            share = 1 - np.count_nonzero(holds) / len(holds)
            found[which] = Diagnostic(
                "W201",
                f"{r.message}, which does not hold everywhere",
                r.span,
                f"broken at ({at[0]:.4g}, {at[1]:.4g}, {at[2]:.4g})",
                r.others,
                "clamp the field, `max(field, least)`, or shift it" if share < 1 else "check its sign",
                severity="warning",
            )
    return list(found.values())


def _reads(root: Node) -> set[str]:
    """The params that a node reads."""
    return {str(n.value) for n in order([root]) if n.op == "param"}


def _known_part(root: Node, settings: Mapping[str, float]) -> Node | None:
    """A solid that holds this one and needs no number that is yet to be found: what it is cut out of."""
    if _reads(root) <= settings.keys():
        return root
    if root.op != "max":
        return None
    parts = [part for a in root.args if (part := _known_part(a, settings)) is not None]
    return parts[0] if len(parts) == 1 else node("max", *parts) if parts else None


def _region(graph: Graph, settings: Mapping[str, float]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The box of all outputs that have one, cut to what is near where they do not end."""
    los, his = [], []
    for name, root in graph.roots.items():
        if name.startswith(("require ", "check ")):
            continue
        solid = _known_part(root, settings)
        if solid is not None and TABLE.get(solid.op) is not None and TABLE[solid.op].result != "bool":
            box = part_box(solid, settings)
            if box is not None:
                los.append(box.lo)
                his.append(box.hi)
    if not los:
        return np.full(3, -NEAR), np.full(3, NEAR)
    lo, hi = np.min(los, axis=0), np.max(his, axis=0)
    return np.where(lo <= -1e5, -NEAR, lo), np.where(hi >= 1e5, NEAR, hi)
