"""What to do about a call whose arguments do not fit: the words of the hint, and the edit that mends it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise, permutations

from porelang.diagnostics import Edit, suggest
from porelang.elaborate import suspect
from porelang.elaborate.bare import value_of
from porelang.elaborate.context import Context
from porelang.elaborate.kinds import KINDS
from porelang.elaborate.values import Function, Given, Poison, Scalar, Text, Value
from porelang.source import Span
from porelang.syntax import habits, tree

#: Operators between solids.
SETS = ("&", "|", "\\")


def are_swapped(ctx: Context, function: Function, given: dict[str, Given], site: tree.Call) -> bool:
    """Whether the first arguments, three at most, fit the parameters in another order only; then it has been said."""
    parameters = [p for p in function.parameters[:3] if p.name in given]
    arguments = [given[p.name] for p in parameters]
    if len(arguments) < 2 or any(a.name or isinstance(a.value, Poison) for a in arguments):
        return False
    if all(_fits(p, a.value) for p, a in zip(parameters, arguments, strict=True)):
        return False
    fitting = (o for o in permutations(arguments) if all(map(_is_for, parameters, (a.value for a in o))))
    ours = next(fitting, None)
    if ours is None:
        return False
    moved = [i for i, (a, o) in enumerate(zip(arguments, ours, strict=True)) if a is not o]
    order = ", ".join(f"`{p.name}`" for p in parameters[moved[0] : moved[-1] + 1])
    first, last = arguments[moved[0]].span, arguments[moved[-1]].span
    places = [a.span for a in arguments[moved[0] : moved[-1] + 1]]
    edit, where = None, first
    hint = f"`{parameters[moved[0]].name}` comes first"
    one_source = all(p.source is site.span.source for p in places)
    if one_source and site.span.start <= first.start and all(p.start < q.start for p, q in pairwise(places)):
        gaps = [Span(p.source, p.end, q.start).text for p, q in pairwise(places)]
        texts = [a.span.text for a in ours[moved[0] : moved[-1] + 1]]
        where = first.to(last)
        edit = Edit(where, "".join(t + gap for t, gap in zip(texts, [*gaps, ""], strict=True)))
        piped = arguments[0].span.start < site.function.span.start
        before = "" if piped else Span(first.source, arguments[0].span.start, first.start).text
        more = ", ..." if len(given) > moved[-1] + 1 else ""
        hint = f"write `{function.name}({before}{edit.text}{more})`"
    label = "the two stand the other way round" if len(moved) == 2 else "these stand in another order"
    ctx.error("E060", f"`{function.name}` takes {order}, in this order", where, label=label, hint=hint, edit=edit)
    return True


def _is_for(p: tree.Parameter, value: Value) -> bool:
    """Whether a value fits a parameter, and is what is usually given for it: what varies in space for a field alone."""
    if not isinstance(value, Scalar):
        return _fits(p, value)
    return _fits(p, value) and bool(value.node.axes) == bool({k.name for k in p.kinds} & {"field", "solid"})


def _fits(p: tree.Parameter, value: Value) -> bool:
    kinds = [KINDS[k.name] for k in p.kinds if k.name in KINDS]
    return not kinds or any(k.coerce(value) is not None for k in kinds)


def as_solid(t: tree.Chain) -> tuple[str, Edit | None]:
    """How to write a condition as a solid, if it compares two numbers, and the edit where it can hardly be meant.

    `sphere(10) & z > 2mm` compares `sphere(10) & z`: what stands beside the comparison is what was to be compared.
    """
    op, left, right, joined = t.rest[0][0], t.first, t.rest[0][1], False
    while isinstance(left, tree.Chain) and left.rest[0][0] in SETS and not suspect.bracketed(left):
        left, joined = left.rest[-1][1], True
    while isinstance(right, tree.Chain) and right.rest[0][0] in SETS and not suspect.bracketed(right):
        right, joined = right.first, True
    if op not in ("<", "<=", ">", ">="):
        return "a solid is a number that is negative inside", None
    low, high = (left, right) if op[0] == "<" else (right, left)
    half = f"{_term(low)} - {_term(high)}"
    if isinstance(high, tree.Number) and high.value == 0:
        half = low.span.text
    elif isinstance(low, tree.Number) and low.value == 0:
        half = f"-{_term(high)}"
    if not joined:
        return f"a solid is a number that is negative inside: `{half}` for `{t.span.text.strip('()')}`", None
    edit = Edit(left.span.to(right.span), f"({half})")
    whole = t.span.text.replace(edit.span.text, edit.text)
    what = f"write `{whole}`" if len(whole) < 60 else f"write `({half})`"
    return f"`{op}` compares all that stands beside it; as a solid a half space is a number: {what}", edit


def joins(t: tree.Chain) -> bool:
    """Whether a comparison has an operator between solids beside it."""
    sides = (t.first, t.rest[0][1])
    return any(isinstance(s, tree.Chain) and s.rest[0][0] in SETS and not suspect.bracketed(s) for s in sides)


def _term(t: tree.Expr) -> str:
    """The text of an expression as it may stand in a difference."""
    tight = isinstance(t, tree.Number | tree.Name | tree.Call | tree.Member | tree.Index)
    if isinstance(t, tree.Chain):
        tight = suspect.bracketed(t) or t.rest[0][0] in ("*", "/", "^")
    return t.span.text if tight else f"({t.span.text})"


#: Contracts of the prelude that say more than a comparison, in words.
_WORDS = (
    (re.compile(r"min_component\((\w+)\) > 0"), r"`\1` to be above 0 along every axis"),
    (re.compile(r"dot\((\w+), \1\) > 0"), r"a `\1` that points somewhere, not [0, 0, 0]"),
    (re.compile(r"len\((\w+)\) >= (\d+)"), r"at least \2 `\1`"),
    (
        re.compile(r"len\((\w+)\) >= (\d+) and shortest_piece\(\1\) >= [\d.]+"),
        r"at least \2 `\1`, each apart from the one before",
    ),
    (
        re.compile(r"not closed or w > 0 and len\((\w+)\) >= (\d+) and shortest_piece\(\1, true\) >= [\d.]+"),
        r"a `w`, and at least \2 `\1` of which the last does not repeat the first, for a closed curve",
    ),
    (
        re.compile(r"not closed or len\((\w+)\) >= (\d+) and shortest_piece\(\1, true\) >= [\d.]+"),
        r"at least \2 `\1`, of which the last does not repeat the first, for a closed curve",
    ),
    (
        re.compile(r"(\w+) >= 0 and \1 <= widest_bend\((\w+), closed\)"),
        r"a `\1` from 0 to the greatest that fits all corners, `widest_bend(\2)`",
    ),
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
    if (ours := _whole(contract, name, value_of(place).text)) is not None:
        return f"write `{ours}`", Edit(value_of(place), ours)
    if function.definition is not None and (told := function.definition.fact(f"Else {name}")):
        return told, None
    hint = f"give `{name}` a value for which that holds"
    prelude = function.definition is not None and function.definition.span.source.prelude
    return hint if prelude else f"{hint}, or change the contract", None


def _whole(contract: str, name: str, written: str) -> str | None:
    """The nearest whole number, or multiple of one, that a contract takes for the number that was written."""
    least = re.search(rf"\b{name} >= (\d+)", contract)
    factor = re.search(rf"mod\({name}, (\d+)\) == 0", contract)
    if not re.fullmatch(r"-?(\d+\.?\d*|\.\d+)", written) or not (
        contract.endswith("is a whole number") or factor or re.fullmatch(rf"{name} >= \d+", contract)
    ):
        return None
    of = int(factor[1]) if factor else 1
    return str(max(of * round(float(written) / of), int(least[1]) if least else of))


def is_number(text: str) -> bool:
    """Whether a text is a number as it is written, with or without a unit."""
    return re.fullmatch(r"-?(\d+\.?\d*|\.\d+)[A-Za-z]*", text.strip()) is not None


def too_many(function: Function, arguments: Sequence[Given]) -> tuple[str, Edit | None]:
    """What to write where there are more arguments than parameters."""
    told = _one_by_one(function, arguments)
    return told if told[0] else _decimal_comma(arguments, len(arguments) - len(function.parameters))


def _decimal_comma(arguments: Sequence[Given], extra: int) -> tuple[str, Edit | None]:
    """What to write for `5,5mm`, which reads as two arguments; `extra` is how many there are too many."""
    joined, pairs, i = [], [], 0
    while i < len(arguments):
        a, b = arguments[i], arguments[i + 1] if i + 1 < len(arguments) else None
        if b is not None and _one_number(a.span, b.span):
            joined.append(f"{a.span.text}.{b.span.text}")
            pairs.append((a, b))
            i += 1
        else:
            joined.append(a.span.text)
        i += 1
    if not pairs or len(pairs) != extra:
        return "", None
    (a, b), many = pairs[0], len(pairs) > 1
    first, last = arguments[0].span, arguments[-1].span
    if many and (first.source is not last.source or last.end < first.start):  # the first was handed on by `|>`
        return "a comma parts arguments; decimals have a point", None
    ours = ", ".join(joined) if many else f"{a.span.text}.{b.span.text}"
    hint = f"a comma parts arguments; with a decimal point it is `{ours}`"
    if not many and re.fullmatch(r"\d{3}[A-Za-z]*", b.span.text):
        return f"{hint}, without separators `{a.span.text}{b.span.text}`", None
    return hint, Edit(first.to(last) if many else a.span.to(b.span), ours)


def _one_number(a: Span, b: Span) -> bool:
    """Whether two arguments are written as one number with a comma: nothing else is between them."""
    touch = a.source is b.source and Span(a.source, a.end, b.start).text == ","
    return touch and a.text.isdigit() and is_number(b.text)


def axis(value: Value, place: Span) -> str:
    """The vector along an axis that is named, `"z"`, `"-x"` or `z`; "" for any other argument."""
    text = value.value if isinstance(value, Text) else value_of(place).text
    found = re.fullmatch(r"([+-]?)\s*([xyzXYZ])", text.strip())
    if found is None:
        return ""
    one = "-1" if found[1] == "-" else "1"
    return f"[{', '.join(one if a == found[2].lower() else '0' for a in 'xyz')}]"


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
