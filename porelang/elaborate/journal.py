"""What an elaboration notes is written down in order, so that it can be noted again without evaluating anything.

All that a `Context` knows and has found lies in the collections made here, or changes by `Journal.note`. A stretch of
the journal is what a statement, or the body of a function, has done: `again` does it in another elaboration, where the
same would be evaluated of the same values. What is there already stays as it is, as it would then.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Any, NoReturn, Protocol, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

#: What was done: a function, and what it takes beside the holder of the collections.
Entry = tuple[Any, ...]
#: What a statement or the body of a function has done. It may hold others, each of which is done once.
Stretch = tuple[Entry, ...]


class Holder(Protocol):
    """What holds collections by name: a `Context`."""

    collections: dict[str, Any]
    journal: Journal


class Journal:
    """The entries of one elaboration, and the stretches that were done in it."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self._done: dict[int, Stretch] = {}  # kept, so that none of the ids is another's

    def note(self, holder: Holder, how: Callable[..., None], *what: object) -> None:
        """Do something that has to be done again, and write it down."""
        self.entries.append((how, *what))
        how(holder, *what)

    def mark(self) -> int:
        """Where a stretch begins that may be taken later."""
        return len(self.entries)

    def since(self, mark: int) -> Stretch:
        """All that was done since then as one stretch, which is one entry from now on."""
        stretch = tuple(self.entries[mark:])
        del self.entries[mark:]
        self.done(stretch)
        return stretch

    def done(self, stretch: Stretch) -> None:
        """Write down that a stretch was done here."""
        if stretch:
            self._done[id(stretch)] = stretch
            self.entries.append((again, stretch))

    def is_new(self, stretch: Stretch) -> bool:
        """Whether a stretch was not done yet; from now on it was."""
        new = id(stretch) not in self._done
        self._done[id(stretch)] = stretch
        return new


def again(holder: Holder, stretch: Stretch) -> None:
    """Do what a stretch did, unless it was done here; nothing is written down."""
    todo = [iter(stretch)] if holder.journal.is_new(stretch) else []
    while todo:
        for how, *what in todo[-1]:
            if how is again:
                if holder.journal.is_new(what[0]):
                    todo.append(iter(what[0]))
                    break
            else:
                how(holder, *what)
        else:
            todo.pop()


def _no_such_change(*_: object, **__: object) -> NoReturn:
    raise TypeError("this is not written down: see porelang.elaborate.journal")


class NotedDict(dict[K, V]):
    """A dict whose changes are written down; what was set can be set otherwise, and stays."""

    def __init__(self, name: str, journal: Journal) -> None:
        super().__init__()
        self._name, self._entries = name, journal.entries

    def __setitem__(self, key: K, value: V) -> None:
        self._entries.append((_set, self._name, key, value))
        dict.__setitem__(self, key, value)

    def setdefault(self, key: K, default: V = None) -> V:  # type: ignore[assignment]  # as dict has it
        self._entries.append((_set_default, self._name, key, default))
        return dict.setdefault(self, key, default)

    __delitem__ = pop = popitem = clear = update = _no_such_change
    __ior__ = _no_such_change


class NotedList(list[V]):
    """A list that grows at its end, which is written down."""

    def __init__(self, name: str, journal: Journal) -> None:
        super().__init__()
        self._name, self._entries = name, journal.entries

    def append(self, item: V) -> None:
        self._entries.append((_append, self._name, item))
        list.append(self, item)

    def extend(self, items: Iterable[V]) -> None:
        for item in items:
            self.append(item)

    def __iadd__(self, items: Iterable[V]) -> NotedList[V]:  # type: ignore[misc,override]  # as list has it
        self.extend(items)
        return self

    __setitem__ = __delitem__ = insert = pop = remove = clear = sort = reverse = _no_such_change


class NotedSet(set[K]):
    """A set that grows, which is written down."""

    def __init__(self, name: str, journal: Journal) -> None:
        super().__init__()
        self._name, self._entries = name, journal.entries

    def add(self, item: K) -> None:
        self._entries.append((_add, self._name, item))
        set.add(self, item)

    def update(self, *several: Iterable[K]) -> None:
        for items in several:
            for item in items:
                self.add(item)

    discard = remove = pop = clear = difference_update = intersection_update = _no_such_change


def _set(holder: Holder, name: str, key: Hashable, value: object) -> None:
    dict.__setitem__(holder.collections[name], key, value)


def _set_default(holder: Holder, name: str, key: Hashable, value: object) -> None:
    dict.setdefault(holder.collections[name], key, value)


def _append(holder: Holder, name: str, item: object) -> None:
    list.append(holder.collections[name], item)


def _add(holder: Holder, name: str, item: Hashable) -> None:
    set.add(holder.collections[name], item)
