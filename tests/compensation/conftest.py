"""Simulated recordings of a knit: the baseline model driven by a smooth random motion, read with noise and jitter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.training import METHODS
from testbench.knit.catalogue import baseline
from testbench.knit.model import inputs
from testbench.recordings.recording import Recording

GAUGE_MM = 25.0
REAL = Path(__file__).resolve().parents[2] / "../shared/data/real/cb_silicone_strip"


def random_motion(time_s: np.ndarray, seed: int, amplitude: float = 0.3) -> np.ndarray:
    """Strain between 0 and `amplitude`: a few sines of incommensurable periods."""
    rng = np.random.default_rng(seed)
    periods = rng.uniform([5.0, 9.0, 17.0], [8.0, 15.0, 40.0])
    phases = rng.uniform(0, 2 * np.pi, 3)
    waves = np.sin(2 * np.pi * time_s[:, None] / periods + phases).sum(axis=1)
    return amplitude * (waves - waves.min()) / np.ptp(waves)


def simulated_recording(seed: int, duration_s: float = 240.0, rate_hz: float = 20.0) -> Recording:
    """A recording of the baseline knit, sampled irregularly at about 41 Hz."""
    dt_s = 1.0 / rate_hz
    grid = np.arange(0.0, duration_s, dt_s)
    signals = baseline().simulate(inputs(grid, random_motion(grid, seed)), dt_s)
    rng = np.random.default_rng(seed + 1000)
    time_s = np.cumsum(rng.uniform(0.008, 0.04, int(duration_s * 41)))
    time_s = time_s[time_s < grid[-1]]

    def read(name: str, noise: float) -> np.ndarray:
        values = np.interp(time_s, grid, signals[name])
        return values + noise * values.std() * rng.standard_normal(len(values))

    channels = {
        "displacement_mm": GAUGE_MM * np.interp(time_s, grid, signals["strain_nominal"]),
        "force_N": read("force_N", 0.01),
        "resistance_ohm": 1.0 / read("conductance_S", 0.005),
    }
    return Recording(time_s, channels, GAUGE_MM, f"simulated-{seed}")


def train(recordings: Sequence[Recording], target: str, options: Options | None = None, method: str = "paper"):
    """A compensator that was trained by one of `METHODS` on these recordings."""
    options = options or Options()
    series = [series_of(recording, target, options.resampling_hz) for recording in recordings]
    return METHODS[method](series, target, options)


def paused(recording: Recording, at_s: float, gap_s: float) -> Recording:
    """The same samples, with nothing recorded for so long at that time."""
    return replace(recording, time_s=recording.time_s + np.where(recording.time_s > at_s, gap_s, 0.0))


@pytest.fixture(scope="session")
def recordings() -> list[Recording]:
    """Three recordings of one simulated sensor: training, A and B."""
    return [simulated_recording(seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="session")
def real_folder() -> Path:
    """The measured recordings of the carbon-black strip."""
    if not REAL.is_dir():
        pytest.skip("the measured recordings are not on this machine")
    return REAL
