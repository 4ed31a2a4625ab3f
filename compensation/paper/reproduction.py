"""The paper's experiments on our recordings: one function an experiment, each returning rows for a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensation.engines.engine import ENGINES
from compensation.series import score
from compensation.series.preprocessing import Series, series_of
from compensation.training.options import Options
from compensation.training.untrained import scaling_of_target, training_arrays, untrained
from gcode.support.arrays import FloatArray
from testbench.recordings.recording import Recording

PUBLISHED = Options(restarts=1)


@dataclass(frozen=True)
class Seeds:
    """r2 of the paper's network from several seeds."""

    r2: FloatArray  # (seeds, recordings)
    dead: NDArray[np.bool_]  # (seeds,)
    training_r2: FloatArray  # (seeds,)

    @property
    def live(self) -> FloatArray:
        """Rows of `r2` whose network learned something: a dead one gives a constant."""
        return self.r2[~self.dead]

    def best_of(self, count: int) -> FloatArray:
        """r2 of the best by training score in each group of `count` seeds."""
        groups = [range(begin, begin + count) for begin in range(0, len(self.r2) - count + 1, count)]
        return np.array([self.r2[max(group, key=lambda seed: self.training_r2[seed])] for group in groups])


def prepared(
    recordings: Mapping[str, Recording], target: str, rate_hz: float = PUBLISHED.rate_hz
) -> dict[str, Series]:
    """Every recording as input and target."""
    return {name: series_of(recording, target, rate_hz) for name, recording in recordings.items()}


def over_seeds(
    training: Series, tests: Sequence[Series], target: str, seeds: int, options: Options = PUBLISHED
) -> Seeds:
    """Train the network once a seed and score every recording."""
    blank = untrained([training], target, options)
    features, truth = training_arrays(blank, [training])
    inputs = [blank.features(part.time_s, part.conductance_S) for part in tests]
    scales = [scaling_of_target(blank, part) for part in tests]
    scores, dead, fitted = [], [], []
    for seed in range(seeds):
        network = ENGINES[options.engine](features, truth, options.sizes, seed, options.l2).network
        outputs = [scale.invert(network(values)) for scale, values in zip(scales, inputs, strict=True)]
        scores.append([score.r2(part.truth, output) for part, output in zip(tests, outputs, strict=True)])
        dead.append(network.is_dead(features))
        fitted.append(score.r2(truth, network(features)))
    return Seeds(np.array(scores), np.array(dead), np.array(fitted))


def regressors(seed: int = 0) -> dict[str, Any]:
    """scikit-learn's that the paper compares with, not fitted yet."""
    from sklearn.ensemble import RandomForestRegressor
    from sklearn.linear_model import LinearRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures

    return {
        "linear": LinearRegression(),
        "polynomial, 3rd order": make_pipeline(PolynomialFeatures(3), LinearRegression()),
        "polynomial, 4th order": make_pipeline(PolynomialFeatures(4), LinearRegression()),
        "random forest": RandomForestRegressor(n_estimators=50, min_samples_leaf=5, random_state=seed),
    }


def baselines(training: Series, tests: Sequence[Series], target: str) -> dict[str, list[float]]:
    """These regressors on the smoothed features: name -> r2 on each test."""
    blank = untrained([training], target, PUBLISHED)
    features, truth = training_arrays(blank, [training])
    found = {}
    for name, regressor in regressors().items():
        # Every 5th row: a forest over neighbours 50 ms apart only memorises them.
        regressor.fit(features[::5], truth[::5])
        outputs = [regressor.predict(blank.features(part.time_s, part.conductance_S)) for part in tests]
        scaled = [blank.scaling_out.invert(output) for output in outputs]
        found[name] = [score.r2(part.truth, output) for part, output in zip(tests, scaled, strict=True)]
    return found
