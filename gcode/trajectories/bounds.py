"""Limits of a motion, and the sampled quantities that are held against them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from gcode.motion.statistics import differences
from gcode.trajectories.quantities import Positive, SpecModel


class Limits(SpecModel):
    """What the executed motion must not exceed, by finite differences at the trajectory's sample rate.

    Attributes
    ----------
    v_max_mm_per_s, a_max_mm_per_s2 : float
        Largest speed and acceleration, either way.
    j_max_mm_per_s3 : float or None
        Largest jerk; None: any.
    x_min_mm, x_max_mm : float
        Travel of the machine.

    Examples
    --------
    >>> import gcode
    >>> slow = gcode.Limits(v_max_mm_per_s=0.5)
    >>> gcode.check(gcode.generate("paper-1", seed=3, duration_s=60), slow).ok
    False
    """

    v_max_mm_per_s: Positive = 10.0
    a_max_mm_per_s2: Positive = 20.0
    j_max_mm_per_s3: Positive | None = None
    x_min_mm: float = Field(default=-1000.0, allow_inf_nan=False)
    x_max_mm: float = Field(default=1000.0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _ordered(self) -> Any:
        if not self.x_min_mm < self.x_max_mm:
            raise ValueError(f"x_min_mm must be below `x_max_mm`, got {self.x_min_mm:g} and {self.x_max_mm:g}")
        return self


class Excess(NamedTuple):
    """A limit that a sampled motion passes: which, by what, and at which sample it is worst."""

    name: str
    unit: str
    value: float
    limit: float
    sample: int
    samples: int

    def at(self, rate_hz: float) -> str:
        """By how much, when and how often a limit is passed, as part of a message."""
        more = f" (and at {self.samples - 1} more samples)" if self.samples > 1 else ""
        where = f"{self.name} {self.value:.4g} {self.unit} at {self.sample / rate_hz:.2f} s"
        return f"{where} is beyond {self.limit:g} {self.unit}{more}"


def excesses(position_mm: np.ndarray, rate_hz: float, limits: Limits, slack: float = 1e-6) -> list[Excess]:
    """Every limit that positions sampled at `rate_hz` pass by more than the relative `slack`.

    The axis stands still before the first position and after the last one: to start and to stop are accelerations.
    """
    checks = [
        ("speed", "mm/s", limits.v_max_mm_per_s),
        ("acceleration", "mm/s2", limits.a_max_mm_per_s2),
        ("jerk", "mm/s3", limits.j_max_mm_per_s3),
    ]
    found = []
    for before, (name, unit, limit) in enumerate(checks):
        if limit is None:
            continue
        values = np.abs(differences(np.pad(position_mm, before, mode="edge"), rate_hz, before + 1))
        beyond = values > limit * (1 + slack) + 1e-9
        if beyond.any():
            worst = int(values.argmax())
            sample = max(worst - before, 0)
            found.append(Excess(name, unit, float(values[worst]), limit, sample, int(beyond.sum())))
    for sign, limit in ((1.0, limits.x_max_mm), (-1.0, limits.x_min_mm)):
        beyond = sign * (position_mm - limit) > 1e-6
        if beyond.any():
            worst = int((sign * position_mm).argmax())
            found.append(Excess("position", "mm", float(position_mm[worst]), limit, worst, int(beyond.sum())))
    return found
