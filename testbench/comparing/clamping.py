"""The zero of the displacement of a recording that was clamped anew: a nuisance of that recording alone.

A sensor that is taken out and put back is gripped a little higher or lower, so its displacement counts from another
point. No effect should be blamed for that, nor be found in it. The zero of the force and the gain of the conductance,
which change as well, are taken out by `testbench.comparing.model_errors.rms_errors`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from testbench.comparing.model_errors import channel_name, rms_errors
from testbench.fitting.evidence.independent_samples import independent_share
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import FORCE_CHANNEL, UNIT_OF

REACH = 4.0  # how far the search goes on either side, in plays
COARSE = 17  # points at which the search begins: half a play apart
FINE = 1e-4  # how closely the best is found, in plays
SETTLED = 0.01  # relative change of the width from one look at the curvature to the next, below which it is found
LOOKS = 12  # at the curvature, at most
TRIED_MM = 0.5  # by how much a displacement is moved to see whether it may have been clamped anew
TELLING_FALL = 0.2  # share of the error that must go; several effects take less


@dataclass(frozen=True)
class Zero:
    """Where a recording's displacement should begin to count.

    Attributes
    ----------
    shift_mm : float
        To be added to the recorded displacement.
    standard_error_mm : float
    play_mm : float
        Standard deviation that was expected of it.
    force_N : float or None
        What was added to the modelled force there; None where no force was recorded.
    """

    shift_mm: float
    standard_error_mm: float
    play_mm: float
    force_N: float | None

    def __str__(self) -> str:
        force = "" if self.force_N is None else f", its force from {self.force_N:+.3g} N"
        return (
            f"clamped anew (play {self.play_mm:g} mm): its displacement counts from "
            f"{-self.shift_mm:+.3g} ± {self.standard_error_mm:.2g} mm{force}"
        )


def moved(measurement: Measurement, shift_mm: float) -> Measurement:
    """The measurement with its displacement counted from another point; nothing is left free in it.

    Of several recordings in a row only the last was clamped anew.
    """
    last = measurement.signals["time_s"] >= (measurement.begins_s[-1] if measurement.begins_s else -np.inf)
    shift = shift_mm / measurement.recording.gauge_length_mm * last
    there = {name: measurement.signals[name] + shift for name in ("strain_nominal", "strain")}
    return replace(measurement, signals={**measurement.signals, **there}, clamp_play_mm=0.0)


def zero_of(model: KnitModel, measurement: Measurement) -> Zero:
    """The zero of displacement under which a model explains a recording best.

    The shift has a Gaussian prior around zero, as wide as the clamps' play; each channel's noise is as large as what
    the model leaves of it (profile likelihood), and neighbouring samples count as one (`independent_share`). The
    search is a coarse one over all that the prior allows, then Brent's method around the best.

    Parameters
    ----------
    model : KnitModel
    measurement : Measurement
        With `clamp_play_mm` above zero.
    """
    play_mm = measurement.clamp_play_mm

    def cost(shift: float) -> float:
        """Minus the log posterior; `shift` in plays."""
        errors = rms_errors(model, moved(measurement, shift * play_mm), free_offset=True)
        return count * float(sum(np.log(max(error, 1e-12)) for error in errors.values())) + 0.5 * shift**2

    count = float(measurement.counts.sum()) * independent_share(measurement)
    shifts = np.linspace(-REACH, REACH, COARSE)
    costs = np.array([cost(shift) for shift in shifts])
    best = int(np.argmin(costs))
    around = shifts[max(best - 1, 0)], shifts[min(best + 1, COARSE - 1)]
    found = float(minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": FINE}).x)
    shift_mm = play_mm * found
    residual = moved(measurement, shift_mm).residual(model)
    force = residual.get(FORCE_CHANNEL)
    force_N = None if force is None else float(force[measurement.counts].mean())
    return Zero(shift_mm, play_mm * _width(cost, found), play_mm, force_N)


def _width(cost: Callable[[float], float], at: float) -> float:
    """Standard deviation of a posterior around its mode, from the curvature; at most that of the prior.

    The curvature is that over one standard deviation on either side, so the step to look at it over is what is found:
    over one of the play, however narrow the posterior in it, the cost is no parabola.
    """
    here, width = cost(at), 1.0
    for _ in range(LOOKS):
        step = width
        bend = (cost(at + step) - 2 * here + cost(at - step)) / step**2
        width = 1 / float(np.sqrt(max(bend, 1.0)))
        if abs(width - step) < SETTLED * step:
            break
    return width


def may_be_clamped_anew(model: KnitModel, held: Measurement) -> str:
    """What to say where another zero of the displacement would explain much of a recording; empty where not.

    It costs three simulations.
    """
    here = rms_errors(model, held, free_offset=True)
    tried = [(shift, rms_errors(model, moved(held, shift), free_offset=True)) for shift in (-TRIED_MM, TRIED_MM)]
    shift_mm, there = min(tried, key=lambda one: sum(np.log(one[1][c] / here[c]) for c in here))
    falls = [c for c in here if there[c] < (1 - TELLING_FALL) * here[c]]
    if not falls or any(there[c] > here[c] for c in here):
        return ""
    fall = " and ".join(f"of the {channel_name(c)} from {here[c]:.3g} to {there[c]:.3g} {UNIT_OF[c]}" for c in falls)
    return (
        f"{held.recording.source}: counted {abs(shift_mm):g} mm {'further' if shift_mm > 0 else 'less far'}, its "
        f"displacement would take the held-out error {fall}; if the sensor was clamped anew, say `clamp_play_mm`"
    )
