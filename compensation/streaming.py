"""Sample by sample, as on the chip: the same numbers as the batch, in constant memory."""

from __future__ import annotations

import numpy as np

from compensation.compensator import Compensator
from compensation.ema import start_samples
from compensation.history import RunningHistory


class CompensatorStream:
    """Running state of a compensator.

    A filter's output is its response from a zero state plus a fading share of its initial value, so the mean of the
    first M samples can be put in when it is known, without keeping those samples. Before that, the mean of those
    seen so far stands in (``start="causal"``): outputs equal the paper's from the longest M on (31 samples, 1.5 s).
    """

    def __init__(self, compensator: Compensator) -> None:
        self._compensator = compensator
        self._log_keep = np.log1p(-np.minimum(compensator.alphas, 1 - 1e-16))
        self._lengths = start_samples(compensator.alphas, compensator.rate_hz)
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        count = len(self._compensator.alphas)
        self._forced, self._fading = np.zeros(count), np.ones(count)
        self._sums, self._seen = np.zeros(count), np.zeros(count)
        self._elapsed_steps, self._first = 0.0, True
        self._history = RunningHistory(self._compensator.history)

    def update(self, conductance_S: float, dt_s: float | None = None) -> float:
        """Feed one sample.

        Parameters
        ----------
        conductance_S : float
        dt_s : float, optional
            Time since the last sample; by default one step at the compensator's rate. Ignored for the first sample.

        Returns
        -------
        float
            Force (N) or displacement (mm).
        """
        compensator = self._compensator
        x = (conductance_S - compensator.scaling_in.mean) / compensator.scaling_in.scale
        steps = 1.0 if dt_s is None else dt_s * compensator.rate_hz
        if self._first:
            self._first = False
        else:
            self._elapsed_steps += steps
            keep = np.exp(self._log_keep * steps)
            self._forced = x + keep * (self._forced - x)
            self._fading = self._fading * keep
        starting = (self._elapsed_steps < self._lengths - 0.5) | (self._seen == 0)
        self._sums[starting] += x
        self._seen[starting] += 1
        smoothed = self._forced + self._fading * self._sums / self._seen
        features = np.concatenate([smoothed, self._history.update(x, steps / compensator.rate_hz)])[None, :]
        output = float(np.mean([network(features)[0] for network in compensator.networks]))
        return output * compensator.scaling_out.scale + compensator.scaling_out.mean
