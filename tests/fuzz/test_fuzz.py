"""Every loader and the wire, attacked: no traceback, no hang, bounded memory. 100,000 cases in the slow suite.

The corpus (``tests/fuzz/corpus/TARGET/``) holds what once broke something; a new finding goes there by hand.
"""

from __future__ import annotations

import json
import os
import random
import resource
import shutil
import warnings
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gcode.mach4.reader import read_text
from gcode.support.errors import UserError
from gcode.trajectories.trajectory import read_csv as read_trajectory
from gcode.trajectories.trajectory import read_spec as read_trajectory_spec
from testbench.campaigns.datasets.spec import read_spec as read_dataset_spec
from testbench.importing.wish import Wish
from testbench.recordings.files import read_recording
from testbench.results.model_file import load_model_file
from testbench.results.result_files import read_diagnosis
from tests.fuzz.targets import (
    EXPERIMENT,
    TARGETS,
    attack,
    compensator_sealed,
    compensators,
    no_hang,
    samples,
    tables,
)
from tests.testbench.importing.exports import import_csv
from tests.testbench.report.samples import diagnosis, score

CORPUS = Path(__file__).parent / "corpus"
QUICK, THOROUGH, MUTANTS = 40, 100_000, 49
PIECES = (
    b"",
    b"9" * 30,
    b"-",
    b"nan",
    b"null",
    b"[",
    b"{",
    b'"',
    b"\n",
    b"\0" * 9,
    b",",
    b"1e999",
    b".",
    b"X",
    b"F0",
)
MOST_MEMORY_BYTES = 1 << 30


def fuzzed(name: str, folder: Path, examples: int, mutants: int = 0) -> None:
    """Attack one target with so many examples of its grammar, and with so many mutants of each."""
    samples()
    place = folder / "case"

    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.data())
    def run(data) -> None:
        nonlocal ran
        case = data.draw(TARGETS[name][1]())
        rng = random.Random(data.draw(st.integers(0, 2**32)) if mutants else 0)
        for number in range(mutants + 1):
            shutil.rmtree(place, ignore_errors=True)
            place.mkdir()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # numbers that overflow on their way to an error
                attack(name, place, mutant(case, rng) if number else case)
            ran += 1

    ran = 0
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    run()
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before
    print(f"\n{name}: {ran} cases, {grown >> 20} MB more memory at most")
    assert grown < MOST_MEMORY_BYTES


GOOD = {
    "model": lambda: json.dumps(samples()["model"]),
    "diagnosis": lambda: json.dumps(diagnosis("missing")),
    "score": lambda: json.dumps(score()),
    "compensator": lambda: compensator_sealed(compensators()[1]),
    "experiment": lambda: json.dumps(EXPERIMENT),
    "workbook": lambda: tables("xlsx"),
    "tdms": lambda: tables("tdms"),
}


@pytest.mark.parametrize("name", GOOD)
def test_what_is_damaged_was_good(name, tmp_path):
    """A sample that its loader refuses would be refused damaged, too, and nothing would have been tried."""
    TARGETS[name][0](tmp_path, GOOD[name]())


def mutant(case, rng: random.Random):
    """The case with some bytes changed, moved, doubled or cut; much quicker than another example."""
    if isinstance(case, tuple):
        return (*case[:-1], mutant(case[-1], rng))
    if isinstance(case, list):
        return [mutant(part, rng) if rng.random() < 0.3 else part for part in case]
    data = bytearray(case.encode("utf-8", "surrogatepass") if isinstance(case, str) else case)
    for _ in range(rng.randint(1, 4)):
        at, other = rng.randint(0, len(data)), rng.randint(0, len(data))
        piece = rng.choice((bytes(data[other : other + rng.randint(1, 30)]), rng.choice(PIECES), rng.randbytes(2)))
        data[at : at + rng.choice((0, 0, 1, 4, 20))] = piece
    return bytes(data)


@pytest.mark.parametrize("name", TARGETS)
def test_damaged_input_gets_a_sentence(name, tmp_path):
    fuzzed(name, tmp_path, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_a_hundred_thousand_damaged_inputs_get_a_sentence_each(name, tmp_path):
    fuzzed(name, tmp_path, THOROUGH // len(TARGETS) // (MUTANTS + 1) + 1, MUTANTS)


@pytest.mark.parametrize("path", sorted(CORPUS.glob("*/*")), ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_once_broke_something_gets_a_sentence(path, tmp_path):
    name = path.parent.name
    data = path.read_bytes()
    whole = path.name.partition(".")[2]
    case = [data] if name == "wire" else (whole, data) if name == "unfinished" else data
    attack(name, tmp_path, case)


def test_what_is_too_large_gets_a_sentence(tmp_path):
    """Cases that would be large files in the corpus."""
    for name, case in {
        "recording": b"time_s,displacement_mm\n0," + b"1" * 200_000 + b"\n1,2\n",
        "foreign": b"time_s,displacement_mm,force_N\n0,1," + b"x" * 200_000 + b"\n1,2,3\n",
        "trajectory": b"time_s,position_mm\n0," + b"1" * 200_000 + b"\n1,2\n",
        "program": b"(" * 2_000_000,
        "dataset spec": b"#" * 2_000_000,
        "trajectory spec": b".".join([b"a"] * 500_000) + b" = 1",
        "model": b"[" + b"[]," * 20_000_000 + b"1]",
        "events": ("events.jsonl", b"{" * 100_000 + b"\n"),
    }.items():
        shutil.rmtree(tmp_path / "case", ignore_errors=True)
        (tmp_path / "case").mkdir()
        attack(name, tmp_path / "case", case)
    wide = ",".join(["time_s", "displacement_mm", "force_N", *(f"c{n}" for n in range(50_000))])
    for name in ("recording", "foreign"):
        attack(name, tmp_path / "case", f"{wide}\n{'1,' * 50_002}1\n{'2,' * 50_002}2\n".encode())


LOADERS = {
    "p.tap": read_text,
    "spec.toml": read_trajectory_spec,
    "set.toml": read_dataset_spec,
    "model.json": load_model_file,
    "d.json": read_diagnosis,
    "r.csv": lambda path: read_recording(path, 25.0),
    "t.csv": read_trajectory,
    "f.csv": lambda path: import_csv(path, Wish(25.0, {"time": "t", "displacement": "x"})),
    "datapackage.json": lambda path: read_recording(path.parent),
}


@pytest.mark.parametrize("name", LOADERS)
def test_a_pipe_is_refused_and_not_waited_for(name, tmp_path):
    os.mkfifo(tmp_path / name)
    with no_hang(), pytest.raises(UserError, match=r"a pipe|not a campaign"):
        LOADERS[name](tmp_path / name)
