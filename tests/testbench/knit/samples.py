"""Motions that the tests of the physics share, and what a law of the conductance makes of one."""

from __future__ import annotations

import numpy as np

UP = np.linspace(0, 0.3, 301)
UP_DOWN_UP = np.concatenate([UP, UP[::-1][1:], UP[1:]])
DT_S = 0.05
T = np.arange(0, 100, DT_S)
ONE = np.ones_like(T)
UP_HOLD_DOWN = 0.2 * np.interp(T, [0, 10, 40, 50], [0, 1, 1, 0])


def log_change(effect: object, strain: np.ndarray = UP_HOLD_DOWN) -> np.ndarray:
    """What the effect adds to ln G over the times `T`, shape (n,)."""
    signals = {"strain": strain, "conductance_S": ONE, "time_s": T}
    return np.log(effect.apply(signals, DT_S)["conductance_S"])  # type: ignore[attr-defined]
