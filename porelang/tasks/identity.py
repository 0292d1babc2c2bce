"""When two tasks are the same: by the flat graph of their fields, what is bound in it, and the code that computes.

No name and no text enters: a program that was renamed, reformatted or written another way asks the same questions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np

from porelang import __version__, resources
from porelang.formula import Bindings
from porelang.ir import TASKS, Node, unknown
from porelang.tape import lower

#: The code that a result depends on, by folder or file of the package.
_CODE = (
    "data.py",
    "ir.py",
    "interval.py",
    "rewrite.py",
    "tape.py",
    "formula.py",
    "ops",
    "rewrites",
    "analysis",
    "backends",
    "tasks",
)


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
        asked = [n.op, outside]
    else:
        if n.op == "solve":  # what it looks for is not what is being tried around it
            sought = unknown(int(n.value))  # type: ignore[arg-type]  # the level
            bindings, known = {m: v for m, v in bindings.items() if m is not sought}, {}
        asked = [_code(), n.op, repr(n.value), _structure(n.args)]
        tape = lower(n.args)
        for i in tape.slots:
            slot = tape.nodes[i]
            if slot.op in TASKS:
                asked.append(_identity(slot, bindings, content, known))
            elif slot in bindings:
                asked.append(np.float64(bindings[slot]).tobytes().hex())  # type: ignore[arg-type]  # a number
            else:
                asked.append(f"?{slot.value}")
    known[n] = hashlib.sha256("\n".join(asked).encode()).hexdigest()
    return known[n]


@lru_cache(maxsize=512)
def _structure(roots: tuple[Node, ...]) -> str:
    """A digest of the tape of roots, whatever its slots are called and bound to."""
    tape = lower(roots)
    digest = hashlib.sha256()
    slots = {i: k for k, i in enumerate(tape.slots)}
    for i, op in enumerate(tape.ops):
        value = tape.values[i]
        said = f"slot {slots[i]}" if i in slots else f"{op} {value.hex() if isinstance(value, float) else value!r}"
        digest.update(f"{said} {tape.inputs[i]}\n".encode())
    digest.update(repr(tape.roots).encode())
    return digest.hexdigest()


@cache
def _code() -> str:
    """A digest of the code: what another version of it found is not this version's."""
    digest = hashlib.sha256(__version__.encode())
    for part in _CODE:
        where = resources.PACKAGE / part
        for path in sorted(where.rglob("*.py")) if where.is_dir() else [where]:
            digest.update(path.read_bytes())
    return digest.hexdigest()
