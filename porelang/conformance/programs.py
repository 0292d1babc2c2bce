"""Conformance programs: small `.pore` files that say in comments what they must return.

    # expect: part(1, 2, 3) = sqrt(14) - 10            the value of an output at a point; `part.x` of a vector
    # expect: part(0, 0, 0) = 0.5 +- 0.01              with a margin of its own
    # set: w=20                                        the params from here on
    # warn: W201                                       a warning that compiling gives (once each; none if not said)
    # fails: at least half must be open                a `check` that does not hold with these params
    # place: 1.5, -3.25, 0.5                           where the law is put to the test, beside places at random

Values are numbers, `nan`, `inf`, `true`, `false`, and arithmetic of them with pi, tau, sqrt, sin, ... Without a margin
they hold within 1e-9 in float64 and 1e-5 in float32, of the value or of 1.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from porelang.resources import PACKAGE

_LINE = re.compile(r"^#\s*(expect|set|warn|fails|place):\s*(.*?)\s*$")
_EXPECT = re.compile(r"^([\w.]+)\s*\((.*?)\)\s*=\s*(.*?)(?:\s*\+-\s*(.*))?$")
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    name: getattr(math, name)
    for name in ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "hypot", "floor")
}
_NAMES = {"pi": math.pi, "tau": math.tau, "inf": math.inf, "nan": math.nan, "true": 1.0, "false": 0.0}
MARGIN = {"f64": 1e-9, "f32": 1e-5}


@dataclass(frozen=True, slots=True)
class Expectation:
    """What an output (or one component of a vector) must be at a point. `margin` is None for that of the type."""

    output: str
    axis: int | None
    point: tuple[float, float, float]
    value: float
    margin: float | None
    line: int

    def holds(self, got: float, dtype: str) -> bool:
        """Whether a value that a backend returned meets the expectation."""
        if math.isnan(self.value) or math.isinf(self.value):
            return (math.isnan(got) and math.isnan(self.value)) or got == self.value
        margin = MARGIN[dtype] * max(1.0, abs(self.value)) if self.margin is None else self.margin
        return abs(got - self.value) <= margin


@dataclass(frozen=True, slots=True)
class Variant:
    """Params, and what must be with them."""

    settings: dict[str, str]
    expectations: list[Expectation] = field(default_factory=list)
    fails: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Case:
    """A conformance program: its file, its variants, the codes of the warnings that compiling it gives, and places at
    which it is judged whatever else is drawn."""

    path: Path
    variants: tuple[Variant, ...]
    warnings: tuple[str, ...]
    places: tuple[tuple[float, float, float], ...] = ()

    @property
    def name(self) -> str:
        return self.path.stem


def folder() -> Path:
    """Where the conformance programs lie: inside the installed package, or among the tests of a checkout."""
    inside = PACKAGE / "conformance" / "programs"
    return inside if inside.is_dir() else PACKAGE.parent / "tests" / "conformance"


def cases() -> list[Case]:
    """All conformance programs, by name."""
    return [read_case(path) for path in sorted(folder().glob("*.pore"))]


def read_case(path: Path) -> Case:
    """The expectations of one file. Raises ValueError, with file and line, for a comment that cannot be read."""
    variants = [Variant({})]
    warnings: list[str] = []
    places: list[tuple[float, float, float]] = []
    for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        match = _LINE.match(text)
        if match is None:
            continue
        what, rest = match[1], match[2]
        try:
            if what == "expect":
                variants[-1].expectations.append(_expectation(rest, number))
            elif what == "set":
                pairs = (pair.split("=", 1) for pair in re.split(r",\s*", rest) if pair)
                variants.append(Variant({name.strip(): value.strip() for name, value in pairs}))
            elif what == "place":
                places.append(_place(rest))
            elif what == "warn":
                warnings.append(rest)
            else:
                variants[-1].fails.append(rest)
        except (ValueError, KeyError, SyntaxError, TypeError) as error:
            raise ValueError(f"{path.name}:{number}: {error}") from None
    said = tuple(v for v in variants if v.expectations or v.fails or v.settings)
    return Case(path, said or (Variant({}),), tuple(warnings), tuple(places))


def _place(text: str) -> tuple[float, float, float]:
    x, y, z = (number(part) for part in text.split(","))
    return x, y, z


def _expectation(text: str, line: int) -> Expectation:
    match = _EXPECT.match(text)
    if match is None:
        raise ValueError(f"`{text}` is not of the form `NAME(x, y, z) = value`")
    name, _, axis = match[1].partition(".")
    margin = None if match[4] is None else number(match[4])
    return Expectation(name, "xyz".index(axis) if axis else None, _place(match[2]), number(match[3]), margin, line)


def number(text: str) -> float:
    """The value of an arithmetic expression: numbers, + - * / **, and the functions and names above."""
    return float(_number(ast.parse(text.strip(), mode="eval").body))


def _number(tree: ast.expr) -> float:
    match tree:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.Name(id=name):
            return _NAMES[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_number(operand)
        case ast.BinOp(left=left, op=op, right=right):
            return float(_OPERATORS[type(op)](_number(left), _number(right)))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _FUNCTIONS[name](*(_number(a) for a in arguments))
    raise ValueError(f"`{ast.unparse(tree)}` is no number")
