"""The compensator: conductance in, force or displacement out; what `train` saves and everything else reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from compensation.engines.network import Network, mean_output
from compensation.memories.ema import slowest_memory_s, smooth
from compensation.memories.history import NO_HISTORY, History
from compensation.series.preprocessing import TARGETS, Series
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.read_only import Unchanging
from testbench.recordings.recording import gaps_in

# Of the range seen in training, as much to either side still goes into the memories.
MARGIN_WIDTHS = 1.0


@dataclass(frozen=True)
class Scaling:
    """Affine standardisation: ``(value - mean) / scale``."""

    mean: float
    scale: float

    @classmethod
    def of(cls, values: FloatArray) -> Scaling:
        """Mean and population standard deviation of `values`."""
        return cls(float(np.mean(values)), float(np.std(values)))

    def apply(self, values: FloatArray) -> FloatArray:
        return (values - self.mean) / self.scale

    def invert(self, values: FloatArray) -> FloatArray:
        return values * self.scale + self.mean


@dataclass(frozen=True, eq=False)
class Seen(Unchanging):
    """Ranges over the training recordings."""

    low: float  # of the standardised conductance
    high: float
    inputs_low: FloatArray  # of each input of the networks, (input_count,)
    inputs_high: FloatArray

    def held(self, x: FloatArray) -> FloatArray:
        """`x`, clipped `MARGIN_WIDTHS` widths of the range outside of it."""
        margin = MARGIN_WIDTHS * (self.high - self.low)
        return np.clip(x, self.low - margin, self.high + margin)


@dataclass(frozen=True, eq=False)
class Beginning(Unchanging):
    """What each memory is expected to hold, given the standardised conductance x at the start: offset + gain x.

    In the order of the networks' inputs, each (input_count,). A filter's x is the mean of its first M samples.
    """

    gain: FloatArray
    offset: FloatArray


class Fitted(Protocol):
    """An estimator that says what compensator it has learned."""

    def trained(self) -> TrainedCompensator:
        """That compensator; an error where it has not been fitted, or has learned something else."""


def trained(compensator: TrainedCompensator | Fitted) -> TrainedCompensator:
    """What `compensation.load` gives, as it is; of a fitted `compensation.Compensator` what it has learned.

    Raises
    ------
    UserError
        If it is neither, or the estimator was fitted by ridge.
    """
    if isinstance(compensator, TrainedCompensator):
        return compensator
    if not hasattr(compensator, "trained"):
        raise UserError(
            "compensator: must be what compensation.load gives, or a fitted compensation.Compensator, got "
            f"{compensator!r}"
        )
    return compensator.trained()


@dataclass(frozen=True, eq=False, repr=False)
class TrainedCompensator(Unchanging):
    """Scaler, smoothing bank (and other memories), and one or more networks whose mean is the answer."""

    target: str  # "force" or "displacement"
    rate_hz: float  # that the smoothing factors refer to
    alphas: FloatArray  # smoothing factors, (k,)
    scaling_in: Scaling  # of the conductance (S), fitted on the training recordings
    scaling_out: Scaling  # of the target (N or mm), likewise
    networks: tuple[Network, ...]  # each takes the k smoothed values and the history's
    irregular: bool = False  # samples are used at their own times, and not resampled to `rate_hz` (the paper)
    # "paper": a recording is known from its beginning (`compensation.memories.ema.smooth`). "causal": what a stream
    # does that is switched on with the first sample.
    start: str = "paper"
    per_recording: bool = False  # each recording is standardised by itself, as if it were known as a whole
    sign: float = 1.0  # -1 where conductance falls with the target; used for the raw baseline only
    history: History = NO_HISTORY  # memories beside the bank; the paper has none
    recipe: Mapping[str, Any] = field(default_factory=dict)  # how it was trained
    seen: Seen | None = None
    beginning: Beginning | None = None  # where a stream's memories begin
    # Added to a prediction, the ends of the interval that held 90 % of the errors in cross-validation (N or mm).
    margins: tuple[float, float] | None = None

    def __repr__(self) -> str:
        size = f"{self.input_count} memories, {self.parameter_count} weights"
        return f"<TrainedCompensator of {self.target} in {self.unit} at {self.rate_hz:g} Hz: {size}>"

    @property
    def unit(self) -> str:
        """Unit of the prediction."""
        return TARGETS[self.target][1]

    @property
    def resampling_hz(self) -> float | None:
        """Rate a recording is resampled to before it is fed in; None where it is taken as sampled."""
        return None if self.irregular else self.rate_hz

    @property
    def in_use(self) -> TrainedCompensator:
        """The one that runs: it begins as a stream does, unless it is one that must know the whole recording."""
        return self if self.per_recording else replace(self, start="causal")

    @property
    def slowest_s(self) -> float:
        """Time constant (s) of the slowest filter of the bank."""
        return slowest_memory_s(self.alphas, self.rate_hz)

    @property
    def input_count(self) -> int:
        """Features that each network takes."""
        return len(self.alphas) + self.history.count

    @property
    def at_rest(self) -> Beginning:
        """Where to begin without anything learned: the first reading had been there for ever and nothing moved."""
        gain = np.ones(self.input_count)
        gain[len(self.alphas) : len(self.alphas) + len(self.history.motion_taus_s)] = 0.0
        return Beginning(gain, np.zeros(self.input_count))

    @property
    def begins(self) -> Beginning:
        """Where to begin in the middle of a use: as was learned, else at rest."""
        return self.beginning or self.at_rest

    @property
    def is_dead(self) -> bool:
        """Whether no start of its network came alive: its output hardly moves."""
        return self.recipe.get("dead_networks", 0) == self.recipe.get("restarts")

    @property
    def parameter_count(self) -> int:
        """Weights and biases of all networks."""
        return sum(network.parameter_count for network in self.networks)

    def features(self, time_s: FloatArray, conductance_S: FloatArray) -> FloatArray:
        """Smoothed, standardised conductance, then the history's features: shape (n, input_count)."""
        scaling = Scaling.of(conductance_S) if self.per_recording else self.scaling_in
        values = scaling.apply(np.asarray(conductance_S, dtype=np.float64))
        if self.seen is not None:
            values = self.seen.held(values)
        filters = len(self.alphas)
        begin = self.begins if self.start == "causal" else self.at_rest
        affine = begin.gain[:filters], begin.offset[:filters]
        time_s = np.asarray(time_s, dtype=np.float64)
        uniform = not (self.irregular or gaps_in(time_s))
        steps_s = np.full(len(values) - 1, 1.0 / self.rate_hz) if uniform else np.diff(time_s)
        smoothed = smooth(values, self.alphas, self.rate_hz, self.start, affine, steps_s)
        held = begin.gain[filters:] * values[0] + begin.offset[filters:]
        return np.hstack([smoothed, self.history.features(values, steps_s, held)])

    def predict(self, time_s: FloatArray, conductance_S: FloatArray) -> FloatArray:
        """Force (N) or displacement (mm) at each sample.

        Parameters
        ----------
        time_s, conductance_S : ndarray, each shape (n,)
            One whole recording, from its first sample. Uniform at `rate_hz` unless `irregular`, but for gaps.
        """
        return self.scaling_out.invert(mean_output(self.networks, self.features(time_s, conductance_S)))

    def predict_series(self, series: Series) -> FloatArray:
        """Prediction for one recording, in the target's unit."""
        if not self.per_recording:
            return self.predict(series.time_s, series.conductance_S)
        output = self.scaling_out.apply(self.predict(series.time_s, series.conductance_S))
        return Scaling.of(series.truth).invert(output)
