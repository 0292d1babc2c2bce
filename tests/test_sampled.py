"""Points at random within solids: wherever these lie, however thin they are, and whether they end."""

from __future__ import annotations

import math

import numpy as np
import pytest

import porelang
from porelang.analysis.sampled import Points, inside_of

#: Bodies about the origin, with half of their size along each axis (mm).
BODIES = [
    ("sphere(0.1)", (0.1, 0.1, 0.1)),
    ("torus(30, 6)", (36, 36, 6)),
    ("box([100, 1, 100])", (50, 0.5, 50)),
    ("cylinder(20, 60) \\ cylinder(19.5, 70)", (20, 20, 30)),
    ("gyroid(8) |> shell(0.4) & cylinder(15, 40)", (15, 15, 20)),
    ("twist(metric(gyroid(10)), 0.1) |> shell(0.8mm) & sphere(20)", (20, 20, 20)),
    ("gyroid(phase=[x/10, y/10, between(z + 10, z - 10, cells=6)]) |> shell(0.3) & box([60, 60, 20])", (30, 30, 10)),
    ("align(gyroid(6), [x, y, 0]) |> shell(0.3) & cylinder(20, 10) \\ cylinder(14, 20)", (20, 20, 5)),
]
#: Where the farthest sample of a wall of a lattice may end short of what cuts it, as part of its size.
SHORT = 0.2
PLACES = [
    (0.0, 0.0, 0.0),
    (80.0, 0.0, 0.0),
    (0.0, 60.0, 0.0),
    (0.0, 500.0, 0.0),
    (200.0, 0.0, 0.0),
    (172.12, -53.8, -3.49),
    (0.0, -40.0, 2000.0),
]


def points_of(text: str) -> Points | None:
    program = porelang.compile(text)
    formula = program.design().of(program.output())
    return inside_of(formula.root, formula.bindings)


@pytest.mark.parametrize(("body", "half"), BODIES)
def test_a_solid_is_found_wherever_it_lies(body: str, half: tuple[float, float, float]) -> None:
    for place in PLACES:
        points = points_of(f"translate({body}, [{', '.join(map(str, place))}])")
        assert points is not None, place
        reach = np.abs(points - place).max(axis=0) / half
        assert (reach <= 1 + 1e-6).all(), place
        assert (reach >= 1 - SHORT).all(), place


@pytest.mark.parametrize(
    "field",
    ["gyroid(8) |> shell(0.4)", "z - 3", "hypot(x - 300, y) - 1", "-sphere(20)", "box([20, 20, 1e9])"],
)
def test_what_has_no_end_is_seen_to_have_none(field: str) -> None:
    assert points_of(field) is None


def test_thin_rods_and_plates_that_stand_askew_are_found_whole() -> None:
    """A box round one is a thousand times as large as itself."""
    for body, half in (("cylinder(0.3, 100)", 50), ("box([90, 90, 0.3])", 45 * math.sqrt(2))):
        points = points_of(f"translate(rotate({body}, [1, 2, 3], 40deg), [70, -90, 130])")
        assert points is not None
        far = np.linalg.norm(points - [70, -90, 130], axis=1).max()
        assert 0.6 * half < far < 1.01 * half
