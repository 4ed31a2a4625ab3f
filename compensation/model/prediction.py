"""Applying a compensator to a recording that has no reference: what a device would have shown, sample by sample."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from compensation.engines.network import mean_output
from compensation.memories.ema import start_steps
from compensation.model.compensator import Fitted, TrainedCompensator, trained
from compensation.model.runtime import READINGS_S, STEPS_S, Status, ranges_of, unseen
from compensation.series.preprocessing import TARGETS
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.read_only import Unchanging
from testbench.recordings.columns import numbers


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(Unchanging):
    """A compensated signal; its arrays can be read only.

    Attributes
    ----------
    target : {"force", "displacement"}
        What was predicted.
    time_s : ndarray, shape (n,)
        As given.
    value : ndarray, shape (n,)
        In the compensator's unit; the last good value where a sample is faulty.
    low, high : ndarray, shape (n,)
        The interval that holds 90 % of the errors of cross-validation; NaN where the compensator has none.
    status : ndarray of int, shape (n,)
        Flags of `compensation.model.runtime.Status`; 0 is good.
    """

    target: str
    time_s: FloatArray
    value: FloatArray
    low: FloatArray
    high: FloatArray
    status: NDArray[np.int64]

    def __repr__(self) -> str:
        good = len(self.status) - np.count_nonzero(self.status)
        return f"<Prediction of {self.target}: {len(self.value)} samples, {good} of them good>"

    def to_frame(self) -> pd.DataFrame:
        """As a table, with the columns of ``compensation predict``: ``time_s, force_N, low_N, high_N, status``."""
        name, unit = TARGETS[self.target]
        columns = {"time_s": self.time_s, name: self.value, f"low_{unit}": self.low, f"high_{unit}": self.high}
        return pd.DataFrame({**columns, "status": self.status})


def predicted(compensator: TrainedCompensator | Fitted, time_s: FloatArray, resistance_ohm: FloatArray) -> Prediction:
    """Apply a compensator to a whole recording: what `CompensatorStream` gives when it is fed these samples.

    With one advantage: where two times contradict each other, the rest of the recording says which is wrong, so that
    a clock which jumps ahead for one sample does not make all the others look late.

    Parameters
    ----------
    compensator : TrainedCompensator or Compensator
        As loaded, or fitted.
    time_s, resistance_ohm : ndarray, each shape (n,)
        In s and ohm, as sampled; a resistance or time that is no number, or a time out of order, marks a faulty
        sample. After a gap of more than an hour it starts anew.

    Returns
    -------
    Prediction
        Force (N) or displacement (mm) of each sample, with an interval and flags; `to_frame` makes it a table.

    Raises
    ------
    UserError
        If the compensator standardises each recording by itself, whose target's mean and spread are not known here,
        or the two are not of one length.

    Examples
    --------
    >>> import testbench as tb
    >>> from compensation import Compensator, predicted
    >>> recording = tb.example(duration_s=60).resampled(20.0)
    >>> model = Compensator(method="paper").fit(recording.conductance_S[:, None], recording["force_N"])
    >>> resistance_ohm = recording["resistance_ohm"].copy()
    >>> resistance_ohm[700] = -1.0
    >>> told = predicted(model, recording.time_s, resistance_ohm)
    >>> (told.value[700] == told.value[699]).item(), told.status[[699, 700, 701]].tolist()
    (True, [0, 1, 0])
    >>> list(told.to_frame())
    ['time_s', 'force_N', 'low_N', 'high_N', 'status']
    """
    compensator = trained(compensator)
    if compensator.per_recording:
        raise UserError(
            "a compensator trained with --per-recording needs the mean and spread of the target, which nobody knows "
            "without a reference; train without it"
        )
    time_s = numbers("predicted", "time_s", time_s)
    resistance_ohm = numbers("predicted", "resistance_ohm", resistance_ohm)
    if time_s.shape != resistance_ohm.shape:
        raise UserError(
            f"time_s and resistance_ohm must be one number a sample each, got shapes {time_s.shape} and "
            f"{resistance_ohm.shape}; give the two columns of one recording"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        conductance_S = 1.0 / resistance_ohm
    status = _faults(time_s, conductance_S)
    value = np.full(len(status), np.nan)
    good = np.flatnonzero(status == 0)
    breaks = np.flatnonzero(np.diff(time_s[good]) > STEPS_S[1]) + 1
    for rows in np.split(good, breaks):
        if len(rows):
            value[rows], status[rows] = _run(compensator, time_s[rows], conductance_S[rows])
    # Faulty rows repeat the last good one; before the first, the mean of the training stands.
    value = pd.Series(value).ffill().fillna(compensator.scaling_out.mean).to_numpy()
    low, high = compensator.margins or (np.nan, np.nan)
    return Prediction(compensator.target, time_s, value, value + low, value + high, status)


def _faults(time_s: FloatArray, conductance_S: FloatArray) -> NDArray[np.int64]:
    wrong = ~((conductance_S >= READINGS_S[0]) & (conductance_S <= READINGS_S[1]))
    status = np.where(wrong, int(Status.BAD_READING), 0)
    # A step is counted from the last good sample, so this cannot be done at once.
    last, in_order = None, _in_order(time_s)
    for row, (now, fault) in enumerate(zip(time_s, wrong, strict=True)):
        if not in_order[row] or (last is not None and not now - last >= STEPS_S[0]):
            status[row] |= int(Status.BAD_STEP)
        elif not fault:
            last = now
    return status


def _in_order(time_s: FloatArray) -> NDArray[np.bool_]:
    """The largest set of samples whose times increase; of equal times the first (patience sorting)."""
    ends: list[float] = []
    rows: list[int] = []
    before = [-1] * len(time_s)
    for row in np.flatnonzero(np.isfinite(time_s)).tolist():
        place = bisect_left(ends, time_s[row])
        if place < len(ends) and ends[place] == time_s[row]:
            continue
        ends[place : place + 1], rows[place : place + 1] = [time_s[row]], [row]
        before[row] = rows[place - 1] if place else -1
    kept = np.zeros(len(time_s), dtype=bool)
    row = rows[-1] if rows else -1
    while row >= 0:
        kept[row], row = True, before[row]
    return kept


def _run(
    compensator: TrainedCompensator, time_s: FloatArray, conductance_S: FloatArray
) -> tuple[FloatArray, NDArray]:
    running = replace(compensator.in_use, irregular=True)
    features = running.features(time_s, conductance_S)
    status = unseen(ranges_of(compensator), compensator.scaling_in.apply(conductance_S), features)
    longest = start_steps(compensator.alphas, compensator.rate_hz).max()
    status[(time_s - time_s[0]) * compensator.rate_hz < longest] |= int(Status.STARTING)
    return compensator.scaling_out.invert(mean_output(compensator.networks, features)), status
