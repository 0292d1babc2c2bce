"""The page's server: loopback only, for whoever knows the token in its address, one page at a time.

A page elsewhere in the browser can send requests to this machine too. So every address begins with a token that only
the address which was opened has, and a foreign Host (a name that was pointed at 127.0.0.1) or Origin is refused.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import secrets
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from porelang.diagnostics import fail
from porelang.preview.doing import Message
from porelang.preview.live import NOTHING, Live, Start
from porelang.preview.look import Look
from porelang.preview.scene import Scene, Wish
from porelang.preview.tokens import NONCE, proof
from porelang.preview.watched import LOOK, Watched
from porelang.preview.wire import packed, texts

WEB = Path(__file__).with_name("web")
#: What a page consists of, and what each file is.
_SCRIPTS = (
    "page",
    "address",
    "camera",
    "controls",
    "editor",
    "hands",
    "line",
    "painter",
    "section",
    "source",
    "viewer",
    "wire",
)
FILES = {
    "": ("page.html", "text/html"),
    "page.css": ("page.css", "text/css"),
    **{f"{name}.js": (f"{name}.js", "text/javascript") for name in _SCRIPTS},
}
#: Words that a page may send in a second; one that sends more is dropped.
MOST_A_SECOND = 400
#: Bytes of one word: line.js says so of what is longer.
LONGEST = 1 << 20
_ALLOWED = ("default-src 'self'", "img-src 'self' data: blob:", "frame-ancestors 'none'", "base-uri 'none'")
HEADERS = {
    "Content-Security-Policy": "; ".join(_ALLOWED),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


def door(port: int = 0) -> tuple[socket.socket, int]:
    """A socket of this machine alone, and its port, one that is free where it is 0. Errors: E108 where it is taken."""
    opened = socket.socket()
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # one that was closed a moment ago is free
    try:
        opened.bind(("127.0.0.1", port))
    except (OSError, OverflowError):
        raise fail("E108", f"port {port} cannot be had",
                   hint="choose another above 1023, or leave --port out: a free one is found") from None  # fmt: skip
    opened.listen()  # who comes before the server has begun waits
    return opened, opened.getsockname()[1]


def server_of(page: Starlette) -> uvicorn.Server:
    """What serves a page: `run(sockets=[...])` does until `should_exit` is set."""
    return uvicorn.Server(uvicorn.Config(page, log_level="error", ws="websockets-sansio", ws_per_message_deflate=False,
                                         ws_max_size=LONGEST, lifespan="off"))  # fmt: skip


def application(path: str, token: str, port: int, start: Start = NOTHING) -> Starlette:
    """The application that serves a file's page at `/TOKEN/` of this port of 127.0.0.1."""
    pages: dict[str, Live] = {}

    def refused(asked: HTTPConnection) -> bool:
        return foreign(asked) or not hmac.compare_digest(str(asked.path_params["token"]).encode(), token.encode())

    def foreign(asked: HTTPConnection) -> bool:
        hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        origin = asked.headers.get("origin")
        return asked.headers.get("host") not in hosts or (
            origin is not None and origin not in {f"http://{host}" for host in hosts}
        )  # fmt: skip

    async def page(request: Request) -> Response:
        name = request.path_params["name"]
        if refused(request) or name not in FILES:
            return PlainTextResponse("nothing is here for you\n", 403, HEADERS)
        file, kind = FILES[name]
        return FileResponse(WEB / file, media_type=kind, headers=HEADERS)

    async def made(request: Request) -> Response:
        live = pages.get(request.path_params["key"])
        if refused(request) or live is None or not (file := live.made.path(request.path_params["name"])).is_file():
            return PlainTextResponse("nothing is here for you\n", 403, HEADERS)
        return FileResponse(file, filename=file.name, headers=HEADERS)

    async def live(page: WebSocket) -> None:
        if refused(page) or page.headers.get("origin") is None:
            await page.close(1008)
            return
        await page.accept()
        look = Look.read(page.query_params.multi_items())
        await _attend(page, Live(path, _nobody, start, look), secrets.token_urlsafe(12), pages)

    async def known(request: Request) -> Response:
        nonce = request.path_params["nonce"]
        if foreign(request) or not NONCE.fullmatch(nonce):
            return PlainTextResponse("nothing is here for you\n", 403, HEADERS)
        return PlainTextResponse(proof(token, nonce), headers=HEADERS)

    return Starlette(routes=[
        Route("/{token}/made/{key}/{name}", made), WebSocketRoute("/{token}/live", live),
        Route("/known/{nonce}", known),
        Route("/{token}/{name:path}", page),
    ])  # fmt: skip


def _nobody(message: Message) -> None:
    """Before there is somebody to be told."""


async def _attend(page: WebSocket, live: Live, key: str, pages: dict[str, Live]) -> None:
    """Speak with one page until it leaves."""
    loop = asyncio.get_running_loop()
    waiting: asyncio.Queue[Message] = asyncio.Queue()

    def tell(message: Message) -> None:
        if isinstance(message, dict) and message["say"] == "made":
            message = message | {"link": f"made/{key}/{message['name']}"}
        with contextlib.suppress(RuntimeError):  # the server has ended
            loop.call_soon_threadsafe(waiting.put_nowait, message)

    live.tell, pages[key] = tell, live
    tasks = [asyncio.create_task(_send(page, waiting))]
    try:
        await asyncio.to_thread(live.begin)  # what a page says comes after that: it may have a text of its own
        tasks += [asyncio.create_task(work) for work in (_hear(page, live), _watch(live))]
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                task.result()
    finally:
        for task in tasks:
            task.cancel()
        del pages[key]
        live.close()


async def _send(page: WebSocket, waiting: asyncio.Queue[Message]) -> None:
    known: list[str | None] = []  # the shaders that the page has
    while True:
        message = await waiting.get()
        if isinstance(message, Scene):
            await page.send_bytes(packed(message, known))
            known = texts(message)
        else:
            await page.send_text(json.dumps(message))


async def _hear(page: WebSocket, live: Live) -> None:
    async for word in _words(page):
        await asyncio.to_thread(_obey, live, word)


def _obey(live: Live, word: dict[str, Any]) -> None:
    """Do what a page asks for; what it cannot ask for is passed over."""
    match word:
        case {"do": "set", "settings": dict(settings)}:
            live.set({n: v for n, v in settings.items() if isinstance(v, int | float | str)})
        case {"do": "preset", "name": str(name)}:
            live.preset(name)
        case {"do": "show", "outputs": list(outputs), "paint": str(paint), "plane": bool(plane)}:
            live.show(Wish(tuple(n for n in outputs if isinstance(n, str)), paint, plane))
        case {"do": "edit", "text": str(text)}:
            live.edit(text)
        case {"do": "save", "text": str(text), "over": bool(over)}:
            live.save(text, over)
        case {"do": "discard"}:
            live.discard()
        case {"do": "style", "text": str(text)}:
            live.style(text)
        case {"do": "complete", "number": int(number), "text": str(text), "offset": int(offset)}:
            live.complete(number, text, offset)
        case {"do": "export", "output": str(output), "ending": str(ending), "voxel": str(voxel)}:
            live.export(output, ending, voxel, force=word.get("force") is True)
        case {"do": "cancel", "of": str(purpose)}:
            live.cancel(purpose)


async def _words(page: WebSocket) -> AsyncIterator[dict[str, Any]]:
    """What the page says; one that says too much, or nonsense, is left."""
    loop = asyncio.get_running_loop()
    begun, count = loop.time(), 0
    while True:
        message = await page.receive()
        if message["type"] == "websocket.disconnect":
            return
        text = message.get("text")
        if text is None:
            await page.close(1003)  # a page says nothing in bytes
            return
        if loop.time() - begun > 1:
            begun, count = loop.time(), 0
        count += 1
        try:
            word = json.loads(text) if count <= MOST_A_SECOND else None
        except json.JSONDecodeError:
            word = None
        if not isinstance(word, dict):
            await page.close(1008)
            return
        yield word


async def _watch(live: Live) -> None:
    """Read the program again whenever it, or a file that it names, was saved."""
    watched = Watched(live.document.path)
    gone = ""
    while True:
        await asyncio.sleep(LOOK)
        if (now := watched.gone()) != gone:
            gone = now
            live.tell({"say": "gone", "why": gone})
        if watched.changed():
            await asyncio.to_thread(live.reread)
