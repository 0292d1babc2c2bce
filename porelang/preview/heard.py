"""What a window knows of its program: what it has been told, until it is told otherwise."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

#: The measures that are shown, by their keys, and what they are called.
MEASURED = {
    "porosity": "porosity", "volume": "volume", "area": "area", "size": "size", "solid_components": "pieces",
}  # fmt: skip
HOLDS = {True: "holds", False: "fails", None: "not certain"}


@dataclass(slots=True)
class Known:
    """The program by its params, outputs, fields and presets; what is wrong and what is being done, each by its
    purpose; measures as (name, value, error), which are `old` while others are made; checks as (text, holds, why)."""

    file: str = ""
    params: list[dict[str, Any]] = field(default_factory=list)
    bodies: list[str] = field(default_factory=list)
    fields: list[str] = field(default_factory=list)
    presets: list[str] = field(default_factory=list)
    wrong: dict[str, str] = field(default_factory=dict)
    doing: dict[str, str] = field(default_factory=dict)
    head: str = ""
    rows: list[tuple[str, str, str]] = field(default_factory=list)
    checks: list[tuple[str, bool | None, str]] = field(default_factory=list)
    old: bool = False
    doubts: list[str] = field(default_factory=list)

    def hear(self, word: dict[str, Any]) -> None:
        """Take in a message of `Live`; those that concern no window are left."""
        match word:
            case {"say": "program"}:
                self.params, self.bodies, self.fields = word["params"], word["bodies"], word["fields"]
                self.presets, self.file = word["presets"], word["file"]
                self.wrong["text"] = "\n\n".join(word["wrong"])
            case {"say": "settings", "settings": settings}:
                for param in self.params:
                    param["value"] = settings.get(param["name"], param["value"])
            case {"say": "gone", "why": why}:
                self.wrong["file"] = why and f"{self.file} {why}: what is drawn is what it was"
            case {"say": "refused" | "stopped"}:
                self.wrong[word["of"]] = word["text"]
            case {"say": "doing"}:
                self.doing[word["of"]] = f"{word['what']} {word['share']:.0%}"
            case {"say": "done"}:
                self.doing.pop(word["of"], None)
            case {"say": "unmeasured"}:
                self.wrong["measure"], self.old = "", True
                self.head = self.head and "measures: not of this part yet"
            case {"say": "measuring"}:
                self.head = f"measuring {word['output']} ..."
            case {"say": "doubts"}:
                self.doubts = [*word["notes"], *word["doubts"]]
            case {"say": "checked"}:
                self.checks = [(c["text"], c["holds"], c["why"]) for c in word["checks"]]
            case {"say": "measured"}:
                self.head, self.old = f"measures of {word['output']}", False
                self.rows = [
                    (MEASURED.get(name, name), value, "" if name == "size" else error)
                    for name, value, error in word["rows"]
                    if name in MEASURED or not name.isidentifier()
                ]
                if envelope := word.get("envelope"):  # of what the porosity is
                    self.rows.append(("within", envelope, ""))
