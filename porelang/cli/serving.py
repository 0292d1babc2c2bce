"""`pore lsp`: what editors start."""

from __future__ import annotations

from argparse import Namespace

from porelang.diagnostics import fail


def lsp(_: Namespace) -> int:
    """Answer an editor until it ends. Errors: E126 where the package of the protocol is missing."""
    try:
        from porelang.lsp.server import serve
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise fail("E126", "`pore lsp` needs the package pygls", hint="pip install 'porelang[editor]'") from None
    serve()
    return 0
