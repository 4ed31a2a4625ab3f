"""When a recording is over: the stage has come all of the planned way and stands, or stands too long for a pause."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from testbench.rig.protocol.items import Row
from testbench.rig.simulation.simulated import Motion

MOVED_MM = 0.2  # more than noise and play of the machine
TAIL_S = 1.0  # recorded after the end of the motion
LONGEST_TIMES = 2.0  # times the planned duration; a stage that moves on for longer is at something else
WHOLE_WAY = 0.95  # of the planned way: what play, noise and lost lines may take from it
_PLAN_HZ = 20.0  # at which a plan is followed, about as often as a device tells


@dataclass
class Way:
    """How far the stage has come, to and fro, in steps of more than `MOVED_MM`, and since when it stands.

    Attributes
    ----------
    done_nm : int
    longest_rest_us, since_us : float
        The longest time between two steps, and when the last one was.
    """

    done_nm: int = 0
    longest_rest_us: float = 0.0
    since_us: float | None = None
    _at_nm: int | None = None

    def follow(self, time_us: int, displacement_nm: int) -> float:
        """See where the stage is now; returns for how long it has stood, in microseconds."""
        if self._at_nm is None:
            self._at_nm = displacement_nm
        step_nm = abs(displacement_nm - self._at_nm)
        if step_nm > MOVED_MM * 1e6:
            if self.since_us is not None:
                self.longest_rest_us = max(self.longest_rest_us, time_us - self.since_us)
            self.done_nm, self._at_nm, self.since_us = self.done_nm + step_nm, displacement_nm, time_us
        elif self.since_us is None:
            self.since_us = time_us
        return time_us - self.since_us

    def unseen(self) -> None:
        """Nobody saw the stage for a while: it stands from the next row on, if it stands."""
        self.since_us = None


@dataclass
class EndOfMotion:
    """Finds the end of the motion from the displacement and the clock.

    The recorder starts before the machine does, by however long the operator takes. So the planned duration counts
    from the first movement that is seen, less the time the plan takes to get there. A machine may be slower than
    planned (another acceleration, another feed, a clock of its own): then it is somewhere in the program when the
    planned time is over, perhaps at a hold or a slow reversal. So the recording goes on until the stage has come all
    of the planned way and stands at its end. Where lines were lost, or the machine was stopped, it never seems to:
    then it is over once the stage has stood for longer than any rest of the program can last.

    Attributes
    ----------
    duration_s : float
        Planned duration.
    first_move_s : float
        When the plan has moved by `MOVED_MM`; infinite if it never does.
    way_nm, end_nm : int
        The planned way, to and fro, and where it ends, from where it starts.
    longest_rest_s : float
        The longest that the plan stands, before its end.
    """

    duration_s: float
    first_move_s: float
    way_nm: int
    end_nm: int
    longest_rest_s: float
    _way: Way = field(default_factory=Way)
    _start_nm: int | None = None
    _end_us: float = float("inf")

    @classmethod
    def of(cls, motion: Motion) -> EndOfMotion:
        """What to wait for where this motion is planned."""
        from_start_mm = motion.displacement_mm - motion.displacement_mm[0]
        moved = np.abs(from_start_mm) > MOVED_MM
        first_s = float(motion.time_s[moved.argmax()]) if moved.any() else float("inf")
        planned = Way()
        times_s = np.append(np.arange(0.0, motion.duration_s, 1 / _PLAN_HZ), motion.duration_s)
        positions_mm = np.interp(times_s, motion.time_s, from_start_mm)
        for time_us, position_nm in zip((1e6 * times_s).tolist(), (1e6 * positions_mm).tolist(), strict=True):
            planned.follow(round(time_us), round(position_nm))
        end_nm = round(1e6 * float(from_start_mm[-1]))
        return cls(motion.duration_s, first_s, planned.done_nm, end_nm, planned.longest_rest_us / 1e6)

    def __call__(self, row: Row) -> bool:
        """Whether the recording is over with this row."""
        time_us, displacement_nm = row.time_us, row.sample.displacement_nm
        stands_us = self.watch(time_us, displacement_nm)
        over_us = time_us - self._end_us
        if over_us < 0:
            return False
        if over_us >= (LONGEST_TIMES - 1) * self.duration_s * 1e6:
            return True
        a_rest_s = 0.0 if self._has_arrived(displacement_nm) else LONGEST_TIMES * self.longest_rest_s
        return stands_us >= (TAIL_S + a_rest_s) * 1e6

    def _has_arrived(self, displacement_nm: int) -> bool:
        from_start_nm = displacement_nm - (self._start_nm or 0)
        near = abs(from_start_nm - self.end_nm) <= MOVED_MM * 1e6
        return near and self._way.done_nm >= WHOLE_WAY * self.way_nm

    @property
    def waiting(self) -> bool:
        """Whether the stage has not moved yet."""
        return not np.isfinite(self._end_us)

    def watch(self, time_us: int, displacement_nm: int) -> float:
        """See where the stage is now; at its first movement the planned duration begins. Returns as `Way.follow`."""
        stands_us = self._way.follow(time_us, displacement_nm)
        if self._start_nm is None:
            self._start_nm = displacement_nm
            if not np.isfinite(self.first_move_s):
                self._end_us = time_us + (self.duration_s + TAIL_S) * 1e6
        elif self.waiting and abs(displacement_nm - self._start_nm) > MOVED_MM * 1e6:
            self._end_us = time_us + (self.duration_s - self.first_move_s + TAIL_S) * 1e6
        return stands_us

    def unseen(self) -> None:
        """Nobody saw the stage for a while, as where an interrupted recording goes on."""
        self._way.unseen()
