"""Programs that once went wrong, one a file in `tests/regressions/`: conformance programs, found and not devised.

Their comments are those of `porelang.conformance.programs` (`# set:`, `# place:`, `# expect:`), and one more:

    # rejected                 the text is no program: all that is asked for is an answer, whatever it says
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from porelang.compiler import try_compile
from porelang.conformance import samples
from porelang.conformance.backend import Backend
from porelang.conformance.programs import read_case
from porelang.conformance.suite import check_case
from porelang.source import Source

FOLDER = Path(__file__).parent / "regressions"
Place = tuple[float, float, float]


def regressions() -> list[Path]:
    """All of them, by name."""
    return sorted(FOLDER.glob("*.pore"))


def replay(path: Path, backend: Backend) -> list[str]:
    """What is wrong with a regression on a backend: nothing, once it is mended."""
    text = path.read_text(encoding="utf-8")
    if re.search(r"^# rejected\b", text, re.MULTILINE):
        return answered(text)
    return [f.failure.example for f in check_case(read_case(path), backend, points=200, seed=1) if f.failure]


def answered(text: str) -> list[str]:
    """What is wrong with the answer to a text that need not be a program: it has one, and what is said has a place."""
    program, found = try_compile(Source("text.pore", text))
    wrong = [str(d) for d in found if d.span is None or not 0 <= d.span.start <= d.span.end <= len(text)]
    if program is None and not any(d.severity == "error" for d in found):
        wrong.append("it is rejected without a word")
    return wrong


def written(
    folder: Path, name: str, story: Sequence[str], text: str,
    settings: Mapping[str, float] | None = None, places: Sequence[Place] = (), rejected: bool = False,
) -> Path:  # fmt: skip
    """Write a regression: its story as comments, then what it is replayed with, then the text."""
    folder.mkdir(exist_ok=True)
    head = [f"# {line}" for part in story for line in part.splitlines()]
    if settings:
        head.append("# set: " + ", ".join(f"{key}={value!r}" for key, value in settings.items()))
    head += [f"# place: {', '.join(map(repr, place))}" for place in places]
    if rejected:
        head.append("# rejected")
    path = folder / f"{name}.pore"
    path.write_text("\n".join([*head, text]), encoding="utf-8")
    if samples.GRID_FILE in text or samples.FRAME_FILE in text:
        samples.write(folder)
    return path
