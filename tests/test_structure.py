"""Params that count and choose what is there at all, filtered lists, and presets."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import porelang
from porelang.cli import main
from porelang.elaborate import context
from porelang.refusals import structural_faults

RING = "param n = 6 in 3..12\nparam r = 2mm in 1mm..3mm\nring(translate(sphere(r), [20, 0, 0]), n)"


def codes(text: str, **settings: float | str) -> list[str]:
    with pytest.raises(porelang.PoreError) as caught:
        porelang.compile(text).design(**settings)
    return [d.code for d in caught.value.diagnostics]


def centres(n: int) -> np.ndarray:
    angles = 2 * np.pi * np.arange(n) / n
    return np.stack([20 * np.cos(angles), 20 * np.sin(angles), 0 * angles], axis=1)


@pytest.mark.parametrize("n", [3, 6, 7, 12])
def test_a_param_counts_copies(n: int) -> None:
    program = porelang.compile(RING)
    np.testing.assert_allclose(program.field(n=n, r=3)(centres(n)), -3.0, atol=1e-9)
    measured = porelang.compile(RING.replace("ring(", "let copies = ring(") + "\nx + volume(copies)")
    (volume,) = (r.value for r in measured.reduced(n=n).values())
    assert volume == pytest.approx(n * 4 / 3 * np.pi * 2**3, rel=1e-3)


def test_a_param_counts_items_and_picks_one() -> None:
    program = porelang.compile(
        "param n = 2 in 0..4\nlet sizes = [1, 2, 4, 8, 16]\n"
        "out all = sum([for i in range(n): sizes[i]])\nout one = sizes[n]\nout mean = n / 4"
    )
    for n in range(5):
        values = [program.field(name, n=n)([[0, 0, 0]])[0] for name in ("all", "one", "mean")] if n else None
        assert n == 0 or values == [2**n - 1, 2**n, n / 4]
    assert program.params["n"].structural
    assert codes("param n = 2 in 0..4\nsum([for i in range(n): x])", n=0) == ["E061"]


def test_other_params_stay_uniform() -> None:
    program = porelang.compile(RING)
    assert program.structure == {"n": 6.0}
    assert not program.params["r"].structural
    assert program.design(r=1).program is program
    assert program.design(n=9).program is program.design(n=9, r=1).program is not program


def test_nested_and_filtered_lists() -> None:
    text = "[for i in range(4) for j in range(i) if i != 2 if j > 0: [10 * i, j, 0]]"
    program = porelang.compile(f"let a = {text}\nout count = len(a)\nout total = a[0] + a[len(a) - 1] + p * 0")
    expected = [[10 * i, j, 0] for i in range(4) for j in range(i) if i != 2 if j > 0]
    assert program.field("count")([[0, 0, 0]])[0] == len(expected)
    np.testing.assert_array_equal(program.field("total")([[0, 0, 0]])[0], np.add(expected[0], expected[-1]))


def test_a_filter_may_depend_on_a_param() -> None:
    program = porelang.compile(
        "param holes = true in {true, false}\nparam least = 1 in 0..3\n"
        "len([for i in range(4) if holes and i >= least: i]) + 0 * x"
    )
    at = [[0.0, 0.0, 0.0]]
    assert program.field()(at)[0] == 3
    assert program.field(least=3)(at)[0] == 1
    assert program.field(holes=False)(at)[0] == 0


def test_choices_of_texts_lists_and_functions_of_any_kind() -> None:
    program = porelang.compile(
        'param side = "both" in {"both", "inside"}\nparam path = a in {a, b}\nparam fancy = true in {true, false}\n'
        "let a = [[0, 0, 0], [10, 0, 0]]\nlet b = [[0, 0, 0], [10, 0, 0], [10, 10, 0]]\n"
        "let part = if fancy then [for q in path: translate(sphere(1), q)] else [shell(sphere(4), 1, side=side)]\n"
        "union(part)"
    )
    assert program.bounds(path="b").hi[1] == pytest.approx(11)
    assert program.bounds(path="a").hi[1] == pytest.approx(1)
    at = [[4.2, 0.0, 0.0]]
    assert program.field(fancy=False)(at)[0] < 0 < program.field(fancy=False, side="inside")(at)[0]


def test_a_choice_among_vectors_needs_no_compiling() -> None:
    program = porelang.compile("param to = [5, 0, 0] in {[5, 0, 0], [0, 5, 0]}\ntranslate(sphere(1), to)")
    assert not program.structure
    assert program.field(to="[0, 5, 0]")([[0, 5, 0]])[0] == -1


def test_what_does_not_count() -> None:
    assert codes("param n = 2.5 in 1..6\nunion([for i in range(n): sphere(1 + i)])") == ["E063"]
    assert codes("param n = 3 in 1..6 step 0.5\nunion([for i in range(n): sphere(1 + i)])") == ["E063"]
    assert codes("param n = 3mm in 1mm..6mm\nunion([for i in range(n): sphere(1 + i)])") == ["E063"]
    assert codes("let n = volume(cube(2))\nunion([for i in range(n): sphere(1 + i)])") == ["E063"]
    assert codes("param n = 3 in 1..6\nparam m = 3 in 1..n\nsphere(n + m)") == ["E063"]  # a range is no count
    assert codes(RING, n=6.5) == ["E084"]
    assert codes(RING, n=13) == ["E085"]


def test_a_whole_param_that_counts_nothing_moves_freely() -> None:
    assert porelang.compile("param n = 6 in 3..12\nsphere(n)").field(n=6.5)([[0, 0, 0]])[0] == -6.5


def test_what_is_wrong_for_another_value_is_told_with_it() -> None:
    text = "param n = 2 in 1..6\nlet sizes = [3, 4, 5, 6]\nsphere(sizes[n])"
    with pytest.raises(porelang.PoreError, match=r"no item 6 .*, with n = 6"):
        porelang.compile(text).design(n=6)
    (found,) = structural_faults(porelang.compile(text))
    assert found.code == "E065"
    assert "n = 6" in found.message
    # all values are looked at on request: 3 alone is wrong here, and no end
    middle = "param n = 2 in 1..6\nsphere([9, 9, 9, -9, 9, 9, 9][n])"
    assert not structural_faults(porelang.compile(middle))
    assert [d.code for d in structural_faults(porelang.compile(middle), all_values=True)] == ["E064"]


def test_a_range_that_is_far_too_large_is_told_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "MOST_EXPRESSIONS", 20_000)
    program = porelang.compile("param n = 6 in 3..1000000\nunion([for i in range(n): translate(sphere(1), [i, 0, 0])])")
    assert structural_faults(program) == []
    (found,) = structural_faults(program, all_values=True)
    assert found.code == "E070"
    assert found.hint == "narrow the range of `n`"


COPIES = "box([60, 10, 10]) \\ repeat(cylinder(1, 20), [6, 100, 100], counts=[{}, 1, 1])"


def test_copies_are_whole() -> None:
    assert porelang.compile("param n = 4 in 2..10\n" + COPIES.format("n")).structure == {"n": 4.0}
    assert codes("param n = 4 in 2..10\n" + COPIES.format("n"), n=4.5) == ["E084"]
    assert codes(COPIES.format("4.5")) == ["E064"]
    assert codes("param w = 6mm in 4mm..10mm\n" + COPIES.format("60mm / w")) == ["E086"]
    # as many as fit, whatever the width: nothing is compiled for that
    fitting = porelang.compile("param w = 6mm in 4mm..10mm\n" + COPIES.format("floor(50mm / w)"))
    assert not fitting.structure
    hole = [[15.0, 0.0, 0.0]]
    assert fitting.field(w="9mm")(hole)[0] < 0 < fitting.field(w="6mm")(hole)[0]


def test_a_choice_among_lists_of_any_length() -> None:
    program = porelang.compile("param f = [1, 2] in {[1, 2], [3, 4, 5]}\nunion([for r in f: sphere(r)])")
    assert program.bounds().hi[0] == pytest.approx(2)
    assert program.bounds(settings={"f": [3, 4, 5]}).hi[0] == pytest.approx(5)  # type: ignore[dict-item]  # as a user might
    assert program.bounds(f="[3,4,5]").hi[0] == pytest.approx(5)


def test_a_preset_reads_no_param() -> None:
    head = "param n = 3 in 1..9\nparam k = 2 in 1..20\nlet m = len([for i in range(n): i])\n"
    for value in ("2 * n", "m", "if n > 5 then 10 else 1", "k"):
        assert codes(head + f'preset "a": n = 4, k = {value}\nring(translate(sphere(k), [50, 0, 0]), n)') == ["E063"]


def test_variants_are_pickled_and_copied() -> None:
    design = porelang.compile(RING).design(n=9)
    again = pickle.loads(pickle.dumps(design))
    assert again.settings == design.settings
    np.testing.assert_allclose(again.field()(centres(9)), -2.0, atol=1e-9)
    assert copy.deepcopy(design).program.structure == {"n": 9.0}
    assert pickle.loads(pickle.dumps(design.program)).design(n=4).program.structure == {"n": 4.0}


def test_a_used_file_may_count(tmp_path: Path) -> None:
    (tmp_path / "parts.pore").write_text(
        "param n = 4 in 2..8\nlet row = union([for i in range(n): sphere(1) @ (p - [3 * i, 0, 0])])\n"
    )
    (tmp_path / "main.pore").write_text('use "parts.pore" as parts\npreset "long": parts.n = 8\nparts.row\n')
    program = porelang.compile(path=tmp_path / "main.pore")
    assert program.structure == {"parts.n": 4.0}
    assert program.bounds(preset="long").hi[0] == pytest.approx(22)
    assert program.bounds(settings={"parts.n": 2}).hi[0] == pytest.approx(4)


# ---- presets

PRESETS = """
param w = 30mm in 4mm..60mm
param t = 0.8 in 0.1..1.5
param n = 3 in 3..12
param kind = gyroid in {gyroid, diamond}
preset "fine": w = 1cm, t = 40%,
  kind = diamond
preset "ring of five": n = 5
kind(w) |> shell(t) & ring(translate(sphere(20), [40, 0, 0]), n)
"""


def test_presets_are_settings_by_name() -> None:
    program = porelang.compile(PRESETS)
    assert program.presets == {"fine": {"w": 10.0, "t": 0.4, "kind": "diamond"}, "ring of five": {"n": 5.0}}
    assert dict(program.design(preset="fine").settings) == {"w": 10.0, "t": 0.4, "n": 3.0, "kind": 1.0}
    assert program.design(preset="fine", w=12).settings["w"] == 12
    assert program.design({"t": 1.0}, preset="ring of five").program.structure == {"n": 5.0}
    assert program.field(preset="fine")([[41, 2, 3]])[0] == program.field(w=10, t=0.4, kind="diamond")([[41, 2, 3]])[0]
    with pytest.raises(porelang.PoreError, match="did you mean `fine`"):
        program.design(preset="fin")


def test_preset_is_a_word_only_in_its_place() -> None:
    assert porelang.compile("let preset = 4\ndef f(preset) = preset + 1\nsphere(preset + f(1))").bounds().hi[0] == 6


def test_presets_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.pore"
    file.write_text(PRESETS.replace("kind(w) |> shell(t) & ", ""))
    assert main(["measure", str(file), "--preset", "ring of five", "--resolution", "48", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["solid_components"] == 5
    assert main(["measure", str(file), "--preset", "ring of six"]) == 2
    assert "did you mean `ring of five`" in capsys.readouterr().err


def test_check_looks_at_both_ends(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.pore"
    file.write_text("param n = 2 in 1..6\nlet sizes = [3, 4, 5, 6]\nsphere(sizes[n])\n")
    for more in ([], ["--measure"]):  # once: an end that does not compile is no part of which something is wrong
        assert main(["check", str(file), *more]) == 1
        told = capsys.readouterr().err
        assert "with n = " in told
        assert told.count("there is no item") == 1
    file.write_text("param n = 2 in 1..6\nsphere(5) & translate(sphere(5), [len([for i in range(n): i]) * 2, 0, 0])\n")
    assert main(["check", str(file), "--measure"]) == 0
    assert "with `n` = 6" in capsys.readouterr().err  # a part that is empty there


# ---- smooth unions of lists


def test_a_smooth_union_of_a_list_does_not_depend_on_its_order() -> None:
    points = np.random.default_rng(1).uniform(-10, 25, (2000, 3))
    balls = [f"translate(sphere(5), [{7 * i}, {i}, 0])" for i in range(4)]
    several = [porelang.compile(f"smooth_union([{', '.join(b)}], 3)").field()(points) for b in (balls, balls[::-1])]
    distances = np.stack([np.linalg.norm(points - [7 * i, i, 0], axis=1) - 5 for i in range(4)])
    k = 3 / (4 * np.log(2))
    np.testing.assert_allclose(several[0], -k * np.log(np.exp(-distances / k).sum(axis=0)), atol=1e-12)
    np.testing.assert_allclose(several[0], several[1], atol=1e-12)


def test_a_smooth_union_of_a_list_keeps_its_words() -> None:
    at = [[0.0, 0.0, 0.0]]
    value = lambda text: porelang.compile(text).field()(at)[0]  # noqa: E731
    assert value("smooth_union([x, x], 8)") == pytest.approx(-2)  # r/4 where two are equal
    assert value("smooth_union([x, y, z], r=8)") == pytest.approx(-8 / 4 * np.log2(3))
    assert value("smooth_intersection([x, y, z], 8)") == pytest.approx(8 / 4 * np.log2(3))
    for d in (4.0, 8.0, 16.0):  # another at the distance d
        assert -0.361 * 8 / 16 ** (d / 8) < value(f"smooth_union([x, x + {d}], 8)") < 0
    box = porelang.compile("smooth_union([for i in range(3): translate(sphere(5), [20 * i, 0, 0])], 2)").bounds()
    assert box.hi[0] == pytest.approx(45, abs=1.2)
