"""Cases of the fourth simulator: the same every time, with the noise asked for, each seed a sensor of its own."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_fourth import make_case

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE

SHORT = {"minutes": 2.0}


def test_the_recordings_are_of_one_sensor_and_move_on_their_own() -> None:
    case = make_case("none", 5.0, 3, **SHORT)
    for recording in (case.calibration, case.held_out):
        assert recording.duration_s == pytest.approx(120, rel=0.03)
        assert recording.mean_rate_hz == pytest.approx(41, rel=0.06)
        assert recording.strain.max() == pytest.approx(case.truth["base"]["max_strain"], rel=0.05)
        assert np.all(recording[RESISTANCE] > 0)
    assert not np.array_equal(case.calibration[DISPLACEMENT][:1000], case.held_out[DISPLACEMENT][:1000])


@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
def test_it_can_be_sampled_slower_and_faster(rate_hz: float) -> None:
    assert make_case("none", 5.0, 3, rate_hz=rate_hz, **SHORT).held_out.mean_rate_hz == pytest.approx(
        rate_hz, rel=0.06
    )


def test_one_channel_alone() -> None:
    force = make_case("stress_relaxation", 2.0, 1, channels=[FORCE], **SHORT)
    assert list(force.calibration.channels) == [DISPLACEMENT, FORCE]
    assert list(force.truth["noise_floor"]) == ["force"]
    for seed in range(8):  # the contacts feel the force, so an effect on it can be seen
        case = make_case("stress_relaxation", 1.0, seed, channels=[RESISTANCE], **SHORT)
        assert case.truth["effects"][0]["strength_reached"] > 0.3
        assert case.truth["effects"][0]["main_channel"] == "conductance"
