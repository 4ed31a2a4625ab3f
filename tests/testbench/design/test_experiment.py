"""The proposed experiment is more decisive than plain noise when rivals are really simulated and refitted."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.design import experiment
from testbench.design.ahead import planned
from testbench.design.experiment import propose
from testbench.design.imitation import Rival
from testbench.design.protocols import MENU, NOISE, Bounds, drivable, menu
from testbench.fitting.fit import fit
from testbench.results.model_file import ModelFile
from tests.testbench.builders import CATALOGUE, NOISE_LN, NOISE_N, record, truth, write_csv
from tests.testbench.design.readings import read

FLOORS = {"force": NOISE_N, "conductance": NOISE_LN}
BOUNDS = Bounds(duration_s=300)
# Draws of the noise: where little is to be told, one draw says nothing.
DRAWS = {"load_cell_creep": 2, "permanent_set": 2, "self_heating": 12}
PAIRS = {
    "load_cell_creep": ({"fraction": 0.03}, "stress_relaxation", {"fraction": 0.03}),
    "permanent_set": ({}, "clamp_slip", {}),
    "self_heating": ({"coefficient": 0.3}, "temperature_drift_trend", {"coefficient_per_h": 0.3}),
}


def rivals(first: str) -> list[Rival]:
    changes, second, others = PAIRS[first]
    return [
        Rival(name, truth().plus(CATALOGUE[name]().replaced(**values)))
        for name, values in ((first, changes), (second, others))
    ]


def misfit_after_refit(option, truth_model, rival_model, seed: int) -> float:
    """Squared misfit over the noise that `testbench fit` itself leaves to the wrong model."""
    measurement = planned(option.made.trajectory, BOUNDS.gauge_length_mm, tuple(FLOORS))
    clean = measurement.modelled(truth_model)
    fitted = measurement.modelled(fit(rival_model, read(measurement, truth_model, seed)).model)
    left = {c: (clean[c] - fitted[c])[measurement.counts] for c in FLOORS}
    return sum(float(np.var(left[c] / FLOORS[c])) for c in FLOORS)


ONE, *OTHERS = PAIRS


@pytest.mark.parametrize("first", [ONE, *(pytest.param(other, marks=pytest.mark.slow) for other in OTHERS)])
def test_the_proposal_beats_plain_noise_after_real_refits(first):
    pair = rivals(first)
    options = propose(pair, FLOORS, BOUNDS)
    best, noise = options[0], next(option for option in options if option.name == NOISE)
    assert best.hardest.log_odds > 2 * noise.hardest.log_odds
    one, other = (rival.model for rival in pair)
    worth = {}
    for option in (best, noise):
        draws = range(DRAWS[first])
        on_one = np.mean([misfit_after_refit(option, one, other, seed) for seed in draws])
        on_other = np.mean([misfit_after_refit(option, other, one, seed) for seed in draws])
        worth[option.name] = min(on_one, on_other)
    assert worth[best.name] > 1.5 * worth[NOISE], worth


@pytest.mark.parametrize(
    "bounds",
    [
        Bounds(),
        Bounds(v_max_mm_per_s=1, a_max_mm_per_s2=2, duration_s=300),
        Bounds(duration_s=120, strain_max_percent=5),
        Bounds(strain_max_percent=80, gauge_length_mm=100, duration_s=300),
    ],
)
def test_every_design_keeps_the_limits_and_the_time(bounds):
    made = drivable(bounds, seed=1)
    assert set(made) == set(MENU)
    for name, one in made.items():
        assert one.statistics.v_max_mm_per_s <= bounds.v_max_mm_per_s + 1e-6, name
        assert one.statistics.a_max_mm_per_s2 <= bounds.a_max_mm_per_s2 + 1e-6, name
        assert one.statistics.x_max_mm <= bounds.stroke_mm + 1e-6, name
        assert 0.9 * bounds.duration_s < one.trajectory.duration_s <= bounds.duration_s, name


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"duration_s": 5}, "duration_s: an experiment takes 1 min to 24 h, got 0.0833333 min"),
        ({"v_max_mm_per_s": -1}, "v_max_mm_per_s: must be a positive"),
        ({"strain_max_percent": 1e-300}, r"a stroke \(1e-300 % of 25 mm .* must take from 0.1 s to half the run"),
        ({"strain_max_percent": 1e300}, "must take from 0.1 s to half the run"),
        ({"v_max_mm_per_s": 1e-300}, "must take from 0.1 s to half the run"),
        ({"v_max_mm_per_s": 1e300, "a_max_mm_per_s2": 1e300}, "must take from 0.1 s to half the run"),
        ({"gauge_length_mm": 1e-300}, "must take from 0.1 s to half the run"),
    ],
)
def test_impossible_bounds_are_refused(changes, match):
    with pytest.raises(UserError, match=match):
        menu(Bounds(**changes))


def test_a_seed_that_no_trajectory_has_is_told_as_such_and_not_as_a_limit_of_the_machine():
    with pytest.raises(UserError, match=r"^seed must be a whole number from 0 to"):
        propose(rivals("permanent_set"), FLOORS, BOUNDS, seed=10**30)


def test_a_picture_in_another_format_is_refused_before_any_work(capsys):
    assert main(["experiment", "one.json", "other.json", "--plot", "next.txt"]) == 2
    assert "next.txt: a figure is written as png, pdf, svg" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "file").write_text("no folder")
    assert main(["experiment", "one.json", "other.json", "-o", str(tmp_path / "file")]) == 2
    assert "cannot write into the folder" in capsys.readouterr().err


def test_a_minute_is_long_enough_for_an_experiment():
    """It was refused, where the recording of the example lasts as long."""
    made = drivable(Bounds(duration_s=60), seed=1)
    assert len(made) > 10
    assert all(one.trajectory.duration_s <= 60 for one in made.values())


def test_of_two_rivals_of_which_one_is_a_case_of_the_other_the_larger_one_can_be_told(monkeypatch):
    """It imitates the smaller one on every motion, and no motion was found to tell them apart."""
    short = Bounds(duration_s=60)
    alone = {NOISE: drivable(short, 1)[NOISE]}
    monkeypatch.setattr(experiment, "drivable", lambda *_: alone)
    relaxing = Rival("relaxing", truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.3)))
    (option,) = propose([Rival("base", truth()), relaxing], FLOORS, short)
    assert (option.hardest.truth, option.hardest.imitator) == ("relaxing", "base")
    assert option.grade == "decisive"


def test_the_same_model_twice_is_refused():
    with pytest.raises(UserError, match="the same model"):
        propose([Rival("a", truth()), Rival("b", truth())], FLOORS, BOUNDS)


def test_command_writes_the_winner(tmp_path, capsys):
    paths = []
    for rival in rivals("permanent_set"):
        step = {"step": "x", "model": rival.model.to_dict(), "noise_floor": FLOORS}
        step["errors"] = {"held_out": FLOORS, "calibration": FLOORS}
        paths.append(str(tmp_path / f"{rival.name}.json"))
        ModelFile(rival.model, 25.0, "r", "h", {}, (step,)).save(paths[-1])
    out, ranking, picture = tmp_path / "next", tmp_path / "ranking.json", tmp_path / "next.png"
    more = ["--duration-s", "120", "-o", str(out), "--json", str(ranking), "--plot", str(picture)]
    assert main(["experiment", *paths, *more]) == 0
    assert "permanent_set against clamp_slip" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {"program.tap", "trajectory.csv", "trajectory.json"}
    options = json.loads(ranking.read_text())["options"]
    assert [o["log_odds"] for o in options] == sorted((o["log_odds"] for o in options), reverse=True)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_command_says_what_it_needs(capsys):
    assert main(["experiment", "one.json"]) == 2
    assert "two rival MODEL files, or --diagnosis JSON --fit RECORDING; got 1 MODEL" in capsys.readouterr().err


def test_command_takes_the_tied_effects_of_a_diagnosis(tmp_path, capsys):
    recording = write_csv(record(truth(), 120), tmp_path / "r.csv")
    errors = {"held_out": FLOORS, "calibration": FLOORS}
    step = {"step": "baseline", "model": truth().to_dict(), "noise_floor": FLOORS, "errors": errors}
    names = ("self_heating", "load_cell_creep", "stress_relaxation")
    case = {"probability": 0.3, "log_evidence": 1.0, "gain": 0.1}
    ranked = [{"effect": name, "form": name} | case for name in names]
    tied = ["load_cell_creep", "stress_relaxation"]
    said = {"verdict": "nothing_missing", "found": [], "tied": tied, "ranking": ranked, "history": [step]}
    said |= {"probabilities": dict.fromkeys(names, 0.3) | {"nothing": 0.1, "unknown": 0.0}}
    said |= {"error_before": FLOORS, "error_after": FLOORS, "noise_floor": FLOORS}
    (tmp_path / "d.json").write_text(json.dumps(said))
    place = ["--fit", recording, "--gauge-length-mm", "25", "--duration-s", "120"]
    assert main(["experiment", "--diagnosis", str(tmp_path / "d.json"), *place]) == 0
    out = capsys.readouterr().out
    assert "load_cell_creep against stress_relaxation" in out
    assert "self_heating" not in out


def test_command_refuses_what_is_no_diagnosis(tmp_path, capsys):
    recording = write_csv(record(truth(), 60), tmp_path / "r.csv")
    (tmp_path / "d.json").write_text('{"verdict": "missing"}')
    where = ["--diagnosis", str(tmp_path / "d.json"), "--fit", recording, "--gauge-length-mm", "25"]
    assert main(["experiment", *where]) == 2
    assert "not a diagnosis" in capsys.readouterr().err
