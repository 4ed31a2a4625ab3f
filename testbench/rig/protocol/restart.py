"""Tells a device that restarted, under a boot number that was there before, from lines that come late or twice."""

from __future__ import annotations

from dataclasses import dataclass

from testbench.rig.protocol.wire import SEQUENCE_WRAP, Sample

LEAST_LINES, LEAST_US = 8, 1_000_000  # so many refused lines in a row, over so long
MOST_PACE = 1.1  # times the host's: a stored buffer that comes again comes quicker than it was measured


@dataclass
class Restart:
    """Refused lines in a row that agree with each other: the first of them, the last one and how many."""

    _first: tuple[Sample, float] | None = None
    _last: Sample | None = None
    _count: int = 0
    _device_us: int = 0

    def forget(self) -> None:
        """A line was accepted: what was refused before it was late or doubled."""
        self._first, self._last, self._count, self._device_us = None, None, 0, 0

    def sees(self, sample: Sample, host_s: float) -> bool:
        """Take note of a refused line; whether those in a row are by now a device's that restarted.

        They are where number and clock run forward from line to line, no faster than the host's clock.
        """
        if self._first is None or self._last is None or not sample.follows(self._last, SEQUENCE_WRAP // 2):
            self._first, self._count, self._device_us = (sample, host_s), 0, 0
        else:
            self._device_us += sample.since(self._last)[1]
        self._last = sample
        self._count += 1
        host_us = (host_s - self._first[1]) * 1e6
        return self._count >= LEAST_LINES and host_us >= LEAST_US and self._device_us <= MOST_PACE * host_us
