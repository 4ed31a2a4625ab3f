"""What all tabs of one studio share: workspace, jobs, catalogue, memory. All else lives in the tab or in a file.

In the studio's functions `c` is the name of a campaign, as it stands in the addresses of the pages.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from gcode.support.disk import append
from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import read_text
from testbench.studio.deleted import Deleted
from testbench.studio.jobs.job import Job
from testbench.studio.jobs.jobs import JobBoard
from testbench.studio.memory import Memory
from testbench.studio.notes import Notes
from testbench.studio.workspace import Workspace
from testbench.trust import is_trusted, trust

if TYPE_CHECKING:
    from testbench.knit.catalogue import Catalogue

OWN_EFFECTS = "effects.py"
KEY_RECORDING = "record"  # one recording at a time
KEY_RIG = "rig"  # the simulated one, where it is behind the port
RUNNING = "running"  # below results; what is to be known of jobs that outlive the studio
PACES = "paces.json"
RESULTS_URL = "/files"  # below it, the server hands out what was made from the campaigns
KEPT_SKETCHES = 2000
COMMANDS = "commands.txt"
LOGGED = (KEY_RECORDING, "run", "import", "align", "model", "diagnose", "experiment", "propose", "train")
WITH_TARGET = ("train", "export")
MOST_EFFECTS_BYTES = 1 << 20
POINTER = "effects-file.txt"  # below results; one line, the path of the file with own effects


def campaign_of(key: str) -> str:
    """The campaign that a job is about: its key is ``kind:campaign``, with the target behind where it has one."""
    kind, _, name = key.partition(":")
    return name.rpartition(":")[0] if kind in WITH_TARGET else name


class Studio:
    """One workspace and its jobs.

    Parameters
    ----------
    root : path
        Folder of campaigns.
    """

    def __init__(self, root: str | Path) -> None:
        self.workspace = Workspace(root)
        outliving = {key: self.workspace.kept(RUNNING, key) for key in (KEY_RECORDING, KEY_RIG)}
        self.jobs = JobBoard(outliving, self.workspace.kept(RUNNING) / PACES)
        self.memory = Memory()
        self.sketches = Memory(KEPT_SKETCHES)
        self.notes = Notes(self.workspace.kept())
        self.deleted = Deleted(self.workspace, self.notes)
        self.jobs.listeners.append(self._log)

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

    @property
    def effects_path(self) -> Path:
        """Where the user's own effects are, or would be: in the workspace, or in the file that was pointed to."""
        pointer = self._pointer
        if pointer.is_file():
            return Path(read_text(pointer, "name of a file", 4096).strip())
        return self.own_effects

    @property
    def own_effects(self) -> Path:
        """The file of own effects of the workspace itself."""
        return self.workspace.root / OWN_EFFECTS

    @property
    def effects_file(self) -> Path | None:
        """The user's own effects, where there are some."""
        return self.effects_path if self.effects_path.is_file() else None

    @property
    def runnable_effects(self) -> Path | None:
        """The user's own effects, where the user agreed to run them as they are now: they are code."""
        path = self.effects_file
        return path if path is not None and is_trusted(path) else None

    def agree_to_effects(self) -> None:
        """The user agrees to run the file of own effects as it is now."""
        if self.effects_file is not None:
            trust(self.effects_file)

    @property
    def _pointer(self) -> Path:
        return self.workspace.kept(POINTER)

    def point_to(self, path: Path) -> None:
        """Use the own effects in another file, which the workspace remembers, or those of the workspace again.

        Raises
        ------
        UserError
            If it is no Python file, or not text.
        """
        if path == self.own_effects and not path.exists():
            self._pointer.unlink(missing_ok=True)
            return
        if path.suffix != ".py" or not path.is_absolute() or not path.is_file():
            raise UserError(f"{path}: no such Python file; give the full path of a .py file on this machine")
        read_text(path, "file of effects", MOST_EFFECTS_BYTES)
        trust(path)
        make_folder(self._pointer.parent)
        write_text(self._pointer, f"{path.resolve()}\n")

    def effects_arguments(self) -> list[str]:
        """``--effects FILE`` where the user has some, and agreed to run them."""
        path = self.runnable_effects
        return ["--effects", str(path)] if path else []

    def catalogue(self) -> Catalogue:
        """Built-in effects and the user's own.

        Raises
        ------
        UserError
            If the user's file cannot be loaded.
        """
        from testbench.knit.catalogue import load_catalogue

        return load_catalogue(self.runnable_effects)
