"""Real processes on real pseudo-terminals: a device that logs what it sends, and the recorder as a child."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

from testbench.rig.pty_port import PtyPort
from testbench.rig.wire import MICROS_WRAP, Sample, encode

MAIN = "import sys; from testbench.cli import main; sys.exit(main())"
CHILDREN: list[subprocess.Popen] = []
BOOT = 0xC0FFEE01
# Starts shortly before a wrap: every test that runs longer than 2 s sees one.
FIRST_MICROS = MICROS_WRAP - 2_000_000


class Sent(NamedTuple):
    """A line that a device sent: when, what, and whether somebody had the port open."""

    host_s: float
    sample: Sample
    heard: bool


class Device:
    """Sends a sample every 5 ms of real time, whether anybody listens or not, and remembers each."""

    def __init__(self, link: Path, step_s: float = 0.005) -> None:
        self.port, self.sent, self._step_s = PtyPort(link), [], step_s
        self._link, self._away = link, 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Device:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self.port.close()

    def unplug(self, lines: int) -> None:
        """Cut the wire in the middle of a line; plug in again `lines` later."""
        self._away = lines

    def _send(self, line: bytes) -> bool:
        if not self._away:
            return self.port.write(line)
        self._away -= 1
        if not self.port.closed:
            self.port.write(line[:20])
            self.port.close()
        elif not self._away:
            self.port = PtyPort(self._link)
        return False

    def _run(self) -> None:
        start_s = time.monotonic()
        while not self._ended.wait(max(0.0, start_s + len(self.sent) * self._step_s - time.monotonic())):
            number = len(self.sent)
            micros = (FIRST_MICROS + round((time.monotonic() - start_s) * 1e6)) % MICROS_WRAP
            sample = Sample(BOOT, number, micros, 1_000_000 + number, 400_000_000 + number, 0)
            heard = self._send(encode(sample))
            self.sent.append(Sent(time.monotonic(), sample, heard))


def recorder(folder: Path, port: str, program: Path, *more: str, **popen) -> subprocess.Popen:
    """``testbench record`` as a child process."""
    words = ["record", "--port", port, "--program", str(program), "-o", str(folder), *more]
    return command(*words, **popen)


def command(*words: str, **popen) -> subprocess.Popen:
    """A `testbench` command as a child process."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    CHILDREN.append(subprocess.Popen([sys.executable, "-c", MAIN, *words], **(pipes | popen)))
    return CHILDREN[-1]


def until(condition, child: subprocess.Popen | None = None, timeout_s: float = 60.0) -> None:
    """Wait for something that another process does; fail loudly if it never does."""
    end_s = time.monotonic() + timeout_s
    while not condition():
        if child is not None and child.poll() is not None:
            raise AssertionError(f"the child ended: {child.communicate()}")
        assert time.monotonic() < end_s, "waited too long"
        time.sleep(0.01)
