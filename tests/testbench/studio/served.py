"""A studio as users start it, in a process of its own, and Debian's chromium to look at it."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from testbench.studio.tail import Tail

CHROMIUM = Path("/usr/bin/chromium")
STDERR = tempfile.NamedTemporaryFile("ab")  # noqa: SIM115 - of all studios, as long as there are tests
HEARD = Tail(Path(STDERR.name))
CODE = """
import sys
from testbench.studio.pages import live
live.REFRESH_S = float(sys.argv.pop())
from testbench.cli import main
sys.exit(main())
"""


@dataclass(frozen=True)
class Served:
    """A running studio."""

    address: str
    root: Path
    process: subprocess.Popen

    def resident_MB(self) -> float:
        """Memory of the server's process."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        found = re.search(r"VmRSS:\s+(\d+)", status)
        assert found
        return int(found.group(1)) / 1024

    def busy_s(self) -> float:
        """Processor time of the server and of the jobs that have ended, in s of one core: the load does not count."""
        text = Path(f"/proc/{self.process.pid}/stat").read_text()
        ticks = text.rpartition(")")[2].split()[11:15]  # utime, stime, cutime, cstime; proc(5)
        return sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")


@contextmanager
def served(root: Path, refresh_s: float = 0.5) -> Iterator[Served]:
    """Start a studio over `root` on a free port; it must end well on Ctrl-C.

    `refresh_s` is how often the live page looks: benchmarks play an hour faster than it lasts.
    """
    root.mkdir(exist_ok=True)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    process = start_studio(root, port, refresh_s)
    try:
        yield Served(f"http://127.0.0.1:{port}", root, process)
        if process.poll() is not None:
            return  # the test has ended it
        process.send_signal(signal.SIGINT)
        assert process.wait(180) in (0, 130)
    finally:
        process.kill()
        process.wait()
        blame_the_server()


def blame_the_server() -> None:
    """Fail where a studio has printed a traceback since the last call; all that it has printed is passed on."""
    said = "".join(f"{line}\n" for line in HEARD.fresh())
    sys.stderr.write(said)
    assert "Traceback (most recent call last)" not in said, f"the studio's server printed a traceback:\n{said}"


def start_studio(root: Path, port: int, refresh_s: float = 0.5) -> subprocess.Popen:
    """Start the server and wait until it answers."""
    argv = [sys.executable, "-c", CODE, "studio", str(root), "--no-browser", "--port", str(port), str(refresh_s)]
    # NiceGUI behaves differently where it sees pytest in the environment.
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "NICEGUI"))}
    process = subprocess.Popen(argv, cwd=root.parent, env=environment, stderr=STDERR)
    try:
        _wait_for(port, process)
    except BaseException:
        process.kill()
        process.wait()
        blame_the_server()
        raise
    return process


def _wait_for(port: int, process: subprocess.Popen) -> None:
    for _ in range(18_000):
        assert process.poll() is None, "the studio ended at its start; see its words above"
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise AssertionError("the studio did not start within 30 min")


def opened_report(page):
    """The report that the ladder's page makes, in a tab of its own, once its pictures are drawn."""
    page.get_by_role("button", name="Report").click()
    link = page.get_by_role("link", name="Open the report")
    link.wait_for()
    with page.context.expect_page() as opened:
        link.click()
    opened.value.wait_for_selector(".plot[data-drawn] .main-svg")
    return opened.value
