"""A law that no catalogue has is found, written, and joins everything; where nothing is left nothing is written."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from testbench.cli import main
from testbench.diagnosis.searching.search import Search
from testbench.knit.catalogue import load_catalogue
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.rules import applied, check
from testbench.measurements.splitting import split
from testbench.proposing import Proposed, propose_law
from testbench.proposing.blindness import not_judged
from testbench.proposing.hunt import Hunt
from testbench.proposing.laws.law import Term
from testbench.proposing.laws.law_coordinates import COORDINATES
from testbench.proposing.laws.operators import OPERATORS
from testbench.proposing.laws.places import PLACES
from testbench.proposing.open_chain import OpenChain
from testbench.proposing.proposal import beyond_the_fit
from testbench.proposing.words import _safe, as_json, first_line, proposal_text, story
from testbench.proposing.writing import effect_class, file_text
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording
from testbench.report.figures.proposal_figures import part_of
from tests.testbench.asked_once import answered_once
from tests.testbench.builders import CATALOGUE, record, truth, write_csv
from tests.testbench.proposing.test_library import GRID, law_of

STRIP = Path(__file__).resolve().parents[3] / "../shared/data/real/cb_silicone_strip"
HEAL_S, REACH = 12.0, 0.5
once = answered_once(propose_law)


class Network(Effect):
    """Bridges that motion breaks and time heals, by a plain loop; no code of the library."""

    name = "network"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance is low after motion and comes back at rest"

    gain: float = parameter(0.5, unit="1", low=0, high=5, doc="change of ln G")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        whole = np.ones_like(strain)
        for i in range(1, len(strain)):
            broken = abs(strain[i] - strain[i - 1]) / REACH * whole[i - 1]
            whole[i] = whole[i - 1] + dt_s * (1 - whole[i - 1]) / HEAL_S - broken
        return {"conductance_S": signals["conductance_S"] * np.exp(self.gain * whole)}


@cache
def pair(hidden: bool = True) -> tuple[Recording, Recording]:
    """Two minutes and two minutes, with or without the network."""
    model = truth().plus(Network()) if hidden else truth()
    first, second = (record(model, 120.0, seed=seed) for seed in (1, 2))
    return first, second


def found() -> Proposed:
    """What is proposed for the network."""
    return once(*pair(), name="my_effect", catalogue=CATALOGUE, most=1)


def test_the_hidden_law_is_found_with_its_numbers():
    (step,) = found().steps
    law = step.option.law
    assert law.key == "conductance: state that forms with time and is wiped out by motion"
    assert law.values["form_s"] == pytest.approx(HEAL_S, rel=0.05)
    assert law.values["wipe"] == pytest.approx(REACH, rel=0.05)
    assert law.strength == pytest.approx(0.5, rel=0.05)
    assert 1 + len(law.term.slots) <= 4
    assert step.option.holds > 0.95


def test_the_held_out_error_falls_to_the_noise():
    proposed = found()
    for channel, floor in proposed.noise_floor.items():
        assert proposed.error_after[channel] < 1.1 * floor
    assert proposed.error_before["conductance"] > 2 * proposed.noise_floor["conductance"]
    assert [step["step"] for step in proposed.after.history] == ["baseline", "+ shape freedom", "+ my_effect"]


def test_a_base_that_has_made_room_for_a_law_is_not_bent_again_without_it():
    hunt = Hunt(Search(split(*pair())[0], CATALOGUE, lambda text: None), "my_effect")
    bent = hunt.projected(hunt.base)
    trial = hunt.fitter.settled(hunt.refitted(found().steps[0].option.law, bent, "my_effect"))
    roomy = hunt.projected(trial.hypothesis, without="my_effect")
    left = {null: np.std(hunt.measurement.residual(null.chain.model)["conductance"]) for null in (bent, roomy)}
    assert left[roomy] > 1.3 * left[bent]  # all of the law, not what a base leaves that bends to it
    assert roomy.of_law(trial.law)[1] == pytest.approx(trial.law.strength, rel=0.05)
    again = hunt.refitted(trial.law, roomy, "my_effect")  # starts where the first has ended
    assert again.log_z == pytest.approx(trial.log_z, abs=1.0)


def test_the_file_keeps_the_rules_and_joins_the_catalogue(tmp_path: Path):
    proposed = found()
    path = tmp_path / "my_effect.py"
    path.write_text(file_text(proposed.laws, proposed.grid, story(proposed), path.name))
    catalogue = load_catalogue(path)
    effect = catalogue["my_effect"]()
    assert check(effect) == []
    assert effect.model_dump() == pytest.approx(proposed.after.model["my_effect"].model_dump())
    assert main(["effects", "--effects", str(path), "--check"]) == 0


def test_the_words_say_what_it_is_and_what_could_not_be_judged():
    text = proposal_text(found())
    assert text.startswith("proposed: the conductance rises with a state that forms with time and is wiped out")
    for part in ("n' = (1 / tau_1) (1 - n)", "LaTeX:", "+ my_effect", "no temperature was recorded"):
        assert part in text
    (step,) = found().steps
    better = replace(step.option, log_evidence=step.option.log_evidence + 20, holds=0.6)
    text = proposal_text(replace(found(), steps=(replace(step, alternatives=(better,)),)))
    assert "more likely, but refused: it gains in 60 % of the resampled recordings: the conductance" in text


def test_how_far_the_held_out_recording_goes_beyond_the_fit_is_said():
    calibration, held = split(*pair(hidden=False))
    strain, there = calibration.signals["strain"], held.signals["strain"][held.counts]
    low = replace(calibration, counts=calibration.counts & (strain < 0.5 * strain.max()))
    seen = strain[low.counts]
    beyond = beyond_the_fit(law_of("force", "strain", "times force"), truth(), low, held)
    assert beyond == pytest.approx(np.mean((there > seen.max()) | (there < seen.min())))
    assert beyond > 0.1
    step = replace(found().steps[0], beyond=beyond)
    text = proposal_text(replace(found(), steps=(step,)))
    assert (
        f"judged on the held-out recording, {100 * beyond:.0f} % of which lies beyond what it was fitted on" in text
    )
    assert as_json(replace(found(), rejected=step))["rejected"]["held_out_beyond"] == beyond


def test_a_share_of_the_force_moves_the_channels_by_the_force_times_as_much():
    chain = OpenChain(truth(), split(*pair(hidden=False))[0])
    share, amount = (chain.slopes(PLACES[name]) for name in ("force by a share", "force"))
    force_N = chain.readable(PLACES["force"])["force_N"]
    assert {c: pytest.approx(slope * force_N) for c, slope in amount.items()} == share


@pytest.mark.parametrize("place", ["conductance", "path beside", "resistance in series"])
def test_the_trace_of_a_change_of_the_conductance_is_that_of_its_effect(place: str):
    calibration = split(*pair(hidden=False))[0]
    chain, law = OpenChain(truth(), calibration), law_of(place, "strain", "lag", gain=1e-4)
    z = law.term.evaluated(chain.readable(law.place), law.values, calibration.dt_s)
    signals = chain.after[law.place.stage]
    after = applied(effect_class(law, "my_law", GRID)(), signals, calibration.dt_s)["conductance_S"]
    change = np.log(after / signals["conductance_S"])
    assert change == pytest.approx(1e-4 * z * chain.slopes(law.place)["conductance"], abs=1e-3 * np.ptp(change))


def test_the_command_writes_effect_picture_and_model_that_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("testbench.proposing.propose_law", once)  # asks what `found` asked
    first, second = (write_csv(one, tmp_path / f"{k}.csv") for k, one in enumerate(pair()))
    effect, model, said = (str(tmp_path / name) for name in ("my_effect.py", "model.json", "said.json"))
    words = ["propose", first, "--held-out", second, "--gauge-length-mm", "25", "-o", effect, "--laws", "1"]
    assert main([*words, "--save-model", model, "--json", said, "--quiet"]) == 0
    assert "wrote" in capsys.readouterr().out
    assert (tmp_path / "my_effect.png").stat().st_size > 10_000
    assert json.loads(Path(said).read_text())["laws"][0]["coordinate"].startswith("state that forms with time")
    # The effect joins everything that takes --effects.
    assert main(["compare", second, "--model", model, "--effects", effect]) == 0
    before = Path(effect).read_text()
    assert main(words) == 2
    assert "exists already" in capsys.readouterr().err
    assert Path(effect).read_text() == before


def test_nothing_left_nothing_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    first, second = (write_csv(one, tmp_path / f"{k}.csv") for k, one in enumerate(pair(hidden=False)))
    effect = tmp_path / "my_effect.py"
    assert (
        main(["propose", first, "--held-out", second, "--gauge-length-mm", "25", "-o", str(effect), "--quiet"]) == 0
    )
    assert capsys.readouterr().out.startswith(
        "nothing is left above the noise of the recording that is fitted: no law is proposed"
    )
    assert sorted(p.name for p in tmp_path.iterdir()) == ["0.csv", "1.csv"]


@pytest.mark.parametrize(
    ("output", "said"),
    [("My Effect.py", "named after its file"), ("drift.py", "called drift already"), ("law.txt", "a Python file")],
)
def test_a_name_that_is_no_name_is_refused_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], output: str, said: str
):
    assert main(["propose", "not-there.csv", "-o", str(tmp_path / output)]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--json", "law.png"], "would be written twice"),
        (["--save-model", "law.png"], "would be written twice"),
        (["--plot", "law.txt"], "a figure is written as png, pdf, svg"),
    ],
)
def test_places_that_cannot_hold_the_result_are_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], said: str
):
    monkeypatch.chdir(tmp_path)
    assert main(["propose", "not-there.csv", "-o", "law.py", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_parameters_that_are_told_are_those_of_the_effect():
    proposed = found()
    told, grid = as_json(proposed)["laws"], proposed.grid
    for (law, name), one in zip(proposed.laws, told, strict=True):
        effect = effect_class(law, name, grid)(**one["parameters"])
        assert set(one["parameters"]) == set(one["units"]) == set(one["meanings"]) <= set(type(effect).model_fields)


def test_the_picture_says_in_which_unit_the_part_of_a_law_is():
    step = found().steps[0]
    lag = Term(COORDINATES["force"], (OPERATORS["lag"],))
    of_force = replace(step, option=replace(step.option, law=replace(step.option.law, term=lag)))
    assert [part_of(one) for one in (step, of_force)] == ["z = n", "z = y, in N"]


def test_too_short_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    short = write_csv(record(truth(), 12.0), tmp_path / "short.csv")
    assert main(["propose", short, "--gauge-length-mm", "25", "-o", str(tmp_path / "my_effect.py"), "--quiet"]) == 2
    assert "too short" in capsys.readouterr().err


def test_one_channel_alone_is_said():
    recording = record(truth(), 60.0, channels=("force_N",))
    notes = " ".join(not_judged(split(recording)[0]))
    assert "no resistance was recorded" in notes
    assert "no force" not in notes


def test_the_name_of_a_recording_cannot_end_the_docstring():
    assert '"' not in _safe('a"""\nimport os\n"""')
    assert "\n" not in _safe('a"""\nimport os\n"""')


def test_a_law_that_is_not_there_is_not_said():
    proposed = found()
    assert proposed.rejected is None
    assert first_line(proposed).startswith("proposed")


@pytest.mark.slow
@pytest.mark.real_data
@pytest.mark.skipif(not STRIP.is_dir(), reason="the measured recordings are not here")
def test_a_real_strip_of_carbon_black_gets_a_law_as_good_as_one_by_hand():
    first, second = (read_recording(STRIP / f"cb7.5_s2_triangles_prestrain10_{x}.csv", 40.0) for x in "ab")
    proposed = propose_law(first, second)
    assert proposed.error_after["conductance"] < 0.0139  # by hand, of 0.081 with the base laws alone
    # What rest makes and motion wipes out: a state, or a memory of what is sharp around no motion.
    law = proposed.steps[0].option.law
    at_rest = {"bell", "logarithm"} & {one.name for one in law.term.operators}
    assert at_rest or "wiped out by motion" in law.key
