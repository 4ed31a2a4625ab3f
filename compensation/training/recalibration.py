"""Fitting a trained compensator to another day or another specimen from a minute of reference.

Four numbers are moved, each as little as the reference allows: gain and zero of the conductance that goes in, gain
and zero of what comes out. The networks stay. Errors of neighbouring samples are alike, so a minute counts as few
independent ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from compensation.model.compensator import Scaling, TrainedCompensator
from compensation.series.preprocessing import Series
from compensation.series.reading import read_samples, without_reference
from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.recording import Recording, gaps_in, recorded_duration_s, recorded_time_s

# How far each wanders between specimens and with age, as standard deviations: log gain and zero (in standard
# deviations of the training) of the input, then of the output. Errors APART_S apart are about independent, and as
# large as ERROR of the target's standard deviation. Developed on specimens 101 to 104; seven sets of values within a
# factor of two gave an r2 of 0.72 to 0.75 on another specimen, where there was 0.59 before.
SPREADS = np.array([0.3, 0.5, 0.1, 0.2])
APART_S, ERROR = 8.0, 0.5
LEAST_S, WARM_S = 5.0, 2.0
# Standard deviations of the training: a sensor that was just put down still relaxes, one in use moves by about 1.
MOST_AT_REST = 0.5
# Of the training's standard deviation: a reference that spreads less stands still, but for the noise of its cell.
STILL = 0.1
# Standard deviations from its mean that a training hardly ever leaves.
FARTHEST = 4.0
# Of the samples of a reference: more of them farther than that are no faulty readings.
MOST_FAR = 0.5


@dataclass(frozen=True)
class Correction:
    """What is moved: the standardised input ``(x - shift_in) / gain_in``, the output ``shift_out + gain_out y``.

    Shifts are in standard deviations of the training's conductance and target.
    """

    gain_in: float = 1.0
    shift_in: float = 0.0
    gain_out: float = 1.0
    shift_out: float = 0.0

    def of(self, compensator: TrainedCompensator) -> TrainedCompensator:
        """The compensator with this correction applied."""
        into, out = compensator.scaling_in, compensator.scaling_out
        return replace(
            compensator,
            scaling_in=Scaling(into.mean + self.shift_in * into.scale, into.scale * self.gain_in),
            scaling_out=Scaling(out.mean + self.shift_out * out.scale, out.scale * self.gain_out),
        )


def recalibrated(compensator: TrainedCompensator, part: Series) -> TrainedCompensator:
    """The compensator, corrected by a reference: half a minute to a minute of motion, or of rest at a known value.

    Raises
    ------
    UserError
        If less than 5 s were recorded; if most of the target is out of the training's reach; if it stands still while
        the sensor moves, or the reverse; or if the compensator standardises each recording by itself.
    """
    if compensator.per_recording:
        raise UserError("a compensator trained with --per-recording knows no level that could be corrected")
    duration_s = recorded_duration_s(part.time_s)
    if round(duration_s, 6) < LEAST_S:  # times since 1970 are known to about a microsecond
        raise UserError(
            f"{part.source}: {duration_s:.1f} s of reference; a recalibration needs at least {LEAST_S:g} s, "
            "and is worth more with 30 to 60 s"
        )
    part, left_out = _without_outliers(compensator, part)
    _check_of_this_sensor(compensator, part)
    found = correction(compensator, part)
    before, after = (_rms(one, part) for one in (compensator, found.of(compensator)))
    note = {
        "on": part.source,
        "marks": part.marks,
        "seconds": duration_s,
        "left_out": left_out,
        "rms_before": before,
        "rms_after": after,
        **vars(found),
    }
    earlier = compensator.recipe.get("recalibrated", [])
    return replace(found.of(compensator), recipe={**compensator.recipe, "recalibrated": [*earlier, note]})


def correction(compensator: TrainedCompensator, part: Series) -> Correction:
    """The likeliest correction, given the reference and the spreads (a posterior mode by least squares)."""
    from scipy.optimize import least_squares

    running = compensator.in_use
    recorded_s, reference = recorded_time_s(part.time_s), _explainable(compensator, part.truth)
    late = recorded_s >= WARM_S
    # Weights that make as many errors as there are count as independent ones.
    weight = np.sqrt(recorded_s[-1] / APART_S / late.sum()) / (ERROR * compensator.scaling_out.scale)
    late &= np.isfinite(reference)

    def residual(numbers: FloatArray) -> FloatArray:
        error = _moved(numbers).of(running).predict_series(part) - reference
        return np.concatenate([weight * error[late], numbers])

    return _moved(least_squares(residual, np.zeros(4), method="lm", diff_step=1e-3, max_nfev=60).x)


def end_of_first(seconds: float, time_s: FloatArray) -> float:
    """When the first seconds of the times (n,) are over: with the sample after them, unless they end in a gap."""
    end_s = float(time_s.min()) + seconds
    if any(start_s <= end_s < stop_s for start_s, stop_s in gaps_in(np.sort(time_s))):
        return end_s
    return float(np.min(time_s[time_s > end_s], initial=np.inf))


def recording_at_rest(compensator: TrainedCompensator, path: str | Path, seconds: float) -> Recording:
    """The beginning of a recording of a sensor without load: its targets are zero throughout.

    Raises
    ------
    UserError
        As `read_samples`; if less than two samples are good; or if the reading wanders as a moved sensor's does.
    """
    time_s, resistance_ohm = read_samples(path)
    good = np.isfinite(time_s) & np.isfinite(resistance_ohm) & (resistance_ohm > 0)
    if good.any():
        good &= time_s <= end_of_first(seconds, time_s[good])
    if good.sum() < 2 or not (np.diff(time_s[good]) > 0).all():
        raise UserError(f"{path}: fewer than two good samples in order of time within {seconds:g} s of its beginning")
    time_s, resistance_ohm = time_s[good], resistance_ohm[good]
    if (spread := _spread(compensator, 1.0 / resistance_ohm)) > MOST_AT_REST:
        raise UserError(
            f"{path}: over its first {seconds:g} s the conductance spreads {spread:.2f} times as far as in the "
            f"training, at rest it does {MOST_AT_REST:g} times at most; give --seconds of rest, or leave --rest out"
        )
    return without_reference(str(path), time_s, resistance_ohm)


def reach(compensator: TrainedCompensator) -> float:
    """How far from zero the target went in training, in its unit."""
    return abs(compensator.scaling_out.mean) + FARTHEST * compensator.scaling_out.scale


def one_sigma_changes(compensator: TrainedCompensator, series: Sequence[Series]) -> FloatArray:
    """By how much the prediction changes where each of the four numbers is a standard deviation of its prior off.

    Returns
    -------
    ndarray, shape (4, n)
        In the target's unit, at every sample of the recordings, one after the other.
    """

    def prediction(one: TrainedCompensator) -> FloatArray:
        return np.concatenate([one.predict_series(part) for part in series])

    as_it_is = prediction(compensator)
    return np.stack([prediction(_moved(off).of(compensator)) - as_it_is for off in np.eye(len(SPREADS))])


def _explainable(compensator: TrainedCompensator, truth: FloatArray) -> FloatArray:
    """What the compensator would predict of this reference if its gains and zeros were right.

    One that explains a share r2 of the variance falls short by 1 - r2 of the way from the mean. Where the reference
    stands still, at rest at the end of its range, that must not be taken for an error; where it moves, it evens out.
    """
    promise, mean = compensator.recipe.get("cross_validated"), compensator.scaling_out.mean
    if not _still(compensator, truth) or promise is None:
        return truth
    return mean + float(np.clip(promise["r2"], 0.0, 1.0)) * (truth - mean)


def _without_outliers(compensator: TrainedCompensator, part: Series) -> tuple[Series, int]:
    """The reference, its target NaN where it is out of the training's reach, and how often that is.

    No correction makes a network predict what it has never seen: one reading of 1e5 N would outweigh all others.
    """
    most, unit = reach(compensator), compensator.unit
    far = np.abs(part.truth) > most
    if far.mean() > MOST_FAR:
        raise UserError(
            f"{part.source}: {far.mean():.0%} of the reference lies beyond {most:.3g} {unit}, as far as the training "
            f"went; check that the {compensator.target} is in {unit}, and of a sensor as in the training"
        )
    return replace(part, truth=np.where(far, np.nan, part.truth)), int(far.sum())


def _check_of_this_sensor(compensator: TrainedCompensator, part: Series) -> None:
    """Refuse a reference that stands still beside a sensor that moves, or the reverse: one is not connected."""
    spread = _spread(compensator, part.conductance_S)
    if spread <= STILL and np.nanstd(part.truth) > MOST_AT_REST * compensator.scaling_out.scale:
        raise UserError(
            f"{part.source}: the conductance stands still (it spreads {spread:.2g} times as far as in the training) "
            f"while the {compensator.target} moves; check that the sensor is connected, and resistance_ohm in ohm"
        )
    if _still(compensator, part.truth) and spread > MOST_AT_REST:
        raise UserError(
            f"{part.source}: the {compensator.target} stands still at {np.nanmean(part.truth):.3g} "
            f"{compensator.unit} while the conductance spreads {spread:.2f} times as far as in the training, so it "
            f"is no reference of this sensor (at rest it spreads {MOST_AT_REST:g} times as far at most); check that "
            "it was recorded"
        )


def _still(compensator: TrainedCompensator, truth: FloatArray) -> bool:
    return bool(np.nanstd(truth) <= STILL * compensator.scaling_out.scale)


def _spread(compensator: TrainedCompensator, conductance_S: FloatArray) -> float:
    """Standard deviation of a conductance, in those of the training."""
    return float(np.std(conductance_S)) / compensator.scaling_in.scale


def _moved(numbers: FloatArray) -> Correction:
    """The correction from four numbers, each in units of its prior standard deviation."""
    log_in, shift_in, log_out, shift_out = numbers * SPREADS
    return Correction(float(np.exp(log_in)), float(shift_in), float(np.exp(log_out)), float(shift_out))


def _rms(compensator: TrainedCompensator, part: Series) -> float:
    error = compensator.in_use.predict_series(part) - part.truth
    return float(np.sqrt(np.nanmean(error**2)))
