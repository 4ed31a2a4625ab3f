"""scikit-learn's conventions hold for the bank and the pipeline."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, GroupKFold
from sklearn.utils.estimator_checks import check_estimator

from compensation.estimators.bank import EXPECTED_FAILED_CHECKS, SmoothingBank, paper_pipeline
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.training import train


def test_check_estimator():
    # Checks that cannot run are announced as warnings; those that fail raise.
    results = check_estimator(
        SmoothingBank(count=2), expected_failed_checks=EXPECTED_FAILED_CHECKS, on_skip=None, on_fail="raise"
    )
    failed = {result["check_name"] for result in results if result["status"] == "xfail"}
    assert failed == set(EXPECTED_FAILED_CHECKS)


def test_names_follow_the_columns():
    frame = pytest.importorskip("pandas").DataFrame({"G": [1.0, 2.0, 3.0]})
    out = SmoothingBank(count=3).set_output(transform="pandas").fit_transform(frame)
    assert list(out.columns) == ["G_a1", "G_a2", "G_a3"]


def test_groups_start_the_bank_anew():
    x = np.r_[np.zeros(50), np.ones(50)][:, None]
    bank = SmoothingBank().fit(x)
    separate = bank.transform(x, groups=np.r_[np.zeros(50), np.ones(50)])
    np.testing.assert_allclose(separate, np.repeat(x, 7, axis=1), atol=1e-13)
    assert np.abs(bank.transform(x) - separate).max() > 0.5


def test_pipeline_is_what_the_command_trains(recordings):
    series = series_of(recordings[0].between(0, 90), "force", 20.0)
    pipeline = clone(paper_pipeline(sizes=(6,), seed=3)).fit(series.conductance_S[:, None], series.truth)
    trained = train([recordings[0].between(0, 90)], "force", Options(sizes=(6,), restarts=1, seed=3))
    ours = trained.predict(series.time_s, series.conductance_S)
    np.testing.assert_allclose(pipeline.predict(series.conductance_S[:, None]), ours, atol=1e-6 * np.ptp(ours))


def test_grid_search_over_grouped_splits(recordings):
    series = series_of(recordings[0].between(0, 60), "force", 20.0)
    groups = np.arange(len(series)) * 3 // len(series)
    grid = {"regressor__bank__count": [3, 7]}
    search = GridSearchCV(paper_pipeline(sizes=(3,), seed=0), grid, cv=GroupKFold(3), error_score="raise")
    search.fit(series.conductance_S[:, None], series.truth, groups=groups)
    assert search.best_params_["regressor__bank__count"] in (3, 7)
    assert np.isfinite(search.cv_results_["mean_test_score"]).all()
