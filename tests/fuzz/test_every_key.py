"""Each of our own documents with every key changed in every way, read by each command that reads it.

No traceback, no hang, exit code 2 with a sentence; or an answer, where the change is one that is allowed. The quick
suite tries a few mutants of each document, the slow one all of them.
"""

from __future__ import annotations

import importlib
import json
import shutil
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from gcode.programs.stored_plan import read_plan
from gcode.support.errors import UserError
from gcode.support.strict import load
from testbench.fitting.results import read_experiment
from testbench.recordings.manifest import NAME, sealed
from testbench.report.experiment_figures import of_file
from testbench.studio.notes import FILE, Notes
from testbench.studio.outliving import ABOUT, Outliving
from testbench.studio.pace import Paces
from testbench.studio.proposed_law import Proposal
from tests.fuzz.every_key import fault_of, mutants
from tests.fuzz.targets import DATASET, compensator_sealed, no_hang
from tests.testbench.builders import record, truth, write_csv
from tests.testbench.report.samples import diagnosis, experiment, score
from tests.testbench.rig.rigs import PROGRAM_TEXT, program
from tests.testbench.studio.proposals import FOUND

QUICK, SLOW = 8, 200  # mutants of each document: in the quick suite; in the slow one, for what takes seconds
SAMPLES = {"score": score(), "experiment": experiment(), "proposal": FOUND}
MODELS = {"before": "model", "after": "rival"}
MADE_BY = (
    "testbench fit {rec} --gauge-length-mm 25 -o {model}",
    "testbench add stress_relaxation --model {model} --fit {rec} --gauge-length-mm 25 -o {rival}",
    "gcode generate --preset paper-1 --seed 1 --gauge-length-mm 25 --duration-s 60 -o {plan}",
    "testbench run --program {driven} --sensor pes -o {campaign}",
    "testbench dataset {spec} -o {dataset} --workers 1",
    "compensation train {campaign} --target force --hidden 1 --restarts 1 -o {compensator}",
)
SLOWLY_MADE_BY = (
    "testbench diagnose {rec} --gauge-length-mm 25 --json {diagnosis}",
    "testbench experiment {model} {rival} --duration-s 120 --json {experiment}",
    "compensation score {compensator} {campaign} -o {score}",
)
RECORDED = "--recording {rec} --gauge-length-mm 25"
ON = "{rec} --gauge-length-mm 25"
Reader = str | Callable[[Path], object]


class Kind(NamedTuple):
    """A kind of document.

    Attributes
    ----------
    place : str
        Where it is put, below the folder of the good files.
    readers : tuple of str or callable
        Commands that read it (``{place}`` is the good file of that name), or what a page of the studio does with it.
    slow_readers : tuple of str
        Commands that take seconds where the change is allowed; they are given fewer mutants.
    seal : callable
        As somebody writes it who knows how its digest is made.
    """

    place: str
    readers: tuple[Reader, ...]
    slow_readers: tuple[str, ...] = ()
    seal: Callable[[Any], str] = json.dumps


def page_of_experiment(path: Path) -> None:
    """What the studio's page shows of it."""
    of_file(read_experiment(path), np.arange(3.0), np.arange(3.0))


def pace_of_job(path: Path) -> None:
    """What a studio foretells with it."""
    pace = Paces(path).start(["testbench", "fit"])
    for elapsed_s, note in ((0.0, "reading"), (1.0, "fitting: 2"), (2.0, "fitting: 3")):
        pace.hear(note, None, elapsed_s)
        pace.left_s(elapsed_s)
        pace.done(elapsed_s)


def proposed_law(path: Path) -> None:
    """What the studio's page reads of it."""
    load(path, Proposal, "proposal")


KINDS: dict[str, Kind] = {
    "model": Kind(
        "rival.json",
        ("testbench ladder {doc}", f"testbench compare {ON} --model {{doc}}"),
        (
            f"testbench report {RECORDED} --model {{doc}} -o {{out}}",
            f"testbench fit {ON} --model {{doc}} -o {{out}}",
            "gcode generate --preset paper-1 --seed 1 --gauge-length-mm 25 --duration-s 60 -o {plan}",
            "testbench run --program {driven} --sensor {doc} -o {out}",
            f"testbench add hysteresis --model {{doc}} --fit {ON} -o {{out}}",
        ),
    ),
    "diagnosis": Kind(
        "diagnosis.json",
        (f"testbench report {RECORDED} --diagnosis {{doc}} -o {{out}}",),
        (f"testbench experiment --diagnosis {{doc}} --fit {ON} --duration-s 120",),
    ),
    "score": Kind("score.json", ("testbench report --compensator {doc} -o {out}",)),
    "experiment": Kind("experiment.json", (page_of_experiment,)),
    "manifest": Kind(
        f"campaign/{NAME}",
        ("testbench verify {doc}", "testbench compare {doc} --model {rival}"),
        ("testbench verify --again {doc}", "testbench run --program {driven} --sensor pes --after {doc} -o {out}"),
        sealed,
    ),
    "changed manifest": Kind(f"campaign/{NAME}", ("testbench verify {doc}",)),
    "list of campaigns": Kind("dataset/dataset.json", ("testbench verify {doc}",)),
    "compensator": Kind(
        "compensator.json",
        ("compensation predict {campaign} --compensator {doc} -o {out}",),
        (
            "compensation score {doc} {campaign} -o {out}",
            "compensation export {doc} -o {out}",
            "compensation recalibrate {doc} {campaign} -o {out}",
        ),
        compensator_sealed,
    ),
    "plan": Kind("plan/trajectory.json", (read_plan,)),
    "proposal": Kind("proposal.json", (proposed_law,)),
    "notes": Kind(FILE, (lambda path: Notes(path.parent).all(),)),
    "job": Kind(ABOUT, (lambda path: Outliving(path.parent).last(),)),
    "paces": Kind("paces.json", (pace_of_job,)),
}
FOLDERS = {"manifest", "changed manifest", "list of campaigns"}  # what is read is the folder that they lie in
PLAIN = {
    FILE: {"knit-7": {"tags": ["wet", "PES"], "note": "slipped once"}},
    ABOUT: {"identity": "0123456789abcdef", "title": "Record", "argv": ["testbench", "record"], "pid": 4711},
    "paces.json": {"testbench fit": {"total_s": 20.0, "marks": {"reading": 1.0, "fitting": 4.0}}},
}


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Mapping[str, Path]:
    """Good files of every kind, made by the commands themselves, but for the samples of what takes long."""
    folder = tmp_path_factory.mktemp("every-key")
    names = ("model", "rival", "diagnosis", "experiment", "compensator", "score")
    paths = {name: folder / f"{name}.json" for name in names}
    paths |= {"rec": folder / "rec.csv", "driven": folder / "driven.tap", "spec": folder / "spec.toml"}
    paths |= {
        "campaign": folder / "campaign",
        "dataset": folder / "dataset",
        "plan": folder / "plan",
        "out": folder / "out",
    }
    write_csv(record(truth(), 60), paths["rec"])
    paths["driven"].write_text(PROGRAM_TEXT.replace("M30", "G1 X5 F120\nG1 X0 F120\n" * 12 + "M30"))
    paths["spec"].write_text(DATASET.replace("knit.json", "model.json").replace("1-3", "1-2"))
    program(folder)
    for name, data in (*PLAIN.items(), *((f"{name}.json", data) for name, data in SAMPLES.items())):
        (folder / name).write_text(json.dumps(data))
    make(MADE_BY, paths)
    models = {f"model_{when}": json.loads(paths[name].read_text()) for when, name in MODELS.items()}
    paths["diagnosis"].write_text(json.dumps(diagnosis() | models))
    return paths


@pytest.fixture(scope="module")
def all_files(files) -> Mapping[str, Path]:
    """The same without any sample."""
    make(SLOWLY_MADE_BY, files)
    return files


def make(commands: Sequence[str], paths: Mapping[str, Path]) -> None:
    for command in commands:
        name, *words = command.format(**paths).split()
        assert importlib.import_module(f"{name}.cli").main(words) == 0, command


def faults(files: Mapping[str, Path], name: str, readers: Sequence[Reader], most: int = 1_000_000) -> list[str]:
    """What readers do wrong with at most so many mutants."""
    kind = KINDS[name]
    place = files["out"].parent / kind.place
    doc = place.parent if name in FOLDERS else place
    text = place.read_text()
    found = []
    try:
        for mutant in mutants(json.loads(text), kind.seal, most):
            place.write_text(mutant.text)
            for reader in readers:
                if fault := _answer(reader, {**files, "doc": doc}):
                    found.append(f"{mutant.change}: {reader}: {fault}")
    finally:
        place.write_text(text)
    return found


def _answer(reader: Reader, paths: Mapping[str, Path], good: bool = False) -> str:
    shutil.rmtree(paths["out"], ignore_errors=True)
    paths["out"].unlink(missing_ok=True)
    if isinstance(reader, str):
        return fault_of(reader.format(**paths), (0,) if good else (0, 1, 2))
    try:
        with warnings.catch_warnings(), no_hang():
            warnings.simplefilter("ignore")
            reader(paths["doc"])
    except UserError as error:
        return str(error) if good else ""
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:200]}"
    return ""


def refusals(files: Mapping[str, Path], name: str, readers: Sequence[Reader]) -> list[str]:
    """What readers say against the unchanged document: its mutants would be refused, too, and nothing be tried."""
    place = files["out"].parent / KINDS[name].place
    paths = {**files, "doc": place.parent if name in FOLDERS else place}
    return list(filter(None, (_answer(reader, paths, good=True) for reader in readers)))


@pytest.mark.parametrize("name", KINDS)
def test_a_changed_key_gets_a_sentence(files, name):
    assert refusals(files, name, KINDS[name].readers) == []
    assert faults(files, name, KINDS[name].readers, QUICK) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_every_changed_key_gets_a_sentence(all_files, name):
    assert refusals(all_files, name, (*KINDS[name].readers, *KINDS[name].slow_readers)) == []
    assert faults(all_files, name, KINDS[name].readers) == []
    assert faults(all_files, name, KINDS[name].slow_readers, SLOW) == []
