"""No dead networks; of 20 tuned ones the worst is within 0.03 of the median. Both presets and a measured strip."""

from __future__ import annotations

import numpy as np
import pytest

from compensation.paper import reproduction as ours
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series.score import r2
from compensation.training.tuning import choose, ensemble
from testbench.recordings.files import read_recording

SEEDS, WITHIN = 20, 0.03
STRIP = ("cb7.5_s2_multisine_600s", "cb7.5_s2_multisine_300s_a", "cb7.5_s2_random_sawtooth_a")


@pytest.fixture(scope="module", params=["pes", "lycra", "strip"])
def series(request, tmp_path_factory):
    """Training, A and B of 23 min each, or of 5 to 10 min of the strip."""
    if request.param == "strip":
        folder = request.getfixturevalue("real_folder")
        recordings = [read_recording(folder / f"{name}.csv", 40.0) for name in STRIP]
    else:
        recordings = list(campaigns(tmp_path_factory.mktemp("c"), request.param, runs=TAB, number=4).values())
    return list(ours.prepared(dict(enumerate(recordings)), "force").values())


def near_the_median(means: np.ndarray) -> bool:
    return bool(means.min() > np.median(means) - WITHIN)


@pytest.mark.slow
def test_five_starts_are_never_all_dead(series):
    """A single start of the published network is dead in one of five to ten; the best of five by training is not.

    It still differs more between seeds than the tuned one: its worst of 20 is not within 0.03 of the median.
    """
    training, *tests = series
    found = ours.over_seeds(training, tests, "force", 5 * SEEDS)
    assert found.dead.any()
    assert len(found.best_of(5)) == SEEDS
    assert found.best_of(5).min() > found.r2[found.dead].max() + 0.3


@pytest.mark.slow
def test_the_tuned_compensator(series):
    training, *tests = series
    choices = choose([training], "force", ours.PUBLISHED)
    apart = (ensemble([training], "force", *choices, 100 * number) for number in range(SEEDS))  # no network is shared
    means = np.array([np.mean([r2(part.truth, one.predict_series(part)) for part in tests]) for one in apart])
    assert near_the_median(means), np.sort(means).round(3)
