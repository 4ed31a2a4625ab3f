"""Obvious cases end to end: what is hidden is named, what is not hidden is not, a user's own effect takes part."""

from __future__ import annotations

from pathlib import Path

import pytest

from testbench.discrepancy import diagnose
from testbench.discrepancy.baseline import starting_baseline
from testbench.discrepancy.compare import compare
from testbench.discrepancy.ladder import fitted_file
from testbench.discrepancy.measurement import split
from testbench.discrepancy.repeat import diagnose_repeatedly
from testbench.knit.catalogue import load_catalogue
from testbench.recording import read_recording
from testbench.worlds import make_case
from tests.testbench.discrepancy.samples import record, truth

STRIP = Path(__file__).resolve().parents[3] / "../shared/data/real/cb_silicone_strip"


def test_nothing_hidden_nothing_found():
    case = make_case("none", seed=1, minutes=6, rate_hz=20, noise="white")
    result = diagnose(case.calibration, case.held_out)
    assert result.verdict == "nothing_missing"
    assert result.tied == ()


def test_resistance_alone_is_enough():
    """Without force there are no free loops of force in the base: nothing may ask for them."""
    case = make_case(
        "adc_saturation", 10, "other_drift", 5013, 5, 12, protocol="return_to_zero", channels=["resistance_ohm"]
    )
    result = diagnose(case.calibration, case.held_out)
    assert (result.verdict, result.weighing.ranking[0].idea) == ("missing", "adc_saturation")


@pytest.mark.slow
def test_a_guess_from_the_data_stays_within_its_bounds():
    """Long holds have their sharpest line below the lowest frequency of a hum."""
    case = make_case("none", 5, "other_drift", 5002, 5, 40, protocol="holds")
    assert diagnose(case.calibration, case.held_out).verdict == "nothing_missing"


@pytest.mark.slow
def test_of_two_that_come_close_the_refits_decide():
    case = make_case("mullins_softening", 15, "mismatched", 9021)
    result = diagnose(case.calibration, case.held_out)
    # A set with a threshold comes so close that both are named; clamps that slip and the rest are far behind.
    assert "mullins_softening" in {result.weighing.ranking[0].idea, *result.tied}
    assert len(result.tied) <= 2
    assert all(result.error_after[c] < 1.15 * case.truth["noise_floor"][c] for c in result.error_after)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "form"),
    [
        ("stress_relaxation", None),
        # A bump after every turn is another matter: slips of the contacts imitate it (docs/benchmark-diagnosis.md).
        ("electrical_overshoot", "fades_with_time"),
        # A set that grows with travel, of a knit that never hangs limp.
        ("permanent_set", None),
    ],
)
def test_an_obvious_effect_is_named(effect, form):
    case = make_case(effect, strength=15, seed=1, minutes=6, rate_hz=20, form=form)
    result = diagnose(case.calibration, case.held_out)
    assert result.verdict == "missing"
    assert effect in [entry.idea for entry in result.weighing.ranking[:2]]
    assert all(result.error_after[c] <= 1.02 * result.error_before[c] for c in result.error_before)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "form"),
    [
        ("clamp_slip", "few_big_jumps"),
        ("jamming_stiffening", "locking_limit"),
    ],
)
def test_what_a_shape_or_a_set_could_imitate_is_told_from_it(effect, form):
    case = make_case(effect, strength=15, seed=2, minutes=6, rate_hz=20, form=form)
    result = diagnose(case.calibration, case.held_out)
    assert (result.verdict, result.weighing.ranking[0].idea) == ("missing", effect)


@pytest.mark.slow
def test_two_hidden_effects_are_found_one_after_the_other():
    case = make_case("stress_relaxation,channel_lag", strength=10, seed=5, minutes=6, rate_hz=20)
    found = diagnose_repeatedly(case.calibration, case.held_out, most=2)
    assert {one.weighing.ranking[0].idea for one in found} == {"stress_relaxation", "channel_lag"}
    steps = [step["step"] for step in found[-1].after.history]
    assert steps[0] == "baseline"
    assert len(steps) >= 3


OWN = '''
import numpy as np
from testbench.knit.effect import Effect, Stage, parameter
from testbench.knit.filters import lowpass


class WarmUpHum(Effect):
    """A stretch of its own: the force answers to the cube of the delayed strain.

    F += gain * (strain 20 s ago, smoothed)^3
    """

    name = "delayed_cube"
    stage = Stage.MECHANICS
    reads, writes = ("strain", "force_N"), ("force_N",)
    strength = "gain_N"
    look = "force follows where the knit was, not where it is"

    gain_N: float = parameter(5.0, unit="N", low=0, high=500, doc="force at full strain")

    def apply(self, signals, dt_s):
        late = np.roll(lowpass(signals["strain"], 2.0, dt_s), round(20 / dt_s))
        late[: round(20 / dt_s)] = 0.0
        return {"force_N": signals["force_N"] + self.gain_N * late**3}
'''


@pytest.mark.slow
def test_a_users_own_effect_is_found_like_a_built_in(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(OWN)
    catalogue = load_catalogue(path)
    model = truth().plus(catalogue["delayed_cube"]().replaced(gain_N=60.0))
    first, second = (record(model, 360, seed=seed) for seed in (1, 2))
    result = diagnose(first, second, catalogue=catalogue)
    assert result.verdict == "missing"
    assert result.weighing.ranking[0].idea == "delayed_cube"


@pytest.fixture(scope="module")
def strip():
    """A calibration and a held-out recording of one strip."""
    paths = [STRIP / f"cb7.5_s2_{name}.csv" for name in ("multisine_600s", "multisine_300s_a")]
    if not all(path.is_file() for path in paths):
        pytest.skip("the measured recordings are not on this machine")
    return [read_recording(path, 40.0) for path in paths]


def test_real_strip_can_be_fitted_and_compared(strip):
    parts = split(*strip)
    file = fitted_file(starting_baseline(parts[0]), *parts, "baseline")
    result = compare(file.model, parts[1], free_offset=True)
    assert all(result.rms[c] >= 0.9 * result.noise_floor[c] for c in result.rms)
    assert result.worst


@pytest.mark.slow
def test_real_strip_conductance_error_falls_by_half(strip):
    result = diagnose(*strip)
    assert result.error_after["conductance"] <= 0.5 * result.error_before["conductance"]
