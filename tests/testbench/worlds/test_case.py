"""A case is what it says: reproducible, of the strength asked for, different from its base by its effect alone."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.optimize import least_squares

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.worlds import CATALOGUE, OUTSIDE, make_case
from testbench.worlds.base import WORLDS, draw_world
from testbench.worlds.case import Bench, choose, rng_of
from testbench.worlds.effects import FORMS

SHORT = {"minutes": 4.0, "rate_hz": 20.0}
ALL = [(effect, form) for effect, forms in FORMS.items() for form in forms]
# what the base absorbs itself, or what a plausible magnitude does not bring to 5 (a room hardly warms in 4 minutes)
WEAK = {"contact_saturation", "mullins_softening", "adc_saturation", "temperature_drift"}


def test_the_same_seed_makes_the_same_case():
    one, two = (make_case("mullins_softening", 5, "mismatched", 7, **SHORT) for _ in range(2))
    assert one.truth == two.truth
    for name, values in one.held_out.channels.items():
        assert np.array_equal(values, two.held_out[name])


def test_another_seed_makes_another_sensor_and_motion():
    one, two = (make_case("none", 5, "matched", seed, **SHORT) for seed in (1, 2))
    assert one.truth["base"] != two.truth["base"]
    assert not np.array_equal(one.calibration[DISPLACEMENT], two.calibration[DISPLACEMENT])


def test_calibration_and_held_out_are_two_trajectories_of_one_sensor():
    case = make_case("none", **SHORT)
    assert not np.array_equal(case.calibration[DISPLACEMENT], case.held_out[DISPLACEMENT])
    noise_mm = case.truth["displacement_noise_mm"]
    assert max(abs(part[DISPLACEMENT][0]) for part in (case.calibration, case.held_out)) < 5 * noise_mm


@pytest.mark.parametrize(("effect", "form"), ALL)
def test_the_strength_asked_for_is_reached_or_said_not_to_be(effect, form):
    entries = [make_case(effect, 5, "matched", seed, form=form, **SHORT).truth["effects"][0] for seed in (3, 4, 6, 8)]
    for entry in entries:
        assert entry["strength_reached"] <= 6
        assert entry["reached"] == (abs(entry["strength_reached"] / 5 - 1) <= 0.2)
        assert entry["magnitude"] <= FORMS[effect][form].most
    assert any(entry["reached"] for entry in entries) or effect in WEAK


@pytest.mark.parametrize("strength", [2, 15])
@pytest.mark.parametrize("world", WORLDS)
def test_weak_and_strong_in_every_world(world, strength):
    entry = make_case("channel_lag", strength, world, 5, **SHORT).truth["effects"][0]
    assert entry["strength_reached"] == pytest.approx(strength, rel=0.2)


def test_none_differs_from_an_effect_by_the_effect_alone():
    """One seed: same motion, same base, same noise; so a read-out effect on resistance leaves force as it was."""
    plain = make_case("none", 5, "mismatched", 9, **SHORT)
    lag = make_case("channel_lag", 5, "mismatched", 9, form="late_resistance", **SHORT)
    assert np.array_equal(plain.calibration.time_s, lag.calibration.time_s)
    assert np.array_equal(plain.calibration[FORCE], lag.calibration[FORCE])
    assert not np.array_equal(plain.calibration[RESISTANCE], lag.calibration[RESISTANCE])
    assert plain.truth["base"] == lag.truth["base"]
    assert plain.truth["noise_floor"] == lag.truth["noise_floor"]


def test_the_noise_floor_in_the_truth_is_the_noise_in_the_recording():
    case = make_case("none", 5, "mismatched", 11, **SHORT)
    bench = Bench(draw_world("mismatched", rng_of(11, "base", "mismatched")), 11, 4.0, 20.0, "any", "perlin")
    force, ln_g = bench.signals("held_out", ())
    noise_N = case.held_out[FORCE] - force
    noise_ln = np.log(case.held_out.conductance_S) - ln_g
    assert np.sqrt(np.mean(noise_N**2)) == pytest.approx(case.truth["noise_floor"]["force"], rel=0.03)
    assert np.sqrt(np.mean(noise_ln**2)) == pytest.approx(case.truth["noise_floor"]["conductance"], rel=0.05)


@pytest.mark.parametrize(("effect", "form"), [("channel_lag", "late_force"), ("stress_relaxation", "one_time")])
def test_a_real_refit_of_the_base_leaves_the_strength(effect, form):
    """The definition is a linear projection; least squares on all base parameters must agree with it."""
    base = draw_world("matched", rng_of(2, "base", "matched"))
    bench = Bench(base, 2, 4.0, 20.0, "white", "perlin")
    one, shape = choose(effect, form, 2, base)
    hidden = bench.scale(one, shape, 5.0)
    seen = bench.whitened("calibration", [hidden])
    names = [(law, p) for law, laws in base.laws().items() for p in laws.parameters]
    start = np.array([base.laws()[law].parameters[p] for law, p in names])

    def residual(factors: np.ndarray) -> np.ndarray:
        world = base
        for (law, p), value in zip(names, start * factors, strict=True):
            world = world.varied(law, p, float(value))
        return bench.whitened("calibration", (), world) - seen

    fit = least_squares(residual, np.ones_like(start), bounds=(0.3, 3), max_nfev=15)
    assert np.sqrt(np.mean(fit.fun**2)) == pytest.approx(5.0, rel=0.2)


def test_two_effects_have_the_strength_each():
    truth = make_case("channel_lag, permanent_set", 5, "matched", 4, **SHORT).truth
    assert [entry["effect"] for entry in truth["effects"]] == ["channel_lag", "permanent_set"]
    assert all(entry["reached"] for entry in truth["effects"])
    assert truth["joint_strength"] > 5
    assert truth["verdict"] == "missing"


def test_unknown_draws_an_effect_that_is_in_no_catalogue():
    truth = make_case("unknown", 5, "matched", 4, **SHORT).truth
    assert truth["verdict"] == "unknown"
    assert truth["effects"][0]["effect"] in OUTSIDE


def test_no_catalogue_effect_bears_the_name_of_an_outside_one():
    from testbench.knit.catalogue import load_catalogue

    known = load_catalogue().mechanisms()
    assert not set(OUTSIDE) & set(known)
    assert set(CATALOGUE) <= set(known)


def test_left_out_the_effect_is_drawn_by_seed_and_varies():
    drawn = {tuple(e["effect"] for e in make_case(None, 5, "matched", s, **SHORT).truth["effects"]) for s in range(8)}
    assert len(drawn) >= 4


def test_measured_temperature_is_recorded_and_explains():
    case = make_case("temperature_drift", 5, "matched", 1, form="measured", **SHORT)
    plain = make_case("none", 5, "matched", 1, **SHORT)
    change = np.log(case.calibration.conductance_S / plain.calibration.conductance_S)
    assert abs(np.corrcoef(change, case.calibration[TEMPERATURE])[0, 1]) > 0.9


def test_unmeasured_temperature_is_not_recorded():
    assert not make_case("temperature_drift", form="conductance_only", **SHORT).calibration.has(TEMPERATURE)


def test_force_only_recordings():
    case = make_case("stress_relaxation", channels=(FORCE,), **SHORT)
    assert set(case.calibration.channels) - {TEMPERATURE} == {DISPLACEMENT, FORCE}


@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
def test_other_sampling_rates(rate_hz):
    case = make_case("stress_relaxation", rate_hz=rate_hz, minutes=3)
    assert case.calibration.mean_rate_hz == pytest.approx(rate_hz, rel=0.01)
    assert case.truth["effects"][0]["reached"]


def test_the_truth_is_plain_json():
    truth = make_case("cyclic_fatigue", **SHORT).truth
    assert json.loads(json.dumps(truth, allow_nan=False)) == truth


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"effect": "gremlins"}, "no effect 'gremlins' to hide; choose from"),
        ({"effect": "channel_lag,channel_lag"}, "names one effect twice"),
        ({"effect": "none,channel_lag"}, "none cannot be joined"),
        ({"effect": "channel_lag", "form": "odd"}, "channel_lag has the forms"),
        ({"world": "flat"}, "world: must be one of matched"),
        ({"noise": "loud"}, "noise: must be one of white"),
        ({"protocol": "jump"}, "protocol: must be one of perlin"),
        ({"strength": 0.0}, "strength: must be a positive number"),
        ({"strength": float("nan")}, "strength: must be a positive number"),
        ({"minutes": 0.01}, "under 200 samples"),
        ({"rate_hz": 1e300}, "more than the 20000000 samples"),
        ({"minutes": 1e300}, "more than the 20000000 samples"),
        ({"seed": -1}, "seed: must be"),
        ({"channels": ("voltage_V",)}, "channels: must be"),
    ],
)
def test_bad_requests_are_refused_in_one_sentence(arguments, message):
    with pytest.raises(UserError, match=message):
        make_case(**arguments)
