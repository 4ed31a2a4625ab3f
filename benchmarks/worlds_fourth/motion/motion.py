"""A motion as the carriage makes it and as it is sampled."""

from __future__ import annotations

import numpy as np

from worlds_fourth.motion.noise import noise_motion
from worlds_fourth.motion.parts import Part, draw_parts, ramp, turns_of
from worlds_fourth.motion.plan import STEP_S, draw_plan
from worlds_fourth.randoms import Rng, stream
from worlds_fourth.signals import GAUGE_LENGTH_MM, Array

USUAL_HZ = 40.0  # about; the step is 24 ms, and now and then a sample is lost
SAMPLE_S = 0.024


def make_motion(
    seed: int, name: str, max_strain: float, minutes: float, rate_hz: float = USUAL_HZ
) -> tuple[Array, Array]:
    """Times and displacements of one recording.

    Parameters
    ----------
    seed, name : int, str
        Of the sensor and of the recording.
    max_strain : float
        At the end of the stroke.
    minutes, rate_hz : float
        About how long, and about how many samples a second.

    Returns
    -------
    time_s, displacement_mm : ndarray, shape (n,)
    """
    rng = stream(seed, "motion", name)
    seconds, longest_mm = minutes * 60.0, max_strain * GAUGE_LENGTH_MM
    plan = draw_plan(rng, longest_mm)
    y = noise_motion(rng, plan, minutes)
    turns = turns_of(y)
    whole = _joined(rng, y, turns, draw_parts(rng, plan, y, turns))
    if len(whole) * STEP_S < seconds:
        whole = np.r_[whole, np.full(int((seconds - len(whole) * STEP_S) / STEP_S) + 2, whole[-1])]
    time_s = _sample_times(rng, seconds, rate_hz / USUAL_HZ)
    time_s = time_s[time_s < min(seconds, len(whole) * STEP_S - 0.01)]
    sampled = np.interp(time_s, np.arange(len(whole)) * STEP_S, whole)
    return time_s - time_s[0], np.clip(sampled, 0, longest_mm)


def _joined(rng: Rng, y: Array, turns: Array, parts: list[Part]) -> Array:
    """A wait, a ramp to the first turn, and the noise with the parts put in."""
    last = int(turns[0]) if len(turns) else 0
    pieces = [np.zeros(int(rng.uniform(1, 4) / STEP_S)), ramp(0, y[last], 4.0)]
    for at, part in parts:
        if at < last:
            at = last
            if not abs(part[0] - y[at]) < 1e-6:
                part = np.r_[ramp(y[at], part[0], 4.0), part, ramp(part[-1], y[at], 4.0)]
        pieces += [y[last:at], part]
        last = at
    return np.concatenate([*pieces, y[last:]])


def _sample_times(rng: Rng, seconds: float, faster: float) -> Array:
    """Uneven steps, as of a rig of several parts; `faster` scales the rate."""
    count = int(seconds * 43 * faster)
    jitter = rng.choice([-0.002, -0.001, 0, 0, 0, 0.001, 0.002], count) * rng.uniform(0.3, 1)
    steps = SAMPLE_S + jitter + rng.normal(0, 1e-4, count)
    steps[rng.random(count) < 0.003] += SAMPLE_S
    return np.cumsum(steps / faster)
