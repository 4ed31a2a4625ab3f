"""How much a recording would tell which of several Gaussian hypotheses holds: mutual information, in nats.

y | h ~ N(m_h, I + F_h F_h^T), in units of the noise that all hypotheses share. The information of an experiment is
the mutual information between hypothesis and reading (Lindley, Ann. Math. Statist. 27 (1956) 986). For a mixture of
Gaussians it lies between two sums over pairs (Kolchinsky & Tracey, Entropy 19 (2017) 361):

    - sum_i p_i ln sum_j p_j exp(-D_ij),   D: Bhattacharyya distance (below), Kullback-Leibler divergence (above).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbench.knit.effect import FloatArray


@dataclass(frozen=True, eq=False)
class Prediction:
    """What one hypothesis expects to read, over the noise.

    Attributes
    ----------
    mean : ndarray, shape (n,)
    factor : ndarray, shape (n, k)
        Standard deviations that its parameters add to the noise, along k independent directions.
    """

    mean: FloatArray
    factor: FloatArray


@dataclass(frozen=True)
class Information:
    """Mutual information between hypothesis and reading, in nats.

    Attributes
    ----------
    low, high : float
        Bounds.
    conditional_entropy : float
        Of the hypotheses once the reading is known, at most: their entropy less `low`, exact where it is small.
        Motions that tell nearly all are ranked by it.
    """

    low: float
    high: float
    conditional_entropy: float


def information(predictions: Sequence[Prediction], probabilities: Sequence[float]) -> Information:
    """Bounds of what a reading tells about which hypothesis holds.

    Parameters
    ----------
    predictions : sequence of Prediction
        Of one motion, one of each hypothesis.
    probabilities : sequence of float
        Probabilities of the hypotheses; they are normalised. What cannot be is neither told nor told from.

    Returns
    -------
    Information
    """
    possible = [(one, chance) for one, chance in zip(predictions, probabilities, strict=True) if chance > 0]
    gaussians = _spanned([one for one, _ in possible])
    weight = np.array([chance for _, chance in possible], dtype=float)
    weight /= weight.sum()
    near = np.array([[_bhattacharyya(one, other) for other in gaussians] for one in gaussians])
    far = np.array([[_divergence(one, other) for other in gaussians] for one in gaussians])
    entropy = float(-weight @ np.log(weight))
    most, least = _conditional_entropy(near, weight), _conditional_entropy(far, weight)
    return Information(max(entropy - most, 0.0), max(entropy - least, 0.0), most)


_Gaussian = tuple[FloatArray, FloatArray]  # mean and covariance


def _spanned(predictions: Sequence[Prediction]) -> list[_Gaussian]:
    """All predictions in the space in which they differ from pure noise about the first one's mean."""
    apart = np.column_stack([p.mean - predictions[0].mean for p in predictions])
    basis = np.linalg.qr(np.hstack([apart, *(p.factor for p in predictions)]))[0]
    inside = [basis.T @ p.factor for p in predictions]
    return [(mean, np.eye(len(mean)) + f @ f.T) for mean, f in zip((basis.T @ apart).T, inside, strict=True)]


def _bhattacharyya(one: _Gaussian, other: _Gaussian) -> float:
    shift, middle = one[0] - other[0], 0.5 * (one[1] + other[1])
    spread = _log_det(middle) - 0.5 * (_log_det(one[1]) + _log_det(other[1]))
    return float(shift @ np.linalg.solve(middle, shift)) / 8 + 0.5 * spread


def _divergence(one: _Gaussian, other: _Gaussian) -> float:
    """Kullback-Leibler divergence of `one` from `other`, in nats."""
    shift = one[0] - other[0]
    trace = float(np.trace(np.linalg.solve(other[1], one[1])))
    spread = _log_det(other[1]) - _log_det(one[1])
    return 0.5 * (trace + float(shift @ np.linalg.solve(other[1], shift)) - len(shift) + spread)


def _log_det(covariance: FloatArray) -> float:
    return float(np.linalg.slogdet(covariance)[1])


def _conditional_entropy(distance: FloatArray, weight: FloatArray) -> float:
    """Entropy less information: sum_i p_i ln(1 + sum_(j not i) p_j / p_i exp(-D_ij))."""
    odds = np.exp(-np.maximum(distance, 0.0)) * weight[None, :] / weight[:, None]
    np.fill_diagonal(odds, 0.0)
    return float(weight @ np.log1p(odds.sum(axis=1)))
