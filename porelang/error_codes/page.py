"""What there is to say of a diagnostic's code, apart from any one program."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Code:
    """A page of `pore explain`: a stable code, what it is about, why, and a program before (or "") and after."""

    code: str
    title: str
    explanation: str
    wrong: str
    right: str
