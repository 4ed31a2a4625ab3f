"""A recorded campaign, from its first byte to its manifest; and its continuation after a crash."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Protocol

from gcode.support.errors import UserError
from gcode.support.files import copy_file, drafted_folder, sha256_of
from testbench.campaigns.campaign import campaign_files, filled
from testbench.campaigns.plan import PROGRAM
from testbench.recordings.manifest import CSV, IN_PROGRESS, NAME, Campaign, read_manifest, write_manifest
from testbench.recordings.stored import EVENTS
from testbench.recordings.versions import software_versions
from testbench.rig.acquisition.appender import held
from testbench.rig.acquisition.ending import EndOfMotion
from testbench.rig.acquisition.recorder import Follow, Limits, Recorder, Report, Status
from testbench.rig.acquisition.resume import continued, mend, watched
from testbench.rig.acquisition.sink import ROOM_BYTES, Sink
from testbench.rig.connection.parts import Part
from testbench.rig.connection.ports import remembered_port, stated_port
from testbench.rig.connection.serial_port import GIVE_UP_S, host_clock_s
from testbench.rig.protocol.items import Event, Row
from testbench.rig.protocol.stream import Intake
from testbench.rig.simulation.played import played
from testbench.rig.simulation.simulated import Motion

LIVE = "knitbench.live"  # group of the entry point of a compensator, which a package above this one has


@dataclass(frozen=True)
class Job:
    """What is to be recorded.

    Attributes
    ----------
    port : str
    baud : int
    program : Path
    gauge_length_mm : float
    limits : Limits
    sensor : str
        A name for the specimen; free text.
    give_up_s : float
        How long a port may stay away, or a disk full.
    """

    port: str
    baud: int
    program: Path
    gauge_length_mm: float
    limits: Limits
    sensor: str = ""
    give_up_s: float = GIVE_UP_S

    @cached_property
    def motion(self) -> Motion:
        """The motion that the controller makes of the program; computed when it is first asked for."""
        return played(self.program, self.gauge_length_mm)[0]

    def prepare(self) -> Job:
        """Load what takes a while before the port is opened: lines that come meanwhile would wait in memory."""
        software_versions()
        _ = self.motion
        return self

    def recipe(self) -> dict[str, Any]:
        """What the manifest keeps of the job."""
        limits = {name: value if value < float("inf") else None for name, value in asdict(self.limits).items()}
        recipe = {"sensor": self.sensor, "port": self.port, "baud": self.baud, **limits}
        return recipe | {"program": PROGRAM, "program_sha256": sha256_of(self.program)}


def begin(job: Job, folder: Path) -> None:
    """Make the campaign folder of a recording that is about to start: all of it or nothing."""
    with drafted_folder(folder) as draft:
        copy_file(job.program, draft / PROGRAM)
        _mark_in_progress(draft, job.gauge_length_mm, job.recipe())


def job_of(folder: Path, port: str | None = None, give_up_s: float = GIVE_UP_S) -> Job:
    """The job of an unfinished recording, from its manifest; `port` where the device is elsewhere now.

    Raises
    ------
    UserError
        If there is nothing to continue.
    """
    campaign, _ = read_manifest(folder)
    if campaign.origin != "recorded":
        raise UserError(f"{folder}: this campaign was {campaign.origin}; only a recorded one can be continued")
    if campaign.status == "complete":
        raise UserError(f"{folder}: this recording is complete; choose another folder for a new one")
    recipe = campaign.recipe
    port = remembered_port(recipe["port"], folder / NAME) if port is None else stated_port(port)
    force_N, strain = recipe["max_force_N"], recipe["max_strain"]
    limits = Limits(*(float("inf") if limit is None else limit for limit in (force_N, strain)))
    program = folder / PROGRAM
    if not program.is_file() or sha256_of(program) != recipe["program_sha256"]:
        raise UserError(f"{program}: missing or not the program that this recording was started with")
    return Job(port, recipe["baud"], program, campaign.gauge_length_mm, limits, recipe["sensor"], give_up_s)


def check_as_begun(folder: Path, said: Mapping[str, Any], program: str | None = None) -> None:
    """Refuse to go on with a recording where it would not do what is said now: it keeps what it began with.

    Parameters
    ----------
    said : mapping
        Of ``gauge_length_mm``, ``specimen``, ``max_force_N``, ``max_strain`` and ``baud``, those that are said.
    program : str, optional

    Raises
    ------
    UserError
    """
    campaign, _ = read_manifest(folder)
    recipe = campaign.recipe
    begun = {
        **recipe,
        "gauge_length_mm": campaign.gauge_length_mm,
        "specimen": recipe.get("sensor"),
        "program": recipe.get("program_sha256"),
    }
    if program is not None:
        said = {**said, "program": sha256_of(Path(program))}
    for name, value in said.items():
        if value != begun.get(name):
            kept = "none" if begun.get(name) is None else begun[name]
            raise UserError(
                f"{name}: this recording goes on as it began, with {kept}; got {value}: leave it out, or begin a new "
                "recording"
            )


def record(
    job: Job,
    folder: Path,
    link: Iterable[Part],
    report: Report = lambda status: None,
    stopped: Callable[[], bool] = lambda: False,
    resume: bool = False,
    clock: Callable[[], float] = host_clock_s,
    pause: Callable[[float], None] = time.sleep,
    follow: Follow | None = None,
) -> Status:
    """Record what `link` delivers into `folder`, which `begin` has made, and write its manifest.

    `follow` sees each row as it is accepted; see `testbench.rig.acquisition.recorder.Recorder`.

    Returns
    -------
    Status
        How it ended, as the manifest says, too. The files hold every accepted sample but those that a full disk never
        took (`unwritten`).

    Raises
    ------
    UserError
        If another recorder is at work in `folder`.
    """
    with held(folder):
        ending, intake, first = EndOfMotion.of(job.motion), Intake(), list[Event]()
        if resume:
            intake, ending, first = _taken_up(job, folder, ending, clock)
        recorder = Recorder(
            intake,
            Sink(folder, ROOM_BYTES),
            job.gauge_length_mm,
            job.limits,
            job.motion.duration_s,
            is_over=ending,
            remark=ending.remark,
            report=report,
            disk_patience_s=job.give_up_s,
            pause=pause,
            follow=follow,
        )
        return filled(folder, "recorded", job.recipe(), recorder, link, stopped, first)


def _taken_up(
    job: Job, folder: Path, ending: EndOfMotion, clock: Callable[[], float]
) -> tuple[Intake, EndOfMotion, list[Event]]:
    """Where an interrupted recording goes on, its files mended, and the event that says so."""
    job_of(folder, job.port)  # another recorder may have finished it since somebody looked
    Sink(folder).close()  # where folders cannot be locked: refuses what is being written, before anything is cut
    now_s = clock()  # reading a day's rows takes a while
    left = mend(folder, time.time())
    intake = continued(left, now_s)
    _mark_in_progress(folder, job.gauge_length_mm, job.recipe())
    event = Event("resume", intake.time_us, {"idle_s": round(left.idle_s, 3)})
    return intake, watched(ending, left), [event]


def _mark_in_progress(folder: Path, gauge_length_mm: float, recipe: dict[str, Any]) -> None:
    campaign = Campaign(gauge_length_mm, "recorded", IN_PROGRESS, recipe, {}, software_versions())
    write_manifest(folder, campaign, [CSV, EVENTS, *(name for name in campaign_files(folder) if name == PROGRAM)])


class Following(Protocol):
    """What a recorder needs of a compensator that follows its recording."""

    def follow(self, row: Row) -> tuple[float, str]:
        """The compensated value after this row, and its unit."""

    def close(self) -> None:
        """Close its file."""


def live_compensator(path: str | Path, folder: str | Path) -> Following:
    """The compensator in `path`, ready to follow a recording into `folder`.

    Raises
    ------
    UserError
        If the file is no compensator, or no package that can run one is installed.
    """
    for point in entry_points(group=LIVE, name="compensator"):
        return point.load()(path, folder)
    raise UserError(
        f"{path}: nothing here can run a compensator; install knitbench anew (`make setup`), so that "
        f"its entry point {LIVE} is known"
    )
