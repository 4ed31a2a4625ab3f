"""Which effects a case hides: what was asked for, or what the seed draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from simulated_case import NONE, UNKNOWN, names_of, stream

from gcode.support.errors import UserError
from worlds_second.chain import Hook
from worlds_second.draws import draw_all
from worlds_second.effects import FOREIGN, KNOWN, MECHANISMS, UNKNOWN_KINDS, Form

CHANCE_NONE, CHANCE_UNKNOWN = 0.15, 0.15
STAGE_NAMES = dict.fromkeys(("force_readout", "resistance_readout", "force_adc", "resistance_adc"), "readout")


@dataclass(frozen=True)
class Hidden:
    """A form of an effect with its drawn parameters."""

    form: Form
    parameters: Mapping[str, float]

    @property
    def in_catalogue(self) -> bool:
        """Whether it is a form of a known mechanism."""
        return self.form.mechanism in KNOWN

    def hooks(self, magnitude: float) -> list[Hook]:
        """What it does in the chain."""
        return self.form.hooks(magnitude, self.parameters)

    def described(self) -> dict[str, Any]:
        """What is hidden, ready for JSON."""
        return {
            "effect": self.form.mechanism,
            "form": self.form.name,
            "in_catalogue": self.in_catalogue,
            "stages": list(dict.fromkeys(STAGE_NAMES.get(stage, stage) for stage in self.form.changes)),
            "parameters": dict(self.parameters),
        }


def choose(effect: str | None, seed: int, recorded: set[str], feels_force: bool = True) -> list[Hidden]:
    """The effects of a case, none for ``"none"``.

    Parameters
    ----------
    effect : str, optional
        A mechanism, a kind of no catalogue, either with ``:form``; ``"none"``, ``"unknown"``, or two of them
        joined by a comma. Without it the seed draws.
    seed : int
    recorded : set of str
        ``"force"`` and ``"conductance"`` as far as recorded: an effect must reach one of them.
    feels_force : bool
        Whether the sensor's conductance depends on the force, or on the strain alone.
    """
    names = names_of(_drawn(seed, recorded, feels_force) if effect is None else effect, {**KNOWN, **FOREIGN})
    return [_choose_one(name, seed, recorded, feels_force) for name in names]


def _drawn(seed: int, recorded: set[str], feels_force: bool) -> str:
    rng = stream(seed, "effect")
    u = rng.random()
    if u < CHANCE_NONE:
        return NONE
    if u < CHANCE_NONE + CHANCE_UNKNOWN:
        return UNKNOWN
    return str(rng.choice([name for name in MECHANISMS if _fitting(name, recorded, feels_force)]))


def _fitting(kind: str, recorded: set[str], feels_force: bool) -> list[str]:
    return [name for name, form in {**KNOWN, **FOREIGN}[kind].items() if form.channels(feels_force) & recorded]


def _choose_one(word: str, seed: int, recorded: set[str], feels_force: bool) -> Hidden:
    kind, _, name = word.partition(":")
    if kind == UNKNOWN:
        kinds = [one for one in UNKNOWN_KINDS if _fitting(one, recorded, feels_force)]
        kind = str(stream(seed, "unknown kind").choice(kinds))
    fitting = _fitting(kind, recorded, feels_force)
    if not fitting or (name and name not in fitting):
        what = " and ".join(sorted(recorded))
        raise UserError(f"make_case: {word} changes nothing in the {what} of sensor {seed}; record the other channel")
    form = {**KNOWN, **FOREIGN}[kind][name or str(stream(seed, "form", kind).choice(fitting))]
    return Hidden(form, draw_all(form.ranges, stream(seed, "parameters", form.mechanism, form.name)))
