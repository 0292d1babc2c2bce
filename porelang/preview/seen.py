"""The picture that somebody looks at: drawn while they go on, refused, cancelled; and of what it is meanwhile."""

from __future__ import annotations

from collections.abc import Mapping

from porelang.preview.doing import Message, Tell, begin, draw
from porelang.preview.look import Look, word
from porelang.preview.scene import Wish, usual
from porelang.program import Design, Program
from porelang.session.jobs import Job, Jobs
from porelang.settings import Setting, settle

Settings = Mapping[str, Setting]


class Seen:
    """The picture of what was asked for last, as soon as it is there. `tell` is told of each, and of what is wrong with
    one: then also of what the picture is that stays. `refused` is why there is none of what was asked for last."""

    def __init__(self, jobs: Jobs, tell: Tell) -> None:
        self._jobs, self._tell = jobs, tell
        self._asked: tuple[Program, Settings, Wish] | None = None
        self._shown: tuple[Design, Wish] | None = None
        self._job: Job[None] | None = None
        self.refused = ""

    def draw(self, program: Program, settings: Settings, wish: Wish) -> Job[None]:
        """Have this drawn; what was asked for before is not wanted any more."""
        self._asked, self.refused = (program, settings, wish), ""

        def work() -> None:
            design = program.design(settings)

            def tell(message: Message) -> None:
                self._shown = design, wish
                self._tell(message)

            draw(design, wish, tell)

        self._job = begin(self._jobs, "scene", work, self._told)
        return self._job

    def cancel(self) -> Wish | None:
        """What is seen stays, and so do its outputs and colours: they are what is wished for from now on. None where
        nothing was being drawn."""
        job = self._job
        self._jobs.cancel("scene")
        if job is None or job.done or self._asked is None:
            return None
        still = self.still()
        program, settings, wish = self._asked
        if self._shown is not None:
            wish = Look(wish=self._shown[1]).wished(program)
        self._asked = program, settings, wish
        if still or self._shown is None:  # else it was only to be drawn more quickly
            text = f"Cancelled. {_as_before(still) or 'Nothing is drawn yet.'}"
            self._tell({"say": "stopped", "of": "scene", "text": text, "wish": word(wish)})
        return wish

    @property
    def lacks(self) -> bool:
        """Whether what was asked for last is not seen, and nobody draws it."""
        job = self._job
        return job is not None and (job.done or job.cancelled) and (self._shown is None or bool(self.still()))

    def still(self) -> str:
        """Of what the picture is, in so far as it is not of what was asked for; "" where it is."""
        if self._shown is None or self._asked is None:
            return ""
        (design, before), (program, settings, wish) = self._shown, self._asked
        if design.program.source.text != program.source.text:
            return "of the program as it was"
        now, then = settle(program.params, settings), design.settings
        parts = [
            f"{n} = {info.shown(then[n])}" for n, info in program.params.items() if n in then and then[n] != now[n]
        ]
        if wish.outputs != before.outputs:
            parts.append(", ".join(f"`{name}`" for name in before.outputs or [usual(program)]))
        if wish.paint != before.paint:
            parts.append(f"the colours of `{before.paint}`" if before.paint else "no colours of a field")
        if wish.plane != before.plane:
            parts.append(f"{'the' if before.plane else 'no'} field on the section")
        return ", ".join(parts)

    def _told(self, message: Message) -> None:
        if isinstance(message, dict) and message["say"] == "refused":
            self.refused = message["text"]
            message = message | {"text": "\n\n".join(filter(None, [self.refused, _as_before(self.still())]))}
        self._tell(message)


def _as_before(still: str) -> str:
    return still and f"The picture is as before: {still}."
