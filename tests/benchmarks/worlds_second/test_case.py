"""One case: the same for one seed, whatever is hidden; honest about what is hidden."""

import numpy as np
import pytest
from worlds_second import LAW_FAMILIES, MECHANISMS, PROTOCOLS, make_case
from worlds_second.sensor import draw_sensor

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE

SHORT = {"minutes": 2.0, "rate_hz": 10.0}


def test_the_two_recordings_of_a_case_move_otherwise():
    case = make_case("none", seed=1, **SHORT)
    assert not np.allclose(case.calibration[DISPLACEMENT], case.held_out[DISPLACEMENT], atol=0.1)


@pytest.mark.parametrize(
    ("effect", "same"),
    [
        ("coating_cracks", FORCE),
        ("shoulder_peak", FORCE),
        ("contact_relaxation", FORCE),
        ("dead_band", FORCE),
        ("load_cell_creep", RESISTANCE),
        ("adc_saturation:force_clipped", RESISTANCE),
        ("swinging_cell", RESISTANCE),
    ],
)
def test_an_effect_changes_nothing_but_itself(effect, same):
    plain, case = (make_case(one, seed=4, **SHORT) for one in ("none", effect))
    assert plain.truth["base"] == case.truth["base"]
    changed = FORCE if same == RESISTANCE else RESISTANCE
    for before, after in ((plain.calibration, case.calibration), (plain.held_out, case.held_out)):
        np.testing.assert_array_equal(before.time_s, after.time_s)
        np.testing.assert_array_equal(before[DISPLACEMENT], after[DISPLACEMENT])
        np.testing.assert_array_equal(before[same], after[same])
    assert np.ptp(plain.calibration[changed] / case.calibration[changed]) > 0


@pytest.mark.parametrize("effect", ["stress_relaxation", "rate_resistance", "clamp_slip:one_yield", "clock_skew"])
@pytest.mark.parametrize("strength", [2.0, 20.0])
def test_strength_is_reached_or_reported(effect, strength):
    found = make_case(effect, strength, seed=1, minutes=6.0).truth["effects"][0]
    assert found["strength_requested"] == strength
    assert found["strength_reached"] == pytest.approx(strength, rel=0.2)
    parts = np.array(list(found["strength_by_channel"].values()))
    assert np.sqrt(np.mean(parts**2)) == pytest.approx(found["strength_reached"])


def test_what_is_out_of_reach_is_reported_as_such():
    found = make_case("temperature_drift", 1e6, seed=1, **SHORT).truth["effects"][0]
    assert found["strength_reached"] < 0.5 * found["strength_requested"]


@pytest.mark.parametrize(
    ("effect", "verdict", "count"),
    [
        ("none", "nothing_missing", 0),
        ("unknown", "unknown", 1),
        ("stick_slip", "unknown", 1),
        ("slack", "missing", 1),
        ("slack,coating_wear", "missing", 2),
        ("slack, stick_slip", "missing", 2),
        ("stick_slip,dead_band", "unknown", 2),
    ],
)
def test_verdict(effect, verdict, count):
    truth = make_case(effect, seed=5, **SHORT).truth
    assert truth["verdict"] == verdict
    assert len(truth["effects"]) == count
    for found in truth["effects"]:
        assert found["in_catalogue"] == (found["effect"] in MECHANISMS)


def test_nothing_named_draws_every_verdict():
    verdicts = [make_case(None, seed=seed, minutes=0.5, rate_hz=10.0).truth["verdict"] for seed in range(30)]
    assert set(verdicts) == {"missing", "unknown", "nothing_missing"}


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(("rate_hz", "minutes"), [(0.25, 60.0), (3.0, 5.0), (100.0, 1.0)])
def test_protocols_and_rates(protocol, rate_hz, minutes):
    case = make_case("stress_relaxation", seed=8, minutes=minutes, rate_hz=rate_hz, protocol=protocol)
    for recording in (case.calibration, case.held_out):
        assert recording.mean_rate_hz == pytest.approx(rate_hz, rel=0.01)
        assert recording.duration_s == pytest.approx(minutes * 60, rel=0.02)
        assert 0.5 < recording.strain.max() / case.truth["base"]["max_strain"] < 1.01
        assert recording.strain.min() > -0.01 * case.truth["base"]["max_strain"]


@pytest.mark.parametrize("channel", [FORCE, RESISTANCE])
@pytest.mark.parametrize("seed", range(4))
def test_one_channel(channel, seed):
    case = make_case(None, seed=seed, channels=[channel], **SHORT)
    assert set(case.calibration.channels) == {DISPLACEMENT, channel}
    assert set(case.truth["noise_floor"]) == {{FORCE: "force", RESISTANCE: "conductance"}[channel]}
    with pytest.raises(UserError, match="record the other channel"):
        make_case("coating_wear" if channel == FORCE else "load_cell_creep", channels=[channel], **SHORT)


def test_a_thermometer_shows_the_room_that_acts():
    case = make_case(
        "temperature_drift:with_the_room", 30.0, seed=2, channels=[FORCE, RESISTANCE, TEMPERATURE], rate_hz=4.0
    )
    plain = make_case("none", seed=2, rate_hz=4.0)
    change = np.log(case.calibration[RESISTANCE] / plain.calibration[RESISTANCE])
    assert abs(np.corrcoef(change, case.calibration[TEMPERATURE])[0, 1]) > 0.99


def test_all_laws_are_drawn():
    bases = [draw_sensor(seed).described() for seed in range(100)]
    for family, names in LAW_FAMILIES.items():
        assert {base[family]["law"] for base in bases} == set(names), family
    strains = [base["max_strain"] for base in bases]
    assert min(strains) < 0.03
    assert max(strains) > 0.8
