"""The families of base laws, each a list of members that are drawn with equal chance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from worlds_second.draws import Range


@dataclass(frozen=True)
class Member:
    """One law of a family: what computes it and where its parameters lie."""

    function: Callable[..., Any]
    ranges: dict[str, Range]


FAMILIES: dict[str, dict[str, Member]] = {}


def law(family: str, **ranges: Range) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Enter the decorated function in a family; its name is the function's name."""

    def enter(function: Callable[..., Any]) -> Callable[..., Any]:
        FAMILIES.setdefault(family, {})[function.__name__.rstrip("_")] = Member(function, ranges)
        return function

    return enter
