"""One case: the same for one seed, whatever is hidden; honest about what is hidden."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from worlds_second import LAW_FAMILIES, MECHANISMS, PROTOCOLS, make_case

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


def test_truth_is_ready_for_json():
    truth = make_case("slack,crosstalk", seed=3, only_laws={"drift": ("power",)}, leave_out=("fung",), **SHORT).truth
    assert json.loads(json.dumps(truth)) == truth
    assert truth["recipe"]["only_laws"] == {"drift": ["power"]}


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


def test_clamped_anew_has_other_zeros():
    plain, anew = (make_case("none", seed=6, reclamped=flag, **SHORT) for flag in (False, True))
    np.testing.assert_array_equal(plain.calibration[FORCE], anew.calibration[FORCE])
    np.testing.assert_array_equal(plain.held_out[DISPLACEMENT], anew.held_out[DISPLACEMENT])
    assert np.mean(np.abs(plain.held_out[FORCE] - anew.held_out[FORCE])) > plain.truth["noise_floor"]["force"]


@pytest.mark.parametrize("max_strain", [0.015, 1.5])
def test_stiff_and_soft(max_strain):
    case = make_case("none", seed=9, max_strain=max_strain, **SHORT)
    assert np.ptp(case.calibration.strain) == pytest.approx(max_strain, rel=0.1)


@settings(max_examples=15, deadline=None)
@given(st.sampled_from([(f, name) for f, names in LAW_FAMILIES.items() for name in names]), st.integers(0, 1000))
def test_laws_are_restricted_and_others_stay(member, seed):
    family, name = member
    plain, only = (make_case("none", seed=seed, only_laws=one, **SHORT) for one in (None, {family: [name]}))
    assert only.truth["base"][family]["law"] == name
    gone = make_case("none", seed=seed, leave_out=f"{family}:{name}", **SHORT)
    assert gone.truth["base"][family]["law"] != name
    for other in set(LAW_FAMILIES) - {family}:
        assert plain.truth["base"][other] == only.truth["base"][other] == gone.truth["base"][other]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"effect": "magic"}, "none of none, unknown"),
        ({"effect": "slack:magic"}, "slack has the forms loose"),
        ({"effect": "slack,none"}, "none stands alone"),
        ({"effect": "slack,slack,slack"}, "at most two"),
        ({"effect": "none", "protocol": "walk"}, "protocol must be one of perlin"),
        ({"effect": "none", "channels": ["force"]}, "channels must name force_N"),
        ({"effect": "none", "channels": [TEMPERATURE]}, "channels must name force_N"),
        ({"effect": "none", "strength": 0.0}, "strength must be a positive"),
        ({"effect": "none", "noise": 0.0}, "noise must be positive"),
        ({"effect": "none", "seed": -1}, "seed must not be negative"),
        ({"effect": "none", "minutes": 0.01}, "at least 50 samples"),
        ({"effect": "none", "max_strain": 50.0}, "max_strain must lie between"),
        ({"effect": "none", "only_laws": {"magic": ["fung"]}}, "no family magic"),
        ({"effect": "none", "only_laws": {"drift": ["fung"]}}, "drift has logarithmic"),
        ({"effect": "none", "leave_out": "magic"}, "no law magic"),
        ({"effect": "none", "only_laws": {"drift": ["power"]}, "leave_out": "power"}, "no law is left"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(UserError, match=message):
        make_case(**{**SHORT, **arguments})
