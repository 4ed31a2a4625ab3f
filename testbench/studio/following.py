"""Following a recording while it grows: the last minute in full, all that came before as an envelope.

Memory stays flat however long the recording runs: the envelope has a fixed number of buckets, and when they are
full, neighbours are merged and each new one covers twice the time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.studio.tail import Tail

RECENT_S = 60.0
BUCKETS = 512


class Follower:
    """Reads what has been appended to a ``recording.csv`` since the last look; it may not be there yet."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.names: list[str] = []
        self.recent: FloatArray = np.empty((0, 0))
        self.envelope: Envelope | None = None
        self._tail = Tail(path)

    def look(self) -> bool:
        """Take in what is new; False when nothing is."""
        lines = self._tail.fresh()
        if not self.names and lines:
            self.names = lines.pop(0).split(",")
        rows = [line.split(",") for line in lines]
        rows = [row for row in rows if len(row) == len(self.names)]
        if not rows:
            return False
        fresh = np.array(rows, dtype=np.float64)
        self.recent = np.concatenate([self.recent, fresh]) if self.envelope else fresh
        self.envelope = self.envelope or Envelope(len(self.names))
        self.envelope.add(fresh)
        first = np.searchsorted(self.recent[:, 0], self.recent[-1, 0] - RECENT_S)
        self.recent = self.recent[first:]
        return True

    def channel(self, name: str) -> FloatArray | None:
        """The last minute of a channel, shape (n,); None where it is not recorded."""
        return self.recent[:, self.names.index(name)] if name in self.names and len(self.recent) else None


class Envelope:
    """Lowest and highest value of each of so many columns (time first) in each of a fixed number of buckets."""

    def __init__(self, columns: int) -> None:
        self.low = np.full((BUCKETS, columns), np.inf)
        self.high = np.full((BUCKETS, columns), -np.inf)
        self.used = 0  # buckets begun
        self.width = 1  # samples a bucket
        self._filled = 0  # samples in the last bucket

    def add(self, rows: FloatArray) -> None:
        """Take in samples, shape (n, columns)."""
        while len(rows):
            if self.used == 0 or self._filled == self.width:
                if self.used == BUCKETS:
                    self._halve()
                self.used, self._filled = self.used + 1, 0
            part = rows[: self.width - self._filled]
            last = self.used - 1
            self.low[last] = np.minimum(self.low[last], part.min(axis=0))
            self.high[last] = np.maximum(self.high[last], part.max(axis=0))
            self._filled += len(part)
            rows = rows[len(part) :]

    def _halve(self) -> None:
        half = BUCKETS // 2
        for array, merge, blank in ((self.low, np.minimum, np.inf), (self.high, np.maximum, -np.inf)):
            array[:half] = merge(array[0::2], array[1::2])
            array[half:] = blank
        self.used, self.width = half, 2 * self.width

    def outline(self, column: int) -> tuple[FloatArray, FloatArray]:
        """Time and value of the outline: low, high, low, high, ..., each shape (2 x buckets,)."""
        time_s = np.repeat(self.low[: self.used, 0], 2)
        values = np.column_stack([self.low[: self.used, column], self.high[: self.used, column]]).ravel()
        return time_s, values
