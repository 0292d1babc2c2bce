"""The one style of `pore fmt`: it keeps what a program means, its remarks and its groups of lines, and is what it is
however the text was spaced."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from porelang.cli.commands import run
from porelang.conformance.generate import Dice, draw_graph, program_text
from porelang.diagnostics import PoreError
from porelang.elaborate.prelude import prelude_files
from porelang.source import Source, Span
from porelang.syntax.format import formatted
from porelang.syntax.parse import lexed, parse

ROOT = Path(__file__).parent.parent
FILES = sorted(
    [*ROOT.glob("examples/**/*.pore"), *ROOT.glob("tests/conformance/*.pore"), *ROOT.glob("tests/errors/*.pore")]
)
PRELUDE = [source.text for _, source in prelude_files()]


def style(text: str) -> str:
    return formatted(Source("a.pore", text))


def dump(item: object) -> object:
    """A tree without its places, by means of its own: what `formatted` compares with, this does not use."""
    if isinstance(item, tuple):
        return tuple(map(dump, item))
    if hasattr(item, "__dataclass_fields__") and not isinstance(item, Span):
        return type(item).__name__, *(dump(getattr(item, name)) for name in item.__dataclass_fields__)
    return None if isinstance(item, Span) else item


def means(text: str) -> object:
    file, wrong = parse(Source("a.pore", text))
    assert not wrong, wrong
    return dump(file.statements)


def remarks(text: str) -> list[str]:
    return [re.sub(r"^#+\s*", "", t.text).rstrip() for t in lexed(text, comments=True) if t.type in ("COMMENT", "DOC")]


def groups(text: str) -> list[int]:
    """How many lines stand together, between empty ones."""
    return [len(group.strip().split("\n")) for group in re.split(r"\n\s*\n", text.strip("\n ")) if group.strip()]


def readable(text: str) -> bool:
    return not parse(Source("a.pore", text))[1]


TEXTS = [text for path in FILES if readable(text := path.read_text(encoding="utf-8"))] + PRELUDE


def test_it_keeps_what_is_written_and_settles_at_once() -> None:
    assert len(TEXTS) > 250
    for text in TEXTS:
        made = style(text)
        assert means(made) == means(text), text
        assert remarks(made) == remarks(text), text
        assert groups(made) == groups(text), text
        assert style(made) == made, text
        assert not made.strip() or made.endswith("\n")
        assert not re.search(r"[ \t]$", made, re.MULTILINE), text


def test_it_does_not_matter_how_a_line_was_spaced() -> None:
    chance = random.Random(4)
    for text in chance.sample(TEXTS, 120):
        out = []
        for line in text.split("\n"):
            spaced, end = chance.choice(["", "\t", "      "]), 0
            for token in lexed(line, comments=True):
                if token.type == "NEWLINE":
                    continue
                between = line[end : token.start]
                joined = not between and end
                spaced += (
                    "" if joined and chance.random() < 0.5 else chance.choice([" ", "   ", "\t"]) if between else ""
                )
                spaced += token.text
                end = token.start + len(token.text)
            out.append(spaced + chance.choice(["", "  "]))
        mangled = "\n".join(out)
        if readable(mangled):
            assert style(mangled) == style(text), mangled


def test_lines_may_end_anywhere() -> None:
    chance, seen = random.Random(5), 0
    for text in chance.sample(TEXTS, 150):
        tokens = [t for t in lexed(text, comments=True) if t.type != "NEWLINE"]
        at = sorted(chance.sample([t.start for t in tokens], min(4, len(tokens))), reverse=True)
        broken = text
        for start in at:
            broken = broken[:start] + chance.choice(["\n", "\n\n", " # why\n"]) + broken[start:]
        if readable(broken):
            seen += 1
            made = style(broken)
            assert means(made) == means(broken), broken
            assert remarks(made) == remarks(broken), broken
            assert style(made) == made, broken
    assert seen > 30


def test_generated_programs_keep_their_meaning() -> None:
    for seed in range(20):
        text = program_text(draw_graph(Dice.seeded(seed)))
        assert means(style(text)) == means(text)


def cases() -> dict[str, tuple[str, str]]:
    """The cases of `data/style.txt`: `==== name`, a text, `----`, and how it is written."""
    found: dict[str, tuple[str, str]] = {}
    for case in re.split(r"^==== ", (ROOT / "tests" / "data" / "style.txt").read_text(), flags=re.MULTILINE)[1:]:
        name, _, both = case.partition("\n")
        text, _, wanted = both.partition("\n----\n")
        found[name] = text, wanted.removesuffix("\n")
    return found


CASES = cases()


@pytest.mark.parametrize("name", CASES)
def test_style(name: str) -> None:
    text, wanted = CASES[name]
    assert style(text) == wanted
    assert style(wanted) == wanted


def test_our_own_programs_are_in_it() -> None:
    ours = [*ROOT.glob("examples/**/*.pore"), *ROOT.glob("porelang/prelude/**/*.pore")]
    assert [str(p) for p in ours if style(p.read_text(encoding="utf-8")) != p.read_text(encoding="utf-8")] == []


# ---- the command ----------------------------------------------------------------------------------------------------


def test_files_are_written_anew(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    well, other, broken = tmp_path / "well.pore", tmp_path / "other.pore", tmp_path / "broken.pore"
    well.write_text("sphere(3)\n")
    other.write_bytes(b"let  a=1\r\nsphere( a )")
    broken.write_text("let a = (\n")
    stamp = well.stat().st_mtime_ns
    assert run(["fmt", "--check", str(well), str(other)]) == 1
    said = capsys.readouterr()
    assert "other.pore is not as `pore fmt` writes it, from line 1, where it would be `let a = 1`" in said.err
    assert (said.out, other.read_bytes()) == ("", b"let  a=1\r\nsphere( a )")
    windows = tmp_path / "windows.pore"
    windows.write_bytes(b"let a = 1\r\nsphere(a)\r\n")
    assert run(["fmt", "--check", str(windows)]) == 0  # lines end as they did
    assert run(["fmt", str(well), str(broken), str(other)]) == 1
    assert "E005" in capsys.readouterr().err
    assert (other.read_bytes(), broken.read_text()) == (b"let a = 1\r\nsphere(a)\r\n", "let a = (\n")
    assert well.stat().st_mtime_ns == stamp
    assert run(["fmt", "--check", str(well), str(other)]) == 0


def test_standard_input(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import io
    import sys

    for text, wanted, status in (("let  a=1", "let a = 1\n", 0), ("let a = (", "", 1)):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
        assert run(["fmt", "-"]) == status
        assert capsys.readouterr().out == wanted


def test_a_text_that_cannot_be_read_is_refused() -> None:
    with pytest.raises(PoreError) as caught:
        style("let a = 1 +\nlet b = (2")
    assert {d.code for d in caught.value.diagnostics} >= {"E005"}
