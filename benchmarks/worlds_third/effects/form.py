"""A form of an effect: what it does to the signals at its stage, for a size that is 0 where it is not there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from worlds_third.randoms import Ranges

Act = Callable[..., None]  # (signals, size, rng of this recording, **values)


@dataclass(frozen=True)
class Form:
    """`main`: the channel its strength is measured in; `limit`: the largest size that makes sense."""

    mechanism: str
    name: str
    stage: str
    main: str
    act: Act
    ranges: Ranges
    limit: float


def form_of(
    forms: list[Form], mechanism: str, stage: str, main: str, limit: float, **ranges: tuple[float, float]
) -> Callable[[Act], Act]:
    """Decorator: add a function to `forms`, under its own name."""

    def add(act: Any) -> Act:
        forms.append(Form(mechanism, act.__name__, stage, main, act, ranges, limit))
        return act

    return add
