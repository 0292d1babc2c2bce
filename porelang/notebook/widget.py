"""The viewer in a notebook: what is set are traits, the same here and in the browser; scenes travel as messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import anywidget
import traitlets

from porelang import values
from porelang.asked import read
from porelang.diagnostics import PoreError, fail
from porelang.notebook.still import fallback
from porelang.preview import told
from porelang.preview.doing import Message, refusal
from porelang.preview.look import word
from porelang.preview.scene import Scene, Wish
from porelang.preview.seen import Seen
from porelang.preview.wire import packed, texts
from porelang.program import Design, Program
from porelang.render.cuts import HalfSpace
from porelang.render.picture import field_of
from porelang.session.jobs import Jobs
from porelang.settings import Setting, settle

#: Traits of which each change is another scene.
DRAWN = ("settings", "outputs", "paint", "plane")
#: What a viewer may be high, in pixels.
LOWEST, HIGHEST = 100, 4000


class Viewer(anywidget.AnyWidget):
    """A part to be turned, cut and set in a notebook.

    `settings` has the value of every param, in base units (mm, rad, N, MPa) or by its word. What is assigned may name
    some, also with units (`viewer.settings = {"w": "2cm"}`): the others stay. `outputs` are those that are drawn (none:
    the usual one), `paint` the field that gives the colours, `plane` whether it is shown on the section, `cut` the
    section, as `pore render --cut` has it (`"y<0"`, "" for none). `wrong` is why what was last assigned was not taken,
    or why it is not drawn; "" where nothing is wrong. Each of these can be observed; `design` has the settings bound.
    """

    _esm = Path(__file__).with_name("widget.js")
    settings = traitlets.Dict().tag(sync=True)
    outputs = traitlets.List(traitlets.Unicode()).tag(sync=True)
    paint = traitlets.Unicode().tag(sync=True)
    plane = traitlets.Bool().tag(sync=True)
    cut = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(460).tag(sync=True)  # in pixels
    still = traitlets.Bytes().tag(sync=True)  # a PNG, seen until there is more; all that a saved notebook has
    wrong = traitlets.Unicode()

    def __init__(self, program: Program, settings: Mapping[str, Setting] | None = None, **traits: Any) -> None:
        self.program = program
        self._jobs = Jobs()
        self._seen = Seen(self._jobs, lambda message: self._tell(message))
        self._known: list[str | None] = []  # the shaders that the browser has
        self._asked: Any = None  # what is to be drawn; None before a browser has asked for it
        self._from_browser = False
        # what was accepted: where several traits are set at once, they have their new values before they are validated
        self._accepted: dict[str, Any] = {"settings": {}, "outputs": [], "paint": "", "cut": "", "height": 460}
        self._why: dict[str, str] = {}  # what is wrong, by its purpose: what is set, or the picture of it
        self._refused: set[str] = set()
        self._still_of: Any = None  # what was set when the still picture was made
        super().__init__(settings=dict(settings or {}), **traits)
        self.on_msg(self._hear)
        self.observe(self._changed, list(DRAWN))

    @property
    def design(self) -> Design:
        """The program with what is set bound. Errors: those of `Program.design`."""
        return self.program.design(self.settings)

    def close(self) -> None:
        """It is not wanted any more."""
        self._jobs.cancel()
        super().close()

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        made = super()._repr_mimebundle_(**kwargs)
        if made is None:
            return None
        data, metadata = made if isinstance(made, tuple) else (made, {})
        what = (self.settings, self.outputs)
        known = self.still if what == self._still_of else None
        instead, self.still = fallback(self.program, self.settings, self.outputs, known)
        self._still_of = what
        return {**instead, **data}, metadata

    def __repr__(self) -> str:
        return f"<viewer of {self.program.source.name}>"

    # ---- what is set ------------------------------------------------------------------------------------------------

    def set_state(self, sync_data: Any) -> None:
        """Take over what was set in the browser; what cannot be is told there, and not taken."""
        self._from_browser = True
        try:
            super().set_state(sync_data)
        finally:
            self._from_browser = False
            refused, self._refused = self._refused, set()
            if not refused:
                self._well()
            for name in refused:
                self.send_state(name)

    @traitlets.validate("settings")
    def _settled(self, proposal: Any) -> Any:
        try:
            found = settle(self.program.params, {**self._accepted["settings"], **proposal["value"]})
        except PoreError as error:
            return self._rejected("settings", error)
        return self._taken("settings", {n: self._value(n, v) for n, v in found.items()})

    @traitlets.validate("outputs")
    def _chosen(self, proposal: Any) -> Any:
        try:
            found = [self.program.output(name) for name in proposal["value"]]
        except PoreError as error:
            return self._rejected("outputs", error)
        return self._taken("outputs", found)

    @traitlets.validate("paint")
    def _painted(self, proposal: Any) -> Any:
        text = proposal["value"].strip()
        try:
            if text:
                field_of(self.program, text, "colour by")
        except PoreError as error:
            return self._rejected("paint", error)
        return self._taken("paint", text)

    @traitlets.validate("plane")
    def _planed(self, proposal: Any) -> Any:
        return self._taken("plane", proposal["value"])

    @traitlets.validate("height")
    def _high(self, proposal: Any) -> Any:
        pixels = proposal["value"]
        if not LOWEST <= pixels <= HIGHEST:
            return self._rejected("height", fail("E108", f"height: a viewer cannot be {pixels} pixels high",
                                                 hint=f"from {LOWEST} to {HIGHEST} it can"))  # fmt: skip
        return self._taken("height", pixels)

    @traitlets.validate("cut")
    def _sides(self, proposal: Any) -> Any:
        text = proposal["value"]
        try:
            sides = read("cut", text, values.cut) if text.strip() else ()
            if len(sides) > 1:
                raise fail("E108", f"cut: `{text}` has {len(sides)} sides, and a viewer cuts at one",
                           hint='`render(cut=...)` draws more; as in cut="y<0"')  # fmt: skip
        except PoreError as error:
            return self._rejected("cut", error)
        return self._taken("cut", "".join(str(HalfSpace(*side)) for side in sides))

    def _value(self, name: str, value: float) -> Setting:
        """A value of a param as it is shown: what counts something is a whole number."""
        info = self.program.params[name]
        return int(value) if info.structural and not info.choices else told.word(info, value)

    def _taken(self, name: str, value: Any) -> Any:
        same = self._accepted.get(name) == value
        self._accepted[name] = value
        if not self._from_browser:  # of several that are set there, one may be refused
            self._well()
            if same and name in DRAWN:  # nobody is told of a change
                self._again()
        return value

    def _rejected(self, name: str, error: PoreError) -> Any:
        """What a trait is where it cannot be what was asked for. Errors: why, unless a browser has asked."""
        self._tell(refusal("settings", error.diagnostics))
        if not self._from_browser:
            raise error
        self._refused.add(name)
        return self._accepted[name]

    def _well(self) -> None:
        """What was last set has been taken: what was wrong with something before it is past."""
        if self._why.get("settings"):
            self._tell(refusal("settings", []))

    # ---- what is drawn ----------------------------------------------------------------------------------------------

    def _hear(self, _: object, word: Any, buffers: Sequence[Any]) -> None:
        match word:
            case {"do": "begin"}:
                self._known = []
                about = told.described(self.program, self.settings)
                self._tell({"say": "program", "file": self.program.source.name.strip("<>"), "wrong": [], **about})
                self._draw()
            case {"do": "preset", "name": str(name)}:
                presets = self.program.presets
                if not name or name in presets:
                    defaults = {n: self._value(n, info.default) for n, info in self.program.params.items()}
                    self.settings = defaults | presets.get(name, {})
            case {"do": "again"}:
                self._again()
            case {"do": "cancel"}:
                self._cancel()

    def _cancel(self) -> None:
        """What is seen stays, and so do its outputs and colours."""
        wish = self._seen.cancel()
        if wish is None:
            return
        self._asked = self.settings, wish
        with self.hold_trait_notifications():
            for name, value in word(wish).items():
                if getattr(self, name) != value:
                    setattr(self, name, value)

    def _again(self) -> None:
        """What was cancelled, or refused, is asked for again."""
        if self._seen.lacks:
            self._draw()

    def _changed(self, change: Any) -> None:
        if self._asked not in (None, self._wished()):
            self._draw()

    def _wished(self) -> tuple[dict[str, Any], Wish]:
        return self.settings, Wish(tuple(self.outputs), self.paint.strip(), self.plane)

    def _draw(self) -> None:
        self._asked = _, wish = self._wished()
        self._wrong("scene", "")  # of what was set before
        self._seen.draw(self.program, self.settings, wish)

    def _tell(self, message: Message) -> None:
        if isinstance(message, Scene):
            self._wrong("scene", "")
            self.send({"say": "scene"}, buffers=[packed(message, self._known)])
            self._known = texts(message)
            return
        if message["say"] in ("refused", "stopped"):
            self._wrong(message["of"], message["text"])
        self.send(message)

    def _wrong(self, purpose: str, text: str) -> None:
        self._why[purpose] = text
        self.wrong = self._why.get("settings") or self._why.get("scene", "")
