"""The bank and the paper's pipeline as scikit-learn estimators: clone, set_output, GridSearchCV, grouped splits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, OneToOneFeatureMixin, TransformerMixin
from sklearn.compose import TransformedTargetRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.validation import check_is_fitted, validate_data

from compensation.memories.ema import PAPER_COUNT, PAPER_FACTOR, PAPER_RATE_HZ, smooth, smoothing_factors

# A filter has memory: these checks permute or thin out the rows, which are samples in time here.
EXPECTED_FAILED_CHECKS = {
    "check_methods_sample_order_invariance": "the bank reads rows as samples in time",
    "check_methods_subset_invariance": "the bank reads rows as samples in time",
}


class SmoothingBank(OneToOneFeatureMixin, TransformerMixin, BaseEstimator):
    """Exponential smoothing of every column with ``alpha_i = factor^-i``, i = 1..count; rows are samples in time.

    Parameters
    ----------
    factor : float
        The paper's a.
    count : int
        The paper's N.
    rate_hz : float
        Sampling rate; only the initial value depends on it.
    start : {"paper", "causal"}
        See `compensation.memories.ema.smooth`.

    Notes
    -----
    Rows of different recordings must not follow one another without a break: pass ``groups`` (one label a row) to
    `transform`, and the bank starts anew wherever the label changes.
    """

    def __init__(
        self,
        factor: float = PAPER_FACTOR,
        count: int = PAPER_COUNT,
        rate_hz: float = PAPER_RATE_HZ,
        start: str = "paper",
    ) -> None:
        self.factor = factor
        self.count = count
        self.rate_hz = rate_hz
        self.start = start

    def fit(self, X: Any, y: Any = None) -> SmoothingBank:
        """Check the input and compute the factors; nothing is learned."""
        validate_data(self, X, dtype=np.float64)
        self.alphas_ = smoothing_factors(self.factor, self.count)
        return self

    def transform(self, X: Any, groups: Any = None) -> NDArray[np.float64]:
        """Smoothed columns: shape (n, columns x count), all factors of the first column first."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        if groups is None:
            return self._smooth(X)
        edges = np.flatnonzero(np.asarray(groups)[1:] != np.asarray(groups)[:-1]) + 1
        return np.concatenate([self._smooth(part) for part in np.split(X, edges)])

    def _smooth(self, X: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.hstack([smooth(column, self.alphas_, self.rate_hz, self.start) for column in X.T])

    def get_feature_names_out(self, input_features: Any = None) -> NDArray[np.object_]:
        """``name_a1`` ... ``name_aN`` for each input column."""
        names = super().get_feature_names_out(input_features)
        numbers = range(1, len(self.alphas_) + 1)
        return np.asarray([f"{name}_a{number}" for name in names for number in numbers], dtype=object)


def paper_pipeline(
    sizes: tuple[int, ...] = (4, 2, 2),
    factor: float = PAPER_FACTOR,
    count: int = PAPER_COUNT,
    seed: int | None = None,
) -> TransformedTargetRegressor:
    """The paper's compensator out of scikit-learn's own parts: StandardScaler, bank, MLPRegressor.

    Fit it on conductance (n, 1) at 20 Hz and force (n,). `compensation train --engine sklearn --restarts 1` gives the
    same numbers.
    """
    network = MLPRegressor(hidden_layer_sizes=sizes, activation="relu", max_iter=10_000, random_state=seed)
    steps = [("scale", StandardScaler()), ("bank", SmoothingBank(factor, count)), ("network", network)]
    return TransformedTargetRegressor(Pipeline(steps), transformer=StandardScaler())
