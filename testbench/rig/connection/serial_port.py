"""pyserial, and nothing else: a link that survives unplugging and never makes the device wait.

A thread of its own reads the port, so that a slow disk cannot make the operating system's small buffer overflow.
"""

from __future__ import annotations

import contextlib
import queue
import re
import termios
import threading
import time
from collections.abc import Iterator

from gcode.support.errors import UserError
from testbench.rig.connection.parts import Chunk, End, Lost, Part, Tick

BAUD = 115200
GIVE_UP_S = 60.0  # until a port that went away is given up
READ_TIMEOUT_S = 0.1
FIRST_WAIT_S, LONGEST_WAIT_S = 0.05, 1.0
# What a port that is not there, not free or not whole raises; pyserial's own error is an OSError.
REFUSALS = (OSError, ValueError, OverflowError, termios.error)


def host_clock_s() -> float:
    """Seconds that never jump and go on while the computer sleeps, as the device's do."""
    if hasattr(time, "CLOCK_BOOTTIME"):
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    return time.monotonic()


def open_port(url: str, baud: int):
    """Open a port for this process alone, without resetting the board.

    An ESP32 board resets when DTR or RTS rise, so both are down before the port opens.

    Raises
    ------
    one of `REFUSALS`
        If it is not there, another process holds it, or it has no such baud rate.
    """
    import serial

    port = serial.serial_for_url(url, do_not_open=True)
    port.baudrate, port.timeout = baud, READ_TIMEOUT_S
    port.dtr = port.rts = False
    port.exclusive = True
    port.open()
    return port


class SerialLink:
    """What a serial port delivers, as parts for the recorder.

    Parameters
    ----------
    url : str
        Device (``/dev/ttyUSB0``) or a pyserial URL (``socket://host:port``).
    baud : int
    give_up_s : float
        How long to wait for a lost port.

    Raises
    ------
    UserError
        If the port cannot be opened at first.
    """

    def __init__(self, url: str, baud: int = BAUD, give_up_s: float = GIVE_UP_S) -> None:
        self._url, self._baud, self._give_up_s = url, baud, give_up_s
        self._parts: queue.SimpleQueue[Part] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._port = self._first_open()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[Part]:
        """Parts as they come; a `Tick` where nothing does, so that the recorder can look at the time."""
        while True:
            try:
                part = self._parts.get(timeout=READ_TIMEOUT_S)
            except queue.Empty:
                part = Tick(host_clock_s())
            yield part
            if isinstance(part, End):
                return

    def close(self) -> None:
        """Stop reading and free the port."""
        self._ended.set()
        self._thread.join(timeout=5.0)

    def _first_open(self):
        try:
            return open_port(self._url, self._baud)
        except REFUSALS as error:
            if "lock" in str(error):
                raise UserError(f"{self._url}: another program holds this port; end it first") from None
            raise UserError(
                f"{self._url}: cannot open this port at {self._baud} baud: {_short(error)}; check its name, the "
                "cable and the baud rate"
            ) from None

    def _read(self) -> None:
        port = self._port
        while port is not None:
            reason = self._drain(port)
            with contextlib.suppress(OSError):
                port.close()
            if reason is None:
                return
            self._parts.put(Lost(host_clock_s(), reason))
            port = self._reopen()

    def _drain(self, port) -> str | None:
        """Read until the link is closed (None) or the port is lost (why)."""
        try:
            while not self._ended.is_set():
                if data := port.read(port.in_waiting or 1):
                    self._parts.put(Chunk(host_clock_s(), data))
        except REFUSALS as error:
            return _short(error)
        return None

    def _reopen(self):
        since_s, wait_s = host_clock_s(), FIRST_WAIT_S
        while host_clock_s() - since_s < self._give_up_s:
            if self._ended.wait(wait_s):
                return None
            try:
                return open_port(self._url, self._baud)
            except REFUSALS:
                wait_s = min(2 * wait_s, LONGEST_WAIT_S)
        gone = f"the port {self._url} did not come back within {self._give_up_s:g} s"
        self._parts.put(End(host_clock_s(), "port lost", gone))
        return None


def _short(error: BaseException) -> str:
    text = str(error.args[-1] if error.args else "")
    if system := re.search(r"\[Errno \d+\] ([^:'\"]+)", text):
        return system[1].strip()
    return text.partition("(")[0].strip().rstrip(":") or type(error).__name__
