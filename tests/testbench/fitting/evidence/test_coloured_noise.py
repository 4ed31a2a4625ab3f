"""Noise that resembles its last samples: how large it is at a grid point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.fitting.evidence.coloured_noise import with_colour
from testbench.fitting.evidence.independent_samples import on_the_grid
from testbench.fitting.evidence.sample_noise import noise_of
from testbench.knit.effect import FloatArray
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording
from tests.testbench.builders import CATALOGUE, record, truth

SD_N = 0.005
HUM_HZ = 3.1


def recorded(colour: float, hum_N: float = 0.0, hertz: float = HUM_HZ) -> Recording:
    """A knit whose load cell has noise of this size, each sample `colour` of the last one and news; and a hum."""
    clean = record(truth(), seed=2, rate_hz=40.0, noise=0.0)
    news = np.random.default_rng(1).standard_normal(len(clean.time_s)) * SD_N * np.sqrt(1 - colour**2)
    hum = hum_N * np.sin(2 * np.pi * hertz * clean.time_s)
    force_N = clean.channels["force_N"] + filtered(news, colour) + hum
    return replace(clean, channels={**clean.channels, "force_N": force_N})


def filtered(news: FloatArray, colour: float) -> FloatArray:
    noise = np.empty_like(news)
    last = 0.0
    for i, one in enumerate(news):
        noise[i] = last = colour * last + one
    return noise


def noise_at_the_grid(recording: Recording) -> tuple[Measurement, float, float]:
    measurement = prepare(recording)
    grid, white = on_the_grid(measurement), noise_of(measurement)
    return grid, white["force"], with_colour(white, (truth(),), grid)["force"]


@pytest.mark.parametrize("colour", [0.3, 0.5, 0.6])
def test_coloured_noise_is_nearly_as_large_as_it_is(colour: float):
    grid, as_if_white, found = noise_at_the_grid(recorded(colour))
    true = float(np.std(grid.residual(truth())["force"][grid.counts]))
    assert as_if_white < 0.85 * true
    assert 0.75 * true < found < 1.05 * true
    assert found > 1.15 * as_if_white


def test_white_noise_stays_as_it_was():
    _, as_if_white, found = noise_at_the_grid(recorded(0.0))
    assert found == pytest.approx(as_if_white, rel=0.07)


@pytest.mark.parametrize("hertz", [0.8, HUM_HZ, 5.3])
def test_a_hum_is_no_noise(hertz: float):
    _, as_if_white, found = noise_at_the_grid(recorded(0.0, hum_N=10 * SD_N, hertz=hertz))
    assert found < 1.3 * as_if_white


def test_what_a_wrong_model_leaves_is_no_noise():
    """One that knows nothing of the force, and one of a drive with a ripple of 30 floors that it does not know."""
    measurement = prepare(recorded(0.0))
    grid, white = on_the_grid(measurement), noise_of(measurement)
    wrong = truth().with_parameters({"elasticity.offset_N": 1.0, "elasticity.stiffness_N": 1e-3})
    assert with_colour(white, (wrong,), grid)["force"] < 1.2 * white["force"]
    rippled = truth().plus(CATALOGUE.effects["leadscrew_ripple"](amplitude=0.004, pitch=0.05))
    assert with_colour(white, (rippled,), grid)["force"] < 1.2 * white["force"]
