"""Strength is what the base cannot absorb."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_case import stream
from worlds_second import make_case
from worlds_second.protocols import draw_motion
from worlds_second.rig import Rig
from worlds_second.sensor import draw_sensor
from worlds_second.strength import make_absorber, reach

from testbench.recordings.channels import FORCE, RESISTANCE


def rig_of(seed):
    motions = [draw_motion(stream(seed, "motion", "perlin", str(i)), "perlin", 3.0, 20.0, i) for i in (0, 1)]
    return Rig(draw_sensor(seed), seed, 1.0, motions, (FORCE, RESISTANCE))


@pytest.mark.parametrize("seed", range(6))
def test_another_base_of_the_same_laws_is_no_effect(seed):
    """A small change of any parameter is absorbed; the same change is far above the floor before."""
    rig = rig_of(seed)
    base = rig.clean([])
    for sensor, _ in rig.sensor.stepped(2e-3):
        moved = rig.clean([], sensor)
        change = {name: moved[name] - base[name] for name in rig.floors}
        assert rig._absorber.left(change)["both"] < 0.1


def test_the_strength_is_that_of_a_plain_least_squares_fit():
    """The same figure from recordings alone: their difference, fitted with NumPy's own least squares."""
    arguments = {"seed": 4, "minutes": 3.0, "rate_hz": 20.0}
    plain, case = (make_case(effect, **arguments) for effect in ("none", "stress_relaxation"))
    floors = plain.truth["noise_floor"]
    rig = rig_of(4)
    base = rig.clean([])
    change = np.concatenate(
        [
            (case.calibration[FORCE] - plain.calibration[FORCE]) / floors["force"],
            np.log(plain.calibration[RESISTANCE] / case.calibration[RESISTANCE]) / floors["conductance"],
        ]
    )
    columns = []
    for sensor, step in rig.sensor.stepped(1e-3):
        moved = rig.clean([], sensor)
        columns.append(np.concatenate([(moved[name] - base[name]) / step / floors[name] for name in floors]))
    x, late = rig.motions[0].x, np.log1p(rig.motions[0].t / 10.0)
    for shape in (*(x**k for k in range(4)), *(late**k for k in range(1, 4))):
        columns += [np.r_[shape, 0 * shape], np.r_[0 * shape, shape]]
    basis = np.stack([c / np.linalg.norm(c) for c in columns if np.any(c)], axis=1)
    left = change - basis @ np.linalg.lstsq(basis, change, rcond=1e-7)[0]
    reached = case.truth["effects"][0]["strength_reached"]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(reached, rel=0.02)


def test_an_absorber_takes_shapes_over_strain_and_time_and_leaves_the_rest():
    rng = np.random.default_rng(0)
    x, time_s = rng.random(2000), np.arange(2000) / 10.0
    base = {"force": np.zeros(2000)}
    absorber = make_absorber(base, [({"force": np.sin(9 * x)}, 1.0)], x, time_s, {"force": 0.5})
    taken = 3 * np.sin(9 * x) + x**3 - x + np.log1p(time_s / 10.0) ** 2
    noise = rng.normal(size=2000)
    assert absorber.left({"force": taken})["both"] < 1e-6
    assert absorber.left({"force": taken + noise})["both"] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("power", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_reach_finds_the_magnitude(power, scale):
    magnitude = reach(5.0, 10.0, lambda m: scale * m**power)
    top = scale * 10.0**power
    assert scale * magnitude**power == pytest.approx(min(5.0, top), rel=0.05)


def test_reach_finds_the_first_of_two_and_the_top_of_a_hill():
    assert reach(5.0, 1.0, lambda m: 400.0 * m * (1.0 - m)) == pytest.approx(0.0127, rel=0.05)
    assert reach(50.0, 1.0, lambda m: 40.0 * m * (1.0 - m)) == pytest.approx(0.5, abs=0.25)


def test_stepped_moves_every_parameter_once():
    sensor = draw_sensor(0)
    count = 3 + sum(len(law.parameters) for law in sensor.laws.values())
    moved = sensor.stepped(1e-3)
    assert len(moved) == count
    assert len({repr(one) for one, _ in moved} | {repr(replace(sensor))}) == count + 1
