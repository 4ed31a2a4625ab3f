"""The compensator as a scikit-learn regressor: conductance to force or displacement, rows in time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from compensation.memories.ema import PAPER_RATE_HZ, smooth, smoothing_factors
from compensation.model.compensator import TrainedCompensator
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import TARGETS, Series
from compensation.training.auto import train_automatically
from compensation.training.options import Options
from compensation.training.training import train_on_series
from compensation.training.tuning import tune
from gcode.support.arrays import FloatArray

METHODS = ("auto", "paper", "tuned", "ridge")
# 20 s at 20 Hz: below, the networks of auto have nothing to be validated on.
FEWEST_ROWS = 400
RIDGE_L2 = 1e-2

# It has memory: these checks permute or thin out the rows, which are samples in time here.
EXPECTED_FAILED_CHECKS = {
    "check_methods_sample_order_invariance": "rows are samples in time, and history matters",
    "check_methods_subset_invariance": "rows are samples in time, and history matters",
}


class Compensator(RegressorMixin, BaseEstimator):
    """Learn force or displacement from the history of a conductance.

    Parameters
    ----------
    method : {"auto", "paper", "tuned", "ridge"}
        As ``compensation train --method``; ``ridge`` is a ridge regression on the smoothing bank. Several columns, or
        less than 20 s, are always learned by ``ridge``.
    target : {"force", "displacement"}
        What y is, in N or mm; needed to save or export.
    rate_hz : float
        Sampling rate of the rows.
    seed : int

    Attributes
    ----------
    compensator_ : compensation.model.compensator.TrainedCompensator or None
        What `stream`, `save` and the exports use; None where `ridge` was used.
    n_features_in_ : int

    Examples
    --------
    >>> import testbench as tb
    >>> from compensation import Compensator
    >>> recording, other = (tb.example(seed=seed, duration_s=60).resampled(20.0) for seed in (1, 2))
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> model.score(other.conductance_S[:, None], other["force_N"]) > 0.9
    True

    Notes
    -----
    Pass ``groups``, one label a row, where rows of several recordings follow one another: each begins anew, and
    ``auto`` holds out whole recordings. With scikit-learn's metadata routing: ``set_fit_request(groups=True)``.
    """

    def __init__(
        self, method: str = "auto", target: str = "force", rate_hz: float = PAPER_RATE_HZ, seed: int = 0
    ) -> None:
        self.method = method
        self.target = target
        self.rate_hz = rate_hz
        self.seed = seed

    def fit(self, X: Any, y: Any, groups: Any = None) -> Compensator:
        """Learn the target from the history of the conductance.

        Parameters
        ----------
        X : array-like, shape (n, 1) or (n, k)
            Conductance in S, in order of time at `rate_hz`; further columns are further signals.
        y : array-like, shape (n,)
        groups : array-like, shape (n,), optional
            Label of the recording that each row belongs to.

        Raises
        ------
        ValueError
            If a parameter is none of those allowed, or X and y do not fit.
        """
        if self.method not in METHODS or self.target not in TARGETS:
            raise ValueError(
                f"method must be one of {', '.join(METHODS)} and target one of {', '.join(TARGETS)}, "
                f"got {self.method!r} and {self.target!r}"
            )
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True, ensure_min_samples=2)
        parts = _parts(len(X), groups)
        varies = np.ptp(X[:, 0]) > 0 and np.ptp(y) > 0
        long_enough = len(X) >= FEWEST_ROWS and min(map(len, parts)) > 1
        self.compensator_: TrainedCompensator | None = None
        if self.method != "ridge" and X.shape[1] == 1 and long_enough and varies:
            self.compensator_ = self._trained([self._series(X[rows, 0], y[rows]) for rows in parts])
        else:
            self._fit_ridge(X, y, parts)
        return self

    def predict(self, X: Any, groups: Any = None) -> FloatArray:
        """Predict each recording from its first row on: shape (n,), in the unit of y."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        out = np.empty(len(X))
        for rows in _parts(len(X), groups):
            if self.compensator_ is not None:
                time_s = np.arange(len(rows)) / self.rate_hz
                out[rows] = self.compensator_.predict(time_s, X[rows, 0])
            else:
                out[rows] = self._memories(X[rows]) @ self.coef_ + self.intercept_
        return out

    def stream(self) -> CompensatorStream:
        """A fresh running state, to be fed sample by sample: ``update(conductance_S, dt_s)``, ``status``."""
        return CompensatorStream(self._whole())

    def save(self, path: str | Path) -> None:
        """Write what ``compensation predict``, ``score`` and ``export`` read."""
        from compensation.model.files import save

        save(path, self._whole())

    def _whole(self) -> TrainedCompensator:
        check_is_fitted(self)
        if self.compensator_ is None:
            raise ValueError(
                "fitted by ridge (asked for, or because of several columns, of under 20 s or of a constant): it has "
                "no stream and no file; fit one column of 20 s or more with method auto, paper or tuned"
            )
        return self.compensator_

    def _series(self, conductance_S: FloatArray, truth: FloatArray) -> Series:
        return Series(np.arange(len(truth)) / self.rate_hz, conductance_S, truth, "fit")

    def _trained(self, series: list[Series]) -> TrainedCompensator:
        options = Options(seed=self.seed, rate_hz=self.rate_hz)
        learn = {"auto": train_automatically, "paper": train_on_series, "tuned": tune}[self.method]
        return learn(series, self.target, options)

    def _fit_ridge(self, X: FloatArray, y: FloatArray, parts: list[NDArray[np.intp]]) -> None:
        self.mean_, self.scale_ = X.mean(axis=0), np.where(X.std(axis=0) > 0, X.std(axis=0), 1.0)
        features = np.empty((len(X), X.shape[1] * len(smoothing_factors())))
        for rows in parts:
            features[rows] = self._memories(X[rows])
        centre = features.mean(axis=0)
        centred = features - centre
        gram = centred.T @ centred / len(X) + RIDGE_L2 * np.eye(features.shape[1])
        self.coef_ = np.linalg.solve(gram, centred.T @ (y - y.mean()) / len(X))
        self.intercept_ = float(y.mean() - centre @ self.coef_)

    def _memories(self, X: FloatArray) -> FloatArray:
        standardised = (X - self.mean_) / self.scale_
        return np.hstack([smooth(column, smoothing_factors(), self.rate_hz) for column in standardised.T])

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        # On the shuffled rows of scikit-learn's checks history says nothing.
        tags.regressor_tags.poor_score = True
        return tags


def _parts(count: int, groups: Any) -> list[NDArray[np.intp]]:
    """Rows of each recording."""
    if groups is None:
        return [np.arange(count)]
    labels = np.asarray(groups)
    if labels.shape != (count,):
        raise ValueError(f"groups must have one label a row, {count}, got shape {labels.shape}")
    return np.split(np.arange(count), np.flatnonzero(labels[1:] != labels[:-1]) + 1)
