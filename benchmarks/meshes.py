"""Meshes: the specimen against what people would use instead, what pruning saves, and compilation; in seconds."""

from __future__ import annotations

from typing import Any

from peers import PEERS, Running
from timing import Case, Times, in_turn, middle

import porelang
from porelang.ir import order
from porelang.mesh import Surface
from porelang.mesh.part import grid_of, surface_of

#: A box of 50 x 50 x 51 mm of which the cylinder fills a tenth.
BOX = (-25.0, -25.0, -25.5, 25.0, 25.0, 25.5)
SPARSE = {
    "cylinder": "cylinder(9, 50)",
    "gyroid sheet in it": "gyroid(4) |> shell(1.53) & cylinder(9, 50)",
    "twisted gyroid sheet in it": "gyroid(4) |> twist(0.05) |> shell(1.53) & cylinder(9, 50)",
}
MANY = 2000


def specimen(rounds: int) -> list[dict[str, Any]]:
    """The gyroid sheet in the cylinder, by every peer that is installed, in turn."""
    running = [Running(peer) for peer in PEERS if peer.python.exists()]
    taken: dict[str, list[Times]] = {r.peer.title: [] for r in running}
    for turn in range(rounds):
        for r in running:
            if turn < r.peer.rounds:
                answer = r.run()
                taken[r.peer.title].append(Times(answer["wall"], answer["cpu"]))
    rows = []
    for r in running:
        r.end()
        time, ours = middle(taken[r.peer.title]), middle(taken[running[0].peer.title])
        rows.append({
            "case": r.peer.title, "seconds": time.wall, "CPU s": time.cpu, "/ porelang": time.wall / ours.wall,
            "triangles": len(r.surface.faces), "defects": defects(r.surface), "versions": r.versions,
        })  # fmt: skip
    return rows


def defects(surface: Surface) -> str:
    """What keeps a mesh from being printed as it is."""
    found = surface.check()
    inside_out = [d for d in found if "inside out" in d]
    if inside_out and len(found) == 1:  # which way the corners run is a choice of the peer
        return "none"
    return "; ".join(d for d in found if d not in inside_out) or "none"


def pruning(rounds: int, size: int = 512) -> list[dict[str, Any]]:
    """A grid of size^3 round a cylinder that fills a tenth of its box, with and without ruling bricks out."""
    rows = []
    for name, text in SPARSE.items():
        design = porelang.compile(text).design()

        def run(prune: bool, design: porelang.Design = design) -> Surface:
            return surface_of(design, None, grid_of(design, resolution=size, bounds=BOX), prune=prune)

        assert len(run(True).faces) == len(run(False).faces)
        times = in_turn({"pruned": lambda: run(True), "all": lambda: run(False)}, rounds)
        rows.append({
            "case": f"{name}, {size}^3", "pruned s": times["pruned"].wall, "all s": times["all"].wall,
            "all / pruned": times["all"].wall / times["pruned"].wall,
            "all / pruned, CPU": times["all"].cpu / times["pruned"].cpu,
        })  # fmt: skip
    return rows


def compiling(rounds: int) -> list[dict[str, Any]]:
    """From text to the flat graph, and the box of a part."""
    many = "\n".join(
        f"let s{i} = sphere({3 + i % 5}) |> translate([{i % 40 * 10}, {i // 40 * 10}, {i % 7}])" for i in range(MANY)
    )
    many += "\n" + " | ".join(f"s{i}" for i in range(MANY))
    sheet = "gyroid(30) |> shell(1.53) & cylinder(75, 300)"
    cases: dict[str, Case] = {
        "compile the sheet": lambda: porelang.compile(sheet).solid(),
        "find the sheet's bounds": lambda: porelang.compile(sheet).bounds(),
        f"compile {MANY} spheres": lambda: order([porelang.compile(many).solid()]),
    }
    return [{"case": n, "seconds": t.wall, "CPU s": t.cpu} for n, t in in_turn(cases, rounds).items()]
