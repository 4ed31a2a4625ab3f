"""The compensator as a scikit-learn regressor: conductance to force or displacement, rows in time."""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Iterable
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.linear_model import Ridge
from sklearn.metrics import r2_score
from sklearn.preprocessing import StandardScaler
from sklearn.utils.validation import check_is_fitted, validate_data

from compensation.memories.ema import PAPER_COUNT, PAPER_RATE_HZ, smooth, smoothing_factors
from compensation.model.compensator import TrainedCompensator
from compensation.model.files import save
from compensation.model.runtime import LARGEST_RATE_HZ, SMALLEST_RATE_HZ, streamable
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import TARGETS, Series, stands_still
from compensation.training.options import HIGHEST_SEED, Options
from compensation.training.training import METHODS
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.kinds import is_number

RIDGE = "ridge"
EVERY_METHOD = (*METHODS, RIDGE)
# Below, the networks of auto have nothing to be validated on.
FEWEST_S, FEWEST_ROWS = 20.0, 10
RIDGE_L2 = 1e-2
# Sums of their squares are neither zero nor infinite.
LEAST, MOST = 1e-100, 1e100


class Compensator(RegressorMixin, BaseEstimator):
    """Learn force or displacement from the history of a conductance.

    Parameters
    ----------
    method : {"auto", "paper", "tuned", "ridge"}
        As ``compensation train --method``; ``ridge`` is a ridge regression on the smoothing bank. Several columns,
        less than 20 s, or a constant are always learned by ``ridge``, with a warning where another one was asked for.
    target : {"force", "displacement"}
        What y is, in N or mm; needed to save or export.
    rate_hz : float
        Sampling rate of the rows.
    seed : int
        Of the networks' first weights.

    Attributes
    ----------
    compensator_ : compensation.model.compensator.TrainedCompensator or None
        What was learned, as it is (`trained` checks it for use); None where `ridge` was used.
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
    ``auto`` holds out whole recordings. With scikit-learn's metadata routing: ``set_fit_request(groups=True)``, and
    likewise for ``predict`` and ``score``.
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
            Label of the recording that each row belongs to; rows of one label are in order of time.

        Raises
        ------
        ValueError
            If a parameter is none of those allowed, X and y do not fit or are in odd units, or a recording has a
            single row.
        """
        self.__dict__.pop("compensator_", None)  # where this fit fails, nothing is fitted
        self._check_parameters()
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True, ensure_min_samples=2)
        for name, values in (("X", X), ("y", y)):
            largest = float(np.abs(values).max())  # a float32 cannot be compared with 1e100
            if largest != 0 and not LEAST <= largest <= MOST:
                raise ValueError(
                    f"{name} is as large as {largest:.3g}, and {LEAST:g} to {MOST:g} can be squared; rescale it"
                )
        parts = _parts(len(X), groups)
        for label, rows in parts.items():
            if len(rows) < 2:
                raise ValueError(
                    f"a recording needs at least 2 rows, group {label!r} has 1; give it more or leave it out"
                )
        self._why_ridge = self._reason_for_ridge(X, y)
        if self._why_ridge and self.method != RIDGE:
            warnings.warn(f"learned by ridge, not by {self.method}: {self._why_ridge}", stacklevel=2)
        learned, self._ridge = None, None
        if self._why_ridge:
            self._ridge = _Ridge(X, y, parts.values(), self.rate_hz)
        else:
            series = [
                Series(np.arange(len(rows)) / self.rate_hz, X[rows, 0], y[rows], "fit") for rows in parts.values()
            ]
            options = Options(seed=int(self.seed), rate_hz=float(self.rate_hz))
            learned = METHODS[self.method](series, self.target, options)
        self.compensator_: TrainedCompensator | None = learned
        return self

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "compensator_")

    def predict(self, X: Any, groups: Any = None) -> FloatArray:
        """Predict each recording from its first row on, as `stream` does: shape (n,), in the unit of y."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        out = np.empty(len(X))
        for rows in _parts(len(X), groups).values():
            if self.compensator_ is not None:
                time_s = np.arange(len(rows)) / self.rate_hz
                out[rows] = self.compensator_.in_use.predict(time_s, X[rows, 0])
            elif self._ridge is not None:
                out[rows] = self._ridge.predict(X[rows])
        return out

    def score(self, X: Any, y: Any, sample_weight: Any = None, groups: Any = None) -> float:
        """The usual coefficient of determination of `predict`."""
        return float(r2_score(y, self.predict(X, groups), sample_weight=sample_weight))

    def stream(self) -> CompensatorStream:
        """A fresh running state, to be fed sample by sample: ``update(conductance_S, dt_s)``, ``status``."""
        return CompensatorStream(self)

    def save(self, path: str | Path) -> None:
        """Write what ``compensation predict``, ``score`` and ``export`` read."""
        save(path, self.trained())

    def trained(self) -> TrainedCompensator:
        """What was learned, for whatever feeds it conductances in S: `stream`, `save`, `predicted` and the exports.

        Raises
        ------
        NotFittedError
            Before `fit`.
        UserError
            If `ridge` was used, or what was learned from is no conductance in S.
        """
        check_is_fitted(self)
        if self.compensator_ is None:
            raise UserError(
                f"fitted by ridge ({self._why_ridge}): it has no stream, no file and no export; fit one column of "
                f"{FEWEST_S:g} s or more with method auto, paper or tuned"
            )
        return streamable(self.compensator_)

    def _check_parameters(self) -> None:
        if self.method not in EVERY_METHOD or self.target not in tuple(TARGETS):
            raise ValueError(
                f"method must be one of {', '.join(EVERY_METHOD)} and target one of {', '.join(TARGETS)}, "
                f"got {self.method!r} and {self.target!r}"
            )
        if not (is_number(self.rate_hz) and SMALLEST_RATE_HZ <= self.rate_hz <= LARGEST_RATE_HZ):
            raise ValueError(
                f"rate_hz must be a number from {SMALLEST_RATE_HZ:.3g} (one sample an hour) to "
                f"{LARGEST_RATE_HZ:.3g}, got {self.rate_hz!r}"
            )
        if not (is_number(self.seed, Integral) and 0 <= self.seed <= HIGHEST_SEED):
            raise ValueError(f"seed must be a whole number from 0 to {HIGHEST_SEED}, got {self.seed!r}")

    def _reason_for_ridge(self, X: FloatArray, y: FloatArray) -> str:
        """Why ridge is what learns; empty where it is not."""
        if self.method == RIDGE:
            return "as asked for"
        if X.shape[1] > 1:
            return f"X has {X.shape[1]} columns, the others take one"
        if len(X) < max(FEWEST_S * self.rate_hz, FEWEST_ROWS):
            has = f"{len(X)} rows are {len(X) / self.rate_hz:.3g} s"
            return f"{has}, the others need {FEWEST_S:g} s in {FEWEST_ROWS} rows"
        if stands_still(X) or stands_still(y):
            return "the conductance or the target is constant"
        return ""

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        # On the shuffled rows of scikit-learn's checks history says nothing.
        tags.regressor_tags.poor_score = True
        return tags


class _Ridge:
    """A ridge regression on the smoothing bank of each column, standardised by the training."""

    def __init__(self, X: FloatArray, y: FloatArray, parts: Iterable[NDArray[np.intp]], rate_hz: float) -> None:
        self._scaler, self._rate_hz = StandardScaler().fit(X), rate_hz
        features = np.empty((len(X), X.shape[1] * PAPER_COUNT))
        for rows in parts:
            features[rows] = self._memories(X[rows])
        self._line = Ridge(RIDGE_L2 * len(X)).fit(features, y)

    def predict(self, X: FloatArray) -> FloatArray:
        """Target of one recording's rows."""
        return self._line.predict(self._memories(X))

    def _memories(self, X: FloatArray) -> FloatArray:
        columns = self._scaler.transform(X).T
        return np.hstack([smooth(column, smoothing_factors(), self._rate_hz, start="causal") for column in columns])


def _parts(count: int, groups: Any) -> dict[Hashable, NDArray[np.intp]]:
    """Rows of each recording, by its label in order of appearance."""
    if groups is None:
        return {None: np.arange(count)}
    labels = np.asarray(groups)
    if labels.shape != (count,):
        raise ValueError(f"groups must have one label a row, {count}, got shape {labels.shape}")
    codes, names = pd.factorize(labels, use_na_sentinel=False)
    return {name: np.flatnonzero(codes == code) for code, name in enumerate(names.tolist())}
