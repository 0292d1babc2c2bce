"""What a program means, through the Python API: units, stages, contracts, params, files, points."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.checks import broken_checks
from porelang.gpu import Gpu
from porelang.program import Program


def value(expression: str, at: tuple[float, float, float] = (1.0, 2.0, 3.0), **settings: object) -> float:
    return float(porelang.compile(expression).field(**settings)([at])[0])  # type: ignore[arg-type]


def codes(text: str) -> list[str]:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text)
    return [d.code for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("text", "millimetres"),
    [
        ("1um", 1e-3),
        ("1mm", 1),
        ("1cm", 10),
        ("1m", 1000),
        ("2in", 50.8),
        ("180deg", math.pi),
        ("1rad", 1),
        ("0.5turn", math.pi),
        ("1N", 1),
        ("2kN", 2000),
        ("1Pa", 1e-6),
        ("1kPa", 1e-3),
        ("3MPa", 3),
        ("1GPa", 1000),
        ("45%", 0.45),
    ],
)
def test_units_are_base_units(text: str, millimetres: float) -> None:
    assert value(f"0 * x + {text} / {text} * {millimetres} + ({text}) - ({text})") == pytest.approx(
        millimetres, rel=1e-12
    )


@pytest.mark.parametrize(
    "text",
    [
        "5mm + 3deg",
        "5mm < 3N",
        "min(5mm, 3deg)",
        "max([1mm, 2mm, 3mm], 2N).x",
        "if x > 0 then 5mm else 3deg",
        "[1mm, 2deg, 3]",
        "cylinder(75mm, 30deg)",
        "sin(5mm)",
        "2 * 5mm + 3deg",
        "5mm * 5mm + 5mm",
        "sqrt(4mm * 4mm) + 3N",
        "(5mm)^2 + 3mm",
        "5mm / 2s",
        "param a = 5mm in 1deg..9deg\na",
        "x ^ 5mm",
        "5N / (2mm * 2mm) + 1N",
        "exp(0) * 5mm % 3deg",
        "atan2(5mm, 3deg)",
    ],
)
def test_known_dimensions_that_clash_are_errors(text: str) -> None:
    assert set(codes(text)) <= {"E062", "E002", "E003", "E004"}


@pytest.mark.parametrize(
    "text",
    [
        "5mm + 3",
        "x + 5mm",
        "cos(x)",
        "cos(tau / 30mm * x)",
        "gyroid(30) |> thicken(5, 1)",
        "thicken(metric(gyroid(30mm)), 2mm)",
        "2 * 5mm + 3mm",
        "sin(30deg) * 75mm",
        "75 * sin(30deg) + 5mm",
        "(5mm / 30mm) * 75 + 2mm",
        "5MPa - 2N / (1mm * 1mm)",
        "twist(gyroid(30), 30deg / 10mm)",
        "sphere(r=5) & cylinder(75mm, 300)",
        "50% * 75 + 2mm",
        "x * 5mm + 3deg",
        "atan2(5mm, 3mm) + 2deg",
        "let r = 75\nr * 5mm + 3",
        "clamp(x, 1mm, 5mm)",
        "mix(2mm, 4mm, 30%)",
        "(4mm)^(1/2) * x",
    ],
)
def test_bare_numbers_fit_anywhere(text: str) -> None:
    assert porelang.compile(text).warnings == ()


def test_stages() -> None:
    program = porelang.compile("param a = 2 in 1..3\nlet c = 2 * 3\nlet u = a * c\nout f = u * x\nout k = u + c")
    assert "const" not in program.params
    assert program.field("k")([[5.0, 5.0, 5.0]])[0] == 18.0
    assert program.field("f", a=3)([[2.0, 0.0, 0.0]])[0] == 36.0
    assert codes("param n = 2.5 in 1..5\nsum([for i in range(n): i * x])") == ["E063"]
    assert codes("sum([for i in range(x): i * x])") == ["E063"]


def test_contracts_on_constants_params_and_fields() -> None:
    assert codes("def f(r: length where r > 0) = x - r\nf(-3)") == ["E064"]
    with pytest.raises(porelang.PoreError, match=r"`w` = -1"):
        porelang.compile("param w = 1 in -1..2\ndef f(r where r > 0) = x - r\nf(w)")
    fine = porelang.compile("param w = 1 in 0.5..2\ndef f(r where r > 0) = x - r\nf(w * w - w + 1)")
    assert fine.warnings == ()  # positive for every w, though not term by term
    (warning,) = porelang.compile("sphere(x) & box([9, 9, 9])").warnings
    assert warning.code == "W201"
    place = [float(v) for v in warning.label.split("(")[1].rstrip(")").split(",")]
    assert place[0] <= 0  # the witness is one
    assert porelang.compile("sphere(x + 20) & box([9, 9, 9])").warnings == ()


def test_contracts_of_what_is_moved_are_seen_from_where_it_is() -> None:
    """`w` is x + 60 at the lattice's own place, and the lattice is then moved 100 mm: positive where it is used."""
    text = "gyroid(w=x + 60) |> translate([100, 0, 0]) & (box([9, 9, 9]) |> translate([100, 0, 0]))"
    assert porelang.compile(text).warnings == ()
    assert porelang.compile(text.replace("x + 60", "x - 60")).warnings[0].code == "W201"


def test_lattices_take_a_period_or_a_phase_not_both_not_neither() -> None:
    assert codes("gyroid()") == ["E043"]
    assert codes("gyroid(20, phase=p / 20)") == ["E045"]
    at = (3.0, 7.0, -2.0)
    assert value("gyroid(w=20)", at) == pytest.approx(value("gyroid(phase=p / 20)", at), abs=1e-14)
    assert codes("gyroid(0)") == ["E064"]
    assert codes("gyroid([1, 2, -3])") == ["E064"]


def test_params_of_every_sort() -> None:
    program = porelang.compile(
        'param w = 30mm in 10mm..60mm step 5mm "cell"\nparam kind = gyroid in {gyroid, diamond}\n'
        'param n = 2 in {1, 2, 4}\nparam side = "both" in {"both", "in"}\nparam on = true in {true, false}\n'
        'let g = kind(w) * n\nif on and side == "both" then g else -g'
    )
    assert program.params["w"].doc == "cell"
    assert program.params["kind"].choices == ("gyroid", "diamond")
    at = (3.0, 7.0, -2.0)

    def f(**settings: object) -> float:
        return float(program.field(**settings)([at])[0])  # type: ignore[arg-type]

    assert f() == pytest.approx(2 * value("gyroid(30)", at))
    assert f(kind="diamond", w="2cm") == pytest.approx(2 * value("diamond(20)", at))
    assert f(n=4) == pytest.approx(4 * value("gyroid(30)", at))
    assert f(on="false") == f(side="in") == pytest.approx(-2 * value("gyroid(30)", at))
    for settings, words in [
        ({"w": 9}, "outside its range"),
        ({"w": "3deg"}, "a length"),
        ({"w": "3xx"}, "no unit"),
        ({"w": "nan"}, "cannot be"),
        ({"w": float("inf")}, "cannot be"),
        ({"kind": "giroid"}, "did you mean `gyroid`?"),
        ({"n": 3}, "cannot be"),
        ({"v": 3}, "`v` is neither an option of what is asked nor a param"),
        ({"on": "maybe"}, "cannot be"),
    ]:
        with pytest.raises(porelang.PoreError, match=words.replace("?", r"\?")):
            program.field(**settings)  # type: ignore[arg-type]


def test_a_param_changes_nothing_but_numbers(gpu: Gpu) -> None:
    """The shader's text, and so its compilation, does not depend on a param's value."""
    program = porelang.compile("param w = 30 in 10..60\nparam k = gyroid in {gyroid, diamond}\nk(w) & sphere(50)")
    points = np.random.default_rng(0).uniform(-40, 40, (100, 3))
    program.field(backend="glsl", dtype="f32")(points)
    before = gpu.compiled
    for w in (12, 33, 59):
        for k in ("gyroid", "diamond"):
            got = program.field(backend="glsl", dtype="f32", w=w, k=k)(points)
            want = program.field(w=w, k=k)(points)
            assert np.abs(got - want).max() < 1e-4
    assert gpu.compiled == before


def test_definitions_may_stand_in_any_order_and_shadow_the_prelude() -> None:
    assert value("let a = b + 1\nlet b = c * 2\nlet c = 3\na + 0 * x") == 7
    assert value("def sphere(r) = 42 + 0 * x\nsphere(1)") == 42
    assert value("def f(x) = x + 1\nf(10) + 0 * y") == 11  # a parameter may be called x
    assert codes("let x = 3\ny") == ["E032"]
    assert codes("let a = 1\nlet a = 2\na + x") == ["E031"]


def test_used_files(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "plates.pore").write_text(
        "param t = 2mm in 1mm..5mm\nlet half = t / 2\ndef plate(h) = abs(z) - h + half\n"
    )
    main = tmp_path / "main.pore"
    main.write_text('use "lib/plates.pore" as plates\nplates.plate(7) + plates.half\n')
    program: Program = porelang.compile(path=main)
    assert program.field()([[0.0, 0.0, 3.0]])[0] == pytest.approx(3 - 7 + 1 + 1)
    assert program.field(**{"plates.t": 4})([[0.0, 0.0, 3.0]])[0] == pytest.approx(3 - 7 + 2 + 2)
    (tmp_path / "lib" / "plates.pore").write_text('use "../main.pore" as main\nlet a = 1\n')
    with pytest.raises(porelang.PoreError, match="ring"):
        porelang.compile(path=main)
    main.write_text('use "lib/nope.pore" as plates\nx\n')
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(path=main)
    assert caught.value.diagnostics[0].code == "E105"
    assert caught.value.diagnostics[0].span is not None
    main.write_text('use "lib/plates.pore" as plates\nplates.plat(1)\n')
    (tmp_path / "lib" / "plates.pore").write_text("def plate(h) = abs(z) - h\n")
    with pytest.raises(porelang.PoreError, match="did you mean `plate`"):
        porelang.compile(path=main)


def test_outputs_and_their_kinds() -> None:
    program = porelang.compile("out v = [x, 2 * y, z]\nout b = x < 3\nout part = sphere(3)")
    points = [[1.0, 2.0, 3.0], [4.0, 0.0, 0.0]]
    assert program.field("v")(points).tolist() == [[1, 4, 3], [4, 0, 0]]
    assert program.field("b")(points).tolist() == [True, False]
    with pytest.raises(porelang.PoreError, match="a vector"):
        program.bounds("v")
    with pytest.raises(porelang.PoreError, match="did you mean `part`"):
        program.field("prat")


@pytest.mark.parametrize(
    "points", [[[1, 2]], [[1, 2, float("nan")]], [["a", "b", "c"]], np.zeros((2, 3, 3)), [[1e12, 0, 0]]]
)
def test_points_that_are_no_places_are_refused(points: object) -> None:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile("x").field()(points)
    assert caught.value.diagnostics[0].code == "E104"


def test_all_independent_errors_are_said_at_once() -> None:
    text = "let a = foo(3)\nlet b = 5mm + 3deg\nlet c = sphere(\nlet d = gyroid(w=1, q=2)\n"
    text += "let e = a + b + c + d\ndef g(t) = t + bar\ne"
    assert sorted(codes(text)) == sorted(["E030", "E062", "E005", "E041", "E030"])


def test_one_period_is_w() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform(-50, 50, (200, 3))
    f = porelang.compile("param w = 17 in 1..99\ngyroid(w) + 2 * diamond([w, 2 * w, 3 * w])").field()
    assert np.abs(f(points + np.array([17, 34, 51])) - f(points)).max() < 1e-12


def test_a_mesh_for_python() -> None:
    mesh = porelang.compile("sphere(10)").mesh("part", voxel=0.5)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4 / 3 * math.pi * 1000, rel=5e-3)
    with pytest.raises(porelang.PoreError, match="no end along x, y, z"):
        porelang.compile("gyroid(30)").mesh()
    with pytest.raises(porelang.PoreError, match="holds no material"):
        porelang.compile("sphere(1) + 5").mesh()


def test_a_refined_mesh_for_python() -> None:
    program = porelang.compile("cylinder(10, 20)")
    plain, fine = program.mesh(voxel=1.0), program.mesh(voxel=1.0, smooth=True, sharp=True)
    exact = math.pi * 100 * 20
    assert abs(fine.volume - exact) < abs(plain.volume - exact)
    assert fine.is_watertight
    few = program.mesh(voxel=1.0, sharp=True, simplify=0.05)
    assert len(few.faces) < len(fine.faces) / 2
    assert few.is_watertight


@pytest.mark.parametrize(
    ("text", "lo", "hi"),
    [
        (
            "def blob(i) = smooth_union(sphere(2), cube(3), 1) |> translate([7 * (i % 10), 7 * floor(i / 10), 0])\n"
            "union([for i in range(100): blob(i)])",
            (-2, -2, -2),
            (65, 65, 2),
        ),
        ("union([for i in range(20): cube(2) |> translate([5 * i, 0, 0]) |> rotate([0, 0, 1], i * 0.1)])", None, None),
        ("cube(10) |> rotate([1, 2, 3], 40deg) |> translate([500, 0, 0])", None, None),
    ],
)
@pytest.mark.slow
def test_bounds_hold_the_part_and_little_more(text: str, lo: object, hi: object) -> None:
    """Against the extent of what dense samples find solid."""
    program = porelang.compile(text)
    box = program.bounds()
    spread = np.random.default_rng(0)
    points = spread.uniform(np.array(box.lo) - 5, np.array(box.hi) + 5, (400_000, 3))
    solid = points[program.field(dtype="f32")(points) <= 0]
    assert (solid >= box.lo).all()
    assert (solid <= box.hi).all()
    slack = 0.1 * np.array(box.size) + 3.5  # a member's size, where there are many
    assert (solid.min(axis=0) - box.lo <= slack).all()
    assert (box.hi - solid.max(axis=0) <= slack).all()
    if lo is not None:
        assert (np.array(box.lo) <= lo).all()
        assert (np.array(box.hi) >= hi).all()


def test_a_broken_check_stops_what_relies_on_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from porelang.cli import main

    path = tmp_path / "part.pore"
    path.write_text('let e = sphere(10)\ncheck porosity(gyroid(5), e) > 80%, "too dense"\ngyroid(5) & e\n')
    assert main(["mesh", str(path), "-o", str(tmp_path / "part.stl")]) == 1
    assert not (tmp_path / "part.stl").exists()
    assert main(["check", str(path)]) == 0
    assert "--measure looks at it" in capsys.readouterr().err
    path.write_text('param w = 12mm in 10mm..20mm\ncheck w > 11mm, "too fine"\ngyroid(w)\n')
    (tmp_path / "points.csv").write_text("1,2,3\n")
    points = ["--points", str(tmp_path / "points.csv")]
    assert main(["eval", str(path), *points]) == 0
    assert main(["eval", str(path), *points, "--set", "w=10.5mm"]) == 1
    (tmp_path / "points.csv").write_text("x;y;z\n1,5;2;3\n")
    assert main(["eval", str(path), *points]) == 2
    assert "decimals with a point" in capsys.readouterr().err


@pytest.mark.slow
def test_walls_thinner_than_a_voxel_are_not_passed_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from porelang.cli import main

    path = tmp_path / "thin.pore"
    path.write_text("shell(sphere(20), 0.01)\n")
    asked = ["mesh", str(path), "-o", str(tmp_path / "thin.stl"), "--resolution", "40"]
    assert main(asked) == 1
    assert "E118" in capsys.readouterr().err
    assert not (tmp_path / "thin.stl").exists()
    assert main([*asked, "--force"]) == 0
    assert "W202" in capsys.readouterr().err
    path.write_text("sphere(20)\n")
    assert main(["mesh", str(path), "-o", str(tmp_path / "thin.stl"), "--resolution", "40"]) == 0
    assert "W202" not in capsys.readouterr().err


def test_what_python_hands_over() -> None:
    program = porelang.compile("out part = sphere(10)\nout half = x < 0")
    assert program.mesh("part", bounds=program.bounds("part"), resolution=20).is_watertight
    assert program.mesh("part", bounds=[[-8] * 3, [8] * 3], resolution=20).bounds.tolist() == [[-8] * 3, [8] * 3]
    assert program.field("half")([[1.0, 0, 0], [-1.0, 0, 0]]).tolist() == [False, True]
    for wrong in ({"dtype": "f16"}, {"backend": "cuda"}):
        with pytest.raises(porelang.PoreError, match="choose from"):
            program.field("part", **wrong)  # type: ignore[arg-type]


@pytest.mark.usefixtures("gpu")
def test_a_condition_on_the_device_is_one() -> None:
    program = porelang.compile("out half = x < 0")
    assert program.field("half", backend="glsl")([[1.0, 0, 0], [-1.0, 0, 0]]).tolist() == [False, True]


def test_an_output_can_be_referred_to_by_its_name() -> None:
    program = porelang.compile('out solid = box([20, 20, 20])\nout skin = shell(solid, 2, side="inside")\n')
    assert program.field("skin")([[9, 0, 0], [7, 0, 0]]).tolist() == pytest.approx([-1, 1])
    bare = porelang.compile('check volume(part) > 100000, "too small"\nsphere(10)')
    (failed,) = broken_checks(bare.design(), measure=True)
    assert failed.message == "too small"


def test_an_output_named_like_a_function_leaves_the_function_alone() -> None:
    program = porelang.compile("out cylinder = cylinder(10, 20)\nout two = cylinder(5, 40)\n")
    assert program.field("two")([[0, 0, 0]])[0] == pytest.approx(-5)


def test_a_let_wins_over_an_output_of_its_name() -> None:
    program = porelang.compile("let skin = sphere(10)\nout skin = skin\nout core = offset(skin, -1)\n")
    assert program.field("core")([[0, 0, 0]])[0] == pytest.approx(-9)


def test_an_output_that_refers_to_itself_is_a_ring() -> None:
    assert codes("out a = b & x\nout b = a\n") == ["E033"]
    assert codes("part & sphere(5)") == ["E033"]


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"resolution": -5}, "resolution of -5"),
        ({"resolution": 0}, "resolution of 0"),
        ({"resolution": math.nan}, "resolution of nan"),
        ({"resolution": "9"}, "'9' is no resolution"),
        ({"resolution": 24.5}, "24.5 is no whole number"),
        ({"voxel": -1.0}, "voxel of -1 mm"),
        ({"voxel": 0}, "voxel of 0 mm"),
        ({"voxel": 1e300}, "larger than any part"),
        ({"voxel": "half"}, "voxel: `half` is no length"),
        ({"voxel": 1.0, "resolution": 3}, "either a voxel or a resolution"),
    ],
)
def test_what_cannot_be_sampled_at_is_said_by_mesh_and_measure(asked: dict[str, Any], words: str) -> None:
    program = porelang.compile("sphere(3)")
    for ask in (program.mesh, program.measure):
        with pytest.raises(porelang.PoreError, match=words) as caught:
            ask(**asked)
        assert caught.value.diagnostics[0].code == "E114"


@pytest.mark.parametrize("simplify", [math.nan, math.inf, "a", -1, 0, True])
def test_a_deviation_is_a_length(simplify: Any) -> None:
    with pytest.raises(porelang.PoreError, match=r"no (deviation|length)") as caught:
        porelang.compile("sphere(3)").mesh(resolution=8, simplify=simplify)
    assert caught.value.diagnostics[0].code == "E114"


def test_nonsense_from_python_is_said_in_words() -> None:
    program = porelang.compile(
        "param voxel = 3 in 1..9\nparam k = f in {f, g}\ndef f(s) = s\ndef g(s) = s\nk(sphere(voxel))"
    )
    wrong: list[tuple[str, Callable[[], object]]] = [
        ("E084", lambda: program.design({"voxel": 10**400})),
        ("E084", lambda: program.design({"voxel": 4}, voxel=5)),
        ("E084", lambda: program.design(k=math.nan)),
        ("E084", lambda: program.design(k=True)),
        ("E083", lambda: program.design({3: 4})),  # type: ignore[dict-item]  # as a user might
        ("E100", lambda: program.field(3)),  # type: ignore[arg-type]  # as above
        ("E109", lambda: program.measure(within=3)),  # type: ignore[arg-type]  # as above
        ("E104", lambda: program.field()([[10**400, 0, 0]])),
        ("E104", lambda: program.field()([[1j, 0, 0]])),
        ("E104", lambda: program.field()([["1", "2", "3"]])),
        ("E104", lambda: program.field()(np.zeros((5, 0)))),
    ]
    for code, ask in wrong:
        with pytest.raises(porelang.PoreError) as caught:
            ask()
        assert caught.value.diagnostics[0].code == code


def test_a_field_comes_back_from_a_pickle_on_either_backend(engine: str) -> None:
    field = porelang.compile("sphere(3)").field(backend=engine)  # type: ignore[arg-type]  # one of the two
    for again in (pickle.loads(pickle.dumps(field)), copy.deepcopy(field)):
        assert again([[5, 0, 0]])[0] == 2
