"""Parameters at which a law jumps: found by moving them, and paid for."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.special import logsumexp

from testbench.diagnosis.judging.discrepancy_map import mapped
from testbench.fitting.evidence.cost_scan import STEPS, width
from testbench.fitting.evidence.independent_samples import on_the_grid, telling
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.priors import declared
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.kinematics.slip import ClampSlipOnce
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth

SLIP_S = 60.3


@cache
def problem():
    """A recording with one slip, and its baseline."""
    slipped = truth().plus(ClampSlipOnce(amount=0.02, when_s=SLIP_S))
    measurement = telling(on_the_grid(prepare(record(slipped, 120.0))))
    return likelihood_of(truth(), measurement, noise_of(measurement)).in_pieces


def fit_from(when_s: float, is_free: bool = True):
    law = truth().plus(ClampSlipOnce(amount=0.02, when_s=when_s))
    return fitted(law, problem(), truth(), free=lambda a: is_free or a != "clamp_slip_once.when_s")


@pytest.mark.parametrize("start_s", [55.0, 60.0, 60.5, 70.0])
def test_the_moment_of_a_slip_is_found_from_beside_it(start_s):
    assert fit_from(start_s).model["clamp_slip_once"].when_s == pytest.approx(SLIP_S, abs=0.1)


def test_the_evidence_is_the_integral_over_the_moment():
    """Laplace's approximation took the moment for known: 9 nats too many."""
    h = fit_from(SLIP_S)
    mean, sd = declared(ClampSlipOnce, "when_s", {})
    moments = np.arange(np.log(SLIP_S) - 3e-3, np.log(SLIP_S) + 3e-3, 2.5e-4)
    held = np.array([fit_from(float(np.exp(x)), is_free=False).log_z for x in moments])
    prior = -0.5 * ((moments - mean) / sd) ** 2 - np.log(sd * np.sqrt(2 * np.pi))
    assert h.log_z == pytest.approx(logsumexp(held + prior + np.log(2.5e-4)), abs=2.0)


def test_a_map_of_the_past_can_be_laid_beside_it():
    """What is no derivative must not be one when columns are added: the matrix would have no root."""
    h = fit_from(SLIP_S)
    index = [p.address for p in h.priors.parameters].index("clamp_slip_once.when_s")
    assert not any(rows[index + 1].any() for rows in h.columns.values())
    assert np.isfinite(mapped(h, problem()).log_z)


def test_the_width_is_where_the_cost_has_risen_by_a_half():
    known = 0.01
    sides = np.array([0.5 * STEPS / known, 0.5 * STEPS / known])  # as beside a jump
    assert width(sides + 7.0, 7.0) == pytest.approx(known)
    assert width(np.full((2, len(STEPS)), 3.0), 3.0) == STEPS[-1]
    steep = np.where(STEPS > 1e-3, 100.0, 0.0)  # within one sample nothing changes
    assert width(np.array([steep, steep]), 0.0) == STEPS[STEPS < 1e-3][-1]
