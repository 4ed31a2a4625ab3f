"""What a program says that ends it does end it: in the foreground of a terminal, and without one."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import subprocess
import sys
import termios
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from testbench.rig.acquisition.stopping import stop_signals
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


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_without_a_terminal_a_kill_is_named_and_ends_the_rig(tmp_path, number):
    heeds = {"preexec_fn": lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL)}
    with rig(tmp_path, stdin=subprocess.DEVNULL, **heeds) as child:
        assert child.stderr
        assert f"; kill {child.pid} ends the rig" in child.stderr.readline()
        os.kill(child.pid, number)
        ended_as_told(child, tmp_path)


@pytest.fixture
def hang_up():
    """Sets what a hang-up does for the time of a test."""
    before = signal.getsignal(signal.SIGHUP)
    yield lambda handler: signal.signal(signal.SIGHUP, handler)
    signal.signal(signal.SIGHUP, before)


def test_a_hang_up_ends_a_recording_well(hang_up):
    hang_up(signal.SIG_DFL)
    with stop_signals() as asked:
        os.kill(os.getpid(), signal.SIGHUP)
        assert asked()


def test_a_hang_up_that_nohup_ignores_ends_nothing(hang_up):
    hang_up(signal.SIG_IGN)
    with stop_signals() as asked:
        os.kill(os.getpid(), signal.SIGHUP)
        assert not asked()
        os.kill(os.getpid(), signal.SIGTERM)
        assert asked()
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


def test_a_recording_may_run_in_another_thread():
    def record() -> bool:
        with stop_signals() as asked:
            return asked()

    with ThreadPoolExecutor(1) as other:
        assert other.submit(record).result() is False


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
