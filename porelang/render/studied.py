"""Where a picture shows what a study has not found: a stress, or a displacement, of places beyond its part.

Two steps of its samples beyond the part a study goes on as inside, farther out it is what it is at the nearest place:
so a program can read it anywhere. In a picture it would be taken for a result.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.numpy import NumpyField
from porelang.data import SampledField, coordinates
from porelang.diagnostics import Diagnostic
from porelang.expression import Expression
from porelang.ir import Node, const, node, order, within
from porelang.ops.studies import DEPTH
from porelang.program import Design
from porelang.units import LENGTH, STRESS

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
#: Steps of the samples of a study: what is farther beyond its part was not studied, nor what they do not cover, from a
#: step beyond its box on.
BEYOND = 1.5
#: A share of what is seen that is beyond is told; rims of a part lie a little beyond its elements.
TOLD = 0.002
#: What is said of colours there.
GREY = "nothing was found there, and it is grey"
_LOOKS_UP = ("lookup", "lookup_cubic")


@dataclass(frozen=True, eq=False)
class Studied:
    """The part that the studies of `names` are of: how far beyond its elements places are, also as `depths`, and what
    is `far` (mm)."""

    names: tuple[str, ...]
    depths: tuple[Node, ...]
    depth: NumpyField
    far: Floats
    place: Any

    def beyond(self, places: Floats) -> Flags:
        """Which places (n, 3) mm lie beyond it."""
        return np.asarray((np.asarray(self.depth.at(places)).reshape(len(places), -1) > self.far).any(axis=1))

    def known(self, field: Callable[[Floats], NDArray[Any]]) -> Callable[[Floats], NDArray[Any]]:
        """A field without a value where nothing was studied."""

        def value(places: Floats) -> NDArray[Any]:
            return np.where(self.beyond(places), np.nan, field(places))

        return value

    def known_root(self, root: Node) -> Node:
        """A flat root that has no value where nothing was studied."""
        for depth, far in zip(self.depths, self.far, strict=True):
            root = node("select", node("lt", const(float(far)), depth), const(math.nan), root)
        return root

    def told(self, places: Floats, what: str) -> list[Diagnostic]:
        """W285 where more than a few of the places (n, 3) that are seen lie beyond it."""
        if not len(places):
            return []
        beyond = self.beyond(places)
        share = float(beyond.mean())
        if share < TOLD:
            return []
        named = " and ".join(f"`{name}`" for name in self.names)
        at = coordinates(places[beyond][len(places[beyond]) // 2])
        said = f"{max(share, 0.01):.0%} of what is drawn lies beyond the part that {named} was asked of, as at ({at})"
        hint = "draw what was studied, or study what is drawn; `outside=0` in the study gives it a number beyond"
        return [
            Diagnostic("W285", f"{said}: {what}", self.place, "a study of this part", hint=hint, severity="warning")
        ]


def studied(design: Design, roots: Sequence[Node]) -> Studied | None:
    """What studies that some flat roots read are of, but for those that say what is `outside`; None where they read
    none."""
    program = design.program
    looks = [n for n in order(roots, into=within) if n.op in _LOOKS_UP and n.args[0].op == "study"]
    said = {n.args[0] for n in looks if _component(n) == DEPTH}
    asked = list(dict.fromkeys(n.args for n in looks if n.args[0] not in said))
    if not asked:
        return None
    tasks = list(dict.fromkeys(task for task, *_ in asked))
    # deeper than can be where samples cover nothing
    depths = tuple(node("select", node("covers", *args), node("lookup", *args, value=(DEPTH, 0, 0, 0)), const(math.inf))
                   for args in asked)  # fmt: skip
    formula = design.formula(*depths)
    far = np.array([BEYOND * max(_samples(formula.bindings[task]).spacing) for task, *_ in asked])
    names = tuple(name for name, n in program.studies.items() if n in tasks)
    return Studied(names, depths, NumpyField(formula, "f64"), far, program.places.get(tasks[0]))


def is_result(shown: Expression) -> bool:
    """Whether a field that reads a study is one of its results, and not what a program makes of one."""
    root = shown.roots[0]
    return shown.dimension == STRESS or root.op in (*_LOOKS_UP, "principal") or (
        shown.dimension == LENGTH and root.op in ("sqrt", "hypot")
    )  # fmt: skip


def _component(n: Node) -> int:
    assert isinstance(n.value, tuple)
    return int(n.value[0])


def _samples(found: object) -> SampledField:
    assert isinstance(found, SampledField)
    return found
