"""Which effects a caller asks for, and a law of each with its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulated_case import UNKNOWN, names_of

from worlds_fourth.effects import (
    actuator,
    clamps,
    coating,
    contacts,
    instruments,
    jamming,
    lags,
    lengthening,
    shoulder,
    slack,
    softening,
    transients,
    unknown_fabric,
    unknown_wiring,
    viscosity,
    warmth,
    yarn,
)
from worlds_fourth.effects.effect import OF_RESISTANCE, Effect, Form
from worlds_fourth.randoms import stream
from worlds_fourth.specimen import Specimen

OF_THE_SPECIMEN = (lengthening, clamps, actuator, slack, viscosity, softening, jamming, warmth)
OF_THE_RESISTANCE = (contacts, transients, shoulder, yarn, coating)
KNOWN: list[Form] = [
    form for file in (*OF_THE_SPECIMEN, *OF_THE_RESISTANCE, lags, instruments) for form in file.FORMS
]
OUTSIDE: list[Form] = [*unknown_fabric.FORMS, *unknown_wiring.FORMS]
MECHANISMS = list(dict.fromkeys(form.mechanism for form in KNOWN))
UNKNOWN_KINDS = sorted({form.mechanism for form in OUTSIDE})


@dataclass(frozen=True)
class Hidden:
    """A law of an effect with its numbers."""

    form: Form
    effect: Effect

    @property
    def in_catalogue(self) -> bool:
        """Whether the catalogue has a mechanism of this name."""
        return self.form.mechanism in MECHANISMS

    @property
    def shown_in(self) -> set[str]:
        """Channels that may show it; the contacts feel the force, but not the other way round."""
        stages = set(self.effect.hooks)
        channels = {"force"} if stages - set(OF_RESISTANCE) else set()
        return channels | ({"conductance"} if stages - {"force_reading"} else set())

    def told(self) -> dict[str, Any]:
        """For the truth of a case."""
        return {
            "effect": self.form.mechanism,
            "form": self.form.name,
            "in_catalogue": self.in_catalogue,
            "stages": list(self.effect.hooks),
            "text": self.effect.text,
        }


def asked_for(effect: str | None, seed: int) -> list[str]:
    """Names, each ``mechanism`` or ``mechanism:law``; None draws a mechanism, ``unknown`` stays as it is."""
    if effect is None:
        return [str(stream(seed, "which effect").choice(MECHANISMS))]
    return names_of(effect, {kind: [form.name for form in _forms(kind)] for kind in (*MECHANISMS, *UNKNOWN_KINDS)})


def _forms(mechanism: str) -> list[Form]:
    return [form for form in [*KNOWN, *OUTSIDE] if form.mechanism == mechanism]


def choose_effect(name: str, specimen: Specimen) -> Hidden:
    """Draw a law of an effect and its numbers; one seed gives one law, whatever the strength.

    Parameters
    ----------
    name : str
        As `asked_for` gives it.
    specimen : Specimen
        Laws take their scales from it.
    """
    mechanism, _, wanted = name.partition(":")
    outside = mechanism in (UNKNOWN, *UNKNOWN_KINDS)
    known_as = f"unknown:{mechanism}" if outside and mechanism != UNKNOWN else mechanism
    rng = stream(specimen.seed, "effect", known_as)
    if mechanism == UNKNOWN:
        mechanism = UNKNOWN_KINDS[int(rng.integers(len(UNKNOWN_KINDS)))]
    forms = _forms(mechanism)
    if not wanted:  # only then, as the numbers that follow depend on what was drawn before
        wanted = forms[int(rng.integers(len(forms)))].name
    form = next(form for form in forms if form.name == wanted)
    return Hidden(form, form.draw(rng, specimen))
