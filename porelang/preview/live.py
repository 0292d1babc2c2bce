"""A file as it is edited and set on a page: what the page is told of it, and the scene of the last program that was
well."""

from __future__ import annotations

import threading
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
from porelang.preview.doing import Message, begin, refusal
from porelang.preview.exports import Made
from porelang.preview.look import Look, word
from porelang.preview.scene import Wish, usual
from porelang.preview.seen import Seen
from porelang.program import Design, Program
from porelang.progress import checkpoint
from porelang.render.picture import field_of
from porelang.session import Session, Snapshot
from porelang.session.jobs import Job
from porelang.settings import Setting, settle

#: Seconds that nothing has to change for before the part is measured, and between two looks whether it is drawn.
STILL, LOOK = 0.8, 0.05


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
    Whatever takes long is a job of its purpose (`text`, `scene`, `measure`, `export`), of which the latest wins. What
    is refused is so by its purpose too, and stays until something is told of that again.
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
        self._begun: told.Settings = {}  # what the command has set
        self.wish = Wish()
        self._seen = Seen(self.session.jobs, lambda message: self.tell(message))
        self._measured: Any = None  # of what the measures are that were told last, where they are of what is set
        self._wanted: object = None  # whoever measures now
        self._order = threading.Lock()  # of what is told of measures
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
        self._taken(self.document.read())
        self.tell({"say": "text", "text": self.document.text})

    def _reread(self) -> None:
        document = self.document
        if not document.changed_on_disk():  # but a file that it uses, or its data
            self._taken(document.edit(document.text))
        elif document.dirty:
            self.tell({"say": "conflict"})
        else:
            self._read()

    def edit(self, text: str) -> None:
        """The text is being written."""
        self.session.submit("text", lambda: self._taken(self.document.edit(text)))

    def save(self, text: str, over: bool = False) -> None:
        """Write the text into the file, unless another program has changed that."""
        try:
            if not self.document.write(text, over):
                self.tell({"say": "conflict"})
                return
        except PoreError as error:
            self._refused("save", error)
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
            self._refused("style", error)

    def complete(self, number: int, text: str, offset: int) -> None:
        """What may be written at a place, as the answer to the page's question of this number."""
        snapshot = self.document.edit(text)
        items = completions(snapshot, told.characters(text, offset))
        self.tell({"say": "completions", "number": number, "items": told.completions(items, text)})

    # ---- what is drawn ----------------------------------------------------------------------------------------------

    def set(self, settings: Mapping[str, float | str]) -> None:
        """Set params, in base units, by their words, or as texts with units. What cannot be is told, and not taken; the
        answer is what all are now."""
        program = self._good()
        if program is None:  # they are looked at when there is one
            self.settings = {**self.settings, **settings}
            self.tell({"say": "settings", "settings": {}})
            return
        before = self._values(program)
        wrong: list[Diagnostic] = []
        for name, value in settings.items():
            try:
                number = settle(program.params, {name: value})[name]
            except PoreError as error:
                wrong += error.diagnostics
            else:
                self.settings = {**self.settings, name: told.word(program.params[name], number)}
        values = self._values(program)
        known = {name: told.word(program.params[name], value) for name, value in values.items()}
        self.tell({"say": "settings", "settings": known})
        self.tell(refusal("settings", wrong))
        if values != before:
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
        if purpose == "scene":
            self.wish = self._seen.cancel() or self.wish
            return
        self.session.jobs.cancel(purpose)
        if purpose == "measure" and self._measured is None:
            self.tell({"say": "unmeasured"})

    def _good(self) -> Program | None:
        found = self.session.snapshot(self.document.path)
        return None if found is None else found.good

    def _values(self, program: Program) -> dict[str, float]:
        return settle(program.params, told.kept(program, self.settings))

    def _design(self) -> Design:
        program = self._good()
        assert program is not None, "it has been drawn"
        return program.design(self.settings)

    def _program(self, found: Snapshot) -> dict[str, Any]:
        of_command = {"file": self._called, "again": ""} if self._called else {}
        return told.program(found, self.settings, self._begun) | of_command

    def _taken(self, found: Snapshot) -> None:
        if found.good is not None:
            self._begin_with(found.good)
            self.settings = told.kept(found.good, self.settings)
            bodies = set(found.good.outputs)
            self.wish = Wish(tuple(n for n in self.wish.outputs if n in bodies), self.wish.paint, self.wish.plane)
        self.tell(self._program(found) | {"wish": word(self.wish)})
        if self._seen.refused:  # a line of it may be another now; if it is not, that is told again
            self.tell(refusal("scene", []))
        if found.program is not None:
            self._measured = None
            self._draw()

    def _begin_with(self, program: Program) -> None:
        start, self._start = self._start, None
        if start is None:
            return
        if start.settings or start.preset:
            try:
                values = program.design(start.settings, preset=start.preset).settings
            except PoreError as error:
                self._refused("settings", error)
            else:
                said = {*start.settings, *program.presets.get(start.preset or "", {})}
                self._begun = {name: told.word(program.params[name], values[name]) for name in said}
        # its own are later than those of the command
        self.settings = {**self._begun, **told.kept(program, self._look.settings)}
        self.wish = self._look.wished(program)

    def _draw(self) -> None:
        """Draw what is set now, and measure it when it is drawn, or cannot be."""
        program = self._good()
        if program is None:
            return
        drawing = self._seen.draw(program, self.settings, self.wish)
        wanted = self._part(program)
        with self._order:  # who measured until now tells nothing more
            self._wanted = wanted
            if wanted != self._measured:
                self._measured = None
                self.tell({"say": "unmeasured"})
        self._job("measure", lambda: self._examined(drawing, wanted), "measuring")

    def _examined(self, drawing: Job[None], wanted: object) -> None:
        """Tell what is doubtful of the part and its colours, and what it measures, unless that was told before."""

        def tell(message: Message) -> None:
            checkpoint()
            with self._order:
                if self._wanted is wanted:
                    self.tell(message)

        until = time.monotonic() + STILL
        while not drawing.done or time.monotonic() < until:
            until = until if drawing.done else time.monotonic() + STILL
            time.sleep(LOOK)
            checkpoint()
        try:
            found = self._looked_at(tell)
            with self._order:
                if self._wanted is wanted:
                    self._measured = found
        except PoreError as error:
            tell({"say": "unmeasured"})
            message = refusal("measure", error.diagnostics)
            if message["text"] != self._seen.refused:  # it is told once
                tell(message)

    def _part(self, program: Program) -> Any:
        """Of what measures are, as it is set now."""
        return self._values(program), self.wish.outputs[:1]

    def _looked_at(self, tell: Callable[[Message], None]) -> Any:
        """What was measured, which is not what was to be drawn where that was cancelled."""
        found, anew, doubts = self.session.snapshot(self.document.path), self._measured is None, list[Diagnostic]()
        try:
            design, wish = self._design(), self.wish
            program = design.program
            part = self._part(program)
            output = program.output(wish.outputs[0] if wish.outputs else usual(program))
            if anew:
                tell({"say": "measuring", "output": output})
            paint = Look(wish=wish).wished(program).paint
            painted = field_of(program, paint, "colour by").roots if paint else ()
            doubts = design.told(*program.roots(output), *program.graph.checks, *painted)
        finally:  # what is doubtful of a text is told also where there is no design of it
            if found is not None and found.program is not None:
                tell(told.doubts(found, doubts))
        if anew:
            tell(told.checked(design))
            with np.errstate(all="ignore"):  # a field may be infinite somewhere, and that is told
                tell(told.measured(Report(output, measure(design, output))))
        return part

    def _refused(self, purpose: str, error: PoreError) -> None:
        self.tell(refusal(purpose, error.diagnostics))

    def _job(self, purpose: str, work: Callable[[], None], said: str = "") -> None:
        begin(self.session.jobs, purpose, work, self.tell, said)
