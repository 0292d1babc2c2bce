"""The loop on real lattices: a beam on three supports and a cylinder under a patch load, networks of gyroid of half the
solid, in tetrahedra of the second order; beside each what the homogenised lattice promises with the same rule.

Minutes each: `python benchmarks/lattices.py beam`, or `cylinder`, with `--size 3mm` for other elements.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import porelang
from porelang.optimize import laws, loop
from porelang.optimize.grid import Force, Grid, Problem, Support
from porelang.optimize.rules import Energy
from porelang.optimize.run import Optimized

Points = NDArray[np.float64]
Where = Callable[[Points], Any]
LIMITS = (0.25, 0.8)
#: A cell of the network, and offsets that take its density from .2 to .83.
CELL, OFFSETS = "param t = 0 in -1.2..1.2\ngyroid(20mm) - t", "t=-0.9..1:9"
TEXTS = {
    "beam": (20.0, "3.3mm", """
        let body = box([240mm, 40mm, 40mm])
        let lattice = gyroid(20mm) - t & body
        let s = bend(lattice, force=1kN, axis=x, toward=-z, E=1GPa, nu=0.3, pads=20mm, size={size})
        """),
    "cylinder": (37.5, "6.5mm", """
        let body = cylinder(75mm, 300mm)
        let lattice = gyroid(37.5mm) - t & body
        let s = study(lattice, fix=z < -149.9mm, load=force(z > 149.9mm and hypot(x, y) < 25, [0N, 0N, -10kN]),
                      E=1GPa, nu=0.3, size={size})
        """),
}  # fmt: skip
NEAR = 1e-6


def beam() -> Problem:
    """As `bend` holds it: supports .9 of the length apart, pads 20 mm wide."""
    grid = Grid(np.ones((96, 16, 16)), (-120.0, -20.0, -20.0), (2.5, 2.5, 2.5))

    def pad(at: float, high: bool) -> Where:
        return lambda p: (np.abs(p[:, 0] - at) < 10 + NEAR) & (np.abs(p[:, 2] - (20 if high else -20)) < NEAR)

    def line(p: Points) -> Any:
        return (np.abs(p[:, 0] + 107.5) < NEAR) & (np.abs(p[:, 2] + 20) < NEAR)

    # pads press evenly and let the beam turn: two balance the third, and a line keeps it in place
    loads = tuple(Force(pad(x, x == 0), (0, 0, f)) for x, f in ((0, -1000.0), (-107.5, 500.0), (107.5, 500.0)))
    far = Support(lambda p: (np.abs(p[:, 0] - 107.5) < NEAR) & (np.abs(p[:, 2] + 20) < NEAR), (False, False, True))
    return Problem(grid, (Support(line), far), loads)


def cylinder() -> Problem:
    grid = Grid.of(
        lambda p: np.maximum(np.hypot(p[:, 0], p[:, 1]) - 75, np.abs(p[:, 2]) - 150),
        (-75, -75, -150),
        (75, 75, 150),
        9.4,
    )
    pressed = Force(lambda p: (p[:, 2] > 150 - NEAR) & (np.hypot(p[:, 0], p[:, 1]) < 25), (0, 0, -1e4))
    return Problem(grid, (Support(lambda p: p[:, 2] < -150 + NEAR),), (pressed,))


def law() -> laws.Lattice:
    """The network as a material, of a solid of 1 GPa."""
    return laws.Lattice(porelang.compile(CELL).homogenize(sweep=OFFSETS, resolution=32, nu=0.3).law, 1000.0)


def real(case: str, size: str, most: int) -> Optimized:
    _, _, text = TEXTS[case]
    lines = ["param t: field = 0", *(line.strip() for line in text.format(size=size).strip().splitlines()), "lattice"]
    return porelang.compile("\n".join(lines)).design().iterate(limits=LIMITS, most=most)


def main() -> None:
    parser = argparse.ArgumentParser(prog="lattices")
    parser.add_argument("case", choices=TEXTS)
    parser.add_argument("--size")
    parser.add_argument("--max", type=int, default=3)
    options = parser.parse_args()
    cell, size, _ = TEXTS[options.case]
    problem = {"beam": beam, "cylinder": cylinder}[options.case]()
    promised = loop.iterate(
        loop.Homogenised(problem, law()), Energy(), loop.Plan(0.5, *LIMITS, cell, 1e-4, options.max)
    )
    print(
        "homogenised",
        *(f"{s.compliance:.5g} ({s.compliance / promised.steps[0].compliance:.3f})" for s in promised.steps),
    )
    if options.max:
        found = real(options.case, options.size or size, options.max)
        print(found.table, found.reason, sep="\n")


if __name__ == "__main__":
    main()
