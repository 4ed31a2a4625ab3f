"""A compensator that is fed sample by sample, as on a chip: the numbers of `predict`, in constant memory."""

from __future__ import annotations

import numpy as np

from compensation.engines.network import mean_output
from compensation.memories.ema import log_retention, start_steps
from compensation.memories.history import RunningHistory
from compensation.model.compensator import Fitted, TrainedCompensator
from compensation.model.runtime import Status, fault_of, limits_of, ranges_of, streamable, unseen
from gcode.support.kinds import number


class CompensatorStream:
    """Running state of a compensator; a faulty sample does not spoil later ones (see `compensation.model.runtime`).

    A filter's output is its response from a zero state plus a fading share of its initial value, so the mean of the
    first M samples can be put in when it is known, without keeping those samples. Before that, the mean of those
    seen so far stands in (``start="causal"``).

    Parameters
    ----------
    compensator : TrainedCompensator or Compensator
        As loaded, or fitted.

    Attributes
    ----------
    value : float
        The last prediction, in N or mm; before the first one the mean of the training.
    status : Status
        Of the last sample.
    margins : tuple of float, optional
        Added to a value: the ends of the interval that holds 90 % of the errors to be expected.

    Raises
    ------
    UserError
        If recordings are standardised by themselves: a stream does not know its own mean in advance.

    Examples
    --------
    >>> import testbench as tb
    >>> from compensation import Compensator, CompensatorStream
    >>> recording = tb.example(duration_s=60).resampled(20.0)
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> running = CompensatorStream(model)
    >>> force_N = [running.update(conductance) for conductance in recording.conductance_S]
    >>> running.update(float("nan")) == force_N[-1], running.status.name
    (True, 'BAD_READING')
    """

    def __init__(self, compensator: TrainedCompensator | Fitted) -> None:
        compensator = streamable(compensator)
        self._compensator, self.margins = compensator, compensator.margins
        self._log_keep = log_retention(compensator.alphas)
        self._lengths = start_steps(compensator.alphas, compensator.rate_hz)
        self._seen_in_training, self._beginning = ranges_of(compensator), compensator.begins
        self._limits = limits_of(compensator)
        self.reset()

    def __repr__(self) -> str:
        return f"<CompensatorStream: {self.value:.4g} {self._compensator.unit}, {self.status.name}>"

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        count = len(self._compensator.alphas)
        self._forced, self._fading = np.zeros(count), np.ones(count)
        self._sums, self._seen = np.zeros(count), np.zeros(count)
        self._elapsed_steps, self._first = 0.0, True
        self._history = RunningHistory(self._compensator.history)
        self.value, self.status = float(self._compensator.scaling_out.mean), Status.STARTING

    def update(self, conductance_S: float, dt_s: float | None = None) -> float:
        """Feed one sample.

        Parameters
        ----------
        conductance_S : float
        dt_s : float, optional
            Time since the last sample that was not left out; by default one step at the compensator's rate. Ignored
            for the first sample.

        Returns
        -------
        float
            Force (N) or displacement (mm); `status` says whether it is good.

        Raises
        ------
        UserError
            If either is none of these, such as a text; what is no number (NaN) is a faulty sample.
        """
        compensator = self._compensator
        conductance_S = number("conductance_S", conductance_S)
        step_s = 1.0 / compensator.rate_hz if dt_s is None or self._first else number("dt_s", dt_s)
        fault = fault_of(conductance_S, step_s)
        if fault:
            self.status = fault
            return self.value
        reading = (conductance_S - compensator.scaling_in.mean) / compensator.scaling_in.scale
        features, starting = self._remember(float(np.clip(reading, *self._limits)), step_s)
        output = mean_output(compensator.networks, features[None, :])
        self.value = float(compensator.scaling_out.invert(output)[0])
        flags = unseen(self._seen_in_training, np.array([reading]), features[None, :])
        self.status = Status(int(flags[0])) | (Status.STARTING if starting else Status.GOOD)
        return self.value

    def _remember(self, x: float, step_s: float) -> tuple[np.ndarray, bool]:
        """Take x into all memories: the networks' inputs, and whether any filter is still starting."""
        count, begin = len(self._forced), self._beginning
        if self._first:
            self._first = False
        else:
            steps = step_s * self._compensator.rate_hz
            self._elapsed_steps += steps
            keep = np.exp(self._log_keep * steps)
            self._forced = x + keep * (self._forced - x)
            self._fading = self._fading * keep
        starting = (self._elapsed_steps < self._lengths) | (self._seen == 0)
        self._sums[starting] += x
        self._seen[starting] += 1
        initial = begin.offset[:count] + begin.gain[:count] * self._sums / self._seen
        held = begin.offset[count:] + begin.gain[count:] * x
        remembered = self._history.update(x, step_s, held)
        return np.concatenate([self._forced + self._fading * initial, remembered]), bool(starting.any())
