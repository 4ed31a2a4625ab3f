"""What holds for the second, third and fourth simulator alike: the same every time, with the noise asked for."""

from __future__ import annotations

import json

import numpy as np
import pytest
import worlds_fourth
import worlds_second
import worlds_third
from hypothesis import given, settings
from hypothesis import strategies as st

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE

SIMULATORS = (worlds_second, worlds_third, worlds_fourth)
SHORT = {"minutes": 2.0, "rate_hz": 20.0}


def same(one, other) -> bool:
    """Whether two cases have the same recordings, to the last digit."""
    pairs = ((one.calibration, other.calibration), (one.held_out, other.held_out))
    return all(
        np.array_equal(a.time_s, b.time_s) and all(np.array_equal(a[name], b[name]) for name in a.channels)
        for a, b in pairs
    )


def name_of(simulator) -> str:
    return simulator.__name__


@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_a_seed_is_a_case(simulator) -> None:
    @settings(max_examples=4, deadline=None)
    @given(st.integers(0, 2**31), st.sampled_from([*simulator.MECHANISMS, *simulator.UNKNOWN_KINDS, None]))
    def check(seed: int, effect: str | None) -> None:
        one, again = (simulator.make_case(effect, 5.0, seed, **SHORT) for _ in range(2))
        assert same(one, again)
        assert one.truth == again.truth == json.loads(json.dumps(one.truth))

    check()


@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_another_seed_is_another_sensor(simulator) -> None:
    one, other = (simulator.make_case("none", seed=seed, **SHORT) for seed in (1, 2))
    assert not same(one, other)
    assert one.truth["base"] != other.truth["base"]


@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_nothing_is_hidden_where_nothing_is_asked_for(simulator) -> None:
    weak, strong = (simulator.make_case("none", strength, 8, **SHORT) for strength in (5.0, 15.0))
    assert same(weak, strong)
    assert weak.truth["verdict"] == "nothing_missing"
    assert weak.truth["effects"] == []


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_the_noise_is_as_asked(simulator, seed: int) -> None:
    """Motion and sensor are the same, so what differs is noise: 10 times less 1 time."""
    quiet, loud = (
        simulator.make_case("none", 5.0, seed, noise=noise, minutes=3.0, rate_hz=20.0) for noise in (1.0, 10.0)
    )
    for one, other in ((quiet.calibration, loud.calibration), (quiet.held_out, loud.held_out)):
        assert np.std(other[FORCE] - one[FORCE]) == pytest.approx(9 * 0.005, rel=0.06)
        assert np.std(np.log(other[RESISTANCE] / one[RESISTANCE])) == pytest.approx(9 * 8e-4, rel=0.06)
    assert loud.truth["noise_floor"] == pytest.approx({"force": 0.05, "conductance": 8e-3})


@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_what_no_catalogue_has_is_no_mechanism_of_it(simulator) -> None:
    assert not set(simulator.MECHANISMS) & set(simulator.UNKNOWN_KINDS)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"effect": "gremlins"}, "no effect 'gremlins'; there are none, unknown, permanent_set"),
        ({"effect": "slack:purple"}, "slack has no form 'purple'; it has "),
        ({"effect": "slack,none"}, "none stands alone, got slack,none"),
        ({"effect": "slack,slack,slack"}, "at most 2 effects at once, got 3"),
        ({"protocol": "waltz"}, "no protocol 'waltz'; there are "),
        ({"rate_hz": 1e-3}, "rate_hz must be between "),
        ({"minutes": 0.01}, "minutes must be between "),
        ({"strength": -1.0}, "strength must be between "),
        ({"noise": float("nan")}, "noise must be between "),
        ({"seed": -1}, "seed must not be negative, got -1"),
        ({"channels": ["pressure_Pa"]}, "one of the first two at least; got pressure_Pa"),
        ({"channels": []}, "got none"),
        ({"effect": "self_heating", "channels": [FORCE]}, "record"),
        ({"effect": "load_cell_creep", "channels": [RESISTANCE]}, "record"),
    ],
    ids=str,
)
@pytest.mark.parametrize("simulator", SIMULATORS, ids=name_of)
def test_what_makes_no_sense_is_said(simulator, arguments: dict[str, object], said: str) -> None:
    with pytest.raises(UserError, match="make_case: ") as error:
        simulator.make_case(**{"effect": "none", **SHORT, **arguments})
    assert said in str(error.value)


@pytest.mark.parametrize("simulator", SIMULATORS[:2], ids=name_of)
def test_a_sensor_has_the_laws_that_are_asked_for_and_else_stays_as_it_was(simulator) -> None:
    for seed in range(4):
        plain = simulator.make_case("none", seed=seed, **SHORT).truth["base"]
        usual = plain["elasticity"]["law"]
        case = simulator.make_case("none", seed=seed, laws=f"drift=power,none elasticity!={usual}", **SHORT)
        base = case.truth["base"]
        assert base["drift"]["law"] in ("power", "none")
        assert base["elasticity"]["law"] != usual
        others = plain.keys() - {"drift", "elasticity"}
        assert {name: base[name] for name in others} == {name: plain[name] for name in others}


@pytest.mark.parametrize("laws", ["colour=red", "drift=red", "drift", "drift=none drift!=none"])
@pytest.mark.parametrize("simulator", SIMULATORS[:2], ids=name_of)
def test_laws_that_there_are_not_are_refused(simulator, laws: str) -> None:
    with pytest.raises(UserError, match=r"laws: .* (there are|of) "):
        simulator.make_case("none", laws=laws, **SHORT)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("simulator", SIMULATORS[:2], ids=name_of)
def test_a_sensor_clamped_anew_has_other_zeros_in_the_held_out_recording_alone(simulator, seed: int) -> None:
    plain, case = (simulator.make_case("none", seed=seed, reclamped=again, **SHORT) for again in (False, True))
    stroke_mm = np.ptp(case.calibration[DISPLACEMENT])
    assert (plain.clamp_play_mm, case.clamp_play_mm) == (0.0, pytest.approx(0.025 * stroke_mm, rel=0.3))
    before, after = plain.held_out, case.held_out
    for name in (DISPLACEMENT, FORCE, RESISTANCE):
        assert np.array_equal(plain.calibration[name], case.calibration[name])
        assert np.array_equal(before[name], after[name]) == (name == DISPLACEMENT)
    change_N = after[FORCE] - before[FORCE]
    assert 0 < np.abs(change_N).max() < 0.2 * np.ptp(before[FORCE])


@pytest.mark.parametrize("simulator", SIMULATORS[:2], ids=name_of)
def test_a_recording_of_too_few_samples_is_refused(simulator) -> None:
    with pytest.raises(UserError, match="is below 60 samples; record longer"):
        simulator.make_case("none", minutes=2.0, rate_hz=0.25)
