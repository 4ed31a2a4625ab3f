"""The simulated rig on a pseudo-terminal: a port that no recorder can tell from a real one."""

from __future__ import annotations

import contextlib
import os
import select
import time
import tty
from collections.abc import Iterable
from pathlib import Path

from gcode.support.errors import UserError

POLL_S = 0.02


class PtyPort:
    """The device's end of a pseudo-terminal.

    Parameters
    ----------
    link : path, optional
        Symbolic link to the port, for a name that stays the same when the port is closed and opened again.
    """

    def __init__(self, link: str | Path | None = None) -> None:
        self._link = Path(link) if link else None
        self._master, slave = os.openpty()
        self.closed = False
        tty.setraw(slave)
        self.device = os.ttyname(slave)
        # Closed on this side, so that the device can tell whether anybody listens.
        os.close(slave)
        if self._link:
            self._point()

    @property
    def name(self) -> str:
        """What to give to ``testbench record --port``."""
        return str(self._link or self.device)

    def has_reader(self) -> bool:
        """Whether somebody has the port open."""
        poll = select.poll()
        poll.register(self._master, 0)
        return not any(event & select.POLLHUP for _, event in poll.poll(0))

    def wait_for_reader(self, wanted: bool = True) -> None:
        """Return when somebody has opened the port (or, with ``wanted=False``, everybody has closed it)."""
        while self.has_reader() != wanted:
            time.sleep(POLL_S)

    def write(self, data: bytes) -> bool:
        """Send; bytes that nobody listens to are gone, as on a real wire. Whether somebody listened."""
        while data:
            if not self.has_reader():
                return False
            _, ready, _ = select.select([], [self._master], [], POLL_S)
            if ready:
                data = data[os.write(self._master, data) :]
        return True

    def close(self) -> None:
        """Unplug."""
        if self.closed:
            return
        self.closed = True
        os.close(self._master)
        if self._link:
            with contextlib.suppress(FileNotFoundError):
                self._link.unlink()

    def _point(self) -> None:
        assert self._link is not None
        try:
            if self._link.is_symlink():
                self._link.unlink()
            self._link.symlink_to(self.device)
        except OSError as error:
            raise UserError(f"{self._link}: cannot make this link: {error.strerror}; choose another place") from None


def serve(port: PtyPort, lines: Iterable[bytes]) -> int:
    """Send `lines` from the moment somebody listens; return how many were sent while nobody listened."""
    port.wait_for_reader()
    return sum(not port.write(line) for line in lines)
