"""When a recording is over: the program's duration after the stage began to move, and not while it still moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbench.rig.protocol.items import Row
from testbench.rig.simulation.simulated import Motion

MOVED_MM = 0.2  # from the first reading: more than noise and play of the machine
TAIL_S = 1.0  # recorded after the end of the motion
LONGEST_TIMES = 2.0  # times the planned duration; a stage that moves on for longer is at something else


@dataclass
class EndOfMotion:
    """Finds the end of the motion from the displacement and the clock.

    The recorder starts before the machine does, by however long the operator takes. So the planned duration counts
    from the first movement that is seen, less the time the plan takes to get there. A machine may be slower than
    planned (another acceleration, another feed, a clock of its own): while it moves, the recording goes on.

    Attributes
    ----------
    duration_s : float
        Planned duration.
    first_move_s : float
        When the plan has moved by `MOVED_MM`; infinite if it never does.
    """

    duration_s: float
    first_move_s: float
    _start_nm: int | None = None
    _end_us: float = float("inf")
    _still_nm: int | None = None
    _moved_us: float = float("-inf")

    @classmethod
    def of(cls, motion: Motion) -> EndOfMotion:
        """What to wait for where this motion is planned."""
        moved = np.abs(motion.displacement_mm - motion.displacement_mm[0]) > MOVED_MM
        first_s = float(motion.time_s[moved.argmax()]) if moved.any() else float("inf")
        return cls(motion.duration_s, first_s)

    def __call__(self, row: Row) -> bool:
        """Whether the recording is over with this row."""
        time_us, displacement_nm = row.time_us, row.sample.displacement_nm
        self.watch(time_us, displacement_nm)
        if self._still_nm is None:
            self._still_nm = displacement_nm
        elif abs(displacement_nm - self._still_nm) > MOVED_MM * 1e6:
            self._still_nm, self._moved_us = displacement_nm, time_us
        over_us = time_us - self._end_us
        stands = time_us - self._moved_us >= TAIL_S * 1e6
        return over_us >= 0 and (stands or over_us >= (LONGEST_TIMES - 1) * self.duration_s * 1e6)

    @property
    def waiting(self) -> bool:
        """Whether the stage has not moved yet."""
        return not np.isfinite(self._end_us)

    def watch(self, time_us: int, displacement_nm: int) -> None:
        """Look for the first movement."""
        if self._start_nm is None:
            self._start_nm = displacement_nm
            if not np.isfinite(self.first_move_s):
                self._end_us = time_us + (self.duration_s + TAIL_S) * 1e6
        elif not np.isfinite(self._end_us) and abs(displacement_nm - self._start_nm) > MOVED_MM * 1e6:
            self._end_us = time_us + (self.duration_s - self.first_move_s + TAIL_S) * 1e6
