"""Noise is what the truth says it is."""

import numpy as np
import pytest
from worlds_second import make_case
from worlds_second.noise import KINDS, draw_kind, draw_noise

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE


@pytest.mark.parametrize("noise", [0.5, 1.0, 10.0])
@pytest.mark.parametrize("seed", range(5))
def test_floors_are_the_noise_of_the_recordings(noise, seed):
    loud, quiet = (make_case("none", seed=seed, noise=one, minutes=3.0) for one in (noise, 1e-9))
    floor = loud.truth["noise_floor"]
    assert floor == pytest.approx({"force": 5e-3 * noise, "conductance": 8e-4 * noise})
    for one, other in ((loud.calibration, quiet.calibration), (loud.held_out, quiet.held_out)):
        force, ln_r = one[FORCE] - other[FORCE], np.log(one[RESISTANCE] / other[RESISTANCE])
        way = one[DISPLACEMENT] - other[DISPLACEMENT]
        assert np.sqrt(np.mean(force**2)) == pytest.approx(floor["force"], rel=1e-3)
        assert np.sqrt(np.mean(ln_r**2)) == pytest.approx(floor["conductance"], rel=1e-3)
        assert np.sqrt(np.mean(way**2)) == pytest.approx(loud.truth["displacement_noise_mm"], rel=1e-3)
        assert loud.truth["displacement_noise_mm"] <= 1e-3 * noise


@pytest.mark.parametrize("kind", KINDS)
def test_colour_is_mild(kind):
    noise = draw_noise(np.random.default_rng(0), 20_000, 1.0, kind, 0.025)
    neighbours = np.mean(noise[1:] * noise[:-1])
    assert np.sqrt(np.mean(noise**2)) == pytest.approx(1.0)
    assert abs(neighbours) < 0.02 if kind == "white" else 0.01 < neighbours < 0.15


def test_all_kinds_are_drawn():
    assert {draw_kind(seed) for seed in range(40)} == set(KINDS)
