"""The first line of a diagnosis: what was found, how sure that is, and whether it carries over."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from testbench.diagnosis.diagnosis import Found
from testbench.diagnosis.words import first_line


def line(verdict: str, held_out: float) -> str:
    """Of a diagnosis whose final model leaves 0.01 N on its own recording."""
    found = (Found("cyclic_fatigue", "cyclic_fatigue_log", 0.78, 60.0),) if verdict == "missing" else ()
    errors = {"calibration": {"force": 0.01}, "held_out": {"force": held_out}}
    return first_line(
        SimpleNamespace(  # type: ignore[arg-type]
            verdict=verdict,
            probabilities={"nothing": 0.8, "unknown": 0.1},
            found=found,
            tied=(),
            left=0.0,
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


def test_where_nothing_is_missing_the_other_recording_shows_more():
    assert "held out the error of the force is 15 times as large: that recording shows" in line(
        "nothing_missing", 0.15
    )
