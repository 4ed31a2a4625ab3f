"""What a program says that ends it does end it: in the foreground of a terminal, and without one."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import subprocess
import sys
import termios
from pathlib import Path

from tests.testbench.rig.devices import MAIN, PATIENCE_S
from tests.testbench.rig.rigs import program


def rig(folder: Path, **popen) -> subprocess.Popen:
    """The simulated rig in a session of its own; nobody listens to it."""
    words = ["rig", "--sensor", "pes", "--program", str(program(folder)), "--link", str(folder / "port")]
    argv = [sys.executable, "-c", MAIN, *words]
    return subprocess.Popen(
        argv, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **popen
    )


def ended_as_told(child: subprocess.Popen, folder: Path) -> None:
    try:
        _, words = child.communicate(timeout=PATIENCE_S)
    finally:
        child.kill()  # leaving the block waits for it, for ever if it was not told
    assert child.returncode == 130, words
    assert not (folder / "port").exists(), "the link stays behind"


def test_without_a_terminal_a_kill_is_named_and_ends_the_rig(tmp_path):
    with rig(tmp_path, stdin=subprocess.DEVNULL) as child:
        assert child.stderr
        assert f"; kill {child.pid} ends the rig" in child.stderr.readline()
        os.kill(child.pid, signal.SIGTERM)
        ended_as_told(child, tmp_path)


def test_in_the_foreground_of_a_terminal_it_is_ctrl_c(tmp_path):
    screen, keyboard = pty.openpty()

    def take_the_terminal() -> None:
        fcntl.ioctl(keyboard, termios.TIOCSCTTY, 0)
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # ignored where these tests run behind a shell's `&`

    with rig(tmp_path, stdin=keyboard, preexec_fn=take_the_terminal) as child:
        assert child.stderr
        assert "; Ctrl-C ends the rig" in child.stderr.readline()
        os.write(screen, b"\x03")
        ended_as_told(child, tmp_path)
    os.close(keyboard)
    os.close(screen)


def test_where_ctrl_c_is_ignored_it_is_a_kill(tmp_path):
    screen, keyboard = pty.openpty()

    def take_the_terminal() -> None:
        fcntl.ioctl(keyboard, termios.TIOCSCTTY, 0)
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    with rig(tmp_path, stdin=keyboard, preexec_fn=take_the_terminal) as child:
        assert child.stderr
        assert f"; kill {child.pid} ends the rig" in child.stderr.readline()
        os.kill(child.pid, signal.SIGTERM)
        ended_as_told(child, tmp_path)
    os.close(keyboard)
    os.close(screen)
