"""A case: two recordings of one sensor, and what is hidden in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from simulated_case import CHANNELS, Case, check, verdict_of

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE
from testbench.recordings.recording import Recording
from worlds_fourth.chain import Sized, plain
from worlds_fourth.effects import Hidden, asked_for, choose_effect
from worlds_fourth.motion.motion import USUAL_HZ
from worlds_fourth.readings import DISPLACEMENT_MM, NOISE, observe
from worlds_fourth.records import make_record
from worlds_fourth.signals import GAUGE_LENGTH_MM, Record
from worlds_fourth.specimen import Specimen, draw_specimen
from worlds_fourth.strength import FLOORS, size_for, strengths

PROTOCOLS = ("mixed",)
LIMITS = {"strength": (0.1, 1000.0), "minutes": (1.0, 240.0), "rate_hz": (10.0, 100.0), "noise": (0.1, 30.0)}
RECORDINGS = ("calibration", "held_out")
FELT = 0.7  # share of strain in the driver of the contacts, up to which they feel the force well
ATTEMPTS = 200  # specimens drawn until the contacts feel the force


def make_case(
    effect: str | None,
    strength: float = 5.0,
    seed: int = 0,
    *,
    minutes: float = 23.0,
    rate_hz: float = USUAL_HZ,
    noise: float = 1.0,
    protocol: str = "mixed",
    channels: Sequence[str] = (FORCE, RESISTANCE),
) -> Case:
    """See `simulated_case`.

    The strength is in floors of 5 mN and of 4e-3 in ln R (see `strength`), times `noise`, in the channel that shows
    the effect more. Where the resistance alone is recorded and the effect is of the force, the contacts of this
    sensor feel the force.
    """
    recipe = {**locals(), "channels": list(channels)}
    check(recipe, LIMITS, PROTOCOLS)
    recorded = [CHANNELS[name] for name in channels]
    specimen, records, hidden = make_sensor(asked_for(effect, seed), seed, minutes, rate_hz, recorded)
    floors = {name: FLOORS[name] * noise for name in recorded}
    sized, told = [], []
    for one in hidden:
        size, capped = size_for(specimen, records[0], one.effect, strength, floors)
        sized.append((one.effect, size))
        told.append(_told(one, size, capped, strength, [strengths(specimen, r, sized[-1:], floors) for r in records]))
    calibration, held_out = (_recording(specimen, record, sized, noise, channels) for record in records)
    truth = {
        "verdict": verdict_of(told),
        "effects": told,
        "base": specimen.told(),
        "noise_floor": {name: NOISE[name] * noise for name in recorded},
        "noise_kind": specimen.instruments.kind,
        "displacement_noise_mm": float(DISPLACEMENT_MM / np.sqrt(12.0)),
        "recipe": recipe,
    }
    return Case(calibration, held_out, truth)


def make_sensor(
    names: Sequence[str], seed: int, minutes: float, rate_hz: float, recorded: Sequence[str]
) -> tuple[Specimen, list[Record], list[Hidden]]:
    """Draw a specimen, move it for both recordings, and draw the effects on it.

    Parameters
    ----------
    names : sequence of str
        As `asked_for` gives them.
    seed, minutes, rate_hz
        As those of `make_case`.
    recorded : sequence of str
        ``force``, ``conductance`` or both.

    Raises
    ------
    UserError
        If an effect shows in no recorded channel.
    """
    drawn = _felt(names, seed, recorded)
    records = [make_record(drawn, name, minutes, rate_hz) for name in RECORDINGS]
    force, log_r = plain(drawn, records[0])
    specimen = replace(
        drawn,
        force_range_N=(float(force.min()), float(force.max())),
        log_r_range=(float(log_r.min()), float(log_r.max())),
    )
    hidden = [choose_effect(name, specimen) for name in names]
    for one in hidden:
        if not set(recorded) & one.shown_in:
            (missing,) = one.shown_in
            text = f"acts on the {missing} alone, which is not recorded; record it"
            raise UserError(f"make_case: {one.form.mechanism}:{one.form.name} {text}")
    return specimen, records, hidden


def _felt(names: Sequence[str], seed: int, recorded: Sequence[str]) -> Specimen:
    """A specimen whose contacts feel the force, where nothing else would show an effect on the force."""
    specimen = draw_specimen(seed)
    if recorded != ["conductance"]:
        return specimen
    for attempt in range(1, ATTEMPTS):
        of_force = any("force" in choose_effect(name, specimen).effect.hooks for name in names)
        if not of_force or specimen.conduction.strain_share <= FELT:
            break
        specimen = draw_specimen(seed, attempt)
    return specimen


def _told(
    hidden: Hidden, size: float, capped: bool, strength: float, reached: Sequence[Mapping[str, float]]
) -> dict[str, Any]:
    """For the truth; `reached` are the strengths in both recordings."""
    calibration, held_out = reached
    main = max(calibration, key=lambda name: calibration[name])
    return {
        **hidden.told(),
        "magnitude": float(size),
        "at_its_largest": capped,
        "main_channel": main,
        "strength_requested": strength,
        "strength_reached": calibration[main],
        "strength_by_channel": dict(calibration),
        "strength_held_out": dict(held_out),
    }


def _recording(
    specimen: Specimen, record: Record, effects: Sized, noise: float, channels: Sequence[str]
) -> Recording:
    """What the instruments write down."""
    displacement_mm, force_N, resistance_ohm = observe(specimen, record, effects, noise)
    readings = {FORCE: force_N, RESISTANCE: resistance_ohm}
    measured = {DISPLACEMENT: displacement_mm, **{channel: readings[channel] for channel in channels}}
    source = f"fourth worlds, sensor {specimen.seed}, {record.name.replace('_', '-')}"
    return Recording(record.time_s, measured, GAUGE_LENGTH_MM, source)
