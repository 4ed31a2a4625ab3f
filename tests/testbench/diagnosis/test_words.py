"""The first line of a diagnosis: what was found, how sure that is, and whether it carries over."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from testbench.diagnosis.result import Found
from testbench.diagnosis.words import first_line


def line(
    verdict: str,
    held_out: float = 0.01,
    bends_like: str = "",
    first: float = 0.1,
    left: float = 0.7,
    floor: float = 0.01,
) -> str:
    """Of a diagnosis whose final model leaves 0.01 N on its own recording."""
    found = (Found("cyclic_fatigue", "cyclic_fatigue_log", 0.78, 60.0),) if verdict == "missing" else ()
    errors = {"calibration": {"force": 0.01}, "held_out": {"force": held_out}}
    return first_line(
        SimpleNamespace(  # type: ignore[arg-type]
            verdict=verdict,
            probabilities={"nothing": 0.8, "unknown": 0.3, "yarn_elongation": 0.11},
            found=found,
            ranking=[
                SimpleNamespace(
                    effect="permanent_set", law="ratchet", probability=first, left=left, held_out_gain=(1, 1, 1)
                )
            ],
            tied=(),
            bends_like=bends_like,
            depends_on=[("force", "elapsed time", 0.5)],
            left=0.0,
            error_after=errors["held_out"],
            noise_floor={"force": floor},
            after=SimpleNamespace(history=[{"errors": errors}]),
        )
    )


@pytest.mark.parametrize("verdict", ["missing", "nothing_missing"])
def test_an_error_that_stays_small_needs_no_word(verdict):
    assert "held out" not in line(verdict, 0.02)


def test_a_law_that_does_not_carry_over_is_told():
    said = line("missing", 0.15)
    assert said.startswith(
        "missing: cyclic fatigue (78 %); less than 1 % of the error above the noise is left in this"
    )
    assert "held out the error of the force is 15 times as large: what was found does not carry over" in said


def test_what_explains_one_channel_says_where_the_rest_is():
    """A lag of the force; the conductance wanders, in the held-out recording as well."""
    steps = [({"force": 0.02, "conductance": 0.01}, {"force": 0.02, "conductance": 0.05})]
    steps.append(({"force": 0.005, "conductance": 0.01}, {"force": 0.006, "conductance": 0.05}))
    history = [{"errors": {"calibration": own, "held_out": other}} for own, other in steps]
    lag = Found("channel_lag", "channel_lag_force", 0.85, 60.0)
    said = first_line(
        SimpleNamespace(  # type: ignore[arg-type]
            verdict="missing",
            probabilities={"channel_lag": 0.85},
            found=(lag,),
            tied=(),
            left=0.66,
            error_after=steps[-1][1],
            noise_floor={"force": 0.005, "conductance": 0.02},
            after=SimpleNamespace(history=history),
        )
    )
    assert said == (
        "missing: channel lag (85 %); 66 % of the error above the noise is left, nearly all of it in the conductance"
    )


def test_where_nothing_is_missing_the_other_recording_shows_more():
    assert "held out the error of the force is 15 times as large: that recording shows" in line(
        "nothing_missing", 0.15
    )


def test_an_error_far_above_the_noise_is_told_whatever_is_left_of_it_where_the_diagnosis_looks():
    """A hum that comes and goes more quickly than that; its alias was found."""
    assert line("missing", 0.014, floor=0.002) == (
        "missing: cyclic fatigue (78 %); less than 1 % of the error above the noise is left; but the error of the "
        "force is 7 times its noise floor: see `testbench compare`"
    )
    assert line("nothing_missing", 0.014, floor=0.002) == (
        "nothing is missing (80 %); but the error of the force is 7 times its noise floor: see `testbench compare`"
    )


def test_a_law_of_the_base_that_is_bent_is_told_where_nothing_is_missing():
    assert line("nothing_missing") == "nothing is missing (80 %)"
    said = line("nothing_missing", bends_like="yarn_elongation")
    assert said == "nothing is missing (80 %), but a law of the base is bent as yarn elongation (11 %) would bend it"


def test_unknown_names_what_is_nearest():
    assert line("unknown") == (
        "unknown (30 %): structure remains that no effect of the catalogue explains, depends most on: force: "
        "elapsed time (50 % of it). The nearest is permanent set (ratchet), which would leave 70 % of the error "
        "above the noise"
    )
    assert "nearest" not in line("unknown", left=0.9)


def test_what_is_probable_but_explains_too_little_is_not_called_unlikely():
    assert line("unknown", first=0.8) == (
        "unknown: permanent set (80 %) is probable, but leaves 70 % of the error above the noise, depends most on: "
        "force: elapsed time (50 % of it)"
    )
