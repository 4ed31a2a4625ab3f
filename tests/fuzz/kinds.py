"""Each kind of document that we write and read again: a good one, its loader, and the commands that read it."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from compensation.model.files import load as load_compensator
from gcode.programs.make import read_plan
from gcode.support.strict import load
from testbench.campaigns.datasets.index import index_problems
from testbench.knit.catalogue import load_catalogue
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import NAME, sealed
from testbench.report.figures.experiment_figures import of_file
from testbench.results.model_file import load_model_file
from testbench.results.result_files import read_diagnosis, read_experiment, read_score
from testbench.studio.jobs.outliving import ABOUT, Outliving
from testbench.studio.jobs.pace import Paces
from testbench.studio.notes import FILE, Notes
from testbench.studio.proposed_law import Proposal
from tests.fuzz.targets import DATASET, compensator_sealed
from tests.testbench.builders import record, truth, write_csv
from tests.testbench.report.samples import diagnosis, experiment, score
from tests.testbench.rig.rigs import PROGRAM_TEXT, program
from tests.testbench.studio.proposals import FOUND

RECORDED = "--recording {rec} --gauge-length-mm 25"
ON = "{rec} --gauge-length-mm 25"


class Kind(NamedTuple):
    """A kind of document.

    Attributes
    ----------
    place : str
        Where it lies, below the folder of the good files.
    loader : callable
        Reads the file, and makes of it what a page of the studio does.
    commands : tuple of str
        Those that read it: ``{doc}`` is where it lies, ``{name}`` the good file of that name. The first is quick.
    seal : callable
        As somebody writes it who knows how its digest is made.
    in_folder : bool
        Commands are given the folder that it lies in.
    """

    place: str
    loader: Callable[[Path], object]
    commands: tuple[str, ...] = ()
    seal: Callable[[Any], str] = json.dumps
    in_folder: bool = False


def _experiment_page(path: Path) -> None:
    of_file(read_experiment(path), np.arange(3.0), np.arange(3.0))


def _foretold(path: Path) -> None:
    pace = Paces(path).start(["testbench", "fit"])
    for elapsed_s, note in ((0.0, "reading"), (1.0, "fitting: 2"), (2.0, "fitting: 3")):
        pace.hear(note, None, elapsed_s)
        pace.left_s(elapsed_s)
        pace.done(elapsed_s)


_catalogue = cache(load_catalogue)
KINDS: dict[str, Kind] = {
    "model": Kind(
        "rival.json",
        lambda path: load_model_file(path, _catalogue()),
        (
            "testbench ladder {doc}",
            f"testbench compare {ON} --model {{doc}}",
            f"testbench report {RECORDED} --model {{doc}} -o {{out}}",
            f"testbench fit {ON} --model {{doc}} -o {{out}}",
            "testbench run --program {driven} --sensor {doc} -o {out}",
            f"testbench add load_cell_creep --model {{doc}} --fit {ON} -o {{out}}",
            f"testbench diagnose {ON} --model {{doc}} --repeat 1 --quiet --json {{out}}",
            "testbench experiment {doc} {model} --duration-s 120",
        ),
    ),
    "diagnosis": Kind(
        "diagnosis.json",
        read_diagnosis,
        (
            f"testbench report {RECORDED} --diagnosis {{doc}} -o {{out}}",
            f"testbench experiment --diagnosis {{doc}} --fit {ON} --duration-s 120",
        ),
    ),
    "score": Kind("score.json", read_score, ("testbench report --compensator {doc} -o {out}",)),
    "experiment": Kind("experiment.json", _experiment_page),
    "manifest": Kind(
        f"campaign/{NAME}",
        lambda path: read_recording(path.parent),
        (
            "testbench verify {doc}",
            "testbench compare {doc} --model {rival}",
            "testbench verify --again {doc}",
            "testbench run --program {driven} --sensor pes --after {doc} -o {out}",
        ),
        sealed,
        in_folder=True,
    ),
    "changed manifest": Kind(
        f"campaign/{NAME}", lambda path: read_recording(path.parent), ("testbench verify {doc}",), in_folder=True
    ),
    "list of campaigns": Kind(
        "dataset/dataset.json",
        lambda path: index_problems(path.parent),
        ("testbench verify {doc}",),
        in_folder=True,
    ),
    "compensator": Kind(
        "compensator.json",
        load_compensator,
        (
            "compensation predict {campaign} --compensator {doc} -o {out}",
            "compensation score {doc} {campaign} -o {out}",
            "compensation export {doc} -o {out}",
            "compensation recalibrate {doc} {campaign} -o {out}",
        ),
        compensator_sealed,
    ),
    "plan": Kind("plan/trajectory.json", read_plan),
    "proposal": Kind("proposal.json", lambda path: load(path, Proposal, "proposal")),
    "notes": Kind(FILE, lambda path: Notes(path.parent).all()),
    "job": Kind(ABOUT, lambda path: Outliving(path.parent).last()),
    "paces": Kind("paces.json", _foretold),
}
SAMPLES = {
    "score.json": score(),
    "experiment.json": experiment(),
    "proposal.json": FOUND,
    FILE: {"knit-7": {"tags": ["wet", "PES"], "note": "slipped once"}},
    ABOUT: {"identity": "0123456789abcdef", "title": "Record", "argv": ["testbench", "record"], "pid": 4711},
    "paces.json": {"testbench fit": {"total_s": 20.0, "marks": {"reading": 1.0, "fitting": 4.0}}},
}
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
MODELS = {"model_before": "model", "model_after": "rival"}


def good_files(folder: Path) -> Mapping[str, Path]:
    """Good files of every kind, made by the commands themselves, but for the samples of what takes long."""
    documents = ("model", "rival", "diagnosis", "experiment", "compensator", "score")
    paths = {name: folder / f"{name}.json" for name in documents}
    paths |= {name: folder / name for name in ("campaign", "dataset", "plan", "out")}
    paths |= {"rec": folder / "rec.csv", "driven": folder / "driven.tap", "spec": folder / "spec.toml"}
    write_csv(record(truth(), 60), paths["rec"])
    paths["driven"].write_text(PROGRAM_TEXT.replace("M30", "G1 X5 F120\nG1 X0 F120\n" * 12 + "M30"))
    paths["spec"].write_text(DATASET.replace("knit.json", "model.json").replace("1-3", "1-2"))
    program(folder)
    for name, data in SAMPLES.items():
        (folder / name).write_text(json.dumps(data))
    make(MADE_BY, paths)
    models = {key: json.loads(paths[name].read_text()) for key, name in MODELS.items()}
    paths["diagnosis"].write_text(json.dumps(diagnosis() | models))
    return paths


def make(commands: Sequence[str], paths: Mapping[str, Path]) -> None:
    """Make files as a user does."""
    for command in commands:
        name, *words = command.format(**paths).split()
        assert importlib.import_module(f"{name}.cli").main(words) == 0, command
