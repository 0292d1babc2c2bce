"""What is said of a file that cannot be used: at the call that names it, in words, with a way out."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from porelang.diagnostics import Diagnostic, PoreError
from porelang.error_codes import CODES
from porelang.source import Span


def refused(read: Callable[[], object], span: Span) -> Diagnostic:
    """The one diagnostic that reading ends with."""
    with pytest.raises(PoreError) as error:
        read()
    (found,) = error.value.diagnostics
    assert found.span == span
    assert found.hint
    assert found.code in CODES
    assert found.message.isprintable()
    return found
