"""Small seeded recordings and models that tests of fits, comparisons and diagnoses share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from testbench.knit.catalogue import Catalogue, baseline, load_catalogue
from testbench.knit.model import KnitModel, inputs
from testbench.recordings.recording import Recording

GAUGE_LENGTH_MM = 25.0
NOISE_N, NOISE_LN = 0.01, 0.003
OWN_EFFECT = """
import numpy as np
from testbench.knit.effect import Effect, Stage, parameter

class Mine(Effect):
    name = "{name}"
    stage = Stage.MECHANICS
    reads, writes = ("strain", "force_N"), ("force_N",)
    strength = "gain"
    look = "nothing good"
    gain: float = parameter(0.1, unit="1", low=-5, high=5, doc="how much")

    def apply(self, signals, dt_s):
        force = signals["force_N"] * (1 + self.gain * signals["strain"])
        {body}
"""
CATALOGUE: Catalogue = load_catalogue()


def motion(duration_s: float, rate_hz: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Time and strain, 0 to 30 %: three sines that never meet, with a rest in every minute."""
    t = np.arange(round(duration_s * rate_hz)) / rate_hz
    phase = np.random.default_rng(seed).uniform(0, 6, 3)
    moving = np.minimum(t % 60, 50) + 50 * (t // 60)
    wave = [np.sin(w * moving + p) for w, p in zip((0.41, 0.73, 1.9), phase, strict=True)]
    strain = 0.15 + 0.075 * wave[0] + 0.05 * wave[1] + 0.02 * wave[2]
    return t, strain * np.minimum(t / 2, 1)


def truth() -> KnitModel:
    """A baseline away from its defaults."""
    return baseline().with_parameters(
        {
            "elasticity.stiffness_N": 6.0,
            "elasticity.curvature": 2.5,
            "hysteresis.friction_N": 0.25,
            "contact.contact_resistance_ohm": 900.0,
            "drift.per_decade": 0.03,
        }
    )


def record(
    model: KnitModel,
    duration_s: float = 240.0,
    rate_hz: float = 20.0,
    seed: int = 0,
    channels: tuple[str, ...] = ("force_N", "resistance_ohm"),
    noise: float = 1.0,
    strain: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Recording:
    """What instruments with white noise make of a model."""
    t, e = motion(duration_s, rate_hz, seed)
    e = e if strain is None else strain(t)
    state = model.simulate(inputs(t, e), 1 / rate_hz)
    rng = np.random.default_rng(seed)
    made = {"displacement_mm": GAUGE_LENGTH_MM * e}
    if "force_N" in channels:
        made["force_N"] = state["force_N"] + noise * NOISE_N * rng.standard_normal(len(t))
    if "resistance_ohm" in channels:
        made["resistance_ohm"] = np.exp(noise * NOISE_LN * rng.standard_normal(len(t))) / state["conductance_S"]
    return Recording(t, made, GAUGE_LENGTH_MM, f"sample-{seed}")


PULL_S, REST_S = 60.0, 30.0


def strokes(t: np.ndarray) -> np.ndarray:
    """Pulls to 20 % and back in three strokes, with rests at zero."""
    inside = t % (PULL_S + REST_S)
    return np.where(inside < PULL_S, 0.2 * np.abs(np.sin(3 * np.pi * inside / PULL_S)), 0.0)


def pulls_of(
    model: KnitModel, count: int, channels: tuple[str, ...] = ("force_N", "resistance_ohm")
) -> list[Recording]:
    """One history of a specimen, recorded pull by pull, with `REST_S` between them."""
    whole = record(model, count * (PULL_S + REST_S), 10.0, 1, channels, strain=strokes)
    made = []
    for number in range(count):
        begin_s = number * (PULL_S + REST_S)
        rows = (whole.time_s >= begin_s) & (whole.time_s < begin_s + PULL_S)
        read = {name: values[rows] for name, values in whole.channels.items()}
        made.append(Recording(whole.time_s[rows] - begin_s, read, GAUGE_LENGTH_MM, f"pull {number + 1}"))
    return made


def own_effect(name: str, body: str = "return {'force_N': force}") -> str:
    """The text of a file with an effect of somebody's own."""
    return OWN_EFFECT.replace("{name}", name).replace("{body}", body)


def write_csv(recording: Recording, path: Path) -> str:
    """As a bare CSV."""
    columns = {"time_s": recording.time_s, **recording.channels}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return str(path)
