"""Elastic laws of a few numbers, drawn to the curve that the base's free shape found.

For its shape freedom any smooth curve will do as a base law, also one that an effect has bent. What tells them apart
is how few numbers are needed: if one of the laws of the field follows the curve, nothing is missing; if none does,
but one of them with the effect beside it does, the effect is there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from testbench.discrepancy.candidates import expand
from testbench.discrepancy.errors import noise_floors
from testbench.discrepancy.measurement import FORCE_CHANNEL, Measurement
from testbench.discrepancy.parameters import free_parameters, values_of, with_values
from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, FloatArray
from testbench.knit.elasticity import ElasticLaw
from testbench.knit.model import KnitModel

POINTS = 200  # of the curve
OUTERMOST = 5e-4  # share of the samples at either end that the curve leaves out
STARTS_OF_ONE_LAW, POLISHED, POLISHING = 3, 9, 30  # starts that are polished, and steps of that
WORTH_A_TRY = 0.1  # ln(squared misfit and noise) that an effect must gain
ELASTICITY = "elasticity"  # the place of the law in a model


@dataclass(frozen=True)
class Curve:
    """Elastic force over strain, and how much of the recording was spent at each strain.

    Attributes
    ----------
    strain, force_N, weight : ndarray, shape (n,)
    """

    strain: FloatArray
    force_N: FloatArray
    weight: FloatArray


@dataclass(frozen=True)
class Drawn:
    """A law drawn to a curve, alone or with an effect beside it, and the RMS of what it misses."""

    law: ElasticLaw
    effect: Effect | None
    misfit_N: float

    def put_in(self, model: KnitModel) -> KnitModel:
        """`model` with this law in the place of its own, and the effect."""
        model = model.replacing(ELASTICITY, self.law)
        return model if self.effect is None else model.plus(self.effect)


@dataclass(frozen=True)
class DrawnLaws:
    """The law that does best alone, and the one that does best with an effect beside it, if any."""

    alone: Drawn
    beside: Drawn | None
    noise_N: float

    @property
    def follows(self) -> bool:
        """Whether the law by itself follows the curve so closely that no effect could gain enough."""
        return self._gained(0.0) < WORTH_A_TRY

    @property
    def tell_apart(self) -> bool:
        """Whether with the effect the misfit is less, counted with the noise."""
        return self.beside is not None and self._gained(self.beside.misfit_N) > WORTH_A_TRY

    def _gained(self, misfit_N: float) -> float:
        """ln(squared misfit of the law alone / this misfit squared), both counted with the noise."""
        return 2 * float(np.log(np.hypot(self.noise_N, self.alone.misfit_N) / np.hypot(self.noise_N, misfit_N)))


def draw_laws(model: KnitModel, measurement: Measurement, catalogue: Catalogue, forms: Sequence[Effect]) -> DrawnLaws:
    """Draw every elastic law of the catalogue to the elastic curve of `model`, alone and with each of `forms` beside.

    Parameters
    ----------
    model : KnitModel
        With shape freedom, fitted to `measurement`.
    measurement : Measurement
        With force.
    catalogue : Catalogue
        A user's own laws take part.
    forms : sequence of Effect
        That add to the force in proportion to their strength, by strain alone.
    """
    curve = elastic_curve(model, measurement)
    laws = [law() for law in catalogue.effects.values() if issubclass(law, ElasticLaw)]
    alone = DrawnLaws(best_law(curve, laws), None, noise_floors(measurement)[FORCE_CHANNEL])
    if alone.follows:
        return alone
    state, residual = model.simulate(measurement.signals, measurement.dt_s), measurement.residual(model)
    points = expand([type(form) for form in forms], "", model, measurement, state, residual)
    return replace(alone, beside=best_law_beside(curve, laws, [point.effect for point in points]))


def elastic_curve(model: KnitModel, measurement: Measurement) -> Curve:
    """What `model` holds for the elastic law: its law and the shape freedom of that, over the strains seen."""
    strain = measurement.signals["strain"][measurement.counts]
    low, high = np.quantile(strain, [OUTERMOST, 1 - OUTERMOST])
    edges = np.linspace(low, high, POINTS + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    laws = KnitModel({name: model[name] for name in (ELASTICITY, "elasticity_shape") if name in model})
    force_N = laws.simulate({"strain": middle, "time_s": middle}, measurement.dt_s)["force_N"]
    return Curve(middle, force_N, np.histogram(strain, edges)[0].astype(np.float64))


def best_law(curve: Curve, laws: Iterable[ElasticLaw]) -> Drawn:
    """The law that follows the curve best by itself."""
    drawn = [law.drawn_to(curve.strain, curve.force_N, curve.weight) for law in laws]
    return _closest((Drawn(law, None, misfit_N) for law, _, misfit_N in drawn), curve)


def best_law_beside(curve: Curve, laws: Iterable[ElasticLaw], starts: Sequence[Effect]) -> Drawn | None:
    """The law and the effect that follow the curve best together; None if no effect helps any of them.

    The starts are forms in proportion to their strength, at several points of their other parameters.
    """
    added_N = [_at_strength_one(effect, curve.strain) for effect in starts]
    found = []
    for law in laws:
        tried = (law.drawn_to(curve.strain, curve.force_N, curve.weight, curve_N) for curve_N in added_N)
        drawn = [
            Drawn(one, effect.near(**{effect.strength: strength}), misfit_N)
            for effect, (one, strength, misfit_N) in zip(starts, tried, strict=True)
            if strength > 0
        ]
        found += sorted(drawn, key=lambda one: one.misfit_N)[:STARTS_OF_ONE_LAW]
    return _closest(found, curve) if found else None


def bends_the_law(form: Effect) -> bool:
    """Whether the effect can be drawn beside a law: it adds a curve over strain, times its strength, to the force."""
    if form.imitated_by != ELASTICITY or form.nonlinear or not {"strain", "force_N"}.issuperset(form.reads):
        return False
    return bool(np.any(_at_strength_one(form, np.linspace(0.0, 1.0, POINTS))))


def _at_strength_one(effect: Effect, strain: FloatArray) -> FloatArray:
    """What the effect adds to no force at all, for each unit of its strength, shape (n,)."""
    nothing = {"strain": strain, "time_s": strain, "force_N": np.zeros_like(strain)}
    unit = effect.near(**{effect.strength: 1.0})
    return KnitModel.of(unit).simulate(nothing, 1.0)["force_N"] / getattr(unit, unit.strength)


def _closest(drawn: Iterable[Drawn], curve: Curve) -> Drawn:
    nearest = sorted(drawn, key=lambda one: one.misfit_N)[:POLISHED]
    return min((_polished(one, curve) for one in nearest), key=lambda one: one.misfit_N)


def _polished(drawn: Drawn, curve: Curve) -> Drawn:
    """Law and effect with all of their parameters moved to follow the curve as closely as they can."""
    model = KnitModel.of(drawn.law, *(() if drawn.effect is None else (drawn.effect,)))
    parameters = free_parameters(model, {})
    signals = {"strain": curve.strain, "time_s": curve.strain}
    low, high = (np.array([p.to_fit(getattr(p, end)) for p in parameters]) for end in ("low", "high"))

    def missed(x: FloatArray) -> FloatArray:
        force_N = with_values(model, parameters, x).simulate(signals, 1.0)["force_N"]
        return np.sqrt(curve.weight / curve.weight.sum()) * (curve.force_N - force_N)

    start = np.clip(values_of(model, parameters), low, high)
    found = least_squares(missed, start, bounds=(low, high), x_scale="jac", max_nfev=POLISHING)
    moved = with_values(model, parameters, found.x)
    law, *effects = (moved[name] for name in moved)
    assert isinstance(law, ElasticLaw)
    return Drawn(law, effects[0] if effects else None, float(np.sqrt(2 * found.cost)))
