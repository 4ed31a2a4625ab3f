"""A law: a place in the chain, and z(t), a coordinate that operators act on one after the other."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from types import CodeType, SimpleNamespace
from typing import Any

import numpy as np

from testbench.knit import filters, memories
from testbench.knit.effect import FloatArray, Signals
from testbench.proposing.laws.law_parts import Coordinate, Operator, Slot
from testbench.proposing.laws.places import PLACES, Place
from testbench.proposing.laws.units import PER_SECOND, SECOND, Unit

MOST_PARAMETERS = 4
STRENGTH = "gain"
TOOLS: dict[str, Any] = {
    "np": np,
    **{
        name: getattr(filters, name)
        for name in ("lowpass", "highpass", "rate", "lagging_rate", "shifted", "beside", "in_series")
    },
    **{
        name: getattr(memories, name)
        for name in (
            "kinetics", "moving", "oscillator", "relay", "held", "no_quicker", "stuck", "seconds_near", "heading",
            "since_turn", "turns_so_far", "last_top", "largest", "path", "work", "delayed", "stop", "power_of",
            "over", "bump", "broad_memory", "two_way_lag", "ever_later", "gathered", "turning",
            "relaxing_stop",
        )
    },
}  # fmt: skip
NAMES = {
    "strain": ("e", 'signals["strain"]'),
    "force_N": ("F", 'signals["force_N"]'),
    "contact_force_N": ("P", 'signals["contact_force_N"]'),
    "conductance_S": ("ln_g", 'log_conductance(signals["conductance_S"])'),
    "time_s": ("t", 'signals["time_s"]'),
    "temperature_C": ("T", 'signals["temperature_C"]'),
}
SINCE_START = ("conductance_S", "temperature_C")  # counted from their first value


@dataclass(frozen=True)
class Term:
    """z(t): a coordinate and the operators that act on it, in turn.

    `sizes` are the usual sizes of the input of each operator, written into the code where a power needs one.
    """

    coordinate: Coordinate
    operators: tuple[Operator, ...] = ()
    span: float = 0.3
    sizes: tuple[float, ...] = ()

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """Parameters of the coordinate, then of each operator."""
        return self.coordinate.slots + tuple(slot for one in self.operators for slot in one.slots)

    @property
    def name(self) -> str:
        """Names of the coordinate and of each operator, with commas between."""
        return ", ".join([self.coordinate.name, *(one.name for one in self.operators)])

    @property
    def memory(self) -> str:
        """Name of its operator with a memory; empty where it has none."""
        return next((one.name for one in self.operators if one.kind == "memory"), "")

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals of the chain that it needs."""
        found = [*self.coordinate.reads, *(name for one in self.operators for name in one.reads)]
        return tuple(dict.fromkeys(found))

    def without(self, at: int) -> Term:
        """The term without its operator number `at`."""
        sizes = self.sizes[:at] + self.sizes[at + 1 :]
        return replace(self, operators=self.operators[:at] + self.operators[at + 1 :], sizes=sizes)

    def extends(self, other: Term) -> bool:
        """Whether it is another term with operators put in."""
        own = iter(self.operators)
        return self.coordinate == other.coordinate and all(one in own for one in other.operators)

    def units(self) -> Iterator[tuple[Unit, Operator | None]]:
        """The unit of the input of each operator, and last, with None, the unit of z."""
        unit = self.coordinate.unit
        for one in self.operators:
            yield unit, one
            unit = one.unit if one.unit is not None else unit * one.times
            unit = unit * unit if one.squares else unit
        yield unit, None

    @property
    def unit(self) -> Unit:
        """The unit of z."""
        return [unit for unit, _ in self.units()][-1]

    def unit_of(self, slot: Slot) -> Unit:
        """The unit of a parameter."""
        if slot.kind in ("time", "delay"):
            return SECOND
        if slot.kind == "frequency":
            return PER_SECOND
        if slot.kind in ("level", "size", "rate"):
            unit = next((unit for unit, one in self.units() if one and slot in one.slots), Unit())
            return unit / SECOND if slot.kind == "rate" else unit
        return Unit()

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The Python code of z: one line for the coordinate, one for each operator."""
        pieces = [self.coordinate.code, *(one.code for one in self.operators)]
        sizes = (1.0, *self.sizes, *(1.0 for _ in pieces))
        return tuple(_written(piece, self.span, size) for piece, size in zip(pieces, sizes, strict=False))

    @property
    def latex(self) -> str:
        """z as a formula."""
        return self._woven()[0]

    @property
    def definitions(self) -> tuple[str, ...]:
        """What the symbols of the formula stand for, where they have an equation of their own."""
        return self._woven()[1]

    def _woven(self) -> tuple[str, tuple[str, ...]]:
        text, found = self.coordinate.latex, list(self.coordinate.definitions)
        for place, one in enumerate(self.operators):
            found += [line.replace("{x}", text) for line in one.definitions]
            size = self.sizes[place] if place < len(self.sizes) else 1.0
            text = one.latex.replace("{x}", text).replace("x_0", f"{size:g}")
        return text, tuple(
            dict.fromkeys(re.sub(r"(?<![\w\\])s(?=\\,|\^2\\,|\})", f"{self.span:g}", line) for line in found)
        )

    @property
    def words(self) -> str:
        """z in words."""
        text = self.coordinate.words
        for one in self.operators:
            text = one.words.replace("{x}", text)
        return text

    def evaluated(self, signals: Signals, values: Mapping[str, float], dt_s: float) -> FloatArray:
        """z on the grid, shape (n,)."""
        return self.within(namespace(signals, dt_s), values)

    def within(self, names: Mapping[str, Any], values: Mapping[str, float]) -> FloatArray:
        """The same, from names that were made once for many terms."""
        space = {**names, "self": SimpleNamespace(**values)}
        made: dict[str, FloatArray] = names["made"]  # coordinates without parameters: the same for many laws
        first = self.lines[0]
        x: Any = made.get(first)
        for line in self.lines if x is None else self.lines[1:]:
            space["x"] = x
            x = eval(compiled(line), space)
            if line is first and not self.coordinate.slots:
                made[first] = x
        return x


def namespace(signals: Signals, dt_s: float) -> dict[str, Any]:
    """The names that the code of a law may use: operators, and the signals of the chain under their short names."""
    space: dict[str, Any] = {**TOOLS, "dt_s": dt_s, "made": {}}
    for signal, (name, _) in NAMES.items():
        if signal in signals:
            values = signals[signal]
            values = filters.log_conductance(values) if signal == "conductance_S" else values
            space[name] = values - values[0] if signal in SINCE_START else values
    return space


@lru_cache(maxsize=1000)
def _written(code: str, span: float, size: float) -> str:
    """The code of a piece with its numbers in it."""
    return code.replace("{span}", f"{span:g}").replace("{size}", f"{size:g}")


@lru_cache(maxsize=1000)
def compiled(line: str) -> CodeType:
    """One line of our own library as code."""
    return compile(line, "<law>", "eval")


@dataclass(frozen=True)
class Law:
    """A law: a term, the place in the chain where it acts, and the values of its parameters.

    Attributes
    ----------
    values : mapping of str to float
        Parameters by key, without the strength.
    strength : float
        In the unit of the place over that of the term.
    """

    place: Place
    term: Term
    values: Mapping[str, float] = field(default_factory=dict)
    strength: float = 1.0

    @property
    def key(self) -> str:
        """Its place and its pieces, without numbers: laws with the same key differ in their parameters alone."""
        return f"{self.place.name}: {self.term.name}"

    @property
    def family(self) -> tuple[str, ...]:
        """Laws that differ in what comes after their memory, or in bends and factors alone, are of one family.

        What lies beyond a threshold is remembered otherwise than the whole: a threshold before a memory counts.
        """
        pieces, memory = self.term.operators, self.term.memory
        before = pieces[: [one.kind for one in pieces].index("memory")] if memory else ()
        edges = [one.name for one in before if one.name in ("threshold", "below")]
        return self.place.name, self.term.coordinate.name, *edges, *([memory] if memory else [])

    @cached_property
    def unit(self) -> Unit:
        """The unit of the strength."""
        return self.place.unit / self.term.unit

    def ways(self) -> list[Law]:
        """The law, and what nearly is the same to first order.

        That is a force changed by a share, where the law ends in that, and a path beside a conductance, or a
        resistance in series with it.
        """
        last = len(self.term.operators) - 1
        if self.place.name == "conductance":
            in_series = replace(self, place=PLACES["resistance in series"], strength=-self.strength)
            return [self, replace(self, place=PLACES["path beside"]), in_series]
        if self.place.name != "force" or last < 0 or self.term.operators[last].name != "times force":
            return [self]
        return [self, replace(self, place=PLACES["force by a share"], term=self.term.without(last))]

    def without(self, at: int) -> Law:
        """The law without its operator number `at`; its strength keeps its value, though the unit may change."""
        term = self.term.without(at)
        values = {slot.key: self.values[slot.key] for slot in term.slots}
        return Law(self.place, term, values, self.strength)
