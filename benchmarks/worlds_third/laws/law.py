"""A law: a function of whole arrays and the ranges its numbers are drawn from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from worlds_third.randoms import Ranges, Values


@dataclass(frozen=True)
class Law:
    """A member of a family; `ranges` are the bounds of what is drawn."""

    function: Callable[..., Any]
    ranges: Ranges = field(default_factory=dict)


@dataclass(frozen=True)
class Chosen:
    """A law with its numbers."""

    name: str
    law: Law
    values: Values

    def __call__(self, *signals: Any) -> Any:
        return self.law.function(*signals, **self.values)

    def told(self) -> dict[str, float | str]:
        """For the truth of a case."""
        return {"law": self.name, **self.values}
