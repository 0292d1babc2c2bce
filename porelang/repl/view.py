"""The page of `pore view` beside a session of the REPL: it shows what was asked for last, and follows every line."""

from __future__ import annotations

import secrets
import threading
import webbrowser
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from porelang.atomic import draft_in, replace_file
from porelang.diagnostics import fail


class View:
    """A page, once it is asked for, of a file beside which data and used files are sought: it is there as long as the
    session, and no longer. `browse` opens it in a browser."""

    def __init__(self, browse: bool) -> None:
        self._browse = browse
        self._held = ExitStack()
        self._path: Path | None = None
        self._text = ""
        self._address = ""

    def show(self, text: str, settings: Mapping[str, str], folder: str = "") -> str:
        """Show a program, at first with these settings, and say where; what it reads lies in a folder. Errors: E113
        where no file can be written, E126."""
        if self._path is None:
            self._path = self._held.enter_context(draft_in(Path(folder).absolute(), "pore"))
        self.follow(text)
        self._address = self._address or self._serve(settings)
        if self._browse:
            webbrowser.open(self._address)
        return self._address

    def follow(self, text: str) -> None:
        """Show this program now, if one is shown at all."""
        if self._path is None or text == self._text:
            return
        self._text = text
        with replace_file(self._path) as file:
            file.write(text.encode())

    def _serve(self, settings: Mapping[str, str]) -> str:
        try:
            from porelang.preview.live import Start
            from porelang.preview.server import application, door, server_of
        except ImportError:
            raise fail("E126", "`:view` needs the packages starlette, uvicorn and websockets",
                       hint="pip install 'porelang[view]'") from None  # fmt: skip
        opened, port = door(0)
        token = secrets.token_urlsafe(24)
        server = server_of(application(str(self._path), token, port, Start(dict(settings), None, {}, called="REPL")))
        threading.Thread(target=lambda: server.run(sockets=[opened]), daemon=True).start()
        self._held.callback(setattr, server, "should_exit", True)
        return f"http://127.0.0.1:{port}/{token}/"

    def __enter__(self) -> View:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._held.close()
