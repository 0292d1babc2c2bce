"""What is said of a mistake, word for word; and that every code has a page whose example really gives it.

`make golden` (or PORELANG_GOLDEN=1) rewrites the texts.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from porelang.checks import broken_checks
from porelang.cli import main
from porelang.compiler import try_compile
from porelang.diagnostics import PoreError
from porelang.error_codes import CODES, RETIRED
from porelang.refusals import refusals
from porelang.source import Source

ROOT = Path(__file__).parent.parent
FOLDER = Path(__file__).parent / "errors"
#: The first line of a program whose mistake shows only where fields are measured.
MEASURED = re.compile(r"\A# (--measure)$", re.MULTILINE)
MISTAKES = sorted(path.stem for path in FOLDER.glob("*.pore"))


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake_is_told_in_these_words(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(FOLDER)
    status = main(["check", f"{name}.pore", *MEASURED.findall((FOLDER / f"{name}.pore").read_text(encoding="utf-8"))])
    told = capsys.readouterr()
    golden = FOLDER / f"{name}.txt"
    if os.environ.get("PORELANG_GOLDEN"):
        golden.write_text(told.err, encoding="utf-8")
    assert told.err == golden.read_text(encoding="utf-8")
    assert told.out == ""
    assert status == (1 if "error[" in told.err else 0)
    assert "error[" in told.err or "warning[" in told.err


def test_every_golden_text_has_its_program() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.txt")) == MISTAKES


def test_every_mistake_has_a_place_and_a_way_out() -> None:
    """A message points at its place; most say what to do."""
    texts = [(FOLDER / f"{name}.txt").read_text(encoding="utf-8") for name in MISTAKES]
    assert all("-->" in text and "^" in text for text in texts)
    assert sum("= hint:" in text for text in texts) > 0.6 * len(texts)
    assert not [text for text in texts if "Traceback" in text or "porelang/" in text]


def test_what_may_be_wrong_with_data_is_told_in_a_golden_text() -> None:
    texts = "".join((FOLDER / f"{name}.txt").read_text(encoding="utf-8") for name in MISTAKES)
    assert {f"E13{i}" for i in range(7)} | {"E096", "E097"} <= set(re.findall(r"error\[(\w+)\]", texts))


def test_codes_in_the_sources_and_pages_are_the_same() -> None:
    given: set[str] = set()
    for path in (ROOT / "porelang").rglob("*.py"):
        if "error_codes" not in path.parts:
            given |= set(re.findall(r'"([EW]\d{3})"', path.read_text(encoding="utf-8")))
    assert given == set(CODES) - RETIRED
    assert set(CODES) > RETIRED


def found_in(text: str) -> list[str]:
    program, found = try_compile(Source("example.pore", text))
    if program is not None:
        try:
            design = program.design()
            design.read_data()
            found = [*found, *refusals(design), *broken_checks(design)]
        except PoreError as error:
            found = [*found, *error.diagnostics]
    return [d.code for d in found]


@pytest.mark.parametrize("code", [c for c, page in sorted(CODES.items()) if page.wrong])
def test_wrong_example_gives_its_code(code: str) -> None:
    assert code in found_in(CODES[code].wrong)


@pytest.mark.parametrize("code", [c for c, page in sorted(CODES.items()) if page.right and 'use "' not in page.right])
def test_right_example_has_no_fault(code: str) -> None:
    assert set(found_in(CODES[code].right)) <= {"W221"}  # some are a definition and nothing else


def test_what_a_text_can_show_is_shown() -> None:
    """Only requests, settings and the machine have pages without an example that is wrong."""
    without = {code for code, page in CODES.items() if not page.wrong}
    assert all(code >= "E090" or code in {"E027", "E028", "E035", "E083", "E084", "E085", "E088"} for code in without)
    assert all(page.title and page.explanation for page in CODES.values())
