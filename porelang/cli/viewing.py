"""`pore view`: a program drawn on a page while it is written."""

from __future__ import annotations

import webbrowser
from argparse import Namespace

from porelang.cli import report
from porelang.cli.loading import data_of
from porelang.compiler import try_compile
from porelang.diagnostics import fail
from porelang.files import read_source
from porelang.preview.live import Start


def view(options: Namespace) -> int:
    """Show a program until a signal ends it: serve its page on this machine, or open a window. Errors: E105, E106,
    E028, E108, E126, and what is wrong with the settings that it begins with."""
    if options.file == "-":
        raise fail("E108", "standard input is no file that is saved", hint="name the .pore file to look at")
    source = read_source(options.file)  # a slip of the name is told at once
    start = Start(dict(options.settings), options.preset, data_of(options))
    if start.settings or start.preset:  # and of a setting; what is wrong in the program the page shows
        program, _ = try_compile(source, bound=start.bound)
        if program is not None:
            program.design(start.settings, preset=start.preset)
    return _window(options, start) if options.window else _page(options, start)


def _page(options: Namespace, start: Start) -> int:
    try:
        from porelang.preview.server import application, door, server_of
        from porelang.preview.tokens import token_of
    except ImportError:
        raise fail("E126", "`pore view` needs the packages starlette, uvicorn and websockets",
                   hint="pip install 'porelang[view]'") from None  # fmt: skip
    opened, port = door(options.port or 0)
    token = token_of(options.file, port, again=bool(options.port))
    address = f"http://127.0.0.1:{port}/{token}/{'?stats' if options.stats else ''}"
    print(address, flush=True)
    report.note("the page follows every save of the program; Ctrl-C ends it")
    if not options.no_browser:
        webbrowser.open(address)
    server_of(application(options.file, token, port, start)).run(sockets=[opened])
    return 0


def _window(options: Namespace, start: Start) -> int:
    try:
        from porelang.preview.window import opened
    except ImportError:
        raise fail("E126", "`pore view --window` needs the package moderngl-window",
                   hint="pip install 'porelang[window]'") from None  # fmt: skip
    try:
        opened(options.file, start)
    except (ImportError, OSError, RuntimeError) as error:  # whatever the system says where it has no screen
        raise fail("E120", f"no window can be opened here: {error}",
                   hint="`pore view` without --window draws in a browser") from None  # fmt: skip
    return 0
