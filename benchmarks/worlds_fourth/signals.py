"""One recording's motion, and what passes through the chain of the sensor while it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from worlds_fourth.randoms import Rng, stream

Array = NDArray[Any]

GAUGE_LENGTH_MM = 25.0  # of every specimen


@dataclass
class Record:
    """A recording before the instruments: what the carriage did. All arrays have shape (n,) unless said otherwise.

    Attributes
    ----------
    name : str
        ``calibration`` or ``held_out``.
    seed : int
        Of the sensor; effects that draw anew in every recording draw by it and by the name.
    time_s, displacement_mm, strain, rate_per_s
        Time from the start, where the carriage was, strain by it and its rate.
    plane : ndarray, shape (n, 6)
        Orthonormal columns that the measure of strength takes out (see `strength`).
    drift
        What ln R drifts by.
    kept : dict
        What the chain computed without any effect, so that it need not be computed again.
    """

    name: str
    seed: int
    time_s: Array
    displacement_mm: Array
    strain: Array
    rate_per_s: Array
    plane: Array
    drift: Array
    kept: dict[str, Any] = field(default_factory=dict)

    def stream(self, name: str, *more: str) -> Rng:
        """Random numbers of an effect, the same whenever it acts on this recording."""
        return stream(self.seed, name, self.name, *more)


@dataclass
class State:
    """What the specimen sees and answers with, filled in stage by stage; arrays have shape (n,).

    Attributes
    ----------
    record : Record
    displacement_mm, strain, rate_per_s
        With what the effects did to the motion.
    elastic_N, friction_N, force_N
        Force of the elastic curve, of its friction, and the whole force with the effects on it.
    share
        Strain over the strain at the end of the stroke; compressed below 0.
    """

    record: Record
    displacement_mm: Array
    strain: Array
    rate_per_s: Array = field(init=False)
    elastic_N: Array = field(init=False)
    friction_N: Array = field(init=False)
    force_N: Array = field(init=False)
    share: Array = field(init=False)


# What an effect does at a stage: (state, signal of the stage, size) -> the changed signal.
Hook = Callable[[State, Array, float], Array]
Hooks = Mapping[str, Hook]
