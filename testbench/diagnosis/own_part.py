"""What an effect changes that the rest of its model could not have changed as well.

The model without the effect is drawn to what the model with it says. Its shapes may do what is believed of them in
this model, in which most are switched off; they are linear, and eliminated. The base laws go further than their
tangents.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from testbench.diagnosis.hypothesis import Hypothesis
from testbench.diagnosis.likelihood import Likelihood
from testbench.fitting.baseline import SHAPES, without_shapes
from testbench.fitting.downhill import Linearised, minimised
from testbench.fitting.noise_level import trimmed_rms
from testbench.fitting.parameters import values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel

STEPS, SMALL_GAIN = 20, 0.02  # at most; share of what is left that a step must gain


def own_part(h: Hypothesis, name: str, likelihood: Likelihood, before: Hypothesis | None = None) -> dict[str, float]:
    """Standard deviation of it, over the relative noise of the samples that count, per channel, in N and ln S.

    Parameters
    ----------
    before : Hypothesis, optional
        The best model without the effect: its base laws, which may be others, are asked as well.
    """
    others = [(h.model.without(name), h)]
    if before is not None:
        others.append((without_shapes(before.model), before))
    left = [_Imitation(h, likelihood, model, whose).found() for model, whose in others]
    return min(left, key=lambda one: sum((size / likelihood.floor[c]) ** 2 for c, size in one.items()))


class _Imitation:
    """Least squares of what a model with an effect says less what one without it says.

    Parameters
    ----------
    h : Hypothesis
        With the effect.
    bare : KnitModel
        Without it.
    whose : Hypothesis
        What is believed of the parameters of `bare`.

    Attributes
    ----------
    low, high : ndarray, shape (p,)
        Bounds of the base laws' parameters.
    """

    def __init__(self, h: Hypothesis, likelihood: Likelihood, bare: KnitModel, whose: Hypothesis) -> None:
        self.likelihood, self.cache, self.bare = likelihood, SimulationCache(), bare
        self.noise = {c: sigma / np.sqrt(likelihood.share) for c, sigma in h.evidence.sigma.items()}
        self.target = self.stacked(likelihood.measurement.modelled(h.model, self.cache))
        base = [i for i, one in enumerate(_owners(whose)) if whose.held[i] and one in bare]
        self.parameters = [whose.priors.parameters[i] for i in base]
        self.precision = whose.priors.scaled(whose.evidence.scale)[base]
        self.low, self.high = (np.array([p.to_fit(getattr(p, e)) for p in self.parameters]) for e in ("low", "high"))
        weights = np.array([i for i, one in enumerate(_owners(h)) if one in SHAPES], int)
        self.shapes = self.stacked_rows({c: rows[weights + 1] for c, rows in h.columns.items()})
        believed = h.priors.scaled(h.evidence.scale)[weights]
        self.inverse = np.linalg.inv(self.shapes @ self.shapes.T + np.diag(believed))

    def found(self) -> dict[str, float]:
        """What cannot be imitated, per channel."""
        x = values_of(self.bare, self.parameters)
        if len(x):
            x, _, _ = minimised(self, x, STEPS, SMALL_GAIN)
        parts = np.split(self.beside_shapes(self.off(x)), len(self.noise))
        return {c: trimmed_rms(part * noise) for part, (c, noise) in zip(parts, self.noise.items(), strict=True)}

    def cost(self, x: FloatArray) -> float:
        off = self.off(x)
        return 0.5 * float(off @ self.beside_shapes(off))

    def linearised(self, x: FloatArray) -> Linearised:
        modelled, columns = sensitivities(
            with_values(self.bare, self.parameters, x), self.parameters, self.likelihood.measurement, self.cache
        )
        laws = self.stacked_rows({c: self.likelihood.picked(rows, c) for c, rows in columns.items()})
        off = self.target - self.stacked(modelled)
        left = self.beside_shapes(off)
        matrix = laws @ self.beside_shapes(laws.T) + np.diag(self.precision)
        return Linearised(matrix, laws @ left, 0.5 * float(off @ left))

    def off(self, x: FloatArray) -> FloatArray:
        """What the base laws leave of the target, shape (channels * k,)."""
        model = with_values(self.bare, self.parameters, x)
        return self.target - self.stacked(self.likelihood.measurement.modelled(model, self.cache))

    def beside_shapes(self, off: FloatArray) -> FloatArray:
        """What is left beside the likeliest weights of the shapes, shape of `off`."""
        return off - self.shapes.T @ (self.inverse @ (self.shapes @ off))

    def stacked(self, signals: Mapping[str, FloatArray]) -> FloatArray:
        """The samples that enter, of every channel over its noise, shape (channels * k,)."""
        return np.concatenate([self.likelihood.picked(signals[c], c) / noise for c, noise in self.noise.items()])

    def stacked_rows(self, rows: Mapping[str, FloatArray]) -> FloatArray:
        """Sensitivities at these samples, of every channel over its noise, shape (p, channels * k)."""
        return np.hstack([rows[c] / noise for c, noise in self.noise.items()])


def _owners(h: Hypothesis) -> list[str]:
    """The effect that each parameter belongs to."""
    return [p.address.partition(".")[0] for p in h.priors.parameters]
