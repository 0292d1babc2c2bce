"""Depths and silhouettes against rays cast here, in float64, through fields written here: no hole, nothing that is not.

A ray is sampled densely and its first entry into solid found by bisection. It knows nothing of bounds, cells or slopes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import porelang
from porelang.analysis.box import Box
from porelang.gpu.fields import gpu
from porelang.render import Camera, Wishes, look, render_output
from porelang.render.camera import VIEWS
from porelang.render.cells import bound_cells
from porelang.render.cuts import Cut, HalfSpace, take_away, whole
from porelang.render.march import Marcher, Scene

Points = NDArray[np.float64]
Field = Callable[[Points], Points]
SIZE = (60, 44)


def shot(
    text: str, view: str = "iso", projection: Any = "perspective", cuts: Sequence[Cut] = (), zoom: float = 1.0,
    bounds: Sequence[float] | None = None, size: tuple[int, int] = SIZE,
) -> tuple[Marcher, Camera, Box]:  # fmt: skip
    """The shader of a program's part, its camera and the box that it draws."""
    program = porelang.compile(text)
    design = program.design()
    part = design.of()
    if bounds is None:
        found = design.bounds()
        more = 1e-3 * max(found.size)
        box = Box(tuple(v - more for v in found.lo), tuple(v + more for v in found.hi))
    else:
        box = Box(tuple(bounds[:3]), tuple(bounds[3:]))
    camera = look(box, VIEWS[view], size, projection, zoom)
    shown = take_away(whole(box, bounds is not None), cuts)
    scene = Scene(part, program.ranges, bound_cells(part, shown.box), shown)
    return Marcher(scene, camera, size, gpu()), camera, box


def cast(field: Field, camera: Camera, box: Box, step: float, size: tuple[int, int] = SIZE) -> Points:
    """Where each ray enters solid for at least two samples `step` mm apart; infinite where it does not."""
    origin, way = (np.reshape(v, (-1, 3)) for v in camera.rays(size))
    with np.errstate(all="ignore"):
        a, b = (np.array(box.lo) - origin) / way, (np.array(box.hi) - origin) / way
    start, end = np.fmin(a, b).max(axis=1), np.fmax(a, b).min(axis=1)
    entry, was = np.full(len(origin), np.inf), np.zeros(len(origin), np.bool_)
    for k in range(math.ceil(float((end - start).max(initial=0)) / step) + 1):
        t = start + k * step
        live = np.flatnonzero((t <= end) & np.isinf(entry))
        inside = field(origin[live] + way[live] * t[live, None]) <= 0
        found = live[inside & was[live]]
        was[live] = inside
        solid, void = t[found] - step, t[found] - 2 * step
        for _ in range(40):
            middle = (solid + void) / 2
            there = field(origin[found] + way[found] * middle[:, None]) <= 0
            solid, void = np.where(there, middle, solid), np.where(there, void, middle)
        entry[found] = np.maximum(solid, start[found])
    return entry.reshape(size[1], size[0])


def agree(
    made: Marcher, camera: Camera, box: Box, field: Field, step: float, off: float = 0.0, grazing: float = 0.0
) -> None:
    """No ray passes through what the dense rays found, and what is met is the surface.

    `off` is how far float32 may misplace a point, in mm; a share of `grazing` of the rays may meet nothing so near.
    """
    found, dense = made.distances().astype(np.float64), cast(field, camera, box, step)
    hit = np.isfinite(dense)
    assert hit.mean() > 0.03
    slack = 2 * made.finest + off
    holes = hit & ~(found <= dense + slack)
    assert not holes.any(), f"{holes.sum()} of {hit.sum()} rays pass through solid"
    origin, way = camera.rays(SIZE)
    met = np.isfinite(found)
    there = np.concatenate([[0.0], np.geomspace(0.1, 4, 9)]) * slack - off
    near = np.stack([field(origin[met] + way[met] * (found[met] + s)[:, None]) for s in there])
    stray = near.min(axis=0) > 0
    assert stray.mean() <= grazing, f"{stray.sum()} of {len(stray)} rays stop where there is nothing"


def norm(p: Points) -> Points:
    return np.linalg.norm(p, axis=-1)


def raw_gyroid(p: Points, w: Points | float) -> Points:
    x, y, z = (math.tau * p / np.asarray(w)[..., None]).T
    value: Points = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return value


def cylinder(p: Points, r: float, h: float) -> Points:
    return np.maximum(np.hypot(p[:, 0], p[:, 1]) - r, np.abs(p[:, 2]) - h / 2)


def chirp(p: Points) -> Points:
    w = 3 + 9 * np.clip(np.hypot(p[:, 0], p[:, 1]) / 15, 0, 1)
    return np.maximum(np.abs(raw_gyroid(p, w)) - 0.2, cylinder(p, 15, 20))


def twisted(p: Points) -> Points:
    x, y, z = p.T
    turn = 0.3 * z
    q = np.stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z], axis=1)
    return np.maximum(np.abs(raw_gyroid(q, 12.0)) - 0.2, cylinder(p, 15, 30))


def many(p: Points) -> Points:
    i = np.arange(60)
    centres = np.stack([12 * np.cos(0.7 * i), 12 * np.sin(0.7 * i), 0.5 * i - 15], axis=1)
    return (norm(p[:, None] - centres) - 1.2).min(axis=1)


def pole(p: Points) -> Points:
    with np.errstate(divide="ignore"):
        return np.maximum(1 / (norm(p) - 6) - 0.2, norm(p) - 10)


FIELDS: dict[str, tuple[str, Field]] = {
    "wavelength that changes": ("gyroid(3 + 9 * ramp(hypot(x, y), 0, 15)) |> shell(0.4) & cylinder(15, 20)", chirp),
    "fast twist": ("gyroid(12) |> shell(0.4) |> twist(0.3) & cylinder(15, 30)", twisted),
    "many pieces": (
        "union([for i in range(60): translate(sphere(1.2), [12 * cos(0.7 * i), 12 * sin(0.7 * i), 0.5 * i - 15])])",
        many,
    ),
    "pole": ("(1 / (length(p) - 6) - 0.2) & sphere(10)", pole),
    "steep": (
        "100 * (gyroid(12) |> shell(0.25)) & cylinder(15, 30)",
        lambda p: np.maximum(100 * (np.abs(raw_gyroid(p, 12.0)) - 0.125), cylinder(p, 15, 30)),
    ),
    "flat": (
        "(gyroid(12) |> shell(0.25)) / 100 & cylinder(15, 30)",
        lambda p: np.maximum((np.abs(raw_gyroid(p, 12.0)) - 0.125) / 100, cylinder(p, 15, 30)),
    ),
}


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
def test_rays_meet_what_dense_rays_meet(name: str) -> None:
    text, field = FIELDS[name]
    made, camera, box = shot(text, projection="orthographic" if name == "fast twist" else "perspective")
    agree(made, camera, box, field, made.nearest / 2, off=1e-4)


@pytest.mark.parametrize("by", ["", "100 * ", "0.01 * "])
@pytest.mark.usefixtures("gpu")
def test_a_thin_wall_of_a_large_part_has_no_hole(by: str) -> None:
    """0.2 mm of 150 mm, in a picture whose pixels are 6 mm; and whatever the field is multiplied by."""
    made, camera, _ = shot(f"{by}(sphere(75) |> shell(0.2))")
    distance = made.distances().astype(np.float64)
    origin, way = camera.rays(SIZE)
    middle = np.einsum("ijk,ijk->ij", origin, way)
    under = middle**2 - np.einsum("ijk,ijk->ij", origin, origin) + 75.1**2
    clear = np.abs(under) > 30  # grazing rays, within 0.2 mm of the rim, are ill-conditioned
    assert np.array_equal(np.isfinite(distance)[clear], (under > 0)[clear])
    hit = clear & (under > 0)
    assert np.abs(distance[hit] - (-middle - np.sqrt(np.maximum(under, 0)))[hit]).max() < 3 * made.finest


@pytest.mark.parametrize("at", [1e3, 6e4])
@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
def test_a_part_far_from_the_origin(at: float) -> None:
    """float32 rounds places to `at` / 2^23: that much is off, and no more."""
    far = np.array([at, -at / 2, at / 3])
    text = f"translate(gyroid(12) |> shell(0.5) & sphere(15), [{far[0]}, {far[1]}, {far[2]}])"
    made, camera, box = shot(text)
    off = 8 * at * 2.0**-23
    assert off < 0.06
    agree(made, camera, box, lambda p: np.maximum(np.abs(raw_gyroid(p - far, 12.0)) - 0.25, norm(p - far) - 15),
          made.nearest / 2, off, grazing=0.01)  # fmt: skip


@pytest.mark.usefixtures("gpu")
def test_a_part_that_is_cut_where_it_is_solid_is_its_faces() -> None:
    made, camera, box = shot("sphere(50)", bounds=(-10, -10, -10, 10, 10, 10))
    agree(made, camera, box, lambda p: np.abs(p).max(axis=1) - 10, 0.1, off=1e-3)


@pytest.mark.usefixtures("gpu")
def test_a_sheet_seen_from_its_edge_is_as_thick_as_it_is() -> None:
    size = (64, 256)
    made, camera, box = shot("box([40, 40, 0.2])", "front", "orthographic", zoom=100, size=size)
    pixel = camera.pixel(size, box)
    rows = np.isfinite(made.distances()).sum(axis=0) * pixel
    assert rows == pytest.approx(0.2, abs=2 * pixel)
    assert pixel < 0.01


# Cuts

QUARTER = (HalfSpace(1, True, 0.0), HalfSpace(2, False, 0.0))
EIGHTH = (HalfSpace(0, False, -2.0), *QUARTER)
SLAB = (HalfSpace(2, False, -3.0), HalfSpace(2, True, 4.0))


def less(p: Points, *cuts: Cut) -> Points:
    """The ball of radius 20 in a lattice, with cuts taken away by Boolean difference."""
    value = np.maximum(raw_gyroid(p, 14.0), norm(p) - 20)
    for cut in cuts:
        sides = [(p[:, h.axis] - h.at) * (1 if h.below else -1) for h in cut]
        value = np.maximum(value, -np.max(sides, axis=0))
    return value


CUTS = [(QUARTER,), (EIGHTH,), (SLAB,), (QUARTER, (HalfSpace(0, True, 0.0),)), (EIGHTH, SLAB)]


@pytest.mark.parametrize("cuts", CUTS)
@pytest.mark.parametrize("view", ["iso", "front"])
@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
def test_what_is_left_of_a_cut_part_is_a_difference(cuts: tuple[Cut, ...], view: str) -> None:
    made, camera, box = shot("gyroid(14) & sphere(20)", view, cuts=cuts)
    agree(made, camera, box, lambda p: less(p, *cuts), made.nearest / 2, off=1e-3)


@pytest.mark.usefixtures("gpu")
def test_both_faces_of_a_quarter_are_sections() -> None:
    """Seen from the front, the upper half of a ball without its front quarter is half a disc, in one colour."""
    wishes = Wishes((200, 200), VIEWS["front"], "orthographic", samples=1, cuts=(QUARTER,))
    ball = porelang.compile("sphere(20)").design()
    picture = render_output(ball, None, wishes)
    red, _, blue, _ = np.moveaxis(picture.pixels.astype(int), 2, 0)
    section = red - blue > 60  # warm, where the material is nearly white
    rim = 2 * math.pi * 20 * picture.pixel
    assert section.sum() * picture.pixel**2 == pytest.approx(math.pi * 400 / 2, abs=0.1 * rim)
    assert section[:100].sum() >= section.sum() - 200  # but for a row at the edge: it is above the middle
    top = render_output(ball, None, replace(wishes, view=VIEWS["top"]))
    red, _, blue, _ = np.moveaxis(top.pixels.astype(int), 2, 0)
    assert (red - blue > 60).sum() * top.pixel**2 == pytest.approx(math.pi * 400 / 2, abs=0.1 * rim)


def test_a_cut_that_takes_a_side_makes_the_box_smaller() -> None:
    box = whole(Box((-1.0, -2.0, -3.0), (1.0, 2.0, 3.0)))
    half = take_away(box, [(HalfSpace(0, True, 0.25),)])
    assert half.box == Box((0.25, -2.0, -3.0), (1.0, 2.0, 3.0))
    assert half.cut_lo == (True, False, False)
    assert not half.notches
    # what is left of z above 0 is behind y = 0 already
    both = take_away(box, [QUARTER, (HalfSpace(1, True, 0.0),)])
    assert both.box == Box((-1.0, 0.0, -3.0), (1.0, 2.0, 3.0))
    assert not both.notches
    # beyond the part nothing is taken
    assert take_away(box, [(HalfSpace(0, True, -5.0),), (HalfSpace(1, True, 0.0), HalfSpace(2, False, 9.0))]) == box
    with pytest.raises(porelang.PoreError, match="E107"):
        take_away(box, [(HalfSpace(0, True, 0.0),), (HalfSpace(0, False, 0.0),)])
    with pytest.raises(porelang.PoreError, match="8 are the most"):
        take_away(box, [(*QUARTER, HalfSpace(0, True, -0.9 + i / 10)) for i in range(9)])


@pytest.mark.usefixtures("gpu")
def test_glass_is_every_surface_on_the_way() -> None:
    """Through the middle of a hollow ball: in at 21 mm and out at 19 mm of its centre, and the same behind it."""
    size = (41, 41)
    made, camera, _ = shot("sphere(20) |> shell(2)", "front", size=size)
    far = float(np.linalg.norm(camera.eye))
    behind, found = None, []
    for layer in range(5):
        behind = made.distances(behind=behind, leaving=layer % 2 == 1)
        found.append(float(behind[20, 20]))
    assert found[:4] == pytest.approx([far - 21, far - 19, far + 19, far + 21], abs=2 * made.finest)
    assert math.isinf(found[4])
