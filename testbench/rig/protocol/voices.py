"""Tells whether two devices talk on one wire: each counts and keeps time for itself, and their lines take turns.

One device counts its lines, so a line of it follows the one before. Where two devices talk, each line follows an
earlier one of its own device instead, turn after turn, whichever of them the recorder takes. A reboot, a lost count
and a clock that jumps begin a new count, too, but the old one does not come back. A line that comes again
says nothing.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field

from testbench.rig.protocol.wire import Sample

TURNS = 16  # from one count to another that was there before, until they are called two devices
MOST_STEP = 8  # a line after so many lost ones still follows; two devices garble each other's lines
MOST_COUNTS = 4  # held at a time
REMEMBERED_LINES = 10_000  # what comes again so many lines late says nothing new


@dataclass
class Voices:
    """The counts that go on at present, each by its last line; the one that spoke last comes last.

    Attributes
    ----------
    boots : tuple of int
        Boot numbers of the two devices that were found talking; empty if it is one, as far as can be told.
    """

    boots: tuple[int, ...] = ()
    _counts: list[Sample] = field(default_factory=list)
    _heard: OrderedDict[Sample, None] = field(default_factory=OrderedDict)
    _turns: int = 0

    def hear(self, sample: Sample) -> bool:
        """Take note of an intact line; whether it proves, for the first time, that two devices talk."""
        if self.boots:
            return False
        following = [one for one in self._counts if sample.follows(one, MOST_STEP)]
        before = min(following, key=lambda one: sample.follows(one, MOST_STEP), default=None)
        if before is None or before is not self._counts[-1]:
            if sample in self._heard:
                return False
            self._turns = self._turns + 1 if before else 0
        if self._turns >= TURNS:
            self.boots = (self._counts[-1].boot, sample.boot)
        others = [one for one in self._counts if one is not before]
        self._counts = [*others[1 - MOST_COUNTS :], sample]
        self._heard[sample] = None
        if len(self._heard) > REMEMBERED_LINES:
            self._heard.popitem(last=False)
        return bool(self.boots)
