"""Sorts what has a log evidence, the best first, and keeps the best of each kind."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Protocol, TypeVar

One = TypeVar("One")


class Weighed(Protocol):
    """What has a log evidence."""

    @property
    def log_z(self) -> float: ...


AnyWeighed = TypeVar("AnyWeighed", bound=Weighed)


def evidence_of(found: Weighed) -> float:
    """Log evidence, to sort by."""
    return found.log_z


def first_of_each(ordered: Iterable[One], kind: Callable[[One], Hashable]) -> list[One]:
    """The first of each kind, in order."""
    first: dict[Hashable, One] = {}
    for one in ordered:
        first.setdefault(kind(one), one)
    return list(first.values())


def best_first(found: Iterable[AnyWeighed]) -> list[AnyWeighed]:
    """Sorted by their evidence."""
    return sorted(found, key=evidence_of, reverse=True)
