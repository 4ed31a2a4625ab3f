"""When a recording is over: the stage has come all of the planned way and stands, or stands too long for a pause."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.rig.protocol.items import Row
from testbench.rig.simulation.simulated import Motion

MOVED_MM = 0.2  # more than noise and play of the machine
STILL_MM = 0.002  # from its end, a plan has ended
TAIL_S = 1.0  # recorded after the end of the motion
LONGEST_TIMES = 2.0  # times the planned duration; a stage that moves on for longer is at something else
WHOLE_WAY = 0.95  # of the planned way: what play, noise and lost lines may take from it
_PLAN_HZ = 20.0  # at which a plan is followed, about as often as a device tells


@dataclass
class Way:
    """How far the stage has come, to and fro, and since when it stands.

    It turns where it comes back by more than `MOVED_MM`, and stands while it stays within as much.

    Attributes
    ----------
    since_us : float
        When it last went on by `MOVED_MM`.
    """

    since_us: float | None = None
    _at_nm: int | None = None
    _before_nm: int = 0  # the way up to the last turn
    _turn_nm: int = 0
    _far_nm: int = 0  # the farthest since then

    @property
    def done_nm(self) -> int:
        """The way up to now."""
        return self._before_nm + abs(self._far_nm - self._turn_nm)

    def follow(self, time_us: int, displacement_nm: int) -> float:
        """See where the stage is now; returns for how long it has stood, in microseconds."""
        if self._at_nm is None:
            self._at_nm = self._turn_nm = self._far_nm = displacement_nm
        if self.since_us is None or abs(displacement_nm - self._at_nm) > MOVED_MM * 1e6:
            self._at_nm, self.since_us = displacement_nm, time_us
        on_nm = displacement_nm - self._far_nm
        if on_nm * (self._far_nm - self._turn_nm) > 0:
            self._far_nm = displacement_nm
        elif abs(on_nm) > MOVED_MM * 1e6:
            self._before_nm, self._turn_nm, self._far_nm = self.done_nm, self._far_nm, displacement_nm
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
    of the planned way, has had the time for its last bit, and has stood there. Where lines were lost, or the machine
    was stopped, it never seems to: then it is over once the stage has stood for longer than any rest of the program
    can last.

    Attributes
    ----------
    duration_s : float
        Planned duration.
    first_move_s : float
        When the plan has moved by `MOVED_MM`; infinite if it never does.
    way_nm, end_nm : int
        The planned way, to and fro, and where it ends, from where it starts.
    longest_rest_s : float
        The longest that the plan may seem to stand before its end: no step of `MOVED_MM`, wherever they begin.
    near_s, last_s : float
        When the plan comes within `MOVED_MM` of its end to stay, and how long it then goes on moving.
    pause_s : float
        The longest that it stays so near before, where what is left of the way may be play and noise.
    """

    duration_s: float
    first_move_s: float
    way_nm: int
    end_nm: int
    longest_rest_s: float
    near_s: float
    last_s: float
    pause_s: float
    _way: Way = field(default_factory=Way)
    _start_nm: int | None = None
    _end_us: float = float("inf")
    _near_us: float | None = None

    @classmethod
    def of(cls, motion: Motion) -> EndOfMotion:
        """What to wait for where this motion is planned."""
        from_start_mm = motion.displacement_mm - motion.displacement_mm[0]
        moved = np.abs(from_start_mm) > MOVED_MM
        first_s = float(motion.time_s[moved.argmax()]) if moved.any() else float("inf")
        planned, done_nm = Way(), []
        times_s = np.append(np.arange(0.0, motion.duration_s, 1 / _PLAN_HZ), motion.duration_s)
        positions_mm = np.interp(times_s, motion.time_s, from_start_mm)
        for time_us, position_nm in zip((1e6 * times_s).tolist(), (1e6 * positions_mm).tolist(), strict=True):
            planned.follow(round(time_us), round(position_nm))
            done_nm.append(planned.done_nm)
        to_go_mm = np.abs(positions_mm - positions_mm[-1])
        near, still = (_last_above(to_go_mm, least_mm) + 1 for least_mm in (MOVED_MM, STILL_MM))
        rest_s = _longest_within(2 * MOVED_MM, positions_mm[:near]) / _PLAN_HZ
        seems_over = (to_go_mm <= MOVED_MM) & (np.array(done_nm) >= WHOLE_WAY**2 * planned.done_nm)
        pause_s = max((len(list(run)) for over, run in groupby(seems_over[:near]) if over), default=0) / _PLAN_HZ
        end_nm = round(1e6 * float(from_start_mm[-1]))
        last_s = (still - near) / _PLAN_HZ
        return cls(motion.duration_s, first_s, planned.done_nm, end_nm, rest_s, near / _PLAN_HZ, last_s, pause_s)

    def __call__(self, row: Row) -> bool:
        """Whether the recording is over with this row."""
        time_us, displacement_nm = row.time_us, row.sample.displacement_nm
        stands_us = self.watch(time_us, displacement_nm)
        over_us = time_us - self._end_us
        if over_us < 0:
            return False
        if over_us >= (LONGEST_TIMES - 1) * self.duration_s * 1e6:
            return True
        if self._way.done_nm >= WHOLE_WAY * self.way_nm and self._near_us is not None:
            wait_s = max(self._time_for_the_last_s(), LONGEST_TIMES * self.pause_s)
            return time_us - self._near_us >= (TAIL_S + wait_s) * 1e6
        return stands_us >= (TAIL_S + LONGEST_TIMES * self.longest_rest_s) * 1e6

    def _time_for_the_last_s(self) -> float:
        """How long this machine, as slow as it was until then, takes for the last bit of the way."""
        begun_us = self._end_us - (self.duration_s + TAIL_S) * 1e6
        slower = ((self._near_us or 0.0) - begun_us) * 1e-6 / max(self.near_s, 1 / _PLAN_HZ)
        return float(np.clip(slower, 1.0, LONGEST_TIMES)) * self.last_s

    def remark(self) -> str:
        """What to say of an end before the planned way was seen, or of one too short to be seen; empty if it was."""
        if not np.isfinite(self.first_move_s):
            return f"a motion below {MOVED_MM:g} mm is not told from standing still: was all of it recorded?"
        done_mm, way_mm = self._way.done_nm / 1e6, self.way_nm / 1e6
        if done_mm >= WHOLE_WAY * way_mm:
            return ""
        return f"the stage was seen to come {done_mm:.1f} mm of the planned {way_mm:.1f} mm: was all of it recorded?"

    @property
    def patience_s(self) -> float:
        """How long a stage may have to stand at its end until that is known to be the end."""
        return TAIL_S + LONGEST_TIMES * max(self.longest_rest_s, self.last_s, self.pause_s)

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
        near = abs(displacement_nm - self._start_nm - self.end_nm) <= MOVED_MM * 1e6
        self._near_us = (time_us if self._near_us is None else self._near_us) if near else None
        return stands_us

    def unseen(self) -> None:
        """Nobody saw the stage for a while, as where an interrupted recording goes on."""
        self._way.unseen()
        self._near_us = None


def _last_above(values: FloatArray, least: float) -> int:
    """The last place where a value is above `least`; -1 if none is."""
    above = np.flatnonzero(values > least)
    return int(above[-1]) if len(above) else -1


def _longest_within(band_mm: float, positions_mm: FloatArray) -> int:
    """The most steps in a row over which a motion stays within a band of this width."""
    longest, first = 0, 0
    highest: deque[int] = deque()  # places of ever lower positions, and of ever higher ones, since the first
    lowest: deque[int] = deque()
    at_mm = positions_mm.tolist()
    for place, here_mm in enumerate(at_mm):
        while highest and at_mm[highest[-1]] <= here_mm:
            highest.pop()
        while lowest and at_mm[lowest[-1]] >= here_mm:
            lowest.pop()
        highest.append(place)
        lowest.append(place)
        while at_mm[highest[0]] - at_mm[lowest[0]] > band_mm:
            first += 1
            for ends in (highest, lowest):
                if ends[0] < first:
                    ends.popleft()
        longest = max(longest, place - first)
    return longest
