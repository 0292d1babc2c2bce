"""How a part was looked at, as an address says it: what is set, which outputs are drawn, in which colours.

What an address cannot ask for is passed over: the program may have changed since it was written.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from porelang.diagnostics import PoreError
from porelang.preview.scene import Wish
from porelang.program import Program
from porelang.render.picture import bodies_of, field_of

#: What begins the name of a param in an address.
_PARAM = "p."


@dataclass(frozen=True, slots=True)
class Look:
    """Params by their texts, and what is drawn."""

    settings: dict[str, str] = field(default_factory=dict)
    wish: Wish = field(default_factory=Wish)

    @classmethod
    def read(cls, said: Iterable[tuple[str, str]]) -> Look:
        """The look that names and values of an address ask for."""
        found = dict(said)
        settings = {name.removeprefix(_PARAM): text for name, text in found.items() if name.startswith(_PARAM)}
        outputs = tuple(filter(None, found.get("outputs", "").split(",")))
        return cls(settings, Wish(outputs, found.get("paint", "").strip(), found.get("plane") == "1"))

    def wished(self, program: Program) -> Wish:
        """What is drawn of a program: the outputs that it has, and the colours if they are those of a field."""
        known = set(bodies_of(program))
        wish = replace(self.wish, outputs=tuple(n for n in self.wish.outputs if n in known))
        try:
            if wish.paint:
                field_of(program, wish.paint, "colour by")
        except PoreError:
            return replace(wish, paint="")
        return wish


def word(wish: Wish) -> dict[str, Any]:
    """A wish, as a page is told of it."""
    return {"outputs": list(wish.outputs), "paint": wish.paint, "plane": wish.plane}
