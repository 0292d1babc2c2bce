"""What studies check of themselves and say: fields that are no numbers, units, sizes, what holds against the load."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang import store
from porelang.backends.numpy import NumpyField
from porelang.cli import main
from porelang.diagnostics import PoreError
from porelang.formula import Formula
from porelang.ir import ONE, ZERO, X, Y, const, node
from porelang.ops.studies import NUMBERS
from porelang.strength import Strength, carry_out
from porelang.tasks.study import estimate
from porelang.tasks.study.coarse import coarse, finer
from porelang.tasks.study.conditions import certain_and_possible
from porelang.tasks.study.got import Got
from porelang.tasks.study.sized import for_walls

pytestmark = pytest.mark.usefixtures("own_cache")

MATERIAL = "E=2GPa, nu=0.3"
BOX = "let body = box([40mm, 10mm, 8mm])\n"
HELD = "x < -19.9mm"
PUSH = "force(x > 19.9mm, [0, 0, -100N])"


def found(call: str, before: str = BOX, refine: bool = False, **settings: Any) -> Strength:
    program = porelang.compile(f"{before}let s = {call}\nout part = body")
    return carry_out(program.design(**settings), refine=refine)


def codes(of: Strength) -> set[str]:
    return {d.code for d in of.told if d.code}


def said(of: Strength, code: str) -> str:
    (one,) = (d for d in of.told if d.code == code)
    return f"{one.message}; {one.hint}"


# ---- what is no number


def test_a_part_whose_field_is_not_a_number_is_refused_with_a_place() -> None:
    with pytest.raises(PoreError, match=r"E093.*not a number at \(") as told:
        found(f"compress(body, 1kN, {MATERIAL}, size=4mm)", "let body = cube(10mm) + 0mm * sqrt(x / 1mm - 2)\n")
    x = float(re.findall(r"at \(([-\d.]+)", str(told.value))[0])
    assert x < 2


@pytest.mark.parametrize("where", ["sqrt(x / 1mm) < 1", "not (sqrt(x / 1mm) < 1)", "0 * log(x / 1mm) == 0"])
def test_a_condition_without_an_answer_is_refused_with_a_place(where: str) -> None:
    with pytest.raises(PoreError, match=r"E174.*this `held`.*not a number at \(-\d"):
        found(f"study(body, fix={where}, load={PUSH}, {MATERIAL}, size=8mm)")


def test_a_condition_that_does_not_ask_there_has_its_answer() -> None:
    guarded = f"{HELD} or (x > 19mm and sqrt(x / 1mm - 19) < 0.5)"
    held = found(f"study(body, fix={guarded}, load=force(z > 3.9mm, [0, 0, -9N]), {MATERIAL}, size=8mm)")
    np.testing.assert_allclose(held.reaction, [0, 0, 9], atol=1e-6)


def test_conditions_are_kleenes() -> None:
    """What might hold, by the truth tables of three values."""
    none = const(float("nan"))
    yes, no, unknown = node("lt", ZERO, ONE), node("lt", ONE, ZERO), node("lt", none, X)

    def answer(n: Any) -> bool | None:
        forms = (node("and", node("le", Y, Y), form) for form in certain_and_possible(n))
        certain, possible = NumpyField(Formula.of(*forms), "f64").at(np.zeros((1, 3)))[0]
        assert possible or not certain
        return bool(certain) if certain == possible else None

    known = {True: yes, False: no, None: unknown}
    for a, first in known.items():
        assert answer(first) is a
        assert answer(node("not", first)) is (None if a is None else not a)
        for b, second in known.items():
            either = True if True in (a, b) else None if None in (a, b) else False
            both = False if False in (a, b) else None if None in (a, b) else True
            assert answer(node("or", first, second)) is either
            assert answer(node("and", first, second)) is both
            chosen = (a if b is True else False) if b is not None else (None if a is not False else False)
            assert answer(node("select", second, first, no)) is chosen
    assert answer(node("eq", none, X)) is None


@pytest.mark.parametrize(("where", "room"), [("x < -20mm", "x < -19mm, where the part ends at -20 mm"),
                                             ("z > 4mm", "z > 3.9mm, where the part ends at 4 mm")])  # fmt: skip
def test_what_misses_an_end_is_told_with_that_end(where: str, room: str) -> None:
    with pytest.raises(PoreError, match="E170") as refused:
        found(f"study(body, fix={where}, load={PUSH}, {MATERIAL}, size=8mm)")
    assert room in str(refused.value)


def test_what_a_study_does_not_give_is_said_with_where_it_is(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "s.pore"
    for asked, hint in (("s.reaction", "`pore fea` reports the force on each support"),
                        ("s.effective_modulus", "`s.stiffness * length / area`"),
                        ("density(s)", "`pore optimize FILE --iterate part --rule optimum`")):  # fmt: skip
        file.write_text(f"{BOX}let s = compress(body, 1kN, {MATERIAL})\nlet a = {asked}\nbody", encoding="utf-8")
        assert main(["check", str(file)]) == 1
        assert hint in capsys.readouterr().err


def test_what_takes_long_is_said_before_it_begins(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the size, what there is to solve and about how long; and nothing where nobody wants to hear it."""
    file = tmp_path / "s.pore"
    file.write_text(f"{BOX}let s = compress(body, 1kN, {MATERIAL}, size=1mm)\nbody", encoding="utf-8")

    def stop(*_: Any, **__: Any) -> None:
        raise PoreError([])

    monkeypatch.setattr("porelang.tasks.study.elements.direct", stop)
    for quiet in ([], ["-q"]):
        main(["fea", str(file), *quiet])
        told = re.findall(r"some [\d,]+ elements of 1 mm, [\d,]+ unknowns: about \d+ s", capsys.readouterr().err)
        assert len(told) == (0 if quiet else 1)


# ---- what holds against the load


def test_the_reaction_is_of_what_stands_still() -> None:
    """It is opposite to the load, and to what a support that moves the part presses with."""
    two = found(f"study(body, fix=[{HELD}, x > 19.9mm], load=force(z > 3.9mm, [0, 0, -10N]), {MATERIAL}, size=8mm)")
    np.testing.assert_allclose(two.report["reaction"], [0, 0, 10], atol=1e-6)
    pressed = found(f"compress(body, 10N, axis=x, {MATERIAL}, size=8mm)").report
    np.testing.assert_allclose(pressed["reaction"], [10, 0, 0], atol=1e-6)
    bent = found(f"bend(body, 10N, pads=4mm, {MATERIAL}, size=4mm)").report
    np.testing.assert_allclose(bent["reaction"], [0, 0, 10], atol=1e-9)
    assert set(bent["reactions"]) == {"first support", "second support"}
    moved = found(f"study(body, fix={HELD}, load=moved(x > 19.9mm, [0.1mm, 0, 0]), {MATERIAL}, size=8mm)").report
    assert moved["reaction"] == moved["reactions"]["held"]
    assert moved["reaction"][0] < -300


# ---- loads that balance each other


def test_a_part_under_pressure_on_all_sides_needs_no_support() -> None:
    """Hydrostatic: sigma = -p everywhere, strain = -p (1 - 2 nu) / E along each axis, counted from the middle."""
    free = found(f"study(body, fix=[], load=pressure(true, 3MPa), {MATERIAL}, size=8mm, balanced=true)")
    fields = free.solved.fields
    np.testing.assert_allclose(fields.stress, np.tile([-3.0, -3, -3, 0, 0, 0], (len(fields.stress), 1)), atol=1e-5)
    strain = -3 * (1 - 2 * 0.3) / 2000
    np.testing.assert_allclose(fields.displacement, strain * fields.mesh.vertices, atol=1e-7)
    for name in ("max_von_mises", "von_mises_99"):  # 0 in truth
        assert free.numbers[name].value < free.numbers[name].error < 1e-4


def test_what_only_seems_to_balance_is_refused() -> None:
    with pytest.raises(PoreError, match=r"E171.*loads drive a motion"):
        found(f"study(body, fix=[], load={PUSH}, {MATERIAL}, size=8mm, balanced=true)")
    with pytest.raises(PoreError, match=r"(?s)E171.*nothing holds.*balanced=true"):
        found(f'study(body, fix=held({HELD}, along="x"), load=pressure(true, 3MPa), {MATERIAL}, size=8mm)')


# ---- doubts about numbers


def test_units_of_elsewhere_are_doubted_when_they_are_known() -> None:
    """What the text does not show, of a param and of a field, is seen when it is solved."""
    params = "param e = 210e9 in 1..1e12\nparam rho = 7850 in 1..8000\n"
    wrong = found(f"study(body, fix={HELD}, load={PUSH}, E=e, nu=0.3, density=rho * (1 + abs(x) / 1m), size=8mm)",
                  params + BOX)  # fmt: skip
    told = [f"{d.message}; {d.hint}" for d in wrong.told if d.code == "W273"]
    assert re.search(r"2.1e\+11 MPa .*`E=210GPa`", told[0])
    assert re.search("g/cm3 .* kg/m3", told[1])
    right = found(f"study(body, fix={HELD}, load={PUSH}, E=e, nu=0.3, density=rho, size=8mm)", params + BOX, e=210e3,
                  rho=7.85)  # fmt: skip
    assert "W273" not in codes(right)


def test_large_displacements_and_yield_are_doubted() -> None:
    call = f'study(body, fix={HELD}, load=force(x > 19.9mm, [0, 0, -LOAD]), material="steel", size=4mm)'
    assert not codes(found(call.replace("LOAD", "50N")))
    yielding = found(call.replace("LOAD", "5kN"))
    assert codes(yielding) == {"W275"}
    assert "yields at 235" in said(yielding, "W275")
    absurd = found(call.replace("LOAD", "1e9N"))
    assert codes(absurd) >= {"W274", "W275"}
    assert "40 mm long" in said(absurd, "W274")
    squeezed = found(f"compress(body, 30kN, {MATERIAL}, size=4mm)")  # 75 MPa, 3.75 %: shorter by .3 mm
    assert "W274" not in codes(squeezed)
    assert "strained by 0.15" in said(found(f"compress(body, 120kN, {MATERIAL}, size=4mm)"), "W274")


@pytest.mark.parametrize("quiet", [[], ["-q"]])
def test_what_is_doubtful_of_the_text_is_in_json_too(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, quiet: list[str]
) -> None:
    """Units are doubted before anything is solved, the elements after: a script reads both in one place."""
    file = tmp_path / "s.pore"
    text = f"{BOX}let s = study(body, fix={HELD}, load={PUSH}, E=210e9, nu=0.3, density=7850, size=8mm)\nbody"
    file.write_text(text, encoding="utf-8")
    assert main(["fea", str(file), "--json", *quiet]) == 0
    out, err = capsys.readouterr()
    told = [d["code"] for d in json.loads(out)["warnings"]]
    assert told == ["W273", "W273", "W284"]
    assert re.findall(r"^warning\[(\w+)\]", err, re.M) == ([] if quiet else told)


# ---- sizes


def test_the_size_that_is_proposed_mends_what_is_too_coarse() -> None:
    """One warning, with one size, and about how many unknowns that makes."""
    call = f"study(body, fix={HELD}, load={PUSH}, {MATERIAL}, size=40mm)"
    coarse = found(call)
    assert codes(coarse) == {"W284"}
    told = said(coarse, "W284")
    assert "walls 8 mm thick, as at (" in told
    assert told.count("size=") == 1
    size, count = re.findall(r"`size=([\d.]+)mm` makes some ([\d,]+) unknowns, about \d+ s$", told)[0]
    assert float(size) <= 4
    fine = found(call.replace("40mm", f"{size}mm"))
    assert not codes(fine)
    assert 0.5 < int(count.replace(",", "")) / fine.solved.unknowns < 2


@pytest.mark.parametrize(
    ("part", "call"),
    [
        ("box([200mm, 200mm, 2mm])", "compress(body, force=1kN, axis=z, {}, size=200mm)"),
        ("box([200mm, 1mm, 1mm])", "study(body, fix=x < -99mm, load=force(x > 99.9mm, [1N, 0N, 0N]), {}, size=200mm)"),
    ],
)
def test_elements_as_large_as_the_part_are_taken(part: str, call: str) -> None:
    """k = E A / L of a plate and of a needle, to what is held across: a platen is no deeper than a plate is thick."""
    found_ = found(call.format("E=2GPa, nu=0"), before=f"let body = {part}\n")
    sides = np.array([float(s) for s in re.findall(r"([\d.]+)mm", part)])
    axis = 2 if "compress" in call else 0
    stiffness = 2000 * np.delete(sides, axis).prod() / sides[axis]
    assert found_.numbers["stiffness"].value == pytest.approx(stiffness, rel=0.02)


def test_stress_beside_a_jump_of_the_material_is_said_to_jump() -> None:
    """Elements of 4 mm are no finer than their samples: the reason why lookups miss is another."""
    call = f"study(body, fix={HELD}, load={PUSH}, E=if body > -2mm then 2.4GPa else 0.9GPa, nu=0.38, size=4mm)"
    told = said(found(call), "W267")
    assert "stress jumps where the material does" in told
    assert "finer than" not in told


KNOWN = Got(
    elements=20_000, unknowns=100_000, iterations=60, residual=1e-9, order=2, size=1.2, finest=0, beside=1.2,
    wall=4.33, wall_x=1, wall_y=2, wall_z=3, gap=0, gap_long=0, gap_across=0, gap_tapers=0, gap_of=0,
    gap_x=0, gap_y=0, gap_z=0, area=1200, moved=0.01,
    strain=0.001, stiffest=0, densest=0, yields=0,
    lost=0, pieces=0, voxel=0.3, off=0, jumps=0, form=0,
    lacking=7.6, beyond=6.5, handles=1, holes=8, form_x=-3, form_y=6,
    form_z=1, shared=0, seam_x=0, seam_y=0, seam_z=0, numbers=tuple(1150.0 * (n == "volume") for n in NUMBERS),
    errors=(0.0,) * len(NUMBERS),
)  # fmt: skip
ERR = list(NUMBERS).index("error")


def with_error(got: Got, error: float) -> Got:
    return replace(got, numbers=tuple(error if i == ERR else n for i, n in enumerate(got.numbers)))


def test_what_is_too_coarse_is_said_once_and_only_if_it_is_so() -> None:
    assert coarse(with_error(KNOWN, 0.09)) == []
    (stresses,) = coarse(with_error(KNOWN, 0.12))
    assert stresses.message == "elements of 1.2 mm are too coarse: stresses err by about 12%"
    (walls,) = coarse(replace(KNOWN, wall=2.3))
    assert walls.message.endswith("coarse: walls 2.3 mm thick, as at (1, 2, 3), are thinner than two of them")
    (form,) = coarse(replace(KNOWN, form=0.11))
    assert "and are joined otherwise: their holes are 1 more or less than its 8" in form.message
    assert "stresses" not in form.message
    (all_of_it,) = coarse(with_error(replace(KNOWN, wall=2.3, form=0.11), 0.2))
    assert all(words in all_of_it.message for words in ("lack 7.6 mm3", "walls 2.3 mm", "stresses err"))
    assert all_of_it.hint.count("size=") == 1
    assert "stiffness may be off by 11%" in all_of_it.label


def test_no_size_is_proposed_that_cannot_be_had_or_does_not_help() -> None:
    def proposed(got: Got) -> tuple[float, float]:
        size, count = re.findall(r"`size=([\d.]+)mm` .*?some ([\d,]+) unknowns", finer(got))[0]
        return float(size), float(count.replace(",", ""))

    few = proposed(with_error(KNOWN, 0.2))
    assert 0.45 < few[0] <= 0.6  # the estimate goes by the size: half of it halves that
    large = replace(KNOWN, unknowns=400_000, numbers=tuple(30_000 * (n == "volume") for n in NUMBERS), size=2.0)
    size, count = proposed(with_error(large, 0.4))
    assert size < 2.0
    assert count < 900_000
    assert "to mend all of it takes 0.5 mm" in finer(with_error(large, 0.4))
    fine = replace(large, unknowns=790_000)
    size, count = proposed(with_error(fine, 0.12))  # nothing affordable helps: what would, and what that takes
    assert size < 2.0 / 1.2
    assert count > 790_000
    slit = finer(with_error(replace(large, gap=0.04, gap_long=20, gap_across=7, gap_of=1), 0.05))
    assert slit.startswith("to open it takes `size=0.12mm` and some ")  # nothing coarser helps
    assert slit.endswith("unknowns: leave it out, or take a part of it")
    most = replace(large, unknowns=2_000_000)
    assert "size=" not in finer(with_error(most, 0.3))
    assert "--refine" in finer(with_error(most, 0.3))


def test_elements_that_are_too_coarse_for_walls_are_called_so() -> None:
    sheet = "let body = metric(gyroid(10mm)) |> shell(WALL) & cube(20mm)\n"
    with pytest.raises(PoreError, match=r"(?s)E162.*makes two through walls of 0\.\d+ mm.*4 million are the most"):
        found(f"compress(body, 1kN, {MATERIAL}, size=2mm)", sheet.replace("WALL", "0.02mm"))
    with pytest.raises(
        PoreError, match=r"E162.*elements of 1\.8 mm are too coarse for walls 0\.\d+ mm thick, as at"
    ) as e:
        found(f"compress(body, 1kN, {MATERIAL}, size=1.8mm)", sheet.replace("WALL", "0.9mm"))
    assert "hang together" not in str(e.value)


def test_where_two_elements_through_walls_are_too_many_one_is_proposed() -> None:
    def cubes(size: float) -> float:
        return 1e6 / size**3

    assert for_walls(2.0, cubes).endswith("makes two through walls of 2 mm: some 1,000,000 unknowns")
    assert "or `size=1mm`, one element through them, some 1,000,000" in for_walls(1.0, cubes)
    assert for_walls(0.1, cubes).endswith("4 million are the most: take a part of it")


def test_elements_found_are_no_larger_than_walls_that_hold_a_part_together() -> None:
    """Of a minute's elements, larger than these walls, a mesh would be crumbs; of larger parts it is, and says so."""
    text = f"let body = gyroid(10mm) |> shell(1) & cube(42mm)\nlet s = compress(body, 1kN, {MATERIAL})"
    program = porelang.compile(f"{text}\nout part = body")
    design = program.design()
    planned = estimate(design.formula(*program.studies["s"].args))
    assert planned.wall is not None
    assert planned.size <= planned.wall.wall * (1 + 1e-9)
    assert 800_000 < planned.unknowns <= 2_500_000


def test_a_graded_mesh_says_its_sizes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "s.pore"
    file.write_text(f"{BOX}let s = study(body, fix={HELD}, load={PUSH}, {MATERIAL}, size=8mm)\nbody", encoding="utf-8")
    assert main(["fea", str(file), "--refine", "--json", "-q"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["finest_size"] < 0.8 * told["size"]
    assert main(["fea", str(file), "-q"]) == 0  # the report is the result
    told = capsys.readouterr()
    assert re.search("of 8 mm(.|\n)*stiffness", told.out)
    assert not told.err
    assert main(["fea", str(file), "-q", "-o", str(tmp_path / "s.vtu")]) == 0
    assert capsys.readouterr().out == ""


def test_what_fea_has_solved_is_not_solved_again(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "param h = 10mm in 5mm..20mm\nlet body = box([20mm, 10mm, h])\n"
    text += f"let s = compress(body, 1kN, {MATERIAL}, size=5mm)\n"
    design = porelang.compile(f"{text}out vm = s.von_mises\nout part = body").design(h=8)
    carry_out(design)
    store.forget()  # what is on disk is left
    monkeypatch.setattr("porelang.tasks.study.found.solved", None)
    again = porelang.compile(f"{text}out vm = s.von_mises\nout part = body")
    stress = again.field("vm", h=8)(np.zeros((1, 3)))[0]
    assert stress == pytest.approx(5, rel=1e-5)  # 1 kN on 200 mm2
    with pytest.raises(TypeError):  # of another height it is another study
        again.field("vm", h=9)(np.zeros((1, 3)))
