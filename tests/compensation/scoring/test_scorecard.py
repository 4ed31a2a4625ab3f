"""The score of a compensator as a document."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from compensation.scoring.scorecard import score_recordings
from compensation.training.options import Options
from compensation.training.training import train


def test_a_window_without_samples_is_left_out(recordings):
    compensator = train(recordings[:1], "force", Options(sizes=(2,), restarts=1, engine="fast"))
    recording = recordings[2]
    late_s = np.where(recording.time_s > recording.duration_s / 2, 300.0, 0.0)
    paused = replace(recording, time_s=recording.time_s + late_s)
    (row,) = score_recordings(replace(compensator, start="causal", irregular=True), [paused])["recordings"]
    assert len(row["zooms"]) == 2
    assert all(zoom["time_s"] for zoom in row["zooms"])
