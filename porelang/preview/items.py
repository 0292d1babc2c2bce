"""What can be set in a window, one below the other, by keys and by the mouse: params, outputs, colours, the section."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from porelang.analysis.box import Box
from porelang.preview.drawing import Section
from porelang.preview.heard import Known
from porelang.preview.live import Live
from porelang.preview.scene import Wish

DEFAULTS = "defaults"


@dataclass(frozen=True, slots=True)
class Item:
    """One thing that is set: what it is called, what it is, and more of it for who chooses it; `step` takes it on (1)
    or back (-1), and what has a range lies at a `share` of it, and is put to another."""

    name: str
    value: str
    more: str
    step: Callable[[int], None]
    share: float | None = None
    put: Callable[[float], None] | None = None


@dataclass(slots=True)
class Desk:
    """What is set in a window. `stage` is the box of the scene, where there is one."""

    live: Live
    known: Known
    section: Section = field(default_factory=Section)
    stage: Box | None = None
    outputs: tuple[str, ...] = ()
    drawn: tuple[str, ...] = ()
    paint: str = ""
    plane: bool = True
    preset: str = ""

    def items(self) -> list[Item]:
        """All of it, as it is now."""
        known = self.known
        out = []
        if known.presets:
            out.append(Item("preset", self.preset or "-", "", self._preset))
        out += [self._param(p) for p in known.params]
        if len(known.bodies) > 1:
            out += [self._output(name) for name in known.bodies]
        out.append(Item("colours", self.paint or "plain", "the field that gives the colours", self.colour))
        across = "none" if self.section.axis < 0 else "across " + "xyz"[self.section.axis]
        out.append(Item("section", across, "", self._across))
        if self.section.axis >= 0 and self.stage is not None:
            out += [self._place(self.stage), Item("field on it", "yes" if self.plane else "no", "", self.field_on)]
        return out

    def wish(self) -> None:
        """Have drawn what is chosen."""
        self.live.show(Wish(self.outputs, self.paint, self.plane and self.section.axis >= 0))

    def wished(self, outputs: Sequence[str], paint: str, plane: bool) -> None:
        """What is drawn is this, says somebody else."""
        self.outputs, self.paint = tuple(outputs), paint
        self.plane = plane if self.section.axis >= 0 else self.plane

    # ---- params -----------------------------------------------------------------------------------------------------

    def _preset(self, way: int) -> None:
        offered = [DEFAULTS, *self.known.presets]
        place = offered.index(self.preset) if self.preset in offered else -1 if way > 0 else 0
        self.preset = offered[(place + way) % len(offered)]
        self.live.preset("" if self.preset == DEFAULTS else self.preset)

    def _param(self, param: dict[str, Any]) -> Item:
        name, value, doc = param["name"], param["value"], param["doc"]
        if param["choices"]:
            words = [f"{c:g}" if isinstance(c, float) else str(c) for c in param["choices"]]
            place = param["choices"].index(value)
            return Item(name, f"{words[place]} {param['unit']}".rstrip(), f"{doc}\none of {', '.join(words)}".strip(),
                        lambda way: self._set(param, param["choices"][(place + way) % len(words)]))  # fmt: skip
        low, high, scale = param["low"], param["high"], param["scale"]
        step = param["step"] or (scale * fine((high - low) / scale) if high > low else scale)
        ends = f"{low / scale:g} to {high / scale:g} {param['unit']}".rstrip()
        steps = f", in steps of {param['step'] / scale:g}" if param["step"] else ""

        def put(number: float) -> None:
            self._set(param, min(max(number, low), high))

        def share(part: float) -> None:
            put(low + step * round(min(max(part, 0.0), 1.0) * (high - low) / step))

        at = (value - low) / (high - low) if high > low else 0.0
        return Item(name, f"{value / scale:.6g} {param['unit']}".rstrip(), f"{doc}\n{ends}{steps}".strip(),
                    lambda way: put(value + way * step), at, share)  # fmt: skip

    def _set(self, param: dict[str, Any], value: float | str) -> None:
        param["value"] = value
        self.preset = ""
        self.live.set({param["name"]: value})

    # ---- looks ------------------------------------------------------------------------------------------------------

    def _output(self, name: str) -> Item:
        shown = self.outputs or self.drawn

        def toggle(_: int) -> None:
            chosen = tuple(n for n in self.known.bodies if (n in shown) != (n == name))
            if chosen:  # something is to be seen
                self.outputs = chosen
                self.wish()

        return Item(name, "shown" if name in shown else "-", "an output", toggle)

    def colour(self, way: int = 1) -> None:
        """By the next field, or the one before."""
        offered = ["", *self.known.fields]
        self.paint = offered[(offered.index(self.paint) + way) % len(offered)] if self.paint in offered else ""
        self.wish()

    def cross(self, axis: int, toward: Sequence[float]) -> None:
        """A section across an axis, through the middle, without what is before it as seen from `toward`; the same once
        more, or axis -1, takes it away."""
        box = self.stage
        if box is None:
            return
        if axis in (self.section.axis, -1):
            self.section.axis = -1
        else:
            self.section = Section(axis, (box.lo[axis] + box.hi[axis]) / 2, -1 if toward[axis] > 0 else 1)
        self.wish()

    def _across(self, way: int) -> None:
        self.cross((self.section.axis + 1 + way) % 4 - 1, (1, -1, 1))

    def _place(self, box: Box) -> Item:
        axis = self.section.axis
        low, size = box.lo[axis], box.size[axis]
        at = (self.section.offset - low) / size
        ends = f"{low:.4g} to {low + size:.4g} mm"
        grain = fine(size) / 20  # of a place that the mouse says, more digits mean nothing
        value = f"{round(self.section.offset / grain) * grain:.4g} mm"
        return Item(f"section {'xyz'[axis]}", value, ends, self.slide, at, self._slide_to)

    def slide(self, way: int) -> None:
        """The section, by a fiftieth of what is seen."""
        axis = self.section.axis
        if axis >= 0 and self.stage is not None:
            self._slide_to((self.section.offset - self.stage.lo[axis]) / self.stage.size[axis] + way / 50)

    def _slide_to(self, share: float) -> None:
        if (box := self.stage) is not None:
            axis = self.section.axis
            self.section.offset = box.lo[axis] + min(max(share, 0.0), 1.0) * box.size[axis]

    def field_on(self, _: int = 1) -> None:
        """Whether the section shows the field."""
        self.plane = not self.plane
        self.wish()


def fine(range: float) -> float:
    """A step of 1, 2 or 5 times a power of ten, of which some fifty make a range."""
    power = 10.0 ** math.floor(math.log10(range / 50))
    return next(power * n for n in (5, 2, 1) if n * power <= range / 50)
