"""What the simulators `worlds_second`, `worlds_third` and `worlds_fourth` share: a case and how one is asked for.

No physics is here: laws, effects, motions, noise and the measure of strength are each simulator's own.

Each has ``MECHANISMS``, ``UNKNOWN_KINDS`` (of no catalogue), ``PROTOCOLS``, ``LAW_FAMILIES``, and a function
``make_case``, which makes a sensor with a hidden effect and records it twice. Its arguments:

effect : str or None
    A mechanism or a kind of no catalogue, as ``name`` or ``name:form``; ``"none"``; ``"unknown"``, which draws such a
    kind; or two of these joined by a comma. None draws.
strength : float
    Of each effect, in noise floors, as its simulator measures it. What is out of reach ends lower; the truth says
    what was reached.
seed : int
    One seed is one sensor with its motions and noise, whatever the effect.
minutes, rate_hz : float
    Length of each recording and its sampling rate.
noise : float
    1 is the noise of the paper's rig (5 mN, 8e-4 in ln G).
protocol : str
    The kind of motion.
channels : sequence of str
    ``force_N``, ``resistance_ohm`` or both, and what else the simulator records.
laws : str
    Only sensors with these base laws (see `laws_of`); what else is drawn stays as it was. Second and third.
reclamped : bool
    The sensor was clamped anew for the held-out recording: displacement and force have other zeros there. Second and
    third.

An argument out of its range, or an effect that shows in no recorded channel, is a `UserError`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from gcode.support.errors import UserError
from testbench.recordings.channels import FORCE, RESISTANCE
from testbench.recordings.recording import Recording

CHANNELS = {FORCE: "force", RESISTANCE: "conductance"}
NONE, UNKNOWN = "none", "unknown"
MOST = 2  # effects at once
FEWEST = 60  # samples


@dataclass(frozen=True)
class Case:
    """Two recordings of one sensor, each of the rested specimen and with its own motion, and what is hidden in them.

    Attributes
    ----------
    calibration, held_out : Recording
    truth : dict
        Ready for JSON: ``verdict`` (``missing`` where an effect of the catalogue's mechanisms is hidden, ``unknown``
        where only others are, ``nothing_missing``), ``effects``, ``base``, ``noise_floor``, ``noise_kind``,
        ``displacement_noise_mm`` and ``recipe``. An effect's ``magnitude`` is in its form's own measure.
    clamp_play_mm : float
        By how much the zero of the displacement may differ between the two; 0 unless the sensor was clamped anew.
    """

    calibration: Recording
    held_out: Recording
    truth: dict[str, Any]
    clamp_play_mm: float = 0.0


def stream(seed: int, *words: str) -> np.random.Generator:
    """The random stream of a sensor that has these words as its name: drawing more from one never shifts another."""
    return np.random.default_rng([seed, crc32("/".join(words).encode())])


def verdict_of(effects: Sequence[Mapping[str, Any]]) -> str:
    """What a diagnosis should say of these hidden effects, as the truth tells them."""
    if not effects:
        return "nothing_missing"
    return "missing" if any(one["in_catalogue"] for one in effects) else "unknown"


def names_of(effect: str, forms: Mapping[str, Collection[str]]) -> list[str]:
    """The effects asked for, each ``unknown``, ``name`` or ``name:form``; none for ``"none"``.

    Parameters
    ----------
    effect : str
        One of these, or two joined by a comma.
    forms : mapping
        Every effect that there is, with its forms.
    """
    names = [name.strip() for name in effect.split(",")]
    if names == [NONE]:
        return []
    if NONE in names:
        raise UserError(f"make_case: none stands alone, got {effect}")
    if len(names) > MOST:
        raise UserError(f"make_case: at most {MOST} effects at once, got {len(names)}; leave some out")
    for name in names:
        kind, _, form = name.partition(":")
        if name != UNKNOWN and kind not in forms:
            raise UserError(f"make_case: no effect {kind!r}; there are {', '.join([NONE, UNKNOWN, *forms])}")
        if form and form not in forms[kind]:
            raise UserError(f"make_case: {kind} has no form {form!r}; it has {', '.join(forms[kind])}")
    return names


def laws_of(asked: str, families: Mapping[str, Collection[str]]) -> dict[str, list[str]]:
    """The laws of every family that may be drawn.

    Parameters
    ----------
    asked : str
        ``family=law,law`` for these alone, ``family!=law`` for all but this; several with spaces between.
    families : mapping
        Every family with its laws.
    """
    allowed = {family: list(laws) for family, laws in families.items()}
    for part in asked.split():
        given, _, named = part.partition("=")
        family, laws = given.removesuffix("!"), named.split(",")
        if family not in families:
            raise UserError(f"laws: no family {family!r}; there are {', '.join(families)}")
        strange = [law for law in laws if law not in families[family]]
        allowed[family] = [law for law in allowed[family] if (law in laws) != given.endswith("!")]
        if strange or not allowed[family]:
            raise UserError(
                f"laws: {family}=law,law or {family}!=law, of {', '.join(families[family])}, at least one left; "
                f"got {asked}"
            )
    return allowed


def check(
    asked: Mapping[str, Any], limits: Mapping[str, tuple[float, float]], protocols: Collection[str], *also: str
):
    """Whether the arguments of `make_case` make sense; `also` are channels beside force and resistance.

    Raises
    ------
    UserError
        Naming the argument, what is allowed and what came.
    """
    for name, (low, high) in limits.items():
        if not low <= asked[name] <= high:
            raise UserError(f"make_case: {name} must be between {low:g} and {high:g}, got {asked[name]:g}")
    if asked["seed"] < 0:
        raise UserError(f"make_case: seed must not be negative, got {asked['seed']}")
    minutes, rate_hz = asked["minutes"], asked["rate_hz"]
    if minutes * 60 * rate_hz < FEWEST:
        raise UserError(f"make_case: {minutes:g} min at {rate_hz:g} Hz is below {FEWEST} samples; record longer")
    if asked["protocol"] not in protocols:
        raise UserError(f"make_case: no protocol {asked['protocol']!r}; there are {', '.join(protocols)}")
    channels = asked["channels"]
    if not set(CHANNELS) & set(channels) or not set(channels) <= {*CHANNELS, *also}:
        came = ", ".join(channels) or "none"
        allowed = ", ".join([*CHANNELS, *also])
        raise UserError(f"make_case: channels are {allowed}, one of the first two at least; got {came}")
