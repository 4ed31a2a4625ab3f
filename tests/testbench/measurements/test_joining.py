"""Recordings of one specimen in a row, each sampled at a rate of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbench.comparing.model_errors import rms_errors
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.measurements.joining import joined
from testbench.measurements.measurement import sampled
from testbench.measurements.preparing import prepare
from tests.testbench.builders import NOISE_N, record, truth

RARE, OFTEN = (record(truth(), *shape, channels=("force_N",)) for shape in ((120, 11.0, 1), (60, 200.0, 2)))


@pytest.mark.parametrize("pair", [(RARE, OFTEN), (OFTEN, RARE)])
def test_the_order_of_rates_decides_neither_the_grid_nor_the_noise(pair):
    both = joined(pair, [10.0])
    assert both.dt_s == prepare(OFTEN).dt_s
    assert sorted(both.averaged) == [1.0, pytest.approx(8, rel=0.01)]
    judged = likelihood_of(truth(), both, noise_of(both))
    noise_N = judged.floor["force"] / judged.weight["force"]
    is_second = both.signals["time_s"][judged.rows] >= both.begins_s[0]
    for rows, one in zip((~is_second, is_second), pair, strict=True):
        expected = NOISE_N if one is RARE else NOISE_N / 8**0.5
        assert np.median(noise_N[rows]) == pytest.approx(expected, rel=0.15)


def test_the_usual_noise_depends_on_no_order():
    one, other = (noise_of(joined(pair, [10.0]))["force"] for pair in ((RARE, OFTEN), (OFTEN, RARE)))
    assert one == pytest.approx(other, rel=0.05)


def test_the_burn_in_of_a_later_recording_counts_nowhere():
    """A model need not be right there: it does not know what was before."""
    alone = prepare(OFTEN)
    wrong_N = OFTEN["force_N"] + 50.0 * (OFTEN.time_s < 0.9 * alone.grid_s[alone.counts][0])
    late = replace(OFTEN, channels={**OFTEN.channels, "force_N": wrong_N})
    both = joined([RARE, late], [10.0])
    _, values = sampled(both, "force")
    expected = len(sampled(prepare(RARE), "force")[0]) + len(sampled(alone, "force")[0])
    assert len(values) == pytest.approx(expected, abs=1)  # its last sample lies between two points of the finer grid
    assert values.max() < 50.0
    assert rms_errors(truth(), both)["force"] < 2 * NOISE_N


@pytest.mark.parametrize("pair", [(RARE, OFTEN), (OFTEN, RARE)])
@pytest.mark.parametrize("rest_s", [1e-3, 0.1, 10.0])
def test_one_begins_a_rest_after_the_last_sample_of_the_other(pair, rest_s):
    both = joined(pair, [rest_s])
    time_s, count = both.recording.time_s, len(pair[0])
    assert np.all(np.diff(time_s) > 0)
    assert time_s[count] - time_s[count - 1] == pytest.approx(rest_s, abs=1.01 * both.dt_s)
