"""How a text is coloured where no language server is: patterns by what they find, in the order in which they are tried.

`make editors` writes the grammar of `editors/vscode` from them; the lexer for Pygments (`porelang.highlight`) reads
them.
"""

from __future__ import annotations

import re

from porelang import resources

#: The words that begin a statement, those within one, and names that are values.
STATEMENTS = ("param", "let", "def", "out", "check", "use", "preset")
WORDS = ("if", "then", "else", "for", "in", "where", "and", "or", "not", "as", "step")
TRUTHS = ("true", "false")
_SIGNS = r"=>|\|>|==|!=|<=|>=|\.\.|[=<>|&\\+\-*/%^~@]"


def _terminal(name: str) -> str:
    """The pattern of a terminal of the grammar."""
    found = re.search(rf"^{name}: /(.*)/$", resources.read("grammar/pore.lark"), re.MULTILINE)
    assert found is not None, name
    return found[1]


def _words(some: tuple[str, ...]) -> str:
    return rf"\b(?:{'|'.join(some)})\b"


def patterns() -> list[tuple[str, str]]:
    """What is found, by names that editors have for it, and its pattern."""
    return [
        ("comment.documentation", r"##(?!#)[^\n]*"),
        ("comment", r"#[^\n]*"),
        ("string", _terminal("STRING")),
        ("number", rf"(?<!\w){_terminal('NUMBER')}"),
        ("keyword.declaration", _words(STATEMENTS)),
        ("keyword", _words(WORDS)),
        ("constant", _words((*TRUTHS, "pi", "tau"))),
        ("variable.coordinate", r"(?<![\w.])[xyzp]\b(?!\s*[(=])"),
        ("function", r"\b[A-Za-z_]\w*(?=\s*\()"),
        ("operator", _SIGNS),
        ("variable", r"[A-Za-z_]\w*"),
    ]
