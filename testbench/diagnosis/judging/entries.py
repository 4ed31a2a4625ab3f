"""What is put into a model: one law, to first order or refitted, and all that a search put in, together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.model import KnitModel

WEAK = 0.1  # of the strength that the data ask for to first order


@dataclass(frozen=True, eq=False)
class Proposal:
    """A law at its best point.

    Attributes
    ----------
    mechanism, law : str
    effect : Effect
    gain : float
        In ln Z, to first order.
    step : ndarray, shape (p,)
        By which the model's own parameters move to make room for it, to first order, in the fit's coordinates.
    model : KnitModel, optional
        With the law in it, where it was refitted beside a stiff base; `gain` is then that of the refit.
    """

    mechanism: str
    law: str
    effect: Effect
    gain: float
    step: FloatArray
    model: KnitModel | None = None

    @property
    def weak(self) -> Effect:
        """The law, weak: a start for a fit of a model that has made no room for it yet."""
        strength = getattr(self.effect, self.effect.strength)
        if self.effect.nonlinear or isinstance(strength, tuple):
            return self.effect
        return self.effect.near(**{self.effect.strength: WEAK * strength})


@dataclass(frozen=True, eq=False)
class Entry:
    """One law put in and refitted.

    Attributes
    ----------
    mechanism, law, name : str
        Of the catalogue; `name` is its name in the model.
    log_z : float
        Log evidence as models are compared: of the model as it is, or beside a free-form map of what it leaves.
    own_part : mapping of channel to float
        What the law changes that the base's laws could not; see `hypothesis.own_part`.
    whole_part : mapping of channel to float
        All that it changes.
    log_prior_bend : float
        Log probability that a law of the base is unlike the sensor's in just this way, so that nothing is missing.
    without : Entry, optional
        All else that was put in, at its best, where that is anything.
    """

    mechanism: str
    law: str
    name: str
    hypothesis: Hypothesis
    log_z: float
    is_settled: bool = False
    own_part: Mapping[str, float] = field(default_factory=dict)
    whole_part: Mapping[str, float] = field(default_factory=dict)
    log_prior_bend: float = -np.inf
    without: Entry | None = None

    @classmethod
    def bare(cls, h: Hypothesis) -> Entry:
        """A model that no law was put into."""
        return cls("", "", "", h, h.log_z)

    def refitted(self, h: Hypothesis, is_settled: bool = False) -> Entry:
        """The same law in a model that was fitted again."""
        return replace(self, hypothesis=h, log_z=h.log_z, is_settled=is_settled)

    @property
    def base(self) -> KnitModel:
        """The model without the law."""
        return self.hypothesis.model.without(self.name)


@dataclass(frozen=True)
class Whole:
    """All that was put in from one round on, together.

    Attributes
    ----------
    log_posterior : float
        Log prior and evidence, nothing else missing.
    log_z : float
        Log evidence, whatever it leaves.
    log_prior_alike : float
        Log prior of these laws among those of the catalogue.
    left : float
        Share of what they should explain that they leave, of the channels that they change.
    first : str
        The mechanism that was put in first.
    first_adds : float, optional
        Log evidence that it adds beside the others, if there are any.
    """

    log_posterior: float
    log_z: float
    log_prior_alike: float
    left: float
    first: str
    first_adds: float | None
