"""The score of a compensator as a document."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.model import files
from compensation.model.prediction import predicted
from compensation.model.streaming import CompensatorStream
from compensation.scoring.scorecard import score_recordings
from compensation.series import score
from compensation.series.preprocessing import passages_of, series_of
from compensation.training.options import Options
from compensation.training.recalibration import recalibrated
from tests.compensation.conftest import paused, train

SMALL = Options(sizes=(2,), restarts=1, engine="fast")


@pytest.fixture(scope="module")
def compensator(recordings):
    return train(recordings[:1], "force", SMALL)


def test_a_window_without_samples_is_left_out(compensator, recordings):
    recording = recordings[2]
    broken = paused(recording, recording.duration_s / 2, 300.0)
    (row,) = score_recordings(replace(compensator, start="causal", irregular=True), [broken])["recordings"]
    assert len(row["zooms"]) == 2
    assert all(zoom["time_s"] for zoom in row["zooms"])


@pytest.mark.parametrize("rate_hz", [1.0, 5.0])
def test_a_slow_recording_is_scored_as_it_is_predicted(recordings, rate_hz):
    """On a grid between its samples a straight line would show the next one in advance."""
    slow = recordings[1].resampled(rate_hz)
    compensator = train([slow], "force", SMALL)
    told = predicted(compensator, slow.time_s, slow["resistance_ohm"]).value
    (row,) = score_recordings(compensator, [slow])["recordings"]
    assert (row["role"], row["samples"]) == ("training", len(slow))
    assert row["r2_after"] == pytest.approx(score.r2(slow["force_N"], told), abs=1e-12)


def test_a_trace_keeps_its_times(compensator, recordings):
    """Seconds since 1970, to the microsecond."""
    since_1970 = replace(recordings[1], time_s=recordings[1].time_s + 1.7e9)
    (row,) = score_recordings(compensator, [since_1970])["recordings"]
    for trace in (row["trace"], *row["zooms"]):
        steps_s = np.diff(trace["time_s"])
        assert steps_s.min() == pytest.approx(steps_s.max(), abs=2e-6)
    assert row["trace"]["time_s"][0] == pytest.approx(since_1970.time_s[0], abs=1e-6)


def test_a_gap_is_no_part_of_a_score(compensator, recordings):
    """Over ten minutes of nothing the grid has straight lines, which nobody has measured."""
    recording = recordings[1]
    whole, broken = (
        score_recordings(compensator, [one])["recordings"][0] for one in (recording, paused(recording, 120.0, 600.0))
    )
    assert broken["samples"] == pytest.approx(whole["samples"], abs=3)
    assert broken["r2_after"] == pytest.approx(whole["r2_after"], abs=0.05)


def test_a_gap_is_no_part_of_a_training(compensator, recordings):
    whole, learned = (compensator, train([paused(recordings[0], 120.0, 600.0)], "force", SMALL))
    assert learned.recipe["samples"] == pytest.approx(whole.recipe["samples"], abs=3)
    assert learned.scaling_out.scale == pytest.approx(whole.scaling_out.scale, rel=1e-3)
    before, after = (score_recordings(one, recordings[1:2])["recordings"][0]["r2_after"] for one in (whole, learned))
    assert after == pytest.approx(before, abs=0.03)


def test_memories_go_on_over_a_gap_as_a_stream_does(compensator, recordings):
    """The sample after a pause stands for all of it."""
    part = series_of(paused(recordings[1], 120.0, 600.0), "force", 20.0)
    stream = CompensatorStream(compensator)
    steps_s = np.diff(part.time_s, prepend=part.time_s[0] - 0.05)
    streamed = [stream.update(*one) for one in zip(part.conductance_S, steps_s, strict=True)]
    np.testing.assert_allclose(compensator.in_use.predict_series(part), streamed, atol=1e-9)


def test_a_recording_that_has_grown_was_learned_from(recordings):
    """Its first half must not count as held out."""
    first = recordings[0].between(0.0, recordings[0].duration_s / 2)
    compensator = train([first], "force", SMALL)
    scores = score_recordings(compensator, [first, *recordings[:2]])
    assert [row["role"] for row in scores["recordings"]] == ["training", "training", "held-out"]


def test_a_part_of_what_was_learned_from_was_learned_from(compensator, recordings, tmp_path):
    """Whatever its name, its times and the sample it begins with; at rest two recordings may be alike by chance."""
    files.save(tmp_path / "c.json", compensator)
    cut = [one.between(101.3, 130.0) for one in recordings[:2]]
    parts = [replace(one, time_s=one.time_s - one.time_s[0], source="elsewhere") for one in cut]
    scores = score_recordings(files.load(tmp_path / "c.json"), parts)
    assert [row["role"] for row in scores["recordings"]] == ["training", "held-out"]
    at_rest = np.tile([1e6, 1e6 + 1], 100)
    assert not len(passages_of(at_rest))


def test_a_reference_was_not_held_out(compensator, recordings):
    found = recalibrated(compensator, series_of(recordings[1], "force", 20.0))
    scores = score_recordings(found, recordings)
    assert [row["role"] for row in scores["recordings"]] == ["training", "reference", "held-out"]
    assert scores["summary"]["recordings"] == 1
    assert score_recordings(found, recordings[:2])["summary"]["over"] == "training and reference"


def test_every_reference_is_known_by_what_was_read(compensator, recordings, tmp_path):
    """Under whatever name, at rest as well, and the first of two recalibrations no less than the last."""
    found = compensator
    minute = series_of(recordings[1].between(0.0, 60.0), "force", 20.0)
    ohm = recordings[2]["resistance_ohm"]
    resting = replace(recordings[2], channels={**recordings[2].channels, "resistance_ohm": 0.9 * ohm[0] + 0.1 * ohm})
    rest = series_of(resting.between(0.0, 20.0), "force", 20.0)
    for reference in (minute, replace(rest, truth=np.zeros(len(rest)))):
        found = recalibrated(found, reference)
    files.save(tmp_path / "c.json", found)
    again = files.load(tmp_path / "c.json")
    assert again.recipe == found.recipe
    elsewhere = [replace(recording, source="elsewhere") for recording in (*recordings[:2], resting)]
    stranger = replace(recordings[1].between(60.0, 120.0), source=minute.source)
    scores = score_recordings(again, [*elsewhere, stranger])
    assert [row["role"] for row in scores["recordings"]] == ["training", "reference", "reference", "held-out"]


def test_a_reference_of_an_older_file_is_known_by_its_path(compensator, recordings, tmp_path):
    old = replace(compensator, recipe={**compensator.recipe, "recalibrated": {"on": recordings[1].source}})
    files.save(tmp_path / "c.json", old)
    again = files.load(tmp_path / "c.json")
    assert again.recipe["recalibrated"] == [{"on": recordings[1].source}]
    assert [row["role"] for row in score_recordings(again, recordings[1:])["recordings"]] == ["reference", "held-out"]
    found = recalibrated(again, series_of(recordings[2], "force", 20.0))
    assert {row["role"] for row in score_recordings(found, recordings[1:])["recordings"]} == {"reference"}
