"""Effects by mechanism and form. A form declares its parameters' ranges and what it does at one stage, or several."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from worlds_second.chain import Hook
from worlds_second.draws import Range
from worlds_second.kernels import Array

Change = Callable[..., Array]

FORCE_ALONE = frozenset({"force_readout", "force_adc"})
RESISTANCE_ALONE = frozenset({"pressure", "contact", "electrical", "resistance_readout", "resistance_adc"})


@dataclass
class Form:
    """One law of a mechanism: ``change(signals, magnitude, **parameters)`` at each of its stages."""

    mechanism: str
    name: str
    largest: float
    ranges: Mapping[str, Range]
    changes: dict[str, Change] = field(default_factory=dict)

    def hooks(self, magnitude: float, parameters: Mapping[str, float]) -> list[Hook]:
        """What it does in a chain, at this magnitude."""
        return [Hook(stage, partial(_call, change, magnitude, parameters)) for stage, change in self.changes.items()]

    def channels(self, feels_force: bool) -> set[str]:
        """The channels that it can change, in a sensor whose conductance feels the force or the strain alone."""
        stages = set(self.changes)
        out = set() if stages <= RESISTANCE_ALONE else {"force"}
        deaf = FORCE_ALONE if feels_force else FORCE_ALONE | {"mechanics"}
        return out if stages <= deaf else out | {"conductance"}


def _call(change: Change, magnitude: float, parameters: Mapping[str, float], signals: Any) -> Array:
    return change(signals, magnitude, **parameters)


KNOWN: dict[str, dict[str, Form]] = {}
FOREIGN: dict[str, dict[str, Form]] = {}


def form(
    mechanism: str, at: str, largest: float, *, foreign: bool = False, **ranges: Range
) -> Callable[[Change], Change]:
    """Enter the decorated function as a form of a mechanism; `largest` bounds its magnitude."""

    def enter(change: Change) -> Change:
        name = change.__name__
        known = (FOREIGN if foreign else KNOWN).setdefault(mechanism, {})
        known[name] = Form(mechanism, name, largest, ranges, {at: change})
        return change

    return enter


def also(mechanism: str, name: str, at: str) -> Callable[[Change], Change]:
    """What a form that is entered already does at one more stage, with the same parameters."""

    def enter(change: Change) -> Change:
        {**KNOWN, **FOREIGN}[mechanism][name].changes[at] = change
        return change

    return enter
