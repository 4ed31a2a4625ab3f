"""What passes through the chain of a sensor, stage by stage, over the time of one recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


@dataclass
class Signals:
    """All arrays have shape (n,). Strains are over the full stroke, forces over the force at its end.

    Attributes
    ----------
    time_s, step_s
        Time from the start, and the step that ends at each sample (the first is 0).
    drive
        Where the carriage was sent to: 0 to 1.
    strain, force, pressure, log_g
        What the specimen sees and answers with; filled in by the chain. ln G is 0 at the end of the stroke.
    room
        Temperature of the room about its mean, of unit spread; nothing feels it but effects of temperature.
    rate_hz, parts
        Samples a second, and steps of the physics for each of them.
    tops
        Largest force, smallest and largest ln G of both recordings without any effect: where an instrument may clip.
    """

    time_s: Array
    drive: Array
    room: Array
    rate_hz: float
    parts: int = 1
    tops: tuple[float, float, float] = (1.0, -1.0, 0.0)
    step_s: Array = field(init=False)
    strain: Array = field(init=False)
    force: Array = field(init=False)
    pressure: Array = field(init=False)
    log_g: Array = field(init=False)

    def __post_init__(self) -> None:
        self.step_s = np.diff(self.time_s, prepend=self.time_s[0])
        self.strain = self.drive.copy()

    @property
    def rate(self) -> Array:
        """Strokes a second, over the sampling step before each sample."""
        return np.diff(self.strain, prepend=self.strain[0]) / np.maximum(self.step_s, 1e-6)

    @property
    def usual_rate(self) -> float:
        """Root mean square of where the carriage was sent to: a scale that no effect changes."""
        ordered = np.diff(self.drive) / self.step_s[1:]
        return float(np.sqrt(np.mean(ordered**2))) + 1e-9

    @property
    def travelled(self) -> Array:
        """Strokes travelled since the start."""
        return np.cumsum(np.abs(np.diff(self.strain, prepend=self.strain[0])))

    @property
    def share_of_time(self) -> Array:
        """0 at the start, 1 at the end of the recording."""
        return self.time_s / self.time_s[-1]
