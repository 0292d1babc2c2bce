"""Messages in the words of a page, which has no options of a command: `a voxel of 0.9mm` for `--voxel 0.9mm`."""

from __future__ import annotations

import re
from dataclasses import replace

from porelang.diagnostics import Diagnostic

_END = "intersect it with a shape that holds it, as in `... & box([50, 50, 50])`"
#: What an option is called on a page, or what is done there instead; the first that fit come first.
_WORDS = [
    (re.compile(words), instead)
    for words, instead in (
        (r"[,;:]?(?: or)? (?:take a part of it, with|mesh it with|pass) --bounds(?: x0,\S*z1)?", ""),
        (r"^pass --bounds x0,.*", _END),
        (r"^say where it ends, as by --bounds=\S+, which holds what samples found", _END),
        (r"smaller --bounds", "a smaller part"),
        (r"keep it as it is, --force", "have it as it is"),
        (r"--voxel (\d[\w.]*)", r"a voxel of \1"),
    )
]
#: An option that is left; those in the command that is named are that command's.
_OPTION = re.compile(r"`[^`]*`|(?<![\w-])--([a-z][a-z-]*)")


def on_page(d: Diagnostic) -> Diagnostic:
    """A diagnostic as a page tells it."""
    return replace(d, message=_said(d.message), label=_said(d.label), hint=_said(d.hint))


def _said(text: str) -> str:
    for words, instead in _WORDS:
        text = words.sub(instead, text)
    return _OPTION.sub(lambda found: found[1] or found[0], text)
