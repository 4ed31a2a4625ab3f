"""A sensor in its rig: clean read-outs, recordings with noise, and how strong an effect is in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from simulated_case import CHANNELS, stream

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording
from worlds_second.chain import Hook, Scales, converted, measure, simulate
from worlds_second.kernels import Array
from worlds_second.noise import DISPLACEMENT_MM, FORCE_N, LN_CONDUCTANCE, draw_kind, draw_noise
from worlds_second.protocols import Motion
from worlds_second.sensor import Sensor
from worlds_second.strength import STEP, Absorber, Channels, make_absorber

CALM_C, THERMOMETER_K = 22.0, 0.02
STEEPEST = 3.0  # slope of the steepest part of a curve over its mean slope, about
DISPLACEMENT_SHARE = 0.3  # noise of the displacement makes at most about this share of either floor


class Rig:
    """A drawn sensor, the motions of its two recordings and the noise of its read-outs.

    Parameters
    ----------
    sensor : Sensor
    seed : int
        Names the streams of noise and of random events.
    noise : float
        1 is the noise of the paper's rig.
    motions : sequence of Motion
        Of the calibration and of the held-out recording.
    recorded : sequence of str
        ``force_N``, ``resistance_ohm`` or both, and ``temperature_C`` if recorded.
    """

    def __init__(
        self, sensor: Sensor, seed: int, noise: float, motions: Sequence[Motion], recorded: Sequence[str]
    ) -> None:
        self.sensor, self.seed, self.motions, self.recorded = sensor, seed, motions, recorded
        self.scales = measure(simulate(sensor, motions[0], [], Scales(), seed)[0])
        self.noise_kind = draw_kind(seed)
        self.rms = {FORCE: FORCE_N * noise, RESISTANCE: LN_CONDUCTANCE * noise}
        self.floors: Mapping[str, float] = {CHANNELS[name]: self.rms[name] for name in CHANNELS if name in recorded}
        spans = {
            FORCE: self.scales.force_high_N - self.scales.force_low_N,
            RESISTANCE: self.scales.ln_high - self.scales.ln_low,
        }
        allowed = [
            DISPLACEMENT_SHARE * self.rms[name] * sensor.stroke_mm / (STEEPEST * spans[name])
            for name in CHANNELS
            if name in recorded
        ]
        self.displacement_noise_mm = float(min(DISPLACEMENT_MM * noise, *allowed))

    def clean(self, hooks: Sequence[Hook], sensor: Sensor | None = None) -> Channels:
        """The calibration's read-outs without noise, with the converters."""
        readings, signals = simulate(sensor or self.sensor, self.motions[0], hooks, self.scales, self.seed)
        force, ln_g = converted(signals, readings.force_N, readings.ln_conductance, hooks)
        return {"force": force, "conductance": ln_g}

    def record(self, index: int, hooks: Sequence[Hook]) -> Recording:
        """The calibration (0) or the held-out recording (1), with noise."""
        readings, signals = simulate(self.sensor, self.motions[index], hooks, self.scales, self.seed)
        times = readings.time_s

        def noise(name: str, rms: float, kind: str = "white") -> Array:
            rng = stream(self.seed, "noise", name, str(index))
            return draw_noise(rng, len(times), rms, kind, float(times[1] - times[0]))

        force, ln_g = converted(
            signals,
            readings.force_N + noise(FORCE, self.rms[FORCE], self.noise_kind),
            readings.ln_conductance + noise(RESISTANCE, self.rms[RESISTANCE], self.noise_kind),
            hooks,
        )
        channels = {
            DISPLACEMENT: readings.x * self.sensor.stroke_mm + noise(DISPLACEMENT, self.displacement_noise_mm),
            FORCE: force,
            RESISTANCE: np.exp(-ln_g),
            TEMPERATURE: CALM_C + readings.room_K + noise(TEMPERATURE, THERMOMETER_K),
        }
        kept = {name: values for name, values in channels.items() if name == DISPLACEMENT or name in self.recorded}
        source = f"second worlds, sensor {self.seed}, {('calibration', 'held out')[index]}"
        return Recording(times, kept, self.sensor.gauge_length_mm, source)

    def strength(self, hooks: Sequence[Hook]) -> dict[str, float]:
        """What the base cannot absorb of an effect, in noise floors, by channel and over ``both``."""
        changed = self.clean(hooks)
        return self._absorber.left({name: changed[name] - self._base[name] for name in self.floors})

    @cached_property
    def _base(self) -> Channels:
        return self.clean([])

    @cached_property
    def _absorber(self) -> Absorber:
        moved = [(self.clean([], sensor), step) for sensor, step in self.sensor.stepped(STEP)]
        motion = self.motions[0]
        rows = slice(None, None, motion.every)
        return make_absorber(self._base, moved, motion.x[rows], motion.t[rows], self.floors)
