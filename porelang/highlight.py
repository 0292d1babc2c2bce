"""A lexer for Pygments, which colours programs in notebooks, Sphinx and LaTeX: `pygmentize -l pore part.pore`.

It is found by its entry point; nothing else here needs Pygments.
"""

from __future__ import annotations

import re
from typing import ClassVar

from pygments.lexer import RegexLexer
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text

from porelang.syntax.highlighting import patterns

_TOKENS = {
    "comment.documentation": String.Doc,
    "comment": Comment.Single,
    "string": String.Double,
    "number": Number,
    "keyword.declaration": Keyword.Declaration,
    "keyword": Keyword,
    "constant": Keyword.Constant,
    "variable.coordinate": Name.Builtin.Pseudo,
    "function": Name.Function,
    "operator": Operator,
    "variable": Name,
}


class PoreLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """Programs of Pore.

    >>> from pygments import highlight
    >>> from pygments.formatters import NullFormatter
    >>> highlight("let a = 3mm", PoreLexer(), NullFormatter())
    'let a = 3mm\\n'
    """

    name = "Pore"
    url = "https://pypi.org/project/porelang"
    aliases: ClassVar[list[str]] = ["pore"]
    filenames: ClassVar[list[str]] = ["*.pore"]
    flags = re.MULTILINE
    tokens: ClassVar[dict[str, list[tuple[str, object]]]] = {
        "root": [
            *((pattern, _TOKENS[what]) for what, pattern in patterns()),
            (r"[()\[\]{},:;.]", Punctuation),
            (r"\s+", Text),
        ]
    }
