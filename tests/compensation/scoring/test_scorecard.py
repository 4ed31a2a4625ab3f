"""The score of a compensator as a document."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.scoring.scorecard import score_recordings
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.recalibration import recalibrated
from compensation.training.training import train


def test_a_window_without_samples_is_left_out(recordings):
    compensator = train(recordings[:1], "force", Options(sizes=(2,), restarts=1, engine="fast"))
    recording = recordings[2]
    late_s = np.where(recording.time_s > recording.duration_s / 2, 300.0, 0.0)
    paused = replace(recording, time_s=recording.time_s + late_s)
    (row,) = score_recordings(replace(compensator, start="causal", irregular=True), [paused])["recordings"]
    assert len(row["zooms"]) == 2
    assert all(zoom["time_s"] for zoom in row["zooms"])


def test_a_gap_is_no_part_of_a_score(recordings):
    """Over ten minutes of nothing the grid has straight lines, which nobody has measured."""
    compensator = train(recordings[:1], "force", Options(sizes=(2,), restarts=1, engine="fast"))
    recording = recordings[1]
    gap_s = np.where(recording.time_s > recording.duration_s / 2, 600.0, 0.0)
    whole, paused = (
        score_recordings(compensator, [one])["recordings"][0]
        for one in (recording, replace(recording, time_s=recording.time_s + gap_s))
    )
    assert paused["samples"] == pytest.approx(whole["samples"], abs=3)
    assert paused["r2_after"] == pytest.approx(whole["r2_after"], abs=0.05)


def test_a_reference_was_not_held_out(recordings):
    compensator = train(recordings[:1], "force", Options(sizes=(2,), restarts=1, engine="fast"))
    found = recalibrated(compensator, series_of(recordings[1], "force", 20.0))
    scores = score_recordings(found, recordings)
    assert [row["role"] for row in scores["recordings"]] == ["training", "reference", "held-out"]
    assert scores["summary"]["recordings"] == 1
