"""Which effects a caller asks for, and a form of each with its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from simulated_case import UNKNOWN, names_of, stream

from gcode.support.errors import UserError
from worlds_third.effects import contacts, electrical, kinematics, mechanics, readout, unknown
from worlds_third.effects.form import Form
from worlds_third.randoms import Values, draw
from worlds_third.sensor import Hook
from worlds_third.signals import Signals

KNOWN = [*kinematics.FORMS, *mechanics.FORMS, *contacts.FORMS, *electrical.FORMS, *readout.FORMS]
MECHANISMS = list(dict.fromkeys(form.mechanism for form in KNOWN))
UNKNOWN_KINDS = list(dict.fromkeys(form.mechanism for form in unknown.FORMS))
FORMS = {
    kind: [form for form in [*KNOWN, *unknown.FORMS] if form.mechanism == kind]
    for kind in [*MECHANISMS, *UNKNOWN_KINDS]
}


@dataclass(frozen=True)
class Effect:
    """A form with its numbers; its randomness within a recording comes from `seed` and the recording's name."""

    form: Form
    values: Values
    seed: int

    @property
    def in_catalogue(self) -> bool:
        """Whether the catalogue has a mechanism of this name."""
        return self.form.mechanism in MECHANISMS

    def hook(self, size: float, recording: str) -> Hook:
        """What it does to one recording, at a size."""

        def act(s: Signals) -> None:
            rng = stream(self.seed, f"{self.form.mechanism}/{self.form.name}/{recording}")
            self.form.act(s, size, rng, **self.values)

        return self.form.stage, act

    def told(self) -> dict[str, Any]:
        """For the truth of a case."""
        return {
            "effect": self.form.mechanism,
            "form": self.form.name,
            "in_catalogue": self.in_catalogue,
            "stages": [self.form.stage],
            "parameters": dict(self.values),
        }


def asked_for(effect: str | None, seed: int) -> list[str]:
    """Names, each ``mechanism`` or ``mechanism:form``; None draws a mechanism, ``unknown`` a kind of no catalogue."""
    rng = stream(seed, "which effect")
    if effect is None:
        return [str(rng.choice(MECHANISMS))]
    names = names_of(effect, {kind: [form.name for form in forms] for kind, forms in FORMS.items()})
    return [str(rng.choice(UNKNOWN_KINDS)) if name == UNKNOWN else name for name in names]


def choose_effect(name: str, seed: int, attempt: int, channels: list[str]) -> Effect:
    """A form of the effect `name`, with its numbers, that the recorded channels can show.

    Parameters
    ----------
    name : str
        As `asked_for` gives it.
    seed, attempt : int
        Another attempt draws another form and other numbers.
    channels : list of str
        ``force`` and ``conductance``, or one of them.
    """
    mechanism, _, wanted = name.partition(":")
    forms = [form for form in FORMS[mechanism] if wanted in ("", form.name)]
    seen = [form for form in forms if _is_seen(form, channels)]
    if not seen:
        raise UserError(f"make_case: {name} acts on {forms[0].main} alone, which is not recorded; record it")
    rng = stream(seed, f"{mechanism}/{attempt}")
    form = seen[int(rng.integers(len(seen)))]
    return Effect(form, draw(rng, form.ranges), int(np.random.default_rng([seed, attempt]).integers(2**31)))


def _is_seen(form: Form, channels: list[str]) -> bool:
    """A reading shows in its own channel alone; the contacts feel the force, but not the other way round."""
    return form.main == "both" or form.main in channels or form.stage == "mechanics"
