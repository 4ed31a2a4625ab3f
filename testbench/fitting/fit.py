"""A model at its best on a measurement, and what is known about its parameters there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.support.errors import UserError
from testbench.fitting import constants
from testbench.fitting.evidence.hypothesis import Hypothesis
from testbench.fitting.evidence.independent_samples import telling
from testbench.fitting.evidence.laplace import fitted
from testbench.fitting.evidence.sample_noise import likelihood_of, noise_of
from testbench.fitting.parameters import FreeParameters
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement

ON_IT = 1e-7  # of a parameter's weak width: nearer than that to a bound it is on it
LEARNT = 0.7  # of the standard deviation before the data: what is known less well is not identified
ALIKE = 0.98  # correlation beyond which a recording can hardly tell two parameters apart


@dataclass(frozen=True)
class Fit:
    """A fitted model and what is known about its parameters.

    Attributes
    ----------
    model : KnitModel
    parameters : FreeParameters
    vector : ndarray, shape (p,)
        Fitted coordinates.
    covariance : ndarray, shape (p, p)
        Of the coordinates. The errors of a model go on for longer than those of a sample: one sample in 1.6 s counts,
        and no more than in about 6 min, however long the recording is.
    prior_sd : ndarray, shape (p,)
        Standard deviations of the coordinates before the data.
    scale : dict of channel to float
        Robust standard deviation of the residual.
    """

    model: KnitModel
    parameters: FreeParameters
    vector: FloatArray
    covariance: FloatArray
    prior_sd: FloatArray
    scale: Mapping[str, float]

    @classmethod
    def of(cls, h: Hypothesis, model: KnitModel | None = None) -> Fit:
        """The fit of a hypothesis; of those of its effects that `model` has, if given."""
        model = model or h.model
        kept = np.array([i for i, p in enumerate(h.priors.parameters) if p.place[0] in model], int)
        parameters = FreeParameters(h.priors.parameters[i] for i in kept)
        prior_sd = h.priors.scaled(h.evidence.scale)[kept] ** -0.5
        return cls(
            model, parameters, h.vector[kept], h.covariance[np.ix_(kept, kept)], prior_sd, dict(h.evidence.sigma)
        )

    @property
    def standard_errors(self) -> FloatArray:
        """Of the fit's coordinates (relative errors for log parameters), shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def at_bound(self) -> list[str]:
        """Addresses of parameters that ended on a bound."""
        near = ON_IT * np.array([p.width for p in self.parameters])
        at_low, at_high = self.vector - self.parameters.low <= near, self.parameters.high - self.vector <= near
        return [p.address for p, on_it in zip(self.parameters, at_low | at_high, strict=True) if on_it]

    def unidentified(self) -> list[str]:
        """Addresses of parameters about which this recording says nearly nothing beyond the prior."""
        known = self.standard_errors < LEARNT * self.prior_sd
        return [p.address for p, ok in zip(self.parameters, known, strict=True) if not ok]

    def correlated(self) -> list[tuple[str, str, float]]:
        """Pairs that this recording can hardly tell apart, with their correlation."""
        errors = np.maximum(self.standard_errors, 1e-150)  # their products must not vanish
        correlation = self.covariance / np.outer(errors, errors)
        rows, columns = np.nonzero(np.triu(np.abs(correlation) > ALIKE, 1))
        names = [p.address for p in self.parameters]
        return [(names[i], names[j], float(correlation[i, j])) for i, j in zip(rows, columns, strict=True)]

    def summary(self) -> dict[str, Any]:
        """JSON-ready parameters with standard errors, and plain lists of what cannot be trusted."""
        parameters = {}
        for p, x, error in zip(self.parameters, self.vector, self.standard_errors, strict=True):
            value = p.to_physical(x)
            wide = float(error * (value if p.log else 1))
            parameters[p.address] = {"value": value, "unit": p.unit, "standard_error": wide}
        return {
            "parameters": parameters,
            "at_bound": self.at_bound(),
            "unidentified": self.unidentified(),
            "correlated": [list(pair) for pair in self.correlated()],
            "residual_scale": dict(self.scale),
        }


def fit(
    model: KnitModel,
    measurement: Measurement,
    iterations: int = constants.ITERATIONS,
    progress: Callable[[str], None] | None = None,
    free: Callable[[str], bool] = lambda address: True,
) -> Fit:
    """Fit the free parameters of `model` to a measurement, as the models of a diagnosis are (`fitted`).

    Parameters
    ----------
    model : KnitModel
        Start of the search; parameters of its base laws are believed near it, within wide limits.
    measurement : Measurement
    iterations : int
        At most.
    progress : callable, optional
        Called with a short text after each iteration.
    free : callable, optional
        Whether to fit the parameter of this address (``effect.parameter``); default all.

    Raises
    ------
    UserError
        If the model gives NaN on these data.
    """
    if not all(np.all(np.isfinite(values)) for values in measurement.modelled(model).values()):
        raise UserError(f"the model ({', '.join(model)}) gives NaN on {measurement.recording.source}")
    base = KnitModel({name: effect for name, effect in model.effects.items() if effect.in_base})
    likelihood = likelihood_of(model, telling(measurement), noise_of(measurement))
    return Fit.of(fitted(model, likelihood, base, iterations=iterations, progress=progress, free=free))
