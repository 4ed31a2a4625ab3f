"""The scikit-learn regressor: scikit-learn's own checks, groups through pipelines, the numbers of `train`."""

from __future__ import annotations

import pickle

import numpy as np
import pandas as pd
import pytest
import sklearn
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.metrics import r2_score
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import parametrize_with_checks

from compensation import Compensator, c_header, predicted, write_onnx
from compensation.model import files as compensator_files
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from tests.compensation.conftest import train

# It has memory: these checks permute or thin out the rows, which are samples in time here.
EXPECTED_FAILED_CHECKS = {
    "check_methods_sample_order_invariance": "rows are samples in time, and history matters",
    "check_methods_subset_invariance": "rows are samples in time, and history matters",
}


@pytest.mark.filterwarnings("ignore:learned by ridge:UserWarning")
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
    trained = train(recordings[:1], "force", Options()).in_use
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
    nameless = np.where(labels == "T", np.nan, 1.0)  # rows without a label are one recording
    np.testing.assert_array_equal(model.predict(X, groups=nameless)[labels == "T"], whole[labels == "T"])


def test_interleaved_groups_are_the_same_recordings(rows):
    X, y, labels = rows
    order = np.argsort(np.tile(np.arange(len(X) // 3), 3), kind="stable")
    assert (labels[order][:4] == ["T", "A", "B", "T"]).all()
    for method in ("ridge", "paper"):
        one, other = Compensator(method=method), Compensator(method=method)
        expected = one.fit(X, y, groups=labels).predict(X, groups=labels)
        got = other.fit(X[order], y[order], groups=labels[order]).predict(X[order], groups=labels[order])
        np.testing.assert_allclose(got, expected[order], atol=1e-6)


def test_a_recording_of_one_row_is_named(rows):
    X, y, labels = rows
    with pytest.raises(ValueError, match="a recording needs at least 2 rows, group 'spare' has 1"):
        Compensator().fit(X, y, groups=["spare", *labels[1:]])


@pytest.mark.parametrize(("rate_hz", "count"), [(20.0, 390), (40.0, 790), (20.0, 410), (0.5, 12), (0.1, 9)])
def test_what_is_too_short_is_so_in_seconds(rows, rate_hz, count):
    X, y, _ = rows
    model = Compensator(method="paper", rate_hz=rate_hz)
    if count / rate_hz >= 20 and count >= 10:
        assert model.fit(X[:count], y[:count]).compensator_ is not None
        return
    with pytest.warns(
        UserWarning, match=r"learned by ridge, not by paper: \d+ rows are .* s, the others need 20 s in 10"
    ):
        model.fit(X[:count], y[:count])
    with pytest.raises(ValueError, match=r"rows are .* it has no stream, no file and no export"):
        model.stream()


@pytest.mark.parametrize("factor", [1e-200, 1e200])
def test_units_whose_squares_no_float_holds_are_refused(rows, factor):
    X, y, _ = rows
    for name, wrong in (("X", (factor * X, y)), ("y", (X, factor * y))):
        with pytest.raises(ValueError, match=rf"{name} is as large as .*e.\d+, and 1e-100 to 1e.100 can be squared"):
            Compensator(method="ridge").fit(*wrong)


@pytest.mark.filterwarnings("error")
def test_single_precision_is_learned_without_a_warning(rows):
    """Of a target in float32 numpy said "overflow encountered in cast", of our own limit."""
    X, y, _ = rows
    fitted = Compensator(method="paper").fit(X[:1200].astype(np.float32), y[:1200].astype(np.float32))
    assert fitted.score(X[:1200], y[:1200]) > 0.5


def test_a_slow_logger_learns_the_same(rows):
    """A sample an hour: memories last as many samples as at 1 Hz, and the stream takes every one."""
    X, y, labels = rows
    slow, quick = (Compensator(method="paper", rate_hz=rate_hz).fit(X, y, groups=labels) for rate_hz in (1 / 3600, 1))
    np.testing.assert_allclose(slow.predict(X, labels), quick.predict(X, labels), atol=1e-6)
    own, stream = X[labels == "A"], slow.stream()
    np.testing.assert_allclose([stream.update(value) for value in own[:, 0]], slow.predict(own), atol=1e-9)


@pytest.mark.parametrize("method", ["paper", "auto"])
def test_what_scikit_learns_checks_are_too_short_for(rows, method):
    """Its own checks have fewer rows than 20 s, so that they see the ridge alone: clone, pickle, refit, names."""
    minute = np.concatenate([np.flatnonzero(rows[2] == label)[:1200] for label in "TAB"])
    X, y, labels = (column[minute] for column in rows)
    frame = pd.DataFrame(X, columns=["conductance_S"])
    model = Compensator(method=method).fit(frame, y, groups=labels)
    expected = model.predict(frame, groups=labels)
    before = dict(vars(model))
    assert set(before) == set(vars(Compensator())) | {
        *("compensator_", "n_features_in_", "feature_names_in_", "_ridge", "_why_ridge")
    }
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(model)).predict(frame, groups=labels), expected)
    assert all(vars(model)[name] is value for name, value in before.items())
    with pytest.raises(ValueError, match="feature names should match"):
        model.predict(frame.rename(columns=lambda name: "G"))
    fresh = clone(model)
    assert not hasattr(fresh, "compensator_")
    np.testing.assert_array_equal(fresh.fit(frame, y, groups=labels).predict(frame, groups=labels), expected)
    assert model.fit(frame[:500], y[:500]).compensator_.recipe["samples"] == 500


def test_another_method_leaves_nothing_of_the_one_before(rows):
    X, y, _ = rows
    model = Compensator(method="ridge").fit(X, y)
    ridge = model.predict(X)
    again = model.set_params(method="paper").fit(X, y).predict(X)
    assert np.abs(again - ridge).max() > 0.01
    np.testing.assert_array_equal(again, Compensator(method="paper").fit(X, y).predict(X))
    assert set(vars(model)) == set(vars(Compensator(method="paper").fit(X, y)))
    assert model._ridge is None
    np.testing.assert_array_equal(model.set_params(method="ridge").fit(X, y).predict(X), ridge)


@pytest.mark.parametrize("before", ["nothing", "paper", "ridge"])
def test_a_fit_that_fails_leaves_nothing_fitted(rows, before):
    """It gave uninitialised memory for a prediction, or the numbers of the fit before."""
    X, y, _ = rows
    model = Compensator(method="auto" if before == "nothing" else before)
    if before != "nothing":
        model.fit(X, y)
    still = np.where(np.arange(len(X))[:, None] < len(X) // 5, X, X[0])
    for wrong, match in (((still, y), "the conductance stands still"), ((1e200 * X, y), "rescale it")):
        with pytest.raises(ValueError, match=match):
            model.set_params(method="auto").fit(*wrong)
        with pytest.raises(NotFittedError):
            model.predict(X)
        with pytest.raises(NotFittedError):
            model.trained()


@pytest.mark.parametrize(
    ("parameters", "match"),
    [
        *(
            (
                {"rate_hz": value},
                rf"rate_hz must be a number from 0.000278 \(.*\) to 1.05e.06, got {value}",
            )
            for value in (0, -20.0, float("nan"), 1e7, 1e-4, None, True)
        ),
        *(
            ({"seed": value}, f"seed must be a whole number from 0 to 2147483647, got {value}")
            for value in (None, -1, 2**31, 0.5, True)
        ),
    ],
)
def test_parameters_without_sense_are_named(rows, parameters, match):
    X, y, _ = rows
    for method in ("ridge", "paper"):
        with pytest.raises(ValueError, match=match):
            Compensator(method=method, **parameters).fit(X, y)


@pytest.mark.parametrize("method", ["paper", "ridge"])
def test_predict_does_not_look_ahead(rows, method):
    X, y, labels = rows
    model = Compensator(method=method).fit(X, y, groups=labels)
    own = X[labels == "A"]
    later = np.where(np.arange(len(own))[:, None] < 20, own, 1.3 * own)
    np.testing.assert_allclose(model.predict(later)[:20], model.predict(own)[:20], atol=1e-12)


def test_a_logarithm_of_the_conductance_is_learned_but_does_not_stream(rows, tmp_path):
    X, y, _ = rows
    model = Compensator(method="paper").fit(np.log(X), y)
    assert np.isfinite(model.predict(np.log(X))).all()
    attempts = (
        model.stream,
        lambda: model.save(tmp_path / "c.json"),
        lambda: CompensatorStream(model),
        lambda: predicted(model, np.arange(len(X)) / 20, 1 / X[:, 0]),
        lambda: c_header(model),
        lambda: write_onnx(model, tmp_path / "c.onnx"),
    )
    for attempt in attempts:
        with pytest.raises(ValueError, match=r"trained on values from -\d.* conductances in S.* without a logarithm"):
            attempt()
    assert list(tmp_path.iterdir()) == []


def test_groups_go_through_pipeline_and_search(rows):
    """The score that the search takes without a word is that of recordings that begin anew."""
    X, y, labels = rows
    with sklearn.config_context(enable_metadata_routing=True):
        model = Compensator(method="ridge").set_fit_request(groups=True).set_score_request(groups=True)
        pipeline = Pipeline([("conductance", FunctionTransformer(np.reciprocal)), ("compensator", model)])
        search = GridSearchCV(pipeline, {"compensator__rate_hz": [10.0, 20.0]}, cv=LeaveOneGroupOut())
        search.fit(1 / X, y, groups=labels)
        whole = search.score(1 / X, y, groups=labels)
    out = labels == "A"
    fitted = [Compensator("ridge", rate_hz=rate).fit(X[~out], y[~out], labels[~out]) for rate in (10.0, 20.0)]
    expected = [one.score(X[out], y[out]) for one in fitted]
    np.testing.assert_allclose(search.cv_results_["split0_test_score"], expected, atol=1e-9)
    best = search.best_estimator_[-1]
    assert whole == pytest.approx(r2_score(y, best.predict(X, groups=labels)), abs=1e-9)
    assert whole != pytest.approx(r2_score(y, best.predict(X)), abs=1e-4)


def test_predict_is_what_the_stream_of_its_file_says(rows, tmp_path):
    X, y, labels = rows
    model = Compensator(method="paper").fit(X, y, groups=labels)
    model.save(tmp_path / "c.json")
    own, stream = X[labels == "A"], CompensatorStream(compensator_files.load(tmp_path / "c.json"))
    np.testing.assert_allclose([stream.update(value) for value in own[:, 0]], model.predict(own), atol=1e-9)


def test_what_uses_a_compensator_says_alike_why_an_estimator_has_none(rows, tmp_path):
    X, y, _ = rows
    ridge = Compensator(method="ridge").fit(X, y)
    for model, match in (
        (ridge, r"ridge \(as asked for\): it has no stream, no file and no export; fit one column of 20 s"),
        (clone(ridge), "not fitted yet"),
    ):
        for use in (
            model.stream,
            model.trained,
            lambda model=model: model.save(tmp_path / "c.json"),
            lambda model=model: CompensatorStream(model),
            lambda model=model: predicted(model, np.arange(len(X)) / 20, 1 / X[:, 0]),
            lambda model=model: c_header(model),
            lambda model=model: write_onnx(model, tmp_path / "c.onnx"),
        ):
            with pytest.raises(ValueError, match=match):
                use()
    assert list(tmp_path.iterdir()) == []


def test_wrong_parameters_are_named(rows):
    X, y, _ = rows
    for wrong in ({"method": "best"}, {"method": ["auto"]}, {"target": [1]}, {"target": {}}):
        with pytest.raises(ValueError, match=r"method must be one of auto.* target one of force, displacement, got"):
            Compensator(**wrong).fit(X, y)


def test_a_constant_that_is_one_but_for_rounding_tells_nothing():
    """The standard deviation of a thousand times 1e-6 is not quite zero, and nothing to divide by."""
    y = np.random.default_rng(0).standard_normal(1000)
    with pytest.warns(UserWarning, match="the conductance or the target is constant"):
        model = Compensator(method="paper").fit(np.full((1000, 1), 1e-6), y)
    np.testing.assert_allclose(model.predict(np.linspace(1e-6, 5e-6, 5)[:, None]), y.mean())
