"""How strong an effect is, and how large it must be for a strength.

The strength is the RMS of what an effect changes, less a cubic over strain, a step with the direction of motion and a
line over time, over a floor: 5 mN of force, 4e-3 of ln R (five times the noise of ln R). It is counted in the
calibration, in the channel that shows more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from worlds_fourth.chain import Sized, plain, respond
from worlds_fourth.effects.effect import Effect
from worlds_fourth.signals import Array, Record
from worlds_fourth.specimen import Specimen

FLOORS = {"force": 5e-3, "conductance": 4e-3}  # N, ln R
STEPS = 14
CLOSE = 0.03  # of the logarithm of the strength
TRIED = (0.15, 0.3, 0.5, 0.7, 0.85)  # of the largest size, where the largest is too weak


def strengths(specimen: Specimen, record: Record, effects: Sized, floors: Mapping[str, float]) -> dict[str, float]:
    """Strength of the effects together, in each channel of `floors`."""
    before, after = plain(specimen, record), respond(specimen, record, effects)
    changes = dict(zip(FLOORS, (b - a for a, b in zip(before, after, strict=True)), strict=True))
    return {name: _left(record, changes[name]) / floor for name, floor in floors.items()}


def _left(record: Record, change: Array) -> float:
    rest = change - record.plane @ (record.plane.T @ change)
    return float(np.sqrt(np.mean(rest**2)))


def size_for(
    specimen: Specimen, record: Record, effect: Effect, strength: float, floors: Mapping[str, float]
) -> tuple[float, bool]:
    """Size that reaches the strength, and whether even the largest size is too weak."""

    def measured(size: float) -> float:
        return max(strengths(specimen, record, [(effect, size)], floors).values())

    largest, top = effect.largest, measured(effect.largest)
    if top <= strength:  # some effects are strongest below their largest size
        tried = [(measured(largest * q), largest * q) for q in TRIED] + [(top, largest)]
        enough = [pair for pair in tried if pair[0] > strength]
        if not enough:
            return max(tried)[1], True
        top, largest = enough[0]
    return _narrowed(strength, largest, top, measured), False


def _narrowed(strength: float, largest: float, top: float, measured: Callable[[float], float]) -> float:
    """Between 0 and `largest`, whose strength is `top`: three steps by straight lines, then by halves."""
    low, low_strength, high, high_strength = 0.0, 0.0, largest, top
    size = largest * strength / top
    best = (abs(math.log(top / strength)), largest)
    for step in range(STEPS):
        now = measured(size)
        if now > 0:
            best = min(best, (abs(math.log(now / strength)), size))
        if best[0] < CLOSE:
            break
        if now < strength:
            low, low_strength = size, now
        else:
            high, high_strength = size, now
        if step < 3 and low_strength > 0:
            ends = [math.log(low_strength), math.log(high_strength)]
            size = math.exp(np.interp(math.log(strength), ends, [math.log(low), math.log(high)]))
        elif step < 3:
            size = low + (high - low) * strength / high_strength
        else:
            size = 0.5 * (low + high)
    return best[1]
