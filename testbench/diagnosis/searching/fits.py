"""Fits models to one measurement, all on the grid and with the noise with which they are compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

from testbench.comparing.ladder import drawn_to_data
from testbench.comparing.model_errors import log_error
from testbench.diagnosis.judging.ranking import evidence_of
from testbench.diagnosis.searching.side_by_side import SideBySide
from testbench.fitting import constants
from testbench.fitting.baseline import (
    SHAPES,
    framed,
    kinds_of_conduction,
    starting_baseline,
    with_shapes,
    with_zeros,
    without_shapes,
)
from testbench.fitting.evidence.coloured_noise import with_colour
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.independent_samples import on_the_grid, telling
from testbench.fitting.evidence.jitter import jitter_of
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.likelihood import Likelihood, law_error_of
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

Progress = Callable[[str], None]
BENDING_STEPS = 16  # of the first fits of a base that bends: all its shapes start from nothing
QUICK_STEPS = 6  # of a fit that only shows whether it is worth a longer one


class Fits:
    """The likelihood of one measurement, and models at their best under it.

    Attributes
    ----------
    measurement : Measurement
        On the grid of the comparison; only samples that say something new count.
    start : KnitModel
        The base as it was started from the data.
    kinds : list of KnitModel
        The same with each kind of conduction that the data leave open, its own first.
    reference : KnitModel
        All their laws: what parameters of a base are believed near.
    likelihood : Likelihood
        For the last fit of a model.
    compared : Likelihood
        As models are compared.
    baseline, flexible : Hypothesis
        The user's model, and the same with base laws that bend.
    """

    def __init__(
        self,
        measurement: Measurement,
        catalogue: Catalogue,
        tell: Progress,
        start: KnitModel | None = None,
        pieces: float = constants.INDEPENDENT,
    ):
        self.catalogue, self.tell, self.pieces = catalogue, tell, pieces
        self.pool = SideBySide([*catalogue.effects.values(), *map(type, start.effects.values() if start else ())])
        self.whole, self.noise = measurement, noise_of(measurement)
        self.measurement = telling(on_the_grid(measurement))
        tell("fitting the baseline")
        start = with_zeros(start or starting_baseline(self.measurement, catalogue), self.measurement, catalogue)
        self.start = without_shapes(start)
        self.kinds = kinds_of_conduction(self.start, self.measurement, catalogue)
        self.reference = KnitModel({name: one[name] for one in reversed(self.kinds) for name in one})
        tell("fitting the shape of the base laws")
        flexible = with_shapes(self.start, self.measurement, catalogue, like=start)
        without_jitter = likelihood_of(self.start, self.measurement, self.noise)
        first = fitted(flexible, without_jitter, self.reference, iterations=BENDING_STEPS)
        models = (self.start, first.model)
        self.jitter_s = jitter_of(models, measurement)
        self.noise = with_colour(self.noise, models, on_the_grid(measurement))
        self.likelihood = self.likelihood_on(self.measurement)
        self.flexible = fitted(first.model, self.likelihood, self.reference, first, BENDING_STEPS)
        # What the user has is the model as given; where its laws bend already, so does what it is compared with.
        given = any(name in SHAPES for name in start)
        self.baseline = self.flexible if given else fitted(self.start, self.likelihood, self.reference)
        law_error = law_error_of(self.flexible.model, self.likelihood)
        self.compared = self.likelihood.with_law_error(law_error).in_pieces

    def compare(self, model: KnitModel, like: Hypothesis | None = None) -> Hypothesis:
        """A model fitted as models are compared; one that was already is never left worse than it was."""
        found = fitted(model, self.compared, self.reference, like)
        if like is None or like.model != model or not like.counts_as(self.compared):
            return found
        return max(found, like, key=evidence_of)

    def quickly(
        self, model: KnitModel, like: Hypothesis, known_priors: Mapping[str, tuple[float, float]] | None = None
    ) -> Hypothesis:
        """A model fitted in a few steps, with the sensitivities of a neighbour; see `fitted`."""
        return fitted(model, self.compared, self.reference, like, QUICK_STEPS, quick=True, known_priors=known_priors)

    def at_rest(self, h: Hypothesis) -> Hypothesis:
        """A model fitted in full, refitted until nothing is gained; at first with shapes as free as without data.

        Shapes that were fitted beside another law hold what is in the way of this one.
        """
        best, better = h, max(fitted(h.model, self.compared, self.reference, h.as_before_data), h, key=evidence_of)
        for _ in range(constants.REFITS):
            if better.log_z < best.log_z + constants.EVIDENCE_ERROR:
                break
            best, better = better, self.compare(better.model, better)
        return better

    def without(self, h: Hypothesis, name: str) -> Hypothesis:
        """A model without one of its effects, refitted."""
        return self.at_rest(self.compare(h.model.without(name), h))

    def bent(self, model: KnitModel) -> KnitModel:
        """A model with base laws that may bend, but do not yet."""
        return with_shapes(model, self.measurement, self.catalogue)

    def about_to_bend(self, h: Hypothesis) -> Hypothesis:
        """A base as it is, its shapes there to be used.

        Where a base has bent to take an effect in, its other parameters have moved along; here they have not.
        """
        return fitted(self.bent(h.model), self.compared, self.reference, iterations=0)

    def started_like(self, other: Effect, law: type[Effect], model: KnitModel) -> Effect:
        """A law that starts as another of its kind in what they share, and is drawn to the data in the rest."""
        return framed(drawn_to_data(like_another(other, law), self.measurement), model, self.measurement)

    def sharp(self, chosen: Sequence[Hypothesis]) -> list[Hypothesis]:
        """The last fits of models that were chosen."""
        finest = self.finest

        def last(h: Hypothesis) -> Hypothesis:
            return fitted(self.unfolded(h.model), finest, self.reference, h if finest is self.likelihood else None)

        return self.pool.map(last, chosen)

    def unfolded(self, model: KnitModel) -> KnitModel:
        """The model with frequencies as the whole recording has them: the grid of the search may have folded them."""
        for name, effect in model.effects.items():
            others = effect.unfolded(1 / self.measurement.dt_s, 0.5 / self.whole.dt_s)
            models = [model, *(model.replacing(name, one) for one in others)]
            if others:
                model = min(models, key=lambda one: log_error(one, self.whole, free_offset=True))
        return model

    @cached_property
    def finest(self) -> Likelihood:
        """For last fits: a recording of hours was searched on a coarse grid."""
        finer = telling(on_the_grid(self.whole, constants.FINER))
        if finer.dt_s == self.measurement.dt_s:
            return self.likelihood
        return self.likelihood_on(finer)

    def likelihood_on(self, measurement: Measurement) -> Likelihood:
        """How the samples of a grid count."""
        return likelihood_of(self.start, measurement, self.noise, self.jitter_s, self.pieces)


def like_another(other: Effect, law: type[Effect]) -> Effect:
    """A law with the parameters that it shares with another."""
    return law().near(**{key: getattr(other, key) for key in law.model_fields if key in type(other).model_fields})


def law_names(effects: Mapping[str, Effect]) -> tuple[str, ...]:
    """Which laws stand in the places of a model."""
    return tuple(effect.name for effect in effects.values())


def newest(model: KnitModel, before: KnitModel) -> str:
    """Name of the effect that a model has, and the one before it has not."""
    return next(name for name in model if name not in before)
