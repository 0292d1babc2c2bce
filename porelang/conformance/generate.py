"""Random programs: typed graphs made from the rows of the table, and the same as texts of the language.

A graph is drawn through a `Chooser`, so that the same code serves a seeded generator (`Dice`) and Hypothesis, which
shrinks what fails. Graphs are kept to values that a part could have: exponents are held down and divisors kept away
from 0 more often than not, since a bound that has become infinite tests nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from porelang.conformance import samples
from porelang.ir import TASKS, ZERO, Node, Stage, Value, X, Y, Z, const, node, order, param, within
from porelang.ops import OPERATORS, TABLE, kind

#: The params that random graphs may read, and their ranges.
RANGES: dict[str, tuple[float, float]] = {"a": (0.5, 4.0), "b": (-2.0, 2.0)}
_CONSTANTS = (0.0, -0.0, 1.0, 2.0, -1.0, 0.5, 3.0, 0.25, 10.0, -0.75, 1 / 3, np.pi, 0.1, 1e-3, 100.0)
_WHOLE = (-2.0, -1.0, 0.0, 2.0, 3.0, 5.0)


class Chooser(Protocol):
    """Where the decisions come from."""

    def below(self, n: int) -> int:
        """A whole number from 0 to n - 1; 0 is the simplest."""
        ...


@dataclass(slots=True)
class Dice:
    """Decisions by a seeded generator."""

    rng: np.random.Generator

    @classmethod
    def seeded(cls, seed: int) -> Dice:
        return cls(np.random.default_rng(seed))

    def below(self, n: int) -> int:
        return int(self.rng.integers(n))


def draw_graph(chooser: Chooser, size: int = 24) -> Node:
    """A random graph of at most about `size` operations, a field of real numbers."""
    reals: list[Node] = [X, Y, Z, 0.1 * X, 0.1 * Y, 0.1 * Z]
    bools: list[Node] = []
    names = list(TABLE)
    for _ in range(1 + chooser.below(size)):
        name = names[chooser.below(len(names))]
        row = TABLE[name]
        arguments = [_argument(chooser, k, reals, bools) for k in row.args]
        made = node(name, *_fit(chooser, name, arguments), value=_asked(chooser, name))
        (reals if kind(made) == "real" else bools).append(made)
    fields = [n for n in reals[6:] if n.axes]
    if fields:
        return fields[-1]
    if bools and bools[-1].axes:
        return node("select", bools[-1], X, ZERO)
    return reals[chooser.below(6)]


def _asked(chooser: Chooser, name: str) -> Value:
    """What more an operation that reads data is asked: what the language can ask, values and not derivatives."""
    row = TABLE[name]
    if name == "joined":  # of its derivatives the language asks for the first
        return row.results[chooser.below(4)]
    if row.results:
        asked = {"sites": tuple(_OF_SITES), "random": row.results[:3]}.get(name, row.results)
        return asked[chooser.below(len(asked))]
    return (0, 0, 0, 0) if row.payload else None


def _argument(chooser: Chooser, wanted: str, reals: list[Node], bools: list[Node]) -> Node:
    if wanted in ("grid", "segments"):
        return samples.slot(wanted)
    if wanted == "bool":
        return bools[-1 - chooser.below(min(len(bools), 4))] if bools else node("lt", ZERO, reals[chooser.below(3)])
    match chooser.below(8):
        case 0:
            return const(_CONSTANTS[chooser.below(len(_CONSTANTS))])
        case 1:
            return param(list(RANGES)[chooser.below(len(RANGES))])
        case 2 | 3:
            return reals[chooser.below(6)]
        case _:
            return reals[-1 - chooser.below(min(len(reals), 6))]


def _fit(chooser: Chooser, name: str, arguments: list[Node]) -> list[Node]:
    """Arguments that the operation makes sense of, most of the time."""
    if name == "joined":
        return [*arguments[:4], samples.JOINT]
    if name == "direction":  # exists only as part of the length of a vector
        return [arguments[0], node("hypot", *arguments)]
    if name in ("random", "sites"):  # whose seed and jitter are numbers
        return [*arguments[:3], const(3.0), const(0.75)][: len(arguments)]
    # what is constant is computed by the compiler, which refuses a constant that is not a number
    constant = all(a.stage is Stage.CONST for a in arguments)
    if chooser.below(8) == 0 and name not in ("exp", "pow") and not constant:
        return arguments
    match name:
        case "exp":
            return [node("min", arguments[0], const(8.0))]
        case "pow":
            base = node("abs", arguments[0])
            if chooser.below(2):
                return [arguments[0], const(_WHOLE[chooser.below(len(_WHOLE))])]
            return [node("min", base, const(20.0)), node("max", node("min", arguments[1], const(3.0)), const(-1.0))]
        case "div" | "mod":
            return [arguments[0], node("add", node("abs", arguments[1]), const(0.25))]
        case "sqrt":
            return [node("abs", arguments[0])]
        case "log":
            return [node("add", node("abs", arguments[0]), const(0.5))]
        case "asin" | "acos":
            return [node("sin_turns", arguments[0])]
    return arguments


def program_text(root: Node) -> str:
    """A graph as a program of the language, an operation a line; its output is `part`."""
    read = {n.value for n in order([root]) if n.op == "param"}
    lines = [
        f"param {name} = {(lo + hi) / 2!r} in {_number(lo)}..{_number(hi)}"
        for name, (lo, hi) in RANGES.items()
        if name in read
    ]
    names: dict[Node, str] = {}
    for n in order([root], within):
        if n.op in TASKS:
            continue
        if n.op == "const":
            names[n] = _number(n.value) if not isinstance(n.value, bool) else str(n.value).lower()
        elif n.op in ("x", "y", "z"):
            names[n] = n.op
        elif n.op == "param":
            names[n] = str(n.value)
        else:
            names[n] = f"v{len(names)}"
            lines.append(f"let {names[n]} = {_call(n, [names[a] for a in n.args if a in names])}")
    lines.append(f"out part = {names[root]}")
    return "\n".join(lines) + "\n"


#: What the language calls the results of the nearest bar.
_MEMBERS = {
    **{f"n{a}": f"outward.{a}" for a in "xyz"},
    **{f"d{a}": f"direction.{a}" for a in "xyz"},
    **{name: name for name in ("distance", "along", "radius", "length", "index")},
}


#: And those of the nearest site.
_OF_SITES = {
    **{name: name for name in ("f1", "f2", "f3", "wall", "number")},
    **{f"{a}1": f"outward.{a}" for a in "xyz"},
    **{f"{a}w": f"across.{a}" for a in "xyz"},
}


def _number(value: object) -> str:
    text = repr(float(value))  # type: ignore[arg-type]  # a const holds a number
    return f"({text})" if text.startswith("-") else text


def _call(n: Node, names: list[str]) -> str:
    symbol = TABLE[n.op].symbol
    place = f"[{', '.join(names)}]"
    match n.op:
        case "lookup":
            return f'load("{samples.GRID_FILE}", "{samples.GRID_NAME}") @ {place}'
        case "lookup_cubic":
            return f'load("{samples.GRID_FILE}", "{samples.GRID_NAME}", smooth=true) @ {place}'
        case "covers":  # what is held beyond the grid is not asked for by itself
            inside = f'load("{samples.GRID_FILE}", "level", outside=0)'
            return f"({inside} @ {place}) > 0"
        case "nearest":
            return f'bare(nearest_bar("{samples.FRAME_FILE}").{_MEMBERS[str(n.value)]} @ {place})'
        case "joined":
            made = f'frame("{samples.FRAME_FILE}", joint={samples.FILLET!r})'
            place = f"[{', '.join(names[:3])}]"
            return f"{made} @ {place}" if n.value == "distance" else f"bare(grad({made}).{str(n.value)[1]} @ {place})"
        case "random":
            return f"random([{', '.join(names[:3])}], {names[3]}).{n.value}"
        case "sites":
            return f"bare(nearest_site([{', '.join(names[:3])}], {names[3]}, {names[4]}).{_OF_SITES[str(n.value)]})"
        case "principal":
            axis, which = str(n.value)[0], str(n.value)[1]
            member = "value" if axis == "v" else f"direction.{axis}"
            return f"bare(principal(tensor({', '.join(names)}), {which}).{member})"
    if n.op == "neg":
        return f"-({names[0]})"
    if n.op == "select":
        return f"if {names[0]} then {names[1]} else {names[2]}"
    if n.op == "not":
        return f"not {names[0]}"
    if n.op == "direction":  # no function: what the language would write
        return f"if {names[1]} == 0 then 0 else {names[0]} / {names[1]}"
    if symbol in OPERATORS or symbol in ("and", "or"):
        return f"{names[0]} {symbol} {names[1]}"
    call = f"{symbol}({', '.join(names)})"
    return f"bare({call})" if TABLE[n.op].units == "angle of" else call  # an angle fits only where angles are meant
