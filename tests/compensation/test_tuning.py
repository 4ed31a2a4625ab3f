"""The tuned compensator chooses from the training recording alone, and no seed is a bad one."""

from __future__ import annotations

import numpy as np
import pytest

from compensation import tuning
from compensation.scorecard import score_recordings
from compensation.training import Options, train

QUICK = Options(engine="fast")


@pytest.fixture(scope="module")
def tuned(recordings):
    """Tuned on the first recording."""
    return train(recordings[:1], "displacement", QUICK, tuned=True)


def test_it_beats_the_mean_of_the_papers_network(tuned, recordings):
    paper = [
        score_recordings(train(recordings[:1], "displacement", Options(restarts=1, seed=seed)), recordings[1:])
        for seed in range(6)
    ]
    mean = np.mean([scores["summary"]["r2_after"] for scores in paper])
    assert score_recordings(tuned, recordings[1:])["summary"]["r2_after"] > mean


def test_the_recipe_tells_every_choice(tuned):
    tried = tuned.recipe["cross_validation"]
    assert len(tried) == len(tuning.BANKS) + len(tuning.PENALTIES) - 1
    best = max(tried, key=lambda row: row["r2"])
    assert tuned.recipe["l2"] == best["l2"]
    assert tuned.recipe["cross_validated_r2"] == best["r2"]
    assert len(tuned.networks) + tuned.recipe["dead_networks"] == tuning.ENSEMBLE


def test_cross_validation_blocks_are_contiguous(recordings, monkeypatch):
    """Each fold's network never sees the block that it is judged on, nor a sample inside it."""
    seen = []

    def recorder(features, truth, options, seed):
        from compensation.network import Network

        seen.append(len(truth))
        return tuning.Fit(Network((np.zeros((7, 1)),), (np.zeros(1),)), np.zeros(1))

    monkeypatch.setattr(tuning, "_fit", recorder)
    from compensation.preprocessing import series_of

    series = [series_of(recordings[0], "force", 20.0)]
    score = tuning.cross_validated(series, "force", Options())
    assert score == pytest.approx(0.0, abs=1e-12)
    assert len(seen) == tuning.FOLDS
    assert sum(seen) == (tuning.FOLDS - 1) * len(series[0])


def test_restarts_leave_no_bad_seed(recordings):
    """Best of five by training score: the worst of several seeds is near the median."""
    scores = [
        score_recordings(train(recordings[:1], "force", Options(engine="fast", seed=100 * seed)), recordings[1:])
        for seed in range(8)
    ]
    after = [row["summary"]["r2_after"] for row in scores]
    assert min(after) > np.median(after) - 0.03
