"""An option of a command, as data."""

from __future__ import annotations

from typing import Any

#: How it is written, and what `argparse` is told of it, but for `type`, `choices` and `required`, which are ours: its
#: own words for what it misses differ from one Python to the next.
Option = tuple[tuple[str, ...], dict[str, Any]]
