"""The GLSL backend: a flat graph as the function `float field(vec3 p)` inside a scaffold from shaders/.

Every intermediate is `precise`, so that a driver neither contracts nor reorders it; functions whose precision the
specification leaves open come from shaders/lib instead. Uniform nodes are computed on the host and arrive as `u[i]`: a
parameter's change never changes the text. The cheaper form of an operation is used where enclosures prove, over all of
space and all settings, that its special cases cannot occur.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from porelang import resources
from porelang.analysis.enclose import F32, enclose, everywhere
from porelang.interval import Interval, interval
from porelang.ir import Node, Stage, order
from porelang.ops import TABLE, kind

Form = Literal["points", "grid", "fragment", "webgl"]
_SCAFFOLD = {"points": "points.comp", "grid": "grid.comp", "fragment": "march.frag", "webgl": "march.frag"}
_VERSION = {
    "fragment": "#version 430",
    "webgl": "#version 300 es\nprecision highp float;\nprecision highp int;\n#define precise",
}
_NAME = re.compile(r"\bpore_\w+")
#: What an operation's cheaper form asks of its arguments.
_CALM: dict[str, Callable[..., bool]] = {
    "divisor": lambda a, b: (
        _never_nan(b)
        and (bool((b.lo > 1e-30).all() and (b.hi < 1e30).all()) or bool((b.hi < -1e-30).all() and (b.lo > -1e30).all()))
    ),
    "numbers": lambda a, b: _never_nan(a) and _never_nan(b),
    "not negative": lambda a: _never_nan(a) and bool((a.lo >= 0).all()),
}


def _never_nan(r: Interval) -> bool:
    return not bool(np.any(r.nan))


@dataclass(frozen=True, slots=True)
class Shader:
    """A shader's text, and the nodes whose values it expects in `u`, in order."""

    text: str
    uniforms: tuple[Node, ...]


def shader(root: Node, ranges: Mapping[str, tuple[float, float]], form: Form) -> Shader:
    """The shader that evaluates `root`; `ranges` are the params' ranges. A condition comes back as 1 or 0."""
    body, uniforms = field_function(root, ranges)
    scaffold = resources.read(f"shaders/{_SCAFFOLD[form]}")
    library = _library(body)
    parts = [f"uniform float u[{len(uniforms)}];"] if uniforms else []
    text = scaffold.replace("// @field", "\n".join([*parts, *library, body]))
    if form in _VERSION:
        text = text.replace("// @version", _VERSION[form], 1)
    return Shader(text, uniforms)


def field_function(root: Node, ranges: Mapping[str, tuple[float, float]]) -> tuple[str, tuple[Node, ...]]:
    """The text of `float field(vec3 p)`, and the uniform nodes it reads."""
    nodes = order([root], lambda n: n.args if n.stage is Stage.FIELD else ())
    calm = _calm(nodes, ranges)
    uniforms: list[Node] = []
    names: dict[Node, str] = {}
    lines: list[str] = []
    for n in nodes:
        if n.op == "const":
            names[n] = literal(n.value)  # type: ignore[arg-type]  # a const holds a number
        elif n.stage is Stage.UNIFORM:
            names[n] = f"u[{len(uniforms)}]" if kind(n) == "real" else f"(u[{len(uniforms)}] != 0.0)"
            uniforms.append(n)
        elif n.op in ("x", "y", "z"):
            names[n] = f"p.{n.op}"
        else:
            names[n] = f"v{len(lines)}"
            row = TABLE[n.op]
            form = row.guarded if n in calm else row.glsl
            boolean = kind(n) == "bool"
            text = form.format(*(_operand(n, a, names) for a in n.args))
            lines.append(f"    {'bool' if boolean else 'precise float'} {names[n]} = {text};")
    result = f"{names[root]} ? 1.0 : 0.0" if kind(root) == "bool" else names[root]
    # pore_keep: llvmpipe stores lane by lane, and without it would compute the last operations lane by lane too
    return "\n".join(["float field(vec3 p) {", *lines, f"    return pore_keep({result});", "}"]), tuple(uniforms)


def _operand(n: Node, a: Node, names: Mapping[Node, str]) -> str:
    """How an argument is written: a factor of 0 is hidden, for drivers fold x * 0 to 0, also where x is no number."""
    return "pore_nought" if n.op == "mul" and a.op == "const" and a.value == 0.0 else names[a]


def literal(value: float | bool) -> str:
    """A constant as GLSL, rounded to float32."""
    if isinstance(value, bool):
        return "true" if value else "false"
    with np.errstate(over="ignore"):
        single = np.float32(value)
    if np.isnan(single):
        return "pore_nan()"
    if np.isinf(single):
        return "pore_inf()" if single > 0 else "(-pore_inf())"
    text = np.format_float_scientific(single, unique=True, trim="0")
    return f"({text})" if single < 0 or (single == 0 and np.signbit(single)) else text


def _calm(nodes: Sequence[Node], ranges: Mapping[str, tuple[float, float]]) -> set[Node]:
    """The nodes whose cheaper form is right everywhere."""
    watched = [n for n in nodes if n.op in TABLE and n.stage is Stage.FIELD and TABLE[n.op].calm]
    if not watched:
        return set()
    inputs = list(dict.fromkeys(a for n in watched for a in n.args))
    params = {name: interval(np.array(lo), np.array(hi)) for name, (lo, hi) in ranges.items()}
    known = dict(zip(inputs, (e.range for e in enclose(inputs, everywhere(), params, F32)), strict=True))
    return {n for n in watched if _CALM[TABLE[n.op].calm](*(known[a] for a in n.args))}


def _library(body: str) -> list[str]:
    """The library functions that a text calls, each after those it calls itself."""
    out: list[str] = []
    done: set[str] = set()

    def add(name: str) -> None:
        if name in done:
            return
        done.add(name)
        text = _function(name)
        for other in _calls(text):
            add(other)
        out.append(text)

    for name in _calls(body):
        add(name)
    return out


def _calls(text: str) -> list[str]:
    """The library functions named in the code (not the comments) of a text, in order."""
    code = re.sub(r"//[^\n]*", "", text)
    return list(dict.fromkeys(_NAME.findall(code)))


@cache
def _function(name: str) -> str:
    return resources.read(f"shaders/lib/{name}.glsl").strip()
