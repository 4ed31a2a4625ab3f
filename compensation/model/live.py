"""A compensator that follows a recording while it is made, for `testbench record --compensator`."""

from __future__ import annotations

import contextlib
import logging
import os
from pathlib import Path

from compensation.model.files import load
from compensation.model.runtime import STEPS_S, Status
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import TARGETS
from gcode.support import disk
from gcode.support.errors import MOST_SHOWN, UserError
from gcode.support.strict import blocks_of
from testbench.campaigns.campaign import COMPENSATED
from testbench.rig.protocol.items import Row, seconds


class LiveCompensator:
    """Takes one sample after another, and keeps what it makes of them in ``compensated.csv``.

    The columns are those of `compensation predict`: time_s, the target, low and high with its unit (nan where the
    compensator has no interval), status.

    Parameters
    ----------
    path : path
        Of the compensator.
    folder : path
        Of the campaign; the file is appended to. A disk that refuses it ends the file, not the recording.

    Raises
    ------
    UserError
        If the file is no compensator, or one that cannot run sample by sample; if what is kept there already is of
        another target.

    Attributes
    ----------
    unit : str
        "N" or "mm".
    """

    def __init__(self, path: str | Path, folder: str | Path) -> None:
        compensator = load(path)
        self.unit, self._channel = compensator.unit, TARGETS[compensator.target][0]
        self._stream = CompensatorStream(compensator)
        self._folder, self._refused = Path(folder), False
        self._header = f"time_s,{self._channel},low_{self.unit},high_{self.unit},status\n"
        self._check_kept(path)
        self._file: int | None = None
        self._last_us: int | None = None
        self._odd_us: int | None = None

    def _check_kept(self, compensator: str | Path) -> None:
        """Refuse to go on with a table of another target; a first line that a kill left half is cut later."""
        place = self._folder / COMPENSATED
        if not place.is_file():
            return
        first_block = next(blocks_of(place, "compensated signal"), b"")
        kept = b"".join(first_block.splitlines(keepends=True)[:1]).decode(errors="replace")
        if not self._header.startswith(kept):
            raise UserError(
                f"{place}: begins with {kept.strip()[:MOST_SHOWN]!r}, and --compensator {compensator} would go on "
                f"with {self._header.strip()!r}; give the compensator that it was begun with, or none"
            )

    def follow(self, row: Row) -> tuple[float, str]:
        """The value after this row of the recorder, and its unit."""
        return self.take(row.time_us, row.sample.resistance_mohm), self.unit

    def take(self, time_us: int, resistance_mohm: int | None) -> float:
        """Feed one sample: recording time in microseconds, resistance in milliohm (None: no reading).

        Returns
        -------
        float
            In `unit`.
        """
        conductance_S = 1e3 / resistance_mohm if resistance_mohm else 0.0
        value = self._stream.update(conductance_S, self._step_s(time_us))
        if not self._stream.status & (Status.BAD_READING | Status.BAD_STEP):
            self._last_us = time_us
        ends = [f"{value + margin:.6f}" for margin in self._stream.margins or ()] or ["nan", "nan"]
        self._keep(f"{seconds(time_us)},{value:.6f},{','.join(ends)},{int(self._stream.status)}\n")
        return value

    def _step_s(self, time_us: int) -> float | None:
        """Time since the last good sample; None where the stream begins, or begins anew.

        One time out of order is a slip of the clock; a second that follows it says that the clock has moved: after
        a pause of more than an hour, or a restart of the rig, what the memories hold means nothing.
        """
        steps_s = [(time_us - before) * 1e-6 for before in (self._last_us, self._odd_us) if before is not None]
        fits = [STEPS_S[0] <= step_s <= STEPS_S[1] for step_s in steps_s]
        self._odd_us = None if any(fits) or self._last_us is None else time_us
        if fits[1:] == [True] and not fits[0]:
            self._stream.reset()
            return None
        return steps_s[0] if self._last_us is not None else None

    def close(self) -> None:
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _keep(self, line: str) -> None:
        if self._refused:
            return
        try:
            if self._file is None:
                self._file = disk.open_growing(self._folder / COMPENSATED)
                if not _cut_half_line(self._file):
                    line = self._header + line
            disk.write_all(self._file, line.encode())
        except (OSError, UserError) as error:
            self._refused = True
            logging.getLogger("knitbench").warning(
                f"{self._folder / COMPENSATED}: ends here, the recording goes on: {error}"
            )
            if self._file is not None:
                with contextlib.suppress(OSError):
                    _cut_half_line(self._file)


def _cut_half_line(handle: int) -> int:
    """Cut what follows the last line feed: a kill or a full disk left it. The size of the file then."""
    whole = disk.whole_lines_size(handle)
    if whole < os.fstat(handle).st_size:
        disk.DISK.truncate(handle, whole)
    return whole
