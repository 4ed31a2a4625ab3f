"""The frame of the commands: how they end, and what their words may be."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

import pytest

import compensation.cli
import gcode.cli
import testbench
import testbench.cli
from gcode.support import console


@pytest.mark.parametrize("where", ["build_parser", "_run"])
def test_ctrl_c_is_a_word_from_the_first_moment_on(where, monkeypatch, capsys):
    def interrupt(*args):
        raise KeyboardInterrupt

    monkeypatch.setattr(console, where, interrupt)
    assert gcode.cli.main(["check", "a.tap", "--v-max", "1", "--a-max", "1", "--x-min", "0", "--x-max", "1"]) == 130
    assert capsys.readouterr().err == "gcode check: interrupted\n"


def test_an_unknown_option_is_told_with_the_command_whose_options_there_are(capsys):
    with pytest.raises(SystemExit, match="2"):
        gcode.cli.main(["play", "a.tap", "-o", "b.csv", "--bogus"])
    assert "gcode play: error: unrecognized arguments: --bogus (see gcode play --help)" in capsys.readouterr().err


def test_too_little_memory_is_a_sentence(monkeypatch, capsys):
    def exhaust(*args):
        raise MemoryError

    monkeypatch.setattr("gcode.mach4.reader.load_program", exhaust)
    assert gcode.cli.main(["play", "a.tap", "-o", "b.csv"]) == 2
    assert "gcode play: error: this needs more memory than there is" in capsys.readouterr().err


def test_a_parameter_of_python_is_told_as_the_option_of_the_command_that_runs(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("time_s,displacement_mm,force_N\n0,0,0\n1,1,1\n2,0,0\n")
    with pytest.raises(testbench.UserError, match="give `gauge_length_mm`"):
        testbench.read(tmp_path / "a.csv")
    assert testbench.cli.main(["fit", str(tmp_path / "a.csv")]) == 2
    assert "give --gauge-length-mm" in capsys.readouterr().err
    (tmp_path / "a.tap").write_text("G21 G90 G94\nG64\nG0 X1\nM30\n")
    words = ["--v-max", "1", "--a-max", "1", "--x-min", "0", "--x-max", "1"]
    assert gcode.cli.main(["check", str(tmp_path / "a.tap"), *words]) == 1
    assert "or state --rapid" in capsys.readouterr().out
    assert "`rapid_mm_per_s`" in str(gcode.check(tmp_path / "a.tap").problems[0])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("gcode play a.tap -o b.csv --rapid 0", "--rapid: Input should be greater than 0"),
        ("gcode check a.tap --v-max 1 --a-max 1 --x-min 2 --x-max 1", "--x-min must be below --x-max, got 2 and 1"),
        ("gcode check a.tap --v-max 1 --a-max 1 --x-min 0 --x-max 1 --rapid -1", "--rapid: Input should be greater"),
        ("gcode generate --preset paper-1 --seed 1 --gauge-length-mm 25 --duration-s 0 -o c", "--duration-s: Input"),
        ("gcode fit --v-mean 0 --v-sd 1 --a-mean 1 --a-sd 1", "--v-mean: Input should be greater than 0"),
        ("testbench investigate pes -o c --budget-minutes 1", "--budget-minutes: 1 min are less than one run of 3"),
        ("testbench investigate pes -o c --sure 2", "--sure: Input should be less than 1, got 2.0"),
        ("testbench ladder model.json", "model.json: no such"),
    ],
)
def test_what_an_error_begins_with_is_told_as_the_option_that_it_is(words, said, tmp_path, monkeypatch, capsys):
    """It was told by its name in Python, behind that of a class: ``Machine: rapid_mm_per_s``."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.tap").write_text("G21 G90 G94\nG64\nG0 X1\nM30\n")
    package, *rest = words.split()
    assert {"gcode": gcode.cli, "testbench": testbench.cli}[package].main(rest) == 2
    assert capsys.readouterr().err.startswith(f"{package} {rest[0]}: error: {said}")


@pytest.mark.parametrize("number", ["0", "-5", "1025", "9" * 20, "2.5", "many"])
@pytest.mark.parametrize(
    ("cli", "words"), [(testbench.cli, "dataset a.toml -o b"), (compensation.cli, "search a b c -o d")]
)
def test_processes_are_1_to_1024(cli, words, number, capsys):
    with pytest.raises(SystemExit, match="2"):
        cli.main([*words.split(), f"--workers={number}"])
    assert f"must be a whole number from 1 to 1024, got '{number}'" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["65536", "-1", "0"])
def test_a_port_is_one_that_can_be_opened(port, capsys):
    with pytest.raises(SystemExit, match="2"):
        testbench.cli.main(["studio", f"--port={port}"])
    assert f"must be a whole number from 1 to 65535, got '{port}'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "said"), [("--seed", "must be a whole number, got 'x'"), ("--v-max", "must be a number, got 'x'")]
)
def test_a_word_for_a_number_is_told_what_is_allowed(option, said, capsys):
    with pytest.raises(SystemExit) as ended:
        gcode.cli.main(["generate", "--preset", "paper-1", option, "x", "-o", "run-1"])
    assert ended.value.code == 2
    assert f"argument {option}: {said}" in capsys.readouterr().err


def test_the_ends_of_a_range_belong_to_it():
    assert [console.whole(1, 7)(text) for text in ("1", "7")] == [1, 7]
    with pytest.raises(argparse.ArgumentTypeError, match="from 1 to 7, got '8'"):
        console.whole(1, 7)("8")


@pytest.mark.parametrize("cli", [gcode.cli, testbench.cli, compensation.cli])
@pytest.mark.parametrize(
    ("name", "text", "allowed"),
    [
        ("SOURCE_DATE_EPOCH", "abc", "0 to 99999999999"),
        ("SOURCE_DATE_EPOCH", "", "0 to 99999999999"),
        ("SOURCE_DATE_EPOCH", "9" * 400, "0 to 99999999999"),
        ("NUMBA_NUM_THREADS", "0", "1 to 1024"),
        ("NUMBA_NUM_THREADS", "-1", "1 to 1024"),
    ],
)
def test_a_number_of_the_environment_that_is_none_is_a_sentence(cli, name, text, allowed, monkeypatch, capsys):
    monkeypatch.setenv(name, text)
    words = {gcode.cli: "play a.tap -o b", testbench.cli: "ladder a.json", compensation.cli: "export a.json -o b"}
    assert cli.main(words[cli].split()) == 2
    said = capsys.readouterr().err
    assert f"error: {name} in the environment must be a whole number from {allowed}, got '{text}'; unset it" in said


def test_numbers_of_the_environment_that_are_some_pass(monkeypatch):
    for name in console.NUMBERS:
        monkeypatch.delenv(name, raising=False)
    console.check_environment()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    console.check_environment()


def test_a_backend_of_matplotlib_that_is_not_there_stops_no_picture(tmp_path):
    what = ["--preset=paper-1", "--seed=1", "--gauge-length-mm=25", "--duration-s=20", "--plot"]
    words = [sys.executable, "-m", "gcode", "generate", *what, "-o", str(tmp_path)]
    there = {**os.environ, "MPLBACKEND": "abc"}
    said = subprocess.run(words, env=there, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert (tmp_path / "trajectory.png").read_bytes().startswith(b"\x89PNG")
