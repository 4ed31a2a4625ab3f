"""The information of an experiment by simulation, to hold its bounds against."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from testbench.design.information import Prediction


def sampled_information(
    predictions: Sequence[Prediction], probabilities: Sequence[float], rng: np.random.Generator, draws: int
) -> float:
    """Nested Monte Carlo: readings are drawn, and the hypotheses weighed with each, where they differ."""
    basis = np.linalg.qr(np.hstack([np.column_stack([p.mean, p.factor]) for p in predictions]))[0]
    gaussians = []
    for p in predictions:
        inside = basis.T @ p.factor
        gaussians.append(multivariate_normal(basis.T @ p.mean, np.eye(len(inside)) + inside @ inside.T))
    told = 0.0
    for truth, probability in zip(gaussians, probabilities, strict=True):
        readings = truth.rvs(draws, random_state=rng).reshape(draws, -1)
        log = np.array([np.atleast_1d(one.logpdf(readings)) for one in gaussians])
        told += probability * float(
            np.mean(truth.logpdf(readings) - logsumexp(log, axis=0, b=np.c_[list(probabilities)]))
        )
    return told
