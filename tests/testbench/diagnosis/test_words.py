"""The first line of a diagnosis: what was found, how sure that is, and whether it carries over."""

from __future__ import annotations

from typing import Any

import pytest

from testbench.diagnosis.verdict import verdict_clauses


def line(
    verdict: str,
    held_out: float = 0.01,
    bends_like: str = "",
    first: float = 0.1,
    left: float = 0.7,
    floor: float = 0.01,
) -> str:
    """Of a diagnosis whose final model leaves 0.01 N on its own recording."""
    found = {"effect": "cyclic_fatigue", "law": "cyclic_fatigue_log", "probability": 0.78, "log_evidence": 60.0}
    errors = {"calibration": {"force": 0.01}, "held_out": {"force": held_out}}
    ranked = {"effect": "permanent_set", "law": "ratchet", "probability": first, "error_share_left": left}
    return said_of(
        verdict=verdict,
        probabilities={"nothing": 0.8, "unknown": 0.3, "yarn_elongation": 0.11, "permanent_set": first},
        found=[found] if verdict == "missing" else [],
        ranking=[ranked | {"held_out_gain": (1, 1, 1)}],
        bends_like=bends_like,
        depends_on=[{"channel": "force", "coordinate": "elapsed time", "gain": 0.5}],
        left_unexplained=0.0,
        error_after=errors["held_out"],
        noise_floor={"force": floor},
        history=[{"errors": errors}],
    )


def said_of(**diagnosis: Any) -> str:
    return "; ".join(verdict_clauses(diagnosis))


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
    lag = {"effect": "channel_lag", "law": "channel_lag_force", "probability": 0.85, "log_evidence": 60.0}
    said = said_of(
        verdict="missing",
        probabilities={"channel_lag": 0.85},
        found=[lag],
        left_unexplained=0.66,
        error_after=steps[-1][1],
        noise_floor={"force": 0.005, "conductance": 0.02},
        history=history,
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
        "force is 7 times its noise floor; a comparison shows where"
    )
    assert line("nothing_missing", 0.014, floor=0.002) == (
        "nothing is missing that these recordings could show (80 %); but the error of the force is 7 times its noise "
        "floor; a comparison shows where"
    )


def test_a_law_of_the_base_that_is_bent_is_told_where_nothing_is_missing():
    assert line("nothing_missing") == "nothing is missing that these recordings could show (80 %)"
    said = line("nothing_missing", bends_like="yarn_elongation")
    assert said.endswith("; but a law of the base is bent as yarn elongation (11 %) would bend it")


def test_unknown_names_what_is_nearest():
    assert line("unknown") == (
        "unknown (30 %): something is missing that no effect of the catalogue explains; what is left depends most on "
        "this: force on elapsed time (50 % of it); the nearest is permanent set (ratchet), which would leave 70 % of "
        "the error above the noise"
    )
    assert "nearest" not in line("unknown", left=0.9)


def test_what_is_probable_but_explains_too_little_is_not_called_unlikely():
    assert line("unknown", first=0.8) == (
        "unknown: permanent set (80 %) is probable, but leaves 70 % of the error above the noise; what is left "
        "depends most on this: force on elapsed time (50 % of it)"
    )
