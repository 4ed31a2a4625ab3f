"""Fitting one network: scikit-learn's MLPRegressor as the reference, and faster ways to the same end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from compensation.network import Network
from gcode.support.errors import UserError

FloatArray = NDArray[np.float64]

MAX_EPOCHS = 10_000
DEFAULT_L2 = 1e-4


@dataclass(frozen=True)
class Fit:
    """A trained network and its training loss after each epoch."""

    network: Network
    loss_curve: FloatArray


def sklearn_engine(features: FloatArray, target: FloatArray, sizes: Sequence[int], seed: int, l2: float) -> Fit:
    """scikit-learn's MLPRegressor with the paper's settings: relu, Adam, at most 10,000 epochs."""
    from sklearn.neural_network import MLPRegressor

    regressor = MLPRegressor(
        hidden_layer_sizes=tuple(sizes), activation="relu", alpha=l2, max_iter=MAX_EPOCHS, random_state=seed
    ).fit(features, target)
    network = Network(tuple(regressor.coefs_), tuple(regressor.intercepts_))
    return Fit(network, np.asarray(regressor.loss_curve_))


Engine = Callable[[FloatArray, FloatArray, Sequence[int], int, float], Fit]
ENGINES: dict[str, Engine] = {"sklearn": sklearn_engine}


def engine(name: str) -> Engine:
    """Engine by name."""
    try:
        return ENGINES[name]
    except KeyError:
        raise UserError(f"--engine must be one of {', '.join(ENGINES)}, got {name}") from None
