"""Obvious cases end to end: what is hidden is named, what is not hidden is not, a user's own effect takes part."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

from testbench.cli import main
from testbench.comparing.compare import compare
from testbench.comparing.ladder import fitted_file
from testbench.design.rivals import rivals_from_diagnosis
from testbench.diagnosis import diagnose
from testbench.diagnosis.result import Diagnosis
from testbench.diagnosis.verdict import verdict_clauses
from testbench.diagnosis.words import first_line
from testbench.fitting import constants
from testbench.fitting.baseline import starting_baseline
from testbench.knit.catalogue import load_catalogue, model_from_dict
from testbench.measurements.splitting import split
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording
from testbench.results.result_files import checked_diagnosis
from testbench.worlds import make_case
from tests.testbench.asked_once import answered_once
from tests.testbench.builders import CATALOGUE, record, truth, write_csv

STRIP = Path(__file__).resolve().parents[3] / "../shared/data/real/cb_silicone_strip"
once = answered_once(diagnose)
HIDDEN = {
    "stress_relaxation": {"fraction": 0.2, "tau_s": 15.0},
    "channel_lag": {"tau_s": 0.4},
    "electrical_overshoot": {"gain": 0.2},
}


def pair(*effects: str, seconds: float = 120.0, noise: float = 1.0) -> tuple[Recording, Recording]:
    """A calibration and a held-out recording with these effects hidden."""
    model = truth()
    for name in effects:
        model = model.plus(CATALOGUE[name]().replaced(**HIDDEN[name]))
    first, second = (record(model, seconds, seed=seed, noise=noise) for seed in (1, 2))
    return first, second


@cache
def relaxed() -> Diagnosis:
    """Of two minutes of a relaxing knit."""
    return diagnose(*pair("stress_relaxation"), most=1)


def test_nothing_hidden_nothing_found():
    result = once(*pair(), catalogue=CATALOGUE)
    assert (result.verdict, result.found, result.tied) == ("nothing_missing", (), ())
    assert first_line(result) == "; ".join(verdict_clauses(result.to_dict()))
    assert first_line(result).startswith("nothing is missing that these recordings could show (")
    assert sum(result.probabilities.values()) == pytest.approx(1.0)


def test_what_is_hidden_is_named_and_explains_the_error():
    result = relaxed()
    assert (result.verdict, result.found[0].effect) == ("missing", "stress_relaxation")
    assert first_line(result).startswith("missing: stress relaxation (")
    assert result.ranking[0].effect == "stress_relaxation"
    # The held-out recording goes to strains that the calibration has not seen.
    for channel, floor in result.noise_floor.items():
        assert result.error_after[channel] < min(2.0 * floor, result.error_before[channel] / 4)
    assert result.left < 0.1
    assert all(share >= 0.01 for *_, share in result.depends_on)


def test_probabilities_are_of_nothing_unknown_and_every_mechanism_and_sum_to_one():
    result = relaxed()
    assert sum(result.probabilities.values()) == pytest.approx(1.0)
    assert {"nothing", "unknown", *(one.effect for one in result.ranking)} == set(result.probabilities)
    assert [one.probability for one in result.ranking] == sorted(
        (one.probability for one in result.ranking), reverse=True
    )


def test_the_json_comes_back_as_it_was_and_its_model_can_be_built():
    said = relaxed().to_dict()
    again = json.loads(json.dumps(said, allow_nan=False))
    assert again == said
    assert {
        "verdict",
        "probabilities",
        "found",
        "ranking",
        "tied",
        "base_misfits",
        "other_laws",
        "bends_like",
        "depends_on",
    } <= set(said)
    assert {"left_unexplained", "error_before", "error_after", "noise_floor", "parameters_after"} <= set(said)
    keys = {"effect", "law", "probability", "log_evidence", "gain", "held_out_gain", "error_share_left"}
    assert all(keys | {"tied_for_first", "start"} == set(entry) for entry in said["ranking"])
    assert model_from_dict(again["model_after"], CATALOGUE).to_dict() == said["model_after"]
    start = again["ranking"][0]
    assert CATALOGUE[start["law"]].model_validate(start["start"]).model_dump(mode="json") == start["start"]


def test_the_first_two_of_a_diagnosis_become_rivals():
    told = checked_diagnosis(json.loads(json.dumps(relaxed().to_dict())), "diagnosis")
    rivals, noise = rivals_from_diagnosis(
        told, "diagnosis", *split(*pair("stress_relaxation")), CATALOGUE, lambda text: None
    )
    assert [one.name for one in rivals] == (list(relaxed().tied) or [e.effect for e in relaxed().ranking])[:2]
    assert set(noise) == {"force", "conductance"}


def test_the_command_says_it_on_one_line_and_writes_one_object(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("testbench.diagnosis.diagnose", once)  # asks what the first test asked
    files = [write_csv(part, tmp_path / f"{name}.csv") for name, part in zip("ab", pair(), strict=True)]
    out, model = tmp_path / "diagnosis.json", tmp_path / "model.json"
    argv = ["diagnose", files[0], "--held-out", files[1], "--gauge-length-mm", "25", "--quiet"]
    assert main([*argv, "--json", str(out), "-o", str(model)]) == 0
    first, _, title, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("nothing is missing that these recordings could show (")
    columns = "rank effect law probability log evidence held-out error left, mean of the channels (95 %)"
    assert " ".join(title.split()) == columns
    assert json.loads(out.read_text())["found"] == []
    assert json.loads(model.read_text())["format"] == "knitbench-model"


@pytest.mark.slow
@pytest.mark.parametrize("effect", HIDDEN)
@pytest.mark.parametrize("noise", [0.3, 0.03])
def test_as_the_noise_goes_to_zero_what_is_hidden_is_found(effect, noise):
    result = diagnose(*pair(effect, noise=noise), most=1)
    assert result.found[0].effect == effect
    certain = 1 - constants.MISLED  # the rest is kept back for evidence that misleads
    assert result.found[0].probability > 0.98 * certain


@pytest.mark.slow
def test_two_hidden_effects_are_both_found():
    result = diagnose(*pair("stress_relaxation", "channel_lag", seconds=240))
    assert {one.effect for one in result.found} == {"stress_relaxation", "channel_lag"}
    steps = [step["step"] for step in result.after.history]
    assert steps[0] == "baseline"
    assert steps[-2:] == [f"+ {one.law}" for one in result.found]
    assert ", then " in first_line(result)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["electrical_overshoot", "contact_relaxation"])
def test_resistance_alone_is_enough(effect):
    """Without force there are no free loops of force in the base: nothing may ask for them."""
    case = make_case(effect, 10, "other_drift", 5013, 5, 12, protocol="return_to_zero", channels=["resistance_ohm"])
    result = diagnose(case.calibration, case.held_out)
    assert (result.verdict, result.found[0].effect) == ("missing", effect)


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
    assert result.found[0].effect == "delayed_cube"


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
def test_what_a_real_strip_lacks_is_in_no_catalogue_and_its_error_falls_nonetheless(strip):
    """Its conducting network breaks and heals. An overshoot is nearest, and leaves twenty noise floors."""
    result = diagnose(*strip)
    assert result.verdict == "unknown"
    assert result.error_after["conductance"] <= 0.75 * result.error_before["conductance"]
