"""What a row of the table of operations holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from porelang.interval import Interval
from porelang.ir import Node

Kind = Literal["real", "bool", "any", "grid", "segments"]
Units = Literal["none", "same", "product", "quotient", "square", "power", "root", "angle", "turns", "pure", "angle of"]


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far a backend's result may lie from the exact one, in units of the type's epsilon (2^-23 in float32).

    The bound is eps * (ulp * |result| + absolute + extra(arguments)). 0.5 ulp is correct rounding.
    """

    ulp: float = 0.5
    absolute: float = 0.0
    extra: Callable[..., Any] | None = None  # an Array


@dataclass(frozen=True, slots=True)
class Op:
    """All there is to know of a kernel operation.

    `args` and `result` are kinds of values. `units` names the rule for dimensions (`porelang.elaborate.dimensions`).
    `numpy` takes arrays or scalars and `out=`, which never overlaps an argument. `glsl` is a template over `{0}`,
    `{1}`, ...; `guarded`, if given, is a cheaper template that is right when the arguments are known to keep to
    `calm` (see `porelang.backends.glsl`).
    `derivative` gives the partial derivative by each argument as nodes (None where it is 0 everywhere).
    `jumps` tells over which boxes the result may jump. `doubles` are closer forms of `enclose` and `jumps` for what is
    computed in float64, where single precision has to be allowed for otherwise.
    `domain` says in words where the result is a number.
    `narrow` turns what the result must lie in, and what the arguments lie in, into narrower ranges of the arguments
    (None for data):
    how "outside 75 mm there is no material" is found by reading a formula backwards.
    `symbol` is the operator or function that writes it in the language (empty if it cannot be written).
    `example` is a call and its exact value.

    Operations that read data: where `payload` is set, a node's value says more of what is asked (which component, which
    derivative), and every form takes it as its last argument. Where `results` are named, one walk through the data
    finds several of them: every form takes the names that are wanted as its last argument and gives a tuple in that
    order; a node's value names the one that it is. In `glsl`, `{wanted}` is a number with a bit for each of them.
    """

    name: str
    args: tuple[Kind, ...]
    result: Kind
    doc: str
    numpy: Callable[..., Any]
    glsl: str
    enclose: Callable[..., Any]  # an Interval
    derivative: Callable[..., tuple[Node | None, ...]]
    symbol: str
    example: tuple[str, float | bool] | None
    units: Units = "same"
    tolerance: Tolerance = Tolerance()
    domain: str = "all numbers"
    jumps: Callable[..., Any] | None = None  # a Mask
    narrow: Callable[..., tuple[Interval | None, ...]] | None = None
    guarded: str = ""
    calm: str = ""
    doubles: tuple[Callable[..., Any], Callable[..., Any]] | None = None  # an Interval, a Mask
    facts: frozenset[str] = frozenset()
    payload: bool = False
    results: tuple[str, ...] = ()
