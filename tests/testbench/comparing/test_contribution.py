"""What an effect would add, without what the base could do by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.comparing.contribution import contribution
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.model import KnitModel, inputs
from testbench.measurements.measurement import Measurement
from testbench.measurements.preparing import prepare
from testbench.recordings.recording import Recording


def measured_with(model: KnitModel) -> Measurement:
    """Two minutes of `model` with a little noise, along a strain that does not repeat."""
    time_s = np.arange(2400) * 0.05
    strain = 0.12 + 0.06 * np.sin(0.9 * time_s) + 0.05 * np.sin(0.37 * time_s + 1.0)
    state = model.simulate(inputs(time_s, strain), 0.05)
    noise = np.random.default_rng(3).normal(size=(2, len(time_s)))
    channels = {
        "displacement_mm": 25 * strain,
        "force_N": state["force_N"] + 1e-3 * noise[0],
        "resistance_ohm": np.exp(1e-3 * noise[1]) / state["conductance_S"],
    }
    return prepare(Recording(time_s, channels, 25.0))


def test_an_effect_that_is_there_predicts_its_own_size() -> None:
    effect = load_catalogue()["stress_relaxation"]().replaced(fraction=0.1)
    found = contribution(baseline(), effect, measured_with(baseline().plus(effect)))
    for channel in found.residual:
        slope = np.polyfit(found.added[channel], found.residual[channel], 1)[0]
        assert slope == pytest.approx(1.0, abs=0.1)


def test_what_the_base_can_do_itself_is_taken_out() -> None:
    model = baseline()
    stiffer = model.with_parameters({"elasticity.stiffness_N": model["elasticity"].stiffness_N * 1.02})
    measurement = measured_with(stiffer)
    effect = load_catalogue()["stress_relaxation"]()
    raw = measurement.residual(model)["force"][measurement.counts]
    found = contribution(model, effect, measurement)
    assert np.std(found.residual["force"]) < 0.1 * np.std(raw)


def test_offsets_do_not_count() -> None:
    measurement = measured_with(baseline())
    moved = replace(measurement, measured={c: v + 0.3 for c, v in measurement.measured.items()})
    effect = load_catalogue()["stress_relaxation"]()
    same, other = (contribution(baseline(), effect, m) for m in (measurement, moved))
    np.testing.assert_allclose(other.residual["force"], same.residual["force"], atol=2e-3)
