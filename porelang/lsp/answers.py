"""What is told, in the types of the protocol."""

from __future__ import annotations

from collections.abc import Iterable

from lsprotocol import types

from porelang.assist import outline
from porelang.assist.complete import Item, What
from porelang.assist.outline import Symbol
from porelang.assist.shown import Signature
from porelang.diagnostics import Diagnostic
from porelang.lsp.places import Encoding, location, position, range_of, width
from porelang.session import Snapshot
from porelang.source import Source, Span

_SEVERITY = {
    "error": types.DiagnosticSeverity.Error,
    "warning": types.DiagnosticSeverity.Warning,
    "note": types.DiagnosticSeverity.Information,
}
_KIND: dict[What, types.CompletionItemKind] = {
    "function": types.CompletionItemKind.Function,
    "param": types.CompletionItemKind.Property,
    "value": types.CompletionItemKind.Variable,
    "file": types.CompletionItemKind.File,
    "argument": types.CompletionItemKind.Field,
    "member": types.CompletionItemKind.Field,
    "unit": types.CompletionItemKind.Unit,
    "word": types.CompletionItemKind.Keyword,
    "kind": types.CompletionItemKind.TypeParameter,
    "text": types.CompletionItemKind.Text,
    "namespace": types.CompletionItemKind.Module,
}
_SYMBOL = {
    "param": types.SymbolKind.Property,
    "let": types.SymbolKind.Variable,
    "def": types.SymbolKind.Function,
    "use": types.SymbolKind.Module,
    "out": types.SymbolKind.Object,
    "check": types.SymbolKind.Boolean,
    "preset": types.SymbolKind.Constant,
}
#: The words of semantic tokens, and what may be said more; their numbers are their places here.
WORDS = ("keyword", "number", "string", "comment", "operator", "function", "parameter", "variable", "property",
         "namespace", "type")  # fmt: skip
MORE = ("declaration", "documentation", "defaultLibrary", "readonly")
LEGEND = types.SemanticTokensLegend(list(WORDS), list(MORE))


def diagnostic(d: Diagnostic, main: Source, encoding: Encoding) -> types.Diagnostic:
    """A diagnostic; one of another file, or without a place, is told at the beginning of this one."""
    here = d.span is not None and d.span.in_file.source is main
    place = d.span if here and d.span is not None else Span(main, 0, 0)
    message = d.message if here or d.span is None else f"{d.span}: {d.message}"
    label = f"\n{d.label}" if d.label else ""
    hint = f"\nhint: {d.hint}" if d.hint else ""
    others = [types.DiagnosticRelatedInformation(location(o.span, encoding), o.text or "here") for o in d.others]
    return types.Diagnostic(
        range_of(place, encoding), f"{message}{label}{hint}", _SEVERITY[d.severity], d.code or None, source="pore",
        related_information=others or None,
        tags=[types.DiagnosticTag.Unnecessary] if d.code == "W220" else None,
    )  # fmt: skip


def actions(
    uri: str, found: Iterable[Diagnostic], main: Source, at: types.Range, encoding: Encoding
) -> list[types.CodeAction]:
    """The edits that mend what is wrong in a range."""
    made = []
    for d in found:
        if d.edit is None or d.span is None or d.edit.span.in_file.source is not main:
            continue
        told = diagnostic(d, main, encoding)
        if told.range.end < at.start or at.end < told.range.start:
            continue
        change = types.TextEdit(range_of(d.edit.span, encoding), d.edit.text)
        title = d.hint.partition("; ")[0][:100] or f"write `{d.edit.text}`"
        made.append(
            types.CodeAction(
                title, types.CodeActionKind.QuickFix, [told], True, edit=types.WorkspaceEdit({uri: [change]})
            )
        )
    return made


def completion(item: Item, source: Source, encoding: Encoding, rank: int) -> types.CompletionItem:
    """A completion; `rank` keeps the order that they have."""
    place = types.Range(position(source, item.start, encoding), position(source, item.end, encoding))
    return types.CompletionItem(
        item.label, kind=_KIND[item.what], detail=item.detail or None, documentation=item.doc or None,
        sort_text=f"{rank:05}", filter_text=item.text, text_edit=types.TextEdit(place, item.text),
    )  # fmt: skip


def signature_help(found: Signature, at: int) -> types.SignatureHelp:
    """How a function is called, and which of its parameters is being written."""
    parameters = [types.ParameterInformation(p.text) for p in found.parameters]
    told = types.SignatureInformation(str(found), types.MarkupContent(types.MarkupKind.Markdown, found.doc), parameters)
    return types.SignatureHelp([told], 0, at)


def symbol(s: Symbol, encoding: Encoding) -> types.DocumentSymbol:
    """An entry of the outline."""
    return types.DocumentSymbol(
        s.name or s.what, _SYMBOL[s.what], range_of(s.span, encoding), range_of(s.name_span, encoding), s.detail or None
    )


def semantic_tokens(snapshot: Snapshot, encoding: Encoding) -> types.SemanticTokens:
    """What each token is: five numbers each, places relative to the one before."""
    data: list[int] = []
    line = column = 0
    text = snapshot.source
    for said in outline.semantic(snapshot):
        at = position(text, said.start, encoding)
        length = width(text.text[said.start : said.start + said.length], encoding)
        more = sum(1 << MORE.index(m) for m in said.more)
        data += [
            at.line - line,
            at.character - (column if at.line == line else 0),
            length,
            WORDS.index(said.word),
            more,
        ]
        line, column = at.line, at.character
    return types.SemanticTokens(data)
