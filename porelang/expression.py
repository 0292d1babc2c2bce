"""What a text names in a program, or says in its words: an output, a `let`, or an expression of these, as in
`s.von_mises / 10MPa`, which an option asks for and the program does not contain."""

from __future__ import annotations

from dataclasses import dataclass, replace

from porelang import outputs
from porelang.diagnostics import Diagnostic, PoreError, fail
from porelang.elaborate.values import Bool, Scalar, Vector
from porelang.ir import Node
from porelang.program import Program
from porelang.rewrites import flatten
from porelang.source import Source, Span
from porelang.syntax.parse import parse
from porelang.units import Dimension

#: What an expression is called for as long as it is compiled.
_NAME = "asked_for"
_STATEMENTS = frozenset({"use", "param", "let", "def", "out", "check", "preset"})
_FUNCTION = "the function "


@dataclass(frozen=True, slots=True)
class Expression:
    """A text, its flat `roots` (one, or three of a vector), and what it is in the language."""

    text: str
    roots: tuple[Node, ...]
    value: Scalar | Vector | Bool

    @property
    def dimension(self) -> Dimension | None:
        """What it is measured in; None where that is not known."""
        return None if isinstance(self.value, Bool) else self.value.dimension


def expression(program: Program, text: str, option: str) -> Expression:
    """What a text asks of a program. `option` is where it was given, for messages.

    Errors: E100 where a name is that of nothing which has values, and what is wrong with an expression, at its place.

    >>> import porelang
    >>> program = porelang.compile("let ball = sphere(5mm)\\nball")
    >>> str(expression(program, "2 * ball", "--field").dimension)
    'a length'
    """
    text = text.strip()
    if text in program.outputs:
        return Expression(text, program.graph.outputs[text], program.outputs[text].value)
    if (let := program.elaborated.lets.get(text)) is not None:
        return Expression(text, flatten(let.node), let)
    if text in program.studies:
        raise fail("E100", f"`{text}` is a study, which gives several fields",
                   hint=f"ask for one, as in `{option} {text}.von_mises`")  # fmt: skip
    try:
        return _compiled(program, text, option)
    except PoreError as error:
        if any(d.code == "E066" for d in error.diagnostics):
            first = error.diagnostics[0]
            said = first.label.removeprefix("this is ")
            if said.startswith(_FUNCTION):
                raise fail("E101", f"`{text}` is a function, and no field", hint=first.hint) from None
            raise fail("E101", f"`{text}` is {said}: several numbers in each place",
                       hint=_one_of(text)) from None  # fmt: skip
        if text.isidentifier() or not text:
            raise outputs.no_number(program.elaborated, text) from None
        raise


def _one_of(text: str) -> str:
    """What to ask for in place of a collection; of a tensor what engineers look at."""
    study, _, member = text.rpartition(".")
    if study and member in ("stress", "strain"):
        more = f", `{study}.von_mises` or `{study}.principal1`" if member == "stress" else ""
        return f"one of them: `{text}.xx`{more}"
    return f"one of them by its name, as in `{text}.xx`"


def _compiled(program: Program, text: str, option: str) -> Expression:
    own = program.source.text
    name = _NAME
    while name in own:
        name += "_"
    before = f"out {name} = ("
    try:
        made = program.also(f"{before}{text}\n)\n")  # the end of a line ends a comment too
    except PoreError as error:
        asked = Source(option, text)
        _alone(asked)
        raise PoreError([_placed(d, program.source.name, len(before), asked) for d in error.diagnostics]) from None
    return Expression(text, made.graph.outputs[name], made.outputs[name].value)


def _alone(asked: Source) -> None:
    """What is wrong in the syntax of a text, without the parentheses that it stands in. Errors: that."""
    read, wrong = parse(asked)
    if wrong:
        raise PoreError(wrong)
    word = asked.text.split(maxsplit=1)[0] if asked.text else ""
    if word in _STATEMENTS and read.statements:
        raise fail("E007", f"a value is asked for, and `{word}` begins a statement", read.statements[0].span,
                   label="value expected", hint="write an expression, such as `z / 2`")  # fmt: skip


def _placed(d: Diagnostic, file: str, begin: int, asked: Source) -> Diagnostic:
    """A diagnostic of the longer program, with its place in the text that was asked for."""

    def at(span: Span) -> bool:
        return span.source.name == file

    def moved(span: Span) -> Span:
        start, end = (min(max(p - begin, 0), len(asked.text)) for p in (span.start, span.end))
        return Span(asked, start, max(start, end))

    if d.span is None or not at(d.span):
        return d
    others = tuple(replace(o, span=moved(o.span)) if at(o.span) else o for o in d.others)
    return replace(d, span=moved(d.span), others=others, edit=None)
