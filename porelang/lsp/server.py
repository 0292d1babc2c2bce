"""The server: documents as they are edited, and questions about them. Everything is asked of one session."""

from __future__ import annotations

import asyncio
import os
import sys
from contextlib import redirect_stdout, suppress
from typing import Any

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

import porelang
from porelang.assist import complete, names, outline
from porelang.assist.calls import signature_at
from porelang.assist.hover import hover
from porelang.diagnostics import Diagnostic, PoreError
from porelang.lsp import answers
from porelang.lsp.places import Encoding, location, offset, path_of, position, range_of, uri_of
from porelang.lsp.protocol import Protocol
from porelang.progress import CancelledError
from porelang.session import Session, Snapshot
from porelang.source import Span
from porelang.syntax.format import formatted

#: Seconds without an edit after which what is doubtful is sampled.
PAUSE = 0.3
#: And within which edits are one: no longer than a key is held down.
TOGETHER = 0.01
#: Of a folder no more files are looked at for programs that use one.
MOST_FILES = 20_000


def programs(folder: str) -> list[str]:
    """The programs in a folder and below, but for hidden folders; of a folder with very many files those seen first."""
    found, seen = [], 0
    for inside, folders, files in os.walk(folder):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and f != "node_modules")
        found += [os.path.normpath(os.path.join(inside, f)) for f in sorted(files) if f.endswith(".pore")]
        seen += len(files)
        if seen > MOST_FILES:
            break
    return found


class Server(LanguageServer):
    """A language server and its session, whose folder is the one that is open."""

    def __init__(self) -> None:
        super().__init__(
            "porelang", porelang.__version__, types.TextDocumentSyncKind.Incremental, protocol_cls=Protocol
        )
        self.session = Session()
        self.folder = os.getcwd()
        self.open: dict[str, str] = {}  # addresses of open documents, as the client writes them, by their paths
        self.edits: dict[str, int] = {}  # how many there were of each
        self.doubts: dict[str, tuple[Diagnostic, ...]] = {}

    @property
    def encoding(self) -> Encoding:
        """In what columns are counted."""
        return self.workspace.position_encoding or types.PositionEncodingKind.Utf16

    def opened(self, uri: str) -> Snapshot:
        """The snapshot of a document as it is now."""
        path = path_of(uri)
        if path not in self.open:
            raise JsonRpcInvalidParams(message=f"{uri} is not open")
        text = self.workspace.get_text_document(uri).source
        known = self.session.snapshot(path)
        return known if known is not None and known.source.text == text else self.session.update(path, text)

    def at(self, params: Any) -> tuple[Snapshot, int]:
        """The snapshot and the character that a question is about."""
        snapshot = self.opened(params.text_document.uri)
        return snapshot, offset(snapshot.source, params.position, self.encoding)

    def tell(self, snapshot: Snapshot, found: tuple[Diagnostic, ...]) -> None:
        """Publish what is wrong or doubtful in a document."""
        told = [answers.diagnostic(d, snapshot.source, self.encoding) for d in found]
        self.text_document_publish_diagnostics(
            types.PublishDiagnosticsParams(self.uri(snapshot.path), told, version=self._version(snapshot.path))
        )

    def uri(self, path: str) -> str:
        """The address of a file, as the client writes it where it has it open."""
        return self.open.get(path) or uri_of(path)

    def location(self, span: Span) -> types.Location:
        """A place and the address of its file, as the client writes it."""
        uri = self.open.get(span.in_file.source.name)
        return location(span, self.encoding) if uri is None else types.Location(uri, range_of(span, self.encoding))

    def _version(self, path: str) -> int | None:
        uri = self.open.get(path)
        return None if uri is None else self.workspace.get_text_document(uri).version

    def users(self, path: str) -> list[Snapshot]:
        """The files that use a file: those that are open, and those of the folder that are not."""
        open_ = [self.opened(uri) for uri in self.open.values()]  # as their clients have them now
        using = self.session.users(path)
        found: list[Snapshot | None] = [snapshot for snapshot in open_ if snapshot.path in using]
        closed = Session(self.session.workspace, self.folder)
        for other in programs(self.folder) if self.workspace.root_path else ():
            if other not in self.open and other != path:
                with suppress(PoreError):  # it cannot be read
                    closed.update(other)
        found += [closed.snapshot(user) for user in closed.users(path)]
        return [snapshot for snapshot in found if snapshot is not None]

    def again(self, paths: list[str]) -> None:
        """Tell again what is wrong in open documents, as a file that they use is another now."""
        for path in dict.fromkeys(paths):
            if path in self.open:
                snapshot = self.session.update(path)
                self.tell(snapshot, snapshot.diagnostics)

    async def changed(self, uri: str) -> None:
        """A document was opened or edited: it is compiled at once, as are the open ones that use it, and what samples
        show is told when nobody has typed for a while. Of edits that come together the last is compiled alone."""
        self.edits[uri] = edit = self.edits.get(uri, 0) + 1
        await asyncio.sleep(TOGETHER)
        if self.edits.get(uri) != edit or path_of(uri) not in self.open:
            return
        snapshot = self.opened(uri)
        waiting = [snapshot]
        for path in self.waiting_for(snapshot.path):
            waiting.append(self.session.update(path))
        for one in waiting:
            still = {s.span.source for s in one.file.statements}  # what was doubted is, where its text is still there
            kept = tuple(d for d in self.doubts.get(one.path, ()) if d.span is not None and d.span.source in still)
            said = {(d.code, d.span) for d in one.diagnostics}
            self.tell(one, (*one.diagnostics, *(d for d in kept if (d.code, d.span) not in said)))
        await asyncio.sleep(PAUSE)
        for one in waiting:
            await self._look(one)

    def waiting_for(self, path: str) -> list[str]:
        """The open documents to which a file matters: those that use it, and those that are broken: they may want one
        that was not there, and are no users of it yet."""
        known = [self.session.snapshot(other) for other in self.open]
        broken = [s.path for s in known if s is not None and s.program is None and s.compiled.file.statements]
        users = [user for user in self.session.users(path) if user in self.open]
        return [other for other in dict.fromkeys([*users, *broken]) if other != path]

    async def _look(self, snapshot: Snapshot) -> None:
        if self.session.snapshot(snapshot.path) is not snapshot or snapshot.program is None:
            return
        job = self.session.submit(("doubts", snapshot.path), lambda: snapshot.all_diagnostics)
        try:
            found = await asyncio.get_running_loop().run_in_executor(None, job.result)
        except CancelledError:
            return
        if self.session.snapshot(snapshot.path) is snapshot:
            self.doubts[snapshot.path] = tuple(d for d in found if d not in snapshot.diagnostics)
            self.tell(snapshot, found)


def server() -> Server:
    """The server with all that it answers."""
    ls = Server()

    @ls.feature(types.INITIALIZED)
    def initialized(_: types.InitializedParams) -> None:
        ls.folder = ls.workspace.root_path or os.getcwd()
        ls.session = Session(folder=ls.folder)
        able = ls.client_capabilities.workspace
        watching = able.did_change_watched_files if able is not None else None
        if watching is not None and watching.dynamic_registration:
            watched = types.DidChangeWatchedFilesRegistrationOptions([types.FileSystemWatcher("**/*.pore")])
            asked = types.Registration("watched", types.WORKSPACE_DID_CHANGE_WATCHED_FILES, watched)
            ls.client_register_capability(types.RegistrationParams([asked]))

    @ls.feature(types.SHUTDOWN)
    def shut_down(*_: object) -> None:
        ls.session.jobs.cancel()

    @ls.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def did_open(params: types.DidOpenTextDocumentParams) -> None:
        ls.open[path_of(params.text_document.uri)] = params.text_document.uri
        await ls.changed(params.text_document.uri)

    @ls.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def did_change(params: types.DidChangeTextDocumentParams) -> None:
        await ls.changed(params.text_document.uri)

    @ls.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def did_save(params: types.DidSaveTextDocumentParams) -> None:
        await ls.changed(params.text_document.uri)

    @ls.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    def did_close(params: types.DidCloseTextDocumentParams) -> None:
        path = path_of(params.text_document.uri)
        users = ls.session.users(path)
        ls.open.pop(path, None)
        ls.edits.pop(params.text_document.uri, None)
        ls.session.jobs.cancel(("doubts", path))
        ls.session.forget(path)
        ls.doubts.pop(path, None)
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(params.text_document.uri, []))
        ls.again(users)

    @ls.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def changed_on_disk(params: types.DidChangeWatchedFilesParams) -> None:
        changed = {path_of(change.uri) for change in params.changes}
        ls.again([user for path in changed for user in ls.waiting_for(path)])

    @ls.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", '"', "(", ","]))
    def completions(params: types.CompletionParams) -> types.CompletionList:
        snapshot, at = ls.at(params)
        items = complete.completions(snapshot, at, ls.folder)
        made = [answers.completion(item, snapshot.source, ls.encoding, i) for i, item in enumerate(items)]
        return types.CompletionList(False, made)

    @ls.feature(types.TEXT_DOCUMENT_HOVER)
    @ls.thread()
    def hovers(params: types.HoverParams) -> types.Hover | None:
        snapshot, at = ls.at(params)
        found = hover(snapshot, at)
        if found is None:
            return None
        text = types.MarkupContent(types.MarkupKind.Markdown, found.markdown)
        return types.Hover(text, range_of(found.span, ls.encoding))

    @ls.feature(types.TEXT_DOCUMENT_SIGNATURE_HELP, types.SignatureHelpOptions(trigger_characters=["(", ","]))
    def signatures(params: types.SignatureHelpParams) -> types.SignatureHelp | None:
        found = signature_at(*ls.at(params))
        return None if found is None else answers.signature_help(*found)

    @ls.feature(types.TEXT_DOCUMENT_DEFINITION)
    def definition(params: types.DefinitionParams) -> types.Location | None:
        span = names.definition(*ls.at(params))
        return None if span is None else ls.location(span)

    @ls.feature(types.TEXT_DOCUMENT_REFERENCES)
    def references(params: types.ReferenceParams) -> list[types.Location]:
        snapshot, at = ls.at(params)
        found = names.references(snapshot, at)
        here = names.use_at(snapshot, at)
        bound = here.bound if here is not None else None
        if bound is not None and bound.span is not None:
            home = bound.span.in_file
            if home.source.name != snapshot.path and not bound.span.source.prelude:
                found += [home]
            for user in ls.users(home.source.name):
                found += [span for span in names.uses_of(user, bound) if user.path != snapshot.path]
            if not params.context.include_declaration:
                found = [span for span in found if span != home]
        return [ls.location(span) for span in found]

    @ls.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    def prepare_rename(params: types.PrepareRenameParams) -> types.Range | None:
        use = names.use_at(*ls.at(params))
        known = use is not None and use.bound is not None and use.bound.kind != "prelude"
        return range_of(use.span, ls.encoding) if known and use is not None else None

    @ls.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
    def rename(params: types.RenameParams) -> types.WorkspaceEdit:
        snapshot, at = ls.at(params)
        here = names.use_at(snapshot, at)
        users = ls.users(snapshot.path)
        try:
            places = names.renamed(snapshot, at, params.new_name)
            for user in users:
                names.refuse_unreadable(user, here.name if here is not None else "")
        except PoreError as error:
            d = error.diagnostics[0]
            raise JsonRpcInvalidParams(message=f"{d.message}; {d.hint}") from None
        edits = {params.text_document.uri: [types.TextEdit(range_of(p, ls.encoding), params.new_name) for p in places]}
        bound = here.bound if here is not None else None
        for user in users:
            found = names.uses_of(user, bound) if bound is not None else []
            if found:
                edits[ls.uri(user.path)] = [types.TextEdit(range_of(p, ls.encoding), params.new_name) for p in found]
        return types.WorkspaceEdit(edits)

    @ls.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def symbols(params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        return [answers.symbol(s, ls.encoding) for s in outline.symbols(ls.opened(params.text_document.uri))]

    @ls.feature(types.TEXT_DOCUMENT_FOLDING_RANGE)
    def folds(params: types.FoldingRangeParams) -> list[types.FoldingRange]:
        found = outline.folds(ls.opened(params.text_document.uri))
        return [types.FoldingRange(first - 1, last - 1, kind=kind) for first, last, kind in found]

    @ls.feature(types.TEXT_DOCUMENT_FORMATTING)
    def formatting(params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        source = ls.opened(params.text_document.uri).source
        try:
            text = formatted(source)
        except PoreError:  # what is wrong is among the diagnostics
            return None
        whole = Span(source, 0, len(source.text))
        return [] if text == source.text else [types.TextEdit(range_of(whole, ls.encoding), text)]

    @ls.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, answers.LEGEND)
    def semantic(params: types.SemanticTokensParams) -> types.SemanticTokens:
        return answers.semantic_tokens(ls.opened(params.text_document.uri), ls.encoding)

    @ls.feature(types.TEXT_DOCUMENT_INLAY_HINT)
    def inlay(params: types.InlayHintParams) -> list[types.InlayHint]:
        snapshot = ls.opened(params.text_document.uri)
        found = ((position(snapshot.source, at, ls.encoding), text) for at, text in outline.hints(snapshot))
        within = params.range
        return [types.InlayHint(at, text, padding_left=True) for at, text in found if within.start <= at <= within.end]

    @ls.feature(
        types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix])
    )
    def actions(params: types.CodeActionParams) -> list[types.CodeAction]:
        uri = params.text_document.uri
        snapshot = ls.opened(uri)
        found = (*snapshot.diagnostics, *ls.doubts.get(snapshot.path, ()))
        return answers.actions(uri, found, snapshot.source, params.range, ls.encoding)

    return ls


def serve() -> None:
    """Answer on standard input and output until the client ends; what else is printed goes to standard error."""
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out, redirect_stdout(sys.stderr):
        server().start_io(stdout=out)
