"""What a sensor went through before its recording: earlier programs, with rests in between.

A knit remembers: its largest stretch, its set, how long its contacts have settled. The second recording of one sensor
is therefore not the first one again. The rig plays the earlier programs first and records only the last one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbench.knit.effect import FloatArray
from testbench.rig.simulation.simulated import SIMULATED_HZ, Motion

DEFAULT_REST_S, LONGEST_REST_S = 600.0, 1e5
RETURN_MM_PER_S = 1.0


def past_displacement(
    motions: Sequence[Motion], rest_s: float | Sequence[float], begins_mm: float = 0.0
) -> FloatArray:
    """The stage's displacement up to a recording: all `motions`, each with a rest after it, shape (n,).

    Parameters
    ----------
    motions : sequence of Motion
        In the order in which they were played.
    rest_s : float or sequence of float
        Rest after each, where the next motion begins; one that ends elsewhere is brought there at 1 mm/s, which may
        take longer than the rest.
    begins_mm : float
        Where the recorded motion begins.
    """
    if not motions:
        return np.zeros(0)
    parts = []
    next_mm = [*(float(motion.displacement_mm[0]) for motion in motions[1:]), begins_mm]
    for motion, begin_mm, after_s in zip(motions, next_mm, np.broadcast_to(rest_s, len(motions)), strict=True):
        end_mm = float(motion.displacement_mm[-1])
        way_back_s = abs(end_mm - begin_mm) / RETURN_MM_PER_S
        taken_s = max(after_s, way_back_s + 1 / SIMULATED_HZ)
        times_s = np.arange(1, round(taken_s * SIMULATED_HZ)) / SIMULATED_HZ
        parts += [motion.displacement_mm, np.interp(times_s, [0.0, max(way_back_s, 1e-9)], [end_mm, begin_mm])]
    return np.concatenate(parts)
