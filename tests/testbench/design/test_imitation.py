"""The measurement that was not made yet, and how closely a model imitates another on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcode.trajectories.trajectory import Trajectory
from testbench.design.ahead import planned
from testbench.design.imitation import Rival, imitate
from testbench.design.protocols import Bounds, drivable
from testbench.fitting import constants
from testbench.fitting.evidence.independent_samples import independent_share
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import known_noise
from tests.testbench.builders import CATALOGUE, GAUGE_LENGTH_MM, NOISE_LN, NOISE_N, truth

FLOORS = {"force": NOISE_N, "conductance": NOISE_LN}


def test_a_planned_measurement_has_the_motion_and_nothing_else():
    motion = Trajectory(np.arange(200) / 20, np.linspace(0, 5, 200))
    measurement = planned(motion, 25.0, ("force",))
    assert measurement.signals["strain"] == pytest.approx(motion.position_mm / 25)
    assert measurement.channels == ("force",)
    assert measurement.counts.sum() == 200 - 60
    assert "temperature_C" not in measurement.signals


def test_a_temperature_that_will_be_measured_swings_by_a_kelvin():
    time_s = np.arange(40_001) / 20
    room = planned(Trajectory(time_s, 0 * time_s), 25.0, ("force",), temperature=True).signals["temperature_C"]
    assert len(room) == len(time_s)
    assert np.ptp(room) == pytest.approx(2, rel=1e-3)
    assert np.abs(np.diff(room)).max() < 0.001  # and goes on where a period ends


@pytest.fixture(scope="module")
def new_heights():
    made = drivable(Bounds(duration_s=120), 1)["new-heights"]
    return planned(made.trajectory, GAUGE_LENGTH_MM, tuple(FLOORS))


def test_a_law_imitates_itself_from_far_away(new_heights):
    model = truth().plus(CATALOGUE["permanent_set"]())
    moved = {"elasticity.stiffness_N": 9.0, "hysteresis.friction_N": 0.1, "contact.contact_resistance_ohm": 1500.0}
    away = imitate(Rival("here", model), Rival("there", model.with_parameters(moved)), new_heights, FLOORS)
    assert away.log_odds < 0.1
    assert (away.truth, away.imitator) == ("here", "there")


def test_what_no_law_of_the_imitator_does_is_left(new_heights):
    relaxing = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.3))
    found = imitate(Rival("relaxing", relaxing), Rival("base", truth()), new_heights, {"force": NOISE_N})
    assert found.channel == "force"
    assert found.log_odds > 5
    assert found.left["force"].mean() == pytest.approx(0, abs=1e-9)


def test_a_search_looks_with_the_noise_that_is_known(new_heights):
    """However far a rival is away, what it leaves is no noise."""
    relaxing = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.4))
    measured = new_heights.modelled(relaxing)
    known = known_noise(replace(new_heights, measured=measured), FLOORS)
    found = fitted(truth(), known, truth())
    assert found.evidence.sigma == FLOORS
    assert found.tails == 0

    def left(model):
        off = {c: (measured[c] - v)[new_heights.counts] / FLOORS[c] for c, v in new_heights.modelled(model).items()}
        return 0.5 * independent_share(new_heights) * sum(float(np.sum((v - v.mean()) ** 2)) for v in off.values())

    taken_for_noise = fitted(truth(), replace(known, is_known=False), truth()).model
    imitation = imitate(Rival("relaxing", relaxing), Rival("base", truth()), new_heights, FLOORS)
    assert imitation.log_odds < 0.9 * left(taken_for_noise)


def test_a_recording_counts_as_many_pieces_as_the_diagnosis_compares_models_by(new_heights):
    relaxing = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.3))
    found = imitate(Rival("relaxing", relaxing), Rival("base", truth()), slower(new_heights, 4), {"force": NOISE_N})
    assert found.log_odds == pytest.approx(0.5 * constants.INDEPENDENT * found.noise_units**2)


def slower(measurement, times: int):
    """The same motion, so many times as long."""
    time_s = times * measurement.signals["time_s"]
    return replace(measurement, signals={**measurement.signals, "time_s": time_s}, dt_s=times * measurement.dt_s)
