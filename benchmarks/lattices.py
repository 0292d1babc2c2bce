"""The loop on real lattices, in tetrahedra of the second order, each beside what the homogenised lattice promises.

`python benchmarks/lattices.py CASE`, minutes each: `beam` on three supports and `cylinder` under a patch load, networks
of gyroid of half the solid; `platens`, a column of it between bonded ones; `orientation`, a diamond network that stands
or lies; `period`, a cantilever of rods as thick everywhere whose cells adapt, with a phase that is found and without.
`--size 3mm` takes other elements.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

import porelang
from porelang.optimize.run import Optimized

TEXTS = {
    "beam": ("3.3mm", """
        param t: field = 0
        let body = box([240mm, 40mm, 40mm])
        let lattice = gyroid(20mm) - t & body
        let s = bend(lattice, force=1kN, axis=x, toward=-z, E=1GPa, nu=0.3, pads=20mm, size={size})
        lattice
        """),
    "cylinder": ("6.5mm", """
        param t: field = 0
        let body = cylinder(75mm, 300mm)
        let lattice = gyroid(37.5mm) - t & body
        let s = study(lattice, fix=z < -149.9mm, load=force(z > 149.9mm and hypot(x, y) < 25, [0N, 0N, -10kN]),
                      E=1GPa, nu=0.3, size={size})
        lattice
        """),
    "platens": ("3.4mm", """
        param t: field = 0
        let lattice = gyroid(20mm) - t & box([60mm, 60mm, 100mm])
        let s = compress(lattice, force=1kN, axis=z, platens="bonded", E=1GPa, nu=0.3, size={size})
        lattice
        """),
    "orientation": ("2mm", """
        let body = box([36mm, 36mm, 60mm])
        let whole = compress(body, force=-1kN, axis=z, E=1GPa, nu=0.3, size=6mm)
        # 111 is turned to x first, which `align` turns to the greatest tension
        let lying = align(rotate(diamond(12mm), axis=[0, 1, -1], angle=acos(1 / sqrt(3))), whole.direction1)
        let s100 = compress(diamond(12mm) & body, force=-1kN, axis=z, E=1GPa, nu=0.3, size={size})
        let s111 = compress(lying & body, force=-1kN, axis=z, E=1GPa, nu=0.3, size={size})
        out along_100 = diamond(12mm) & body
        out along_111 = lying & body
        out cell = diamond(12mm)
        """),
    "period": ("3mm", """
        param w: field = {start}
        let body = translate(box([120mm, 40mm, 40mm]), {at})
        let lattice = {lattice} & body
        let s = bend(lattice, force=1kN, axis=x, toward=-z, supports="cantilever", E=1GPa, nu=0.3, size={size})
        lattice
        """),
}  # fmt: skip
#: Rods of the network are as thick everywhere: its density goes with the square of their number.
RODS, MIDDLE, FAR = "1.5 * ((20mm / w)^2 - 1)", "[0, 0, 0]", "[260mm, 20mm, 20mm]"
#: What adapts, its start, the lattice, and where the cantilever lies: lattices know where the origin is.
NETWORKS = {
    "phase": ("20mm", f"gyroid(phase=phase(w, body)) - {RODS}", MIDDLE),
    "naive": ("20mm", f"gyroid(w) - {RODS}", MIDDLE),
    "thickness": ("0", "gyroid(20mm) - w", MIDDLE),
    "phase, far from the origin": ("20mm", f"gyroid(phase=phase(w, body)) - {RODS}", FAR),
    "naive, far from the origin": ("20mm", f"gyroid(w) - {RODS}", FAR),
}


def text(case: str, size: str, **more: str) -> str:
    return "\n".join(line.strip() for line in TEXTS[case][1].strip().splitlines()).format(size=size, **more)


def timed(what: str, work: Callable[[], Optimized]) -> None:
    begin = time.process_time()
    found = work()
    print(f"\n{what}, {time.process_time() - begin:.0f} s of CPU", found.table, found.reason, sep="\n")
    if found.promise:
        print(found.promise, "steps", *(f"{c / found.promise.uniform:.3f}" for c in found.promise.path))
    print(*(f"{d.code}: {d.message}" for d in found.told), sep="\n", flush=True)


def loops(case: str, size: str, most: int) -> None:
    program = porelang.compile(text(case, size))
    timed("energy", lambda: program.iterate(limits=(0.25, 0.8), most=most))
    timed("energy, early steps homogenised", lambda: program.iterate(limits=(0.25, 0.8), most=2, early="homogenised"))
    timed("optimum", lambda: program.iterate(limits=(0.25, 0.8), rule="optimum"))


def orientation(size: str) -> None:
    program = porelang.compile(text("orientation", size))
    numbers = program.homogenize("cell", nu=0.3).numbers
    print(f"homogenised: Zener ratio {numbers['zener']:.2f}, 111 over 100 {numbers['E.100'] / numbers['E.111']:.3f}")
    found = [program.study(s).numbers for s in ("s100", "s111")]
    for name, numbers in zip(("100", "111"), found, strict=True):
        c, v = numbers["compliance"], numbers["volume"]
        print(f"{name}: compliance {c.value:.4g} +- {c.error / c.value:.1%}, porosity {1 - v.value / 36 / 36 / 60:.4f}")
    print(f"111 over 100 {np.divide(*(n['compliance'].value for n in reversed(found))):.3f}")


def period(size: str) -> None:
    for name, (start, lattice, at) in NETWORKS.items():
        program = porelang.compile(text("period", size, start=start, lattice=lattice, at=at))
        try:
            timed(name, lambda program=program: program.iterate(limits=(0.3, 0.75), porosity=0.5, rule="optimum"))
        except porelang.PoreError as error:  # what falls into pieces is refused
            print(f"\n{name}: {error}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(prog="lattices")
    parser.add_argument("case", choices=TEXTS)
    parser.add_argument("--size")
    parser.add_argument("--max", type=int, default=3)
    options = parser.parse_args()
    size = options.size or TEXTS[options.case][0]
    if options.case == "orientation":
        orientation(size)
    elif options.case == "period":
        period(size)
    else:
        loops(options.case, size, options.max)


if __name__ == "__main__":
    main()
