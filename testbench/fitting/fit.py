"""Bounded, weighted, robust least squares of a knit model on force and log-conductance."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gcode.support.errors import UserError
from testbench.fitting.measurement import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, Measurement
from testbench.fitting.noise import noise_floor, spread
from testbench.fitting.parameters import FreeParameter, free_parameters, values_of, with_values
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, SimulationCache

MAX_ITERATIONS = 25
# Residuals are autocorrelated: what this time spans is worth one independent sample. Weakens the data against the
# priors and widens the standard errors; measured on residuals of simulated and real recordings it is 0.5 to 3 s.
INDEPENDENT_S = 0.8
HUBER_LIMIT = 3.0
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
        errors = np.maximum(self.standard_errors, 1e-300)
        correlation = self.covariance / np.outer(errors, errors)
        rows, columns = np.nonzero(np.triu(np.abs(correlation) > limit, 1))
        names = [p.address for p in self.parameters]
        return [(names[i], names[j], float(correlation[i, j])) for i, j in zip(rows, columns, strict=True)]


def independent_share(measurement: Measurement) -> float:
    """Independent samples per sample of the grid: a finer grid adds samples, not knowledge."""
    return min(1.0, measurement.dt_s / INDEPENDENT_S)


def prior_ridge(parameters: Sequence[FreeParameter], measurement: Measurement) -> FloatArray:
    """Precision of the priors, shape (p,), where every sample counts: more where samples repeat each other."""
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
    measurements: Sequence[Measurement],
    only: Iterable[str] | None = None,
    max_iterations: int = MAX_ITERATIONS,
    progress: Callable[[str], None] | None = None,
    addresses: Callable[[str], bool] | None = None,
    scale_by: Callable[[FloatArray], float] = spread,
) -> Fit:
    """Fit the free parameters of `model` to one or several measurements at once.

    Levenberg-Marquardt on the normal equations (Marquardt, J. SIAM 11 (1963) 431), projected on the bounds, with
    Huber weights (Huber, Robust Statistics (1981), ch. 7) and weak Gaussian priors that keep what the data cannot
    tell near its start. Channels are weighted by their residual's own robust spread, so neither dominates.

    Parameters
    ----------
    model : KnitModel
        Start of the search.
    measurements : sequence of Measurement
    only : iterable of str, optional
        Effects to fit; the others stay as they are.
    progress : callable, optional
        Called with a short text after each iteration.
    addresses : callable, optional
        Whether to fit the parameter of this address (``effect.parameter``); default all.
    scale_by : callable, optional
        What a channel's residuals are measured by: `spread`, or `robust_sd`, under which what is rare hardly counts.

    Raises
    ------
    UserError
        If the model gives NaN on these data.
    """
    parameters = free_parameters(model, shape_scales(measurements[0]), only)
    if addresses is not None:
        parameters = [p for p in parameters if addresses(p.address)]
    problem = _Problem(parameters, measurements, scale_by)
    x = values_of(model, parameters)
    scale = problem.scale_of(model)
    damping, iterations = 1e-3, 0
    normal = problem.linearise(model, x, scale)
    for iterations in range(1, max_iterations + 1):
        step = _projected_step(normal, x, problem, damping)
        trial = with_values(model, parameters, x + step)
        cost = problem.cost(trial, scale)
        if progress:
            progress(f"iteration {iterations}: cost {cost:.4g}")
        if cost < normal.cost:
            gain = (normal.cost - cost) / normal.cost
            model, x, damping = trial, values_of(trial, parameters), max(damping / 5, 1e-8)
            scale = problem.scale_of(model)
            normal = problem.linearise(model, x, scale)
            if gain < SMALL_GAIN:
                break
        else:
            damping *= 8
            if damping > 1e6:
                break
    covariance = np.linalg.pinv(normal.matrix, hermitian=True)
    return Fit(model, tuple(parameters), x, covariance, scale, iterations)


@dataclass(frozen=True)
class _Normal:
    matrix: FloatArray
    gradient: FloatArray
    cost: float


class _Problem:
    """Residuals, cost and normal equations over all measurements."""

    def __init__(
        self,
        parameters: Sequence[FreeParameter],
        measurements: Sequence[Measurement],
        scale_by: Callable[[FloatArray], float],
    ) -> None:
        self.parameters, self.measurements, self.scale_by = parameters, measurements, scale_by
        self.caches = [SimulationCache() for _ in measurements]
        self.low = np.array([p.to_fit(p.low) for p in parameters])
        self.high = np.array([p.to_fit(p.high) for p in parameters])
        self.centre = np.array([p.centre for p in parameters])
        self.precision = np.array([p.width for p in parameters]) ** -2.0
        self.floor = {
            channel: noise_floor(values[measurements[0].counts])
            for channel, values in measurements[0].measured.items()
        }

    def scale_of(self, model: KnitModel) -> dict[str, float]:
        residuals: dict[str, list[FloatArray]] = {}
        for measurement, cache in zip(self.measurements, self.caches, strict=True):
            for channel, values in measurement.residual(model, cache).items():
                residuals.setdefault(channel, []).append(values[measurement.counts])
        return {c: max(self.scale_by(np.concatenate(r)), self.floor[c], 1e-12) for c, r in residuals.items()}

    def cost(self, model: KnitModel, scale: Mapping[str, float]) -> float:
        total = self._prior_cost(values_of(model, self.parameters))
        for measurement, cache in zip(self.measurements, self.caches, strict=True):
            for channel, values in measurement.residual(model, cache).items():
                z = np.abs(values[measurement.counts]) / scale[channel]
                huber = np.where(z < HUBER_LIMIT, 0.5 * z * z, HUBER_LIMIT * (z - 0.5 * HUBER_LIMIT))
                total += float(huber.sum()) * independent_share(measurement)
        return total if np.isfinite(total) else np.inf

    def _prior_cost(self, x: FloatArray) -> float:
        return 0.5 * float(np.sum(self.precision * (x - self.centre) ** 2))

    def linearise(self, model: KnitModel, x: FloatArray, scale: Mapping[str, float]) -> _Normal:
        matrix = np.diag(self.precision)
        gradient = -self.precision * (x - self.centre)
        for measurement, cache in zip(self.measurements, self.caches, strict=True):
            modelled, jacobian = sensitivities(model, self.parameters, measurement, cache)
            share = independent_share(measurement)
            for channel, rows in jacobian.items():
                residual = (measurement.measured[channel] - modelled[channel]) / scale[channel]
                weight = np.minimum(1.0, HUBER_LIMIT / np.maximum(np.abs(residual), 1e-12)) * share
                weight *= measurement.counts
                columns = rows * (np.sqrt(weight) / scale[channel])
                matrix = matrix + columns @ columns.T  # of an array with itself: half the work
                gradient = gradient + rows @ (weight * residual) / scale[channel]
        if not np.all(np.isfinite(matrix)):
            raise UserError(f"the model ({', '.join(model)}) gives NaN on {self.measurements[0].recording.source}")
        return _Normal(matrix, gradient, self.cost(model, scale))


def _projected_step(normal: _Normal, x: FloatArray, problem: _Problem, damping: float) -> FloatArray:
    """Damped Newton step in which parameters that push against a bound stay there."""
    held = ((x <= problem.low) & (normal.gradient < 0)) | ((x >= problem.high) & (normal.gradient > 0))
    free = np.flatnonzero(~held)
    matrix = normal.matrix[np.ix_(free, free)]
    damped = matrix + damping * np.diag(np.diag(matrix))
    step = np.zeros_like(x)
    step[free] = np.linalg.solve(damped, normal.gradient[free])
    return np.clip(x + step, problem.low, problem.high) - x
