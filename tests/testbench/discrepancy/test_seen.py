"""A reading that stands at its rail is seen, whatever a model makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.discrepancy.measurement import prepare
from testbench.discrepancy.screen import FLEXIBLE, WITHOUT_SLIP
from testbench.discrepancy.standin import may_move, straightened
from testbench.knit.catalogue import baseline
from testbench.recording import FORCE, RESISTANCE, Recording
from tests.testbench.discrepancy.samples import CATALOGUE, record, truth

FORMS = ("adc_saturation", "adc_saturation_high", "adc_saturation_force")


def seen_in(recording: Recording, form: str):
    """What the form sees in the readings, against an untouched model."""
    measurement = prepare(recording)
    state = truth().simulate(measurement.signals, measurement.dt_s)
    return CATALOGUE[form]().seen(state, measurement.residual(truth()), measurement.dt_s)


def clipped(channel: str, change) -> Recording:
    whole = record(truth(), 240, rate_hz=40)
    return replace(whole, channels={**whole.channels, channel: change(whole[channel])})


def test_a_rail_is_seen_at_its_level():
    ohm = record(truth(), 240, rate_hz=40)[RESISTANCE]
    floor_ohm, top_ohm = np.quantile(ohm, [0.05, 0.95])
    low = seen_in(clipped(RESISTANCE, lambda r: np.maximum(r, floor_ohm)), "adc_saturation")
    assert low.floor_ohm == pytest.approx(floor_ohm, rel=1e-6)
    high = seen_in(clipped(RESISTANCE, lambda r: np.minimum(r, top_ohm)), "adc_saturation_high")
    assert high.floor_S == pytest.approx(1 / top_ohm, rel=1e-6)
    force = seen_in(clipped(FORCE, lambda f: np.minimum(f, 1.5)), "adc_saturation_force")
    assert force.inverse_range_per_N == pytest.approx(1 / 1.5, rel=1e-6)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("step", [0.0, 0.05])
def test_nothing_is_seen_in_a_free_or_a_coarse_reading(form, step):
    def coarse(values):
        return np.round(values / step) * step if step else values

    channel = FORCE if form.endswith("force") else RESISTANCE
    assert seen_in(clipped(channel, coarse), form) is None


def test_a_contact_law_that_must_not_bend_keeps_its_slip():
    shape = CATALOGUE["contact_shape"]()
    bent = shape.replaced(
        strain_weights=(0.1,) * len(shape.strain_weights), slip_weights=(0.2,) * len(shape.slip_weights)
    )
    model = baseline().plus(bent)
    straight = straightened(model, "without contact_shape")["contact_shape"]
    assert not any(straight.strain_weights)
    assert all(straight.slip_weights)
    free = may_move("without contact_shape")
    assert free("contact_shape.slip_weights[0]")
    assert not free("contact_shape.strain_weights[3]")
    stuck = straightened(model, WITHOUT_SLIP)["contact_shape"]
    assert all(stuck.strain_weights)
    assert not any(stuck.slip_weights)
    assert not may_move(WITHOUT_SLIP)("contact_shape.slip_growth[0]")
    assert straightened(model, FLEXIBLE) is model
