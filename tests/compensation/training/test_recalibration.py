"""Recalibration: what was changed is found again, a minute of reference is no licence to run away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.cli import main
from compensation.model import files as compensator_files
from compensation.series import score
from compensation.series.preprocessing import Series, series_of
from compensation.training.options import Options
from compensation.training.recalibration import Correction, correction, recalibrated
from gcode.support.errors import UserError
from testbench.recordings import doubts
from testbench.recordings.files import write_recording_csv
from testbench.recordings.recording import Recording
from tests.compensation.conftest import paused, train


@pytest.fixture(scope="module")
def compensator(recordings):
    return train(recordings[:1], "force", Options(restarts=3, engine="fast"))


@pytest.fixture(scope="module")
def test_part(recordings):
    return series_of(recordings[1], "force", 20.0)


def changed(part: Series, gain: float) -> Series:
    """The same knit with other yarn resistance: every conductance times `gain`."""
    return replace(part, conductance_S=gain * part.conductance_S)


def first(part: Series, seconds: float) -> Series:
    return part.rows(np.flatnonzero(part.time_s < part.time_s[0] + seconds))


@pytest.mark.parametrize("gain", [0.75, 1.3])
def test_a_minute_makes_up_for_another_resistance(compensator, test_part, gain):
    other = changed(test_part, gain)

    def r2(one):
        return score.r2_ordinary(other.truth[1200:], one.predict_series(other)[1200:])

    found = recalibrated(compensator, first(other, 60))
    right = score.r2_ordinary(test_part.truth[1200:], compensator.predict_series(test_part)[1200:])
    lost = right - r2(compensator)
    assert lost > 0.1
    # The spreads hold it back: a minute is not trusted to make up for everything.
    assert right - r2(found) < 0.6 * lost
    (note,) = found.recipe["recalibrated"]
    assert note["rms_after"] < note["rms_before"]
    assert compensator.recipe.get("recalibrated") is None


def test_what_fits_already_is_left_alone(compensator, recordings):
    part = first(series_of(recordings[0], "force", 20.0), 60)
    own = replace(part, truth=compensator.in_use.predict_series(part))
    found = correction(compensator, own)
    assert vars(found) == pytest.approx(vars(Correction()), abs=0.02)


def test_rest_moves_the_zero(compensator, test_part):
    time_s = np.arange(0.0, 30.0, 0.05)
    held = np.ones(len(time_s))
    rest = Series(time_s, held * test_part.conductance_S.mean(), held * 0.0, "rest")
    before = compensator.in_use.predict_series(rest)[-1]
    after = recalibrated(compensator, rest).in_use.predict_series(rest)[-1]
    assert abs(after) < 0.7 * abs(before)


@pytest.mark.parametrize("noise", [1e-3, 1e-2])
def test_a_reference_stands_still_whatever_its_noise(compensator, test_part, noise):
    """A compensator that falls short at the end of its range does so of a weight, be it read with noise or not."""
    promised = replace(compensator, recipe={**compensator.recipe, "cross_validated": {"r2": 0.5}})
    time_s, rng = np.arange(0.0, 30.0, 0.05), np.random.default_rng(0)
    top = float(test_part.truth.max())
    weight = Series(time_s, np.full(len(time_s), test_part.conductance_S.max()), np.full(len(time_s), top), "weight")
    noisy = replace(weight, truth=top + noise * rng.standard_normal(len(time_s)))
    still, read = (vars(correction(promised, part)) for part in (weight, noisy))
    assert read == pytest.approx(still, abs=0.01)
    assert abs(vars(correction(compensator, noisy))["shift_out"] - read["shift_out"]) > 0.05


def test_the_command_saves_what_predict_reads(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    write_recording_csv(tmp_path / "r.csv", recordings[1])
    out = tmp_path / "new.json"
    argv = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "-o", str(out)]
    assert main([*argv, "--seconds", "45"]) == 0
    assert "45 s of reference" in capsys.readouterr().out
    assert compensator_files.load(out).recipe["recalibrated"][0]["seconds"] == pytest.approx(45, abs=0.1)
    assert main([*argv, "--seconds", "6"]) == 0
    assert main([*argv, "--seconds", "2"]) == 2
    assert "--seconds must be a number from 5 on" in capsys.readouterr().err


def test_a_gap_is_no_reference(compensator, recordings, tmp_path, capsys, caplog, monkeypatch):
    """It does not count as time that says anything, it is not a straight line, and it is said."""
    monkeypatch.setattr(doubts, "_SAID", set())
    compensator_files.save(tmp_path / "c.json", compensator)
    argv = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "-o", str(tmp_path / "new.json")]
    write_recording_csv(tmp_path / "r.csv", paused(recordings[1], 12.0, 30.0))
    assert main([*argv, "--seconds", "42"]) == 0
    assert "12 s of reference" in capsys.readouterr().out
    assert "nothing was recorded in 30.0" in caplog.text
    assert main([*argv, "--seconds", "20"]) == 0
    assert "12 s of reference" in capsys.readouterr().out
    write_recording_csv(tmp_path / "r.csv", paused(recordings[1], 3.0, 30.0))
    assert main([*argv, "--seconds", "20"]) == 2
    assert "3.0 s of reference; a recalibration needs at least 5 s" in capsys.readouterr().err


def test_a_gap_weighs_nothing(compensator, test_part):
    """Ten minutes of nothing in a minute of reference leave the correction where it was."""
    other = changed(first(test_part, 60), 1.3)
    with_gap = replace(other, time_s=other.time_s + 600.0 * (other.time_s > other.time_s[0] + 59))
    found, expected = (vars(correction(compensator, one)) for one in (with_gap, other))
    assert found == pytest.approx(expected, abs=0.02)


def test_a_rest_with_a_gap_has_no_points_in_it(compensator, recordings, tmp_path):
    rest = still(recordings[1], resistance_ohm=float(recordings[1]["resistance_ohm"][0]))
    write_recording_csv(tmp_path / "rest.csv", paused(rest, 5.0, 30.0))
    out = tmp_path / "new.json"
    compensator_files.save(tmp_path / "c.json", compensator)
    words = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "rest.csv"), "--rest", "--seconds", "40"]
    assert main([*words, "-o", str(out)]) == 0
    assert compensator_files.load(out).recipe["recalibrated"][0]["seconds"] == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("rate_hz", [None, 10.0, 7.0])
@pytest.mark.parametrize("begin_s", [0.0, 1.7e9])
@pytest.mark.parametrize("irregular", [True, False])
@pytest.mark.parametrize("rest", [True, False])
def test_the_least_reference_is_enough(compensator, recordings, tmp_path, rate_hz, begin_s, irregular, rest):
    """Five seconds that are asked for are five, wherever the samples lie."""
    part = recordings[1] if rate_hz is None else recordings[1].resampled(rate_hz)
    part = replace(still(part, resistance_ohm=float(part["resistance_ohm"][0])), time_s=part.time_s + begin_s)
    write_recording_csv(tmp_path / "r.csv", part)
    compensator_files.save(tmp_path / "c.json", replace(compensator, irregular=irregular))
    words = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "--seconds", "5"]
    assert main([*words, "-o", str(tmp_path / "new.json"), *(["--rest"] if rest else [])]) == 0


@pytest.mark.parametrize("command", ["recalibrate c.json r.csv -o new.json", "score c.json r.csv"])
def test_a_recording_in_another_unit_is_asked_about(compensator, recordings, tmp_path, caplog, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(doubts, "_SAID", set())
    compensator_files.save(tmp_path / "c.json", compensator)
    for factor in (1.0, 1e-3):
        ohm = factor * recordings[1]["resistance_ohm"]
        part = replace(recordings[1], channels={**recordings[1].channels, "resistance_ohm": ohm})
        write_recording_csv(tmp_path / "r.csv", part)
        assert main(command.split()) == 0
        assert ("r.csv: no sample has a conductance" in caplog.text) == (factor != 1.0)


def still(recording: Recording, **channels: float) -> Recording:
    """The same recording of a sensor that holds still: some channels at one value throughout."""
    held = {name: np.full(len(recording), value) for name, value in channels.items()}
    return replace(recording, channels={**recording.channels, **held})


def test_rest_is_taken_from_a_sensor_that_rests(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    resistance_ohm = float(recordings[1]["resistance_ohm"][0])
    for name, one in (("moved", recordings[1]), ("rest", still(recordings[1], resistance_ohm=resistance_ohm))):
        write_recording_csv(tmp_path / f"{name}.csv", one)

    def code(name: str) -> int:
        words = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / f"{name}.csv"), "--rest", "--seconds", "20"]
        return main([*words, "-o", str(tmp_path / "new.json")])

    assert code("rest") == 0
    assert code("moved") == 2
    said = capsys.readouterr().err
    assert "times as far as in the training, at rest it does 0.5 times at most" in said
    assert said.count("\n") == 1


def test_a_reference_may_stand_still(compensator, recordings, tmp_path, capsys):
    compensator_files.save(tmp_path / "c.json", compensator)
    argv = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "-o", str(tmp_path / "new.json")]
    resistance_ohm = float(recordings[1]["resistance_ohm"].mean())
    weight = still(recordings[1], force_N=0.3, resistance_ohm=resistance_ohm)
    write_recording_csv(tmp_path / "r.csv", weight)
    assert main(argv) == 0
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(weight))
    write_recording_csv(tmp_path / "r.csv", replace(weight, channels={**weight.channels, "force_N": 0.3 + noise}))
    assert main(argv) == 0
    write_recording_csv(tmp_path / "r.csv", still(recordings[1], force_N=0.0))
    capsys.readouterr()
    assert main(argv) == 2
    assert "say so with --rest" in capsys.readouterr().err


def test_a_reference_that_stands_still_beside_a_moving_sensor_is_refused(compensator, recordings, tmp_path, capsys):
    """A load cell that is not connected says nothing of a sensor that is stretched, whatever its noise."""
    compensator_files.save(tmp_path / "c.json", compensator)
    argv = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "-o", str(tmp_path / "new.json")]
    dead = still(recordings[1], force_N=0.3)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(dead))
    for force_N in (dead["force_N"], dead["force_N"] + noise):
        write_recording_csv(tmp_path / "r.csv", replace(dead, channels={**dead.channels, "force_N": force_N}))
        assert main(argv) == 2
        said = capsys.readouterr().err
        assert "the force stands still at 0.3 N while the conductance spreads" in said
        assert said.count("\n") == 1


def test_a_sensor_that_stands_still_beside_a_moving_reference_is_refused(compensator, test_part):
    """One that is not connected was corrected to half the error, with a gain of 1.7."""
    part, rng = first(test_part, 60), np.random.default_rng(0)
    for noise in (0.0, 0.01):
        read = compensator.scaling_in.invert(noise * rng.standard_normal(len(part)))
        with pytest.raises(UserError, match=r"the conductance stands still .* while the force moves"):
            recalibrated(compensator, replace(part, conductance_S=read))


@pytest.mark.parametrize("seconds", ["60", "6"])
def test_a_reference_that_was_never_tared_is_refused(compensator, recordings, tmp_path, capsys, seconds):
    compensator_files.save(tmp_path / "c.json", compensator)
    recording = recordings[1]
    untared = replace(recording, channels={**recording.channels, "force_N": recording["force_N"] + 100.0})
    write_recording_csv(tmp_path / "untared.csv", untared)
    out = tmp_path / "new.json"
    words = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "untared.csv"), "--seconds", seconds]
    assert main([*words, "-o", str(out)]) == 2
    said = capsys.readouterr().err
    assert "force_N lies between" in said
    assert "it was not tared" in said
    assert not out.exists()


def test_a_spike_of_the_cell_is_no_reference(compensator, recordings, tmp_path, capsys):
    """One reading of nearly a million newton leaves the correction where it was; one in another unit is refused."""
    compensator_files.save(tmp_path / "c.json", compensator)
    argv = ["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "r.csv"), "-o", str(tmp_path / "new.json")]
    found = []
    for spike_N in (0.0, 9e5):
        force_N = recordings[1]["force_N"].copy()
        force_N[1200] += spike_N
        one = replace(recordings[1], channels={**recordings[1].channels, "force_N": force_N})
        write_recording_csv(tmp_path / "r.csv", one)
        assert main(argv) == 0
        assert ("sample(s) beyond" in capsys.readouterr().out) == bool(spike_N)
        (note,) = compensator_files.load(tmp_path / "new.json").recipe["recalibrated"]
        found.append([note[name] for name in ("gain_in", "shift_in", "gain_out", "shift_out", "rms_after")])
    np.testing.assert_allclose(*found, atol=0.01)
    channels = {**recordings[1].channels, "force_N": 1e3 * recordings[1]["force_N"]}
    write_recording_csv(tmp_path / "r.csv", replace(recordings[1], channels=channels))
    assert main(argv) == 2
    assert "as far as the training went; check that the force is in N" in capsys.readouterr().err


@pytest.mark.parametrize("more", [[], ["--rest"]])
def test_a_clock_in_ms_is_refused(compensator, recordings, tmp_path, capsys, more):
    compensator_files.save(tmp_path / "c.json", compensator)
    write_recording_csv(tmp_path / "ms.csv", replace(recordings[1], time_s=1e3 * recordings[1].time_s))
    out = tmp_path / "new.json"
    assert main(["recalibrate", str(tmp_path / "c.json"), str(tmp_path / "ms.csv"), "-o", str(out), *more]) == 2
    assert "is its time in s? At 20 Hz nearly all of it would be straight lines" in capsys.readouterr().err
    assert not out.exists()


def test_too_little_reference_is_said(compensator, test_part):
    with pytest.raises(UserError, match=r"4.0 s of reference; a recalibration needs at least 5 s"):
        recalibrated(compensator, first(test_part, 4))
    with pytest.raises(UserError, match="knows no level"):
        recalibrated(replace(compensator, per_recording=True), test_part)
