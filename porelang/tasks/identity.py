"""When two tasks are the same: by the flat graph of their fields, what is bound in it, and the code that computes.

No name and no text enters, nor the order of arguments that commute: a program that was renamed, reformatted or
rearranged asks the same questions. A param and the number it has are not told apart either, but where the compiler
could fold the number, nor a `solve` from the same one within another.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache

import numpy as np

from porelang import __version__, resources
from porelang.formula import Bindings
from porelang.ir import SLOTS, TASKS, UNKNOWN, Node, Stage, Value, unknown
from porelang.ops import TABLE
from porelang.tape import Tape, lower

#: The code that a result depends on, by folder or file of the package.
_FILES = ("data.py", "ir.py", "interval.py", "rewrite.py", "tape.py", "formula.py", "parallel.py", "compiled.py")
_CODE = (*_FILES, "ops", "rewrites", "analysis", "backends", "tasks")
#: What some tasks depend on besides: a study on its mesher and its solver.
_MORE = {"study": ("solid.py", "walls.py", "tet", "fea")}
#: Of two zeros these give the first: where they are computed once, the order of their arguments counts.
_FIRST_ZERO = ("max", "min")


def identity(n: Node, bindings: Bindings, content: Callable[[Node], str]) -> str:
    """The name of a task's result: a digest of all it depends on.

    `bindings` are the settings, and the values of the unknowns that are being tried; `content` gives the digest of what
    a task reads from outside the program (a file), or "" where there is no such thing.
    """
    bound = {m: v for m, v in bindings.items() if m.op not in TASKS}
    return _identity(n, bound, content, {}, {}, 0)


def _identity(
    n: Node,
    bindings: Bindings,
    content: Callable[[Node], str],
    closed: dict[Node, str],
    open_: dict[Node, str],
    depth: int,
) -> str:
    """`closed` are the digests of tasks that read no unknown, `open_` those of others within the same `solve`, which
    is the one that `depth` others surround."""
    known = open_ if n.depends >= UNKNOWN else closed
    if n in known:
        return known[n]
    if outside := content(n):
        known[n] = _digest(n.op, outside)
        return known[n]
    value = _written(n.value)
    if n.op == "solve":  # what it looks for is not what is being tried around it
        assert isinstance(n.value, int)
        sought = unknown(n.value)
        bindings = {m: v for m, v in bindings.items() if m is not sought}
        value, open_, depth = "", {}, n.value

    def slot(m: Node) -> str:
        if m.op in TASKS:
            return _identity(m, bindings, content, closed, open_, depth)
        if m in bindings:
            return _number(bindings[m])
        assert isinstance(m.value, int)
        return f"?{depth - m.value}"  # by how many searches lie between

    tape = lower(n.args)
    known[n] = _digest(code_digest(n.op if n.op in _MORE else ""), n.op, value, *_roots(tape, slot))
    return known[n]


def _roots(tape: Tape, slot: Callable[[Node], str]) -> list[str]:
    """A digest of each root, from those of what it is made of; of what commutes in an order of their own."""
    digests: list[str] = []
    for i, op in enumerate(tape.ops):
        if op in SLOTS:
            digests.append(slot(tape.nodes[i]))
        elif op == "const" and isinstance(tape.values[i], float):
            digests.append(_number(tape.values[i]))
        else:
            inputs = [digests[a] for a in tape.inputs[i]]
            ordered = op in _FIRST_ZERO and tape.stages[i] is not Stage.FIELD
            if op in TABLE and "commutative" in TABLE[op].facts and not ordered:
                inputs.sort()
            digests.append(_digest(op, _written(tape.values[i]), *inputs))
    return [digests[r] for r in tape.roots]


def _number(value: object) -> str:
    """A number by its bits: 0 and -0 are two."""
    return np.float64(value).tobytes().hex()  # type: ignore[arg-type]  # params and unknowns are bound to numbers


def _written(value: Value) -> str:
    return value.hex() if isinstance(value, float) else repr(value)


def _digest(*parts: str) -> str:
    return hashlib.blake2b("\n".join(parts).encode(), digest_size=32).hexdigest()


@cache
def code_digest(task: str = "") -> str:
    """A digest of the code that finds results, of a task where it is named: what another version of it found is not
    this version's."""
    digest = hashlib.sha256(f"{__version__}, NumPy {np.__version__}".encode())
    for part in (*_CODE, *_MORE.get(task, ())):
        where = resources.PACKAGE / part
        for path in sorted(where.rglob("*.py")) if where.is_dir() else [where]:
            digest.update(path.read_bytes())
    return digest.hexdigest()
