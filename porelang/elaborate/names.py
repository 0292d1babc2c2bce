"""Names: what each statement refers to, found before anything is evaluated.

One walk reports unknown names and second bindings, and yields the order in which the definitions of a file can be
evaluated (they may stand in any order) or the cycle in which they refer to each other.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace

from porelang.diagnostics import Diagnostic, Edit, Label, suggest
from porelang.materials import MATERIALS
from porelang.ops.tasks import TASK_TABLE
from porelang.source import Span
from porelang.syntax import habits, tree
from porelang.syntax.measures import of_a_number, unit_alone, unknown_unit
from porelang.units import UNITS, WITHOUT

COORDINATES = ("x", "y", "z", "p")
Binding = tree.Param | tree.Let | tree.Def | tree.Use | tree.Out


#: Names of the language's design that no version has yet.
_FOAMS = ("perlin", "simplex", "cubic_noise", "worley", "particles", "voronoi_cells", "voronoi_edges", "truss")
PLANNED = frozenset({*_FOAMS, "metric"})


def bindings(
    statements: Iterable[tree.Statement], known: Collection[str] = ()
) -> tuple[dict[str, Binding], list[Diagnostic]]:
    """The definitions of a file by name, and a diagnostic for each name bound twice or not to be bound.

    An output can be referred to by its name too, unless the file binds that name or it is `known` outside:
    `out cylinder = cylinder(75, 300)` is the function's.
    """
    names: dict[str, Binding] = {}
    outs: dict[str, tree.Out] = {}
    found: list[Diagnostic] = []
    for s in statements:
        if isinstance(s, tree.Out):
            if s.name in outs:
                found.append(_duplicate(s.name, s.name_span, outs[s.name].name_span, "output"))
            outs.setdefault(s.name, s)
        if not isinstance(s, tree.Param | tree.Let | tree.Def | tree.Use):
            continue
        if s.name in COORDINATES:
            found.append(
                Diagnostic(
                    "E032",
                    f"`{s.name}` is a coordinate and cannot be bound here",
                    s.name_span,
                    label="x, y, z and p are the point",
                    hint="choose another name; a parameter may be called so",
                )
            )
        elif s.name in names:
            found.append(_duplicate(s.name, s.name_span, names[s.name].name_span, "name"))
        else:
            names[s.name] = s
    for name, out in outs.items():
        if name not in names and name not in known and name not in COORDINATES:
            names[name] = out
    return names, found


def _duplicate(name: str, second: Span, first: Span, what: str) -> Diagnostic:
    return Diagnostic(
        "E031",
        f"the {what} `{name}` is bound twice",
        second,
        label="bound again here",
        others=(Label(first, "first bound here"),),
        hint="give one of them another name",
    )


def children(item: object) -> Iterator[object]:
    """The parts of a tree node that are tree nodes."""
    if isinstance(item, tuple):
        yield from item
    elif is_dataclass(item) and not isinstance(item, Span):
        for field in fields(item):
            value = getattr(item, field.name)
            if isinstance(value, tuple) or (is_dataclass(value) and not isinstance(value, Span)):
                yield value


@dataclass(frozen=True, slots=True, eq=False)
class Free:
    """A name that a statement uses and does not bind itself. `text` is the place of the text that is meant there, if
    one is; `around` the call or member that it begins; `local` the names that are bound around it; `unit` whether the
    names of units mean these there."""

    name: str
    span: Span
    text: Span | None
    around: tree.Call | tree.Member | None
    local: frozenset[str]
    unit: bool


def free_names(statement: tree.Statement | tree.Expr) -> tuple[Free, ...]:
    """The names that a statement, or an expression, uses and does not bind itself, in the order of its text."""
    found: list[Free] = []
    stack: list[tuple[object, frozenset[str]]] = [(statement, frozenset())]
    texts: dict[Span, Span] = {}
    in_units: set[Span] = set()  # expressions in which the names of units are units
    around: dict[Span, tree.Call | tree.Member] = {}  # a name, and the call or member that it begins
    while stack:
        item, local = stack.pop()
        unit = getattr(item, "span", None) in in_units
        if unit:
            local |= UNITS.keys()
        if isinstance(item, tree.Call):
            texts |= _texts(item)
            around[item.function.span] = item
            in_units |= {a.value.span for a in item.arguments if units_named(item, a)}
        if isinstance(item, tree.Member):
            around[item.target.span] = item
        if isinstance(item, tree.Name):
            if item.name not in local:
                text, beside = texts.get(item.span), around.get(item.span)
                found.append(Free(item.name, item.span, text, beside, local, unit))
            continue
        stack.extend(reversed(list(_parts(item, local))))
    return tuple(found)


def resolve(
    statements: Sequence[tree.Statement],
    names: Collection[str],
    free: Callable[[tree.Statement], tuple[Free, ...]] = free_names,
) -> tuple[dict[int, set[str]], list[Diagnostic]]:
    """For each statement (by index) the names it uses that it does not bind itself, and a diagnostic for each that is
    not among those that can be seen."""
    uses: dict[int, set[str]] = {}
    missing: dict[str, tuple[Diagnostic, list[Span]]] = {}
    visible = {*names, *COORDINATES}
    for i, s in enumerate(statements):
        uses[i] = set()
        for use in free(s):
            name, seen = use.name, use.name in visible
            if use.unit and not seen:
                missing.setdefault(name, (_no_unit(use.span), []))
                continue
            uses[i].add(name)
            if name in missing:
                missing[name][1].append(use.span)
            elif not seen and use.text is not None:
                missing[name] = (_text(use.text), [])
            elif not seen:
                found = unknown_name(name, use.span, visible | use.local, isinstance(use.around, tree.Call))
                missing[name] = (_recast(found, name, use.around), [])
    return uses, [_with_places(d, places) for d, places in missing.values()]


#: What takes the names of files and of arrays, which are texts.
LOADING = ("load", "load_vector", "load_tensor")
_READING = (*LOADING, "frame", "nearest_bar")


def units_named(call: tree.Call, argument: tree.Argument) -> bool:
    """Whether this is the `unit=` of what is loaded, where the names of units mean these: `unit=MPa`."""
    loads = isinstance(call.function, tree.Name) and call.function.name in LOADING
    misspelt = argument.name is not None and argument.name not in TASK_TABLE["load"].parameters
    return loads and (argument.name in ("unit", "lengths") or misspelt)  # of what is misspelt that alone is said


def _no_unit(span: Span) -> Diagnostic:
    """What stands as the unit of what is loaded, and is none of ours."""
    if span.text in WITHOUT:
        hint = f"there is no unit of {WITHOUT[span.text]}: leave `unit` out, and the values are numbers"
        return Diagnostic("E002", f"`{span.text}` is not a unit", span, hint=hint)
    return unknown_unit(span, "1", span)


def _texts(call: tree.Call) -> dict[Span, Span]:
    """The names in a call where a text is meant, each with the place of that text: `load(a.npz, vm)`."""
    files = isinstance(call.function, tree.Name) and call.function.name in _READING
    found: dict[Span, Span] = {}
    for a in call.arguments:
        if not (files and a.name is None) and a.name != "side":
            continue
        inner = a.value
        while isinstance(inner, tree.Member):
            inner = inner.target
        if isinstance(inner, tree.Name):
            found[inner.span] = a.value.span
    return found


def _recast(d: Diagnostic, name: str, call: tree.Call | tree.Member | None) -> Diagnostic:
    """`vec3(1, 2, 3)`, `float(a)` and `np.sin`, which Pore writes without the name: the edit takes it away."""
    if isinstance(call, tree.Member):
        prefix = Span(call.span.source, call.span.start, call.name_span.start)
        return replace(d, edit=Edit(prefix, "")) if habits.NAMES.get(name) == habits.NO_PREFIX else d
    if call is None or not call.arguments or any(a.name for a in call.arguments):
        return d
    if d.code != "E037" and len(call.arguments) == 1 and (ours := of_a_number(name, call.arguments[0].span)):
        return replace(
            d, message=f"`{name}` is a unit, and no function", hint=f"write `{ours}`", edit=Edit(call.span, ours)
        )
    values = call.arguments[0].span.to(call.arguments[-1].span).text
    if name == "vec3" and len(call.arguments) == 3:
        return replace(d, edit=Edit(call.span, f"[{values}]"))
    if name == "float" and len(call.arguments) == 1:
        return replace(d, edit=Edit(call.span, f"({values})"))
    return d


def _text(span: Span) -> Diagnostic:
    """A name where a text is meant."""
    return Diagnostic(
        "E030",
        f"`{span.text}` is a text, and texts stand in quotes",
        span,
        label="nothing is called this",
        hint=f'write `"{span.text}"`',
        edit=Edit(span, f'"{span.text}"'),
    )


def _with_places(d: Diagnostic, places: list[Span]) -> Diagnostic:
    """A name that is unknown in several places is one mistake."""
    if not places:
        return d
    more = f", and in {len(places) - 1} more places" if len(places) > 1 else ""
    return replace(d, others=(Label(places[0], f"used here too{more}"),))


def _parts(item: object, local: frozenset[str]) -> Iterator[tuple[object, frozenset[str]]]:
    """The parts of a node, each with the names that are bound around it."""
    match item:
        case tree.Lambda():
            yield item.body, local | {p.name for p in item.parameters}
        case tree.Def():
            inner = local | {p.name for p in item.parameters}
            seen = local
            for p in item.parameters:  # a default may use the parameters before it
                if p.default is not None:
                    yield p.default, seen
                seen = seen | {p.name}
                if p.where is not None:
                    yield p.where, inner
            yield item.body, inner
        case tree.Block():
            inner = local
            for b in item.bindings:
                yield b, inner
                inner = inner | {b.name}
            yield item.value, inner
        case tree.Comprehension():
            inner = local
            for clause in item.clauses:
                yield clause.items, inner
                inner = inner | {clause.name.name}
                for condition in clause.filters:
                    yield condition, inner
            yield item.value, inner
        case tree.Member():
            yield item.target, local
        case _:
            for child in children(item):
                yield child, local


def unknown_name(name: str, span: Span, visible: Iterable[str], called: bool = False) -> Diagnostic:
    """The diagnostic for a name that means nothing, which is called or not."""
    if theirs := habits.hint(name, called):
        ours = habits.ours(name, called)
        return Diagnostic(
            "E037",
            f"`{name}` is not a word of Pore",
            span,
            label="a word of another program",
            hint=theirs,
            edit=Edit(span, ours) if ours else None,
        )
    if (alone := unit_alone(name, span)) is not None:
        return alone
    if name in PLANNED:
        return Diagnostic(
            "E030",
            f"`{name}` is not in this version of the language",
            span,
            label="planned, and not there yet",
            hint=habits.hint(name) or "docs/language.md lists what there is",
        )
    if name == "density" and called:
        said = "no function, but a loop"
        hint = "the density that is stiffest for its mass: `pore optimize FILE --iterate part --rule optimum`"
        return Diagnostic("E030", f"unknown name `{name}`", span, label=said, hint=hint)
    if name in MATERIALS:
        said = "a material is named by a text"
        return Diagnostic("E030", f"unknown name `{name}`", span, label=said, hint=f'in quotes: `material="{name}"`')
    near = suggest(name, (v for v in visible if not v.startswith("_")))
    if name.lower() in ("nan", "inf", "infinity"):
        return Diagnostic(
            "E030",
            f"there is no `{name}` in the language",
            span,
            label="not a number one can write",
            hint="a field that is undefined somewhere is a mistake; leave that part out",
        )
    if near is None:
        return Diagnostic(
            "E030",
            f"unknown name `{name}`",
            span,
            label="nothing is called this",
            hint=f"bind it first: `let {name} = ...` or `param {name} = ... in lo..hi`"
            + (f"; as a unit it has a number, `1{name}`" if name in UNITS else ""),
        )
    return Diagnostic(
        "E030",
        f"unknown name `{name}`",
        span,
        label="nothing is called this",
        hint=f"did you mean `{near}`?",
        edit=Edit(span, near),
    )


def evaluation_order(names: Mapping[str, Binding], uses: Mapping[str, set[str]]) -> tuple[list[str], list[Diagnostic]]:
    """The names in an order in which each comes after those it uses, and a diagnostic for every cycle."""
    done: set[str] = set()
    in_cycle: set[str] = set()
    out: list[str] = []
    found: list[Diagnostic] = []
    for start in names:
        if start in done:
            continue
        path: list[str] = [start]
        stack = [iter(sorted(uses[start] & names.keys()))]
        while stack:
            for other in stack[-1]:
                if other in path:
                    loop = path[path.index(other) :]
                    if not in_cycle & set(loop):
                        found.append(_cycle([names[n] for n in loop]))
                    in_cycle |= set(loop)
                elif other not in done:
                    path.append(other)
                    stack.append(iter(sorted(uses[other] & names.keys())))
                    break
            else:
                stack.pop()
                name = path.pop()
                done.add(name)
                out.append(name)
    return out, found


def _cycle(loop: list[Binding]) -> Diagnostic:
    first = loop[0]
    shown = [*loop[:4], *loop[-1:]] if len(loop) > 6 else loop
    parts = [f"`{b.name}`" for b in shown]
    if len(loop) > 6:
        parts.insert(4, "...")
    way = " -> ".join([*parts, f"`{first.name}`"])
    what = "calls itself" if len(loop) == 1 and isinstance(first, tree.Def) else "is defined by itself"
    return Diagnostic(
        "E033",
        f"`{first.name}` {what}: {way}",
        _named(first),
        label="the ring starts here",
        others=tuple(Label(_named(b), "and goes through this") for b in loop[1:4]),
        hint="there is no recursion; for a repetition use `[for i in range(n): ...]` or `repeat`",
    )


def _named(b: Binding) -> Span:
    """Where a name is bound; the bare last expression, which binds `part`, has no name to point at."""
    return b.name_span if b.name_span.end > b.name_span.start else b.span
