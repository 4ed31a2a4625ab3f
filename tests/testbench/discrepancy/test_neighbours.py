"""Neighbours in the catalogue: which of two it is, and when it is neither. Cases that were once named wrongly."""

from __future__ import annotations

import pytest

from testbench.discrepancy import diagnose
from testbench.knit.catalogue import load_catalogue
from testbench.worlds import make_case

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("world", "seed"),
    [
        pytest.param("mismatched", 54006, id="jumps, and a smooth slip fits better before all of them are found"),
        pytest.param("matched", 42006, id="jumps, and the held-out recording hangs limper than the calibration"),
        pytest.param("matched", 56006, id="slides, and screens far behind a set"),
    ],
)
def test_a_slipping_clamp_is_told_from_a_knit_that_grew_longer(world, seed):
    case = make_case("clamp_slip", 5, world, seed)
    result = diagnose(case.calibration, case.held_out)
    assert (result.verdict, result.weighing.ranking[0].idea) == ("missing", "clamp_slip")
    assert all(result.error_after[c] < 1.5 * case.truth["noise_floor"][c] for c in result.error_after)


@pytest.mark.parametrize(("effect", "seed"), [("gauge_factor_fades", 42020), ("cyclic_fatigue", 47027)])
def test_what_the_catalogue_does_not_have_is_none_of_its_neighbours(effect, seed):
    case = make_case(effect, 5, "matched", seed)
    assert diagnose(case.calibration, case.held_out, catalogue=load_catalogue().without(effect)).verdict == "unknown"


def test_noise_that_wanders_is_no_structure():
    """The floor is counted too low, and an overshoot gains half of what the lag does: still it is the lag."""
    case = make_case("channel_lag", 5, "matched", 55013)
    result = diagnose(case.calibration, case.held_out)
    assert (result.verdict, result.weighing.ranking[0].idea) == ("missing", "channel_lag")
