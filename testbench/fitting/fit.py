"""Bounded, weighted, robust least squares of a knit model on force and log-conductance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gcode.support.errors import UserError
from testbench.fitting.downhill import Linearised, huber, huber_weight, minimised
from testbench.fitting.parameters import FreeParameter, free_parameters, values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import noise_floor, spread
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

MAX_ITERATIONS = 25
# Residuals are autocorrelated: what this time spans is worth one independent sample. Weakens the data against the
# priors and widens the standard errors; measured on residuals of simulated and real recordings it is 0.5 to 3 s.
INDEPENDENT_S = 0.8
SMALL_GAIN = 1e-4


@dataclass(frozen=True)
class Fit:
    """A fitted model and what is known about its parameters.

    Attributes
    ----------
    model : KnitModel
    parameters : tuple of FreeParameter
    vector : ndarray, shape (p,)
        Fitted coordinates.
    covariance : ndarray, shape (p, p)
        Of the coordinates, with the autocorrelation of the residual allowed for.
    scale : dict of channel to float
        Robust standard deviation of the residual.
    iterations : int
    """

    model: KnitModel
    parameters: tuple[FreeParameter, ...]
    vector: FloatArray
    covariance: FloatArray
    scale: Mapping[str, float]
    iterations: int

    @property
    def standard_errors(self) -> FloatArray:
        """Of the fit's coordinates (relative errors for log parameters), shape (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def at_bound(self) -> list[str]:
        """Addresses of parameters that ended on a bound."""
        return [
            p.address
            for p, x in zip(self.parameters, self.vector, strict=True)
            if np.isclose(x, p.to_fit(p.low), atol=1e-6) or np.isclose(x, p.to_fit(p.high), atol=1e-6)
        ]

    def unidentified(self) -> list[str]:
        """Addresses of parameters about which this recording says nearly nothing beyond the prior."""
        known = self.standard_errors < 0.7 * np.array([p.width for p in self.parameters])
        return [p.address for p, ok in zip(self.parameters, known, strict=True) if not ok]

    def correlated(self, limit: float = 0.98) -> list[tuple[str, str, float]]:
        """Pairs that this recording can hardly tell apart, with their correlation."""
        errors = np.maximum(self.standard_errors, 1e-150)  # their products must not vanish
        correlation = self.covariance / np.outer(errors, errors)
        rows, columns = np.nonzero(np.triu(np.abs(correlation) > limit, 1))
        names = [p.address for p in self.parameters]
        return [(names[i], names[j], float(correlation[i, j])) for i, j in zip(rows, columns, strict=True)]


def independent_share(measurement: Measurement) -> float:
    """Independent samples per sample of the grid: a finer grid adds samples, not knowledge."""
    return min(1.0, measurement.dt_s / INDEPENDENT_S)


def prior_ridge(parameters: Sequence[FreeParameter], measurement: Measurement) -> FloatArray:
    """Precision of the priors, shape (p,), beside sums in which neighbours count as if they were independent."""
    return np.array([p.width for p in parameters]) ** -2.0 / independent_share(measurement)


def shape_scales(measurement: Measurement) -> dict[str, float]:
    """Typical size of a correction, by unit: a tenth of the force's range, 0.3 in ln G."""
    scales = {"1": 0.3, "1/ks": 0.1, "N": 1.0}
    if FORCE_CHANNEL in measurement.measured:
        scales["N"] = 0.1 * float(np.ptp(measurement.measured[FORCE_CHANNEL]))
    if CONDUCTANCE_CHANNEL in measurement.measured:
        scales["1"] = max(0.1 * float(np.ptp(measurement.measured[CONDUCTANCE_CHANNEL])), 0.02)
    return scales


def fit(
    model: KnitModel,
    measurement: Measurement,
    max_iterations: int = MAX_ITERATIONS,
    progress: Callable[[str], None] | None = None,
    addresses: Callable[[str], bool] = lambda address: True,
) -> Fit:
    """Fit the free parameters of `model` to a measurement.

    Levenberg-Marquardt on the normal equations (Marquardt, J. SIAM 11 (1963) 431), projected on the bounds, with
    Huber weights (Huber, Robust Statistics (1981), ch. 7) and weak Gaussian priors that keep what the data cannot
    tell near its start. Channels are weighted by their residual's own robust spread, so neither dominates.

    Parameters
    ----------
    model : KnitModel
        Start of the search.
    measurement : Measurement
    progress : callable, optional
        Called with a short text after each iteration.
    addresses : callable, optional
        Whether to fit the parameter of this address (``effect.parameter``); default all.

    Raises
    ------
    UserError
        If the model gives NaN on these data.
    """
    parameters = [p for p in free_parameters(model, shape_scales(measurement)) if addresses(p.address)]
    problem = _Problem(model, parameters, measurement, progress)
    x, here, iterations = minimised(problem, values_of(model, parameters), max_iterations, SMALL_GAIN)
    covariance = np.linalg.pinv(here.matrix, hermitian=True)
    return Fit(problem.model(x), tuple(parameters), x, covariance, problem.scale, iterations)


class _Problem:
    """Residuals, cost and normal equations."""

    def __init__(
        self,
        start: KnitModel,
        parameters: Sequence[FreeParameter],
        measurement: Measurement,
        progress: Callable[[str], None] | None,
    ) -> None:
        self.start, self.parameters, self.measurement = start, parameters, measurement
        self.progress, self.tried, self.cache = progress, 0, SimulationCache()
        self.scale: dict[str, float] = {}
        self.share = independent_share(measurement)
        self.low = np.array([p.to_fit(p.low) for p in parameters])
        self.high = np.array([p.to_fit(p.high) for p in parameters])
        self.centre = np.array([p.centre for p in parameters])
        self.precision = np.array([p.width for p in parameters]) ** -2.0
        self.floor = {c: noise_floor(values[measurement.counts]) for c, values in measurement.measured.items()}

    def model(self, x: FloatArray) -> KnitModel:
        return with_values(self.start, self.parameters, x)

    def cost(self, x: FloatArray) -> float:
        model = self.model(x)
        total = self._cost(model, self.residual(model))
        self.tried += 1
        if self.progress:
            self.progress(f"iteration {self.tried}: cost {total:.4g}")
        return total

    def residual(self, model: KnitModel) -> dict[str, FloatArray]:
        left = self.measurement.residual(model, self.cache)
        return {c: values[self.measurement.counts] for c, values in left.items()}

    def _cost(self, model: KnitModel, left: Mapping[str, FloatArray]) -> float:
        moved = values_of(model, self.parameters) - self.centre
        misfit = sum(float(huber(np.abs(values) / self.scale[c]).sum()) for c, values in left.items())
        total = 0.5 * float(np.sum(self.precision * moved**2)) + misfit * self.share
        return total if np.isfinite(total) else np.inf

    def linearised(self, x: FloatArray) -> Linearised:
        model = self.model(x)
        left = self.residual(model)
        self.scale = {c: max(spread(values), self.floor[c], 1e-12) for c, values in left.items()}
        matrix, gradient = np.diag(self.precision), -self.precision * (x - self.centre)
        _, jacobian = sensitivities(model, self.parameters, self.measurement, self.cache)
        for channel, values in left.items():
            residual = values / self.scale[channel]
            root = np.sqrt(huber_weight(np.abs(residual)) * self.share)
            columns = jacobian[channel][:, self.measurement.counts] * (root / self.scale[channel])
            matrix = matrix + columns @ columns.T  # of an array with itself: half the work
            gradient = gradient + columns @ (root * residual)
        if not np.all(np.isfinite(matrix)):
            raise UserError(f"the model ({', '.join(model)}) gives NaN on {self.measurement.recording.source}")
        return Linearised(matrix, gradient, self._cost(model, left))
