"""A law put into the model and refitted together with the base: its evidence, and its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from testbench.diagnosis.judging.entries import Proposal
from testbench.diagnosis.searching.proposals import Screen
from testbench.diagnosis.searching.starts import best_start
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.likelihood import Likelihood
from testbench.knit.effect import Effect, bounds_of
from testbench.knit.model import KnitModel
from testbench.proposing.grids import MOST_SKEW, Grid
from testbench.proposing.laws.grammar import PRICE_OF_PIECE
from testbench.proposing.laws.law import Law
from testbench.proposing.writing import effect_class, strength_key

TIED_NATS = 3.0  # evidences that are no farther apart cannot be told from each other
QUICK = 6  # iterations of a first refit; the best are carried to their end
WIDTHS = {"time": 2.0, "size": 1.5, "path": 1.5, "number": 0.7}  # e-folds, before seeing data; of others, 1


@dataclass(frozen=True)
class Trial:
    """A law that was refitted in a model.

    Attributes
    ----------
    law : Law
        With its numbers as refitted.
    name : str
        In the model.
    log_z : float
        Log evidence, the price of its pieces taken off.
    """

    law: Law
    name: str
    hypothesis: Hypothesis
    log_z: float


class LawFitter:
    """Refits laws beside a base: by a likelihood, with priors of the base laws around a reference model."""

    def __init__(self, likelihood: Likelihood, reference: KnitModel, grid: Grid) -> None:
        self.likelihood, self.reference, self.grid = likelihood, reference, grid

    def tried(self, law: Law, name: str, current: Hypothesis, prior_sd: float, base: KnitModel) -> Trial:
        """A law refitted quickly beside a model.

        Parameters
        ----------
        prior_sd : float
            Typical strength of the law.
        base : KnitModel
            The model itself, or without an earlier guess at the law: then its base has made room for it already.
        """
        effect = effect_class(law, name, self.grid)()
        has_room = base != current.model
        model = base.plus(effect, name) if has_room else self.start(current, effect, name, prior_sd)
        known_priors = self.priors_of(law, effect, name, prior_sd)
        h = fitted(model, self.likelihood, self.reference, current, QUICK, True, known_priors)
        return self.trial(law, name, h)

    def start(self, current: Hypothesis, effect: Effect, name: str, prior_sd: float) -> KnitModel:
        """Where the linear model of base and law together promises the maximum, as far as that holds.

        The base has taken in what it could of the law: beside the base as it is, the law at its size does harm, and a
        fit would take it away again.
        """
        plain = self.likelihood.measurement.modelled(current.model)
        changed = self.likelihood.measurement.modelled(current.model.plus(effect, name))
        screen = Screen(current, self.likelihood)
        rows = {c: self.likelihood.picked(changed[c] - plain[c], c)[None] * current.robust[c] for c in plain}
        strength = getattr(effect, effect.strength)
        found = screen.evidence(rows, 0.0, (strength / prior_sd) ** 2, -1)
        there = effect.near(**{effect.strength: float(found.coefficients[-1]) * strength})
        gain = found.value - screen.plain.value
        return best_start(current, Proposal(name, name, there, gain, screen.room_made(found, 1)), self.likelihood)

    def settled(self, trial: Trial) -> Trial:
        """A trial whose refit is continued until it has converged."""
        h = fitted(trial.hypothesis.model, self.likelihood, self.reference, trial.hypothesis)
        return self.trial(trial.law, trial.name, h)

    def anew(self, trial: Trial, model: KnitModel) -> Trial:
        """The law of a trial refitted in another model, with the same priors of its parameters."""
        h = fitted(model, self.likelihood, self.reference, known_priors=trial.hypothesis.priors.by_address)
        return self.trial(trial.law, trial.name, h)

    def trial(self, law: Law, name: str, h: Hypothesis) -> Trial:
        """A trial from a fitted model that holds the law under `name`."""
        law = as_fitted(law, h.model[name])
        return Trial(law, name, h, h.log_z - PRICE_OF_PIECE * len(law.term.operators))

    def priors_of(self, law: Law, effect: Effect, name: str, prior_sd: float) -> Mapping[str, tuple[float, float]]:
        """Priors of a law's parameters, mean and standard deviation: wide, since the search saw the data already."""
        found = {f"{name}.{strength_key(law)}": (0.0, prior_sd)}
        for slot in law.term.slots:
            value = law.values[slot.key]
            log = bounds_of(type(effect).model_fields[slot.key])["scale"] == "log"
            if slot.kind == "time":
                times = self.grid.times_s(2)
                centre = float(np.mean(np.log(times)))
                found[f"{name}.{slot.key}"] = (centre, max(WIDTHS["time"], abs(np.log(value) - centre)))
            elif log:
                found[f"{name}.{slot.key}"] = (float(np.log(value)), WIDTHS.get(slot.kind, 1.0))
            else:
                reaches = {"angle": np.pi, "delay": 1.0, "skew": MOST_SKEW, "strain": 0.5 * self.grid.span}
                found[f"{name}.{slot.key}"] = (value, reaches.get(slot.kind) or max(abs(value), 1e-6))
        return found


def as_fitted(law: Law, effect: Effect) -> Law:
    """The law with the parameters that its effect has in a fitted model."""
    values = {slot.key: float(getattr(effect, slot.key)) for slot in law.term.slots}
    return replace(law, values=values, strength=float(getattr(effect, strength_key(law))))
