"""The scikit-learn regressor: scikit-learn's own checks, groups through pipelines, the numbers of `train`."""

from __future__ import annotations

import numpy as np
import pytest
import sklearn
from sklearn.model_selection import GridSearchCV, GroupKFold
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import parametrize_with_checks

from compensation import Compensator
from compensation.estimators.regressor import EXPECTED_FAILED_CHECKS
from compensation.model import files as compensator_files
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.training import train


@parametrize_with_checks([Compensator()], expected_failed_checks=lambda _: EXPECTED_FAILED_CHECKS)
def test_scikit_learns_checks(estimator, check):
    check(estimator)


@pytest.fixture(scope="module")
def rows(recordings):
    """Conductance (n, 1), force (n,) and labels of three recordings of 60 s."""
    parts = [series_of(recording.between(20, 80), "force", 20.0) for recording in recordings]
    X = np.concatenate([part.conductance_S for part in parts])[:, None]
    labels = np.repeat(["T", "A", "B"], [len(part) for part in parts])
    return X, np.concatenate([part.truth for part in parts]), labels


def test_gives_the_numbers_of_the_command(recordings):
    part = series_of(recordings[0], "force", 20.0)
    model = Compensator(method="paper").fit(part.conductance_S[:, None], part.truth)
    trained = train(recordings[:1], "force", Options())
    np.testing.assert_allclose(
        model.predict(part.conductance_S[:, None]), trained.predict(part.time_s, part.conductance_S), rtol=1e-9
    )


def test_groups_begin_anew(rows):
    X, y, labels = rows
    model = Compensator(method="ridge").fit(X, y, groups=labels)
    whole = model.predict(X, groups=labels)
    for label in "TAB":
        own = labels == label
        np.testing.assert_array_equal(whole[own], model.predict(X[own]))
    assert np.abs(whole - model.predict(X)).max() > 0.01
    with pytest.raises(ValueError, match="one label a row"):
        model.predict(X, groups=labels[:5])


def test_groups_go_through_pipeline_and_search(rows):
    X, y, labels = rows
    with sklearn.config_context(enable_metadata_routing=True):
        model = Compensator(method="ridge").set_fit_request(groups=True).set_predict_request(groups=True)
        pipeline = Pipeline([("log", FunctionTransformer(np.log)), ("compensator", model)])
        search = GridSearchCV(
            pipeline, {"compensator__rate_hz": [10.0, 20.0]}, cv=GroupKFold(3), scoring="neg_mean_squared_error"
        )
        search.fit(X, y, groups=labels)
    assert len(search.cv_results_["mean_test_score"]) == 2
    assert np.isfinite(search.cv_results_["mean_test_score"]).all()


def test_streams_and_saves(rows, tmp_path):
    X, y, labels = rows
    model = Compensator(method="paper").fit(X, y, groups=labels)
    model.save(tmp_path / "c.json")
    stream = CompensatorStream(compensator_files.load(tmp_path / "c.json"))
    assert stream.update(float(X[0, 0]), 0.05) == pytest.approx(model.stream().update(float(X[0, 0]), 0.05))
    with pytest.raises(ValueError, match="no stream and no file; fit one column of 20 s or more"):
        Compensator(method="ridge").fit(X, y).stream()


def test_wrong_parameters_are_named(rows):
    X, y, _ = rows
    with pytest.raises(ValueError, match="method must be one of auto"):
        Compensator(method="best").fit(X, y)
