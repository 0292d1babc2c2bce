"""What a task tells of a result: a note and doubts."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Doubt:
    """A warning about what was found; `label` stands under the place that asks for it."""

    code: str
    message: str
    label: str = ""
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Told:
    """What a task tells of a result: a `note` in one line ("" for none), and its doubts."""

    note: str = ""
    doubts: tuple[Doubt, ...] = ()
