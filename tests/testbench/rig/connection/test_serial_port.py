"""A port that fails in the middle of its opening: at first a sentence, later one more trial."""

from __future__ import annotations

import termios

import pytest

from gcode.support.errors import UserError
from testbench.rig.connection import serial_port
from testbench.rig.connection.parts import Chunk, Lost
from testbench.rig.connection.serial_port import SerialLink
from testbench.rig.simulation.pty_port import PtyPort
from tests.testbench.rig.devices import until


@pytest.fixture
def port():
    port = PtyPort()
    yield port
    port.close()


def test_a_baud_rate_that_no_port_has_is_refused_in_a_sentence(port):
    with pytest.raises(UserError, match=f"{port.device}: cannot open this port at {2**40} baud: .*the baud rate"):
        SerialLink(port.device, 2**40)


def test_a_port_that_goes_away_again_while_it_is_opened_is_tried_again(port, monkeypatch):
    """What the terminal's calls raise is no OSError: the reading thread ended, and nothing was heard any more."""
    back, opened, trials = PtyPort(), serial_port.open_port, []

    def open_port(url, baud):
        trials.append(url)
        if len(trials) == 2:
            raise termios.error(5, "Input/output error")
        return opened(back.device if len(trials) > 2 else url, baud)

    monkeypatch.setattr(serial_port, "open_port", open_port)
    link = SerialLink(port.device)
    port.close()
    until(back.has_reader, timeout_s=60.0)
    back.write(b"again")
    parts = []
    for part in link:
        parts.append(part)
        if isinstance(part, Chunk):
            break
    link.close()
    back.close()
    assert [type(part) for part in parts if isinstance(part, Lost | Chunk)] == [Lost, Chunk]
    assert len(trials) == 3
