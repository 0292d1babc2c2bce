"""What an edit of a program costs while it is being written, and what compiling it afresh costs, in ms."""

from __future__ import annotations

import statistics
import time
from typing import Any

from porelang.compiler import compiled
from porelang.session import Session
from porelang.source import Source

#: What an edit replaces, by what is edited, and by what.
EDITS = {
    "a remark at the top": ("param w", "# cells\nparam w"),
    "the radius of a ball": ("let s99 = sphere(4mm)", "let s99 = sphere(5mm)"),
    "a lattice": ("let g98 = gyroid(a96)", "let g98 = gyroid(a96 + 1mm)"),
    "a bracket too many": ("let u100 = (", "let u100 = (("),
    "a param that all of it reads": ("= 30mm in", "= 31mm in"),
}


def program(lines: int) -> str:
    """A program of so many lines: lengths, functions, lattices, balls that are moved and turned, cuts, their union."""
    kinds = (
        "let a{n} = w * {share:.3f} + {n}mm",
        "def f{n}(c, s) = c |> thicken(s, 0.3mm) & sphere({n}mm + 10mm)",
        "let g{n} = gyroid(a{a}) |> shell(0.1)",
        "let s{n} = sphere({r}mm) |> translate([{n}mm, 5mm, 0mm]) |> rotate([0, 0, 1], {n}deg)",
        "let u{n} = (g{g} & s{s}) | box([{r}mm, 2mm, 3mm])",
        "# what stands here is line {n}",
    )
    out = ["param w = 30mm in 10mm..60mm"]
    for n in range(lines - 3):
        values = {"n": n, "share": 1 + n / 1000, "r": 3 + n % 7, "a": n - 2, "g": n - 2, "s": n - 1}
        out.append(kinds[n % len(kinds)].format(**values))
    cut = [f"u{n}" for n in range(4, lines - 3, len(kinds))]
    return "\n".join([*out, f"union([{', '.join(cut)}])", ""])


def edits(rounds: int) -> list[dict[str, Any]]:
    """Each edit is made and taken back again and again; both count. Afresh is the same text without a session."""
    text, found = program(500), []
    for what, (old, new) in EDITS.items():
        assert old in text, what
        session, times, afresh = Session(folder=""), [], []
        session.update("a.pore", text)
        for _ in range(rounds):
            for now in (text.replace(old, new), text):
                begun = time.perf_counter()
                session.update("a.pore", now)
                times.append(time.perf_counter() - begun)
                begun = time.perf_counter()
                compiled(Source("a.pore", now), folder="")
                afresh.append(time.perf_counter() - begun)
        edit, whole = statistics.median(times), statistics.median(afresh)
        found.append({"case": what, "ms": 1e3 * edit, "afresh, ms": 1e3 * whole, "ratio": whole / edit})
    return found
