"""What a recording shows in a terminal: one line that is redrawn; what must be read stays, whole."""

from __future__ import annotations

import io

from testbench.rig.acquisition.recorder import Status
from testbench.rig.acquisition.status_words import terminal


class Screen(io.StringIO):
    """Something that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_line_is_cut_to_the_terminal_but_a_message_and_the_end_are_whole(monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    monkeypatch.setenv("TERM", "xterm")
    screen = Screen()
    report = terminal("rig", screen)
    for state, message in (("recording", ""), ("recording", "no data"), ("recording", "no data"), ("complete", "")):
        report(Status(60.0, state=state, message=message))
    redrawn, *kept = [line.split("\x1b[K")[-1] for line in screen.getvalue().replace("\n", "\r").split("\r") if line]
    assert redrawn == "rig: 0.0/60 s  0 sa"
    assert kept[0].endswith("! no data")
    assert kept[1] == redrawn
    assert kept[2].endswith("strain 0.000")
    assert screen.getvalue().count("\n") == 2


def test_a_silence_that_goes_on_is_told_once_and_not_each_second(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    for screen in (Screen(), io.StringIO()):
        report = terminal("rig", screen)
        for second in range(3, 60):
            report(Status(60.0, message=f"no bytes for {second} s"))
        assert screen.getvalue().count("\n") == 1
        assert ("no bytes for 59 s" in screen.getvalue()) == screen.isatty()
