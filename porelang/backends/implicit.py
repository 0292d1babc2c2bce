"""The 3MF backend: a flat graph as an `implicitfunction` of the 3MF Volumetric and Implicit extensions (0.8.0).

The third writer beside NumPy and GLSL. The table NODES says of every operation which nodes it becomes; what the
extension lacks is composed of what it has. Settings and numbers found from fields are constants. Only nodes are used
that both the schema and lib3mf (2.5) know: they name the inverse angles differently (`arctan2`, `atan2`), so those are
composed, and so is `clamp`, which the schema gives two inputs in place of three.

Undefined results of nodes are guarded unless an enclosure over the box proves that they cannot occur: a reader's select
may compute both of its sides. So a divisor of 0 is 1e-30, a root is of 0 at least. Where the source is no number the
function is some number. A condition is 1 or 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.analysis.enclose import F64, Enclosure, enclose_all
from porelang.data import SampledField
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import Node, Stage
from porelang.tape import AXES

#: Nodes of the extension by name over what they read: an argument (a whole number), a constant, or other nodes.
Tree = int | float | tuple[Any, ...]
A, B, C = range(3)
#: What stands for a divisor of 0, for the least number that has a logarithm, and for infinity: float32 has them.
NOUGHT, LEAST, HUGE = 1e-30, 1e-37, 1e30
#: Of the image functions: steps between black and white in 16 bits.
STEPS = 65535


@dataclass(frozen=True, slots=True)
class Form:
    """The nodes of an operation, right for all arguments; and fewer, which are right where ranges are `calm`."""

    nodes: Tree
    plain: Tree = 0
    calm: Callable[..., bool] | None = None


def _nonzero(x: Tree) -> Tree:
    return ("select", 0.0, ("abs", x), x, NOUGHT)


def _half(t: Tree) -> Tree:
    """The tangent of half the angle whose tangent is t."""
    return ("division", t, ("addition", 1.0, ("sqrt", ("addition", 1.0, ("multiplication", t, t)))))


def _angle(y: Tree, x: Tree) -> Tree:
    """The angle of (x, y), right to 4 ulp: its tangent is halved three times, which leaves pi / 16 at most, and of the
    series the first term that is missing is 6e-19 of it."""
    reach = ("addition", ("length", ("composevector", x, y, 0.0)), ("abs", x))
    t = _half(_half(("division", y, ("max", reach, LEAST))))
    square = ("multiplication", t, t)
    series: Tree = -1 / 23
    for k in range(21, 0, -2):
        series = ("addition", (1 if k % 4 == 1 else -1) / k, ("multiplication", square, series))
    angle = ("multiplication", 8.0, ("multiplication", t, series))
    turned = ("subtraction", ("select", y, 0.0, -math.pi, math.pi), angle)
    return ("select", x, 0.0, turned, angle)


_BESIDE = ("sqrt", ("max", 0.0, ("multiplication", ("subtraction", 1.0, A), ("addition", 1.0, A))))
_REDUCED = ("multiplication", math.tau, ("subtraction", A, ("floor", ("addition", A, 0.5))))
_PART = ("subtraction", A, ("floor", A))
_NEXT = ("addition", ("floor", A), 1.0)
_EVEN = ("multiplication", 2.0, ("floor", ("multiplication", 0.5, _NEXT)))
#: 0 to a power above 0 is 0, and to others it is undefined
_BASE = ("select", 0.0, B, ("abs", A), ("max", ("abs", A), LEAST))
_ODD = ("select", A, 0.0, ("select", 0.5, ("mod", B, 2.0), -1.0, 1.0), 1.0)


def _apart(a: Interval, b: Interval) -> bool:
    """Whether b is never 0."""
    return bool(np.all((b.lo > 0) | (b.hi < 0)) and not np.any(b.nan))


def _at_least(least: float) -> Callable[..., bool]:
    return lambda a: bool(np.all(a.lo >= least) and not np.any(a.nan))


def _positive(a: Interval, b: Interval) -> bool:
    return bool((np.all(a.lo > 0) or (np.all(a.lo >= 0) and np.all(b.lo > 0))) and not np.any(a.nan))


#: THE TABLE: operation -> nodes. What reads data is below; what is in neither cannot be written.
NODES: dict[str, Form] = {
    "neg": Form(("subtraction", 0.0, A)),
    "add": Form(("addition", A, B)),
    "sub": Form(("subtraction", A, B)),
    "mul": Form(("multiplication", A, B)),
    "square": Form(("multiplication", A, A)),
    "div": Form(("division", A, _nonzero(B)), ("division", A, B), _apart),
    "mod": Form(("mod", A, _nonzero(B)), ("mod", A, B), _apart),
    "pow": Form(("multiplication", ("pow", _BASE, B), _ODD), ("pow", A, B), _positive),
    "min": Form(("min", A, B)),
    "max": Form(("max", A, B)),
    "abs": Form(("abs", A)),
    "sign": Form(("sign", A)),
    "floor": Form(("floor", A)),
    # halves go to the even one, which the extension leaves open
    "round": Form(("select", _PART, 0.5, ("floor", A), ("select", 0.5, _PART, _NEXT, _EVEN))),
    "sqrt": Form(("sqrt", ("max", A, 0.0)), ("sqrt", A), _at_least(0.0)),
    "hypot": Form(("length", ("composevector", A, B, 0.0))),
    "direction": Form(("select", 0.0, B, ("division", A, _nonzero(B)), 0.0), ("division", A, B), _apart),
    "exp": Form(("exp", A)),
    "log": Form(("log", ("max", A, LEAST)), ("log", A), _at_least(LEAST)),
    "sin": Form(("sin", A)),
    "cos": Form(("cos", A)),
    "sin_turns": Form(("sin", _REDUCED)),
    "cos_turns": Form(("cos", _REDUCED)),
    "reduced": Form(_REDUCED),
    "asin": Form(_angle(A, _BESIDE)),
    "acos": Form(_angle(_BESIDE, A)),
    "atan2": Form(_angle(A, B)),
    "lt": Form(("select", A, B, 1.0, 0.0)),
    "le": Form(("select", B, A, 0.0, 1.0)),
    "eq": Form(("select", A, B, 0.0, ("select", B, A, 0.0, 1.0))),
    "and": Form(("multiplication", A, B)),
    "or": Form(("max", A, B)),
    "not": Form(("subtraction", 1.0, A)),
    "select": Form(("select", 0.5, A, B, C)),
}
#: The ports of nodes that read or give vectors; all others read scalars A, B, ... and give a scalar.
_PORTS = {
    "composevector": (("x", "y", "z"), "scalarref", "vector"),
    "length": (("A",), "vectorref", "scalar"),
}
_XYZ = ('"x"', '"y"', '"z"')


class Unwritable(Exception):  # noqa: N818  no error of ours, but what is told of one
    """An operation that the extension cannot say, by its node."""

    def __init__(self, node: Node) -> None:
        super().__init__(node.op)
        self.node = node


@dataclass(frozen=True, slots=True)
class Image:
    """A component of a sampled field as grey values: `low + grey * span`, with grey 0 to 1 in STEPS."""

    field: SampledField
    component: int
    low: float
    span: float

    @property
    def error(self) -> float:
        """How far a value may be off: half a step."""
        return self.span / STEPS / 2


@dataclass(frozen=True, slots=True)
class Function:
    """An implicit function: its nodes as XML, how many they are, and the images that they read.

    The function of image k is called by the resource id `IMAGES + 2 k + 1`, before which the image has its own.
    """

    text: str
    nodes: int
    images: tuple[Image, ...]

    @property
    def id(self) -> int:
        return IMAGES + 2 * len(self.images)


#: The first id of an image; 1 is that of the box.
IMAGES = 2


def function(formula: Formula, box: Sequence[Interval], name: str) -> Function:
    """The first root of a formula as a function of `pos` (mm), whose result is called `shape`; `box` is where it is
    evaluated, and `name` is quoted for XML. Errors: Unwritable."""
    formula = formula.taken.with_roots(formula.taken.root)
    tape = formula.tape
    ranges = enclose_all(formula, box, F64)
    writer = _Writer()
    refs: dict[int, str] = {}
    for i, op in enumerate(tape.ops):
        if op in AXES:
            refs[i] = f"position.{op}"
        elif tape.kinds[i] not in ("real", "bool"):
            continue
        elif tape.stages[i] is not Stage.FIELD:
            refs[i] = ""  # a number: written when somebody reads it
        elif op in ("lookup", "covers"):
            data = formula.known[tape.inputs[i][0]]
            place = [refs[a] or writer.constant(formula.known[a]) for a in tape.inputs[i][1:]]
            refs[i] = _READ[op](writer, data, place, tape.nodes[i])
        elif op not in NODES:
            raise Unwritable(tape.nodes[i])
        else:
            form = NODES[op]
            known = [_range(ranges.get(a)) for a in tape.inputs[i]]
            calm = form.calm is not None and None not in known and form.calm(*known)
            arguments = [refs[a] or writer.constant(formula.known[a]) for a in tape.inputs[i]]
            refs[i] = writer.put(form.plain if calm else form.nodes, arguments)
    root = tape.roots[0]
    shape = refs[root] or writer.constant(formula.known[root])
    return Function(writer.function(name, shape), len(writer.lines) + 1, tuple(writer.images.values()))


def _range(found: Enclosure | None) -> Interval | None:
    return None if found is None else found.range


def _lookup(writer: _Writer, data: SampledField, place: list[str], n: Node) -> str:
    """Trilinear values of an image: the middles of its voxels are the nodes, and beyond the outermost they stay."""
    assert isinstance(n.value, tuple)
    component, *orders = (int(v) for v in n.value)
    if any(orders):
        raise Unwritable(n)
    values = data.values[..., component]
    low, span = float(values.min()), float(values.max()) - float(values.min())
    if span == 0:
        return writer.constant(low)
    uvw: list[Tree] = []
    for axis, (o, h, count) in enumerate(zip(data.origin, data.spacing, data.shape, strict=True)):
        u = ("multiplication", ("subtraction", axis, o), 1 / h)
        held = ("max", 0.0, ("min", u, float(count - 1)))
        uvw.append(("multiplication", ("addition", held, 0.5), 1 / count))
    key = (data.digest, component)
    writer.images.setdefault(key, Image(data, component, low, span))
    grey = writer.call(IMAGES + 2 * list(writer.images).index(key) + 1, writer.put(("composevector", *uvw), place))
    return writer.put(("addition", low, ("multiplication", span, A)), [grey])  # the image's error is half a step


def _covers(writer: _Writer, data: SampledField, place: list[str], n: Node) -> str:
    """Whether no coordinate lies beyond an end."""
    beyond: Tree = ("subtraction", data.origin[0], 0)
    for axis, (first, last) in enumerate(zip(data.origin, data.end, strict=True)):
        beyond = ("max", beyond, ("max", ("subtraction", first, axis), ("subtraction", axis, last)))
    return writer.put(("select", 0.0, beyond, 0.0, 1.0), place)


_READ: dict[str, Callable[[_Writer, SampledField, list[str], Node], str]] = {"lookup": _lookup, "covers": _covers}


class _Writer:
    """Nodes in order, each distinct one once."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.images: dict[tuple[str, int], Image] = {}
        self._known: dict[tuple[str, ...], str] = {}

    def put(self, tree: Tree, arguments: Sequence[str]) -> str:
        """What refers to the result of a tree."""
        done: dict[int, str] = {}  # trees share their parts

        def ref(tree: Tree) -> str:
            if isinstance(tree, float):
                return self.constant(tree)
            if isinstance(tree, int):
                return arguments[tree]
            if id(tree) not in done:
                done[id(tree)] = self._node(tree[0], [ref(part) for part in tree[1:]])
            return done[id(tree)]

        return ref(tree)

    def constant(self, value: Any) -> str:
        """What refers to a number; infinity and no number at all are as far outside as float32 goes."""
        number = float(value)
        number = number if math.isfinite(number) else math.copysign(HUGE, number) if number == number else HUGE
        return self._add("constant", f' value="{number!r}"', "", '<i:scalar identifier="value"/>', "value")

    def call(self, resource: int, place: str) -> str:
        """What refers to the grey value of an image function."""
        named = '<i:resourceid identifier="value"/>'
        which = self._add("constresourceid", f' value="{resource}"', "", named, "value")
        inputs = f'<i:resourceref identifier="functionID" ref="{which}"/><i:vectorref identifier="pos" ref="{place}"/>'
        return self._add("functioncall", "", inputs, '<i:scalar identifier="red"/>', "red")

    def _node(self, kind: str, refs: Sequence[str]) -> str:
        ports, read, gives = _PORTS.get(kind, (("A", "B", "C", "D"), "scalarref", "scalar"))
        inputs = "".join(f'<i:{read} identifier="{p}" ref="{r}"/>' for p, r in zip(ports, refs, strict=False))
        return self._add(kind, "", inputs, f'<i:{gives} identifier="result"/>', "result")

    def _add(self, kind: str, given: str, inputs: str, outputs: str, port: str) -> str:
        key = (kind, given, inputs)
        if key not in self._known:
            name = f"n{len(self.lines)}"
            read = f"<i:in>{inputs}</i:in>" if inputs else ""
            self.lines.append(f'<i:{kind} identifier="{name}"{given}>{read}<i:out>{outputs}</i:out></i:{kind}>')
            self._known[key] = f"{name}.{port}"
        return self._known[key]

    def function(self, name: str, shape: str) -> str:
        """The whole function."""
        head = (
            f'<i:implicitfunction id="{IMAGES + 2 * len(self.images)}" displayname={name}>'
            '<i:in><i:vector identifier="pos"/></i:in>',
            '<i:decomposevector identifier="position"><i:in><i:vectorref identifier="A" ref="inputs.pos"/></i:in>'
            f"<i:out>{''.join(f'<i:scalar identifier={quoted}/>' for quoted in _XYZ)}</i:out></i:decomposevector>",
        )
        end = f'<i:out><i:scalarref identifier="shape" ref="{shape}"/></i:out></i:implicitfunction>'
        return "\n".join([*head, *self.lines, end]) + "\n"
