"""Terminals without a character, streams that are closed, gone or full: an answer or its exit code, always."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest

from gcode.support.streams import redrawn
from testbench.cli import main
from tests.testbench.rig.rigs import program

CHECK = "import sys; from gcode.cli import main; sys.exit(main())"
LIMITS = ["--v-max", "5", "--a-max", "200", "--x-min", "-1", "--x-max", "10"]


@pytest.mark.parametrize(("encoding", "shown"), [("ascii", r"k\u03a9"), ("latin-1", r"k\u03a9"), ("utf-8", "kΩ")])
def test_a_terminal_may_have_few_characters(monkeypatch, encoding, shown):
    stream = io.TextIOWrapper(io.BytesIO(), encoding, write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    with pytest.raises(SystemExit, match="0"):
        main(["report", "--help"])
    assert shown in stream.buffer.getvalue().decode(encoding)


def checked(folder, name, **popen):
    return subprocess.run([sys.executable, "-c", CHECK, "check", str(folder / name), *LIMITS], check=False, **popen)


@pytest.mark.parametrize("closed", [0, 1, 2])
@pytest.mark.parametrize(("name", "code"), [("two_triangles.tap", 0), ("nothing.tap", 2)])
def test_a_closed_stream_changes_no_exit_code(tmp_path, closed, name, code):
    program(tmp_path)
    done = checked(tmp_path, name, capture_output=True, text=True, preexec_fn=lambda: os.close(closed))
    assert done.returncode == code
    assert "Traceback" not in done.stderr


def test_an_error_that_nobody_takes_keeps_its_exit_code(tmp_path):
    with open("/dev/full", "w") as full:
        assert checked(tmp_path, "nothing.tap", stderr=full).returncode == 2


@pytest.mark.parametrize(("name", "code"), [("two_triangles.tap", 0), ("refused.tap", 1)])
def test_a_reader_that_has_gone_changes_no_exit_code(tmp_path, name, code):
    """A refused program passed: ``gcode check ... | head -1`` was 0 whatever it had found."""
    (tmp_path / "refused.tap").write_text(program(tmp_path).read_text().replace("M30", "M3"))
    reader, writer = os.pipe()
    os.close(reader)
    done = checked(tmp_path, name, stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (code, "")


def test_an_answer_that_nobody_takes_is_no_answer(tmp_path):
    program(tmp_path)
    with open("/dev/full", "w") as full:
        done = checked(tmp_path, "two_triangles.tap", stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert done.stderr == "gcode check: error: system: No space left on device\n"


@pytest.mark.parametrize(("term", "shown"), [("xterm", "\r\x1b[Krecor"), ("dumb", "\r     \rrecor")])
def test_a_line_that_is_redrawn_is_no_wider_than_the_terminal(monkeypatch, term, shown):
    monkeypatch.setenv("TERM", term)
    monkeypatch.setenv("COLUMNS", "6")
    assert redrawn("recording: 12 s") == shown
