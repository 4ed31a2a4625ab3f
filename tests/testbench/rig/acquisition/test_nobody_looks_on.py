"""A recording outlives whoever looks on: a reader that has gone or reads no more, a stream that was never open."""

from __future__ import annotations

import fcntl
import os
import signal

import pytest

from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from tests.testbench.rig.devices import PATIENCE_S, Device, command, recorder, until
from tests.testbench.rig.rigs import program

PIPE_BYTES = 4096  # the smallest that a pipe can be made
ROWS = 200  # 1 s: a report that nobody takes, and another one


def rows(folder):
    path = folder / "recording.csv"
    return path.read_text().count("\n") - 1 if path.exists() else 0


def gone():
    """A pipe whose reader has gone."""
    reader, writer = os.pipe()
    os.close(reader)
    return writer


def never_read():
    """A pipe that is full, and that nobody reads."""
    _, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    os.write(writer, bytes(PIPE_BYTES))
    return writer


def full_disk():
    """A log on a disk that is full."""
    return os.open("/dev/full", os.O_WRONLY)


@pytest.mark.parametrize(
    ("nobody", "stream"), [(gone, "stdout"), (never_read, "stdout"), (full_disk, "stderr"), (never_read, "stderr")]
)
def test_a_recording_goes_on_when_nobody_takes_its_progress(tmp_path, nobody, stream):
    folder, wish = tmp_path / "c", program(tmp_path)
    # Without a terminal stderr is written to only where there is something to say, such as a silent port's return.
    more = ["--progress-json"] if stream == "stdout" else []
    with Device(tmp_path / "port") as device:
        child = recorder(folder, device.port.name, wish, *more, **{stream: nobody()})
        until(lambda: rows(folder) > ROWS, child)
        device.unplug(lines=20)
        until(lambda: not device.away, child)
        back = len(device.sent)
        until(lambda: rows(folder) > back, child)
        child.send_signal(signal.SIGTERM)
        child.communicate(timeout=PATIENCE_S)
    assert child.returncode == 0
    assert problems(folder) == []
    assert read_recording(folder).metadata["status"] == "interrupted"


def test_a_stream_that_was_closed_is_not_a_file_of_the_recording(tmp_path):
    """The number of a closed stream is the next file's: what a library says on stderr would land in that file."""
    folder, wish = tmp_path / "c", program(tmp_path)

    def without_streams() -> None:
        for number in (0, 1, 2):
            os.close(number)

    with Device(tmp_path / "port") as device:
        streams = {"stdout": None, "stderr": None, "preexec_fn": without_streams}
        child = recorder(folder, device.port.name, wish, start=command, **streams)
        until(lambda: rows(folder) > 20, child)
        opened = {number: os.readlink(f"/proc/{child.pid}/fd/{number}") for number in (0, 1, 2)}
        child.send_signal(signal.SIGTERM)
        child.wait(timeout=PATIENCE_S)
    assert opened == dict.fromkeys((0, 1, 2), "/dev/null")
    assert child.returncode == 0
    assert problems(folder) == []
