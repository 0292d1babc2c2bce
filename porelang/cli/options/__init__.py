"""The options of commands, as data: how each is written, what it takes, and what `--help` says of it."""

from __future__ import annotations

from porelang.cli.options.common import COMMON
from porelang.cli.options.meshes import MESHES
from porelang.cli.options.option import Option
from porelang.cli.options.pictures import PICTURES
from porelang.cli.options.strength import STRENGTH

#: By the keys that commands name; several keys may write one option, each for commands of its own.
OPTIONS: dict[str, Option] = COMMON | MESHES | STRENGTH | PICTURES
