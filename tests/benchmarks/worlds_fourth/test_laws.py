"""Base laws of the fourth simulator are physically plausible, whatever numbers are drawn for them."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_fourth import LAW_FAMILIES
from worlds_fourth.laws import DRIFTS, drift_of
from worlds_fourth.laws.courses import COURSES
from worlds_fourth.laws.elasticity import CURVES, Elasticity
from worlds_fourth.motion import make_motion
from worlds_fourth.randoms import stream
from worlds_fourth.specimen import draw_specimen

SPECIMENS = [draw_specimen(seed) for seed in range(120)]
END = 0.5
STRAIN = np.linspace(-0.05, 1.05 * END, 500)
CYCLES = END * np.interp(np.linspace(0, 6, 1801), range(7), [0, 1, 0, 0.7, 0.2, 1, 0])


def test_all_laws_are_drawn() -> None:
    told = [specimen.told() for specimen in SPECIMENS]
    for family, names in LAW_FAMILIES.items():
        assert {base[family]["law"] for base in told} == set(names), family
    assert {specimen.end for specimen in SPECIMENS} == {0.3, 0.5}


@pytest.mark.parametrize("name", CURVES)
def test_the_elastic_force_rises_from_rest_to_its_top(name: str) -> None:
    for seed in range(12):
        curve = CURVES[name](stream(seed, name), END)
        force = Elasticity(name, curve, END, 0.1, 3.0).force_N(STRAIN)
        assert np.all(np.diff(force) > 0)
        assert np.interp(0.0, STRAIN, force) == pytest.approx(0.1, abs=0.02)
        assert np.interp(END, STRAIN, force) == pytest.approx(3.0, rel=1e-3)


def test_friction_takes_work_and_stays_below_the_force() -> None:
    for specimen in SPECIMENS:
        strain = CYCLES * specimen.end / END
        elastic = specimen.elasticity.force_N(strain)
        loop = specimen.friction.loop_N(strain, elastic)
        work = np.sum(0.5 * (loop[1:] + loop[:-1]) * np.diff(strain))
        assert work > 0, specimen.friction.text
        assert np.abs(loop).max() < 0.3 * specimen.top_N


def test_the_conductance_goes_the_way_that_was_drawn() -> None:
    for specimen in SPECIMENS:
        conduction = specimen.conduction
        assert 0.3 <= conduction.range <= 1.5
        strain = np.linspace(0, specimen.end, 60)
        share = conduction.strain_share
        force = specimen.elasticity.force_N(strain) / specimen.top_N
        curve = conduction.log_g(share * strain / specimen.end + (1 - share) * force, strain)
        ends = sorted((curve[0], curve[-1]))
        bent = curve.max() > ends[1] + 0.04 or curve.min() < ends[0] - 0.04
        course = "bend" if bent else "rise" if curve[-1] > curve[0] else "fall"
        assert course == conduction.course, conduction.text
    assert {specimen.conduction.course for specimen in SPECIMENS} == set(COURSES)


@pytest.mark.parametrize("name", DRIFTS)
def test_drift_is_about_as_high_as_was_drawn(name: str) -> None:
    time_s = np.arange(0, 360, 0.025)
    share = 0.5 + 0.5 * np.sin(time_s)
    heights = [np.ptp(drift_of(name, "all", 0.01, stream(seed, name), time_s, share)) for seed in range(20)]
    assert 1e-4 < np.median(heights) < 0.04


@pytest.mark.parametrize("seed", range(4))
def test_a_motion_uses_its_stroke_within_the_limits_of_the_carriage(seed: int) -> None:
    time_s, displacement_mm = make_motion(seed, "calibration", END, 3.0)
    assert time_s[0] == 0
    assert time_s[-1] == pytest.approx(180, abs=4)
    assert np.all(np.diff(time_s) > 0)
    assert 0 <= displacement_mm.min() < 0.01
    assert 0.95 * 12.5 < displacement_mm.max() <= 12.5
    assert np.abs(np.gradient(displacement_mm, time_s)).max() < 9.0
    fast = make_motion(seed, "calibration", END, 3.0, 80.0)[0]
    assert len(fast) == pytest.approx(2 * len(time_s), rel=0.01)
