"""A file as it is edited and set on a page: what the page is told of it, and the scene of the last program that was
well."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.asked import Report
from porelang.assist.complete import completions
from porelang.diagnostics import Diagnostic, PoreError
from porelang.elaborate.context import Bound
from porelang.measure import measure
from porelang.preview import told
from porelang.preview.document import Document
from porelang.preview.doing import Message, begin, draw, refusal
from porelang.preview.exports import Made
from porelang.preview.look import Look, word
from porelang.preview.scene import Wish, usual
from porelang.program import Design, Program
from porelang.progress import checkpoint
from porelang.session import Session, Snapshot
from porelang.session.jobs import Job
from porelang.settings import Setting, settle

#: Seconds that nothing has to change for before the part is measured.
STILL = 0.8


@dataclass(frozen=True, slots=True)
class Start:
    """What a page begins with: params as `pore` takes them, a preset, and what is bound to params that take data; what
    it is `called` where its file has no name that anybody gave it."""

    settings: Mapping[str, Setting]
    preset: str | None
    bound: Mapping[str, Bound]
    called: str = ""


NOTHING = Start({}, None, {})


class Live:
    """A program on a page. `tell` is called with what the page is to know, from whichever thread knows it first.

    A text with an error keeps the program before it, and its picture; settings stay as long as a param takes them.
    Whatever takes long is a job of its purpose (`text`, `scene`, `measure`, `export`), of which the latest wins.
    """

    def __init__(
        self, path: str, tell: Callable[[Message], None], start: Start = NOTHING, look: Look | None = None
    ) -> None:
        self.session = Session(bound=start.bound)
        self._start: Start | None = start
        self._called = start.called
        self._look = look or Look()
        self.document = Document(self.session, path)
        self.tell = tell
        self.settings: told.Settings = {}
        self.wish = Wish()
        self._shown: tuple[Design, Wish] | None = None  # of what the picture is
        self._drawing: Job[None] | None = None
        self.made = Made()

    def begin(self) -> None:
        """A page that knows nothing is there."""
        self._reading(self._read)

    def close(self) -> None:
        """Nobody looks any more."""
        self.session.jobs.cancel()
        self.made.close()

    # ---- the text ---------------------------------------------------------------------------------------------------

    def reread(self) -> None:
        """Something was saved, here or elsewhere."""
        self._reading(self._reread)

    def _reading(self, work: Callable[[], None]) -> None:
        """Do what reads the file; where that cannot be read, it is told."""
        try:
            work()
        except PoreError as error:
            self._refused("text", error)

    def _read(self) -> None:
        self._seen(self.document.read())
        self.tell({"say": "text", "text": self.document.text})

    def _reread(self) -> None:
        document = self.document
        if not document.changed_on_disk():  # but a file that it uses, or its data
            self._seen(document.edit(document.text))
        elif document.dirty:
            self.tell({"say": "conflict"})
        else:
            self._read()

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
        """Set params, in base units, by their words, or as texts with units. What cannot be is told, and not taken."""
        program = self._good()
        if program is None:  # they are looked at when there is one
            self.settings = {**self.settings, **settings}
            return
        taken: told.Settings = {}
        wrong: list[Diagnostic] = []
        for name, value in settings.items():
            try:
                number = settle(program.params, {name: value})[name]
            except PoreError as error:
                wrong += error.diagnostics
            else:
                taken[name] = told.word(program.params[name], number)
        self.settings = {**self.settings, **taken}
        if wrong or any(taken[name] != settings[name] for name in taken):  # a slider knows where it is
            values = program.design(self.settings).settings
            known = {n: told.word(program.params[n], values[n]) for n in settings if n in program.params}
            self.tell({"say": "settings", "settings": known})
        self.tell(refusal("settings", wrong))
        if taken:
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
            values = program.design(self.settings).settings  # a preset may say them with units
            self.settings = {n: told.word(program.params[n], values[n]) for n in self.settings}
            self.tell(self._program(found))
        self._draw()

    def show(self, wish: Wish) -> None:
        """Have other outputs drawn, in other colours."""
        self.wish = wish
        self._draw()

    def export(self, output: str, ending: str, voxel: str, force: bool = False) -> None:
        """Mesh an output into a file that the page can have, with `force` even where it has lost much of the part."""

        def work() -> None:
            try:
                name, what = self.made.mesh(self._design(), output, ending, voxel, force)
            except PoreError as error:
                lost = any(d.code == "E118" for d in error.diagnostics)  # what there is can be had all the same
                self.tell(refusal("export", error.diagnostics) | {"lost": lost})
            else:
                self.tell({"say": "made", "name": name, "what": what})

        self._job("export", work)

    def cancel(self, purpose: str) -> None:
        """What is being done for a purpose is not wanted any more; what is shown stays, and so do its colours."""
        self.session.jobs.cancel(purpose)
        if purpose != "scene" or self._drawing is None or self._drawing.done:
            return
        still = self._still()
        if self._shown is not None and (program := self._good()) is not None:
            self.wish = Look(wish=self._shown[1]).wished(program)
        if still or self._shown is None:  # else it was only to be drawn more quickly
            self.tell({"say": "stopped", "of": purpose, "still": still, "wish": word(self.wish)})

    def _good(self) -> Program | None:
        found = self.session.snapshot(self.document.path)
        return None if found is None else found.good

    def _design(self) -> Design:
        program = self._good()
        assert program is not None, "it has been drawn"
        return program.design(self.settings)

    def _program(self, found: Snapshot) -> dict[str, Any]:
        return told.program(found, self.settings) | ({"file": self._called, "again": ""} if self._called else {})

    def _seen(self, found: Snapshot) -> None:
        if found.good is not None:
            self._begin_with(found.good)
            self.settings = told.kept(found.good, self.settings)
            bodies = set(found.good.outputs)
            self.wish = Wish(tuple(n for n in self.wish.outputs if n in bodies), self.wish.paint, self.wish.plane)
        self.tell(self._program(found) | {"wish": word(self.wish)})
        if found.program is not None:
            self._draw()

    def _begin_with(self, program: Program) -> None:
        start, self._start = self._start, None
        if start is None:
            return
        if start.settings or start.preset:
            try:
                values = program.design(start.settings, preset=start.preset).settings
            except PoreError as error:
                self._refused("text", error)
            else:
                self.settings = {name: told.word(program.params[name], v) for name, v in values.items()}
        self.settings = {**self.settings, **self._look.settings}  # its own are later than those of the command
        self.wish = self._look.wished(program)

    def _draw(self) -> None:
        if self._good() is not None:
            self._drawing = begin(self.session.jobs, "scene", self._drawn, self._of_scene)

    def _of_scene(self, message: Message) -> None:
        """Tell a word about the picture; of what it is still, where it is refused."""
        if isinstance(message, dict) and message["say"] == "refused":
            message = message | {"still": self._still()}
        self.tell(message)

    def _still(self) -> str:
        """Of what the picture is, in so far as it is not of what is set; "" where it is."""
        program = self._good()
        if self._shown is None or program is None:
            return ""
        design, wish = self._shown
        if design.program.source.text != program.source.text:
            return "of the program as it was"
        now, then = settle(program.params, self.settings), design.settings
        parts = [
            f"{n} = {info.shown(then[n])}" for n, info in program.params.items() if n in then and then[n] != now[n]
        ]
        if self.wish.outputs != wish.outputs:
            parts.append(", ".join(f"`{name}`" for name in wish.outputs or [usual(program)]))
        if self.wish.paint != wish.paint:
            parts.append(f"the colours of `{wish.paint}`" if wish.paint else "no colours of a field")
        if self.wish.plane != wish.plane:
            parts.append(f"{'the' if wish.plane else 'no'} field on the section")
        return ", ".join(parts)

    def _drawn(self) -> None:
        design, wish = self._design(), self.wish

        def tell(message: Message) -> None:
            self._shown = design, wish
            self.tell(message)

        made = draw(design, wish, tell)
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
