"""`record` and `resume_recording`: a campaign from the serial port of a rig."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.files import existing_file
from gcode.support.kinds import instance, number, path_of, whole
from testbench.api.bench.running import CampaignResult
from testbench.campaigns import record as campaigns
from testbench.campaigns.clearing import vacant
from testbench.campaigns.record import Job, job_of, live_compensator
from testbench.recordings.files import check_beside
from testbench.rig.acquisition.recorder import Limits, Report, Status
from testbench.rig.acquisition.status_words import as_dict, as_text
from testbench.rig.acquisition.stopping import stop_signals
from testbench.rig.connection.ports import stated_port
from testbench.rig.connection.serial_port import BAUD, GIVE_UP_S, SerialLink
from testbench.rig.simulation.played import played

Stopped = Callable[[], bool]
LARGEST_STRAIN = 10.0  # nothing is planned beyond 1000 %: a larger limit is one in %, and would never be passed


@dataclass(frozen=True, repr=False)
class RecordResult(CampaignResult):
    """A campaign that was recorded from a port.

    Attributes
    ----------
    folder : Path
        With the recording, the program and the manifest; they hold every sample that was accepted.
    status : Status
        How it ended: its ``state`` is ``complete``, ``interrupted``, or names the trouble that ``message`` tells of.
    """

    status: Status

    def __str__(self) -> str:
        return f"{self.folder}: {self.status.state}: {as_text(self.status)}"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the folder, and the fields of the status."""
        return {"folder": str(self.folder), **as_dict(self.status)}


def record(
    port: str,
    program: str | Path,
    folder: str | Path,
    *,
    gauge_length_mm: float | None = None,
    specimen: str = "",
    max_force_N: float | None = None,
    max_strain: float | None = None,
    baud: int = BAUD,
    give_up_s: float = GIVE_UP_S,
    compensator: str | Path | None = None,
    report: Report = lambda status: None,
    stopped: Stopped | None = None,
) -> RecordResult:
    """Record what the rig on a serial port sends while the machine runs a program, until the motion is over.

    Every sample is on the disk before the next one is looked at: what a crash leaves, `resume_recording` continues.

    Parameters
    ----------
    port : str
        Device (``/dev/ttyUSB0``), ``socket://HOST:PORT`` or ``rfc2217://HOST:PORT``.
    program : path
        The Mach4 program that the machine will run; a copy is kept in the folder.
    folder : path
        Of the campaign; must not exist, or be empty.
    gauge_length_mm : float, optional
        In mm; default: the program's.
    specimen : str
        What is in the clamps; kept in the manifest.
    max_force_N, max_strain : float, optional
        Beyond this force in N, or this strain (0.3: 30 %), the recording ends; default: there is no such limit.
    baud : int
    give_up_s : float
        How long, in s, a lost port may stay away, or a full disk full.
    compensator : path, optional
        Follow the recording with this trained compensator; what it says is kept in ``compensated.csv``.
    report : callable
        Called with a `testbench.rig.acquisition.recorder.Status` while it records and at the end.
    stopped : callable, optional
        Asked whether to end early. Default: Ctrl-C (SIGINT, SIGTERM, SIGHUP) ends the recording well.

    Returns
    -------
    RecordResult

    Raises
    ------
    UserError
        If the folder holds something, the program cannot be played, or the port cannot be opened.

    Examples
    --------
    >>> import tempfile
    >>> import gcode
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = gcode.generate("paper-1", seed=1, duration_s=60).write(folder)
    ...     try:
    ...         tb.record("/dev/no-such-port", f"{folder}/program.tap", f"{folder}/knit-7")
    ...     except tb.UserError as error:
    ...         print(str(error).partition(":")[0])
    /dev/no-such-port
    """
    folder, port = path_of(folder, "folder"), stated_port(port)
    said = {"max_force_N": max_force_N, "max_strain": max_strain}
    limits = Limits(**{name: limit for name, limit in said.items() if limit is not None})
    if LARGEST_STRAIN < limits.max_strain < float("inf"):
        raise UserError(f"max_strain must be at most {LARGEST_STRAIN:g}, got {max_strain:g}; 0.3 stands for 30 %")
    baud, give_up_s = whole("baud", baud, 1), number("give_up_s", give_up_s, 0)
    vacant(folder, origin="")
    program = existing_file(program, "program; make one with `gcode generate`")
    check_beside(program)
    _, gauge = played(program, gauge_length_mm)
    job = Job(port, baud, program, gauge, limits, instance("specimen", specimen, str), give_up_s)
    return _recorded(job, folder, False, compensator, report, stopped)


def resume_recording(
    folder: str | Path,
    port: str | None = None,
    *,
    give_up_s: float = GIVE_UP_S,
    compensator: str | Path | None = None,
    report: Report = lambda status: None,
    stopped: Stopped | None = None,
) -> RecordResult:
    """Continue the unfinished recording in a folder, after a crash or an interruption.

    Parameters
    ----------
    folder : path
        Of the campaign.
    port : str, optional
        Where the device is now; default: where it was.
    give_up_s, compensator, report, stopped
        As for `record`.

    Returns
    -------
    RecordResult

    Raises
    ------
    UserError
        If there is nothing to continue, or the port cannot be opened.

    Examples
    --------
    >>> import tempfile
    >>> import gcode
    >>> import testbench as tb
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = tb.run(tb.preset("pes"), gcode.generate("paper-1", seed=1, duration_s=30), folder)
    ...     try:
    ...         tb.resume_recording(folder)
    ...     except tb.UserError as error:
    ...         print(str(error).partition(": ")[2])
    this campaign was simulated; only a recorded one can be continued
    """
    folder, give_up_s = path_of(folder, "campaign"), number("give_up_s", give_up_s, 0)
    return _recorded(job_of(folder, port, give_up_s), folder, True, compensator, report, stopped)


def _recorded(
    job: Job, folder: Path, resume: bool, compensator: str | Path | None, report: Report, stopped: Stopped | None
) -> RecordResult:
    job = job.prepare()
    with contextlib.ExitStack() as until_the_end:
        live = live_compensator(compensator, folder) if compensator else None
        if live is not None:
            until_the_end.callback(live.close)
        link = SerialLink(job.port, job.baud, job.give_up_s)
        until_the_end.callback(link.close)
        asked = stopped or until_the_end.enter_context(stop_signals())
        if not resume:
            campaigns.begin(job, folder)
        follow = live.follow if live else None
        return RecordResult(folder, campaigns.record(job, folder, link, report, asked, resume, follow=follow))
