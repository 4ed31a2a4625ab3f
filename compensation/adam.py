"""Minibatch Adam for small relu networks, compiled: the arithmetic of scikit-learn's MLPRegressor.

The reference spends most of its time between NumPy calls on 200 x 7 arrays. Here one call runs a whole epoch. Random
numbers come from the same stream in the same order, so that the same seed gives the same network, to rounding.
Arrays are laid out (layer, unit, row of the batch): the inner loop runs over rows and becomes vector instructions.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numba
import numpy as np
from numpy.typing import NDArray

from compensation.network import Network

FloatArray = NDArray[np.float64]

# Sums may be reordered, nothing else: the results differ from the reference by rounding.
jit = numba.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})

BATCH = 200
LEARNING_RATE, BETA_1, BETA_2, EPSILON = 1e-3, 0.9, 0.999, 1e-8
TOLERANCE, PATIENCE = 1e-4, 10


def initial_network(widths: Sequence[int], rng: np.random.RandomState) -> Network:
    """Glorot's uniform start, drawn in MLPRegressor's order. `widths` includes the inputs and the single output."""
    weights, biases = [], []
    for fan_in, fan_out in pairwise(widths):
        bound = np.sqrt(6.0 / (fan_in + fan_out))
        weights.append(rng.uniform(-bound, bound, (fan_in, fan_out)))
        biases.append(rng.uniform(-bound, bound, fan_out))
    return Network(tuple(weights), tuple(biases))


def flatten(network: Network) -> FloatArray:
    """All weights and biases in one vector, layer by layer, each layer's weights before its biases."""
    pairs = zip(network.weights, network.biases, strict=True)
    return np.concatenate([part.ravel() for pair in pairs for part in pair])


def unflatten(flat: FloatArray, widths: Sequence[int]) -> Network:
    """Inverse of `flatten`."""
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
    max_epochs: int,
    start: Network | None = None,
    batch: int = BATCH,
    rate: float = LEARNING_RATE,
    averaging: float = 0.0,
) -> tuple[Network, FloatArray]:
    """Train one network as `MLPRegressor(hidden_layer_sizes=sizes, alpha=l2, random_state=seed)` does.

    Parameters
    ----------
    features, target : ndarray, shapes (n, k) and (n,)
    start : Network, optional
        Go on from this network instead of a random one.
    batch : int
        Rows a step; scikit-learn's is 200.
    rate : float
        Adam's learning rate; scikit-learn's is 0.001.
    averaging : float
        Share that the running mean of the weights, taken after each epoch, keeps of itself; that mean is returned.
        0 returns the last weights, as scikit-learn does. The mean does not jump about the minimum as the weights do
        (B. T. Polyak and A. B. Juditsky, Acceleration of stochastic approximation by averaging, 1992).

    Returns
    -------
    network : Network
    loss_curve : ndarray, shape (epochs,)
    """
    features, target = np.ascontiguousarray(features), np.ascontiguousarray(target)
    widths = (features.shape[1], *sizes, 1)
    widths_array = np.array(widths)
    rng = np.random.RandomState(seed)
    flat = flatten(start or initial_network(widths, rng))
    first, second = np.zeros_like(flat), np.zeros_like(flat)
    mean, curve = flat, list[float]()
    order, best, stale, steps = np.arange(len(features)), np.inf, 0, 0
    while len(curve) < max_epochs and stale <= PATIENCE:
        order = order[_permutation(rng, len(order))]
        loss, steps = _epoch(features, target, order, widths_array, flat, first, second, steps, l2, batch, rate)
        curve.append(loss)
        stale = stale + 1 if loss > best - TOLERANCE else 0
        best = min(best, loss)
        share = max(1.0 - averaging, 1.0 / len(curve))
        mean = (1.0 - share) * mean + share * flat
    return unflatten(mean, widths), np.asarray(curve)


def _permutation(rng: np.random.RandomState, count: int) -> NDArray[np.int64]:
    indices = np.arange(count)
    rng.shuffle(indices)
    return indices


@jit
def _epoch(features, target, order, widths, flat, first, second, steps, l2, batch, rate):
    layers = len(widths) - 1
    active = np.zeros((layers + 1, widths.max(), batch))
    delta = np.zeros((layers + 1, widths.max(), batch))
    gradient = np.zeros(len(flat))
    total = 0.0
    for begin in range(0, len(order), batch):
        rows = order[begin : begin + batch]
        count = len(rows)
        for unit in range(widths[0]):
            for k in range(count):
                active[0, unit, k] = features[rows[k], unit]
        _forward(widths, flat, active, count)
        loss = 0.0
        for k in range(count):
            error = active[layers, 0, k] - target[rows[k]]
            delta[layers, 0, k] = error
            loss += error * error
        _backward(widths, flat, active, delta, gradient, count)
        penalty = _finish_gradient(widths, flat, gradient, l2, count)
        total += 0.5 * loss + 0.5 * l2 * penalty
        steps += 1
        _adam_step(flat, gradient, first, second, steps, rate)
    return total / len(order), steps


@jit
def _forward(widths, flat, active, count):
    layers = len(widths) - 1
    at = 0
    for layer in range(layers):
        n_in, n_out = widths[layer], widths[layer + 1]
        for j in range(n_out):
            out = active[layer + 1, j, :count]
            out[:] = flat[at + n_in * n_out + j]
            for i in range(n_in):
                weight, values = flat[at + i * n_out + j], active[layer, i, :count]
                for k in range(count):
                    out[k] += weight * values[k]
            if layer < layers - 1:
                for k in range(count):
                    out[k] = max(out[k], 0.0)
        at += (n_in + 1) * n_out


@jit
def _backward(widths, flat, active, delta, gradient, count):
    end = len(flat)
    for layer in range(len(widths) - 2, -1, -1):
        n_in, n_out = widths[layer], widths[layer + 1]
        at = end - (n_in + 1) * n_out
        for j in range(n_out):
            gradient[end - n_out + j] = delta[layer + 1, j, :count].sum()
        for i in range(n_in):
            values, back = active[layer, i, :count], delta[layer, i, :count]
            back[:] = 0.0
            for j in range(n_out):
                weight, step = flat[at + i * n_out + j], delta[layer + 1, j, :count]
                product = 0.0
                for k in range(count):
                    product += values[k] * step[k]
                    back[k] += weight * step[k]
                gradient[at + i * n_out + j] = product
            for k in range(count):
                back[k] = back[k] if values[k] > 0.0 else 0.0
        end = at


@jit
def _finish_gradient(widths, flat, gradient, l2, count):
    penalty = 0.0
    at = 0
    for layer in range(len(widths) - 1):
        weights = widths[layer] * widths[layer + 1]
        for k in range(at, at + weights):
            penalty += flat[k] * flat[k]
            gradient[k] += l2 * flat[k]
        at += weights + widths[layer + 1]
    for k in range(len(gradient)):
        gradient[k] /= count
    return penalty


@jit
def _adam_step(flat, gradient, first, second, steps, rate):
    step = rate * np.sqrt(1 - BETA_2**steps) / (1 - BETA_1**steps)
    for k in range(len(flat)):
        first[k] = BETA_1 * first[k] + (1 - BETA_1) * gradient[k]
        second[k] = BETA_2 * second[k] + (1 - BETA_2) * gradient[k] * gradient[k]
        flat[k] -= step * first[k] / (np.sqrt(second[k]) + EPSILON)
