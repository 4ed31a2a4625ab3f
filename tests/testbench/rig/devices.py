"""Real processes on real pseudo-terminals: a device that logs what it sends, and the recorder as a child."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from itertools import pairwise
from multiprocessing import reduction
from pathlib import Path
from typing import Any, NamedTuple

from testbench.cli import main
from testbench.rig.protocol.wire import MICROS_WRAP, Sample, encode
from testbench.rig.simulation.pty_port import PtyPort

MAIN = "import sys; from testbench.cli import main; sys.exit(main())"
CHILDREN: list[subprocess.Popen | Forked] = []
# A server that has imported everything once: a process from it starts in milliseconds, and dies like any other.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["testbench.api.bench.capturing", "testbench.api.bench.serving", "tests.testbench.rig.devices"]
)
BOOT = 0xC0FFEE01
# Starts shortly before a wrap: every test that runs longer than 2 s sees one.
PATIENCE_S = 600.0  # of every wait for another process: it ends early, and a machine may be busy
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

    @property
    def away(self) -> bool:
        """Whether the wire is cut."""
        return self._away > 0

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


class Handle:
    """An open file on its way into a forked process."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __reduce__(self):
        return _arrived, (reduction.DupFd(self.number),)


def _arrived(handle) -> int:
    return handle.detach()


class Forked:
    """A `testbench` command in a process of its own that starts at once and dies like any other; used as a `Popen`.

    What its streams are not given to, `communicate` returns. `before` is called first.
    """

    def __init__(
        self, *words: str, stdout: int | None = None, stderr: int | None = None, before: Callable[[], None] = int
    ) -> None:
        self._kept = [tempfile.TemporaryFile("w+") for _ in range(2)]  # noqa: SIM115
        self._said: list[str] = []
        given = (stdout, stderr)
        handles = [Handle(kept.fileno() if one is None else one) for one, kept in zip(given, self._kept, strict=True)]
        self._process = FORKS.Process(target=_command, args=(words, handles, before), daemon=True)
        self._process.start()
        self.kill = self._process.kill
        CHILDREN.append(self)

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    poll = returncode.fget

    def send_signal(self, number: int) -> None:
        os.kill(self._process.pid, number)

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        self._process.join(timeout)
        assert self.returncode is not None, "waited too long"
        for kept in self._kept:
            with kept:
                kept.seek(0)
                self._said.append(kept.read())
        self._kept = []
        return self._said[0], self._said[1]


def _command(words: tuple[str, ...], handles: list[int], before: Callable[[], None]) -> None:
    for number, handle in enumerate(handles, start=1):
        os.dup2(handle, number)
        os.close(handle)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")  # those that are there were made for other files
    before()
    code = main(words)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):  # as Python does when it ends
            stream.flush()
    os._exit(code)


def recorder(
    folder: Path, port: str, program: Path, *more: str, start: Callable[..., Any] = Forked, **streams
) -> Any:
    """``testbench record`` as a child process, forked or from the beginning (`command`)."""
    return start("record", "--port", port, "--program", str(program), "-o", str(folder), *more, **streams)


class Witness:
    """A process that does nothing but write a line every 5 ms, synced once a second as a recording is.

    How long the machine keeps it from that is how long it may keep a recorder.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._child = FORKS.Process(target=_write_on, args=(path,), daemon=True)

    def __enter__(self) -> Witness:
        self._child.start()
        until(self._path.exists)
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()
        self._child.join()

    def longest_stall_s(self, since_s: float, until_s: float) -> float:
        """The longest time without a line between two instants of `time.monotonic`."""
        text = self._path.read_text()
        times_s = [float(line) for line in text[: text.rfind("\n") + 1].splitlines()]
        around = [times_s[0], *times_s, until_s]
        return max(later - earlier for earlier, later in pairwise(around) if since_s < later <= until_s)


def _write_on(path: Path) -> None:
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def sync() -> None:
        while True:
            time.sleep(1.0)
            os.fsync(handle)

    threading.Thread(target=sync, daemon=True).start()
    while True:
        os.write(handle, f"{time.monotonic()}\n".encode())
        time.sleep(0.005)


def command(*words: str, **popen) -> subprocess.Popen:
    """A `testbench` command as a child process."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    CHILDREN.append(subprocess.Popen([sys.executable, "-c", MAIN, *words], **(pipes | popen)))
    return CHILDREN[-1]


def until(condition, child=None, timeout_s: float = PATIENCE_S) -> None:
    """Wait for something that another process does; fail loudly if it never does."""
    end_s = time.monotonic() + timeout_s
    while not condition():
        if child is not None and child.poll() is not None:
            raise AssertionError(f"the child ended: {child.communicate()}")
        assert time.monotonic() < end_s, "waited too long"
        time.sleep(0.01)
