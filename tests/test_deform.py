"""Deformed parts in pictures: lengths and places against closed forms, colours against the field; what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

import porelang
from porelang import values
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.picture import Picture
from porelang.render.camera import VIEWS, look
from porelang.render.painting import AMBIENT
from porelang.render.raster import project, seen
from porelang.render.scale import Ramp, scale_colours
from porelang.render.shade import lit, open_sky

#: Stretched by 1 % of its 40 mm along z.
BAR = "let bar = box([10mm, 10mm, 40mm])\nlet s = compress(bar, force=-1kN, axis=z, E=1GPa, nu=0.25, size=5mm)\nbar"
PLAIN: dict[str, Any] = {
    "view": "front", "projection": "orthographic", "size": (240, 240), "samples": 1, "background": "transparent",
}  # fmt: skip


def extents(made: Picture) -> tuple[float, float]:
    """How wide and how high what is seen is, in mm."""
    label, _ = ndimage.label(made.pixels[..., 3] > 0, np.ones((3, 3)))  # what is written on it is apart from the part
    there = label == 1 + np.argmax(np.bincount(label.ravel())[1:])
    return tuple((np.ptp(np.flatnonzero(there.any(axis=axis))) + 1) * made.pixel for axis in (0, 1))  # type: ignore[return-value]  # two of them


# ---- where it is


@pytest.mark.parametrize("factor", [1, 25])
def test_a_stretched_bar_is_longer_and_thinner_by_the_factor(factor: int) -> None:
    made = porelang.compile(BAR).render(**PLAIN, deform=f"{factor} s", frame="bounds")
    wide, high = extents(made)
    assert high == pytest.approx(40 * (1 + 0.01 * factor), abs=1.5 * made.pixel)
    assert wide == pytest.approx(10 * (1 - 0.0025 * factor), abs=1.5 * made.pixel)
    assert made.deformed.factor == factor
    assert made.deformed.greatest == pytest.approx(math.hypot(0.4, 0.0125, 0.0125), rel=0.02)


def test_unless_told_otherwise_the_greatest_displacement_is_a_tenth_of_the_part() -> None:
    made = porelang.compile(BAR).render(**PLAIN, deform=True)
    assert made.deformed.what == "s"
    assert 0.095 * 40 <= made.deformed.factor * made.deformed.greatest <= 0.1 * 40


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
def test_the_tip_of_a_cantilever_is_where_beam_theory_has_it(projection: Any) -> None:
    """Timoshenko's beam with Cowper's coefficient (The shear coefficient in Timoshenko's beam theory, 1966)."""
    long, wide, high, young, nu, force, factor = 60.0, 8.0, 6.0, 2000.0, 0.3, 20.0, 3.0
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    tip = force * long**3 / (3 * young * wide * high**3 / 12)
    tip += force * long / (kappa * young / (2 * (1 + nu)) * wide * high)
    text = (f"let beam = box([{long:g}mm, {wide:g}mm, {high:g}mm])\nlet s = bend(beam, {force:g}N, axis=x, toward=-z, "
            f'supports="cantilever", E={young:g}MPa, nu={nu}, size=3mm)\nbeam')  # fmt: skip
    made = porelang.compile(text).render(**(PLAIN | {"projection": projection, "size": (400, 300)}), deform=factor)
    corner = np.array([[long / 2, -wide / 2, -high / 2 - factor * tip]])  # its lower edge; the end turns by little
    there = made.pixels[..., 3] > 0  # what is written on it stands above
    lowest = np.flatnonzero(there.any(axis=1)).max() + 1
    expected = project(corner, made.camera, (400, 300))[0, 1]
    # the section at the end is turned about the middle, which takes the lower edge inward, not down
    assert abs(lowest - expected) < 1.5 + 0.02 * factor * tip / made.pixel


def test_a_lattice_is_moved_by_a_study_of_the_solid_whatever_that_says_of_its_outside() -> None:
    lattice = BAR.removesuffix("bar").replace("size=5mm", "size=5mm, outside=0") + "gyroid(5mm) |> shell(0.9) & bar"
    made = porelang.compile(lattice).render(**PLAIN, deform="20 s.displacement", ghost=True)
    other = porelang.compile(lattice.replace(", outside=0", "")).render(**PLAIN, deform=20, ghost=True)
    assert np.array_equal(made.pixels, other.pixels)
    assert extents(made)[1] == pytest.approx(48, abs=2 * made.pixel)
    assert 0.1 < made.covered < 0.3


def test_an_expression_of_displacements_can_be_drawn() -> None:
    made = porelang.compile(BAR).render(**PLAIN, deform="10 * s.displacement")
    other = porelang.compile(BAR + " @ p").render(**PLAIN, deform="s.displacement + [0mm, 0mm, z / 100]")
    assert made.deformed.factor == 10
    assert other.deformed.greatest == pytest.approx(0.6, rel=0.03)


def test_cuts_open_the_part_before_it_moves() -> None:
    made = porelang.compile(BAR).render(**PLAIN, deform=25, cut="z>0")
    assert extents(made)[1] == pytest.approx(20 * 1.25, abs=1.5 * made.pixel)
    from_above = porelang.compile(BAR).render(**(PLAIN | {"view": "top"}), deform=25, cut="z>0")
    red, green, _ = from_above.array[120, 120].astype(float)
    assert red > 1.5 * green  # the face of the cut


# ---- its colours


def test_colours_are_those_of_the_field_at_the_place_that_has_moved_there() -> None:
    """Of a bar that hangs, with nu = 0: the stress is g (l - z), and z moves by g (l z - z^2 / 2) / E; g in N/mm3."""
    load, long, young, factor = 9.80665e-3, 30.0, 100.0, 60.0
    text = ("let bar = box([6mm, 6mm, 30mm])\nlet s = study(bar, z < -14.9mm, weight([0, 0, 1000]), E=100MPa, nu=0, "
            "density=1, size=3mm)\nbar")  # fmt: skip
    size = (200, 300)
    program = porelang.compile(text)
    asked = PLAIN | {"size": size}
    made = program.render(**asked, deform=factor, field="s.von_mises", range=(0, load * long))
    # light falls evenly on a flat face that is seen from in front, but for where it is dark beside it
    shade = AMBIENT + (1 - AMBIENT) * lit(np.array([[0.0, 0, -1]]), np.ones(1), np.zeros(1, np.bool_), bare=True)
    for z in (4.0, 11.0, 19.0, 26.0):
        moved = z + factor * load * (long * z - z**2 / 2) / young
        x, y = project(np.array([[0.0, -3, moved - 15]]), made.camera, size)[0, :2]
        expected = scale_colours(np.array([load * (long - z)]), Ramp(0, load * long)) * shade
        np.testing.assert_allclose(made.array[int(y), int(x)] / 255, expected[0], atol=0.03)


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
def test_the_place_on_a_triangle_lies_on_the_ray(projection: Any) -> None:
    random = np.random.default_rng(3)
    vertices = random.normal(size=(60, 3)) * 5
    faces = np.arange(60, dtype=np.int32).reshape(-1, 3)
    size = (150, 100)
    whole = porelang.compile("sphere(12)").bounds()
    camera = look(whole, VIEWS["iso"], size, projection)
    found = seen(vertices, faces, camera, size)
    origin, way = camera.rays(size)
    nearest = np.full(size[::-1], np.inf)
    for a, b, c in vertices[faces]:  # by the plane of each, and the signs of three volumes
        normal = np.cross(b - a, c - a)
        t = ((a - origin) @ normal) / (way @ normal)
        place = origin + way * t[..., None]
        inside = np.ones(t.shape, np.bool_)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.cross(q - p, place - p) @ normal >= 0
        nearest = np.where(inside & (t < nearest), t, nearest)
    same = np.isfinite(nearest) == np.isfinite(found.distance)
    assert same.mean() > 0.999  # rounding, on an edge
    both = np.isfinite(nearest) & np.isfinite(found.distance)
    assert both.mean() > 0.05
    np.testing.assert_allclose(found.distance[both], nearest[both], rtol=1e-5)
    for rows, hit, one, weights in found.bands():
        place = np.einsum("kc,kcd->kd", weights, vertices[faces[one]])
        distance = found.distance[rows][hit][:, None].astype(np.float64)
        np.testing.assert_allclose(place, origin[rows][hit] + way[rows][hit] * distance, atol=1e-4)


def test_a_plane_sees_all_of_its_sky_and_the_foot_of_a_wall_less() -> None:
    size = (120, 120)
    camera = look(porelang.compile("cube(40)").bounds(), VIEWS["top"], size, "orthographic")
    flat = np.full(size, 50.0, np.float32)
    up = np.zeros((*size, 3), np.float32)
    up[..., 2] = -1
    assert open_sky(flat, up, camera, 5.0).min() == 1
    step = flat.copy()
    step[:, 60:] -= 3.0  # a step at the right
    sky = open_sky(step, up, camera, 5.0)[:, :60]
    assert sky[60, 59] < 0.85
    assert (sky[10:-10, :30] == 1).all()


def test_planes_show_stress_where_the_part_is_and_nowhere_else() -> None:
    """Of a bar that hangs: from 0 at its end on; what is behind another plane, beside the part, is seen."""
    text = ("let bar = box([6mm, 6mm, 30mm])\nlet s = study(bar, z < -14.9mm, weight([0, 0, 1000]), E=100MPa, nu=0, "
            "density=1, size=3mm)\nbar")  # fmt: skip
    made = porelang.compile(text).render(
        **PLAIN | {"view": (-80, 0), "size": (100, 300)}, field="s.von_mises", slice=["y=-2", "x=0"], solid="none"
    )
    assert made.scale.ends == pytest.approx((0, 0.2942), abs=3e-4)
    assert extents(made)[1] == pytest.approx(30, abs=2 * made.pixel)
    columns = np.flatnonzero((made.pixels[..., 3] > 0).any(axis=0))
    assert (np.diff(columns) == 1).all()
    assert (columns[-1] - columns[0]) * made.pixel == pytest.approx(6 * math.cos(math.radians(10)), abs=0.5)


# ---- the command, and what it refuses


def test_the_command_says_by_how_much(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "a.pore", tmp_path / "a.png"
    file.write_text(BAR)
    words = ["render", str(file), "-o", str(out), "--size", "300x200", "--samples", "1"]
    assert main([*words, "--deform", "--field", "s.stress.zz / 2MPa", "--legend", "--json", "-q"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["deform"]["of"] == "s"
    assert told["deform"]["factor"] == pytest.approx(9.9, abs=0.11)
    assert told["slice_range"] == pytest.approx([4.75, 5.25])
    with Image.open(out) as image:
        pixels: NDArray[Any] = np.asarray(image.convert("L"))
    assert (pixels[:20, 100:230] < 128).any()  # it is written on the picture
    assert main([*words, "--deform", "7.5"]) == 0
    assert "displacements x 7.5, of 0.4" in capsys.readouterr().out


TWO = BAR.replace("\nbar", "\nlet t = compress(bar, force=1kN, axis=z, E=1GPa, nu=0.25, size=5mm)\nbar")


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        (BAR, ["--deform", "0"], "a number above 0"),
        (BAR, ["--deform", "-5"], "a number above 0"),
        (BAR, ["--deform", "nan s"], "a number above 0"),
        (BAR, ["--deform", "inf"], "a number above 0"),
        (BAR, ["--deform", "1e999 s"], "a number above 0"),
        (BAR, ["--deform", "s.von_mises"], "`s.von_mises` is no displacement: it is no vector, a stress"),
        (BAR, ["--deform", "s.direction1"], "a vector, a ratio"),
        (BAR, ["--deform", "q"], "no study called `q`"),
        (BAR, ["--deform", "s -3"], "a number above 0"),
        (BAR, ["--deform", "s.displacment"], "displacement"),
        (BAR, ["--deform", "[0mm, 0mm, 0mm]"], "moves nothing"),
        (BAR, ["--deform", "[0mm, 0mm, log(z) * 1mm]"], "are no numbers at ("),
        ("sphere(5)", ["--deform"], "has no study"),
        (TWO, ["--deform"], "several studies: `s`, `t`"),
        (TWO, ["--deform", "110 t"], "inside out"),
        (BAR, ["--ghost"], "add --deform"),
        (BAR, ["--deform", "--slice", "x=0"], "planes, which do not deform"),
        (BAR, ["--deform", "--solid", "glass"], "not drawn as glass"),
        (f"out a = sphere(1)\n{BAR}", ["--deform", "--bodies"], "drawn alone"),
        (BAR, ["--field", "s"], "as in `--field s.von_mises`"),
        (BAR, ["--field", "s.displacement"], "length(s.displacement)"),
        (BAR, ["--field", "s.stress"], "`s.stress.xx`, `s.von_mises`"),
        (BAR, ["--field", "s.stiffness"], "is one number, and no field"),
        (BAR, ["--field", "s.von_mises", "--deform", "s.stress"], "several numbers in each place"),
        (BAR, ["--field", "s.von_misses"], "von_mises"),
        (BAR, ["--field", "s.von_mises /"], "--field:1:"),
        (BAR, ["--field", "s.von_mises + 1mm"], "--field:1:1"),
        (BAR, ["--field", "s.von_mises)"], "--field:1:"),
        (BAR, ["--field", "z < 0mm"], "is a condition"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_a_way_out(
    text: str, words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "a.pore", tmp_path / "a.png"
    file.write_text(text)
    assert main(["render", str(file), "-o", str(out), "--size", "120x90", "--samples", "1", *words]) in (1, 2)
    told = capsys.readouterr().err
    assert said in told
    assert "error[E" in told
    assert "hint" in told or "value expected" in told
    assert not out.exists()


def test_a_compression_is_magnified_up_to_where_nothing_is_left_and_no_more() -> None:
    """1 % of compression without strain across: at 100 times as much the bar is flat."""
    text = BAR.replace("force=-1kN", "force=1kN").replace("nu=0.25", "nu=0")
    program = porelang.compile(text)
    assert extents(program.render(**PLAIN, deform=90, frame="bounds"))[1] == pytest.approx(4, abs=0.3)
    with pytest.raises(PoreError, match=r"take 99 or less|take 1e\+02 or less") as caught:
        program.render(**PLAIN, deform=101)
    assert caught.value.diagnostics[0].code == "E179"


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("s", (None, "s")), ("auto", (None, "")), ("auto s", (None, "s")), ("12.5", (12.5, "")),
        ("1e2 s", (100.0, "s")),
        ("100 * s.displacement", (100.0, "s.displacement")), ("3x s", (3.0, "s")), ("s 100", (100.0, "s")),
        ("s.displacement * 100", (100.0, "s.displacement")), ("s x 2.5", (2.5, "s")), ("s2", (None, "s2")),
        ("auto_s", (None, "auto_s")),
        ("2 * s.displacement + t.displacement", (None, "2 * s.displacement + t.displacement")),
    ],
)  # fmt: skip
def test_how_an_option_is_read(text: str, read: tuple[float | None, str]) -> None:
    assert values.deform(text) == read


# ---- what was not studied


@pytest.mark.parametrize("deform", [True, False])
def test_what_was_not_studied_is_grey_and_told(deform: bool, request: pytest.FixtureRequest) -> None:
    """A block beside the bar that is solved, as large in the picture: it has no stress, and no say in the colours."""
    if not deform:
        request.getfixturevalue("gpu")
    both = BAR.replace("compress(bar", 'compress(bar, platens="bonded"').replace(
        "\nbar", "\nbar | bar @ [x - 30, y, z]"
    )
    wishes = PLAIN | {"field": "s.von_mises", "deform": deform}
    with pytest.warns(porelang.PoreWarning, match=r"W285.*(50|51|49)% of what is drawn lies beyond") as told:
        made = porelang.compile(both).render(**wishes)
    assert [w.message.diagnostic.code for w in told] == ["W285"]
    assert ("moved with the nearest place" in str(told[0].message)) == deform
    there = made.pixels[..., 3] > 0
    there[:30] = False  # what is written on it
    middle = int(np.flatnonzero(there.any(axis=0)).mean())
    colour = np.ptp(made.pixels[..., :3].astype(int), axis=-1)
    assert colour[:, middle:][there[:, middle:]].max() < 12
    assert np.median(colour[:, :middle][there[:, :middle]]) > 40
    alone = porelang.compile(both.replace(" | bar @ [x - 30, y, z]", "")).render(**wishes)
    assert made.scale.ends == pytest.approx(alone.scale.ends, rel=0.02)


@pytest.mark.usefixtures("gpu")
def test_what_a_study_says_is_beyond_is_drawn() -> None:
    text = BAR.replace("size=5mm", "size=5mm, outside=0").replace("\nbar", "\nbar | bar @ [x - 30, y, z]")
    made = porelang.compile(text).render(**PLAIN, field="s.von_mises")
    assert not made.told


def test_of_several_studies_the_one_whose_field_is_drawn_deforms_the_part() -> None:
    text = BAR.replace("\nbar", "\nlet t = compress(bar, force=-1kN, axis=x, E=1GPa, nu=0.25, size=5mm)\nbar")
    program = porelang.compile(text)
    for name in ("s", "t"):
        assert program.render(**PLAIN, field=f"{name}.von_mises", deform=True).deformed.what == name
    with pytest.raises(PoreError, match=r"E100.*several studies"):
        program.render(**PLAIN, deform=True)
