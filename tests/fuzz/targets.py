"""The fuzz targets: every loader of a file, and the wire. Each takes a case and may answer with a `UserError`."""

from __future__ import annotations

import hashlib
import json
import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from compensation.memories.history import NO_HISTORY
from compensation.model.files import load as load_compensator
from compensation.model.files import save as save_compensator
from compensation.model.streaming import CompensatorStream
from compensation.training.learners import WHOLE
from compensation.training.options import Options
from gcode.mach4.controller import play
from gcode.mach4.reader import parse_program, read_program, read_text
from gcode.programs.made_again import check_file
from gcode.programs.make import make
from gcode.support.errors import UserError
from gcode.trajectories.bounds import Limits
from gcode.trajectories.designed import Hold, Ramp, ReturnToZero
from gcode.trajectories.trajectory import TrajectorySpec, spec_to_toml
from gcode.trajectories.trajectory import read_csv as read_trajectory
from gcode.trajectories.trajectory import read_spec as read_trajectory_spec
from testbench.campaigns.campaign import simulate_campaign
from testbench.campaigns.datasets.index import index_problems
from testbench.campaigns.datasets.spec import read_spec as read_dataset_spec
from testbench.campaigns.datasets.tasks import tasks_of
from testbench.campaigns.record import Job, begin, job_of, record
from testbench.comparing.tables import ladder_table
from testbench.importing.wish import Wish
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import NAME, problems, sealed
from testbench.results.model_file import ModelFile, load_model_file
from testbench.results.result_files import read_diagnosis, read_experiment, read_score
from testbench.rig.acquisition.recorder import Limits as Alarms
from testbench.rig.acquisition.resume import continued, mend
from testbench.rig.connection.parts import Chunk, End
from testbench.rig.protocol.stream import Intake
from tests.compensation.conftest import train
from tests.fuzz import grammars
from tests.testbench.builders import record as record_of
from tests.testbench.builders import truth
from tests.testbench.importing import exports
from tests.testbench.importing.exports import import_csv
from tests.testbench.report.samples import diagnosis, score
from tests.testbench.rig.rigs import plan, program, rig, triangle

HANGS_AFTER_S, SLEEPS_AFTER_S = 30, 600  # of work, which a busy machine does not lengthen; on the clock
LIMITS = Limits(v_max_mm_per_s=5, a_max_mm_per_s2=20, x_min_mm=-1, x_max_mm=10)
SPEC = TrajectorySpec.of(
    Ramp(to_percent=4, speed_mm_per_s=1.0) + Hold(duration_s=2) + ReturnToZero(rest_s=1), name="small"
)
DATASET = 'sensors = ["knit.json"]\nseeds = "1-3"\nprograms = ["two_*.tap"]\ngauge_length_mm = 25\n'
TABLE = b"time_s,displacement_mm,force_N,resistance_ohm\n0.0,0.1,1,400000\n0.1,0.2,1.5,400100\n0.2,0.3,2,400200\n"


class HungError(Exception):
    """A case did not end."""


@contextmanager
def no_hang() -> Iterator[None]:
    """End a case that does not end by itself."""

    def hung(number: int, frame: object) -> None:
        raise HungError

    timers = {
        signal.ITIMER_PROF: (signal.SIGPROF, HANGS_AFTER_S),
        signal.ITIMER_REAL: (signal.SIGALRM, SLEEPS_AFTER_S),
    }
    before = {name: signal.signal(name, hung) for name, _ in timers.values()}
    for timer, (_, seconds) in timers.items():
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        for timer in timers:
            signal.setitimer(timer, 0)
        for name, handler in before.items():
            signal.signal(name, handler)


@cache
def samples() -> dict[str, Any]:
    """Good files of every kind, made once."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    simulate_campaign(plan(folder), folder / "c", triangle(2.0))
    job = Job("/dev/ttyUSB0", 115200, program(folder), 25.0, Alarms())
    begin(job, folder / "r")
    lines = list(rig(duration_s=2.0).lines())
    record(job, folder / "r", [Chunk(0.0, b"".join(lines)), Chunk(0.0, b"garbage\n"), End(1.0, "interrupted")])
    fitted = ModelFile(baseline(), 25.0, "a", "b", FIT, (STEP | {"model": baseline().to_dict()},))
    fitted.save(folder / "model.json")
    return {
        "manifests": tuple(json.loads((folder / name / NAME).read_text()) for name in ("c", "r")),
        "files": {path.name: path.read_bytes() for path in (folder / "r").iterdir()},
        "model": json.loads((folder / "model.json").read_text()),
        "program": make(SPEC, 1, 25.0).program,
    }


@cache
def compensators() -> tuple[dict[str, Any], ...]:
    """Good compensators of both kinds, quickly made; what they predict does not matter."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    found = []
    for history in (NO_HISTORY, WHOLE):
        options = Options(sizes=(2,), restarts=1, engine="fast", history=history)
        made = train([record_of(truth(), 60)], "force", options)
        save_compensator(folder / "c.json", replace(made, margins=(-0.1, 0.1)))
        found.append(json.loads((folder / "c.json").read_text()))
    return tuple(found)


def compensator_sealed(data: dict[str, Any]) -> str:
    """As somebody writes it who knows how the digest is made."""
    bare = {key: value for key, value in data.items() if key != "sha256"}
    digest = hashlib.sha256(json.dumps(bare, sort_keys=True, allow_nan=False).encode()).hexdigest()
    return json.dumps(bare | {"sha256": digest})


@cache
def tables(end: str) -> bytes:
    """A good workbook or TDMS file."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    return {"xlsx": exports.workbook, "tdms": exports.labview}[end](folder).read_bytes()


FIT = {
    "parameters": {"elasticity.stiffness_N": {"value": 5.0, "unit": "N", "standard_error": 0.1}},
    "at_bound": [],
    "unidentified": ["drift.gain"],
    "correlated": [["a", "b", 0.99]],
    "residual_scale": {"force_N": 0.1},
    "iterations": 3,
}
STEP = {
    "step": "baseline",
    "errors": {"calibration": {"force": 0.1}, "held_out": {"force": 0.1}},
    "noise_floor": {"force": 0.01},
}
EXPERIMENT = {
    "rivals": ["creep", "relaxation"],
    "gauge_length_mm": 25.0,
    "options": [
        {"protocol": "noise", "duration_s": 600.0, "log_odds": 3.0, "grade": "decisive", "channel": "force"},
    ],
    "left": {"force": {"time_s": [0.0, 1.0], "over_noise": [0.0, 2.0]}},
}
INDEX = {
    "format": "knitbench-dataset",
    "version": 1,
    "campaigns": [
        {"campaign": "a", "sensor": "s", "program": "p.tap", "seed": 1, "samples": 9, "manifest_sha256": "0" * 64}
    ],
}


def _file(load: Callable[[Path], object], name: str) -> Callable[[Path, bytes | str], None]:
    """A target that writes the case to a file of that name and loads it."""

    def run(folder: Path, case: bytes | str) -> None:
        path = folder / name
        path.write_bytes(case if isinstance(case, bytes) else case.encode("utf-8", "surrogatepass"))
        load(path)

    return run


def _campaign(folder: Path, case: bytes | str) -> None:
    """A manifest is read for every purpose that there is."""
    for name, data in samples()["files"].items():
        (folder / name).write_bytes(data)
    (folder / NAME).write_bytes(case if isinstance(case, bytes) else case.encode("utf-8", "surrogatepass"))
    for use in (problems, job_of, read_recording):
        try:
            use(folder)
        except UserError:
            continue


def _unfinished(folder: Path, case: tuple[str, bytes]) -> None:
    """One file of an unfinished recording is damaged; it is taken up again."""
    for name, data in samples()["files"].items():
        (folder / name).write_bytes(data)
    (folder / case[0]).write_bytes(case[1])
    continued(mend(folder, 0.0), 0.0)
    continued(mend(folder, 0.0), 0.0)


def _program(path: Path) -> None:
    text = read_text(path)
    check_file(text, LIMITS)
    program = parse_program(text)
    for use in (lambda: program.planned(), lambda: play(read_program(text))):
        try:
            use()
        except UserError:
            continue


def _dataset(path: Path) -> None:
    folder = path.parent
    (folder / "knit.json").write_text(json.dumps(baseline().to_dict()))
    program(folder)
    spec = read_dataset_spec(path)
    if len(spec.seeds) < 100 and spec.trajectory is None:
        tasks_of(spec, folder, folder / "out")


def _wire(folder: Path, case: list[bytes]) -> None:
    intake = Intake()
    for number, data in enumerate(case):
        list(intake.feed(data, number * 0.5))
    list(intake.disconnected("end"))
    assert intake.lost >= 0


def _foreign(path: Path) -> None:
    wish = Wish(25.0, {"time": "time_s", "displacement": "displacement_mm", "force": "force_N"})
    import_csv(path, wish)


def _table(path: Path) -> None:
    import_csv(path, Wish(40.0))


def _compensator(path: Path) -> None:
    """One that loads must run: on good readings, and on none."""
    stream = CompensatorStream(load_compensator(path))
    for conductance_S in (1e-6, 2e-6, float("nan"), 0.0, 1e-6):
        stream.update(conductance_S, 0.05)


_catalogue = cache(load_catalogue)
Target = tuple[Callable[[Path, Any], None], Callable[[], st.SearchStrategy]]
TARGETS: dict[str, Target] = {
    "manifest": (
        _campaign,
        lambda: st.one_of(
            grammars.damaged_documents(samples()["manifests"], sealed),
            grammars.damaged_documents(samples()["manifests"]),
            grammars.damaged_bytes(tuple(json.dumps(one).encode() for one in samples()["manifests"])),
        ),
    ),
    "unfinished": (
        _unfinished,
        lambda: st.sampled_from(["recording.csv", "events.jsonl", "recording.bad"]).flatmap(
            lambda name: st.tuples(st.just(name), grammars.damaged_bytes((samples()["files"][name],)))
        ),
    ),
    "events": (
        _unfinished,
        lambda: grammars.damaged_documents(
            tuple(json.loads(line) for line in samples()["files"]["events.jsonl"].splitlines())
        ).map(
            lambda text: (
                "events.jsonl",
                samples()["files"]["events.jsonl"] + text.encode("utf-8", "replace") + b"\n",
            )
        ),
    ),
    "model": (
        _file(lambda path: ladder_table(load_model_file(path, _catalogue())), "model.json"),
        lambda: grammars.damaged_documents((samples()["model"],)),
    ),
    "index": (
        _file(lambda path: index_problems(path.parent), "dataset.json"),
        lambda: grammars.damaged_documents((INDEX,)),
    ),
    "diagnosis": (
        _file(read_diagnosis, "d.json"),
        lambda: grammars.damaged_documents((diagnosis("missing"), diagnosis("unknown"))),
    ),
    "score": (_file(read_score, "s.json"), lambda: grammars.damaged_documents((score(),))),
    "compensator": (
        _file(_compensator, "c.json"),
        lambda: st.one_of(
            grammars.damaged_documents(compensators()), grammars.damaged_documents(compensators(), compensator_sealed)
        ),
    ),
    "experiment": (_file(read_experiment, "e.json"), lambda: grammars.damaged_documents((EXPERIMENT,))),
    "workbook": (_file(_table, "t.xlsx"), lambda: grammars.damaged_bytes((tables("xlsx"),))),
    "tdms": (_file(_table, "t.tdms"), lambda: grammars.damaged_bytes((tables("tdms"),))),
    "dataset spec": (
        _file(_dataset, "set.toml"),
        lambda: grammars.damaged_bytes((DATASET.encode(), VARIED.encode())),
    ),
    "trajectory spec": (
        _file(read_trajectory_spec, "spec.toml"),
        lambda: grammars.damaged_bytes((spec_to_toml(SPEC).encode(),)),
    ),
    "program": (
        _file(_program, "p.tap"),
        lambda: st.one_of(grammars.programs, grammars.damaged_bytes((samples()["program"].encode(),))),
    ),
    "recording": (
        _file(lambda path: read_recording(path, 25.0), "r.csv"),
        lambda: st.one_of(grammars.tables(), grammars.damaged_bytes((TABLE,))),
    ),
    "foreign": (
        _file(_foreign, "f.csv"),
        lambda: st.one_of(grammars.tables(), grammars.damaged_bytes((TABLE, TABLE.decode().encode("utf-16")))),
    ),
    "trajectory": (
        _file(read_trajectory, "t.csv"),
        lambda: st.one_of(grammars.tables(), grammars.damaged_bytes((b"time_s,position_mm\n0,0\n1,2\n2,3\n",))),
    ),
    "wire": (_wire, lambda: grammars.wires),
}
VARIED = DATASET + 'same_sensor = true\nrest_s = 20\n[vary]\n"elasticity.stiffness_N" = [5.0, 9.0]\n'


def attack(name: str, folder: Path, case: Any) -> None:
    """Run one case; anything but an answer or a `UserError` escapes."""
    with no_hang():
        try:
            TARGETS[name][0](folder, case)
        except UserError:
            return
