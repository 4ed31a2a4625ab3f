"""A case: two recordings of one sensor, and what is hidden in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from simulated_case import CHANNELS, Case, check, stream, verdict_of

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording
from worlds_third import noise as noises
from worlds_third.clock import refined, sample_times, steps_between
from worlds_third.effects import Effect, asked_for, choose_effect
from worlds_third.protocols import PROTOCOLS
from worlds_third.randoms import between
from worlds_third.sensor import Hook, Sensor, make_sensor, respond
from worlds_third.signals import Array, Signals
from worlds_third.strength import Absorption, size_for

LIMITS = {"strength": (0.1, 1000.0), "minutes": (1.0, 240.0), "rate_hz": (0.2, 200.0), "noise": (0.1, 30.0)}
RECORDINGS = ("calibration", "held_out")
ATTEMPTS = 6  # forms tried until one reaches the strength asked for
NEAR = 0.05  # of it: near enough
STROKE_S = (3.0, 15.0)  # time of a stroke
SLOWEST, SAMPLES = 10.0, 12.0  # at least so many strokes in a recording, so many samples in a stroke
ROOM_C = 1.2  # RMS of the room's temperature about 22 degrees
STEPS_PER_MM = (160.0, 800.0)  # of the stepper motor
ZERO_STRAIN, ZERO_FORCE_N = (-0.02, 0.03), (-0.02, 0.02)  # after clamping anew; the strain over the stroke


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

    The strength is what smooth functions of strain, direction and time cannot absorb of the effect in its main
    channel (see `strength`); of the strain, in the channel that shows it more. Where the resistance alone is recorded
    and the effect is of the force, the contacts of this sensor are pressed by the force.
    """
    recipe = {**locals(), "channels": list(channels)}
    check(recipe, LIMITS, PROTOCOLS, TEMPERATURE)
    recorded = [CHANNELS[name] for name in channels if name in CHANNELS]
    names = asked_for(effect, seed)
    sensor = make_sensor(seed, laws, pressed_by_force=_is_felt_by_force_alone(names, seed, recorded))
    rig = _Rig(sensor, seed, minutes, rate_hz, protocol, reclamped)
    floors = {"force": noises.FORCE_N * noise, "conductance": noises.LOG_G * noise}
    sized = [_sized(rig, name, strength, {k: floors[k] for k in recorded}) for name in names]
    made = rig.run([(one, told["magnitude"]) for one, told in sized])
    kind = noises.kind_of(stream(seed, "kind of noise"))
    first, second = (_recording(rig, s, floors, kind, channels, k) for k, s in zip(RECORDINGS, made, strict=True))
    told = [told for _, told in sized]
    truth = {
        "verdict": verdict_of(told),
        "effects": told,
        "base": sensor.told(),
        "noise_floor": {name: floors[name] for name in recorded},
        "noise_kind": kind,
        "displacement_noise_mm": float(rig.motor_step_mm / np.sqrt(12.0)),
        "recipe": recipe,
    }
    return Case(first, second, truth, reclamped * max(ZERO_STRAIN) * sensor.stroke_mm)


class _Rig:
    """Sensor, motions and instruments of one seed."""

    def __init__(
        self, sensor: Sensor, seed: int, minutes: float, rate_hz: float, protocol: str, reclamped: bool
    ) -> None:
        self.sensor, self.seed, self.reclamped = sensor, seed, reclamped
        self.motor_step_mm = 1.0 / between(stream(seed, "motor"), *STEPS_PER_MM)
        parts = steps_between(rate_hz)
        self.moved = [self._moved(name, minutes, rate_hz, parts, protocol) for name in RECORDINGS]
        self.zero_strain = between(stream(seed, "clamps/strain"), *ZERO_STRAIN) if reclamped else 0.0
        self.zero_force_N = between(stream(seed, "clamps/force"), *ZERO_FORCE_N) if reclamped else 0.0
        self.base = self.run([])
        force, log_g = (np.concatenate(one) for one in zip(*((s.force, s.log_g) for s in self.base), strict=True))
        self.tops = (float(force.max()), float(log_g.min()), float(log_g.max()))

    tops = (1.0, -1.0, 0.0)

    def run(self, effects: Sequence[tuple[Effect, float]]) -> list[Signals]:
        """Signals of both recordings with effects of these sizes."""
        made = []
        for name, (time_s, drive, room, rate_hz, parts) in zip(RECORDINGS, self.moved, strict=True):
            s = Signals(time_s, drive, room, rate_hz, parts, self.tops)
            if name == RECORDINGS[1]:
                s.strain = s.strain + self.zero_strain
            hooks: list[Hook] = [effect.hook(size, name) for effect, size in effects]
            made.append(respond(self.sensor, s, hooks))
        return made

    def _moved(
        self, name: str, minutes: float, rate_hz: float, parts: int, protocol: str
    ) -> tuple[Array, Array, Array, float, int]:
        rng = stream(self.seed, f"{protocol}/{name}")
        stroke_s = min(max(between(rng, *STROKE_S), SAMPLES / rate_hz), minutes * 60 / SLOWEST)
        time_s = refined(sample_times(stream(self.seed, f"clock/{name}"), minutes, rate_hz), parts)
        drive = PROTOCOLS[protocol](time_s, rng, stroke_s)
        return time_s, drive, _room(stream(self.seed, f"room/{name}"), time_s), rate_hz, parts


def _is_felt_by_force_alone(names: Sequence[str], seed: int, recorded: list[str]) -> bool:
    """Whether an effect on the force would show nowhere unless the force presses the contacts."""
    of_force = any(choose_effect(name, seed, 0, recorded).form.stage == "mechanics" for name in names)
    return recorded == ["conductance"] and of_force


def _sized(rig: _Rig, name: str, strength: float, floors: Mapping[str, float]) -> tuple[Effect, dict[str, Any]]:
    """A form of the effect that reaches the strength, or the one of a few that comes closest, and what to tell."""
    scaled = {k: v / rig.sensor.sizes["force_full_N"] if k == "force" else v for k, v in floors.items()}
    absorption = Absorption(rig.base, scaled, rig.reclamped)
    found: list[tuple[float, Effect, float]] = []
    for attempt in range(ATTEMPTS):
        effect = choose_effect(name, rig.seed, attempt, list(floors))
        main = effect.form.main

        def measured(size: float, effect: Effect = effect, main: str = main) -> float:
            left = absorption.left(rig.run([(effect, size)]))
            return left.get(main, max(left.values()))

        size, reached = size_for(strength, effect.form.limit, measured)
        found.append((reached, effect, size))
        if abs(reached / strength - 1) <= NEAR:
            break
    reached, effect, size = min(found, key=lambda one: abs(np.log(max(one[0], 1e-9) / strength)))
    told = {
        **effect.told(),
        "magnitude": size,
        "main_channel": effect.form.main,
        "strength_requested": strength,
        "strength_reached": reached,
        "strength_by_channel": absorption.left(rig.run([(effect, size)])),
    }
    return effect, told


def _recording(
    rig: _Rig, s: Signals, floors: Mapping[str, float], kind: str, channels: Sequence[str], name: str
) -> Recording:
    """What the instruments write down."""
    sizes, keep = rig.sensor.sizes, slice(None, None, s.parts)
    rng = stream(rig.seed, f"noise/{name}")
    count = len(s.time_s[keep])
    zero_N = rig.zero_force_N if name == RECORDINGS[1] else 0.0
    force_N = s.force[keep] * sizes["force_full_N"] + zero_N + floors["force"] * noises.force_noise(rng, kind, count)
    log_g = s.log_g[keep] + floors["conductance"] * noises.resistance_noise(rng, kind, s.log_g[keep])
    room_C = 22.0 + ROOM_C * s.room[keep] + 0.02 * rng.normal(size=count)
    step = rig.motor_step_mm
    readings = {
        FORCE: force_N,
        RESISTANCE: sizes["resistance_full_ohm"] * np.exp(-log_g),
        TEMPERATURE: room_C,
    }
    measured = {DISPLACEMENT: np.round(s.drive[keep] * rig.sensor.stroke_mm / step) * step}
    measured |= {channel: readings[channel] for channel in channels}
    source = f"third worlds, sensor {rig.seed}, {name.replace('_', '-')}"
    return Recording(s.time_s[keep], measured, sizes["gauge_length_mm"], source)


def _room(rng: np.random.Generator, time_s: Array) -> Array:
    """Temperature of a room about its mean: a random walk that is drawn back, without corners, of unit spread."""
    pace_s = between(rng, 40.0, 150.0)
    count = int(time_s[-1] / pace_s) + 8
    walk = np.zeros(count)
    for k in range(1, count):
        walk[k] = 0.85 * walk[k - 1] + rng.normal()
    place = time_s / pace_s + 1.0
    cell = place.astype(int)
    u = place - cell
    near = [walk[cell + j] for j in (-1, 0, 1, 2)]
    weights = [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3]
    smooth = sum(w * n for w, n in zip(weights, near, strict=True)) / 6.0
    return (smooth - smooth.mean()) / max(float(np.std(smooth)), 1e-6)
