"""`make editors`: what colours without a server, from the patterns of the package: the grammar of TextMate, for VS Code
and others, and a module for the editor of `pore view`."""

from __future__ import annotations

import json
from pathlib import Path

from porelang.syntax.highlighting import patterns

HERE = Path(__file__).parent
GRAMMAR = HERE / "vscode" / "pore.tmLanguage.json"
MODULE = HERE / "page" / "src" / "patterns.js"
#: What TextMate calls what is found.
SCOPES = {
    "comment.documentation": "comment.line.documentation.pore",
    "comment": "comment.line.number-sign.pore",
    "string": "string.quoted.double.pore",
    "number": "constant.numeric.pore",
    "keyword.declaration": "storage.type.pore",
    "keyword": "keyword.control.pore",
    "constant": "constant.language.pore",
    "variable.coordinate": "variable.language.pore",
    "function": "entity.name.function.pore",
    "operator": "keyword.operator.pore",
    "variable": "variable.other.pore",
}


def grammar() -> str:
    """The text of the grammar."""
    found = [{"name": SCOPES[what], "match": pattern} for what, pattern in patterns()]
    made = {"name": "Pore", "scopeName": "source.pore", "fileTypes": ["pore"], "patterns": found}
    return json.dumps(made, indent=2) + "\n"


def module() -> str:
    """The text of the module."""
    found = "".join(f"  {json.dumps([what, pattern])},\n" for what, pattern in patterns())
    return (
        "// Made by `make editors` from porelang/syntax/highlighting.py: what is found, tried in this order.\n"
        f"export const PATTERNS = [\n{found}];\n"
    )


if __name__ == "__main__":
    GRAMMAR.write_text(grammar(), encoding="utf-8")
    MODULE.write_text(module(), encoding="utf-8")
