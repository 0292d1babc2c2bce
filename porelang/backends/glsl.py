"""The GLSL backend: a flat graph as the function `float field(vec3 p)` inside a scaffold from shaders/.

Every intermediate is `precise`, so that a driver neither contracts nor reorders it; functions whose precision the
specification leaves open come from shaders/lib instead. Uniform nodes are computed on the host and arrive as `u[i]`: a
parameter's change never changes the text. The cheaper form of an operation is used where enclosures prove, over all of
space and all settings, that its special cases cannot occur.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from porelang import resources
from porelang.analysis.enclose import F32, enclose, everywhere
from porelang.formula import Bindings, Formula, ranges
from porelang.interval import Interval
from porelang.ir import Node, Stage, constant
from porelang.ops import TABLE, Op
from porelang.tape import AXES, PICK, Tape, lower

Form = Literal["points", "grid", "fragment", "webgl", "plane"]
_SCAFFOLD = {"points": "points.comp", "grid": "grid.comp", "fragment": "march.frag", "webgl": "march.frag",
             "plane": "plane.frag"}  # fmt: skip
_WEBGL = "#version 300 es\nprecision highp float;\nprecision highp int;\n#define precise"
_VERSION = {"fragment": "#version 430", "webgl": _WEBGL, "plane": _WEBGL}
_NAME = re.compile(r"\b(?:pore_|Pore)\w+")
#: What reads a word of the data of a slot; written for each shader, unlike the functions of the library.
WORD = "pore_word"
#: The binding of the first buffer of data: those before it are what is written, the places, and what a picture needs.
FIRST_DATA = {"points": 2, "grid": 2, "fragment": 3}
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
    """A shader's text, the nodes whose values it expects in `u`, and those whose data it expects in buffers."""

    text: str
    uniforms: tuple[Node, ...]
    data: tuple[Node, ...]


def shader(
    roots: tuple[Node, ...], params: Mapping[str, tuple[float, float]], form: Form, paint: Node | None = None
) -> Shader:
    """The shader that evaluates roots; `params` are their ranges. A condition comes back as 1 or 0.

    Pictures have one root, and for WebGL a field in whose colours it is painted; planes have two, the field that is
    shown and the part; points and grids may have several, whose values follow each other.
    """
    uniforms: dict[Node, int] = {}
    data: dict[Node, int] = {}
    body = field_function(roots, params, uniforms, data)
    if paint is not None:
        body += "\n" + field_function((paint,), params, uniforms, data, "paint")
    scaffold = resources.read(f"shaders/{_SCAFFOLD[form]}")
    library = _library(body)
    if form == "plane" or paint is not None:
        library.append(resources.read("shaders/scale.glsl").strip())
    parts = [f"#define ROOTS {len(roots)}"] if len(roots) > 1 else []
    parts += ["#define PAINTED"] if paint is not None else []
    parts += [f"uniform float u[{len(uniforms)}];"] if uniforms else []
    parts += [_word(k, form) for k in range(len(data))]
    text = scaffold.replace("// @field", "\n".join([*parts, *library, body]))
    if form in _VERSION:
        text = text.replace("// @version", _VERSION[form], 1)
    return Shader(text, tuple(uniforms), tuple(data))


def _word(k: int, form: Form) -> str:
    """The function that reads a word of data: from a buffer, or in WebGL, which has none, from a texture of rows."""
    if form in ("webgl", "plane"):
        return (
            f"uniform highp usampler2D data{k};\n"
            f"uint pore_word{k}(int i) {{ return texelFetch(data{k}, ivec2(i & 2047, i >> 11), 0).x; }}"
        )
    return (
        f"layout(std430, binding = {FIRST_DATA[form] + k}) readonly buffer Data{k} {{ uint data{k}[]; }};\n"
        f"uint pore_word{k}(int i) {{ return data{k}[i]; }}"
    )


def field_function(
    roots: tuple[Node, ...],
    params: Mapping[str, tuple[float, float]],
    uniforms: dict[Node, int],
    data: dict[Node, int],
    name: str = "field",
) -> str:
    """The text of `float field(vec3 p)`, of several roots `void fields(vec3 p, out float f[n])`. What it reads is added
    to `uniforms` and `data` with its place there, after what other functions of the shader read."""
    tape = lower(roots)
    calm = _calm(tape, params)
    names: dict[int, str] = {}
    lines: list[str] = []
    for i in sorted({*tape.frontier, *tape.field, *(i for i, op in enumerate(tape.ops) if op in AXES)}):
        n, op = tape.nodes[i], tape.ops[i]
        if op in AXES:
            names[i] = f"p.{op}"
        elif op == "const":
            names[i] = literal(constant(n))
        elif tape.kinds[i] not in ("real", "bool"):
            names[i] = str(data.setdefault(n, len(data)))
        elif tape.stages[i] is not Stage.FIELD:
            u = f"u[{uniforms.setdefault(n, len(uniforms))}]"
            names[i] = u if tape.kinds[i] == "real" else f"({u} != 0.0)"
        elif op == PICK:
            names[i] = f"{names[tape.inputs[i][0]]}.{n.value}"
        else:
            names[i] = f"v{len(lines)}"
            row = TABLE[op]
            form = row.guarded if i in calm else row.glsl
            operands = [_operand(tape, i, a, names) for a in tape.inputs[i]]
            text = form.format(*operands, payload=_payload(n.value), wanted=_wanted(row, tape.values[i]))
            kind = f"Pore{op.capitalize()}" if row.results else "bool" if tape.kinds[i] == "bool" else "precise float"
            lines.append(f"    {kind} {names[i]} = {text};")
    results = [f"{names[r]} ? 1.0 : 0.0" if tape.kinds[r] == "bool" else names[r] for r in tape.roots]
    # pore_keep: llvmpipe stores lane by lane, and without it would compute the last operations lane by lane too
    if len(results) == 1:
        head, tail = f"float {name}(vec3 p) {{", [f"    return pore_keep({results[0]});"]
    else:
        head = f"void {name}s(vec3 p, out float f[{len(results)}]) {{"
        tail = [f"    f[{k}] = pore_keep({r});" for k, r in enumerate(results)]
    return "\n".join([head, *lines, *tail, "}"])


def _wanted(row: Op, names: object) -> int:
    """A bit for each result of a walk that is read, in the order of the row."""
    return sum(1 << row.results.index(name) for name in names) if isinstance(names, tuple) and row.results else 0


def _payload(value: object) -> str:
    return ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _operand(tape: Tape, i: int, a: int, names: Mapping[int, str]) -> str:
    """How an argument is written: a factor of 0 is hidden, for drivers fold x * 0 to 0, also where x is no number."""
    hidden = tape.ops[i] == "mul" and tape.ops[a] == "const" and tape.values[a] == 0.0
    return "pore_nought" if hidden else names[a]


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


def _calm(tape: Tape, params: Mapping[str, tuple[float, float]]) -> set[int]:
    """The positions whose cheaper form is right everywhere, for all settings and all data."""
    watched = [i for i in tape.field if tape.ops[i] in TABLE and TABLE[tape.ops[i]].calm]
    if not watched:
        return set()
    inputs = list(dict.fromkeys(a for i in watched for a in tape.inputs[i]))
    anything: Bindings = {tape.nodes[i]: None for i in tape.slots}
    formula = Formula(tuple(tape.nodes[a] for a in inputs), {**anything, **ranges(params)})
    known = dict(zip(inputs, (e.range for e in enclose(formula, everywhere(), F32)), strict=True))
    return {i for i in watched if _CALM[TABLE[tape.ops[i]].calm](*(known[a] for a in tape.inputs[i]))}


def _library(body: str) -> list[str]:
    """The library functions that a text calls, each after those it calls itself."""
    out: list[str] = []
    done: set[str] = set()

    def add(name: str) -> None:
        if name in done or name.startswith(WORD):
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
    return [name for name in dict.fromkeys(_NAME.findall(code)) if not name.startswith(WORD)]


@cache
def _function(name: str) -> str:
    """The text of a library function; one that reads data, `pore_lookup3`, is written for its slot, `@` in the text."""
    bare = name.rstrip("0123456789")
    if bare == name or (resources.folder("shaders") / "lib" / f"{name}.glsl").exists():
        return resources.read(f"shaders/lib/{name}.glsl").strip()
    return resources.read(f"shaders/lib/{bare}.glsl").strip().replace("@", name.removeprefix(bare))
