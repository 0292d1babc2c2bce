"""What the statements of a program came to when it was elaborated before.

A statement is evaluated again where its text is another, or where what it reads came to something else: else its value
is what it was, and what was noted is noted again from the journal. So an edit costs what depends on it. Elaborating
afresh is the same with nothing remembered.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass

from porelang.elaborate.context import Context
from porelang.elaborate.journal import Stretch, again
from porelang.elaborate.names import Free, free_names
from porelang.elaborate.results import Requirement
from porelang.elaborate.values import POISON, Scope, Value
from porelang.syntax import tree

#: What a step was made of: other steps (by identity), names, settings.
On = tuple[Hashable, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One evaluation: what it was made of, its value, what it asks of params, what was noted, and its share of the
    budget."""

    on: On
    value: Value
    required: dict[Requirement, None]
    noted: Stretch
    spent: int


class Steps:
    """The steps of the last elaboration of a program. It belongs to one program, whose texts may change, and to one
    thread at a time; where relative paths begin and which params have data are always the same.
    """

    def __init__(self) -> None:
        self.numbers: dict[Requirement, int] = {}
        self._before: dict[Hashable, Step] = {}
        self._now: dict[Hashable, Step] = {}
        self._lost: dict[str, Value] = {}
        self._around = Scope(self._lost)
        self._scopes: dict[tuple[str, str], tuple[dict[str, Value], Scope]] = {}
        self._names: dict[tree.Statement, tuple[Free, ...]] = {}

    def around(self, lost: frozenset[str], base: Scope) -> Scope:
        """The names around all files, and those of statements that could not be read."""
        self._lost.clear()
        self._lost.update(dict.fromkeys(lost, POISON))
        if self._around.outer is not base:
            self._around = Scope(self._lost, base)
        return self._around

    def scope(self, file: str, prefix: str, outer: Scope) -> tuple[dict[str, Value], Scope]:
        """The names of a file, none of them bound yet, and the scope that they are looked up in.

        It is the same one each time, so that functions that are not made anew see what their file binds now.
        """
        found = self._scopes.get((file, prefix))
        if found is None or found[1].outer is not outer:
            members: dict[str, Value] = {}
            found = self._scopes[file, prefix] = members, Scope(members, outer)
        found[0].clear()
        return found

    def free_names(self, statement: tree.Statement) -> tuple[Free, ...]:
        """The names that a statement uses and does not bind itself."""
        found = self._names.get(statement)
        if found is None:
            found = self._names[statement] = free_names(statement)
        return found

    def step(self, ctx: Context, key: Hashable, on: On, evaluate: Callable[[], Value]) -> Step:
        """What `evaluate` comes to, which is decided by the key and by what it is made of."""
        found = self._before.get(key)
        if found is not None and found.on == on and ctx.spend_again(found.spent):
            again(ctx, found.noted)
        else:
            mark, spent = ctx.journal.mark(), ctx.spent
            with ctx.requiring() as own:
                value = evaluate()
            found = Step(on, value, own, ctx.journal.since(mark), ctx.spent - spent)
        ctx.required.update(found.required)
        self._now[key] = found
        return found

    def end(self, whole: bool = True) -> None:
        """The program has been elaborated: what was not met is forgotten, unless it was not elaborated to its end."""
        self._before, self._now = self._now if whole else {**self._before, **self._now}, {}
        met = {key[0] for key in self._before if isinstance(key, tuple)}
        self._names = {s: names for s, names in self._names.items() if s in met}
