"""What the networks of `auto`, `tuned` and the twin learn from, and how one of them is trained.

The state of a knit is never the same twice: beside the recording as it is, there are versions of it with the
conductance shifted a little up and down, so that a network learns from changes rather than from absolute values.
Nor is the motion: where all holds last six seconds, a memory of six seconds tells when the hold will end, and a
network that learned that clock is lost where they last twelve. So there may be versions at another pace as well, in
which the recording is slower or quicker than it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from compensation.engines.engine import BATCH, train_adam
from compensation.engines.network import Network
from compensation.model.compensator import TrainedCompensator
from compensation.model.runtime import ready_for_use
from compensation.series.preprocessing import Series
from compensation.series.score import BLOCK_S
from compensation.training.options import Options
from compensation.training.untrained import training_arrays, untrained
from gcode.support.arrays import FloatArray
from testbench.recordings.recording import recorded_duration_s

# The history's features are standardised to this spread: a little more penalised than the bank's, which have about 1.
HISTORY_SPREAD = 0.5
STATE_SHIFT = 0.1
PIECE_S = 40.0
ROWS, SMALL_BATCH, RATE, AVERAGING, LESSON_EPOCHS = 2_000, 40, 4e-3, 0.9, 1_000


@dataclass(frozen=True)
class Lessons:
    """What networks learn from: features of the recording as it is, and with its conductance shifted."""

    blank: TrainedCompensator  # scalers, bank and history
    versions: tuple[FloatArray, ...]  # each (n, k), (feature - shift) * scale; first the recording as it is
    truth: FloatArray  # standardised target, (n,)
    shift: FloatArray  # (k,)
    scale: FloatArray  # (k,)
    block_rows: int  # of a minute

    def fit(self, kept: NDArray[np.bool_], options: Options, seed: int) -> Network:
        """Train one network, on standardised features, on the rows that are kept."""
        step = max(len(self.truth) // ROWS, 1)
        # Each version is thinned out at rows of its own, so that together they cover the recording.
        picks = [
            np.arange(index * step // len(self.versions), len(kept), step) for index in range(len(self.versions))
        ]
        picks = [rows[kept[rows]] for rows in picks]
        features = np.concatenate([version[rows] for version, rows in zip(self.versions, picks, strict=True)])
        truth = np.concatenate([self.truth[rows] for rows in picks])
        # MLPRegressor divides L2 by the batch size: as much of it here as in batches of its own size.
        l2 = options.l2 * SMALL_BATCH / BATCH
        fit = train_adam(features, truth, options.sizes, seed, l2, LESSON_EPOCHS, SMALL_BATCH, RATE, AVERAGING)
        return fit.network

    def fit_on_all(self, options: Options, seed: int) -> Network:
        """Train one network on every row, for features as they come."""
        return self.fit(np.ones(len(self.truth), dtype=bool), options, seed).absorbing(self.shift, self.scale)


def lessons(
    series: Sequence[Series],
    target: str,
    options: Options,
    starts: bool = False,
    shift: float = STATE_SHIFT,
    paces: Sequence[float] = (1.0,),
) -> Lessons:
    """Features and target of all training recordings, one after the other.

    Parameters
    ----------
    starts : bool
        Begin as a stream does, and let the shifted versions begin anew every `PIECE_S`, so that a network also learns
        from memories that have just been switched on.
    shift : float
        Of the conductance in the versions, in standard deviations.
    paces : sequence of float
        Factors by which time is stretched (2: the motion takes twice as long); for each, one version with the
        conductance shifted up, one with it shifted down.
    """
    blank = untrained(series, target, options)
    copies = [list(series), list(series)]
    if starts:
        blank = ready_for_use(blank, series).in_use
        copies = [pieces(series, PIECE_S, offset) for offset in (0.0, PIECE_S / 2)]
    features, truth = training_arrays(blank, series)
    centre, scale = np.zeros(blank.input_count), np.ones(blank.input_count)
    own = features[:, len(blank.alphas) :]
    centre[len(blank.alphas) :] = own.mean(axis=0)
    scale[len(blank.alphas) :] = HISTORY_SPREAD / np.maximum(own.std(axis=0), 1e-9)
    moved = [
        features_at_pace(_shifted(blank, by), copy, pace)
        for pace in paces
        for by, copy in zip((shift, -shift), copies, strict=True)
    ]
    versions = tuple((values - centre) * scale for values in (features, *moved))
    duration_s = sum(recorded_duration_s(part.time_s) for part in series)
    block_rows = max(int(len(truth) * BLOCK_S / duration_s), 1)
    return Lessons(blank, versions, truth, centre, scale, block_rows)


def pieces(series: Sequence[Series], length_s: float, offset_s: float = 0.0) -> list[Series]:
    """The recordings cut every `length_s`, the first cut after `offset_s` more; together the same samples."""
    found = []
    for part in series:
        number = np.floor((part.time_s - part.time_s[0] - offset_s) / length_s)
        for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(number)) + 1):
            found.append(part.rows(rows))
    return found


def features_at_pace(blank: TrainedCompensator, series: Sequence[Series], pace: float) -> FloatArray:
    """Features (n, k) of the recordings, had a second of them taken `pace` seconds.

    Of a sensor without memory, or one of pure hysteresis, that is what it would have measured; of a knit it is not,
    and so a network trusts its time constants no more closely than to about that factor.
    """
    if pace == 1.0:
        return training_arrays(blank, series)[0]
    slower = [replace(part, time_s=part.time_s * pace) for part in series]
    return training_arrays(replace(blank, irregular=True), slower)[0]


def _shifted(blank: TrainedCompensator, by: float) -> TrainedCompensator:
    """A compensator that reads a conductance as if it were higher by `by` standard deviations."""
    scaling = blank.scaling_in
    return replace(blank, scaling_in=replace(scaling, mean=scaling.mean - by * scaling.scale))
