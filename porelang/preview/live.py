"""A file as it is edited and set on a page: what the page is told of it, and the scene of the last program that was
well."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from porelang.asked import Report
from porelang.assist.complete import completions
from porelang.diagnostics import PoreError
from porelang.elaborate.context import Bound
from porelang.measure import measure
from porelang.preview import told
from porelang.preview.document import Document
from porelang.preview.doing import Message, begin, draw, refusal
from porelang.preview.exports import Made
from porelang.preview.scene import Wish
from porelang.program import Design, Program
from porelang.progress import checkpoint
from porelang.session import Session, Snapshot
from porelang.settings import Setting

#: Seconds that nothing has to change for before the part is measured.
STILL = 0.8


@dataclass(frozen=True, slots=True)
class Start:
    """What a page begins with: params as `pore` takes them, a preset, and what is bound to params that take data."""

    settings: Mapping[str, Setting]
    preset: str | None
    bound: Mapping[str, Bound]


NOTHING = Start({}, None, {})


class Live:
    """A program on a page. `tell` is called with what the page is to know, from whichever thread knows it first.

    A text with an error keeps the program before it, and its picture; settings stay as long as a param takes them.
    Whatever takes long is a job of its purpose (`text`, `scene`, `measure`, `export`), of which the latest wins.
    """

    def __init__(self, path: str, tell: Callable[[Message], None], start: Start = NOTHING) -> None:
        self.session = Session(bound=start.bound)
        self._start: Start | None = start
        self.document = Document(self.session, path)
        self.tell = tell
        self.settings: told.Settings = {}
        self.wish = Wish()
        self.made = Made()

    def begin(self) -> None:
        """A page that knows nothing is there. Errors: those of reading the file."""
        self._seen(self.document.read())
        self._text()

    def close(self) -> None:
        """Nobody looks any more."""
        self.session.jobs.cancel()
        self.made.close()

    # ---- the text ---------------------------------------------------------------------------------------------------

    def reread(self) -> None:
        """Something was saved, here or elsewhere. Errors: those of reading the file."""
        document = self.document
        if document.dirty and document.changed_on_disk():
            self.tell({"say": "conflict"})
        elif document.dirty:  # a file that it uses, or its data
            self._seen(document.edit(document.text))
        elif document.changed_on_disk():
            self._seen(document.read())
            self._text()
        else:
            self._seen(document.edit(document.text))

    def edit(self, text: str) -> None:
        """The text is being written."""
        self.session.submit("text", lambda: self._seen(self.document.edit(text)))

    def save(self, text: str, over: bool = False) -> None:
        """Write the text into the file, unless another program has changed that."""
        try:
            if not self.document.write(text, over):
                self.tell({"say": "conflict"})
                return
        except PoreError as error:
            self._refused("text", error)
            return
        self.tell({"say": "saved"})

    def discard(self) -> None:
        """Take the text that is on disk instead of the one here."""
        self.begin()

    def style(self, text: str) -> None:
        """Have the page show its text in the one style."""
        try:
            self.tell({"say": "styled", "text": self.document.styled(text)})
        except PoreError as error:
            self._refused("text", error)

    def complete(self, number: int, text: str, offset: int) -> None:
        """What may be written at a place, as the answer to the page's question of this number."""
        snapshot = self.document.edit(text)
        items = completions(snapshot, told.characters(text, offset))
        self.tell({"say": "completions", "number": number, "items": told.completions(items, text)})

    # ---- what is drawn ----------------------------------------------------------------------------------------------

    def set(self, settings: Mapping[str, float | str]) -> None:
        """Set params, in base units or by their words."""
        self.settings = {**self.settings, **settings}
        self._draw()

    def preset(self, name: str) -> None:
        """Set params by a name of the program; `""` sets all back to their defaults."""
        program = self._good()
        if program is None or (name and name not in program.presets):
            return
        self.settings = {}
        if name:
            self.settings = {n: v for n, v in program.presets[name].items() if isinstance(v, int | float | str)}
        found = self.session.snapshot(self.document.path)
        if found is not None:
            self.tell(told.program(found, self._numbers(program)))
        self._draw()

    def show(self, wish: Wish) -> None:
        """Have other outputs drawn, in other colours."""
        self.wish = wish
        self._draw()

    def export(self, output: str, ending: str, voxel: str) -> None:
        """Mesh an output into a file that the page can have."""

        def work() -> None:
            try:
                name, what = self.made.mesh(self._design(), output, ending, voxel)
            except PoreError as error:
                self._refused("export", error)
            else:
                self.tell({"say": "made", "name": name, "what": what})

        self._job("export", work)

    def cancel(self, purpose: str) -> None:
        """What is being done for a purpose is not wanted any more; what is shown stays."""
        self.session.jobs.cancel(purpose)

    def _good(self) -> Program | None:
        found = self.session.snapshot(self.document.path)
        return None if found is None else found.good

    def _design(self) -> Design:
        program = self._good()
        assert program is not None, "it has been drawn"
        return program.design(self.settings)

    def _numbers(self, program: Program) -> told.Settings:
        """The settings by number, as a page shows them: a preset may say them with units."""
        values = program.design(self.settings).settings
        self.settings = {n: told.word(program.params[n], values[n]) for n in self.settings}
        return self.settings

    def _text(self) -> None:
        self.tell({"say": "text", "text": self.document.text})

    def _seen(self, found: Snapshot) -> None:
        if found.good is not None:
            self._begin_with(found.good)
            self.settings = told.kept(found.good, self.settings)
            bodies = set(found.good.outputs)
            self.wish = Wish(tuple(n for n in self.wish.outputs if n in bodies), self.wish.paint, self.wish.plane)
        self.tell(told.program(found, self.settings))
        if found.program is not None:
            self._draw()

    def _begin_with(self, program: Program) -> None:
        start, self._start = self._start, None
        if start is None or not (start.settings or start.preset):
            return
        try:
            values = program.design(start.settings, preset=start.preset).settings
        except PoreError as error:
            self._refused("text", error)
            return
        self.settings = {name: told.word(program.params[name], v) for name, v in values.items()}

    def _draw(self) -> None:
        if self._good() is not None:
            self._job("scene", self._drawn)

    def _drawn(self) -> None:
        design = self._design()
        made = draw(design, self.wish, self.tell)
        self._job("measure", lambda: self._measured(design, made.bodies[0].layer.name), "measuring")

    def _measured(self, design: Design, output: str) -> None:
        until = time.monotonic() + STILL
        while time.monotonic() < until:
            time.sleep(0.05)
            checkpoint()
        self.tell({"say": "measuring", "output": output})
        try:
            found = self.session.snapshot(self.document.path)
            if found is not None and found.program is design.program:
                self.tell(told.doubts(found, design.told(*design.program.roots(output))))
            self.tell(told.checked(design))
            checkpoint()
            with np.errstate(all="ignore"):  # a field may be infinite somewhere, and that is told
                self.tell(told.measured(Report(output, measure(design, output))))
        except PoreError as error:
            self._refused("measure", error)

    def _refused(self, purpose: str, error: PoreError) -> None:
        self.tell(refusal(purpose, error.diagnostics))

    def _job(self, purpose: str, work: Callable[[], None], said: str = "") -> None:
        begin(self.session.jobs, purpose, work, self.tell, said)
