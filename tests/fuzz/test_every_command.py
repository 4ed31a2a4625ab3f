"""A share of the attack on every command (`benchmarks/attack_commands.py` runs all of it)."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from attack_commands import COMMANDS, Attack

from compensation import cli as compensation
from gcode import cli as gcode
from testbench import cli as testbench
from tests.fuzz.every_key import chosen

SHARE = 100  # of some 18,000 cases


def test_every_command_is_attacked():
    packages = {"gcode": gcode, "testbench": testbench, "compensation": compensation}
    every = {f"{package} {command}" for package, cli in packages.items() for command in cli.COMMANDS}
    # The studio is a server; hostile folders and addresses of it have tests of their own.
    assert {" ".join(command.split()) for command in COMMANDS} == every - {"testbench studio"}


@pytest.fixture(scope="module")
def attack(tmp_path_factory):
    before, folder = Path.cwd(), tmp_path_factory.mktemp("attack")
    os.chdir(folder)
    yield Attack(folder)
    os.chdir(before)


def faults(attack, some):
    found = {f"{case.command}, {case.wrong!a}": attack.fault(case) for case in some}
    return {case: fault for case, fault in found.items() if fault}


@pytest.mark.slow
def test_what_is_attacked_answers_when_nothing_is_wrong(attack):
    # A call that is refused for another reason never meets the wrong file beside it.
    assert faults(attack, [case for case in attack.cases if case.wrong == "nothing"]) == {}


@pytest.mark.slow
def test_a_wrong_file_or_word_gets_a_sentence(attack):
    some = chosen(attack.cases, SHARE, lambda case: f"{case.command} {case.wrong}")
    assert faults(attack, some) == {}
