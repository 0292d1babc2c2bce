"""The session: every edit gives what compiling afresh would, at the cost of what it changed; jobs of which the latest
wins."""

from __future__ import annotations

import random
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from porelang.compiler import Memory, compiled
from porelang.elaborate import context
from porelang.elaborate.values import Scalar
from porelang.ir import constant
from porelang.progress import CancelledError, tell
from porelang.rewrites import flatten
from porelang.session import Jobs, Session, Snapshot, Workspace
from porelang.source import Source
from porelang.syntax.parse import BLANKS

ROOT = Path(__file__).parent.parent

#: A program with most of what a statement can depend on: defs that call each other, contracts, structure, a preset,
#: checks, suspicions, numbers found from fields, an output that is referred to.
PROGRAM = """\
param w = 12mm in 8mm..20mm "cell"
param n = 3 in 2..6
param kind = gyroid in {gyroid, schwarz_p}
## Walls of a lattice.
def walls(f, t: length where t > 0) = metric(f) |> shell(t)
def twice(f, d = 4mm) = f | (f |> translate([d, 0, 0]))
let body = cube(30mm)
let cells = kind(w)
let thin = walls(cells, 1mm) & body
let rods = union([for i in range(n): capsule([i * 5mm, 0, -9mm], [i * 5mm, 0, 9mm], 1mm + i * 0.1mm)])
let grown = offset(sphere(9), x / 4 + 2)
let d = to_porosity(cells, 60%, body)
def unused(a, b: angle = 20deg) = rotate(a, [0, 0, 1], b) & walls(a, 2mm)
preset "fine": w = 9mm, n = 4
check w > 2 * n * 1mm, "cells are too small"
out skin = twice(thin) \\ rods
skin | grown | offset(cells, d) & body
"""
USER = """\
use "lib/parts.pore" as parts
param r = 5mm in 1mm..9mm
parts.ring(r) | sphere(parts.t) | plate
let plate = box([r, r, 1])
"""
PARTS = "param t = 2mm in 1mm..3mm\nlet half = t / 2\ndef ring(r) = torus(r, half)\n"


def told(snapshot: Snapshot) -> list[str]:
    return [str(d) for d in snapshot.diagnostics]


def edits(text: str, many: int, seed: int) -> Iterator[str]:
    """Texts as they come about while somebody writes: lines cut short, changed, taken out, doubled, moved."""
    chance = random.Random(seed)
    lines = text.split("\n")
    for _ in range(many):
        before, i = list(lines), chance.randrange(len(lines))
        line = lines[i]
        match chance.randrange(8):
            case 0:
                lines[i] = line[: chance.randrange(len(line) + 1)]
            case 1:
                lines[i] = line.replace(chance.choice("123456789"), chance.choice("0123456789"), 1)
            case 2:
                lines[i] = line.replace("mm", chance.choice(["", "cm", "deg"]), 1)
            case 3:
                lines[i] = line + "  # a remark"
            case 4:
                lines.insert(i, line)
            case 5:
                lines.insert(chance.randrange(len(lines)), lines.pop(i))
            case 6:
                at = chance.randrange(len(line) + 1)
                lines[i] = line[:at] + chance.choice(["(", ")", "x", " + 1mm", "|", '"', "{", "\n"]) + line[at:]
            case _:
                names = [word for word in ("w", "cells", "body", "walls", "thin", "n", "r", "plate") if word in line]
                other = chance.choice(["body", "w", "walls", "q"])
                lines[i] = line.replace(chance.choice(names), other) if names else ""
        yield "\n".join(lines)
        if chance.random() < 0.75:  # most mistakes are mended at once
            lines = before


def same_as_afresh(path: str, snapshot: Snapshot, session: Session) -> None:
    afresh = compiled(snapshot.source, session.workspace.used, "")
    assert told(snapshot) == [str(d) for d in afresh.diagnostics], snapshot.source.text
    assert (snapshot.program is None) == (afresh.program is None)
    if snapshot.program is not None and afresh.program is not None:
        ours, theirs = snapshot.program, afresh.program
        assert ours.graph.roots == theirs.graph.roots, snapshot.source.text
        assert [*ours.params.items()] == [*theirs.params.items()] or str(ours.params) == str(theirs.params)
        assert list(ours.elaborated.presets) == list(theirs.elaborated.presets)
        assert [str(s.span) for s in ours.elaborated.suspicions] == [str(s.span) for s in theirs.elaborated.suspicions]
        assert [str(s) for _, s in ours.elaborated.tasks] == [str(s) for _, s in theirs.elaborated.tasks]


@pytest.mark.parametrize("seed", range(2))
def test_every_edit_gives_what_compiling_afresh_gives(seed: int) -> None:
    session = Session(folder="")
    for text in edits(PROGRAM, 20, seed):
        same_as_afresh("part.pore", session.update("part.pore", text), session)


def test_edits_of_a_used_file_are_seen_by_its_users() -> None:
    session = Session(folder="")
    session.workspace.open("lib/parts.pore", PARTS)
    session.update("part.pore", USER)
    for part, user in zip(edits(PARTS, 20, 5), edits(USER, 20, 6), strict=True):
        same_as_afresh("lib/parts.pore", session.update("lib/parts.pore", part), session)
        assert "part.pore" in session.users("lib/parts.pore") or 'use "lib/parts.pore"' not in user
        same_as_afresh("part.pore", session.update("part.pore"), session)
        same_as_afresh("part.pore", session.update("part.pore", user), session)
        session.update("part.pore", USER)


@pytest.mark.parametrize("name", ["grip", "types", "closed_loop", "coordinates"])
def test_examples_are_edited(name: str) -> None:
    text = (ROOT / "examples" / f"{name}.pore").read_text()
    session = Session(folder=str(ROOT))
    for edited in edits(text, 10, 7):
        snapshot = session.update(f"examples/{name}.pore", edited)
        afresh = compiled(snapshot.source, session.workspace.used, str(ROOT))
        assert told(snapshot) == [str(d) for d in afresh.diagnostics], edited


def test_only_what_depends_on_an_edit_is_evaluated_again(monkeypatch: pytest.MonkeyPatch) -> None:
    evaluated: list[str] = []
    evaluate = context.Context.evaluate

    def counted(ctx: context.Context, t: context.tree.Expr, scope: context.Scope) -> context.Value:
        evaluated.append(t.span.text)
        return evaluate(ctx, t, scope)

    monkeypatch.setattr(context.Context, "evaluate", counted)
    session = Session(folder="")
    text = "let a = 1 + 2\nlet b = a * 3\nlet c = 7 + 8\nsphere(c) | cube(9)\n"
    session.update("a.pore", text)
    evaluated.clear()
    session.update("a.pore", text.replace("7 + 8", "7 + 8  # mm").replace("let a", "\n\nlet a"))
    assert evaluated == []  # remarks and places are nothing that a value is made of
    session.update("a.pore", text.replace("* 3", "* 4"))
    assert evaluated == ["a * 4", "a", "4"]
    evaluated.clear()
    session.update("a.pore", text.replace("1 + 2", "5").replace("* 3", "* 4"))
    assert evaluated == ["5", "a * 4", "a", "4"]


def test_places_are_those_of_the_text_as_it_is_now() -> None:
    session = Session(folder="")
    wrong = "let a = sphere(3)\nlet b = a + nothing\na"
    (before,) = session.update("a.pore", wrong).diagnostics
    assert (before.span and before.span.line, before.span and before.span.column) == (2, 13)
    snapshot = session.update("a.pore", "# above\n\n" + wrong)
    (after,) = snapshot.diagnostics
    assert after.span is not None
    assert (after.span.line, after.span.column, after.span.in_file.text) == (4, 13, "nothing")
    assert "4 | let b = a + nothing" in str(after)
    # a warning that was found before the edit is told where its text is now
    doubtful = "sphere(3) \\ translate(sphere(1), [9, 0, 0])"
    moved = session.update("b.pore", doubtful).program
    assert moved is not None
    session.update("b.pore", "# above\n" + doubtful)
    (said,) = moved.warnings
    assert said.span is not None
    assert said.span.line == 2


def test_there_is_always_a_snapshot_and_the_last_good_program() -> None:
    session = Session(folder="")
    good = session.update("a.pore", "param r = 3mm in 1mm..5mm\nsphere(r)").program
    assert good is not None
    for text in (
        "",
        "(",
        "let",
        '"',
        "\x00\x01",
        "let a = {\n",
        "out part = part",
        "#",
        "param r = 3mm in 1mm..5mm\nsphere(q)",
    ):
        assert session.update("a.pore", text).good is good
    mended = session.update("a.pore", "sphere(4)")
    assert mended.good is mended.program
    assert mended.version == 11


def test_what_values_show_is_asked_for_apart() -> None:
    session = Session(folder="")
    snapshot = session.update("a.pore", "sphere(3) \\ translate(sphere(1), [9, 0, 0])")
    assert told(snapshot) == []
    assert [d.code for d in snapshot.all_diagnostics] == ["W203"] or snapshot.all_diagnostics


def test_an_expression_has_its_value() -> None:
    session = Session(folder="")
    snapshot = session.update("a.pore", "let t = 1cm / 4\n\nlet u = sphere(t * 2)\nu")
    at = snapshot.source.text.index("t * 2") + 1
    *_, product, name = snapshot.expressions_at(at - 1)
    assert (product.span.text, name.span.text) == ("t * 2", "t")
    values = [snapshot.value(e) for e in (product, name)]
    assert [constant(flatten(v.node)[0]) for v in values if isinstance(v, Scalar)] == [5.0, 2.5]
    assert snapshot.expressions_at(17) == []  # an empty line
    listed = session.update("b.pore", "[for i in range(3) if i > 0: sphere(i)]")
    for at in range(len(listed.source.text)):
        assert listed.expressions_at(at)
    assert [e.span.text for e in listed.expressions_at(11)][-1] == "range"


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.pore")), ids=lambda p: p.stem)
def test_tokens_are_all_that_is_written(path: Path) -> None:
    snapshot = Session(folder=str(ROOT)).update(str(path))
    text, written = snapshot.source.text, []
    for token in snapshot.tokens:
        assert text[token.start : token.start + len(token.text)] == token.text
        written.append(token.text)
    assert "".join("".join(written).split()) == "".join("".join(c for c in text if c not in BLANKS).split())


def test_a_program_is_as_large_as_it_may_be_whether_or_not_it_was_edited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "MOST_EXPRESSIONS", 900)
    lists = "".join(f"let l{i} = [for j in range(20): j + {i}]\n" for i in range(9))
    memory, enough = Memory(), lists + "sphere(3)"
    assert compiled(Source("a", enough), memory=memory).diagnostics == ()
    more = lists + "let more = [for j in range(90): j * 2]\nsphere(3)"
    told_again = [str(d) for d in compiled(Source("a", more), memory=memory).diagnostics]
    assert "E070" in told_again[0]
    assert told_again == [str(d) for d in compiled(Source("a", more)).diagnostics]
    assert compiled(Source("a", enough), memory=memory).diagnostics == ()


def test_lists_that_are_too_long_together_are_told_before_they_are_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the first list is filtered, or the second depends on it, once enough has been computed."""
    steps: list[int] = []
    spend = context.Context.spend
    monkeypatch.setattr(context.Context, "spend", lambda *a: (steps.append(1), spend(*a))[1])
    monkeypatch.setattr(context, "MOST_EXPRESSIONS", 5000)
    for clauses, most in (
        ("for i in range(80) for j in range(80)", 300),
        ("for i in range(80) if i >= 0 for j in range(80)", 5200),
        ("for i in range(80) for j in range(i + 40)", 5200),
    ):
        steps.clear()
        (found,) = compiled(Source("a", f"union([{clauses}: sphere(1 + i + j)])")).diagnostics
        assert found.code == "E070"
        assert len(steps) < most
    # lists that become shorter, or are left out, are not 40 x 40
    monkeypatch.setattr(context, "MOST_EXPRESSIONS", 1500)
    for clauses in ("for i in range(40) for j in range(40 - 4 * i)", "for i in range(40) if i < 2 for j in range(40)"):
        told = compiled(Source("a", f"let list = [{clauses}: j]\nsphere(len(list))")).diagnostics
        assert told == ()


# ---- the workspace --------------------------------------------------------------------------------------------------


def test_an_unsaved_text_stands_over_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.pore"
    path.write_text("sphere(1)")
    workspace = Workspace()
    assert workspace.source(str(path)).text == "sphere(1)"
    workspace.open(str(path), "sphere(2)")
    assert workspace.source(f"{tmp_path}/./a.pore").text == "sphere(2)"
    path.write_text("sphere(3)")
    assert workspace.source(str(path)).text == "sphere(2)"
    workspace.close(str(path))
    assert workspace.source(str(path)).text == "sphere(3)"


# ---- jobs -----------------------------------------------------------------------------------------------------------


def test_the_latest_job_wins() -> None:
    jobs, at_work, most, began = Jobs(), [0], [0], threading.Event()
    lock = threading.Lock()

    def work(name: str, wait: bool) -> str:
        with lock:
            at_work[0] += 1
            most[0] = max(most[0], at_work[0])
        began.set()
        try:
            while wait:
                tell(1, 2)
        finally:
            with lock:
                at_work[0] -= 1
        return name

    first = jobs.submit("picture", lambda: work("first", True))
    assert began.wait(10)
    waiting = [jobs.submit("picture", lambda: work("later", True)) for _ in range(5)]
    last = jobs.submit("picture", lambda: work("last", False))
    other = jobs.submit("mesh", lambda: "mesh")
    assert last.result(10) == "last"
    assert other.result(10) == "mesh"
    for job in (first, *waiting):
        with pytest.raises(CancelledError):
            job.result(10)
    assert most[0] == 1


def test_what_goes_wrong_in_a_job_is_told_to_who_asks() -> None:
    jobs, seen = Jobs(), []

    def work() -> None:
        tell(1, 3)
        raise ValueError("wrong")

    job = jobs.submit("a", work, lambda what, done, total: seen.append((what, done, total)))
    with pytest.raises(ValueError, match="wrong"):
        job.result(10)
    assert (job.done, seen) == (True, [("working", 1, 3)])
    jobs.cancel()
    assert jobs.submit("a", lambda: 4).result(10) == 4


def test_threads_edit_side_by_side() -> None:
    session, wrong = Session(folder=""), []

    def write(name: str, seed: int) -> None:
        try:
            for text in edits(PROGRAM, 8, seed):
                same_as_afresh(name, session.update(name, text), session)
        except BaseException as error:
            wrong.append(error)

    threads = [threading.Thread(target=write, args=(f"{i}.pore", i)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
