"""Pictures: silhouettes and depths against closed forms and dense sampling, cuts, planes, and the command."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import porelang
from porelang.analysis.box import Box
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.gpu.fields import gpu
from porelang.program import Design
from porelang.progress import watching
from porelang.render import Camera, Picture, Wishes, look, render_output
from porelang.render.camera import VIEWS
from porelang.render.cells import SOLID, STEEP, VOID, bound_cells
from porelang.render.cuts import HalfSpace, take_away, whole
from porelang.render.march import Marcher, Scene
from porelang.render.marks import AXES, axes_mark, lay, scale_bar_mark, told
from porelang.render.painting import BODIES
from porelang.render.planes import Plane
from porelang.render.scale import COLOURS, VIRIDIS, Ramp, Scale

ROOT = Path(__file__).parent.parent
SPECIMEN = str(ROOT / "examples" / "specimen.pore")


def marcher(text: str, size: tuple[int, int], view: str = "iso", projection: Any = "perspective", **settings: float):
    """The shader of a program's part, with the camera, the field in float64 and the box."""
    program = porelang.compile(text)
    design = program.design(**settings)
    part, found = design.of(), design.bounds()
    more = 1e-3 * max(found.size)
    box = Box(tuple(v - more for v in found.lo), tuple(v + more for v in found.hi))
    camera = look(box, VIEWS[view], size, projection)
    scene = Scene(part, program.ranges, bound_cells(part, box), whole(box))
    return Marcher(scene, camera, size, gpu()), camera, design.field(), box


def entries(
    camera: Camera, size: tuple[int, int], box: Box, field: Any, step: float, least: int = 1
) -> NDArray[np.float64]:
    """By brute force: where each ray enters solid, from samples `step` mm apart, `least` of them in a row in solid."""
    origin, way = (np.reshape(v, (-1, 3)) for v in camera.rays(size))
    with np.errstate(all="ignore"):
        a, b = (np.array(box.lo) - origin) / way, (np.array(box.hi) - origin) / way
    start, end = np.fmin(a, b).max(axis=1), np.fmax(a, b).min(axis=1)
    entry = np.full(len(origin), np.inf)
    run = np.zeros(len(origin), np.intp)
    for k in range(math.ceil(float((end - start).max(initial=0)) / step) + 1):
        t = start + k * step
        live = np.flatnonzero((t <= end) & np.isinf(entry))
        if not len(live):
            break
        inside = field(origin[live] + way[live] * t[live, None]) <= 0
        run[live] = np.where(inside, run[live] + 1, 0)
        enough = live[run[live] == least]
        entry[enough] = t[enough] - (least - 1) * step
    return entry.reshape(size[1], size[0])


def alpha_area(picture: Picture) -> float:
    return float((picture.pixels[..., 3] / 255).sum()) * picture.pixel**2


@pytest.mark.usefixtures("gpu")
def test_silhouette_of_a_sphere_is_a_disc() -> None:
    r = 20.0
    design = porelang.compile(f"sphere({r})").design()
    picture = render_output(design, None, Wishes((240, 180), projection="orthographic", samples=2, transparent=True))
    # each sample on the rim is off by at most itself; they average: a tenth of the rim's pixels is generous
    assert alpha_area(picture) == pytest.approx(math.pi * r * r, abs=0.1 * 2 * math.pi * r * picture.pixel)


@pytest.mark.usefixtures("gpu")
def test_size_of_a_sphere_in_perspective() -> None:
    """The silhouette of a sphere is a circle: its tangent cone has sine r / d."""
    size = (201, 201)
    made, camera, _, _ = marcher("sphere(20)", size, "front")
    distance = made.distances()
    far = float(np.linalg.norm(camera.eye))
    radius = math.tan(math.asin(20 / far)) / camera.zoom * size[1] / 2  # in pixels
    seen = np.isfinite(distance)
    assert abs(seen.sum() - math.pi * radius**2) < 0.1 * 2 * math.pi * radius
    assert distance[100, 100] == pytest.approx(far - 20, abs=made.nearest)


@pytest.mark.usefixtures("gpu")
def test_depths_of_a_sphere_are_exact() -> None:
    size = (160, 120)
    made, camera, _, _ = marcher("translate(sphere(20), [5, -3, 2])", size)
    distance = made.distances().astype(np.float64)
    origin, way = camera.rays(size)
    to = origin - np.array([5, -3, 2])
    b = np.einsum("ijk,ijk->ij", to, way)
    under = b * b - (np.einsum("ijk,ijk->ij", to, to) - 400)
    clear = np.abs(np.sqrt(np.abs(under))) > 1.0  # grazing rays are ill-conditioned
    assert np.array_equal(np.isfinite(distance)[clear], (under > 0)[clear])
    both = clear & (under > 0)
    exact = -b[both] - np.sqrt(under[both])
    assert np.abs(distance[both] - exact).max() < made.nearest


@pytest.mark.parametrize(
    ("text", "projection"),
    [
        ("gyroid(12) |> shell(0.25) & cylinder(15, 30)", "perspective"),
        ("gyroid(12) |> shell(0.25) & cylinder(15, 30)", "orthographic"),
        ("neovius(10) |> shell(0.6) & sphere(14)", "perspective"),
        ("iwp(gyroid(40) + 12) & box([20, 20, 20])", "perspective"),
        ("sphere(15) |> shell(0.2) & x", "orthographic"),
    ],
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.usefixtures("gpu")
def test_no_holes_against_dense_sampling(text: str, projection: str) -> None:
    """Every ray that dense sampling finds in solid, for longer than the shortest step, meets it no later.

    And what is met is solid.
    """
    size = (72, 54)
    made, camera, field, box = marcher(text, size, "iso", projection)
    step = made.nearest / 2
    distance = made.distances().astype(np.float64)
    dense = entries(camera, size, box, field, step, least=4)
    assert np.isfinite(dense).mean() > 0.05
    hit = np.isfinite(dense)
    slack = made.nearest + step
    holes = hit & ~(distance <= dense + slack)
    assert not holes.any(), f"{holes.sum()} of {hit.sum()} rays pass through the solid"
    # what was met is the surface: just behind it there is solid, up to what float32 rounds
    origin, way = camera.rays(size)
    met = np.isfinite(distance)
    t = distance[met]
    just = np.stack([field(origin[met] + way[met] * (t + d)[:, None]) for d in (0, 0.02 * made.nearest, made.nearest)])
    assert (just.min(axis=0) < 1e-4).all()


@pytest.mark.usefixtures("gpu")
def test_where_a_field_may_jump_only_what_is_thinner_than_a_sample_is_missed() -> None:
    """Along the seam of `polar` no step is proven."""
    size = (72, 54)
    text = "(gyroid(14) |> polar(5 * 14) |> shell(0.5)) & cylinder(16, 12)"
    made, camera, field, box = marcher(text, size)
    assert made.cells.max() >= STEEP / 2
    step, sample = made.nearest / 2, camera.pixel(size, box)
    dense = entries(camera, size, box, field, step, least=2 + math.ceil(1.2 * sample / step))
    hit = np.isfinite(dense)
    assert hit.mean() > 0.05
    assert (made.distances()[hit] <= dense[hit] + 1.2 * sample + step).all()


@pytest.mark.usefixtures("gpu")
def test_thin_and_steep_shell_has_no_hole() -> None:
    """A field a thousand times as steep as a distance, and a wall three samples thick."""
    size = (64, 64)
    made, camera, field, box = marcher("1000 * (sphere(20) |> shell(0.3))", size, "front")
    dense = entries(camera, size, box, field, 0.05)
    assert np.isfinite(dense).any()
    assert (made.distances()[np.isfinite(dense)] <= dense[np.isfinite(dense)] + made.nearest + 0.05).all()


@pytest.mark.usefixtures("gpu")
def test_a_field_that_jumps_is_drawn() -> None:
    """Slabs made with floor: the field is -1 or 1 and passes zero nowhere."""
    size = (90, 60)
    made, camera, field, box = marcher("(if mod(floor(z / 3), 2) < 1 then -1 else 1) & cube(20)", size, "front")
    assert made.cells.max() >= STEEP / 2
    dense = entries(camera, size, box, field, made.nearest)
    distance = made.distances()
    hit = np.isfinite(dense)
    assert np.array_equal(np.isfinite(distance), hit)
    assert np.abs(distance[hit] - dense[hit]).max() < 3 * made.nearest


def test_cells_hold_what_they_say() -> None:
    program = porelang.compile("gyroid(12) |> shell(0.4) & cylinder(15, 30)")
    box = program.bounds()
    cells = bound_cells(program.design().of(), box)
    rng = np.random.default_rng(5)
    points = rng.uniform(box.lo, box.hi, (20000, 3))
    which = tuple(np.floor((points - box.lo) / box.size * cells.counts).astype(int).T)
    held = cells.values[which]
    field = program.field()
    values = field(points)
    assert (values[held == VOID] > 0).all()
    assert (values[held == SOLID] < 0).all()
    eps = 1e-6
    slope = np.stack([(field(points + eps * e) - field(points - eps * e)) / (2 * eps) for e in np.eye(3)], axis=1)
    bounded = held > 0
    assert bounded.any()
    assert (np.linalg.norm(slope, axis=1)[bounded] <= held[bounded] * (1 + 1e-6) + 1e-6).all()
    # and they are of use: most bounds are within three times the steepest slope of a gyroid with this period
    assert np.median(held[bounded]) < 3 * math.sqrt(3) * math.tau / 12


@pytest.mark.usefixtures("gpu")
def test_a_param_changes_the_picture_without_compiling() -> None:
    program = porelang.compile("param r = 10 in 5..20\nsphere(r)")
    wishes = Wishes((80, 60), samples=1, projection="orthographic", transparent=True)
    bounds = (-21.0, -21.0, -21.0, 21.0, 21.0, 21.0)
    small = render_output(program.design(), None, wishes, bounds)
    compiled = gpu("person").compiled
    large = render_output(program.design(r=20), None, wishes, bounds)
    assert gpu("person").compiled == compiled
    assert alpha_area(large) == pytest.approx(4 * alpha_area(small), rel=0.05)


@pytest.mark.usefixtures("gpu")
def test_cut_takes_half_away_and_shows_its_face() -> None:
    design = porelang.compile("cube(20)").design()
    above = ((HalfSpace(2, False, 4.0),),)
    wishes = Wishes((120, 120), VIEWS["right"], "orthographic", samples=1, transparent=True, cuts=above)
    seen = render_output(design, None, wishes).pixels[..., 3] > 0
    pixel = render_output(design, None, wishes).pixel
    rows = np.flatnonzero(seen.any(axis=1))
    assert len(rows) * pixel == pytest.approx(14, abs=2 * pixel)  # from z = -10 to 4
    # seen from above the cut face is there, in its own flat colour
    top = Wishes((120, 120), VIEWS["top"], "orthographic", samples=1, cuts=above)
    face = render_output(design, None, top).pixels[40:80, 40:80, :3].reshape(-1, 3)
    assert (face == face[0]).all()
    assert face[0, 0] > face[0, 2] + 50  # warm, where the material is nearly white
    whole = render_output(design, None, Wishes((120, 120), VIEWS["top"], "orthographic", samples=1))
    assert abs(int(whole.pixels[60, 60, 0]) - int(whole.pixels[60, 60, 2])) < 50


@pytest.mark.usefixtures("gpu")
def test_cut_at_the_depth_asked_for() -> None:
    program = porelang.compile("cube(20)")
    part = program.design().of()
    whole_box = Box((-10.5,) * 3, (10.5,) * 3)
    shown = take_away(whole(whole_box), [(HalfSpace(1, True, -2.5),)])
    box = shown.box
    assert box == Box((-10.5, -2.5, -10.5), (10.5, 10.5, 10.5))
    camera = look(whole_box, VIEWS["front"], (40, 40), "orthographic")
    scene = Scene(part, {}, bound_cells(part, box), shown)
    made = Marcher(scene, camera, (40, 40), gpu())
    assert made.distances()[20, 20] == pytest.approx(-2.5 - camera.eye[1], abs=made.nearest)


def test_slice_has_the_colours_of_its_values() -> None:
    """The field of a ball is its distance: red inside, yellow near zero, blue outside, dark on the rim."""
    design = porelang.compile("out part = sphere(20)\nlet tilt = x / 40\nout other = tilt & cube(60)").design()
    bounds = (-40.0, -40.0, -40.0, 40.0, 40.0, 40.0)
    wishes = Wishes((200, 200), VIEWS["top"], "orthographic", samples=1, slices=(Plane(2, 0.0),), solid="none")
    picture = render_output(design, "part", wishes, bounds)
    assert picture.scale is not None
    assert picture.scale.low == pytest.approx(20)  # the centre is 20 deep, the corners lie farther out

    def colour(x: float, y: float, of: Picture = picture) -> NDArray[np.float64]:
        column, row = round(99.5 + x / of.pixel), round(99.5 - y / of.pixel)
        return of.pixels[row, column, :3].astype(np.float64)

    def expected(value: float) -> NDArray[np.float64]:
        """Red at the depth of the centre, yellow at zero, blue at what the corners of the plane attain."""
        ends = np.linspace(-20, 0, 5).tolist() + np.linspace(0, 42, 5).tolist()[1:]
        return np.array([np.interp(value, ends, 255 * channel) for channel in COLOURS.T])

    assert picture.scale.high == pytest.approx(42)  # 43.2 * sqrt(2) - 20 is 41.1
    for x, y in ((0, 0), (5, 5), (0, 39), (39, 39), (-30, 8)):
        assert np.abs(colour(x, y) - expected(math.hypot(x, y) - 20)).max() < 8
    assert np.abs(colour(17, 0) - colour(0, 17)).max() < 8
    assert colour(20, 0).max() < 120
    inside, outside = colour(15, 0), colour(35, 0)
    assert inside[0] > inside[2]
    assert outside[2] > outside[0]
    # another field on the same plane: a `let` by its name
    tilted = render_output(design, "part", replace(wishes, field="tilt"), bounds)
    assert np.abs(colour(-30, 20, tilted) - colour(-30, -20, tilted)).max() < 8
    assert colour(-35, 0, tilted)[0] > colour(-35, 0, tilted)[2] + 80
    assert colour(35, 0, tilted)[2] > colour(35, 0, tilted)[0] + 80


@pytest.mark.usefixtures("gpu")
def test_an_opaque_part_hides_the_plane_behind_it() -> None:
    design = porelang.compile("sphere(10)").design()
    plane = (Plane(1, 8.0),)
    view = Wishes((80, 80), VIEWS["front"], "orthographic", samples=1, slices=plane, solid="opaque")
    alone = render_output(design, None, Wishes((80, 80), VIEWS["front"], "orthographic", samples=1))
    both = render_output(design, None, view)
    assert abs(int(both.pixels[40, 40, 0]) - int(alone.pixels[40, 40, 0])) < 12
    glass = render_output(design, None, Wishes((80, 80), VIEWS["front"], "orthographic", samples=1, slices=plane,
                                                solid="glass"))  # fmt: skip
    assert int(glass.pixels[40, 40, 0]) - int(glass.pixels[40, 40, 2]) > 30  # the red of the plane shines through


@pytest.mark.usefixtures("gpu")
def test_tiles_make_one_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    from porelang.render import march

    made, *_ = marcher("gyroid(12) & cylinder(15, 30)", (100, 70))
    whole = made.distances()
    monkeypatch.setattr(march, "LARGEST", 32)
    told: list[int] = []
    with watching(lambda _, done, total: told.append(done)):
        assert np.array_equal(made.distances(), whole)
    assert len(told) == 4 * 3
    assert told[-1] == 100 * 70


@pytest.mark.usefixtures("gpu")
def test_the_shader_is_one_for_webgl_too() -> None:
    """The same scaffold as GLSL ES 3.00, which OpenGL 4.3 compiles too; in a process of its own, as drivers crash."""
    code = """
import moderngl, porelang
from porelang.backends.glsl import shader
program = porelang.compile("param w = 12 in 5..20\\ngyroid(w) |> twist(0.02) & cylinder(15, 30)")
text = shader(program.roots(), program.ranges, "webgl").text
context = moderngl.create_context(standalone=True, backend="egl", require=430)
made = context.program(vertex_shader="#version 300 es\\nvoid main() { gl_Position = vec4(0.0); }", fragment_shader=text)
print("cells" in made, "u" in made)
"""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)
    assert done.stdout.split() == ["True", "True"], done.stderr


def codes(error: pytest.ExceptionInfo[PoreError]) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def test_what_cannot_be_drawn_is_said() -> None:
    design: Design = porelang.compile("sphere(10)").design()
    with pytest.raises(PoreError) as far:
        render_output(design, None, Wishes((20, 20)), (20, 20, 20, 30, 30, 30))
    assert codes(far) == ["E111"]
    with pytest.raises(PoreError) as nothing:
        render_output(design, None, Wishes((20, 20), cuts=((HalfSpace(0, True, 11.0),),)))
    assert codes(nothing) == ["E107"]
    assert "x<11" in str(nothing.value)
    with pytest.raises(PoreError) as endless:
        render_output(porelang.compile("gyroid(10)").design(), None, Wishes((20, 20)))
    assert codes(endless) == ["E102"]
    with pytest.raises(PoreError) as unknown:
        render_output(design, None, Wishes((20, 20), slices=(Plane(0, 0.0),), field="prat"))
    assert codes(unknown) == ["E100"]
    assert "part" in str(unknown.value)
    with pytest.raises(PoreError) as large:
        render_output(design, None, Wishes((16000, 16000)))
    assert codes(large) == ["E114"]


@pytest.mark.usefixtures("gpu")
def test_a_program_too_long_for_a_shader_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    from porelang.render import march

    monkeypatch.setattr(march, "LONGEST", 5)
    with pytest.raises(PoreError) as error:
        render_output(porelang.compile("gyroid(9.5) & cylinder(15.5, 30)").design(), None, Wishes((20, 20)))
    assert codes(error) == ["E121"]


@pytest.mark.usefixtures("gpu")
def test_command_writes_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "a.png"
    line = ["render", SPECIMEN, "-o", str(target), "--size", "120x90", "--samples", "1", "--view", "-60,20", "--json"]
    assert main([*line, "--cut", "y<0", "--slice", "z=-1cm", "--background", "transparent"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["file"] == str(target)
    assert found["size"] == [120, 90]
    assert found["backend"] == "glsl"
    assert found["steps"] > 0
    assert found["seconds"] > 0
    assert 0.05 < found["covered"] < 0.9
    with Image.open(target) as image:
        assert image.size == (120, 90)
        assert image.mode == "RGBA"
        assert image.getpixel((0, 0))[3] == 0
    assert os.listdir(tmp_path) == ["a.png"]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["-o", "a.jpg"], 2, "E112"),
        (["-o", "nowhere/a.png"], 2, "E113"),
        (["-o", "a.png", "--cut", "y=0"], 2, "what to take away"),
        (["-o", "a.png", "--slice", "q=0"], 2, "write x=0"),
        (["-o", "a.png", "--slice", "x=3deg"], 2, "write x=0"),
        (["-o", "a.png", "--size", "800"], 2, "WIDTHxHEIGHT"),
        (["-o", "a.png", "--view", "above"], 2, "AZIMUTH,ELEVATION"),
        (["-o", "a.png", "--zoom", "0"], 2, "twice as large"),
        (["-o", "a.png", "--solid", "none"], 2, "--slice x=0"),
        (["-o", "a.png", "--field", "part"], 2, "is where `part` is zero"),
        (["-o", "a.png", "--field", "nothing"], 2, "no number called `nothing`"),
        (["-o", "a.png", "--field", "specimen", "--solid", "glass"], 2, "glass has no colours"),
        (["-o", "a.png", "--range", "-1..1"], 2, "--slice x=0"),
        (["-o", "a.png", "--legend"], 2, "there are none"),
        (["-o", "a.png", "--slice", "x=0", "--range", "2..1"], 2, "-20..20"),
        (["-o", "a.png", "--slice", "x=0", "--legend", "mm", "--size", "90x400"], 2, "has no room for a legend"),
        (["-o", "a.png", "--size", "0x0"], 2, "WIDTHxHEIGHT"),
        (["-o", "a.png", "--size", "16000x16000"], 2, "40 million pixels"),
        (["-o", "a.png", "--cut", "y<0 &"], 2, "what to take away"),
        (["-o", "a.png", "--cut", "y<0 & y>1"], 2, "takes nothing away"),
        (["-o", "a.png", "--cut", "y<1e6"], 2, "leaves nothing of the part"),
        (["-o", "a.png", "--cut", "y<1e6 & z>-1e6"], 2, "leaves nothing of the part"),
    ],
)
def test_command_refuses(
    words: list[str], status: int, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["render", SPECIMEN, *words]) == status
    assert said in capsys.readouterr().err
    assert not os.listdir(tmp_path)


EXCHANGER = """
let block = box([40, 40, 30])
let wall = x
out solid = abs(wall) - 2 & block
out left = wall + 2 & block
out right = 2 - wall & block
"""


def covers(picture: Picture) -> tuple[float, float]:
    """The shares of the picture's width and height that the part takes, from its first pixel to its last."""
    seen = picture.pixels[..., 3] > 0
    return tuple(float(np.ptp(np.flatnonzero(seen.any(axis=axis))) + 1) / seen.shape[1 - axis] for axis in (0, 1))  # type: ignore[return-value]  # two of them


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
@pytest.mark.parametrize(
    "text",
    [
        "sphere(10)",
        "translate(cylinder(4, 60), [300, 20, -7]) |> rotate([1, 2, 3], 0.7)",
        # bounds that are safe, and far too large
        "sphere(10) & (sphere(10) @ [x + 0 * x * y, y, z]) | (translate(sphere(1), [0, 90, 0]) & z > 50)"
        .replace(" & z > 50", " & (50 - z)"),
        "sphere(4) | (cube(200) & length(p) - 3)",
    ],
)  # fmt: skip
@pytest.mark.usefixtures("gpu")
def test_the_part_fills_the_picture_and_none_of_it_is_cut_off(text: str, projection: Any) -> None:
    wishes = Wishes((200, 150), projection=projection, samples=1, transparent=True)
    made = render_output(porelang.compile(text).design(), None, wishes)
    rim = np.concatenate([made.pixels[[0, -1], :, 3].ravel(), made.pixels[:, [0, -1], 3].ravel()])
    assert not rim.any()
    assert 0.85 <= max(covers(made)) <= 0.97


@pytest.mark.usefixtures("gpu")
def test_a_pin_that_a_coarse_picture_misses_is_not_cut_off() -> None:
    """It is thinner than a coarse pixel by far, and reaches out of the frame that a ball alone would have."""
    program = porelang.compile("sphere(10) | capsule([0.03, 0, 0], [0.03, 0, 60], 0.06)")
    made = render_output(program.design(), None, Wishes((400, 400), VIEWS["front"], samples=2, transparent=True))
    rows = np.flatnonzero(made.pixels[..., 3].any(axis=1))
    assert rows[0] > 0
    assert np.ptp(rows) * made.pixel == pytest.approx(70, rel=0.05)


@pytest.mark.usefixtures("gpu")
def test_pictures_of_one_frame_can_be_compared() -> None:
    program = porelang.compile("param r = 10 in 5..10\ncube(40) & (sphere(r) | translate(sphere(1), [30, 0, 0]))")
    wishes = Wishes((120, 90), projection="orthographic", samples=1, frame="bounds")
    bounds = (-20.0, -20.0, -20.0, 20.0, 20.0, 20.0)
    same = [render_output(program.design(r=r), None, replace(wishes, frame="surface"), bounds).pixel for r in (6, 9)]
    assert same[0] == same[1]
    pixels = [render_output(program.design(r=9), None, replace(wishes, frame=f)).pixel for f in ("surface", "bounds")]  # type: ignore[arg-type]  # each is one
    assert pixels[0] <= pixels[1]


@pytest.mark.usefixtures("gpu")
def test_each_output_has_its_colour() -> None:
    design = porelang.compile(EXCHANGER).design()
    wishes = Wishes((300, 200), VIEWS["top"], "orthographic", samples=1)
    made = render_output(design, ["solid", "left", "right"], wishes)
    assert [name for name, _ in made.colours] == ["solid", "left", "right"]
    width = 40 / made.pixel
    for (_, colour), x in zip(made.colours, (0, -12, 12), strict=True):
        seen = made.pixels[100, round(150 + x / 40 * width), :3].astype(float)
        assert np.abs(seen - np.array(colour)).max() < 40  # as bright as it is lit
        nearest = min(made.colours, key=lambda c: float(np.abs(seen - np.array(c[1])).sum()))
        assert nearest[1] == colour
    # where one ends the next begins: at 2 mm from the middle
    row = made.pixels[100, :, :3].astype(float)
    blue = row[:, 2] > row[:, 0] + 30
    assert (np.flatnonzero(blue)[0] - 149.5) * made.pixel == pytest.approx(2, abs=1.5 * made.pixel)
    with pytest.raises(PoreError, match="glass"):
        render_output(design, ["solid", "left"], replace(wishes, solid="glass"))
    with pytest.raises(PoreError, match="no output `solit`"):
        render_output(design, ["solit"], wishes)


@pytest.mark.usefixtures("gpu")
def test_a_field_is_seen_on_the_surface() -> None:
    design = porelang.compile("let heat = 20 + x\nlet both = x\ncube(20)").design()
    wishes = Wishes((200, 200), VIEWS["top"], "orthographic", samples=1, field="heat")
    made = render_output(design, None, wishes)
    assert isinstance(made.scale, Ramp)
    assert made.scale.ends == pytest.approx((10, 30), abs=0.3)
    seen = made.pixels[100, [15, 185], :3].astype(float)
    assert np.abs(seen[0] - 255 * VIRIDIS[0]).max() < 45
    assert np.abs(seen[1] - 255 * VIRIDIS[-1]).max() < 60
    around = render_output(design, None, replace(wishes, field="both"))
    assert isinstance(around.scale, Scale)
    seen = around.pixels[100, [15, 185], :3].astype(float)
    assert seen[0, 0] > seen[0, 2] + 60  # red where it is negative
    assert seen[1, 2] > seen[1, 0] + 60


@pytest.mark.parametrize(
    ("pixel", "width", "length"), [(0.1, 800, 10), (1.0, 800, 100), (0.003, 500, 0.2), (7, 300, 200)]
)
def test_a_scale_bar_has_a_round_length_that_is_true(pixel: float, width: int, length: float) -> None:
    blank = np.full((400, width, 4), 255, np.uint8)
    made = lay(blank, [scale_bar_mark(pixel, (width, 400))], blank[..., 0] < 0)
    dark = (made[..., :3].max(axis=2) < 110).sum(axis=1)
    bar = np.flatnonzero(made[int(np.argmax(dark)), :, 0] < 140)
    assert np.ptp(bar) + 1 == pytest.approx(length / pixel, abs=4)  # and the thickness of its ends
    assert told(length) == {10: "10 mm", 100: "100 mm", 0.2: "0.2 mm", 200: "200 mm"}[length]
    assert [told(v) for v in (5000.0, 0.05, 1000.0)] == ["5 m", "50 um", "1 m"]


@pytest.mark.parametrize(
    ("view", "axis", "column", "row"),
    [("front", 0, 1, 0), ("front", 2, 0, -1), ("right", 1, 1, 0), ("top", 1, 0, -1), ("back", 0, -1, 0)],
)
def test_the_triad_points_where_the_axes_do(view: str, axis: int, column: int, row: int) -> None:
    box = Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    blank = np.full((600, 800, 4), 255, np.uint8)
    made = lay(blank, [axes_mark(look(box, VIEWS[view], (800, 600)), (800, 600))], blank[..., 0] < 0)

    def near(colour: tuple[int, int, int]) -> NDArray[np.bool_]:
        return np.abs(made[..., :3].astype(int) - colour).max(axis=2) < 40

    place = np.argwhere(near(AXES[axis])).mean(axis=0)
    ends = np.argwhere(near(AXES[axis]))
    long = np.ptp(ends, axis=0)
    assert (long[1] > 2 * long[0]) if column else (long[0] > 2 * long[1])
    middle = np.argwhere((made[..., :3] < 250).any(axis=2)).mean(axis=0)
    if column:
        assert (place[1] - middle[1]) * column > 0
    else:
        assert (place[0] - middle[0]) * row > 0
    assert not (made[300:, 400:, :3] < 255).any()  # it stays in its corner


#: What those see who lack a cone, of linear red, green and blue: Machado, Oliveira and Fernandes 2009, severity 1.
SEEN_BY = {
    "all cones": np.eye(3),
    "no long": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "no medium": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "no short": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}


def lab(colour: tuple[int, int, int], eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """A colour as an eye sees it, in CIELAB (D65): a distance of 2 is just noticed."""
    share = np.array(colour) / 255
    linear = np.clip(eye @ np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4), 0, 1)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear
    f = np.cbrt(xyz / (0.9505, 1.0, 1.089))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("eye", SEEN_BY)
@pytest.mark.parametrize("colours", [BODIES, AXES], ids=["bodies", "axes"])
def test_colours_are_told_apart_by_every_eye(eye: str, colours: tuple[tuple[int, int, int], ...]) -> None:
    places = [lab(c, SEEN_BY[eye]) for c in colours]
    assert min(float(np.linalg.norm(a - b)) for i, a in enumerate(places) for b in places[:i]) > 15


def test_marks_keep_off_the_part_where_they_can() -> None:
    box, size = Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), (400, 300)
    blank = np.full((300, 400, 4), 255, np.uint8)
    marks = [axes_mark(look(box, VIEWS["iso"], size), size), scale_bar_mark(0.1, size)]
    seen = np.zeros((300, 400), np.bool_)
    seen[200:, :250] = True  # the lower left corner
    drawn = (lay(blank, marks, seen)[..., :3] < 250).any(axis=2)
    assert drawn[:150, :200].any()
    assert drawn[200:, 250:].any()
    assert not (drawn & seen).any()
    everywhere = lay(blank, marks, np.ones((300, 400), np.bool_))  # then they are on it
    assert (everywhere[150:, :200, :3] < 250).any()
    tiny = lay(blank[:20, :30], marks, seen[:20, :30])
    assert tiny.shape == (20, 30, 4)


@pytest.mark.usefixtures("gpu")
def test_a_picture_for_python(tmp_path: Path) -> None:
    program = porelang.compile(EXCHANGER)
    made = program.render(bodies=True, size="120x90", samples=1, cut="x>0", axes=True, scale_bar=True, view=(-30, 20))
    assert made.array.shape == (90, 120, 3)
    assert made.array.dtype == np.uint8
    made.save(tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert np.array_equal(np.asarray(image), made.array)
    assert made._repr_png_().startswith(b"\x89PNG")
    assert "\n" not in repr(made)
    assert len(repr(made)) < 100
    clear = program.render("solid", size=(60, 40), samples=1, background="transparent")
    assert clear.pixels[0, 0].tolist()[3] == 0
    assert clear.array[0, 0].tolist() == [255, 255, 255]
    with pytest.raises(PoreError, match="E112"):
        made.save(tmp_path / "a.jpg")
    for wrong, code in (
        ({"view": "above"}, "E108"), ({"cut": "y=0"}, "E108"), ({"size": (0, 5)}, "E108"), ({"slice": ["q=1"]}, "E108"),
        ({"projection": "flat"}, "E108"), ({"legend": True}, "E108"), ({"zoom": 0}, "E108"), ({"samples": 9}, "E108"),
        ({"range": "2..1", "field": "wall"}, "E108"), ({"solid": "none"}, "E108"),
    ):  # fmt: skip
        with pytest.raises(PoreError) as caught:
            program.render("solid", **wrong)  # type: ignore[arg-type]  # as a user might
        assert caught.value.diagnostics[0].code == code
    failing = porelang.compile('param r = 5 in 1..9\ncheck r < 4, "too large"\nsphere(r)')
    with pytest.raises(PoreError, match="too large"):
        failing.render(size=(40, 30))
    assert failing.render(size=(40, 30), samples=1, check=False).covered > 0


@pytest.mark.usefixtures("gpu")
def test_the_command_draws_several_outputs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "hx.pore"
    path.write_text(EXCHANGER)
    target = tmp_path / "a.png"
    words = ["render", str(path), "-o", str(target), "--size", "300x200", "--samples", "1", "--json"]
    assert main([*words, "--bodies", "--legend", "--axes", "--scale-bar"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["output"] == ["solid", "left", "right"]
    assert set(told["colours"]) == {"solid", "left", "right"}
    with Image.open(target) as image:
        assert image.size == (300, 200)
    assert main([*words, "--out", "left", "--out", "right"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["output"] == ["left", "right"]
    assert again["colours"] == {name: told["colours"][name] for name in ("left", "right")}  # an output keeps its colour
    assert main([*words, "--out", "left"]) == 0
    assert json.loads(capsys.readouterr().out)["output"] == "left"


@pytest.mark.slow
def test_without_opengl_it_says_what_to_install(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "porelang", "render", SPECIMEN, "-o", str(tmp_path / "a.png"), "--size", "40x30"]
    environment = {**os.environ, "PORELANG_GL": "none", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 3
    assert "error[E120]" in done.stderr
    assert "hint" in done.stderr
    assert "Traceback" not in done.stderr
    assert not os.listdir(tmp_path)
    # planes alone are drawn with NumPy
    command += ["--slice", "z=0", "--solid", "none"]
    planes = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert planes.returncode == 0
    assert os.listdir(tmp_path) == ["a.png"]
