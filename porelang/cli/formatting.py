"""`pore fmt`: programs in the one style, in place, or from standard input to standard output."""

from __future__ import annotations

from argparse import Namespace
from typing import BinaryIO

from porelang.atomic import destination, save
from porelang.cli import report
from porelang.diagnostics import Diagnostic, PoreError
from porelang.files import read_source, read_standard_input
from porelang.source import Source
from porelang.syntax.format import formatted


def fmt(options: Namespace) -> int:
    """Write each file in the one style, if it is not; with `--check` say which are not, and write none.

    A file that cannot be read as a program is not touched, nor is one that is well; the others are written all the
    same. Errors: all of theirs.
    """
    wrong: list[Diagnostic] = []
    changed = 0
    for name in dict.fromkeys(options.files):
        try:
            changed += _standard_input(options.check) if name == "-" else _file(name, options)
        except PoreError as error:
            wrong += error.diagnostics
    if wrong:
        raise PoreError(wrong)
    return 1 if options.check and changed else 0


def _standard_input(check: bool) -> bool:
    source = read_standard_input()
    text = formatted(source)
    if not check:
        print(text, end="")
    elif text != source.text:
        report.note(f"standard input {_where(source, text)}")
    return text != source.text


def _file(name: str, options: Namespace) -> bool:
    source = read_source(name)
    text = formatted(source)
    if text == source.text:
        return False
    if options.check:
        report.note(f"{name} {_where(source, text)}")
        return True
    save(destination(name), lambda file: _write(file, text))
    if not options.quiet:
        report.note(f"{name}: written anew")
    return True


def _where(source: Source, text: str) -> str:
    """Where a text is first written otherwise."""
    old, new = source.text.split("\n"), text.split("\n")
    at = next((i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), min(len(old), len(new)))
    said = f", where it would be `{new[at].strip()}`" if at < len(new) and new[at].strip() else ""
    return f"is not as `pore fmt` writes it, from line {at + 1}{said}"


def _write(file: BinaryIO, text: str) -> None:
    file.write(text.encode())
