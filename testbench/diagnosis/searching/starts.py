"""Where a refit with another law starts."""

from __future__ import annotations

import numpy as np

from testbench.comparing.ladder import drawn_to_data
from testbench.diagnosis.judging.entries import Proposal
from testbench.diagnosis.searching.proposals import Law
from testbench.fitting.downhill import huber
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import PARTS
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.effect import Effect
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
    tried = [h.model.plus(p.weak), h.model.plus(p.effect)]
    for part in (*PARTS, 0.0):
        step = np.where(h.priors.group >= 0, p.step, part * p.step)
        tried.append(h.priors.parameters.model_at(h.model, h.vector + step).plus(p.effect))
    return min(tried, key=lambda one: _misfit(one, h, likelihood))


def drawn_anew(h: Hypothesis, law: Law, likelihood: Likelihood) -> KnitModel:
    """The model with a law that changes the strain, and its base drawn anew to the data over what is left of that.

    Of all points of the law the one that fits best. Where much of a stretch only takes up slack, the knit is many
    times as stiff over the rest: no small step leads there.
    """
    measurement = likelihood.measurement

    def drawn(effect: Effect) -> KnitModel:
        model = h.model.plus(effect)
        strain = model.simulate(measurement.signals, measurement.dt_s)["strain"]
        for name in h.model:
            if not model[name].strength:
                model = model.replacing(name, drawn_to_data(model[name], measurement, strain))
        return model

    return min((drawn(one.effect) for one in law.candidates), key=lambda one: _misfit(one, h, likelihood))


def _misfit(model: KnitModel, h: Hypothesis, likelihood: Likelihood) -> float:
    residual = likelihood.measurement.residual(model)
    total = sum(
        float(np.sum(huber(np.abs(likelihood.picked(values, c)) / h.evidence.sigma[c])))
        for c, values in residual.items()
    )
    return total if np.isfinite(total) else np.inf
