"""When two tasks are the same: by the flat graph of their fields, what is bound in it, and the code that computes.

No name and no text enters, and of a sum or an intersection not which part stands first: a program that was renamed,
reformatted or rearranged asks the same questions. (A param and the number it has are not told apart either, but where
the compiler could fold the number.)
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache

import numpy as np

from porelang import __version__, resources
from porelang.formula import Bindings
from porelang.ir import SLOTS, TASKS, Node, Value, unknown
from porelang.ops import TABLE
from porelang.tape import Tape, lower

#: The code that a result depends on, by folder or file of the package.
_FILES = ("data.py", "ir.py", "interval.py", "rewrite.py", "tape.py", "formula.py", "parallel.py")
_CODE = (*_FILES, "ops", "rewrites", "analysis", "backends", "tasks")


def identity(n: Node, bindings: Bindings, content: Callable[[Node], str]) -> str:
    """The name of a task's result: a digest of all it depends on.

    `bindings` are the settings, and the values of the unknowns that are being tried; `content` gives the digest of what
    a task reads from outside the program (a file), or "" where there is no such thing.
    """
    return _identity(n, {m: v for m, v in bindings.items() if m.op not in TASKS}, content, {})


def _identity(n: Node, bindings: Bindings, content: Callable[[Node], str], known: dict[Node, str]) -> str:
    if n in known:
        return known[n]
    outside = content(n)
    if outside:
        known[n] = _digest(n.op, outside)
        return known[n]
    if n.op == "solve":  # what it looks for is not what is being tried around it
        assert isinstance(n.value, int)
        sought = unknown(n.value)
        bindings, inside = {m: v for m, v in bindings.items() if m is not sought}, dict[Node, str]()
    else:
        inside = known

    def slot(m: Node) -> str:
        if m.op in TASKS:
            return _identity(m, bindings, content, inside)
        if m in bindings:
            return np.float64(bindings[m]).tobytes().hex()  # type: ignore[arg-type]  # a number
        return f"?{m.value}"

    tape = lower(n.args)
    known[n] = _digest(_code(), n.op, _written(n.value), *_roots(tape, slot))
    return known[n]


def _roots(tape: Tape, slot: Callable[[Node], str]) -> list[str]:
    """A digest of each root, from those of what it is made of; of what commutes in an order of their own."""
    digests: list[str] = []
    for i, op in enumerate(tape.ops):
        if op in SLOTS:
            digests.append(slot(tape.nodes[i]))
            continue
        inputs = [digests[a] for a in tape.inputs[i]]
        if op in TABLE and "commutative" in TABLE[op].facts:
            inputs.sort()
        digests.append(_digest(op, _written(tape.values[i]), *inputs))
    return [digests[r] for r in tape.roots]


def _written(value: Value) -> str:
    return value.hex() if isinstance(value, float) else repr(value)


def _digest(*parts: str) -> str:
    return hashlib.blake2b("\n".join(parts).encode(), digest_size=32).hexdigest()


@cache
def _code() -> str:
    """A digest of the code: what another version of it found is not this version's."""
    digest = hashlib.sha256(__version__.encode())
    for part in _CODE:
        where = resources.PACKAGE / part
        for path in sorted(where.rglob("*.py")) if where.is_dir() else [where]:
            digest.update(path.read_bytes())
    return digest.hexdigest()
