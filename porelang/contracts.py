"""Contracts that constants alone do not decide: proven over the ranges of params, or over the part's box.

Enclosures prove a contract; where they cannot, a witness is sought among samples. Only a witness makes a diagnostic: a
doubt without one is left to be checked with the values in use.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from porelang.analysis.box import part_box
from porelang.analysis.enclose import boxes, enclose
from porelang.backends.numpy import NumpyField
from porelang.diagnostics import Diagnostic, Edit
from porelang.elaborate.results import ParamInfo, Requirement
from porelang.elaborate.tasks import A_SHARE
from porelang.formula import Bindings, Formula, ranges
from porelang.ir import SLOTS, Node, Stage, node, order, param, within
from porelang.ops import TABLE
from porelang.rewrites import Graph
from porelang.source import Span

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
    whole = ranges({name: (i.low, i.high) for name, i in params.items()})
    for condition, r in zip(graph.requirements, requirements, strict=True):
        if any(n.op in SLOTS and n.op != "param" for n in order([condition], within)):
            continue
        if bool(enclose(Formula((condition,), whole))[0].range.lo >= 1):
            continue
        used = [params[str(n.value)] for n in order([condition]) if n.op == "param"]
        samples = _settings(used)
        tried = Formula((condition,), {param(name): values for name, values in samples.items()})  # type: ignore[misc]  # many at a time
        holds = np.broadcast_to(np.asarray(tried.numbers[0], np.bool_), (_SAMPLES,))
        if not holds.all():
            row = int(np.argmin(holds))
            setting = ", ".join(f"`{i.name}` = {i.shown(samples[i.name][row])}" for i in used)
            always = "" if holds.any() else ", nor with any other setting tried"
            hint, edit = "narrow the param's range, or change the formula", None
            if r.message.endswith(A_SHARE) and len(used) == 1:
                hint, edit = _in_percent(used[0]) or (hint, None)
            found.append(
                Diagnostic(
                    "E086",
                    f"{r.message}, which does not hold with {setting}{always}",
                    r.span,
                    "broken for some settings",
                    r.others,
                    hint,
                    edit,
                )
            )
    return [d for d in found if not any(_follows(d, other) for other in found)]


def _follows(d: Diagnostic, other: Diagnostic) -> bool:
    """Whether what is said of a whole call has its cause in one of its arguments, of which the same is said."""
    a, b = d.span, other.span
    if a is None or b is None or a.source is not b.source or d.message.split()[0] != other.message.split()[0]:
        return False
    return a.start <= b.start and b.end <= a.end and (a.start, a.end) != (b.start, b.end)


#: What follows the name of a param that is declared with plain numbers.
_NUMBER = r"\s*(\d+\.?\d*)\s*"
_PLAIN = re.compile(rf"(\s*=){_NUMBER}(in){_NUMBER}\.\.{_NUMBER}(?:(step){_NUMBER})?(?=[\"#\n]|$)")


def _in_percent(info: ParamInfo) -> tuple[str, Edit | None] | None:
    """How to declare a porosity that was declared by numbers of percent: the words, and the edit."""
    if info.dimension is not None or not 1 < info.default <= 100 or info.high > 100:
        return None
    text = info.span.source.text
    found = _PLAIN.match(text, info.span.end)
    if found is None:
        return f"a porosity of {info.default:g} % is written `{info.default:g}%`: declare the param in percent", None
    _, default, _, low, high, _, step = found.groups()
    ours = f" = {default}% in {low}%..{high}%" + (f" step {step}%" if step else "")
    end = found.start() + len(found[0].rstrip())
    return f"write `param {info.name}{ours}`", Edit(Span(info.span.source, info.span.end, end), ours)


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


def doubtful_contracts(
    contracts: Sequence[tuple[int, Node]],
    requirements: Mapping[int, Requirement],
    solids: Sequence[Node],
    bindings: Bindings,
) -> list[Diagnostic]:
    """A warning, with a place that shows it, for each contract on a field that breaks inside the box of the solids.

    Contracts about what `bindings` lack, as it is yet to be found, wait until it is there.
    """
    known = [(which, condition) for which, condition in contracts if _bound(condition, bindings)]
    if not known:
        return []
    lo, hi = _region(solids, bindings)
    cuts = [np.linspace(lo[i], hi[i], _CELLS + 1) for i in range(3)]
    low = np.stack(np.meshgrid(*(c[:-1] for c in cuts), indexing="ij"), -1).reshape(-1, 3)
    high = np.stack(np.meshgrid(*(c[1:] for c in cuts), indexing="ij"), -1).reshape(-1, 3)
    random = np.random.default_rng(1)
    found: dict[int, Diagnostic] = {}
    for which, condition in known:
        if which in found:
            continue
        in_space = condition.stage is Stage.FIELD
        if not in_space:
            points = np.zeros((1, 3))
        else:
            sure = np.broadcast_to(
                enclose(Formula((condition,), bindings), boxes(low, high))[0].range.lo >= 1, len(low)
            )
            if sure.all():
                continue
            cells = np.nonzero(~sure)[0]
            pick = random.choice(cells, 20 * _SAMPLES)
            points = low[pick] + random.random((len(pick), 3)) * (high[pick] - low[pick])
            points = np.concatenate([low[cells], points])
        holds = NumpyField(Formula((condition,), bindings), "f64", 1).at(points)
        if not holds.all():
            broken = points[~holds]
            at = broken[int(np.argmin(np.abs(broken).max(axis=1)))]  # the one a user is likeliest to look at
            r = requirements[which]
            share = 1 - np.count_nonzero(holds) / len(holds)
            found[which] = Diagnostic(
                "W201",
                f"{r.message}, which does not hold{' everywhere' if in_space else ''}",
                r.span,
                f"broken at ({at[0]:.4g}, {at[1]:.4g}, {at[2]:.4g})" if in_space else "broken with these settings",
                r.others,
                r.hint or ("clamp the field, `max(field, least)`, or shift it" if share < 1 else "check its sign"),
                severity="warning",
            )
    return list(found.values())


def _bound(root: Node, bindings: Bindings) -> bool:
    """Whether all that a root reads is bound."""
    return all(n in bindings for n in order([root], within) if n.op in SLOTS)


def _known_part(root: Node, bindings: Bindings) -> Node | None:
    """A solid that holds this one and needs nothing that is yet to be found: what it is cut out of."""
    if _bound(root, bindings):
        return root
    if root.op != "max":
        return None
    parts = [part for a in root.args if (part := _known_part(a, bindings)) is not None]
    return parts[0] if len(parts) == 1 else node("max", *parts) if parts else None


def _region(solids: Sequence[Node], bindings: Bindings) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The box of all solids that have one, cut to what is near where they do not end."""
    los, his = [], []
    for root in solids:
        solid = _known_part(root, bindings)
        if solid is not None and TABLE.get(solid.op) is not None and TABLE[solid.op].result != "bool":
            box = part_box(Formula((solid,), bindings))
            if box is not None:
                los.append(box.lo)
                his.append(box.hi)
    if not los:
        return np.full(3, -NEAR), np.full(3, NEAR)
    lo, hi = np.min(los, axis=0), np.max(his, axis=0)
    return np.where(lo <= -1e5, -NEAR, lo), np.where(hi >= 1e5, NEAR, hi)
