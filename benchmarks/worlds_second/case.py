"""One case: two recordings of a drawn sensor with a hidden effect, and the truth about it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from simulated_case import Case, check, stream, verdict_of

from testbench.recordings.channels import FORCE, RESISTANCE, TEMPERATURE
from worlds_second.chain import Hook
from worlds_second.choice import Hidden, choose
from worlds_second.protocols import PLAY, PROTOCOLS, draw_motion
from worlds_second.rig import Rig
from worlds_second.sensor import draw_sensor
from worlds_second.strength import reach

LIMITS = {"strength": (1e-3, 1e6), "minutes": (0.1, 1440.0), "rate_hz": (0.01, 1000.0), "noise": (1e-9, 100.0)}


def make_case(
    effect: str | None,
    strength: float = 5.0,
    seed: int = 0,
    *,
    minutes: float = 23.0,
    rate_hz: float = 40.0,
    noise: float = 1.0,
    protocol: str = "perlin",
    channels: Sequence[str] = (FORCE, RESISTANCE),
    laws: str = "",
    reclamped: bool = False,
) -> Case:
    """See `simulated_case`.

    The strength is what the sensor's own base laws cannot absorb of an effect: RMS over all samples of the recorded
    channels. At noise 1 the displacement has up to 1 um.
    """
    recipe = {**locals(), "channels": list(channels)}
    check(recipe, LIMITS, PROTOCOLS, TEMPERATURE)
    sensor = draw_sensor(seed, laws)
    motions = [
        draw_motion(stream(seed, "motion", protocol, str(index)), protocol, minutes, rate_hz, index, reclamped)
        for index in (0, 1)
    ]
    rig = Rig(sensor, seed, noise, motions, channels)
    hidden = choose(effect, seed, set(rig.floors), sensor.feels_force)
    hooks, effects = _scaled(rig, hidden, strength)
    truth = {
        "verdict": verdict_of(effects),
        "effects": effects,
        "base": sensor.described(),
        "noise_floor": dict(rig.floors),
        "noise_kind": rig.noise_kind,
        "displacement_noise_mm": rig.displacement_noise_mm,
        "recipe": recipe,
    }
    return Case(rig.record(0, hooks), rig.record(1, hooks), truth, reclamped * PLAY * sensor.stroke_mm)


def _scaled(rig: Rig, hidden: Sequence[Hidden], strength: float) -> tuple[list[Hook], list[dict[str, Any]]]:
    """What the effects do to the sensor, each alone brought to the strength asked for, and the truth about them."""
    hooks, effects = [], []
    for one in hidden:
        magnitude = reach(strength, one.form.largest, partial(_strength, rig, one))
        got = rig.strength(one.hooks(magnitude))
        reached = {
            "magnitude": magnitude,
            "strength_requested": float(strength),
            "strength_reached": got.pop("both"),
            "strength_by_channel": got,
        }
        effects.append({**one.described(), **reached})
        hooks += one.hooks(magnitude)
    return hooks, effects


def _strength(rig: Rig, one: Hidden, magnitude: float) -> float:
    return rig.strength(one.hooks(magnitude))["both"]
