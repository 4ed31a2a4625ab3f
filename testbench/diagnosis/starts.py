"""Where a refit with another law starts."""

from __future__ import annotations

import numpy as np

from testbench.diagnosis.evidence.hypothesis import Hypothesis
from testbench.diagnosis.evidence.laplace import PARTS
from testbench.diagnosis.evidence.likelihood import Likelihood
from testbench.diagnosis.proposals import Proposal
from testbench.fitting.downhill import huber
from testbench.fitting.parameters import with_values
from testbench.knit.model import KnitModel


def best_start(h: Hypothesis, p: Proposal, likelihood: Likelihood) -> KnitModel:
    """The model with the law in it, at whichever of a few points fits best.

    The linear model promises the maximum a step away. The shapes are linear in their weights, so their part of that
    step is taken whole; of the part of the other parameters a share. Two points have no step: the law as it was
    proposed, and weak.

    Parameters
    ----------
    h : Hypothesis
        The model beside which the law was proposed.
    """
    low, high = h.priors.low, h.priors.high
    tried = [h.model.plus(p.first), h.model.plus(p.effect)]
    for part in PARTS:
        step = np.where(h.priors.group >= 0, p.step, part * p.step)
        tried.append(with_values(h.model, h.priors.parameters, np.clip(h.vector + step, low, high)).plus(p.effect))
    return min(tried, key=lambda one: _misfit(one, h, likelihood))


def _misfit(model: KnitModel, h: Hypothesis, likelihood: Likelihood) -> float:
    residual = likelihood.measurement.residual(model)
    total = sum(
        float(np.sum(huber(np.abs(likelihood.picked(values, c)) / h.evidence.sigma[c])))
        for c, values in residual.items()
    )
    return total if np.isfinite(total) else np.inf
