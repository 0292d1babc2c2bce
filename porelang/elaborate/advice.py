"""What to do about a call whose arguments do not fit: the words of the hint, and the edit that mends it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from porelang.diagnostics import Edit, suggest
from porelang.elaborate.context import Context
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.values import Function, Given, Poison, Scalar, Value
from porelang.source import Span
from porelang.syntax import habits, tree


def are_swapped(ctx: Context, function: Function, given: dict[str, Given], site: tree.Call) -> bool:
    """Whether the first two arguments fit each other's parameters and not their own; then it has been said."""
    if len(function.parameters) < 2:
        return False
    first, second = function.parameters[:2]
    a, b = given.get(first.name), given.get(second.name)
    if a is None or b is None or a.name or b.name or any(isinstance(v.value, Poison) for v in (a, b)):
        return False
    if _fits(first, a.value) or _fits(second, b.value) or not (_fits(first, b.value) and _fits(second, a.value)):
        return False
    order = ", ".join(f"`{p.name}`" for p in (first, second))
    edit = None
    hint = f"`{first.name}` comes first"
    if a.span.source is b.span.source and site.span.start <= a.span.start < b.span.start:
        between = Span(a.span.source, a.span.end, b.span.start).text
        edit = Edit(a.span.to(b.span), f"{b.span.text}{between}{a.span.text}")
        hint = f"write `{function.name}({edit.text}{', ...' if len(given) > 2 else ''})`"
    ctx.error("E060", f"`{function.name}` takes {order}, in this order", a.span.to(b.span),
              label="the two stand the other way round", hint=hint, edit=edit)  # fmt: skip
    return True


def _fits(p: tree.Parameter, value: Value) -> bool:
    kinds = [KINDS[k.name] for k in p.kinds if k.name in KINDS]
    return not kinds or any(k.coerce(value) is not None for k in kinds)


#: Contracts of the prelude that say more than a comparison, in words.
_WORDS = (
    (re.compile(r"min_component\((\w+)\) > 0"), r"`\1` to be above 0 along every axis"),
    (re.compile(r"dot\((\w+), \1\) > 0"), r"a `\1` that points somewhere, not [0, 0, 0]"),
    (re.compile(r"len\((\w+)\) >= (\d+)"), r"at least \2 `\1`"),
    (re.compile(r"(\w+) is a whole number"), r"a whole number for `\1`"),
)


def in_words(contract: str) -> str:
    for form, words in _WORDS:
        if form.fullmatch(contract):
            return form.sub(words, contract)
    contract = re.sub(r"min_component\((\w+)\)", r"the least of \1", contract)
    return f"`{contract}`"


def kept(function: Function, contract: str, name: str, place: Span) -> tuple[str, Edit | None]:
    """How a contract may be kept that a constant breaks. The prelude's cannot be changed, the user's can."""
    if function.name in habits.BROKEN and contract.endswith("> 0"):
        return habits.BROKEN[function.name], None
    if re.fullmatch(r"-\s*[\w.]+", place.text) and re.fullmatch(rf"{name} >=? 0", contract):
        positive = place.text[1:].strip()
        return f"write `{positive}`", Edit(place, positive)
    hint = f"give `{name}` a value for which that holds"
    prelude = function.definition is not None and function.definition.span.source.prelude
    return hint if prelude else f"{hint}, or change the contract", None


def is_number(text: str) -> bool:
    """Whether a text is a number as it is written, with or without a unit."""
    return re.fullmatch(r"-?(\d+\.?\d*|\.\d+)[A-Za-z]*", text.strip()) is not None


def too_many(function: Function, arguments: Sequence[Given]) -> tuple[str, Edit | None]:
    """What to write where there are more arguments than parameters."""
    told = _one_by_one(function, arguments)
    return told if told[0] or len(arguments) != len(function.parameters) + 1 else _decimal_comma(arguments)


def _decimal_comma(arguments: Sequence[Given]) -> tuple[str, Edit | None]:
    """What to write for `5,5mm`, which reads as two arguments."""
    for a, b in pairwise(arguments):
        touch = a.span.source is b.span.source and Span(a.span.source, a.span.end, b.span.start).text == ","
        if touch and a.span.text.isdigit() and is_number(b.span.text):
            joined = f"{a.span.text}.{b.span.text}"
            hint = f"a comma parts arguments; with a decimal point it is `{joined}`"
            if re.fullmatch(r"\d{3}[A-Za-z]*", b.span.text):
                return f"{hint}, without separators `{a.span.text}{b.span.text}`", None
            return hint, Edit(a.span.to(b.span), joined)
    return "", None


def _one_by_one(function: Function, arguments: Sequence[Given]) -> tuple[str, Edit | None]:
    """What to write where the items of a list, or the components of a vector, are given one by one."""
    params = function.parameters
    extra = len(arguments) - len(params)
    at = next((i for i, p in enumerate(params) if {k.name for k in p.kinds} & {"list", "vector", "point"}), None)
    if at is None or any(a.name for a in arguments):
        return "", None
    is_list = any(k.name == "list" for k in params[at].kinds)
    count = extra + 1 if is_list else 3
    taken = arguments[at : at + count]
    if len(taken) < count or (not is_list and not all(isinstance(a.value, Scalar) for a in taken)):
        return "", None
    first, end = taken[0].span, taken[-1].span
    if first.source is not end.source or end.end < first.start:  # the first was handed on by `|>`
        return f"`{params[at].name}` is one argument: `[a, b, c]`", None
    items = first.to(end)
    if len(params) > 1:
        what = "a list" if is_list else "a vector"
        return f"`{params[at].name}` is {what}: write `[{items.text}]`", Edit(items, f"[{items.text}]")
    sign = {"union": "|", "intersection": "&"}.get(function.name)
    more = f", or `{f' {sign} '.join(a.span.text for a in arguments)}`" if sign and len(items.text) < 60 else ""
    shown = items.text if len(items.text) < 60 else "a, b"
    return f"it takes one list: write `{function.name}([{shown}])`{more}", Edit(items, f"[{items.text}]")


def other_parameter(
    name: str, a: Given, names: Sequence[str], spot: Span, site: tree.Call | None
) -> tuple[str, Edit | None]:
    """What is meant by a parameter that a function has not."""
    word = a.name or ""
    value = a.span.text[len(word) :].partition("=")[2].strip()
    if word in ("d", "diameter", "dia") and "r" in names and value:
        half = f"r={value} / 2" if value.replace(".", "").isalnum() else f"r=({value}) / 2"
        return f"it takes the radius: write `{half}`", Edit(a.span, half)
    if (name, word) in habits.OTHER_FUNCTIONS and site is not None:
        ours, why = habits.OTHER_FUNCTIONS[name, word]
        named = isinstance(site.function, tree.Name) and site.function.name == name
        return why, Edit(site.function.span, ours) if named else None
    if word in habits.NEEDLESS:
        text = a.span.source.text
        before, after = len(text[: a.span.start].rstrip()), len(text) - len(text[a.span.end :].lstrip())
        start = before - 1 if text[:before].endswith(",") else a.span.start
        end = after + 1 if start == a.span.start and text[after : after + 1] == "," else a.span.end
        return f"leave it out: {habits.NEEDLESS[word]}", Edit(Span(a.span.source, start, end), "")
    near = next((p for p in habits.PARAMETERS.get(word, ()) if p in names), None) or suggest(word, names)
    if near:
        return f"did you mean `{near}`?", Edit(spot, near)
    return f"its parameters are {', '.join(names) or 'none'}", None
