"""`make bench`: how fast fields are evaluated and meshed, as medians and ratios within one run.

Nothing here is asserted: read the ratios. `make bench-peers` adds the tools that people would use instead; `--readme`
writes the table of the specimen into README.md.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any

from cells import cells
from data import data
from edits import edits
from elasticity import elasticity
from fields import fields
from loop import loop
from meshes import compiling, pruning, specimen
from metric import metric
from peers import install
from phases import phases
from porosities import porosities
from preview import preview
from sampling import sampling
from shapes import shapes
from starts import starts
from tensors import tensors
from tetmeshers import tetmeshers
from tets import tets
from timing import machine
from transfers import transfers

README = Path(__file__).parent.parent / "README.md"
TABLE = re.compile(r"(<!-- benchmarks -->\n).*?(<!-- end -->)", re.DOTALL)


def main() -> None:
    parser = argparse.ArgumentParser(prog="benchmarks", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument(
        "--only",
        help="of specimen, pruning, fields, metric, data, sampling, shapes, tensors, phases, tets, tetmeshers, loop, "
        "elasticity, gpu, compiling, starts, edits, preview, porosities, cells",
    )
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--readme", action="store_true", help="write the table of the specimen into README.md")
    parser.add_argument("--peers", action="store_true", help="first install what is compared with, into .peers")
    options = parser.parse_args()
    if options.peers:
        install()
    sections = {
        "specimen": lambda: specimen(options.rounds),
        "pruning": lambda: pruning(max(3, options.rounds // 3)),
        "fields": lambda: fields(options.rounds),
        "metric": lambda: metric(max(3, options.rounds // 3)),
        "data": lambda: data(max(3, options.rounds // 3)),
        "sampling": lambda: sampling(max(3, options.rounds // 3)),
        "shapes": lambda: shapes(max(1, options.rounds // 4)),
        "tensors": lambda: tensors(options.rounds),
        "phases": lambda: phases(max(3, options.rounds // 3)),
        "tets": lambda: tets(max(1, options.rounds // 3)),
        "tetmeshers": lambda: tetmeshers(max(1, options.rounds // 3)),
        "loop": loop,
        "elasticity": lambda: elasticity(max(1, options.rounds // 4)),
        "gpu": lambda: transfers(options.rounds),
        "compiling": lambda: compiling(max(3, options.rounds // 3)),
        "starts": lambda: starts(options.rounds),
        "edits": lambda: edits(options.rounds),
        "preview": lambda: preview(options.rounds),
        "porosities": lambda: porosities(max(1, options.rounds // 4)),
        "cells": cells,
    }
    if options.only and options.only not in sections:
        parser.error(f"--only takes one of {', '.join(sections)}")
    results: dict[str, list[dict[str, Any]]] = {}
    if not options.json:
        print(machine())
    for name, section in sections.items():
        if options.only in (None, name):
            results[name] = section()
            if not options.json:
                print(f"\n{name}", *map(line, results[name]), sep="\n", flush=True)
    if options.json:
        print(json.dumps({"machine": machine(), **results}, indent=1))
    if options.readme and "specimen" in results:
        text = table(results["specimen"], results.get("pruning", []))
        README.write_text(TABLE.sub(lambda m: f"{m[1]}{text}{m[2]}", README.read_text(encoding="utf-8")))


def line(row: dict[str, Any]) -> str:
    numbers = "  ".join(f"{v:.3g} {k}" if isinstance(v, float) else f"{v} {k}" for k, v in row.items() if k != "case")
    return f"  {row['case']:<36}{numbers}"


def table(rows: list[dict[str, Any]], pruned: list[dict[str, Any]]) -> str:
    """The specimen's rows as Markdown."""
    lines = ["| | s | CPU s | x | triangles | what is wrong with the mesh |", "|---|---|---|---|---|---|"]
    for r in rows:
        numbers = f"{r['seconds']:.3g} | {r['CPU s']:.3g} | {r['/ porelang']:.3g} | {r['triangles']:,}"
        lines.append(f"| {r['case']} ({r['versions']}) | {numbers} | {r['defects']} |")
    lines += ["", f"Medians of one run, taken in turn, on {machine()}."]
    if pruned:
        gains = ", ".join(f"{r['case'].partition(',')[0]} {r['all / pruned']:.1f} x" for r in pruned)
        lines.append(
            f"A 512^3 grid round a part in a tenth of its box is meshed faster than with every brick sampled: {gains}."
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
