"""Applying a compensator without a reference, and learning from resistance and force alone."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from compensation.cli import main
from compensation.export.export_c import c_header
from compensation.memories.history import History
from compensation.model import files as compensator_files
from compensation.model.prediction import predicted
from compensation.model.runtime import Status
from compensation.model.streaming import CompensatorStream
from compensation.training.options import Options
from gcode.support.errors import UserError
from testbench.recordings import doubts
from testbench.recordings.files import write_recording_csv
from tests.compensation.conftest import paused, train


@pytest.fixture(scope="module")
def compensator(recordings):
    history = History((0.5, 8.0), (0.2, 0.5, 1.0))
    return train(recordings[:1], "force", Options(sizes=(6, 3), restarts=1, history=history, engine="fast"))


def test_equals_the_stream_faulty_samples_included(compensator, recordings):
    time_s, ohm = recordings[1].time_s[:600].copy(), recordings[1]["resistance_ohm"][:600].copy()
    ohm[[0, 50, 51, 200]] = [np.nan, -1.0, 0.0, np.inf]
    time_s[[120, 300]] = [np.nan, time_s[299]]
    ohm[400] /= 50
    found = predicted(compensator, time_s, ohm)
    stream, last = CompensatorStream(compensator), None
    for row, (now, value, status) in enumerate(zip(time_s, found.value, found.status, strict=True)):
        conductance = 1.0 / ohm[row] if ohm[row] else np.inf
        step = now - last if last is not None else (0.05 if np.isfinite(now) else np.nan)
        assert stream.update(conductance, step) == pytest.approx(value, abs=1e-9)
        assert int(stream.status) == status
        if not stream.status & (Status.BAD_READING | Status.BAD_STEP):
            last = now


def test_a_long_pause_starts_anew(compensator, recordings):
    part = recordings[1].between(0, 30)
    time_s = np.concatenate([part.time_s, part.time_s + 7200])
    ohm = np.tile(part["resistance_ohm"], 2)
    found = predicted(compensator, time_s, ohm)
    np.testing.assert_allclose(found.value[len(part) :], found.value[: len(part)], atol=1e-7)


@pytest.mark.parametrize("jump_s", [1e9, 500.0, -500.0])
def test_a_clock_that_jumps_for_one_sample_spoils_that_one_alone(compensator, recordings, jump_s):
    part = recordings[1].between(0, 60)
    time_s = part.time_s.copy()
    time_s[700] += jump_s
    found = predicted(compensator, time_s, part["resistance_ohm"])
    assert list(np.flatnonzero(found.status & Status.BAD_STEP)) == [700]
    without = np.delete(np.arange(len(time_s)), 700)
    expected = predicted(compensator, time_s[without], part["resistance_ohm"][without])
    np.testing.assert_array_equal(found.value[without], expected.value)


def test_it_takes_lists_and_columns_of_a_table_and_no_two_lengths(compensator, recordings):
    part = recordings[1].between(0, 10)
    expected = predicted(compensator, part.time_s, part["resistance_ohm"]).value
    # The rows of a table that was cut keep their numbers, by which pandas would look up ours.
    table = pd.DataFrame({"time_s": part.time_s, "ohm": part["resistance_ohm"]}, index=np.arange(len(part)) + 1000)
    for time_s, ohm in ((part.time_s.tolist(), part["resistance_ohm"].tolist()), (table["time_s"], table["ohm"])):
        np.testing.assert_array_equal(predicted(compensator, time_s, ohm).value, expected)
    with pytest.raises(
        UserError, match=r"one number a sample each, got shapes \(3,\) and \(2,\); give the two columns"
    ):
        predicted(compensator, [0.0, 0.1, 0.2], [1e5, 1e5])
    with pytest.raises(UserError, match="predicted: time_s must be numbers, got dates"):
        predicted(compensator, pd.to_datetime(part.time_s, unit="s"), part["resistance_ohm"])
    with pytest.raises(UserError, match="predicted: resistance_ohm must be real numbers, got complex128"):
        predicted(compensator, part.time_s, part["resistance_ohm"] * 1j)
    assert (
        repr(predicted(compensator, [0.0, 0.1], [-1.0, -1.0])) == "<Prediction of force: 2 samples, 0 of them good>"
    )
    assert re.fullmatch(r"<CompensatorStream: \S+ N, STARTING>", repr(CompensatorStream(compensator)))
    with pytest.raises(UserError, match="conductance_S must be a number, got 'a'"):
        CompensatorStream(compensator).update("a")
    with pytest.raises(UserError, match="`name` must be a C identifier, got 5"):
        c_header(compensator, 5)


def test_what_was_learned_is_not_changed_in_place_and_can_be_told_apart(compensator):
    with pytest.raises(ValueError, match="read-only"):
        compensator.networks[0].weights[0][0] = 1.0
    with pytest.raises(TypeError, match="not changed in place"):
        compensator.recipe["trained_on"] = []
    assert compensator.networks[0] != deepcopy(compensator.networks[0])  # comparing arrays ended in a traceback


def test_a_prediction_is_a_table_that_nobody_writes_into(compensator, recordings):
    part = recordings[1].between(0, 10)
    time_s = part.time_s.copy()
    found = predicted(replace(compensator, margins=(-0.25, 0.5)), time_s, part["resistance_ohm"])
    time_s[0] = -1.0  # what was given stays the caller's
    table = found.to_frame()
    assert list(table) == ["time_s", "force_N", "low_N", "high_N", "status"]
    np.testing.assert_array_equal(table["time_s"], part.time_s)
    np.testing.assert_allclose(table["high_N"] - table["force_N"], 0.5)
    assert list(predicted(replace(compensator, target="displacement"), [0.0], [1e6]).to_frame())[1:3] == [
        "displacement_mm",
        "low_mm",
    ]
    for values in (found.time_s, found.value, found.low, found.high, found.status):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0


def test_command_writes_what_it_says(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    part = recordings[1].between(0, 60)
    pd.DataFrame({"time_s": part.time_s, "resistance_ohm": part["resistance_ohm"]}).to_csv(
        tmp_path / "worn.csv", index=False
    )
    words = ["predict", str(tmp_path / "worn.csv"), "--compensator", str(tmp_path / "c.json")]
    assert main([*words, "-o", str(tmp_path / "out.csv")]) == 0
    assert "wrote" in capsys.readouterr().out
    table = pd.read_csv(tmp_path / "out.csv")
    assert list(table) == ["time_s", "force_N", "low_N", "high_N", "status"]
    assert len(table) == len(part)
    error = table["force_N"] - part["force_N"]
    assert np.sqrt(np.mean(error[60:] ** 2)) < 0.5 * part["force_N"].std()


def test_what_cannot_be_predicted_is_said(compensator, tmp_path, capsys):
    with pytest.raises(UserError, match="mean and spread of the target"):
        predicted(replace(compensator, per_recording=True), np.arange(5.0), np.ones(5))
    compensator_files.save(tmp_path / "c.json", compensator)
    (tmp_path / "no.csv").write_text("time_s,force_N\n0,1\n")
    for name, words in (("no.csv", "no column resistance_ohm"), ("absent.csv", "cannot read this recording")):
        argv = ["predict", str(tmp_path / name), "--compensator", str(tmp_path / "c.json")]
        assert main([*argv, "-o", str(tmp_path / "out.csv")]) == 2
        assert words in capsys.readouterr().err


def test_resistance_and_force_alone_are_enough(recordings, tmp_path, capsys):
    """The same compensator as from the whole recording, with no gauge length given."""
    write_recording_csv(tmp_path / "whole.csv", recordings[0])
    pd.read_csv(tmp_path / "whole.csv").drop(columns="displacement_mm").to_csv(tmp_path / "bare.csv", index=False)
    networks = []
    for name in ("whole", "bare"):
        out = tmp_path / f"{name}.json"
        argv = ["train", str(tmp_path / f"{name}.csv"), "--target", "force", "--method", "paper", "--restarts", "1"]
        assert main([*argv, "--engine", "fast", "-o", str(out)]) == 0
        networks.append(compensator_files.load(out).networks[0].weights[0])
    np.testing.assert_array_equal(*networks)
    capsys.readouterr()
    assert main(["train", str(tmp_path / "bare.csv"), "--target", "displacement", "-o", str(out)]) == 2
    assert "displacement_mm is constant (zero throughout, as where the file has no such column)" in (
        capsys.readouterr().err
    )


def test_without_any_reference_there_is_nothing_to_learn(recordings, tmp_path, capsys):
    write_recording_csv(tmp_path / "r.csv", recordings[0])
    pd.read_csv(tmp_path / "r.csv")[["time_s", "resistance_ohm"]].to_csv(tmp_path / "r.csv", index=False)
    assert main(["train", str(tmp_path / "r.csv"), "--target", "force", "-o", str(tmp_path / "c.json")]) == 2
    said = capsys.readouterr().err
    assert "neither force_N nor displacement_mm (found: time_s, resistance_ohm)" in said
    assert "name yours, be it a strain, with `testbench import`" in said


def test_an_untared_force_is_refused(recordings, tmp_path, capsys):
    write_recording_csv(tmp_path / "t.csv", recordings[0])
    table = pd.read_csv(tmp_path / "t.csv")
    table["force_N"] += 20.0
    table.to_csv(tmp_path / "t.csv", index=False)
    assert main(["train", str(tmp_path / "t.csv"), "--target", "force", "-o", str(tmp_path / "c.json")]) == 2
    assert "not tared" in capsys.readouterr().err


def test_an_untared_force_that_is_not_used_is_not_refused(recordings, tmp_path):
    """The displacement is learned and scored to the last bit as beside a force that was tared."""
    scores = []
    for offset_N in (0.0, 20.0):
        force_N = recordings[0]["force_N"] + offset_N
        write_recording_csv(
            tmp_path / "t.csv", replace(recordings[0], channels={**recordings[0].channels, "force_N": force_N})
        )
        c, s = str(tmp_path / "c.json"), str(tmp_path / "s.json")
        words = ["train", str(tmp_path / "t.csv"), "--target", "displacement", "--restarts", "1", "--engine", "fast"]
        assert main([*words, "-o", c]) == 0
        assert main(["score", c, str(tmp_path / "t.csv"), "-o", s]) == 0
        scores.append(json.loads(Path(s).read_text())["summary"]["r2_after"])
    assert scores[0] == scores[1]


def predicting(folder):
    """The words of a prediction for ``r.csv`` by ``c.json``."""
    compensator, out = str(folder / "c.json"), str(folder / "o.csv")
    return ["predict", str(folder / "r.csv"), "--compensator", compensator, "-o", out]


def test_a_resistance_in_another_unit_is_asked_about(compensator, recordings, tmp_path, capsys):
    """Not one conductance of the training: kiloohm in a column of ohm."""
    compensator_files.save(tmp_path / "c.json", compensator)
    for factor, asked in ((1.0, False), (1e-3, True)):
        part = recordings[1].between(0, 60)
        resistance_ohm = factor * part["resistance_ohm"]
        resistance_ohm[7] = -1.0
        pd.DataFrame({"time_s": part.time_s, "resistance_ohm": resistance_ohm}).to_csv(
            tmp_path / "r.csv", index=False
        )
        assert main(predicting(tmp_path)) == 0
        printed = capsys.readouterr().out
        assert ("is resistance_ohm in ohm" in printed) == asked
        assert "under 0.1% with a resistance that is no positive number" in printed


def test_another_target_or_unit_is_refused(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    write_recording_csv(tmp_path / "r.csv", recordings[1])
    argv = predicting(tmp_path)
    for option, wanted in (("--target", "displacement"), ("--unit", "mm")):
        assert main([*argv, option, wanted]) == 2
        assert f"gives force in N, not the {option} {wanted}" in capsys.readouterr().err
        assert not (tmp_path / "o.csv").exists()
    assert main([*argv, "--target", "force", "--unit", "N"]) == 0


def test_a_prediction_takes_the_place_of_an_earlier_one_and_never_of_a_recording(
    compensator, recordings, tmp_path, capsys
):
    compensator_files.save(tmp_path / "c.json", compensator)
    for name in ("r.csv", "other.csv"):
        write_recording_csv(tmp_path / name, recordings[1])
    argv = predicting(tmp_path)
    assert main(argv) == main(argv) == 0
    assert main([*argv[:-1], str(tmp_path / "other.csv")]) == 2
    assert "a recording is there" in capsys.readouterr().err


def test_a_recording_shorter_than_the_slowest_memory_is_refused(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    write_recording_csv(tmp_path / "r.csv", recordings[1].between(0, compensator.slowest_s - 1))
    for argv in (predicting(tmp_path), ["score", str(tmp_path / "c.json"), str(tmp_path / "r.csv")]):
        assert main(argv) == 2
        assert f"slowest memory has {compensator.slowest_s:.0f} s" in capsys.readouterr().err


def test_a_gap_makes_no_recording_long_enough(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    write_recording_csv(tmp_path / "r.csv", paused(recordings[1].between(0, 20), 10, 60))
    training = ["train", str(tmp_path / "r.csv"), "--target", "force", "-o", str(tmp_path / "new.json")]
    for argv in (predicting(tmp_path), ["score", str(tmp_path / "c.json"), str(tmp_path / "r.csv")], training):
        assert main(argv) == 2
        assert re.search(r"r.csv: 20\.0 s long|longest recording has 20 s", capsys.readouterr().err)


@pytest.mark.parametrize("fault", ["no reading", "a clock that runs backwards"])
def test_what_has_no_good_sample_is_not_predicted(compensator, recordings, tmp_path, capsys, fault):
    compensator_files.save(tmp_path / "c.json", compensator)
    part = recordings[1].between(0, 60)
    frame = pd.DataFrame({"time_s": part.time_s, "resistance_ohm": part["resistance_ohm"]})
    frame = frame.assign(resistance_ohm=np.nan) if fault == "no reading" else frame[::-1]
    frame.to_csv(tmp_path / "r.csv", index=False)
    assert main(predicting(tmp_path)) == 2
    said = capsys.readouterr().err
    assert "r.csv: 0.0 s of good samples (a positive resistance, times in order)" in said
    assert "are faulty: mend time_s and resistance_ohm (`testbench import` has --sort and --drop-bad)" in said


def test_a_clock_in_milliseconds_is_asked_about(compensator, recordings, tmp_path, caplog, monkeypatch):
    monkeypatch.setattr(doubts, "_SAID", set())
    compensator_files.save(tmp_path / "c.json", compensator)
    part = recordings[1].between(0, 60)
    for factor in (1.0, 1000.0):
        write_recording_csv(tmp_path / "r.csv", replace(part, time_s=factor * part.time_s))
        assert main(predicting(tmp_path)) == 0
        assert ("is its time in s?" in caplog.text) == (factor != 1.0)
