"""What changes when a sensor is clamped anew between recordings: each has zeros of its own, which are no findings."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import AdditiveLaw
from testbench.knit.effect import FloatArray, Signals, Stage, Vector, parameter, zeros

MOST_TIME_S = 1e9


class Zeros(AdditiveLaw):
    """Base of the two: by how much each recording but the first, of several in a row, is shifted.

    The parameter has the name of the signal that it shifts.
    """

    in_base = True

    begins_s: Vector = parameter(
        (MOST_TIME_S,), unit="s", low=0, high=MOST_TIME_S, doc="times at which recordings begin, but the first"
    )

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        """The number that belongs to each sample, 0 in the first recording; shape (n,)."""
        values = getattr(self, self.writes[0])
        return np.r_[0.0, values][np.searchsorted(self.begins_s[: len(values)], signals["time_s"], side="right")]

    def put(self, signals: Signals, change: FloatArray) -> dict[str, FloatArray]:
        (name,) = self.writes
        return {name: signals[name] + change}


class DisplacementZeros(Zeros):
    """The zero of the displacement lies elsewhere in each recording, for the sensor was clamped anew.

    e = e_read + d_r        in recording r = 2, 3, ...

    Source: ISO 13934-1:2013 (strip method): the distance between the jaws is set anew for each specimen, within 1 mm.
    Valid: several recordings of one specimen in a row.
    """

    name = "displacement_zeros"
    stage = Stage.KINEMATICS
    reads, writes = ("time_s", "strain"), ("strain",)
    look = "each recording is shifted along the strain against the others"

    strain: Vector = zeros(1, unit="1", most=0.1, typical=0.01, doc="shift of each recording but the first")


class ForceZeros(Zeros):
    """The zero of the load cell lies elsewhere in each recording, for it was tared anew.

    F_read = F + z_r        in recording r = 2, 3, ...

    Source: as the zero of force that is free in every held-out recording (docs/finding-effects.md).
    Valid: several recordings of one specimen in a row.
    """

    name = "force_zeros"
    stage = Stage.READOUT
    reads, writes = ("time_s", "force_N"), ("force_N",)
    look = "each recording is shifted along the force against the others"

    force_N: Vector = zeros(1, unit="N", most=1e3, typical=0.02, doc="shift of each recording but the first")
