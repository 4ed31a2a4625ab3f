"""What a fitted model expects of a motion that was not made yet, and how uncertain that is.

Linearised: the parameters are Gaussian about the fit, with the precision of the readings so far and of their priors,
and the next reading follows them along its sensitivities. Nothing is fitted again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gcode.support.errors import UserError
from testbench.design.information import Prediction
from testbench.fitting.evidence.evidence import scaled
from testbench.fitting.evidence.independent_samples import in_last_fit, news_of
from testbench.fitting.evidence.priors import priors_of
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.cache import SimulationCache
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import FORCE_CHANNEL

NEGLIGIBLE = 1e-3  # directions in which a prediction varies by less than this share of the noise are left out
SWITCHED_OFF = 1e3  # factor on the precision of a group of weights from which it changes nothing
_Modelled = Mapping[str, FloatArray]  # by channel, shape (n,)


@dataclass(frozen=True, eq=False)
class Likely:
    """One hypothesis that is still likely.

    Attributes
    ----------
    name : str
        ``nothing`` or a mechanism.
    model : KnitModel
        Fitted to all readings so far.
    scales : mapping of str to float
        Factor on the prior precision of each group of shape weights, as the evidence found it.
    """

    name: str
    probability: float
    model: KnitModel
    scales: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Reading:
    """How much a recording counts: its noise, and how many independent readings it has.

    Attributes
    ----------
    noise : mapping of channel to float
        What the best model leaves, in N and in ln S.
    pieces : float
        Independent pieces of one recording, at most.
    """

    noise: Mapping[str, float]
    pieces: float


class Forecaster:
    """Predictions of one hypothesis.

    Parameters
    ----------
    likely : Likely
    measurement : Measurement
        All readings so far, on which its model was fitted.
    reading : Reading
    """

    def __init__(self, likely: Likely, measurement: Measurement, reading: Reading) -> None:
        self.likely, self.reading = likely, reading
        priors = priors_of(likely.model, measurement, likely.model, {})
        scale = np.array([likely.scales.get(name, 1.0) for name in priors.groups])
        factor = scaled(np.ones(len(priors.mean)), priors.group, scale)
        kept = np.flatnonzero(factor < SWITCHED_OFF)
        self._parameters = [priors.parameters[k] for k in kept]
        width = (priors.precision[kept] * factor[kept]) ** -0.5
        # What is known of the parameters counts samples as the diagnosis does.
        runs = 1 + len(measurement.begins_s)
        _, rows, _ = self._linearised(measurement, in_last_fit(measurement, reading.pieces * runs))
        rows = rows * width[:, None]
        value, vector = np.linalg.eigh(rows @ rows.T)
        self._spread = width[:, None] * vector / np.sqrt(1.0 + np.maximum(value, 0.0))

    def expect(self, measurement: Measurement) -> tuple[Prediction, float]:
        """What is expected of the counting samples, and the motion's largest force in N, either way (NaN: none).

        Parameters
        ----------
        measurement : Measurement
            A motion that was not made yet, after all that the specimen went through; only its samples count.
        """
        mean, rows, modelled = self._linearised(measurement, news_of(measurement, self.reading.pieces))
        factor = rows.T @ self._spread
        value, vector = np.linalg.eigh(factor.T @ factor)
        begin = int(np.searchsorted(measurement.signals["time_s"], (0.0, *measurement.begins_s)[-1] - 1e-9))
        force_N = modelled[FORCE_CHANNEL][begin:] if FORCE_CHANNEL in modelled else np.array([np.nan])
        return Prediction(mean, factor @ vector[:, value > NEGLIGIBLE]), float(np.abs(force_N).max())

    def _linearised(self, measurement: Measurement, news: float) -> tuple[FloatArray, FloatArray, _Modelled]:
        """Means and sensitivities over the noise, channels in a row, shapes (m,) and (p, m); and what is read.

        The samples that count tell as much as so many (`news`) independent ones.
        """
        modelled, jacobian = sensitivities(self.likely.model, self._parameters, measurement, SimulationCache())
        if unread := [channel for channel in self.reading.noise if channel not in modelled]:
            raise UserError(
                f"the model of {self.likely.name} says nothing of {unread[0]}: it needs a law of that channel, "
                "and the recordings a column of it"
            )
        counts = measurement.counts
        over = {c: np.sqrt(news / counts.sum()) / noise for c, noise in self.reading.noise.items()}
        mean = np.concatenate([modelled[c][counts] * over[c] for c in over])
        return mean, np.hstack([jacobian[c][:, counts] * over[c] for c in over]), modelled
