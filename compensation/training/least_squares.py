"""Ridge regression from sums of products, so that folds are added and taken away without going through rows again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from compensation.training.lessons import Lessons
from gcode.support.arrays import FloatArray

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Sums:
    """Sums over some rows of products of the features, a one and the target, each shape (k + 2, k + 2)."""

    learn: FloatArray  # averaged over all versions of the recording
    judge: FloatArray  # of the first version alone, the recording as it is

    @classmethod
    def of(cls, lesson: Lessons, rows: Mask) -> Sums:
        """The sums over these rows."""
        products = []
        for version in lesson.versions:
            x = np.column_stack([version[rows], np.ones(rows.sum()), lesson.truth[rows]])
            products.append(x.T @ x)
        return cls(np.sum(products, axis=0) / len(products), products[0])

    @classmethod
    def total(cls, parts: Sequence[Sums]) -> Sums:
        """The sums over the rows of all parts."""
        return cls(sum(part.learn for part in parts), sum(part.judge for part in parts))  # type: ignore[arg-type]

    def solved(self, l2: float) -> tuple[FloatArray, float]:
        """Weights and bias; the penalty is on features of unit variance, in shares of the number of rows."""
        count = self.learn[-2, -2]
        mean = self.learn[:-2, -2] / count
        covariance = self.learn[:-2, :-2] / count - np.outer(mean, mean)
        target_mean = self.learn[-1, -2] / count
        cross = self.learn[:-2, -1] / count - mean * target_mean
        spread = np.sqrt(np.maximum(np.diag(covariance), 1e-12))
        scaled = covariance / np.outer(spread, spread) + l2 * np.eye(len(spread))
        weights = np.linalg.solve(scaled, cross / spread) / spread
        return weights, float(target_mean - mean @ weights)

    def error(self, weights: FloatArray, bias: float) -> float:
        """Sum of squared errors on these rows."""
        w = np.concatenate([weights, [bias, -1.0]])
        return float(w @ self.judge @ w)
