"""Gradual units: the dimension of a result, where those of the arguments are known, and clashes between known ones.

A bare number fits anywhere: where one side is not known, neither is a product, and a sum takes the side that is known.
The one exception is a bare number as written: `2 * 5mm` is a length.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from porelang.elaborate.values import Scalar, Vector
from porelang.ops.row import Units
from porelang.units import ANGLE, RATIO, Dimension

Known = Dimension | None
Number = Scalar | Vector


class Clash(Exception):  # noqa: N818  # caught next door, never shown
    """Two known dimensions that do not fit; `argument` is the index of the second."""

    def __init__(self, first: int, second: int) -> None:
        self.first, self.second = first, second


class Unfit(Exception):  # noqa: N818  # likewise
    """A known dimension where another is needed."""

    def __init__(self, argument: int, wanted: str) -> None:
        self.argument, self.wanted = argument, wanted


def same(arguments: Sequence[Number]) -> Known:
    """The one dimension of all arguments that have one."""
    first: int | None = None
    for i, a in enumerate(arguments):
        if a.dimension is None:
            continue
        if first is None:
            first = i
        elif arguments[first].dimension != a.dimension:
            raise Clash(first, i)
    return None if first is None else arguments[first].dimension


def _literal(a: Number) -> bool:
    return isinstance(a, Scalar) and a.literal


def _mixed(d: Dimension) -> Known:
    """An angle times a length may be an arc, which is a length: such a product is not known."""
    return None if d.angle and (d.length > 0 or d.force > 0) and d.angle > 0 else d


def product(a: Number, b: Number) -> Known:
    if a.dimension is not None and b.dimension is not None:
        return _mixed(a.dimension * b.dimension)
    for plain, other in ((a, b), (b, a)):
        if _literal(plain) and other.dimension not in (None, RATIO):
            return other.dimension
    return None


def quotient(a: Number, b: Number) -> Known:
    if a.dimension is not None and b.dimension is not None:
        return _mixed(a.dimension / b.dimension)
    if _literal(b) and a.dimension not in (None, RATIO):
        return a.dimension
    if _literal(a) and b.dimension not in (None, RATIO):
        return RATIO / b.dimension
    return None


def result(rule: Units, arguments: Sequence[Number], exponent: float | None = None) -> Known:
    """The dimension of an operation's result by its rule in the table; `exponent` is a power's, where it is
    constant."""
    first = arguments[0].dimension if arguments else None
    match rule:
        case "same":
            return same(arguments)
        case "product":
            return product(*arguments)
        case "quotient":
            return quotient(*arguments)
        case "square":
            return None if first is None else first * first
        case "root":
            return None if first is None else first ** Fraction(1, 2)
        case "power":
            if arguments[1].dimension not in (None, RATIO):
                raise Unfit(1, "a plain number as the exponent")
            if first is None or exponent is None:
                return None
            return first ** Fraction(exponent).limit_denominator(12)
        case "angle":
            if first not in (None, ANGLE, RATIO):
                raise Unfit(0, "an angle")
            return None
        case "turns":
            if first not in (None, RATIO):
                raise Unfit(0, "a number of turns (say `p / w`)")
            return None
        case "pure":
            return None
        case "angle of":
            same(arguments)
            return ANGLE
    return None
