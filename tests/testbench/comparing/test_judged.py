"""One model has one error on one recording: the ladder, the command, the notebook and the page agree."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import gcode
import testbench as tb
from gcode.support.errors import UserError
from testbench.cli import main
from testbench.comparing.clamping import moved
from testbench.comparing.judged import check_judged_on, held_samples, judged
from testbench.comparing.ladder import as_a_step, on_the_ladder
from testbench.comparing.remounting import held_errors
from testbench.fitting.fit import fit
from testbench.measurements.joining import joined
from testbench.measurements.preparing import prepare
from testbench.measurements.splitting import split
from testbench.recordings.between import Between
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile, same_source
from tests.testbench.builders import CATALOGUE, NOISE_LN, record, truth, write_csv

SHIFT_MM = 0.6


def named(recording: Recording, source: str) -> Recording:
    return replace(recording, source=source)


@pytest.fixture(scope="module")
def own() -> Recording:
    return named(record(truth(), 120, seed=1), "a.csv")


@pytest.fixture(scope="module")
def anew() -> Recording:
    """Another recording of the sensor, put in 0.6 mm higher."""
    other = record(truth(), 120, seed=2)
    channels = {**other.channels, "displacement_mm": other["displacement_mm"] - SHIFT_MM}
    return replace(other, channels=channels, source="b.csv")


@pytest.fixture(scope="module")
def clamped_file(own: Recording, anew: Recording) -> ModelFile:
    calibration, held = split(own, anew, between=Between(clamp_play_mm=0.5))
    return on_the_ladder(fit(truth(), calibration), None, "baseline", calibration, held)


def test_the_held_out_recording_keeps_the_zero_that_the_ladder_found(clamped_file, anew) -> None:
    found = tb.compare(anew, clamped_file)
    assert found.comparison.rms == pytest.approx(clamped_file.history[-1]["errors"]["held_out"], rel=1e-3)
    assert found.to_dict()["clamped_anew"] == clamped_file.history[-1]["zero"]
    assert "clamped anew (play 0.5 mm)" in found.notes[0]


def test_a_third_recording_finds_its_zero_where_play_is_given_and_offers_to_where_not(clamped_file, anew) -> None:
    third = named(anew, "c.csv")
    bound, free = tb.compare(third, clamped_file), tb.compare(third, clamped_file, clamp_play_mm=0.5)
    assert "clamped_anew" not in bound.to_dict()
    assert "`clamp_play_mm`" in bound.notes[0]
    assert free.to_dict()["clamped_anew"]["shift_mm"] == pytest.approx(SHIFT_MM, abs=0.1)
    assert free.comparison.rms["force"] < 0.5 * bound.comparison.rms["force"]


def test_the_model_s_own_recording_has_no_play(clamped_file, own, anew) -> None:
    assert not judged(clamped_file, own).elsewhere
    with pytest.raises(UserError, match="its zero is the model's own"):
        judged(clamped_file, own, clamp_play_mm=0.5)
    with pytest.raises(UserError, match=r"must be from 0 to 2\.5 mm"):
        judged(clamped_file, anew, clamp_play_mm=9.0)


def test_a_recording_that_was_fitted_on_two_thirds_is_judged_on_the_last(tmp_path, capsys) -> None:
    path, model = write_csv(record(truth(), 120, seed=1), tmp_path / "a.csv"), str(tmp_path / "model.json")
    assert main(["fit", path, "--gauge-length-mm", "25", "-o", model]) == 0
    capsys.readouterr()
    assert main(["compare", path, "--model", model, "--json"]) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    rms = {channel: entry["rms"] for channel, entry in told["channels"].items()}
    assert rms == json.loads((tmp_path / "model.json").read_text())["history"][-1]["errors"]["held_out"]
    assert told["judged_from_s"] == pytest.approx(80, abs=0.1)
    assert "judged on its last third, from 80 s on" in said.err
    assert main(["compare", path, "--model", model, "--clamp-play-mm", "0.5"]) == 2
    assert "was fitted on this recording" in capsys.readouterr().err


def test_what_belongs_to_one_recording_is_free_on_another_one(own) -> None:
    hum = CATALOGUE["periodic_interference"]()
    model = truth().plus(hum)
    other = named(record(model, 120, seed=2), "b.csv")
    file = ModelFile(model, 25.0, fitted_on="a.csv", held_out="c.csv")
    measurement = prepare(other)
    turned = replace(file, model=truth().plus(hum.replaced(phase_rad=hum.phase_rad - 2)))
    rms = tb.compare(other, turned).comparison.rms
    assert rms == pytest.approx(held_errors(turned.model, measurement), rel=1e-9)
    assert rms["conductance"] < 1.2 * NOISE_LN, "the phase was found again"


def test_moving_the_origin_is_the_only_thing_that_a_zero_does(clamped_file, anew) -> None:
    on = judged(clamped_file, anew)
    shift = clamped_file.history[-1]["zero"]["shift_mm"]
    expected = moved(prepare(anew), shift).signals["strain"]
    assert np.array_equal(on.measurement.signals["strain"], expected)


def test_a_folder_that_has_moved_is_known_by_the_names_in_it(tmp_path) -> None:
    here = tmp_path / "knit" / "recording.csv"
    here.parent.mkdir()
    here.touch()
    assert same_source(str(here), str(tmp_path / "x" / ".." / "knit" / "recording.csv"))
    assert same_source("/gone/knit/recording.csv", str(here))
    assert not same_source("/gone/other/recording.csv", str(here))
    assert not same_source(str(here), "/elsewhere/knit/recording.csv")
    assert not same_source("", "")


def test_recordings_in_memory_are_told_apart_by_their_content() -> None:
    columns = {"time_s": [0, 1, 2], "displacement_mm": [0, 1, 0], "force_N": [0, 2, 1]}
    first, again = tb.read(columns, gauge_length_mm=25), tb.read(dict(columns), gauge_length_mm=25)
    assert first.source == again.source
    assert first.source != tb.read(columns | {"force_N": [0, 2, 2]}, gauge_length_mm=25).source
    time_s, channels = columns["time_s"], {name: columns[name] for name in ("displacement_mm", "force_N")}
    assert Recording(time_s, channels, 25).source == first.source, "whoever made it"


def test_one_program_on_two_sensors_makes_two_recordings_of_two_names() -> None:
    """Else a model of the one counts as fitted on the other, and is judged on its last third with its zeros free."""
    plain, relaxing = tb.example(duration_s=20), tb.example(tb.effects.StressRelaxation(), duration_s=20)
    assert plain.source != relaxing.source
    assert plain.source == tb.example(duration_s=20).source
    assert (
        tb.compare(relaxing, ModelFile(truth(), 25.0, plain.source, plain.source)).to_dict().get("judged_from_s")
        is None
    )
    program = gcode.generate("paper-1", seed=3, duration_s=20)
    assert tb.simulate("pes", program).source != tb.simulate("lycra", program).source


def test_a_model_without_a_law_for_a_channel_is_one_sentence(own, tmp_path, capsys) -> None:
    path, model = write_csv(own, tmp_path / "a.csv"), tmp_path / "model.json"
    force_only = truth().without("contact").without("drift")
    ModelFile(force_only, 25.0).save(model)
    assert main(["compare", path, "--model", str(model)]) == 2
    assert "has a conductance, and the model (elasticity, hysteresis) simulates none" in capsys.readouterr().err


def test_what_several_recordings_were_before_is_missed_aloud(own, anew, caplog) -> None:
    """Diagnosed as one history, they make another error of what is held out than it has alone."""
    both = joined([own, named(record(truth(), 120, seed=3), "d.csv")], [60.0])
    file = as_a_step(truth(), {}, None, "baseline", both, prepare(anew))
    assert file.of_several
    assert not replace(file, history=()).of_several, "whatever the recording is called"
    words = "judged as of a fresh specimen; it is of that of 2 recordings, not there to say what it had gone through"
    assert words in judged(file, anew).doubt
    assert "taken for new; the model was fitted on 2 recordings in a row, and if this is" in judged(file, own).doubt
    assert judged(replace(file, history=()), own).doubt == ""
    held_samples(file, own, anew)
    assert words in caplog.text


def test_other_samples_of_the_same_noise_are_told_by_the_error_of_the_model(own) -> None:
    """One recording in forty has the noise floor of another in its only channel."""
    held, ramp_N = prepare(own), 0.3 * own.time_s / own.time_s[-1]
    other = prepare(replace(own, channels={**own.channels, "force_N": own["force_N"] + ramp_N}))
    step = as_a_step(truth(), {}, None, "baseline", held, held).history[-1]
    check_judged_on(held, step, truth())
    with pytest.raises(UserError, match="judged on other samples: their error is force"):
        check_judged_on(other, step, truth())
    check_judged_on(other, {**step, "recordings": 2}, truth())
