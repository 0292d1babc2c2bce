"""What the documents say is so: programs compile, generated parts are up to date, links lead somewhere."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from porelang.checks import failed_checks
from porelang.cli.arguments import COMMANDS
from porelang.compiler import try_compile
from porelang.elaborate.prelude import prelude_scope
from porelang.elaborate.values import Function
from porelang.ops import TABLE
from porelang.source import Source

ROOT = Path(__file__).parent.parent
DOCUMENTS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
}
PROGRAMS = [
    (f"{name}:{text[: found.start()].count(chr(10)) + 1}", found[1])
    for name, text in DOCUMENTS.items()
    for found in re.finditer(r"```pore\n(.*?)```", text, re.DOTALL)
]


@pytest.mark.parametrize(("place", "text"), PROGRAMS, ids=[place for place, _ in PROGRAMS])
def test_program_in_a_document_compiles_without_a_word(place: str, text: str) -> None:
    program, found = try_compile(Source(place, text))
    assert found == []
    assert program is not None
    design = program.design()
    assert failed_checks(design, measure=False) == []
    assert all(abs(v) < 1e4 for corner in design.bounds() for v in corner)


def test_the_documents_hold_programs() -> None:
    assert {"README.md", "docs/language.md"} <= {place.rpartition(":")[0] for place, _ in PROGRAMS}


def test_python_of_the_readme_runs(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    (text,) = re.findall(r"```python\n(.*?)```", DOCUMENTS["README.md"], re.DOTALL)
    names: dict[str, object] = {}
    exec(text, names)
    assert "150" in capsys.readouterr().out
    assert names["mesh"].is_watertight  # type: ignore[attr-defined]


def smaller(text: str, size: str, other: str) -> str:
    assert size in text
    return text.replace(size, other)


def test_python_of_its_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text, strength, solver = re.findall(r"```python\n(.*?)```", DOCUMENTS["docs/python.md"], re.DOTALL)
    # as they stand, but for sizes that take ten seconds
    text = smaller(text, "sphere(8mm)", "sphere(4mm)").replace("resolution=40", "resolution=20")
    strength = smaller(strength, "homogenize(resolution=16)", "homogenize(resolution=8)")
    names: dict[str, object] = {}
    exec(text, names)
    out = capsys.readouterr().out
    assert out.startswith(re.findall(r"# (<param .*>)\n", text)[0])
    assert "porosity" in out
    assert "+-" in out
    exec(strength, {})
    told = capsys.readouterr().out.splitlines()
    stiffness, _, _, z = (float(word.strip("[],")) for word in told[0].split())
    assert stiffness == pytest.approx(2000 * 100 / 40, rel=1e-6)
    assert z == pytest.approx(2000, rel=1e-6)
    exec(solver, names)
    found = names["found"]
    assert 0.97 < found.compliance / (1000**2 / 5000) < 1  # type: ignore[attr-defined]  # a bonded foot is stiffer
    assert found.reactions[0].force[2] == pytest.approx(1000, rel=1e-6)  # type: ignore[attr-defined]


def test_python_of_tetrahedra_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (text,) = re.findall(r"```python\n(.*?)```", DOCUMENTS["docs/tetrahedra.md"], re.DOTALL)
    names: dict[str, object] = {}
    exec(text, names)
    assert "min" not in capsys.readouterr().err
    assert names["outside"].is_watertight  # type: ignore[attr-defined]
    assert [path.name for path in tmp_path.iterdir()] == ["part.msh"]


def test_generated_parts_of_the_reference_are_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    text = DOCUMENTS["docs/language.md"]
    assert generate.page(text) == text, "run `make docs`"


def test_reference_names_everything_there_is() -> None:
    text = DOCUMENTS["docs/language.md"]
    functions = {name for name, value in prelude_scope().names.items() if isinstance(value, Function)}
    assert not {name for name in functions if f"`{name}`" not in text and f"`{name}(" not in text}
    assert not {op.symbol for op in TABLE.values() if op.symbol and f"`{op.symbol}`" not in text.replace("\\|", "|")}


def test_readme_lists_the_commands() -> None:
    listed = re.findall(r"^\| `pore (\w+)", DOCUMENTS["README.md"], re.MULTILINE)
    assert sorted(listed) == sorted(COMMANDS)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_links_lead_to_files(name: str) -> None:
    folder = (ROOT / name).parent
    targets = re.findall(r"\]\(([^)#:]+)\)|src=\"([^\"]+)\"", DOCUMENTS[name])
    assert not [t for pair in targets for t in pair if t and not (folder / t).exists()]
