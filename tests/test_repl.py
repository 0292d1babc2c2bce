"""The REPL: what a line comes to, through a pipe and at a terminal."""

from __future__ import annotations

import subprocess
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from prompt_toolkit.application import create_app_session
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document
from prompt_toolkit.input import create_pipe_input
from prompt_toolkit.output import DummyOutput

from porelang.repl.commands import COMMANDS
from porelang.repl.loop import MORE, answered, talk
from porelang.repl.picture import SIGNS, slice_of
from porelang.repl.state import State, is_incomplete, said
from porelang.session import Session


def spoken(*lines: str) -> list[str]:
    """What is said to lines, one after the other; the prompts that they were read at are told too, as `?...`."""
    out: list[str] = []
    left = list(lines)

    def read(prompt: str) -> str:
        if prompt == MORE:
            out.append("?more")
        if not left:
            raise EOFError
        return left.pop(0)

    talk(read, out.append, State(Session()))
    return out


def test_an_expression_is_shown_as_what_it_is() -> None:
    assert spoken("let w = 12mm", "w * 2 + 1cm") == ["a length: 34mm"]
    assert spoken("3 < 4") == ["a condition: true"]
    assert spoken("[1, 2, 3] * 1mm") == ["a vector: [1, 2, 3]"]
    assert spoken("def f(a, b: length = 2mm) = a * b", "f") == ["f(a, b: length = 2mm)"]
    (text,) = spoken("sphere(9) & cube(30)")
    kind, _, steep, part = text.split("\n")
    assert (kind, steep) == ("a number that varies in space", "it rises by 1 in each mm, 1 at most")
    assert part.startswith("as a part: 18 x 18 x 18 mm, (-9, -9, -9) to (9, 9, 9), of which it fills 5")
    share, off = (float(word.strip("%")) for word in part.rsplit(" fills ", 1)[1].split(" +- "))
    assert share == pytest.approx(52.36, abs=2 * off)  # pi / 6
    assert "has no end along x, y, z" in spoken("gyroid(10)")[0]


def test_statements_are_kept_and_take_the_place_of_others() -> None:
    assert spoken("let a = 2mm", "let b = a * 3", "let a = 4mm", "b") == ["a length: 12mm"]
    assert spoken("let a = 2mm", ":drop a", "let b = a")[1].startswith("error[E030]: unknown name `a`")
    # what is wrong changes nothing
    assert spoken("let a = 2mm", "let a = nothing", "a")[-1] == "a length: 2mm"


def test_what_others_need_stays() -> None:
    told = spoken("let a = 2mm", "let b = a * 3", ":drop a", "b", ":drop b", ":drop a", "1 + 1")
    assert told[0] == "error[E108]: `a` is needed by `b`\n  = hint: `:drop b` first, or write another `a`"
    assert told[1:] == ["a length: 6mm", "`b` is gone", "`a` is gone", "a number: 2"]


def test_a_param_that_is_written_anew_is_what_the_line_says() -> None:
    told = spoken(
        "param w = 8mm in 4mm..9mm", ":set w = 5mm", "param w = 3mm in 1mm..4mm", "w", ":set w = 9mm", ":set w 2mm"
    )
    assert told[1] == "note: `w` is what this line says, and not 5mm any more"
    assert told[2] == "a length: 3mm with the params at their defaults"
    assert " --> <repl>:1:7\n  |\n1 | param w = 3mm" in told[3]
    assert "`:set w = 2mm`" in told[4]
    assert "names a function" in spoken(":doc")[0]


def test_a_part_whose_check_fails_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    told = spoken("let w = 3mm", 'check w > 4mm, "thin"', "sphere(w)", f":mesh {path}")
    assert told[-1].startswith("error[E068]: thin\n --> <repl>:1:7")
    assert not path.exists()


def test_a_remark_may_say_what_the_part_is_called() -> None:
    state = said(State(Session()), "let body = sphere(3)\n# body\nbody\n", part=True).state
    assert state.text == "let body = sphere(3)\n# body\nout part = body\n"
    assert answered(state, "let w = 3").state.program is not None


def test_a_setting_ends_with_its_range() -> None:
    told = spoken("let b = 4mm", "param a = 3mm in 1mm..b", ":set a = 3.5mm", "let b = 3mm", "2", ":set")
    assert told[1] == "note: `a` is what the program says, and not 3.5mm any more, which lies outside of it now"
    assert told[2:] == ["a number: 2", "a = 3mm in 1mm..3mm"]


def test_names_that_nobody_typed_are_not_shown() -> None:
    assert "`gyroid(8)` has no end" in spoken("gyroid(8)")[0]
    assert "`it" not in spoken("it")[0].replace("unknown name `it`", "")
    assert spoken("param w = 3 in 1..4", 'preset "a": w = 2', ':drop preset "a"') == ["`preset a` is gone"]


def test_a_check_that_falls_is_told() -> None:
    check = 'check w > 7mm, "wide"'
    anew = "param w = 4mm in 2mm..12mm"
    told = spoken("param w = 8mm in 2mm..12mm", check, ":set w = 3mm", check, ":set w =", anew)
    assert told[0] == 'note: it holds: check w > 7mm, "wide"'
    assert told[1].startswith("w = 3mm\nerror[E068]: wide")
    assert told[2].startswith("error[E068]: wide")  # asked for again
    assert told[3] == "w = 8mm"
    assert "error[E068]: wide" in told[4]


def test_a_remark_belongs_to_what_follows(tmp_path: Path) -> None:
    path = tmp_path / "a.pore"
    told = spoken(
        "# of a panel", "", "# the cell", "let w = 3mm", "w", "# seen", "let v = w", ":program", f":save {path}"
    )
    assert told[1] == "# of a panel\n# the cell\nlet w = 3mm\n# seen\nlet v = w"
    assert path.read_text().startswith("# of a panel\n# the cell\nlet w = 3mm\n")


def test_a_program_is_saved_where_its_files_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "lib.pore").write_text("param t = 2mm in 1mm..3mm\n")
    text = 'use "lib.pore" as lib\nout part = sphere(lib.t)\n'
    monkeypatch.chdir(tmp_path)
    state = said(State(Session(), "deep/<repl>"), text, part=True).state
    refused = answered(state, ":save other.pore")
    assert refused.wrong
    assert "`:save deep/other.pore`" in refused.said
    assert not answered(state, ":save deep/other.pore").wrong
    assert (tmp_path / "deep" / "other.pore").read_text() == text
    from porelang.repl.terminal import Names

    names = Names([text], "deep/<repl>")
    assert [c.text for c in names.get_completions(Document("lib."), CompleteEvent())] == ["t"]


def test_remarks_are_kept(tmp_path: Path) -> None:
    text = """\
# of a panel

## the cell
param w = 8mm in 4mm..12mm  # from the datasheet

# the body
let body = cube(20)

out part = gyroid(w) & body  # all
# end
"""
    (tmp_path / "part.pore").write_text(text)
    state = said(State(Session()), text, part=True).state
    saved = tmp_path / "saved.pore"
    assert answered(state, f":save {saved}").said == f"{saved}: 3 statements"
    assert saved.read_text() == text
    changed = answered(state, "let body = cube(30)").state
    assert changed.text.replace("\n\n", "\n") == text.replace("cube(20)", "cube(30)").replace("\n\n", "\n")


def test_a_line_that_is_not_complete_goes_on() -> None:
    for text in ("cube(", "let a =", "let a = 1 +", "{", "a |>", "[1,"):
        assert is_incomplete(text), text
    for text in ("cube(1)", "let a = 1", ":help", "", "# a (", 'let t = "("'):
        assert not is_incomplete(text), text
    assert spoken("let a = 2mm +", "1mm", "a") == ["?more", "a length: 3mm"]
    told = spoken("sphere(3", ":type 1mm")  # a command ends what was begun
    assert told[1].startswith("error[E005]")
    assert told[2] == "a length"
    told = spoken("let a = (", "1mm", "")  # an empty line says that it is meant so
    assert told[:2] == ["?more", "?more"]
    assert told[2].startswith("error[E005]: `(` is never closed")


def test_params_are_set() -> None:
    told = spoken(
        "param r = 3mm in 1mm..5mm", "r * 2", ":set r = 4mm", "r * 2", ":set", ":set r = 9mm", ":set q = 1", "r"
    )
    assert told[0] == "a length: 6mm with the params at their defaults"
    assert told[1:4] == ["r = 4mm", "a length: 8mm with the params as they are set", "r = 4mm in 1mm..5mm"]
    assert told[4].startswith("error[E085]")
    assert "q" in told[5]
    assert told[6] == "a length: 4mm with the params as they are set"


def test_commands() -> None:
    for name, command in COMMANDS.items():
        assert f"{name} {command.takes}".strip() in spoken(":help")[0]
    assert spoken(":type gyroid(10)") == ["a number that varies in space"]
    assert spoken(":doc gyroid")[0].startswith("gyroid(w: period or phase: vector = p / w)\n\nSchoen's gyroid.")
    assert spoken("let a = 2", ":ir a * x") == ["%0 = mul 2.0, x\na * x = %0"]
    assert "float" in spoken(":glsl gyroid(10)")[0]
    assert "did you mean `:program`?" in spoken(":prgram")[0]
    assert spoken("let a = 1mm", ":program") == ["let a = 1mm"]
    assert "compiled in" in spoken(":time 1 + 1")[0]
    assert spoken(":quit", "1 + 1") == []


def test_files_are_written_and_never_over_others(tmp_path: Path) -> None:
    mesh, program = tmp_path / "a.stl", tmp_path / "a.pore"
    told = spoken("let r = 5mm", "sphere(r)", f":mesh {mesh}", f":save {program}", f":save {program}")
    assert "triangles" in told[1]
    assert mesh.stat().st_size > 1000
    assert program.read_text() == "let r = 5mm\nsphere(r)\n"
    assert "is there already" in told[3]
    assert "E112" in spoken("sphere(3)", f":mesh {tmp_path / 'a.doc'}")[1]


def test_a_slice_is_drawn_in_signs_and_in_colours() -> None:
    found = said(State(Session()), "sphere(5)")
    text = slice_of(found.design, found.name, 20, False).split("\n")
    assert text[-1] == "z = 0 mm, 10.5 x 10.5 mm"
    rows = text[:-1]
    assert [rows[i].rstrip() for i in range(len(rows))] == [rows[-1 - i].rstrip() for i in range(len(rows))]  # a ball
    assert rows[len(rows) // 2][10] in SIGNS[:2]
    assert rows[0][:1] in ("", " ", ".", ":", "-")
    shown = slice_of(found.design, found.name, 20, True)
    assert shown.count("\033[38;2;") == 20 * len(rows)


def test_it_speaks_through_a_pipe(tmp_path: Path) -> None:
    file = tmp_path / "part.pore"
    file.write_text("param r = 4mm in 1mm..9mm\nlet ball = sphere(r)\nball & cube(20)\n")

    def run(text: str) -> tuple[int, str]:
        done = subprocess.run(
            [sys.executable, "-m", "porelang", "repl", str(file)],
            input=text,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stderr == ""
        return done.returncode, done.stdout

    status, out = run("r * 2\ndef f(a) = a\n  |> offset(1mm)\nf(ball)\n")
    assert status == 0
    assert out.startswith("a length: 8mm")
    assert "10 x 10 x 10 mm" in out
    status, out = run("nothing + 1\n2 + 2\n")
    assert (status, out.split("\n")[-2]) == (1, "a number: 4")


@pytest.fixture
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """What is said at a terminal to keys."""
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path))

    def type_(text: str) -> list[str]:
        out: list[str] = []
        with create_pipe_input() as given, create_app_session(input=given, output=DummyOutput()):
            from porelang.repl.terminal import reader

            given.send_text(text)
            program = [""]
            talk(reader(program), out.append, State(Session()), lambda state: program.__setitem__(0, state.text))
        return out

    return type_


def test_a_terminal_completes_names_and_remembers_lines(keys: Callable[[str], list[str]], tmp_path: Path) -> None:
    from porelang.repl.terminal import Names

    names = Names(["let wide = 3mm\n"])
    offered = [c for c in names.get_completions(Document("wid"), CompleteEvent()) if c.text == "wide"]
    assert [c.start_position for c in offered] == [-3]
    assert [c.text for c in names.get_completions(Document(":hel"), CompleteEvent())] == [":help"]
    assert "wide" in [c.text for c in names.get_completions(Document(":type wid"), CompleteEvent())]
    (tmp_path / "parts").mkdir()
    offered = [c.text for c in names.get_completions(Document(f":save {tmp_path}/pa"), CompleteEvent())]
    assert offered == ["rts"]
    assert [c.text for c in names.get_completions(Document("shell(wide, "), CompleteEvent())][:2] == ["side=", "t="]
    assert keys("1 + 1\n\x04") == ["a number: 2"]
    assert "+1 + 1" in (tmp_path / "repl.history").read_text()
    assert keys("let a = (\x03" + "2 + 2\n\x04") == ["a number: 4"]  # Ctrl-C leaves the line


def test_what_is_wrong_is_at_its_place_in_the_line() -> None:
    told = spoken("let w = 12mm", "let v = 3mm", "w * q", "let big = cube(1e9mm)", "big")
    assert " --> <repl>:1:5\n  |\n1 | w * q\n" in told[0]
    assert told[1].startswith("error[E117]: `big` lies ")
    assert "\n1 | big\n" in told[1]


def test_a_check_is_looked_at_as_soon_as_it_is_written() -> None:
    said_of = spoken("let w = 12mm", 'check w > 2mm, "wide"', 'check w < 5mm, "narrow"')
    assert said_of[0] == 'note: it holds: check w > 2mm, "wide"'
    assert said_of[1].startswith("error[E068]: narrow\n --> <repl>:1:7")
    kept = spoken("let w = 3mm", 'check w > 1mm, "a"', 'check w > 2mm, "b"', ":drop check 1", 'check w < 5mm, "c"',
                  ":program")[-1]  # fmt: skip
    assert '"b"' in kept
    assert '"c"' in kept


def test_what_a_file_does_not_have_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    param = "param t = 1mm in 0.5mm..2mm"
    told = spoken(param, ":set t = 1.5mm", "sphere(9) |> shell(t)", ':save "my part.pore"', ":set t =")
    assert told[-2] == (
        "my part.pore: 1 statement; its part is `sphere(9) |> shell(t)`, which was asked for last; "
        "not in it: t = 1.5mm, as was set here"
    )
    assert told[-1] == "t = 1mm"
    assert (tmp_path / "my part.pore").read_text() == f"{param}\nsphere(9) |> shell(t)\n"
    told = spoken("let v = 2mm", "let w = 3mm", "sphere(w)", ":drop w", ":save rest.pore")
    assert told[-1] == "rest.pore: 1 statement"  # what was asked for names what is gone
    assert (tmp_path / "rest.pore").read_text() == "let v = 2mm\n"
    assert "`3` is a number, and no part" in spoken(":mesh a.stl 3")[0]
    assert "nothing was asked for yet" in spoken(":mesh a.stl")[0]


def test_a_pipe_has_blank_lines_and_pipes() -> None:
    text = "let c = union([\n  sphere(3),\n\n  sphere(4)\n])\n\n  |> shell(1)\n:program\n"
    said_of = subprocess.run([sys.executable, "-m", "porelang", "repl"], input=text, capture_output=True, text=True)
    assert said_of.returncode == 0
    assert said_of.stdout == "let c = union([\n  sphere(3),\n  sphere(4)\n])\n  |> shell(1)\n"


def test_a_line_of_a_pipe_is_answered_before_the_next() -> None:
    command = [sys.executable, "-m", "porelang", "repl"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as talking:
        assert talking.stdin is not None
        assert talking.stdout is not None
        for n in (2, 3):
            print(f"{n} * {n}", file=talking.stdin, flush=True)
            assert talking.stdout.readline() == f"a number: {n * n}\n"


def test_names_and_docs_of_the_user_are_kept() -> None:
    assert spoken("let it = 3", "let it_ = 4", "it + it_") == ["a number: 7"]
    assert spoken("## twice as much", "def g(a) = 2 * a", ":doc g")[-1].endswith("twice as much")


def test_a_page_follows_what_is_written(tmp_path: Path) -> None:
    """It is one page, and its file is gone with the session."""
    command = [sys.executable, "-m", "porelang", "repl"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=tmp_path, text=True) as talking:
        assert talking.stdin is not None
        assert talking.stdout is not None
        print("let w = 12mm\n:view sphere(w)\n:view box([w, w, w])", file=talking.stdin, flush=True)
        addresses = [talking.stdout.readline().split(" ")[0] for _ in range(2)]
        assert addresses[0] == addresses[1]
        with urllib.request.urlopen(addresses[0], timeout=20) as page:
            assert b"<canvas" in page.read()
        (file,) = tmp_path.iterdir()
        assert file.read_text() == "let w = 12mm\nbox([w, w, w])\n"
        talking.stdin.close()
        assert talking.wait(20) == 0
    assert list(tmp_path.iterdir()) == []
    assert "nothing has been written yet" in spoken(":view")[0]


def test_what_is_wrong_in_several_lines_is_in_its_line() -> None:
    (told,) = spoken("let f = {\n  let a = 1\n  a + qq\n}")
    assert " --> <repl>:3:7\n" in told
    state = said(State(Session()), "let a = 1\n\nlet b = a\nlet c = qq + 1\n")
    assert [(d.span.line, d.span.column) for d in state.diagnostics if d.span is not None] == [(4, 9)]
    assert spoken("it")[0].startswith("error[E030]: unknown name `it`")


def test_a_file_is_begun_with_where_it_lies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "lib.pore").write_text("let t = 2mm\n")
    (tmp_path / "deep" / "part.pore").write_text('use "lib.pore" as lib\nsphere(lib.t)\n')
    (tmp_path / "deep" / "wrong.pore").write_text("let a = 1\n\nlet b = qq\n")
    monkeypatch.chdir(tmp_path)

    def run(file: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "porelang", "repl", file]
        return subprocess.run(command, input="lib.t\n", capture_output=True, text=True)

    for path in ("deep/part.pore", "./deep/part.pore"):
        assert run(path).stdout == "a length: 2mm\n"
    wrong = run("deep/wrong.pore")
    assert (wrong.returncode, wrong.stdout) == (1, "")
    assert " --> deep/wrong.pore:3:9\n" in wrong.stderr


def test_a_mesh_is_reported_as_the_command_does(tmp_path: Path) -> None:
    (told,) = spoken(f":mesh {tmp_path / 'a.stl'} sphere(3) | translate(sphere(1), [9, 0, 0])")
    assert "surfaces   2 that are not joined" in told
    assert "pieces     2: " in told
