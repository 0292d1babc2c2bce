"""From the rules of `grammar/pore.lark` to the syntax tree: one method a rule, called from the bottom up."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Any

from porelang.diagnostics import Edit, Label, PoreError, fail
from porelang.source import Span
from porelang.syntax import tree
from porelang.syntax.failure import new_value
from porelang.syntax.measures import unknown_unit
from porelang.syntax.tokens import Token
from porelang.units import UNITS

_NUMBER = re.compile(r"([0-9.]+(?:[eE][+-]?[0-9]+)?)(.*)")
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_ESCAPES = {'"': '"', "\\": "\\", "n": "\n"}
_COMPOSED = (tree.Chain, tree.Unary, tree.If, tree.Lambda)


@dataclass(frozen=True, slots=True, eq=False)
class Parens:
    """`(a, b)`: a value in parentheses if it is one, the parameters of a function if `=>` follows."""

    span: Span
    items: tuple[tree.Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Bare:
    """An expression that stands as a statement."""

    span: Span
    value: tree.Expr


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    value: tree.Expr


@dataclass(frozen=True, slots=True, eq=False)
class Default:
    value: tree.Expr


class Builder:
    """The actions of the grammar's rules. Holds no state: each token carries its place and source."""

    # ---- statements

    def file(self, children: list[Any]) -> list[Any]:
        return children

    def use(self, children: list[Any]) -> tree.Use:
        head, path, _, name = children
        return tree.Use(head.span.to(name.span), self.text([path]), name.text, name.span)

    def param(self, children: list[Any]) -> tree.Param:
        head, name, _, default, _, low, _, high, _, step, doc = children
        span = head.span.to((doc or step or high).span)
        return tree.Param(span, name.text, name.span, default, low, high, step, (), self._doc(head, doc))

    def choice(self, children: list[Any]) -> tree.Param:
        head, name, _, default, _, _, *choices, close, doc = children
        span = head.span.to((doc or close).span)
        said = self._doc(head, doc)
        return tree.Param(span, name.text, name.span, default, None, None, None, tuple(choices), said)

    def data(self, children: list[Any]) -> tree.Param:
        head, name, _, kind, _, default, doc = children
        span = head.span.to((doc or default).span)
        said = self._doc(head, doc)
        return tree.Param(span, name.text, name.span, default, None, None, None, (), said, kind.text, kind.span)

    def preset(self, children: list[Any]) -> tree.Preset:
        head, name, _, *settings = children
        return tree.Preset(head.span.to(settings[-1].span), _text(name).value, name.span, tuple(settings))

    def setting(self, children: list[Any]) -> tree.Setting:
        *name, _, value = children
        text = "".join(t.text for t in name)
        return tree.Setting(name[0].span.to(value.span), text, name[0].span.to(name[-1].span), value)

    def _doc(self, head: Token, doc: Token | None) -> str:
        return head.doc if doc is None else self.text([doc]).value

    def let(self, children: list[Any]) -> tree.Let:
        head, name, _, value = children
        return tree.Let(head.span.to(value.span), name.text, name.span, value)

    def definition(self, children: list[Any]) -> tree.Def:
        head, name, _, *parameters, _, _, body = children
        flat: list[tree.Parameter] = []
        for parameter in parameters:
            flat.extend(parameter if isinstance(parameter, tuple) else (parameter,))
        return tree.Def(head.span.to(body.span), name.text, name.span, tuple(flat), body, head.doc)

    def out(self, children: list[Any]) -> tree.Out:
        head, name, _, value = children
        return tree.Out(head.span.to(value.span), name.text, name.span, value)

    def check(self, children: list[Any]) -> tree.Check:
        head, condition, message = children
        return tree.Check(head.span.to(message.span), condition, self.text([message]).value)

    def bare(self, children: list[Any]) -> Bare:
        return Bare(children[0].span, children[0])

    # ---- parameters of a def

    def parameter(self, children: list[Any]) -> tree.Parameter:
        name, *rest = children
        kinds: tuple[tree.Name, ...] = ()
        where = default = None
        end = name.span
        for part in rest:
            if isinstance(part, Where):
                where = part.value
                end = where.span
            elif isinstance(part, Default):
                default = part.value
                end = default.span
            else:
                kinds = part
                end = part[-1].span
        return tree.Parameter(name.span.to(end), name.text, name.span, kinds, where, default, None)

    def alternatives(self, children: list[Any]) -> tuple[tree.Parameter, tree.Parameter]:
        *first, word, second = children
        if second.default is None:
            raise fail(
                "E024",
                f"`{second.name}` needs a default that computes it from `{first[0].text}`",
                second.span,
                others=(Label(word.span, "one of the two is given by a caller"),),
                hint=f"write `{first[0].text} or {second.name} = ...`",
            )
        return replace(self.parameter(first), alternative=second.name), second

    def kinds(self, children: list[Any]) -> tuple[tree.Name, ...]:
        return tuple(tree.Name(c.span, c.text) for c in children if c.type == "NAME")

    def where(self, children: list[Any]) -> Where:
        return Where(children[1])

    def default(self, children: list[Any]) -> Default:
        return Default(children[1])

    # ---- expressions

    def conditional(self, children: list[Any]) -> tree.If:
        # if a then b [else-if a then b]... else c
        branches = tuple((children[i], children[i + 2]) for i in range(1, len(children) - 2, 4))
        return tree.If(children[0].span.to(children[-1].span), branches, children[-1])

    def function(self, children: list[Any]) -> tree.Lambda:
        left, arrow, body = children
        items = left.items if isinstance(left, Parens) else (left,)
        names = tuple(item for item in items if isinstance(item, tree.Name))
        if not items:
            raise fail("E017", "a function needs a parameter", left.span, hint="a value without one is just `let`")
        for item in items:
            if not isinstance(item, tree.Name):
                raise fail(
                    "E017",
                    "what stands left of `=>` is a name, or names in parentheses",
                    item.span,
                    label="not a name",
                    others=(Label(arrow.span, "of this function"),),
                    hint="write `t => ...` or `(a, b) => ...`; an assignment is `let`, a comparison `>=`",
                )
        return tree.Lambda(left.span.to(body.span), names, body)

    def chain(self, children: list[Any]) -> tree.Chain:
        first = children[0]
        operators, operands = children[1::2], children[2::2]
        rest = tuple(zip((o.text for o in operators), operands, strict=True))
        return tree.Chain(first.span.to(operands[-1].span), first, rest, tuple(o.span for o in operators))

    def pipe(self, children: list[Any]) -> tree.Chain:
        for target in children[2::2]:
            if not isinstance(target, tree.Call | tree.Name | tree.Member):
                _not_a_pipe_target(target)
        return self.chain(children)

    def unary(self, children: list[Any]) -> tree.Unary:
        op, operand = children
        return tree.Unary(op.span.to(operand.span), op.text, operand)

    def operand(self, children: list[Any]) -> Any:
        return _value(children[0])

    def call(self, children: list[Any]) -> tree.Call:
        function, opened, *arguments, close = children
        _same_line(opened, function)
        named: tree.Argument | None = None
        for argument in arguments:
            if argument.name is not None:
                named = argument
            elif named is not None:
                raise fail(
                    "E021",
                    "an argument without a name stands after one with a name",
                    argument.span,
                    others=(Label(named.span, "named here"),),
                    hint="put it before the named ones, or name it too",
                )
        function = _value(function)
        return tree.Call(function.span.to(close.span), function, tuple(arguments))

    def argument(self, children: list[Any]) -> tree.Argument:
        value = children[-1]
        if len(children) == 1:
            return tree.Argument(value.span, None, value)
        return tree.Argument(children[0].span.to(value.span), children[0].text, value)

    def member(self, children: list[Any]) -> tree.Member:
        target, _, name = children
        target = _value(target)
        return tree.Member(target.span.to(name.span), target, name.text, name.span)

    def index(self, children: list[Any]) -> tree.Index:
        target, opened, index, close = children
        _same_line(opened, target)
        target = _value(target)
        return tree.Index(target.span.to(close.span), target, index)

    def number(self, children: list[Any]) -> tree.Number:
        return _number(children[0])

    def text(self, children: list[Any]) -> tree.Text:
        return _text(children[0])

    def truth(self, children: list[Any]) -> tree.Boolean:
        return tree.Boolean(children[0].span, children[0].type == "TRUE")

    def name(self, children: list[Any]) -> tree.Name:
        return tree.Name(children[0].span, children[0].text)

    def parens(self, children: list[Any]) -> Parens:
        return Parens(children[0].span.to(children[-1].span), tuple(children[1:-1]))

    def list_of(self, children: list[Any]) -> tree.List:
        return tree.List(children[0].span.to(children[-1].span), tuple(children[1:-1]))

    def comprehension(self, children: list[Any]) -> tree.Comprehension:
        opened, *clauses, _, value, close = children
        return tree.Comprehension(opened.span.to(close.span), tuple(clauses), value)

    def clause(self, children: list[Any]) -> tree.Clause:
        _, name, _, items, *filters = children
        return tree.Clause(tree.Name(name.span, name.text), items, tuple(filters))

    def filter(self, children: list[Any]) -> tree.Expr:
        return children[1]  # type: ignore[no-any-return]  # what lark hands over has no type

    def block(self, children: list[Any]) -> tree.Block:
        opened, *bindings, value, close = children
        return tree.Block(opened.span.to(close.span), tuple(bindings), value)

    disjunction = conjunction = comparison = union = intersection = sum = product = power = at = range = chain


def _value(node: Any) -> Any:
    """The value of what may stand in parentheses; a composed one is then shown with them."""
    if not isinstance(node, Parens):
        return node
    if len(node.items) == 1:
        item = node.items[0]
        return replace(item, span=node.span) if isinstance(item, _COMPOSED) else item
    if not node.items:
        raise fail("E007", "these parentheses are empty", node.span, label="a value is missing")
    inner = node.span.text[1:-1].strip().rstrip(",")
    raise fail(
        "E017",
        "several values in parentheses are not a value",
        node.span,
        hint="write [a, b, c] for a vector or a list; before `=>` they are the parameters of a function",
        edit=Edit(node.span, f"[{inner}]"),
    )


def _same_line(opened: Token, target: Any) -> None:
    if opened.starts_line:
        raise PoreError(new_value(opened, target.span))


def _not_a_pipe_target(target: tree.Expr) -> None:
    label, hint = "not a call", "write `a |> f(b)` for `f(a, b)`"
    first = target.first if isinstance(target, tree.Chain) else None
    if isinstance(target, tree.Chain) and isinstance(first, tree.Call | tree.Name | tree.Member):
        op = target.rest[0][0]
        hint = f"`{op}` binds tighter than `|>`: put the part before `{op}` in parentheses, `(a |> f(b)) {op} c`"
    raise fail(
        "E016",
        "what stands right of `|>` is a function, with or without arguments",
        target.span,
        label=label,
        hint=hint,
    )


def _number(token: Token) -> tree.Number:
    match = _NUMBER.fullmatch(token.text)
    assert match is not None  # the terminal NUMBER is this and more
    digits, unit = match.groups()
    if unit and unit not in UNITS:
        place = Span(token.span.source, token.span.start + len(digits), token.span.end)
        raise PoreError(unknown_unit(token.span, digits, place))
    value = float(digits)
    if math.isinf(value) or (unit and math.isinf(value * UNITS[unit].scale)):
        raise fail("E003", "this number is too large", token.span, hint="the largest is about 1.8e308")
    return tree.Number(token.span, value, unit)


def _text(token: Token) -> tree.Text:
    inner = token.text[1:-1]
    start = token.span.start + 1
    for match in _ESCAPE.finditer(inner):
        if match[1] not in _ESCAPES:
            place = Span(token.span.source, start + match.start(), start + match.end())
            edit = Edit(place, "\\\\" + match[1])
            hint = 'the escapes are \\" \\\\ and \\n; for a backslash write \\\\'
            raise fail("E004", "this escape is not known", place, hint=hint, edit=edit)
    for i, char in enumerate(inner):
        if (char < " " and char != "\t") or "\ud800" <= char <= "\udfff":
            place = Span(token.span.source, start + i, start + i + 1)
            raise fail("E004", f"the character U+{ord(char):04X} cannot stand in a text", place, hint="leave it out")
    return tree.Text(token.span, _ESCAPE.sub(lambda m: _ESCAPES[m[1]], inner))
