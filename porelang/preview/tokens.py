"""The token in the address of a page: what tells whoever may see it from whoever may not.

A page that stays open while `pore view` ends is to find its way back to the one that is started again at its port. So a
token is kept for a day, where this user alone can read it; it is taken up where the port was asked for by name. And a
page gives it away only to who knows it already: another program may listen at that port by then.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import re
import secrets
import time
from contextlib import suppress

from porelang import cache

#: Seconds that a token is kept for, and how many are.
KEPT, MOST = 86_400, 100
_TOKEN = re.compile(r"[A-Za-z0-9_-]{32}")
_PREFIX = "view-"
#: What a page may ask to be proven with: letters of its own choice.
NONCE = re.compile(r"[0-9a-f]{32}")


def token_of(path: str, port: int, again: bool) -> str:
    """The token for a file's page at a port: the one that it had there within a day where it is wanted `again`, or a
    new one. It is kept where there is a place that this user alone can read."""
    key = _key(path, port)
    token = (_kept(key) if again else None) or secrets.token_urlsafe(24)
    cache.put(key, token.encode(), MOST, _PREFIX)
    return token


def proof(token: str, nonce: str) -> str:
    """What shows who asked that the token is known here, and nothing of the token."""
    return hmac.new(token.encode(), nonce.encode(), hashlib.sha256).hexdigest()


def _key(path: str, port: int) -> str:
    named = f"{os.path.realpath(path)}\0{port}".encode(errors="surrogatepass")
    return f"{_PREFIX}{hashlib.sha256(named).hexdigest()}"


def _kept(key: str) -> str | None:
    where = cache.folder()
    if where is None:
        return None
    with suppress(OSError):
        found = os.lstat(where / key)
        if found.st_mode & 0o077 or not 0 <= time.time() - found.st_mtime < KEPT:  # others may have read it
            return None
        token = (cache.get(key) or b"").decode("ascii", "replace")
        return token if _TOKEN.fullmatch(token) else None
    return None
