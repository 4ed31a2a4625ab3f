"""Fitting one network: scikit-learn's MLPRegressor as the reference, and faster ways to the same end."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from compensation.engines.adam import BATCH, Fit, train_adam
from compensation.engines.network import Network
from gcode.support.arrays import FloatArray

MAX_EPOCHS = 10_000
DEFAULT_L2 = 1e-4
# Found on samples of the candidates on other sensors' recordings than benchmarks/bench_training.py prints.
FAST_ROWS, FAST_STRIDE, FAST_BATCH, FAST_RATE, FAST_AVERAGING = 2_500, 7, 40, 6e-3, 0.9


def sklearn_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """scikit-learn's MLPRegressor with the paper's settings: relu, Adam, at most 10,000 epochs."""
    from sklearn.neural_network import MLPRegressor

    regressor = MLPRegressor(
        hidden_layer_sizes=tuple(sizes), activation="relu", alpha=l2, max_iter=MAX_EPOCHS, random_state=seed
    ).fit(features, target)
    network = Network(tuple(regressor.coefs_), tuple(regressor.intercepts_))
    return Fit(network, np.asarray(regressor.loss_curve_))


def exact_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """The same training, compiled: the same seed gives scikit-learn's loss curve to rounding."""
    return train_adam(features, target, sizes, seed, l2, MAX_EPOCHS)


def fast_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """Every k-th row only, k <= 7, in smaller batches with a larger step, and the mean of the last epochs' weights.

    Neighbours at 20 Hz say nearly the same, and the bank has seen them all. A larger step needs fewer epochs but
    jumps about the minimum; the mean does not.
    """
    stride = int(np.clip(len(features) // FAST_ROWS, 1, FAST_STRIDE))
    rows, truth = features[::stride], target[::stride]
    # MLPRegressor divides L2 by the batch size: as much of it here as in batches of its own size.
    l2 = l2 * FAST_BATCH / BATCH
    return train_adam(
        rows, truth, sizes, seed, l2, MAX_EPOCHS, batch=FAST_BATCH, rate=FAST_RATE, averaging=FAST_AVERAGING
    )


Engine = Callable[[FloatArray, FloatArray, Sequence[int], int, float], Fit]
ENGINES: dict[str, Engine] = {"exact": exact_engine, "fast": fast_engine, "sklearn": sklearn_engine}
