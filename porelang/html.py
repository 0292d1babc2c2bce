"""What notebooks show: tables of plain texts as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

_SIGNS = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})
_CELL = "text-align:left;padding:2px 12px 2px 0;vertical-align:top"


def brief(text: str, most: int = 120) -> str:
    """A text in one line of a bounded length."""
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[: most - 3]}..."


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with a line of heads; every cell is a text, shown as it is."""
    head = "".join(f'<th style="{_CELL}">{h.translate(_SIGNS)}</th>' for h in heads)
    lines = ("".join(f'<td style="{_CELL}">{cell.translate(_SIGNS)}</td>' for cell in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def title(text: str) -> str:
    """A line above tables."""
    return f"<div><b>{text.translate(_SIGNS)}</b></div>"


def verbatim(text: str) -> str:
    """A text whose lines stay as they are."""
    return f'<pre style="line-height:1.3">{text.translate(_SIGNS)}</pre>'
