"""Fitting one network: scikit-learn's MLPRegressor as the reference, and faster ways to the same end.

`train_adam` is the reference's training, each epoch one compiled call (`compensation.engines.adam_kernels`). Random
numbers come from the same stream in the same order, so that the same seed gives the same network, to rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from compensation.engines.adam_kernels import epoch
from compensation.engines.network import Network
from gcode.support.arrays import FloatArray

BATCH = 200
LEARNING_RATE = 1e-3
TOLERANCE, PATIENCE = 1e-4, 10
MAX_EPOCHS = 10_000
DEFAULT_L2 = 1e-4
# Found on samples of the candidates on other sensors' recordings than benchmarks/bench_training.py prints.
FAST_ROWS, FAST_STRIDE, FAST_BATCH, FAST_RATE, FAST_AVERAGING = 2_500, 7, 40, 6e-3, 0.9


@dataclass(frozen=True)
class Fit:
    """A trained network and its training loss after each epoch."""

    network: Network
    loss_curve: FloatArray


def initial_weights(widths: Sequence[int], rng: np.random.RandomState) -> FloatArray:
    """Glorot's uniform start, drawn in MLPRegressor's order: layer by layer, its weights before its biases.

    `widths` includes the inputs and the single output.
    """
    layers = [(np.sqrt(6.0 / (fan_in + fan_out)), (fan_in + 1) * fan_out) for fan_in, fan_out in pairwise(widths)]
    return np.concatenate([rng.uniform(-bound, bound, count) for bound, count in layers])


def unflatten(flat: FloatArray, widths: Sequence[int]) -> Network:
    """A network of weights and biases in one vector, in the order of `initial_weights`."""
    weights, biases, at = [], [], 0
    for fan_in, fan_out in pairwise(widths):
        weights.append(flat[at : at + fan_in * fan_out].reshape(fan_in, fan_out).copy())
        at += fan_in * fan_out
        biases.append(flat[at : at + fan_out].copy())
        at += fan_out
    return Network(tuple(weights), tuple(biases))


def train_adam(
    features: FloatArray,
    target: FloatArray,
    sizes: Sequence[int],
    seed: int,
    l2: float,
    max_epochs: int = MAX_EPOCHS,
    batch: int = BATCH,
    rate: float = LEARNING_RATE,
    averaging: float = 0.0,
) -> Fit:
    """Train one network as `MLPRegressor(hidden_layer_sizes=sizes, alpha=l2, random_state=seed)` does, compiled.

    As it comes, the same seed gives scikit-learn's loss curve to rounding.

    Parameters
    ----------
    features, target : ndarray, shapes (n, k) and (n,)
    batch : int
        Rows a step; scikit-learn's is 200.
    rate : float
        Adam's learning rate; scikit-learn's is 0.001.
    averaging : float
        Share that the running mean of the weights, taken after each epoch, keeps of itself; that mean is returned.
        0 returns the last weights, as scikit-learn does. The mean does not jump about the minimum as the weights do
        (B. T. Polyak and A. B. Juditsky, Acceleration of stochastic approximation by averaging, 1992).
    """
    features, target = np.ascontiguousarray(features), np.ascontiguousarray(target)
    widths = (features.shape[1], *sizes, 1)
    widths_array = np.array(widths)
    rng = np.random.RandomState(seed)
    flat = initial_weights(widths, rng)
    first, second = np.zeros_like(flat), np.zeros_like(flat)
    mean, curve = flat, list[float]()
    order, best, stale, steps = np.arange(len(features)), np.inf, 0, 0
    while len(curve) < max_epochs and stale <= PATIENCE:
        order = order[rng.permutation(len(order))]
        total, steps = epoch(features, target, order, widths_array, flat, first, second, steps, l2, batch, rate)
        loss = total / len(order)
        curve.append(loss)
        stale = 0 if loss <= best - TOLERANCE else stale + 1  # a loss that is no number is no progress
        best = min(best, loss)
        share = max(1.0 - averaging, 1.0 / len(curve))
        mean = (1.0 - share) * mean + share * flat
    return Fit(unflatten(mean, widths), np.asarray(curve))


def sklearn_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """scikit-learn's MLPRegressor with the paper's settings: relu, Adam, at most 10,000 epochs."""
    from sklearn.neural_network import MLPRegressor

    regressor = MLPRegressor(
        hidden_layer_sizes=tuple(sizes), activation="relu", alpha=l2, max_iter=MAX_EPOCHS, random_state=seed
    ).fit(features, target)
    network = Network(tuple(regressor.coefs_), tuple(regressor.intercepts_))
    return Fit(network, np.asarray(regressor.loss_curve_))


def fast_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """Every k-th row only, k <= 7, in smaller batches with a larger step, and the mean of the last epochs' weights.

    Neighbours at 20 Hz say nearly the same, and the bank has seen them all. A larger step needs fewer epochs but
    jumps about the minimum; the mean does not.
    """
    stride = int(np.clip(len(features) // FAST_ROWS, 1, FAST_STRIDE))
    rows, truth = features[::stride], target[::stride]
    # MLPRegressor divides L2 by the batch size: as much of it here as in batches of its own size.
    l2 = l2 * FAST_BATCH / BATCH
    return train_adam(rows, truth, sizes, seed, l2, batch=FAST_BATCH, rate=FAST_RATE, averaging=FAST_AVERAGING)


Engine = Callable[[FloatArray, FloatArray, Sequence[int], int, float], Fit]
ENGINES: dict[str, Engine] = {"exact": train_adam, "fast": fast_engine, "sklearn": sklearn_engine}
