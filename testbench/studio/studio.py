"""What all tabs of one studio share: workspace, jobs, own effects, memory. All else lives in the tab or in a file.

In the studio's functions `c` is the name of a campaign, as it stands in the addresses of the pages.
"""

from __future__ import annotations

import time
from pathlib import Path

from gcode.support.disk import append
from gcode.support.files import make_folder
from testbench.studio.deleted import Deleted
from testbench.studio.jobs.job import Job
from testbench.studio.jobs.jobs import JobBoard
from testbench.studio.memory import Memory
from testbench.studio.notes import Notes
from testbench.studio.own_effects import OwnEffects
from testbench.studio.workspace import Workspace

KEY_RECORDING = "record"  # one recording at a time
KEY_RIG = "rig"  # the simulated one, where it is behind the port
RUNNING = "running"  # below results; what is to be known of jobs that outlive the studio
PACES = "paces.json"
RESULTS_URL = "/files"  # below it, the server hands out what was made from the campaigns
KEPT_SKETCHES = 2000
COMMANDS = "commands.txt"
LOGGED = (KEY_RECORDING, "run", "import", "align", "model", "diagnose", "experiment", "propose", "train")
WITH_TARGET = ("train", "export")


def campaign_of(key: str) -> str:
    """The campaign that a job is about: its key is ``kind:campaign``, with the target behind where it has one."""
    kind, _, name = key.partition(":")
    return name.rpartition(":")[0] if kind in WITH_TARGET else name


class Studio:
    """One workspace, `root`, and its jobs."""

    def __init__(self, root: str | Path) -> None:
        self.workspace = Workspace(root)
        outliving = {key: self.workspace.kept(RUNNING, key) for key in (KEY_RECORDING, KEY_RIG)}
        self.jobs = JobBoard(outliving, self.workspace.kept(RUNNING) / PACES, self._log)
        self.memory = Memory()
        self.sketches = Memory(KEPT_SKETCHES)
        self.notes = Notes(self.workspace.kept())
        self.deleted = Deleted(self.workspace, self.notes)
        self.effects = OwnEffects(self.workspace)

    def commands_path(self, name: str) -> Path:
        """The command lines that have been run for a campaign, one a line with its time."""
        return self.workspace.results(name) / COMMANDS

    def make_results(self, key: str) -> str:
        """Make the folder that a job writes its results to; the campaign that it is about, or nothing."""
        name = campaign_of(key)
        if name:
            make_folder(self.workspace.results(name))
        return name

    def _log(self, job: Job) -> None:
        """Keep what was run for a campaign."""
        key = job.key
        if key == KEY_RECORDING:
            key = f"{key}:{self.workspace.name_of(Path(job.argv[-1]))}"
        if key.partition(":")[0] in LOGGED and (name := self.make_results(key)):
            self.keep_command(name, job.command)

    def keep_command(self, name: str, command: str) -> None:
        """Keep a command line that was run for a campaign, or that does what was done for it."""
        append(self.commands_path(name), f"{time.strftime('%Y-%m-%d %H:%M')}  {command}\n")
