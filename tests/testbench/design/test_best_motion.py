"""Free motions keep every limit, and the one that is chosen tells more than random motion when it is really made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gcode.programs.make import make
from gcode.support.errors import UserError
from gcode.trajectories.trajectory import Trajectory
from testbench.design.ahead import following, planned
from testbench.design.best_motion import best_motion
from testbench.design.compositions import drawn, in_words, motion_of, varied
from testbench.design.forecast import Forecaster, Likely, Reading
from testbench.design.information import information
from testbench.design.protocols import NOISE, Bounds, menu
from testbench.fitting.constants import ALIKE_S
from testbench.fitting.fit import fit
from tests.testbench.builders import CATALOGUE, NOISE_LN, NOISE_N, truth
from tests.testbench.design.monte_carlo import sampled_information
from tests.testbench.design.readings import read

READING = Reading({"force": NOISE_N, "conductance": NOISE_LN}, 30)
BOUNDS = Bounds(duration_s=120)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    v_max=st.floats(0.5, 40),
    a_max=st.floats(2, 100),
    strain=st.floats(2, 80),
    duration=st.floats(120, 900),
    gauge=st.sampled_from([10.0, 25.0, 100.0]),
    steps=st.integers(0, 4),
)
def test_every_free_motion_keeps_every_limit(seed, v_max, a_max, strain, duration, gauge, steps):
    bounds = Bounds(v_max, a_max, strain, duration, gauge)
    rng = np.random.default_rng(seed)
    genes = drawn(rng)
    for _ in range(steps):
        genes = varied(genes, rng)
    motion = motion_of(genes, bounds, seed)
    if motion is None:
        return  # it is left out of the search
    position, rate = motion.trajectory.position_mm, motion.trajectory.rate_hz
    assert position.min() >= -1e-9
    assert position.max() <= bounds.stroke_mm + 1e-3
    assert np.abs(np.diff(position)).max() * rate <= v_max + 1e-6
    assert np.abs(np.diff(position, 2)).max() * rate**2 <= a_max * (1 + 1e-6) + 1e-6
    assert motion.trajectory.duration_s <= duration
    assert position[0] == position[-1] == 0
    assert in_words(motion.spec)


def test_most_free_motions_can_be_driven_and_fill_their_time():
    rng = np.random.default_rng(0)
    motions = [motion_of(drawn(rng), BOUNDS, 1) for _ in range(60)]
    driven = [motion for motion in motions if motion is not None]
    assert len(driven) > 50
    assert np.median([motion.trajectory.duration_s for motion in driven]) > 0.9 * BOUNDS.duration_s


def history(model, seed: int = 3):
    """Two minutes of random motion that a model went through, with noise."""
    made = make(menu(BOUNDS)[NOISE], seed, BOUNDS.gauge_length_mm)
    measurement = planned(made.trajectory, BOUNDS.gauge_length_mm, tuple(READING.noise))
    return read(measurement, model, seed)


def rivals(measured):
    """Permanent set and a sliding clamp, each fitted to what was read."""
    models = {
        "permanent_set": truth().plus(CATALOGUE["permanent_set"]()),
        "clamp_slip": truth().plus(CATALOGUE["clamp_slip_sliding"]()),
    }
    return [Likely(name, 0.5, fit(model, measured, iterations=8).model) for name, model in models.items()]


@pytest.fixture(scope="module")
def designed():
    measured = history(truth().plus(CATALOGUE["permanent_set"]()))
    likely = rivals(measured)
    return measured, likely, best_motion(likely, measured, READING, BOUNDS, rest_s=10.0, trials=6)


def test_the_best_motion_is_expected_to_tell_more_than_random_motion(designed):
    _, _, found = designed
    assert found.expected.conditional_entropy <= found.perlin.conditional_entropy
    assert found.expected.low >= found.perlin.low
    assert found.tried > 10


def test_the_best_motion_is_a_checked_program_within_the_limits(designed):
    _, _, found = designed
    assert found.made.statistics.v_max_mm_per_s <= BOUNDS.v_max_mm_per_s + 1e-6
    assert found.made.statistics.a_max_mm_per_s2 <= BOUNDS.a_max_mm_per_s2 + 1e-6
    assert found.made.statistics.x_max_mm <= BOUNDS.stroke_mm + 1e-3
    assert found.made.trajectory.duration_s <= BOUNDS.duration_s


def test_the_bounds_hold_what_simulated_readings_of_knit_models_tell(designed):
    """Nested Monte Carlo on the forecasts of real models: readings are drawn, the rivals weighed with each."""
    measured, likely, found = designed
    ahead = following(measured, found.made.trajectory, BOUNDS.gauge_length_mm, 10.0)
    expected = [Forecaster(one, measured, READING).expect(ahead)[0] for one in likely]
    bounds = information(expected, [0.5, 0.5])
    told = sampled_information(expected, [0.5, 0.5], np.random.default_rng(0), 4000)
    assert bounds.low - 0.03 <= told <= bounds.high + 0.03


def test_rivals_that_are_one_model_leave_nothing_to_learn(designed):
    measured, likely, _ = designed
    twins = [likely[0], replace(likely[0], name="twin")]
    ahead = following(measured, make(menu(BOUNDS)[NOISE], 1, 25.0).trajectory, 25.0, 10.0)
    expected = [Forecaster(one, measured, READING).expect(ahead)[0] for one in twins]
    assert information(expected, [0.5, 0.5]).high < 1e-9


def test_a_fresh_specimen_has_no_past_and_an_aged_one_all_of_it(designed):
    measured, _, found = designed
    fresh = following(measured, found.made.trajectory, 25.0, None)
    aged = following(measured, found.made.trajectory, 25.0, 10.0)
    assert len(aged.counts) - len(fresh.counts) == len(measured.counts) + round(10 / measured.dt_s)
    assert fresh.counts.sum() == aged.counts.sum()
    assert not aged.counts[: len(measured.counts)].any()


def test_motions_that_need_too_much_force_are_left_out(designed):
    measured, likely, _ = designed
    top = float(np.max(measured.measured["force"]))
    with pytest.raises(UserError, match="no motion keeps these limits"):
        best_motion(likely, measured, READING, BOUNDS, rest_s=10.0, trials=2, max_force_N=0.2 * top)


def test_one_hypothesis_is_no_question(designed):
    measured, likely, _ = designed
    with pytest.raises(UserError, match="two hypotheses or more, got 1"):
        best_motion(likely[:1], measured, READING, BOUNDS)


def test_a_short_motion_has_no_more_pieces_than_it_lasts(designed):
    """37 s count: they are 23 pieces of news, however many a recording may have at most."""
    measured, likely, _ = designed
    short = Trajectory(np.arange(801) / 20, 5 * np.abs(np.sin(np.arange(801) / 100)))
    ahead = following(measured, short, BOUNDS.gauge_length_mm, 10.0)
    news = measured.dt_s * ahead.counts.sum() / ALIKE_S
    (few, _), (many, _) = (
        Forecaster(likely[0], measured, replace(READING, pieces=pieces)).expect(ahead) for pieces in (news, 300.0)
    )
    assert many.mean == pytest.approx(few.mean)
    assert len(many.mean) == 2 * ahead.counts.sum()


def test_the_force_of_a_motion_is_not_that_of_what_came_before(designed):
    """A specimen that was pulled hard may still be pulled gently."""
    measured, likely, _ = designed
    gentle = Trajectory(np.arange(801) / 20, 0.5 * np.abs(np.sin(np.arange(801) / 100)))
    ahead = following(measured, gentle, BOUNDS.gauge_length_mm, 10.0)
    _, top_N = Forecaster(likely[0], measured, READING).expect(ahead)
    assert top_N < 0.3 * float(np.max(measured.measured["force"]))


def test_a_force_counts_either_way(designed):
    """A recording stops beyond its limit, whether pulled or pushed."""
    measured, likely, _ = designed
    push = Trajectory(np.arange(801) / 20, -2.5 * np.abs(np.sin(np.arange(801) / 100)))
    forecaster = Forecaster(likely[0], measured, READING)
    force_N = likely[0].model.simulate(following(measured, push, BOUNDS.gauge_length_mm, None).signals, measured.dt_s)
    assert force_N["force_N"].max() < 0.5 * np.abs(force_N["force_N"]).max()
    _, top_N = forecaster.expect(following(measured, push, BOUNDS.gauge_length_mm, None))
    assert top_N == pytest.approx(np.abs(force_N["force_N"]).max(), rel=0.01)


def test_in_a_rest_the_strain_goes_to_where_the_motion_begins(designed):
    """As in recordings that are joined."""
    measured, _, found = designed
    pulled = replace(measured, counts=measured.counts & (measured.signals["strain"] > 0.1))
    pulled = pulled.at(pulled.seen)
    ahead = following(pulled, found.made.trajectory, BOUNDS.gauge_length_mm, 10.0)
    rest = (ahead.signals["time_s"] > pulled.signals["time_s"][-1]) & (ahead.signals["time_s"] < ahead.begins_s[-1])
    assert np.abs(np.diff(ahead.signals["strain"][rest])).max() < 0.3 * ahead.dt_s / 10.0
    assert len(ahead.quieter) == len(ahead.strain_noise) == len(ahead.counts)
