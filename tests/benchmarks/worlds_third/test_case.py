"""Cases of the third simulator: the same every time, with the noise asked for, over the whole range promised."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_third import LAW_FAMILIES, PROTOCOLS, make_case
from worlds_third.case import _Rig
from worlds_third.sensor import make_sensor
from worlds_third.strength import Absorption

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE

SHORT = {"minutes": 3.0, "rate_hz": 20.0}


def test_all_kinds_of_noise_are_drawn() -> None:
    kinds = {make_case("none", 5.0, seed, minutes=1, rate_hz=10).truth["noise_kind"] for seed in range(40)}
    assert kinds == {"white", "heavy_tailed", "divider"}


def test_the_displacement_comes_in_steps_of_the_motor() -> None:
    case = make_case("none", 5.0, 3, **SHORT)
    step_mm = case.truth["displacement_noise_mm"] * np.sqrt(12)
    steps = case.calibration[DISPLACEMENT] / step_mm
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert 1e-3 < step_mm < 0.01


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(("minutes", "rate_hz"), [(20.0, 0.25), (3.0, 20.0), (1.5, 100.0)])
def test_any_rate_motion_and_stroke(protocol: str, minutes: float, rate_hz: float) -> None:
    case = make_case("none", 5, 11, minutes=minutes, rate_hz=rate_hz, protocol=protocol)
    for recording in (case.calibration, case.held_out):
        assert recording.duration_s == pytest.approx(minutes * 60, rel=0.02)
        assert recording.mean_rate_hz == pytest.approx(rate_hz, rel=0.02)
        assert recording.strain.max() == pytest.approx(case.truth["base"]["max_strain"], rel=0.1)
        assert recording.strain.min() > -0.01 * case.truth["base"]["max_strain"]
        assert np.all(recording[RESISTANCE] > 0)
    assert not np.array_equal(case.calibration[DISPLACEMENT], case.held_out[DISPLACEMENT])


@pytest.mark.parametrize("seed", range(10))
def test_force_rises_with_strain_and_is_hardly_ever_a_push(seed: int) -> None:
    recording = make_case("none", 5.0, seed, **SHORT).calibration
    order = np.argsort(recording.strain)
    low, high = (float(np.mean(recording[FORCE][part])) for part in (order[:200], order[-200:]))
    assert high > low + 1.0
    assert recording[FORCE].min() > -0.12 * recording[FORCE].max()


def test_all_laws_are_drawn() -> None:
    bases = [make_case("none", 5.0, seed, minutes=1.0, rate_hz=10.0).truth["base"] for seed in range(40)]
    for family, names in LAW_FAMILIES.items():
        assert {base[family]["law"] for base in bases} == set(names), family
    strains = np.array([base["max_strain"] for base in bases])
    assert strains.min() < 0.1
    assert strains.max() > 0.6


def test_one_channel_alone_and_the_room() -> None:
    force = make_case("stress_relaxation", 5.0, 1, channels=[FORCE], **SHORT)
    assert list(force.calibration.channels) == [DISPLACEMENT, FORCE]
    assert list(force.truth["noise_floor"]) == ["force"]
    room = make_case("temperature_drift:wandering_room", 5.0, 1, channels=[RESISTANCE, TEMPERATURE], **SHORT)
    plain = make_case("none", 5.0, 1, channels=[RESISTANCE, TEMPERATURE], **SHORT)
    change = np.log(room.calibration[RESISTANCE] / plain.calibration[RESISTANCE])
    assert abs(np.corrcoef(change, room.calibration[TEMPERATURE])[0, 1]) > 0.99


def test_contacts_are_pressed_by_the_force_unless_other_laws_are_asked_for() -> None:
    drives = [make_sensor(1, asked, pressed_by_force=True).laws["drive"].name for asked in ("", "drive=by_strain")]
    assert drives == ["by_force", "by_strain"]


def test_another_zero_of_the_displacement_is_no_effect_in_a_sensor_clamped_anew() -> None:
    rig = _Rig(make_sensor(3), 3, 2.0, 20.0, "perlin", reclamped=True)
    changed = rig.run([])
    changed[1].force = changed[1].force + 0.1 + 0.2 * changed[1].drive
    plain, anew = (Absorption(rig.base, {"force": 1e-3}, again).left(changed)["force"] for again in (False, True))
    assert plain > 10.0
    assert anew == pytest.approx(0.0, abs=1e-6)
