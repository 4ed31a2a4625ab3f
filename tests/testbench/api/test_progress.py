"""Progress is shown where somebody watches, and nowhere else."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace

from testbench.api.progress import Telling, _NotebookLine, telling


class Terminal:
    """Something that says it is a terminal."""

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> None:
        self.text += text

    def flush(self) -> None:
        pass


def test_a_callable_is_used_as_it_is_and_false_says_nothing():
    said: list[str] = []
    with telling(said.append) as tell:
        tell("one")
    assert said == ["one"]
    with telling(False) as tell:
        assert tell is None


def test_a_script_sees_nothing(capsys):
    with telling(None) as tell:
        tell("one")
    assert capsys.readouterr() == ("", "")


def test_a_terminal_sees_one_line_that_is_gone_at_the_end(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with telling(None) as tell:
        tell("one")
    assert terminal.text == "\r\x1b[Kone\r\x1b[K"


def test_a_program_gets_json_with_what_is_counted(monkeypatch, capsys):
    monkeypatch.setenv("KNITBENCH_PROGRESS", "json")
    Telling("motion", 3, "imitating")("imitating on noise")
    event = json.loads(capsys.readouterr().err)
    assert event == {"note": "imitating on noise", "unit": "motion", "done": 1, "total": 3}


def test_a_notebook_sees_one_line_written_over(monkeypatch):
    shown: list[str] = []
    handle = SimpleNamespace(update=lambda what: shown.append(what._repr_html_()))
    kernel = type("ZMQInteractiveShell", (), {})()
    ipython = SimpleNamespace(get_ipython=lambda: kernel)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=lambda *a, **k: handle))
    with telling(None) as tell:
        tell("<one>")
    assert shown == ["<small>&lt;one&gt;</small>", "<small></small>"]


def test_a_fork_of_a_kernel_says_nothing_in_the_notebook(monkeypatch):
    """It has no wire to the notebook: Jupyter would warn of each word."""
    said = []
    line = _NotebookLine(lambda shown, display_id: SimpleNamespace(update=lambda html: said.append(html._text)))
    line("screening the catalogue")
    monkeypatch.setattr("os.getpid", lambda: -1)
    line("refitting with stress_relaxation")
    assert said == ["screening the catalogue"]
