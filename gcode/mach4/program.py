"""Program: a single-axis program as columns, whatever dialect it was written in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gcode.motion.blocks import Blocks
from gcode.support.errors import UserError
from gcode.support.read_only import Unchanging
from gcode.trajectories.trajectory import Trajectory, sampled

MOST_HZ, MOST_STEPS = 10_000.0, 100_000_000  # of a plan; a week at 100 Hz has 60 million


@dataclass(frozen=True)
class Problem:
    """Why a line of a program is refused."""

    line: int
    reason: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


@dataclass(frozen=True, eq=False, repr=False)
class Program(Unchanging):
    """Moves and dwells of a program, one element a block.

    Attributes
    ----------
    line : array of int (n,)
        Line of the file, from 1.
    position_mm : array (n,)
        Where the block ends; a dwell ends where it began.
    feed_mm_per_s : array (n,)
        Programmed speed; inf for a rapid move, nan for a dwell and for a move without a feed.
    dwell_s : array (n,)
        Dwell time; zero for moves.
    steps : array of int (n,)
        How many samples of the planned trajectory the block stands for (our own files; 1 elsewhere).
    exact_stop : array of bool (n,)
        Whether the axis stops at the block's end (G61).
    start_mm : float
        Position before the first block.
    header : mapping
        ``KEY: value`` of the header comments of our own files, keys in lower case.
    problems : tuple of Problem
        What the reader refused.
    unsaid : tuple of str
        Modes that the file leaves to whatever the controller was set to before, as ``G20 or G21``.
    """

    line: np.ndarray
    position_mm: np.ndarray
    feed_mm_per_s: np.ndarray
    dwell_s: np.ndarray
    steps: np.ndarray
    exact_stop: np.ndarray
    start_mm: float = 0.0
    header: Mapping[str, str] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    unsaid: tuple[str, ...] = ()

    def __repr__(self) -> str:
        places = np.append(self.position_mm, self.start_mm)
        refused = f", {len(self.problems)} problem(s)" if self.problems else ""
        return f"<Program {len(self.line)} blocks, {places.min():.3g} to {places.max():.3g} mm{refused}>"

    @property
    def length_mm(self) -> np.ndarray:
        """Signed length of each block."""
        return np.diff(self.position_mm, prepend=self.start_mm)

    def blocks(self, rapid_mm_per_s: float) -> Blocks:
        """The blocks to drive: rapid moves at `rapid_mm_per_s`, all others at their feeds."""
        length = self.length_mm
        speed = np.where(np.isinf(self.feed_mm_per_s), rapid_mm_per_s, self.feed_mm_per_s)
        return Blocks(length, np.where(length != 0, np.nan_to_num(speed), 0.0), self.dwell_s)

    def planned(self) -> Trajectory:
        """The trajectory that one of our own programs was written from, exactly as its decimals say.

        Raises
        ------
        UserError
            If the header does not state the sample rate.
        """
        rate_hz = self.header_number("rate_hz")
        if rate_hz is None:
            raise UserError("program: its header states no RATE_HZ, so its planned time is unknown; use gcode play")
        before = np.concatenate(([self.start_mm], self.position_mm[:-1]))
        if not len(self.line):
            raise UserError("program: it holds no move, so there is no plan in it")
        if not 0 < rate_hz <= MOST_HZ or self.steps.sum() > MOST_STEPS:
            raise UserError(
                f"program: {self.steps.sum()} steps at {rate_hz:g} Hz are no plan of ours; use gcode play"
            )
        count = self.steps + 1
        # A block of k steps waits for k - 1 samples, then moves (a dwell waits for all of them).
        waits = np.column_stack((count - 2, np.ones_like(count))).ravel()
        position = np.repeat(np.column_stack((before, self.position_mm)).ravel(), waits)
        return sampled(np.concatenate(([self.start_mm], position)), rate_hz)

    def header_number(self, key: str) -> float | None:
        """A number of the header, None where it is missing or no finite number."""
        try:
            value = float(self.header[key])
        except (KeyError, ValueError):
            return None
        return value if np.isfinite(value) else None
