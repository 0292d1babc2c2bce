"""The language server, spoken to by a client over standard input and output, as editors do."""

from __future__ import annotations

import asyncio
import json
import re
import subprocess
import sys
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.client import LanguageClient

from porelang.lsp.places import offset, position
from porelang.source import Source

PROGRAM = """\
param w = 12mm in 8mm..20mm  "cell"
let body = cube(30mm)
let k = w * 2 + 1cm
## Walls of a lattice.
def walls(f, t: length where t > 0) = metric(f) |> shell(t)
let thin = walls(gyroid(w), t=1mm) & body
thin | sphere(k / 9)
"""


class Editor:
    """A client with one document, that waits for what it is told."""

    def __init__(self, client: LanguageClient, uri: str) -> None:
        self.client, self.uri, self.version = client, uri, 0
        self.told: asyncio.Queue[types.PublishDiagnosticsParams] = asyncio.Queue()

    async def open(self, text: str) -> list[types.Diagnostic]:
        item = types.TextDocumentItem(self.uri, "pore", 0, text)
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        return await self.diagnostics(0)

    async def write(self, text: str) -> list[types.Diagnostic]:
        self.version += 1
        document = types.VersionedTextDocumentIdentifier(uri=self.uri, version=self.version)
        whole = types.TextDocumentContentChangeWholeDocument(text)
        self.client.text_document_did_change(types.DidChangeTextDocumentParams(document, [whole]))
        return await self.diagnostics(self.version)

    async def diagnostics(self, version: int) -> list[types.Diagnostic]:
        while True:
            said = await asyncio.wait_for(self.told.get(), 60)
            if said.uri == self.uri and said.version == version:
                return list(said.diagnostics)

    def at(self, text: str, of: str, more: int = 0) -> dict[str, Any]:
        source = Source("", text)
        place = position(source, text.index(of) + more, "utf-16")
        return {"text_document": types.TextDocumentIdentifier(self.uri), "position": place}


def spoken(tmp_path: Path, talk: Callable[[Editor], Coroutine[Any, Any, None]], name: str = "part.pore") -> None:
    async def run() -> None:
        client = LanguageClient("test", "1")
        await client.start_io(sys.executable, "-m", "porelang", "lsp")
        editor = Editor(client, (tmp_path / name).as_uri())

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def told(params: types.PublishDiagnosticsParams) -> None:
            editor.told.put_nowait(params)

        root = tmp_path.as_uri()
        await client.initialize_async(types.InitializeParams(types.ClientCapabilities(), root_uri=root))
        client.initialized(types.InitializedParams())
        await talk(editor)
        await client.shutdown_async(None)
        client.exit(None)
        await client.stop()

    asyncio.run(asyncio.wait_for(run(), 120))


def test_an_editor_is_served(tmp_path: Path) -> None:
    async def talk(editor: Editor) -> None:
        client = editor.client
        assert await editor.open(PROGRAM) == []

        hover = await client.text_document_hover_async(types.HoverParams(**editor.at(PROGRAM, "k / 9")))
        assert hover is not None
        assert isinstance(hover.contents, types.MarkupContent)
        assert "a length: 34mm" in hover.contents.value

        help_ = await client.text_document_signature_help_async(
            types.SignatureHelpParams(**editor.at(PROGRAM, "t=1mm", 2))
        )
        assert help_ is not None
        assert help_.signatures[0].label == "walls(f, t: length where t > 0)"
        assert help_.active_parameter == 1

        where = await client.text_document_definition_async(types.DefinitionParams(**editor.at(PROGRAM, "gyroid")))
        assert isinstance(where, types.Location)
        assert where.uri.endswith("prelude/tpms.pore")
        assert (
            Path(where.uri.removeprefix("file://"))
            .read_text()
            .split("\n")[where.range.start.line]
            .startswith("def gyroid")
        )

        context = types.ReferenceContext(True)
        uses = await client.text_document_references_async(
            types.ReferenceParams(context=context, **editor.at(PROGRAM, "w * 2"))
        )
        assert uses is not None
        assert [u.range.start.line for u in uses] == [0, 2, 5]

        change = await client.text_document_rename_async(
            types.RenameParams(new_name="period", **editor.at(PROGRAM, "w * 2"))
        )
        assert change is not None
        assert change.changes is not None
        assert len(change.changes[editor.uri]) == 3
        with pytest.raises(Exception, match="stands for something else"):
            await client.text_document_rename_async(types.RenameParams(new_name="body", **editor.at(PROGRAM, "w * 2")))

        symbols = await client.text_document_document_symbol_async(
            types.DocumentSymbolParams(types.TextDocumentIdentifier(editor.uri))
        )
        assert symbols is not None
        assert [s.name for s in symbols] == ["w", "body", "k", "walls", "thin", "part"]

        tokens = await client.text_document_semantic_tokens_full_async(
            types.SemanticTokensParams(types.TextDocumentIdentifier(editor.uri))
        )
        assert tokens is not None
        assert len(tokens.data) % 5 == 0
        assert list(tokens.data[:10]) == [0, 0, 5, 0, 0, 0, 6, 1, 7, 9]  # a keyword, and a variable that is declared

        whole = types.Range(types.Position(0, 0), types.Position(99, 0))
        hints = await client.text_document_inlay_hint_async(
            types.InlayHintParams(types.TextDocumentIdentifier(editor.uri), whole)
        )
        assert hints is not None
        assert [(h.position.line, h.label) for h in hints] == [(2, "= 34mm")]

    spoken(tmp_path, talk)


def test_mistakes_are_told_and_mended(tmp_path: Path) -> None:
    async def talk(editor: Editor) -> None:
        client = editor.client
        text = PROGRAM.replace("gyroid(w)", "gyroyd(w)")
        (wrong,) = await editor.open(text)
        assert (wrong.code, wrong.severity, wrong.range.start) == (
            "E030",
            types.DiagnosticSeverity.Error,
            types.Position(5, 17),
        )
        assert "did you mean `gyroid`?" in wrong.message
        actions = await client.text_document_code_action_async(
            types.CodeActionParams(
                types.TextDocumentIdentifier(editor.uri), wrong.range, types.CodeActionContext([wrong])
            )
        )
        assert actions is not None
        (action,) = actions
        assert isinstance(action, types.CodeAction)
        assert action.edit is not None
        assert action.edit.changes is not None
        (edit,) = action.edit.changes[editor.uri]
        assert (edit.new_text, edit.range) == ("gyroid", wrong.range)

        assert await editor.write(PROGRAM) == []
        # a statement that cannot be read costs itself alone: names behind it are known, and completed
        broken = PROGRAM + "let more = body |> offset("
        assert [d.code for d in await editor.write(broken)] == ["E018", "E005"]
        place = types.CompletionParams(**editor.at(broken, "offset(", 7))
        found = await client.text_document_completion_async(place)
        assert isinstance(found, types.CompletionList)
        labels = [item.label for item in found.items]
        assert labels[:1] == ["d="]
        assert {"body", "thin", "walls", "gyroid"} <= set(labels)

    spoken(tmp_path, talk)


@pytest.mark.parametrize(
    "address",
    [
        "my%20part.pore",
        "B%C3%BCcher/a%28b%29%23.pore",
        "a+b(1)'c@d!.pore",
        "untitled:Untitled-1",
        "git:/part.pore?HEAD",
    ],
)
def test_addresses_are_those_of_the_client(tmp_path: Path, address: str) -> None:
    """However it writes what may be encoded, and may not; what is published for another address nobody sees."""

    async def talk(editor: Editor) -> None:
        editor.uri = address if ":" in address else f"{tmp_path.as_uri()}/{address}"
        assert [d.code for d in await editor.open("sphere(w)\n")] == ["E030"]
        assert await editor.write("let w = 3\nsphere(w)\n") == []
        place = types.HoverParams(**editor.at("let w = 3\nsphere(w)\n", "w)"))
        assert await editor.client.text_document_hover_async(place) is not None

    spoken(tmp_path, talk)


def test_it_ends_while_it_is_looking(tmp_path: Path) -> None:
    """At what takes long; its client waits for no more than the answer."""

    async def talk(editor: Editor) -> None:
        many = ", ".join(f"translate(metric(gyroid({4 + n / 10})) |> shell(1), [{9 * n}, 0, 0])" for n in range(40))
        await editor.open(f"union([{many}]) & box([300, 30, 30])\n")
        await asyncio.sleep(0.8)

    spoken(tmp_path, talk)


def test_a_file_that_comes_back_is_seen(tmp_path: Path) -> None:
    """As it does when a version is checked out, or where a `use` was typed before its file is there."""

    async def talk(editor: Editor) -> None:
        (missing,) = await editor.open('use "lib.pore" as lib\nlib.body\n')
        assert "lib.pore" in missing.message
        lib = tmp_path / "lib.pore"
        lib.write_text("let body = sphere(3)\n")
        change = types.FileEvent(lib.as_uri(), types.FileChangeType.Created)
        editor.client.workspace_did_change_watched_files(types.DidChangeWatchedFilesParams([change]))
        assert await editor.diagnostics(0) == []

    spoken(tmp_path, talk)


def test_a_used_file_that_is_not_saved_yet_is_seen(tmp_path: Path) -> None:
    async def talk(editor: Editor) -> None:
        (missing,) = await editor.open('use "lib.pore" as lib\nlib.body\n')
        assert "lib.pore" in missing.message
        lib = types.TextDocumentItem((tmp_path / "lib.pore").as_uri(), "pore", 0, "let body = sphere(3)\n")
        editor.client.text_document_did_open(types.DidOpenTextDocumentParams(lib))
        assert await editor.diagnostics(0) == []

    spoken(tmp_path, talk)


def test_a_name_is_changed_and_found_in_files_that_are_not_open(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    user = tmp_path / "deep" / "user.pore"
    user.write_text('use "../part.pore" as lib\nsphere(lib.t)\n')

    async def talk(editor: Editor) -> None:
        text = "let t = 2mm\nlet body = sphere(t)\n"
        await editor.open(text)
        made = await editor.client.text_document_rename_async(
            types.RenameParams(new_name="wall", **editor.at(text, "t = 2"))
        )
        assert made is not None
        assert made.changes is not None
        assert {uri: len(edits) for uri, edits in made.changes.items()} == {editor.uri: 2, user.as_uri(): 1}
        context = types.ReferenceContext(include_declaration=True)
        found = await editor.client.text_document_references_async(
            types.ReferenceParams(context=context, **editor.at(text, "t = 2"))
        )
        assert found is not None
        assert [place.uri for place in found] == [editor.uri, editor.uri, user.as_uri()]

        user.write_text('use "../part.pore" as lib\nout part = sphere(lib.t)\nlet z = lib.t + (\n')
        with pytest.raises(JsonRpcException, match=r"line 3 of .*user\.pore` has `t` in it"):
            await editor.client.text_document_rename_async(
                types.RenameParams(new_name="wall", **editor.at(text, "t = 2"))
            )

    spoken(tmp_path, talk)


def test_a_name_is_changed_in_texts_as_they_are_now(tmp_path: Path) -> None:
    """Of a file that was edited a moment ago, and is not compiled yet."""
    (tmp_path / "part.pore").write_text("let t = 2mm\n")

    async def talk(editor: Editor) -> None:
        text = "let t = 2mm\nsphere(t)\n"
        await editor.open(text)
        user = Editor(editor.client, (tmp_path / "user.pore").as_uri())
        user.told = editor.told
        using = 'use "part.pore" as lib\nsphere(lib.t)\n'
        await user.open(using)
        document = types.VersionedTextDocumentIdentifier(uri=user.uri, version=1)
        change = types.TextDocumentContentChangeWholeDocument("# two\n# lines\n" + using)
        editor.client.text_document_did_change(types.DidChangeTextDocumentParams(document, [change]))
        made = await editor.client.text_document_rename_async(
            types.RenameParams(new_name="wall", **editor.at(text, "t = 2"))
        )
        assert made is not None
        assert made.changes is not None
        (edit,) = made.changes[user.uri]
        assert (edit.range.start.line, edit.range.start.character) == (3, 11)

    spoken(tmp_path, talk)


def test_a_document_without_a_file_is_named_as_the_client_does(tmp_path: Path) -> None:
    async def talk(editor: Editor) -> None:
        editor.uri = "untitled:Untitled-1"
        text = "let w = 3\nsphere(w)\n"
        await editor.open(text)
        where = await editor.client.text_document_definition_async(types.DefinitionParams(**editor.at(text, "w)")))
        assert isinstance(where, types.Location)
        assert where.uri == editor.uri

    spoken(tmp_path, talk)


def test_what_samples_show_follows_when_nobody_types(tmp_path: Path) -> None:
    async def talk(editor: Editor) -> None:
        text = "sphere(3) \\ translate(sphere(1), [9, 0, 0])\n"
        assert await editor.open(text) == []
        (doubt,) = await editor.diagnostics(0)
        assert doubt.severity == types.DiagnosticSeverity.Warning
        # it stays while its text does, and goes where that goes
        (moved,) = await editor.write("# above\n" + text)
        assert (moved.code, moved.range.start.line) == (doubt.code, 1)

    spoken(tmp_path, talk)


def test_an_edit_of_a_used_file_is_told_in_those_that_use_it(tmp_path: Path) -> None:
    (tmp_path / "plates.pore").write_text("let t = 2mm\n")

    async def talk(editor: Editor) -> None:
        assert await editor.open('use "plates.pore" as plates\nsphere(plates.t)\n') == []
        lib = Editor(editor.client, (tmp_path / "plates.pore").as_uri())
        item = types.TextDocumentItem(lib.uri, "pore", 0, "let u = 2mm\n")
        lib.client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        while not (said := await asyncio.wait_for(editor.told.get(), 60)).diagnostics or said.uri != editor.uri:
            pass
        assert [d.code for d in said.diagnostics] == ["E036"]

    spoken(tmp_path, talk)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_columns_are_counted_as_agreed(encoding: str) -> None:
    text = "# \u00e4\u20ac\U0001d70b x\nlet a = 1 # \U0001d70b\n"
    source = Source("a.pore", text)
    for at in range(len(text)):
        assert offset(source, position(source, at, encoding), encoding) == at
    wanted = {"utf-8": 12, "utf-16": 7, "utf-32": 6}[encoding]
    assert position(source, text.index("x"), encoding) == types.Position(0, wanted)
    assert offset(source, types.Position(0, 99), encoding) == text.index("\n")
    assert offset(source, types.Position(99, 0), encoding) == len(text)


def test_a_request_that_cannot_be_read_is_answered(tmp_path: Path) -> None:
    """Or its client waits for ever."""
    hover = {"jsonrpc": "2.0", "method": "textDocument/hover"}
    nothing: dict[str, Any] = {"jsonrpc": "2.0", "params": None}
    begins = {"processId": None, "rootUri": None, "capabilities": {}}
    said = [
        {**nothing, "id": 1, "method": "initialize", "params": begins},
        {**hover, "id": 2, "params": {}},
        {**hover, "id": 3, "params": {"textDocument": 5}},
        {**hover, "id": 4, "params": {"textDocument": {"uri": "file:///x.pore"}, "position": {"line": "a"}}},
        {**nothing, "id": 7, "method": "initialize", "params": begins},  # once is enough: documents would be lost
        {"id": 8, "method": "textDocument/hover"},
        {**nothing, "id": 5, "method": "shutdown"},
        {
            **hover,
            "id": 6,
            "params": {"textDocument": {"uri": "file:///x.pore"}, "position": {"line": 1, "character": 0}},
        },
        {**nothing, "method": "exit"},
    ]
    bodies = [json.dumps(word).encode() for word in said]
    asked = b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) for body in bodies)
    ended = subprocess.run([sys.executable, "-m", "porelang", "lsp"], input=asked, capture_output=True, timeout=60)
    answers = [json.loads(body) for body in re.split(rb"Content-Length.*?\r\n\r\n", ended.stdout, flags=re.S)[1:]]
    by_id = {answer["id"]: answer for answer in answers if "id" in answer}
    for number in (2, 3, 4):
        assert by_id[number]["error"]["code"] == -32602
        assert "parameters of textDocument/hover" in by_id[number]["error"]["message"]
    assert by_id[5]["result"] is None  # it went on
    assert {by_id[number]["error"]["code"] for number in (6, 7)} == {-32600}
    assert -32600 in {answer["error"]["code"] for answer in answers if answer.get("id") is None and "error" in answer}
    assert ended.returncode == 0
