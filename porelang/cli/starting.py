"""`pore new` and `pore examples`: a program to begin with, and programs to learn from."""

from __future__ import annotations

import re
import shlex
import shutil
import sys
import textwrap
from argparse import Namespace
from pathlib import Path
from typing import BinaryIO

from porelang import resources
from porelang.atomic import destination, save
from porelang.cli import report
from porelang.diagnostics import fail, suggest

#: What a new program is; `part` is its name.
PROGRAM = "cli/new.pore"
#: Columns of the list before what an example is about.
_NAMES = 24
_QUOTED = re.compile(r'"([^"\n]+\.\w+)"')


def new(options: Namespace) -> int:
    """Write a commented program that compiles, under a name that is free. Errors: E108, E113."""
    path = Path(options.name)
    if not path.name or options.name.endswith("/") or path.name == "..":
        raise fail("E108", f"`{options.name}` is no name of a program", hint="as in `pore new bracket`")
    if path.suffix not in ("", ".pore"):
        raise fail("E108", f"a program ends in .pore, and `{path.name}` does not", hint=f"write `{path.stem}.pore`")
    path = path.with_suffix(".pore")
    program, picture = shlex.quote(str(path)), shlex.quote(str(path.with_suffix(".png")))
    text = resources.read(PROGRAM)
    for ending in (".pore", ".png", ".stl", ""):
        text = text.replace(f"bracket{ending}", shlex.quote(f"{path.stem}{ending}") if ending else path.stem)
    _write({path: text.encode()})
    report.note(f"{path}: change it while `pore watch {program} -- render -o {picture}` draws it")
    return 0


def examples(options: Namespace) -> int:
    """List the examples, or copy those that are named, with the files they read. Errors: E108, E113."""
    known = shown()
    if not options.names:
        for name, path in known.items():
            print(_line(name, _about(path)))
        report.note("`pore examples NAME` copies one into this folder, with the files that it reads")
        return 0
    copied: dict[Path, bytes] = {}
    for word in options.names:
        name = word.removesuffix(".pore")
        if name not in known:
            near = suggest(name, known)
            raise fail("E108", f"there is no example `{name}`",
                       hint=f"did you mean `{near}`?" if near else "`pore examples` lists them")  # fmt: skip
        copied |= {Path(path.name): path.read_bytes() for path in _with_what_it_reads(known[name])}
    _write(copied)
    report.note(f"copied {', '.join(map(str, copied))}")
    return 0


def shown() -> dict[str, Path]:
    """The programs, those of the paper's figures last."""
    folder = resources.folder("examples")
    return {path.stem: path for path in (*sorted(folder.glob("*.pore")), *sorted(folder.glob("figures/*.pore")))}


def _about(path: Path) -> str:
    """The first sentence of a program's first remark."""
    remark: list[str] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        remark.append(line.lstrip("# "))
    return re.split(r"(?<=[.])\s(?=[A-Z`])", " ".join(remark))[0].rstrip(".")


def _line(name: str, about: str) -> str:
    """A row of the list: within the width of a terminal, or on one line for other programs."""
    begun = f"{name:<{_NAMES}}"
    if not sys.stdout.isatty():
        return begun + about
    width = max(shutil.get_terminal_size().columns, 2 * _NAMES)
    return textwrap.fill(about, width, initial_indent=begun, subsequent_indent=" " * _NAMES)


def _with_what_it_reads(program: Path) -> list[Path]:
    """A program and the files beside it that it names, and those that they name."""
    found = [program]
    for path in found:
        if path.suffix == ".pore":
            named = (path.parent / name for name in _QUOTED.findall(path.read_text(encoding="utf-8")))
            found += [other for other in named if other.is_file() and other not in found]
    return found


def _write(files: dict[Path, bytes]) -> None:
    """All of these files, none of which is there yet."""
    for path in files:
        if path.exists() or path.is_symlink():
            raise fail("E113", f"`{path}` is there already, and stays as it is",
                       hint="choose another name, or move it away")  # fmt: skip
    for path, content in files.items():

        def write(file: BinaryIO, content: bytes = content) -> None:
            file.write(content)

        save(destination(path), write)
