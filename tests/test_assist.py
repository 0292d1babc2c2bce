"""What is told of a place in a text: names, completions, calls, values, the outline."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from porelang.assist import complete, names, outline
from porelang.assist.calls import signature_at
from porelang.assist.hover import hover
from porelang.diagnostics import PoreError
from porelang.session import Session, Snapshot
from porelang.source import Span

PROGRAM = """\
# cells between two plates
# of which one is curved
param w = 12mm in 8mm..20mm  "cell"
param kind = gyroid in {gyroid, iwp}
let body = cube(30mm)
let k = w * 2 + 1cm
let turned = kind(w) @ [y, x, z]
## Walls of a lattice.
## Gives: a distance
## Example: walls(gyroid(9), 1)
def walls(f, t: length where t > 0,
          more = t) = {
  let d = metric(f)
  [for t in [t, more]: d |> shell(t)][0]
}
let twice = (t, u) => t * u
let thin = walls(gyroid(w), t=1mm) & body
preset "fine": w = 9mm
out part = thin | sphere(twice(k, 1) / 9)
"""


def snapshot(text: str = PROGRAM, **files: str) -> Snapshot:
    session = Session(folder="")
    for name, more in files.items():
        session.workspace.open(f"{name}.pore", more)
    return session.update("a.pore", text)


def at(of: str, more: int = 0, text: str = PROGRAM) -> int:
    assert text.count(of) == 1, of
    return text.index(of) + more


def told(spans: list[Span]) -> list[tuple[int, int]]:
    return [(span.line, span.column) for span in spans]


# ---- names ----------------------------------------------------------------------------------------------------------


def test_all_uses_of_a_name_stand_for_the_same() -> None:
    one = snapshot()
    assert told(names.references(one, at("w * 2"))) == [(3, 7), (6, 9), (7, 19), (17, 25), (18, 16)]
    # a parameter, the item of a comprehension and the parameter of a function are three things of one name
    assert told(names.references(one, at("t > 0"))) == [(11, 14), (11, 30), (12, 18), (14, 14), (17, 29)]
    assert told(names.references(one, at("for t in", 4))) == [(14, 8), (14, 35)]
    assert told(names.references(one, at("t * u"))) == [(16, 14), (16, 23)]
    assert names.references(one, at("12mm")) == []


def test_a_name_leads_to_where_it_is_bound() -> None:
    one = snapshot()
    asked = at("k, 1"), at("walls(gyroid(w)", 2), at("d |> shell")
    places = [names.definition(one, offset) for offset in asked]
    assert [p and (p.line, p.column) for p in places] == [(6, 5), (11, 5), (13, 7)]
    prelude = names.definition(one, at("metric(f)"))
    assert prelude is not None
    assert (prelude.source.name, prelude.text) == ("prelude/metric.pore", "metric")
    assert names.definition(one, at("30mm")) is None


def test_names_of_a_used_file_are_known_by_their_dots() -> None:
    text = 'use "plates.pore" as plates\nplates.ring(plates.t)\n'
    one = snapshot(text, plates="let t = 2mm\ndef ring(r) = torus(9, r)\n")
    where = names.definition(one, text.index("ring(") + 1)
    assert where is not None
    assert (where.source.name, where.line, where.column) == ("plates.pore", 2, 5)
    bound = names.use_at(one, text.index("t)")).bound  # type: ignore[union-attr]  # it is there
    assert bound is not None
    assert told(names.uses_of(one, bound)) == [(2, 20)]
    with pytest.raises(PoreError, match="is bound in `plates"):
        names.renamed(one, text.index("ring(") + 1, "annulus")


def test_a_name_of_a_used_file_is_changed_in_presets_and_arguments_too() -> None:
    lib = "param t = 2mm in 1mm..4mm\ndef wall(f, thick = 1mm) = shell(f, thick)\n"
    text = (
        'use "plates.pore" as plates\nlet g = plates.wall\nlet a = g(sphere(9), thick=2mm)\n'
        'preset "thin": plates.t = 1mm\nout part = a & plates.wall(cube(20), thick=plates.t)\n'
    )
    session = Session(folder="")
    session.workspace.open("plates.pore", lib)
    user, used = session.update("a.pore", text), session.update("plates.pore", lib)

    def changed(of: str, name: str) -> str:
        use = names.use_at(used, lib.index(of))
        assert use is not None
        assert use.bound is not None
        out = text
        for span in sorted(names.uses_of(user, use.bound), key=lambda s: -s.start):
            out = out[: span.start] + name + out[span.end :]
        return out

    for of, name in (("t = 2mm", "size"), ("thick", "wide"), ("wall", "skin")):
        session.workspace.open("plates.pore", re.sub(rf"\b{of.split()[0]}\b", name, lib))
        assert [str(d) for d in session.update("a.pore", changed(of, name)).diagnostics] == []
    session.workspace.open("plates.pore", lib)
    user = session.update("a.pore", text)
    assert told(names.renamed(user, text.index("plates\n"), "pl")) == [(1, 22), (2, 9), (4, 16), (5, 16), (5, 44)]


def test_a_name_is_not_changed_where_a_use_of_it_would_be_left() -> None:
    broken = "let a = w + (\nparam w = 8mm in 4mm..9mm\nlet q = w + 1\n"
    with pytest.raises(PoreError, match=r"line 1 of `a\.pore` has `w` in it"):
        names.renamed(snapshot(broken), broken.index("w = 8"), "wide")
    last = 'check volume(part) > 1, "m"\nsphere(3)\n'
    with pytest.raises(PoreError, match="what the last expression of a file is called"):
        names.renamed(snapshot(last), last.index("part"), "wide")
    other = "def f(a) = a\nlet g = f\ng(a=3)\n"
    assert told(names.renamed(snapshot(other), other.index("a)"), "b")) == [(1, 7), (1, 12), (3, 3)]


def test_a_name_is_followed_through_files() -> None:
    """Behind two dots, and of a let of a used file that stands for a def of that file, not of the user's."""
    lib = "def ball(r: length) = sphere(r)\nlet g = ball\nlet size = 3\n"
    middle = 'use "lib.pore" as plates\n'
    text = (
        'use "middle.pore" as mm\nuse "lib.pore" as plates\ndef ball(r: length, q: length = 2mm) = sphere(r + q)\n'
        "out part = plates.g(r=2mm) | ball(r=mm.plates.size) | mm.plates.g(r=1mm)\n"
    )
    session = Session(folder="")
    session.workspace.open("lib.pore", lib)
    session.workspace.open("middle.pore", middle)
    user, used = session.update("a.pore", text), session.update("lib.pore", lib)
    for of, wanted in (("size", [(4, 47)]), ("r: length", [(4, 21), (4, 67)])):
        use = names.use_at(used, lib.index(of))
        assert use is not None
        assert use.bound is not None
        assert told(names.uses_of(user, use.bound)) == wanted
    assert told(names.renamed(user, text.index("r: length"), "s")) == [(3, 10), (3, 47), (4, 35)]


def test_a_parameter_of_a_lambda_is_changed_where_it_is_named() -> None:
    text = "let f = (u) => u + 1\nf(u=2)\n"
    assert told(names.renamed(snapshot(text), text.index("u)"), "v")) == [(1, 10), (1, 16), (2, 3)]


@pytest.mark.parametrize(
    "text", ["let b = { let kk = 3; let jj = j", "let q = [for i in range(3) for j in [j", "let jj = j"]
)
def test_what_is_being_bound_is_not_offered(text: str) -> None:
    assert not {"j", "jj"} & {i.text for i in complete.completions(snapshot(text), len(text))}


def test_a_preset_sets_params_and_nothing_else() -> None:
    lib = "param t = 2mm in 1mm..4mm\nlet v = 3\n"
    text = 'use "plates.pore" as plates\nparam w = 8mm in 4mm..9mm\npreset "thin": '
    for more, wanted in (("", True), ("pla", True), ("plates.", True), ("w = 5mm, ", True), ("w = ", False)):
        found = complete.completions(snapshot(text + more, plates=lib), len(text + more))
        assert ([i.text for i in found] == ["plates.t", "w"]) is wanted
        assert {i.start for i in found if wanted} <= {len(text), len(text) + len("w = 5mm, ")}


@pytest.mark.parametrize(
    "text", ["let q = [for i in range(3): i", "let h = i => i", "def f(i) = i", "let b = { let i = 3\n i"]
)
def test_an_inner_name_is_offered_once(text: str) -> None:
    found = [i.text for i in complete.completions(snapshot(text), len(text))]
    assert found.count("i") == 1


def test_a_name_is_changed_where_it_stands_for_the_same() -> None:
    one = snapshot()
    text = PROGRAM
    for span in sorted(names.renamed(one, at("t > 0"), "wall"), key=lambda s: -s.start):
        text = text[: span.start] + "wall" + text[span.end :]
    other = snapshot(text)
    assert [str(d) for d in other.diagnostics] == []
    assert one.program is not None
    assert other.program is not None
    assert one.program.graph.roots == other.program.graph.roots
    for name, why in (
        ("body", "something else"),
        ("2x", "no name"),
        ("x", "something else"),
        ("metric", "as the language"),
        ("if", "no name"),
    ):
        with pytest.raises(PoreError, match=why):
            names.renamed(one, at("w * 2"), name)
    with pytest.raises(PoreError, match="language's own"):
        names.renamed(one, at("metric(f)"), "distance")


# ---- what is said of a place ----------------------------------------------------------------------------------------


def said(of: str, more: int = 0) -> str:
    found = hover(snapshot(), at(of, more))
    assert found is not None
    return found.markdown


def test_a_number_is_told_with_its_unit() -> None:
    assert "a length: 34mm with the params at their defaults" in said("k, 1")
    assert "1cm = 10mm" in said("1cm", 1)
    assert "param w = 12mm in 8mm..20mm\n" in said("w * 2")
    assert said("w * 2").endswith("cell")


def test_a_field_is_told_with_how_far_it_reaches() -> None:
    _, reach, steep = said("& body", 2).split("\n\n")[1].split("  \n")
    low, _, high, where = reach.split(" ", 3)
    assert (where, steep) == ("in the part, as samples show", "it rises by 1 in each mm, 1 at most")
    assert -15 <= float(low) < -13  # of a cube of 30 mm
    assert -0.2 < float(high) <= 0


def test_a_number_found_from_a_field_is_told_with_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("porelang.assist.hover.SECONDS", 60.0)  # on a machine that has much else to do
    text = "let body = cube(20mm)\nlet share = porosity(sphere(8), body)\nsphere(8) & body\n"
    found = hover(snapshot(text), text.index("share"))
    assert found is not None
    (line,) = found.lines
    kind, _, number = line.partition(": ")
    value, error = (float(part) for part in number.split(" +- "))
    assert kind == "a ratio"
    assert value == pytest.approx(1 - 4 / 3 * np.pi * 512 / 8000, abs=error)
    assert 0 < error < 0.01


def test_a_function_is_told_with_what_it_takes() -> None:
    text = said("walls(gyroid(w)", 2)
    assert "def walls(f, t: length where t > 0, more = t)" in text
    assert "Walls of a lattice." in text
    assert "walls(gyroid(9), 1)" in text
    assert "Gives" not in text
    assert "gyroid(w: period or phase: vector = p / w)" in said("gyroid(w), t")


def test_a_call_is_told_while_it_is_written() -> None:
    cases = {
        "let a = walls(": ("walls", 0),
        "let a = walls(f, 1mm, ": ("walls", 2),
        "let a = walls(f, [1, 2, (": ("walls", 1),
        "let a = walls(f, max(1mm, ": ("max", 1),
        "let a = gyroid(w) |> walls(": ("walls", 1),
        "let a = walls(more=": ("walls", 2),
        "let a = walls(f, 1mm)": None,
        "let a = nothing(": None,
    }
    for more, wanted in cases.items():
        text = PROGRAM + more
        found = signature_at(snapshot(text), len(text))
        assert (found and (found[0].name, found[1])) == wanted, more


# ---- completions ----------------------------------------------------------------------------------------------------


def offered(more: str, folder: str = "", **files: str) -> list[complete.Item]:
    text = PROGRAM + more
    return complete.completions(snapshot(text, **files), len(text), folder)


def labels(items: list[complete.Item]) -> list[str]:
    return [item.label for item in items]


def test_names_are_offered_nearest_first() -> None:
    found = offered("let a = ")
    assert {"body", "k", "walls", "twice", "kind", "gyroid", "if"} <= set(labels(found))
    assert labels(found).index("walls") < labels(found).index("gyroid")
    inner = offered("def f(radius, h = 2) = [for i in range(3): (t => ")
    assert labels(inner)[:4] == ["h", "i", "radius", "t"]
    item = next(i for i in found if i.label == "walls")
    assert (item.what, item.detail) == ("function", "walls(f, t: length where t > 0, more = t)")


def test_a_word_that_was_begun_is_replaced() -> None:
    item = next(i for i in offered("let a = gyr") if i.label == "gyroid")
    assert (item.start, item.end) == (len(PROGRAM) + 8, len(PROGRAM) + 11)


def test_what_fits_is_offered() -> None:
    assert labels(offered("let a = 3"))[:2] == ["um", "mm"]
    assert labels(offered("let a = 2.5m"))[:2] == ["um", "mm"]
    assert "cell1" in labels(offered("let cell1 = 3mm\nlet a = cell1"))  # the digit is of a name
    assert labels(offered("let v = [1, 2, 3]\nlet a = v.")) == ["x", "y", "z"]
    assert labels(offered("let a = conventions.")) == ["axolotl"]
    assert "gyroid" in labels(offered("let a = conventions.axolotl."))
    assert labels(offered("let a = walls(gyroid(w), "))[:2] == ["more=", "t="]
    assert labels(offered("let a = walls(gyroid(w), t=2mm, "))[:2] == ["f=", "more="]
    assert "length" in labels(offered("def g(a: "))
    assert labels(offered("\n"))[:3] == ["check", "def", "let"]
    assert offered("let a = 1 # so ") == []
    assert labels(
        offered('use "plates.pore" as plates\nlet a = plates.', plates="let t = 2mm\ndef ring(r) = torus(r, t)\n")
    ) == ["t", "ring"]


def test_what_is_being_bound_is_not_offered_and_the_words_of_an_argument_are() -> None:
    text = "let gyre = gy"
    found = complete.completions(snapshot(text), len(text), "")
    assert "gyre" not in labels(found)
    assert "gyroid" in labels(found)
    text = 'shell(gyroid(10), 1, side="'
    assert labels(complete.completions(snapshot(text), len(text), "")) == ["both", "inside", "outside"]


def test_files_and_the_arrays_in_them_are_offered(tmp_path: Path) -> None:
    folder = tmp_path
    (folder / "more").mkdir()
    (folder / "part.stl").write_text("")
    np.savez(folder / "stress.npz", mises=np.zeros((2, 2, 2)), origin=np.zeros(3), spacing=np.ones(3))
    (folder / "a.vtu").write_text(
        '<VTKFile><DataArray type="Float64" Name="U" NumberOfComponents="3">0</DataArray>'
        '<DataArray Name="connectivity"/></VTKFile>'
    )
    assert labels(offered('let a = load("', str(folder))) == ["a.vtu", "more/", "stress.npz"]
    assert labels(offered('let a = mesh("', str(folder))) == ["more/", "part.stl"]
    assert {"mises"} <= set(labels(offered('let a = load("stress.npz", "', str(folder))))
    (item,) = offered('let a = load("a.vtu", "', str(folder))
    assert (item.label, item.detail) == ("U", "a vector")
    assert offered('let a = load("nothing.vtu", "', str(folder)) == []
    text = 'let a = load("'  # in a folder of the one that is open: beside the program, as it is loaded
    (folder / "more" / "b.vtu").write_text("")
    inner = Session(folder=str(folder)).update(str(folder / "more" / "c.pore"), text)
    assert labels(complete.completions(inner, len(text), str(folder))) == ["b.vtu"]
    assert "PA12" in labels(offered('let s = compress(body, force=1kN, axis=z, material="'))


# ---- the outline ----------------------------------------------------------------------------------------------------


def test_the_outline() -> None:
    one = snapshot()
    found = outline.symbols(one)
    assert [(s.name, s.what) for s in found][:4] == [("w", "param"), ("kind", "param"), ("body", "let"), ("k", "let")]
    assert [s.detail for s in found if s.name == "walls"] == ["(f, t, more)"]
    assert outline.folds(one) == [(1, 2, "comment"), (8, 10, "comment"), (11, 15, "region")]
    assert list(outline.hints(one)) == [(at("+ 1cm", 5), "= 34mm")]


def test_each_token_has_its_kind() -> None:
    one = snapshot()
    found = {PROGRAM[s.start : s.start + s.length]: (s.word, s.more) for s in outline.semantic(one)}
    assert found["gyroid"] == ("function", ("defaultLibrary",))
    assert found["thin"][0] == "variable"
    assert found["length"] == ("type", ())
    assert found["preset"] == ("keyword", ())
    assert found["## Gives: a distance"] == ("comment", ("documentation",))
    broken = outline.semantic(snapshot("let a = (\nlet b = 3mm"))
    assert [s.word for s in broken] == ["keyword", "variable", "operator", "keyword", "variable", "operator", "number"]
