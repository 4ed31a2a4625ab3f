"""The method chosen by cross-validation: what it prints is what it promises, and it knows when to give up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensation.cli import main
from compensation.commands.common import cross_validation_table
from compensation.memories.ema import smooth
from compensation.model import files as compensator_files
from compensation.model.streaming import CompensatorStream
from compensation.paper.paper_campaigns import campaigns
from compensation.series import score
from compensation.series.preprocessing import Series, series_of
from compensation.training import auto
from compensation.training.auto import (
    LEARNERS,
    STACKED,
    choose,
    cross_validated,
    stacked,
    steps,
    train_automatically,
    weights_of,
)
from compensation.training.folds import folds_of
from compensation.training.learners import Ridge, linear, products_of, solved
from compensation.training.lessons import features_at_pace
from compensation.training.options import Options
from gcode.support.errors import UserError
from testbench.recordings.files import write_recording_csv
from tests.compensation.conftest import paused
from tests.compensation.model.test_runtime import cold_starts


@pytest.fixture(scope="module")
def series(recordings):
    return [series_of(recording, "force", 20.0) for recording in recordings]


@pytest.fixture(scope="module")
def trained(series):
    notes = []
    compensator = train_automatically(series[:1], "force", Options(), notes.append)
    assert len(notes) == steps(series[:1])
    return compensator


def test_it_beats_the_line_on_a_knit_and_says_by_how_much(trained, series):
    tried, promise = trained.recipe["tried"], trained.recipe["cross_validated"]
    assert set(tried) == {"line", "ridge", "paper", "networks", "stack"}
    assert trained.recipe["chosen"] == "stack"
    assert promise["r2"] == tried["stack"]["r2"] > tried["line"]["r2"]
    assert 0.0 < promise["r2_elsewhere"] < promise["r2_ordinary"]
    assert promise["r2"] > max(row["r2"] for row in tried.values()) - 0.01
    assert trained.parameter_count <= 1500
    held_out = [score.r2(part.truth, trained.predict_series(part)) for part in series[1:]]
    line = [score.rho_squared(part.truth, part.conductance_S) for part in series[1:]]
    assert np.mean(held_out) > np.mean(line) + 0.01
    assert np.mean(held_out) == pytest.approx(promise["r2"], abs=0.05)


def test_the_interval_of_a_training_with_a_gap_is_that_of_what_was_recorded(recordings):
    """80 s give none, whatever lies between them; 240 s give the same with a gap and without."""

    def interval(recording):
        part = series_of(recording, "force", 20.0)
        error = np.sin(np.arange(len(part)) / 100)
        return auto._interval(part.truth, part.truth + 0.1 * part.truth.std() * error, [part], whole=False)

    assert interval(paused(recordings[0].between(0.0, 80.0), 40.0, 600.0)) is None
    assert interval(paused(recordings[0], 120.0, 600.0)) == pytest.approx(interval(recordings[0]), abs=1e-3)


@pytest.mark.slow
def test_the_interval_holds_on_sensors_that_were_not_trained_on(tmp_path):
    runs = [campaigns(tmp_path, "lycra", runs=("T",), number=number)["T"] for number in range(61, 68)]
    series = [series_of(recording, "force", 20.0) for recording in runs]
    compensator = train_automatically(series[:4], "force", Options())
    low, high = compensator.margins
    inside = [
        (low <= error) & (error <= high) for error in (p.truth - compensator.predict_series(p) for p in series[4:])
    ]
    assert 0.85 < np.mean(np.concatenate(inside)) < 0.95


def test_switched_on_in_use_it_is_nearly_as_good_as_one_that_ran(trained, recordings):
    cold, warm = cold_starts(trained, recordings[1])
    assert cold < 1.5 * warm


def test_batch_and_stream_begin_alike(trained, series):
    part = series[1]
    stream = CompensatorStream(trained)
    fed = [stream.update(conductance, 0.05) for conductance in part.conductance_S[:200]]
    np.testing.assert_allclose(fed, trained.predict_series(part)[:200], atol=1e-9)


def noisy_line(seed: int) -> Series:
    """A target that is a straight line of the conductance, and noise that nothing explains."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, 120.0, 0.05)
    conductance = 1e-6 * (3 + np.sin(time_s / 3) + 0.5 * np.sin(time_s / 7.7))
    return Series(time_s, conductance, 2e6 * conductance + 0.5 * rng.standard_normal(len(time_s)), f"line {seed}")


def test_where_nothing_beats_the_line_the_line_is_taken():
    for seed in range(2):
        part = noisy_line(seed)
        compensator = train_automatically([part], "force", Options())
        assert compensator.recipe["chosen"] == "line"
        fresh = noisy_line(seed + 100)
        errors = compensator.predict_series(fresh) - 2e6 * fresh.conductance_S
        assert np.sqrt(np.mean(errors**2)) < 0.1


def test_the_better_of_line_and_stack_is_taken_and_of_equals_the_line():
    noise = np.random.default_rng(0).standard_normal(6000)
    for factor, chosen in ((0.99, "stack"), (1.0, "line"), (1.01, "line")):
        assert choose({"line": noise, "stack": factor * noise}, np.zeros(6000)) == chosen


def test_the_weights_are_what_each_is_worth():
    """Errors that have nothing to do with one another are shared out by their variances; more of the same is out."""
    rng, count = np.random.default_rng(0), 100_000
    truth, first, second = rng.standard_normal((3, count))
    predictions = {"ridge": [truth + first], "networks": [truth + second / 2], "paper": [truth + second]}
    predictions = {name: np.array(values) for name, values in predictions.items()}
    weights = weights_of(predictions, truth)
    assert sum(weights.values()) == pytest.approx(1.0)
    assert weights["ridge"] == pytest.approx(0.2, abs=0.02)
    assert weights["networks"] == pytest.approx(0.8, abs=0.02)
    assert "paper" not in weights
    assert sum(weights_of(dict.fromkeys(STACKED, -truth[None]), truth).values()) == pytest.approx(1.0)


def test_the_weights_are_the_best_that_sum_to_one():
    """A part that falls short by half of a truth of spread 1 errs as much as two whose noise has a spread of 0.5."""
    rng = np.random.default_rng(0)
    truth, first, second = rng.standard_normal((3, 100_000))
    values = (0.5 * truth, truth + 0.5 * first, truth + 0.5 * second)
    predictions = {name: value[None] for name, value in zip(STACKED, values, strict=True)}
    assert list(weights_of(predictions, truth).values()) == pytest.approx([1 / 3] * 3, abs=0.01)

    def error(shares):
        return np.mean((truth - np.array(list(shares)) @ np.array(values)) ** 2)

    least = error(weights_of(predictions, truth).values())
    assert all(least <= error(shares) for shares in rng.dirichlet(np.ones(3), 200))
    # An error that the others' cannot make up for, and one that is none: all weight is where it belongs.
    exact = predictions | {"paper": truth[None]}
    assert weights_of(exact, truth)["paper"] == pytest.approx(1.0)


def test_a_folds_weights_come_from_the_others():
    rng = np.random.default_rng(0)
    truth, folds = rng.standard_normal(4000), np.repeat(np.arange(4), 1000)
    good, bad = truth + 0.1 * rng.standard_normal(4000), 3 * rng.standard_normal(4000)
    ridge, networks = np.where(folds == 0, bad, good), np.where(folds == 0, good, bad)
    predictions = {"ridge": ridge[None], "paper": bad[None], "networks": networks[None]}
    found = stacked(predictions, truth, folds)
    np.testing.assert_allclose(found[folds == 0], bad[folds == 0], atol=0.5)


def holds(seconds: float, seed: int) -> Series:
    """Pulled by another amount and held for so long each time; what is read lags by 2 s and is noisy."""
    time_s = np.arange(0.0, 150.0, 0.05)
    number = (time_s // (2 * seconds)).astype(int)
    rng = np.random.default_rng(seed)
    heights = rng.uniform(0.3, 1.0, number.max() + 1)
    stretch = np.where(time_s % (2 * seconds) < seconds, heights[number], 0.0)
    lagging = smooth(stretch, np.array([0.05 / 2.0]), 20.0)[:, 0]
    noise = 0.05 * rng.standard_normal(len(time_s))
    return Series(time_s, 1e-6 * (3 + lagging + noise), stretch, f"holds of {seconds} s")


def test_what_it_learns_is_the_sensor_and_not_the_clock_of_the_motion():
    """Holds of one length in the training: a memory tells when they end, where only the conductance may."""
    compensator = train_automatically([holds(6.0, 1)], "displacement", Options())
    longer = holds(12.0, 2)
    line = np.polyval(np.polyfit(longer.conductance_S * 1e6, longer.truth, 1), longer.conductance_S * 1e6)
    assert score.r2(longer.truth, compensator.predict_series(longer)) > score.r2(longer.truth, line)


def test_versions_of_another_pace_are_those_of_a_slower_recording(series):
    """Features of a recording in slow motion, sampled as often as it, are those of the recording at another pace."""
    part = series[0].rows(np.arange(2000))
    learner = Ridge([part], "force", Options())
    blank = learner.lessons.blank
    slow = np.arange(0.0, 1.5 * part.time_s[-1], 0.05)
    stretched = Series(slow, np.interp(slow, 1.5 * part.time_s, part.conductance_S), slow, "slow")
    expected = blank.features(stretched.time_s, stretched.conductance_S)[::3]
    got = features_at_pace(blank, [part], 1.5)[::2][: len(expected)]
    late = slice(600, None)
    error = np.abs(got - expected[: len(got)])[late].std(axis=0) / expected[late].std(axis=0)
    assert (error < 0.15).all(), error.round(3)


def test_folds_are_recordings_where_there_are_enough(series):
    folds, whole = folds_of(series)
    assert whole
    assert [len(np.unique(part)) for part in np.split(folds, np.cumsum([len(p) for p in series])[:-1])] == [1, 1, 1]
    parts, whole = folds_of(series[:1])
    assert not whole
    assert parts.max() == 4
    assert (np.diff(parts) >= 0).all()


@pytest.mark.parametrize(
    ("lengths", "whole"),
    [([50, 50, 1900], False), ([500, 500, 1000], True), ([500, 500, 1001], False), ([9] * 8, True), ([9, 9], False)],
)
def test_no_fold_is_most_of_all_rows(lengths, whole):
    """A fold that holds most of all is predicted from next to nothing: then folds are parts, as of one recording."""
    time_s = np.arange(2000) / 20
    series = [Series(*np.tile(time_s[:length], (3, 1)), "") for length in lengths]
    folds, told = folds_of(series)
    assert told is whole
    assert np.bincount(folds).max() <= sum(lengths) / 2


def test_one_recording_beside_two_scraps_is_predicted_from_its_own_parts(series):
    """Held out as a whole, the long one would be predicted from 5 s, and a straight line would be what is left."""
    scraps = [series[1].rows(np.arange(50)), series[2].rows(np.arange(50)), series[0].rows(np.arange(2000))]
    promise = train_automatically(scraps, "force", Options()).recipe["cross_validated"]
    assert not promise["whole_recordings"]
    assert promise["r2"] > promise["line_r2"] + 0.01
    assert "recordings of which one outweighs the others cannot show it" in cross_validation_table(
        {"tried": {}, "chosen": "stack", "trained_on": ["", "", ""], "cross_validated": promise}, "N"
    )


def test_the_table_says_of_what_the_folds_are(trained):
    promise = trained.recipe["cross_validated"] | {"whole_recordings": True, "folds": 5, "r2_interval": None}
    for count, words in ((5, "on 5 whole recordings"), (8, "on 5 groups of whole recordings")):
        table = cross_validation_table(trained.recipe | {"cross_validated": promise, "trained_on": [""] * count}, "N")
        assert words in table
        assert f"expect r2 {promise['r2']:.3f} (too short for an interval)" in table


@pytest.mark.parametrize("recordings_of", [3, 1], ids=["whole recordings", "parts of one"])
def test_no_learner_looks_at_what_is_held_out(series, recordings_of):
    """Another target there, and another conductance from its middle on, change nothing of what is said before that.

    The recordings are altered as they are given: not even a scaler or a range may know of it.
    """
    given = [part.rows(np.arange(600)) for part in series[:recordings_of]]
    folds, _ = folds_of(given)
    held_out, number = folds == 1, 1 if recordings_of == 3 else 0
    own = held_out[len(given[0]) * number :][: len(given[number])]
    late = own & (np.cumsum(own) > own.sum() / 2)
    altered = list(given)
    altered[number] = replace(
        given[number],
        truth=np.where(own, 99.0 - given[number].truth, given[number].truth),
        conductance_S=given[number].conductance_S * np.where(late, 1.7, 1.0),
    )
    one, other = (cross_validated(each, "force", Options(), folds) for each in (given, altered))
    half = held_out.sum() // 2
    assert set(one) == {kind.name for kind in LEARNERS}
    for name in one:
        np.testing.assert_array_equal(one[name][:, held_out][:, :half], other[name][:, held_out][:, :half])
        assert (one[name][:, held_out] != other[name][:, held_out]).any()


def test_ridge_is_scikit_learns(series):
    from sklearn.linear_model import Ridge as Reference
    from sklearn.preprocessing import StandardScaler

    learner = Ridge(series[:1], "force", Options())
    lesson = replace(learner.lessons, versions=learner.lessons.versions[:1])
    rows = np.ones(len(lesson.truth), dtype=bool)
    x = StandardScaler().fit_transform(lesson.versions[0])
    expected = Reference(alpha=0.1 * len(x)).fit(x, lesson.truth).predict(x)
    products = products_of(lesson, rows)
    got = linear(*solved(products, 0.1))(lesson.versions[0])
    np.testing.assert_allclose(got, expected, atol=1e-8)
    squares = float(np.sum((lesson.truth - expected) ** 2))
    assert learner.error(np.stack([products, products]), 0.1) == pytest.approx(2 * squares, rel=1e-6)


def promise_of(path) -> dict[str, float]:
    return compensator_files.load(path).recipe["cross_validated"]


def test_it_is_the_default_and_prints_what_it_tried(recordings, tmp_path, capsys):
    write_recording_csv(tmp_path / "r.csv", recordings[0].between(0.0, 120.0))
    out = tmp_path / "c.json"
    assert main(["train", str(tmp_path / "r.csv"), "--target", "force", "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    for words in ("cross-validated on 5 contiguous parts", "<- chosen", "expect r2", "ordinary", "fewer than three"):
        assert words in printed
    assert f"of another day or specimen about r2 {promise_of(out)['r2_elsewhere']:.2f}" in printed
    # What was learned by heart is no figure to print beside what was predicted unseen.
    assert "training " not in printed.split("cross-validated on")[0]
    trained = compensator_files.load(out)
    assert trained.margins is not None
    assert f"{len(trained.networks)} network(s) with hidden layers" in printed
    for sizes in {network.sizes for network in trained.networks}:
        assert (f"x {sizes}" if sizes else "a linear one") in printed
    assert (
        main(["train", str(tmp_path / "r.csv"), "--target", "force", "--method", "auto", "--l2", "1", "-o", str(out)])
        == 2
    )
    assert "--l2 is for --method paper only" in capsys.readouterr().err


def test_it_does_not_learn_from_each_recordings_own_mean(series):
    with pytest.raises(UserError, match="leave --per-recording out"):
        train_automatically(series[:1], "force", Options(per_recording=True))


def test_what_moves_in_one_part_alone_cannot_be_cross_validated(series):
    part = series[0]
    resting = np.arange(len(part)) < 0.85 * len(part)
    still = replace(part, truth=np.where(resting, 0.0, part.truth))
    with pytest.raises(UserError, match="without one of 5 parts the force stands still"):
        train_automatically([still], "force", Options())


def test_a_rest_among_the_recordings_has_no_r2_of_its_own(series):
    """The raw signal is scored on the recordings that move; a rest is learned from as well."""
    short = [part.rows(np.arange(200)) for part in series]
    rest = replace(short[0], truth=np.zeros(200))
    assert auto._raw_r2([rest, *short[1:]], 1.0) == pytest.approx(auto._raw_r2(short[1:], 1.0))
    found = train_automatically([rest, *short[1:]], "force", Options())
    assert np.isfinite(found.recipe["cross_validated"]["raw_r2"])


@pytest.mark.parametrize(("count", "above", "asked"), [(2, 0.01, True), (2, -0.01, False), (1, 0.01, False)])
def test_recordings_that_are_better_apart_are_asked_about(trained, count, above, asked):
    """One of two in kiloohm: what was learned of both was worse than either one's own straight line."""
    promise = trained.recipe["cross_validated"]
    recipe = {**trained.recipe, "cross_validated": {**promise, "raw_r2": promise["r2"] + above}}
    table = cross_validation_table(recipe | {"trained_on": [""] * count}, "N")
    assert ("are all recordings of one kind of sensor, and in the same units?" in table) == asked


def test_what_is_no_better_than_a_constant_is_said(trained):
    promise = trained.recipe["cross_validated"]
    for r2, said in ((promise["r2_ordinary"], False), (-0.1, True)):
        recipe = {**trained.recipe, "cross_validated": {**promise, "r2_ordinary": r2}}
        assert ("no better than a constant" in cross_validation_table(recipe, "N")) == said
