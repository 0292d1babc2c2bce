"""What is said to a user about their program: one type for errors, warnings and notes."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any, Literal

from porelang.html import brief, verbatim
from porelang.source import Source, Span

Severity = Literal["error", "warning", "note"]
TAB = "    "
WIDEST = 160  # a longer source line is shown as a window round the caret


@dataclass(frozen=True, slots=True)
class Label:
    """A place that matters to a diagnostic, and what is to be seen there."""

    span: Span
    text: str = ""


#: Nobody reads more; the first are the likeliest causes.
MOST_DIAGNOSTICS = 100


@dataclass(frozen=True, slots=True)
class Edit:
    """A change of the text that mends the program: replace `span` by `text`."""

    span: Span
    text: str

    def apply(self, text: str) -> str:
        """The text of the file with this change."""
        place = self.span.in_file
        return text[: place.start] + self.text + text[place.end :]


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One thing that is wrong or doubtful in a program, with its place, reason and way out; or a note, what was found.

    `code` is stable and listed in `porelang.error_codes`, "" for a note; `label` stands under the caret; `others` are
    the second places that matter; `hint` is a sentence that says what to do; `edit`, where there is one, does it.
    """

    code: str
    message: str
    span: Span | None = None
    label: str = ""
    others: tuple[Label, ...] = ()
    hint: str = ""
    edit: Edit | None = None
    severity: Severity = "error"

    @property
    def told(self) -> tuple[str, Span | None]:
        """What is said, and at which place of which file: the same for a program that was compiled twice."""
        return self.code, None if self.span is None else self.span.in_file

    def __str__(self) -> str:
        return render(self)

    def __repr__(self) -> str:
        place = "" if self.span is None else f" at {self.span}"
        return f"<{f'{self.severity} {self.code}'.rstrip()}{place}: {brief(self.message)}>"

    def _repr_html_(self) -> str:
        return verbatim(render(self))

    def to_json(self) -> dict[str, Any]:
        """The object that `pore check --json` prints for this diagnostic."""
        place: dict[str, Any] = {"file": None, "line": None, "column": None, "end_line": None, "end_column": None}
        if self.span is not None:
            place = _place(self.span)
        edit = None if self.edit is None else {**_place(self.edit.span), "text": self.edit.text}
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            **place,
            "label": self.label,
            "others": [{**_place(o.span), "label": o.text} for o in self.others],
            "hint": self.hint,
            "edit": edit,
        }


class PoreError(Exception):
    """A program, or a request about one, was rejected; `diagnostics` says why."""

    def __init__(self, diagnostics: Iterable[Diagnostic] | Diagnostic) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = (
            (diagnostics,) if isinstance(diagnostics, Diagnostic) else tuple(diagnostics)
        )
        super().__init__("\n\n".join(render(_in_python(d)) for d in self.diagnostics))

    def __reduce__(self) -> tuple[Any, ...]:
        return (PoreError, (self.diagnostics,))

    def __repr__(self) -> str:
        return f"PoreError({', '.join(map(repr, self.diagnostics))})"

    def _render_traceback_(self) -> list[str]:
        """What a notebook shows: the lines of its own that led here, and what is wrong, without what lies between."""
        import traceback

        inside = os.path.dirname(__file__) + os.sep
        between = [f"{os.sep}{name}{os.sep}" for name in ("IPython", "traitlets")]  # a viewer's are assigned by these
        own = [f for f in traceback.extract_tb(self.__traceback__)
               if not f.filename.startswith(inside) and not any(name in f.filename for name in between)
               and "run_cell_magic('pore'" not in (f.line or "")]  # fmt: skip
        if not own:  # a cell that is a program
            return str(self).split("\n")
        return [line.rstrip("\n") for line in traceback.format_list(own)] + ["", *str(self).split("\n")]


class PoreWarning(UserWarning):
    """What is doubtful about a program, or about what was made of it, as Python warns; `diagnostic` says it."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(render(_in_python(diagnostic)))

    def __reduce__(self) -> tuple[Any, ...]:
        return (PoreWarning, (self.diagnostic,))


def warn(found: Iterable[Diagnostic]) -> None:
    """Tell whoever called this package of each diagnostic, as a `PoreWarning` at their line."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "porelang":
        level, frame = level + 1, frame.f_back
    for d in found:
        if d.severity == "warning" or d.severity == "error":
            warnings.warn(PoreWarning(d), stacklevel=level)


def fail(code: str, message: str, span: Span | None = None, **more: Any) -> PoreError:
    """A `PoreError` with one diagnostic, to be raised."""
    return PoreError(Diagnostic(code, message, span, **more))


#: An option of a command as it stands in a text, with its value if it is a number, a number type or the like.
_OPTION = re.compile(
    r"`pore (?P<command>\w+)(?P<options>(?: --[a-z-]+)+)`|`pore [^`]*`|"
    r"(?<![\w`-])--(?P<name>[a-z]+(?:-[a-z]+)*)"
    r"(?: (?P<value>\d[\w.]*(?:,\d[\w.]*)*|numpy|glsl|direct|ftetwild|none|NAME|[xyz]=\d\w*|x0,y0,z0,x1,y1,z1))?"
    r"(?![\w-])"
)
_FLAGS = frozenset({"force", "keep_islands", "resume", "refine"})
#: What a command is called in Python, of those that are called otherwise there.
_METHODS = {"fea": "study", "optimize": "iterate"}


def _in_python(d: Diagnostic) -> Diagnostic:
    """A diagnostic in the words of Python: `voxel="0.4mm"` for `--voxel 0.4mm`. Commands print what is in it."""
    message, label, hint = (_OPTION.sub(_keyword, text) for text in (d.message, d.label, d.hint))
    return replace(d, message=message, label=label, hint=hint)


def _keyword(option: re.Match[str]) -> str:
    if option["command"]:
        given = ", ".join(f"{flag.replace('-', '_')}=True" for flag in option["options"].replace(" --", " ").split())
        return f"`program.{_METHODS.get(option['command'], option['command'])}({given})`"
    if option["name"] is None:  # another command, as it is
        return option[0]
    name, value = option["name"].replace("-", "_"), option["value"]
    if value is None:
        return f"{name}=True" if name in _FLAGS else f"`{name}`"
    return f"{name}={value}" if value == "NAME" or value.isdigit() else f'{name}="{value}"'


def to_lists(found: Iterable[Diagnostic]) -> dict[str, list[dict[str, Any]]]:
    """Warnings and notes as `--json` lists them, by those keys."""
    told = list(found)
    return {f"{kind}s": [d.to_json() for d in told if d.severity == kind] for kind in ("warning", "note")}


def suggest(name: str, known: Iterable[str]) -> str | None:
    """The known name nearest to a misspelt one, if any is near."""
    if not isinstance(name, str):  # from Python anything may come
        return None
    names = list(known)
    lower = {n.lower(): n for n in names}
    if name.lower() in lower:
        return lower[name.lower()]
    near = get_close_matches(name, names, n=1, cutoff=0.6 if len(name) == 3 else 0.7)
    return near[0] if near else None


def in_order(found: Iterable[Diagnostic], main: Source) -> list[Diagnostic]:
    """By their places: those of the main file first, those without a place last."""

    def place(d: Diagnostic) -> tuple[bool, int]:
        at = None if d.span is None else d.span.in_file
        return (True, 0) if at is None else (at.source is not main, at.start)

    return sorted(found, key=place)


def render(d: Diagnostic) -> str:
    """The text of a diagnostic for a terminal: message, place, source lines with carets, hint. A note is one line."""
    if d.severity == "note":
        return f"note: {d.message}" if d.span is None else f"note: {d.span}: {d.message}"
    out = [f"{d.severity}[{d.code}]: {d.message}"]
    places = [] if d.span is None else [Label(d.span, d.label), *d.others]
    width = max((len(str(p.span.source.position(max(p.span.end - 1, p.span.start))[0])) for p in places), default=1)
    for i, place in enumerate(places):
        mark = "^" if i == 0 else "-"
        out.append(f"{' ' * width}--> {place.span}")
        out.extend(_excerpt(place, mark, width))
    if d.hint:
        out.append(f"{' ' * width} = hint: {d.hint}")
    return "\n".join(out)


def _excerpt(place: Label, mark: str, width: int) -> list[str]:
    span, source = place.span, place.span.source
    line, column = source.position(span.start)
    text = source.line(line)
    length = max(1, min(span.end - span.start, len(text) - column + 1))
    if len(text) > WIDEST:
        cut = max(0, column - 1 - WIDEST // 3)
        length = min(length, WIDEST // 2)
        text = ("..." if cut else "") + text[cut : cut + WIDEST] + "..."
        column = column - cut + (3 if cut else 0)
    before = text[: column - 1].replace("\t", TAB)
    shown = "".join(c if c.isprintable() else " " if c.isspace() else "\ufffd" for c in text.replace("\t", TAB))
    carets = mark * max(1, len(text[column - 1 : column - 1 + length].replace("\t", TAB)))
    gap = " " * width
    return [f"{gap} |", f"{line:>{width}} | {shown}", f"{gap} | {' ' * len(before)}{carets} {place.text}".rstrip()]


def _place(span: Span) -> dict[str, Any]:
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return {
        "file": span.source.name,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
    }
