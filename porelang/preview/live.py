"""A file as it is edited and set: what a page is told of it, and the scene of the last program that was well."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Callable
from typing import Any

from porelang.diagnostics import PoreError, in_order, render
from porelang.elaborate.results import ParamInfo
from porelang.preview.scene import Scene, scene
from porelang.program import Program
from porelang.session import Session, Snapshot

#: What a page is told: an object for JSON, or a scene.
Message = dict[str, Any] | bytes


class Live:
    """A program on a page. `tell` is called with what the page is to know, from whichever thread knows it first.

    A text with an error keeps the program before it, and its picture; settings stay as long as a param takes them.
    """

    def __init__(self, path: str, tell: Callable[[Message], None], session: Session | None = None) -> None:
        self.path, self.tell = os.path.normpath(path), tell
        self.session = session or Session()
        self.settings: dict[str, float | str] = {}
        self.output: str | None = None
        self._text = ""  # of the shader that the page has

    def read(self) -> Snapshot:
        """The file is as it is on disk now: tell of it, and draw it. Errors: E105, E106, E028 where it is none."""
        return self._seen(self.session.update(self.path))

    def choose(self, settings: dict[str, float | str] | None = None, output: str | None = None) -> None:
        """Set params, in base units or by their words, or have another output drawn; draw it."""
        self.settings |= settings or {}
        self.output = output or self.output
        self._draw()

    def begin(self) -> None:
        """A page that knows nothing is there."""
        self._text = ""
        found = self.session.snapshot(self.path)
        if found is None:
            self.read()
        else:
            self._seen(found)

    def close(self) -> None:
        """Nobody looks any more."""
        self.session.jobs.cancel()

    def _seen(self, found: Snapshot) -> Snapshot:
        if found.good is not None:
            self.settings = _kept(found.good, self.settings)
            if self.output not in found.good.outputs:
                self.output = None
        self.tell(_told(found, self.settings))
        self._draw()
        return found

    def _draw(self) -> None:
        found = self.session.snapshot(self.path)
        program = None if found is None else found.good
        if program is None:
            return
        settings, output = dict(self.settings), self.output
        self.session.submit("scene", lambda: self._drawn(program, settings, output))

    def _drawn(self, program: Program, settings: dict[str, float | str], output: str | None) -> None:
        self.tell({"say": "drawing"})
        try:
            made = scene(program.design(settings), output)
        except PoreError as error:
            self.tell({"say": "refused", "text": "\n\n".join(render(d) for d in error.diagnostics)})
            return
        self.tell(packed(made, known=made.text == self._text))
        self._text = made.text


def packed(made: Scene, known: bool = False) -> bytes:
    """A scene as one message: the length of its head, the head, blanks up to a multiple of 4 bytes, the textures. The
    shader is left out where it is `known`."""
    head = made.head()
    if known:
        head["text"] = None
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + made.body()


def _kept(program: Program, settings: dict[str, float | str]) -> dict[str, float | str]:
    """The settings that a program still takes."""
    kept: dict[str, float | str] = {}
    for name, value in settings.items():
        info = program.params.get(name)
        if info is None:
            continue
        if isinstance(value, str):
            fits = value in info.choices
        else:
            fits = value in info.numbers if info.numbers else not info.choices and info.low <= value <= info.high
        if fits:
            kept[name] = value
    return kept


def _told(found: Snapshot, settings: dict[str, float | str]) -> dict[str, Any]:
    """What a page shows of a program beside its picture; where its text is wrong, of the last that was well."""
    program = found.good
    return {
        "say": "program",
        "file": os.path.basename(found.path),
        "wrong": [render(d) for d in in_order(found.diagnostics, found.source) if d.severity == "error"],
        "doubts": [render(d) for d in in_order(found.diagnostics, found.source) if d.severity == "warning"],
        "params": [] if program is None else [_param(p, settings.get(p.name)) for p in program.params.values()],
        "outputs": [] if program is None else list(program.outputs),
    }


def _param(info: ParamInfo, value: float | str | None) -> dict[str, Any]:
    """A param for a slider: its value and range in base units, and the factor to the unit that it is shown in."""
    default = info.choices[int(info.default)] if info.choices and not info.numbers else info.default
    return {
        "name": info.name,
        "doc": info.doc,
        "value": default if value is None else value,
        "default": default,
        "low": info.low,
        "high": info.high,
        "step": info.step,
        "choices": list(info.numbers or info.choices),
        "unit": "" if info.dimension is None else info.dimension.unit,
    }
