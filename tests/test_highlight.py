"""Colours without a language server: the patterns agree with the language's own lexer."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name
from pygments.token import Comment, Keyword, Number, String

from porelang.highlight import PoreLexer
from porelang.syntax.parse import lexed
from porelang.syntax.tokens import STATEMENTS

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "editors"))
FILES = sorted([*(ROOT / "examples").glob("*.pore"), *(ROOT / "porelang" / "prelude").glob("*.pore")])
KINDS = {"NUMBER": Number, "STRING": String.Double, "COMMENT": Comment.Single, "DOC": String.Doc}
WORDS = STATEMENTS | {"IF", "THEN", "ELSE", "FOR", "IN", "WHERE", "AND", "OR", "NOT"}


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_patterns_agree_with_the_lexer(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    said = {at: (kind, value) for at, kind, value in PoreLexer().get_tokens_unprocessed(text)}
    for token in lexed(text, comments=True):
        wanted = Keyword if token.type in WORDS else KINDS.get(token.type)
        if wanted is not None:
            kind, value = said[token.start]
            assert kind in wanted, (token, kind)
            assert value.rstrip() == token.text.rstrip()


def test_pygments_finds_it() -> None:
    assert isinstance(get_lexer_by_name("pore"), PoreLexer)


def test_the_grammar_of_editors_is_that_of_the_package() -> None:
    from generate import GRAMMAR, grammar

    assert GRAMMAR.read_text(encoding="utf-8") == grammar(), "make editors"
    for pattern in json.loads(grammar())["patterns"]:
        re.compile(pattern["match"])
