"""What a person should be told while a recording runs: silence, lines all rejected, two devices, a wrong clock.

It looks at host times and at the intake's counts after each part of a link. It changes nothing that is recorded.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from testbench.rig.protocol.items import Event
from testbench.rig.protocol.stream import Anchor, Intake

QUIET_S = 3.0  # without a line, and a port is called silent
QUIET_INTERVALS = 5.0  # a device of one line in ten seconds is not silent after three
# Rejected lines are counted over so many seconds and lines at least, and told from this share on.
WATCHED_S, WINDOW_LINES, MOSTLY = 3.0, 10, 0.9
# The clocks of device and host are compared once a minute; told is what differs by 2 %, and by 2 s at least.
CLOCK_S, CLOCK_SHARE, CLOCK_LEAST_S = 60.0, 0.02, 2.0
HINTS = {
    "time stands still": "does the device's clock run?",
    "time runs backwards": "does the device's clock run?",
    "clock jump": "does the device's clock run?",
    "repeated": "does the device count its lines?",
    "other channels": "did the device change what it measures?",
    "other version": "another version of the protocol?",
}


@dataclass
class Watchdog:
    """Watches a recording and says what looks wrong.

    Attributes
    ----------
    message : str
        What a person should know now; empty if all is well.
    before : int
        Lines that earlier recorders accepted: they say nothing of how often one comes now.
    """

    message: str = ""
    before: int = 0
    _began_s: float | None = None
    _bytes_s: float = 0.0
    _line_s: float = 0.0
    _lines: int = 0
    _silent: bool = False
    _window: tuple[float, int, Counter[str]] = field(default_factory=lambda: (0.0, 0, Counter()))
    _rejected: str = ""
    _clock_from: Anchor | None = None
    _clock: str = ""

    def look(self, host_s: float, came: bool, intake: Intake) -> list[Event]:
        """Look at the intake after a part.

        Parameters
        ----------
        host_s : float
            Host time of the part.
        came : bool
            Whether it brought bytes.
        intake : Intake

        Returns
        -------
        list of Event
            What is new to be remembered: ``silent``, ``mostly rejected``, ``clock disagrees``.
        """
        if self._began_s is None:
            self._began_s = self._bytes_s = self._line_s = host_s
            self._window = (host_s, intake.accepted, intake.bad.copy())
        if came:
            self._bytes_s = host_s
        lines = intake.accepted + intake.bad.total()
        if lines != self._lines:
            self._lines, self._line_s = lines, host_s
        found = [*self._silence(host_s, intake), *self._rejections(host_s, intake), *self._clocks(intake)]
        if self._silent:
            self.message = self._quiet_words(host_s)
        else:
            self.message = _two_devices(intake) or self._rejected or self._clock or _bridged(intake)
        return found

    def away(self, host_s: float) -> None:
        """The port is lost, which is said elsewhere: silence counts from its return on."""
        self._bytes_s = self._line_s = host_s
        self._silent, self._clock_from = False, None

    def _silence(self, host_s: float, intake: Intake) -> list[Event]:
        assert self._began_s is not None
        heard = intake.accepted - self.before
        usual_s = (self._line_s - self._began_s) / heard if heard > 1 else 0.0
        was, self._silent = self._silent, host_s - self._line_s > max(QUIET_S, QUIET_INTERVALS * usual_s)
        if was or not self._silent:
            return []
        details: dict[str, object] = {"for_s": round(host_s - self._line_s, 1)}
        return [Event("silent", intake.time_us, details | {"bytes": self._bytes_s > self._line_s})]

    def _quiet_words(self, host_s: float) -> str:
        if self._bytes_s > self._line_s:
            return f"bytes come, but no whole line for {host_s - self._line_s:.0f} s: wrong baud rate?"
        return f"no bytes for {host_s - self._bytes_s:.0f} s: is the device on, and is this its port?"

    def _rejections(self, host_s: float, intake: Intake) -> list[Event]:
        since_s, accepted, bad = self._window
        good, rejected = intake.accepted - accepted, intake.bad - bad
        lines = good + rejected.total()
        if host_s - since_s < WATCHED_S or lines < WINDOW_LINES:
            return []
        self._window = (host_s, intake.accepted, intake.bad.copy())
        share, was = rejected.total() / lines, self._rejected
        if share < MOSTLY:
            self._rejected = ""
            return []
        reason = rejected.most_common(1)[0][0]
        hint = HINTS.get(reason, "wrong baud rate?")
        self._rejected = f"{100 * share:.0f} % of the lines are rejected ({reason}): {hint}"
        return [] if was else [Event("mostly rejected", intake.time_us, {"share": round(share, 3), "reason": reason})]

    def _clocks(self, intake: Intake) -> list[Event]:
        now, start = intake.anchor, self._clock_from
        if now is None or start is None or now.epoch != start.epoch:
            self._clock_from, self._clock = now, "" if now is None or start is None else self._clock
            return []
        host_s, device_s = now.host_s - start.host_s, (now.time_us - start.time_us) / 1e6
        if host_s < CLOCK_S:
            return []
        self._clock_from, was = now, self._clock
        off_s = device_s - host_s
        if abs(off_s) < max(CLOCK_LEAST_S, CLOCK_SHARE * host_s):
            self._clock = ""
            return []
        self._clock = f"the device's clock ran {device_s:.1f} s while the host's ran {host_s:.1f} s"
        details: dict[str, object] = {"device_s": round(device_s, 3), "host_s": round(host_s, 3)}
        return [] if was else [Event("clock disagrees", intake.time_us, details)]


def _two_devices(intake: Intake) -> str:
    """What to say where two devices talk on one wire; said until the end, since what was recorded may be of both."""
    boots = " and ".join(f"{boot:08x}" for boot in intake.voices.boots)
    return boots and f"two devices seem to talk on this wire (boot {boots}): disconnect one and record anew"


def _bridged(intake: Intake) -> str:
    """What to say of a device whose clock was lost, by a jump or by a restart: each is an event, too."""
    times = intake.anchor.epoch if intake.anchor else 0
    if intake.restarts:
        zero = "if its encoder counts from zero, displacement and strain have another zero since"
        return f"the device restarted ({intake.restarts} times): {zero}; stop the machine and record anew"
    return f"the device's clock jumped {times} times: the host's bridged it" if times else ""
