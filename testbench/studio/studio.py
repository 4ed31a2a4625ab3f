"""What all tabs of one studio share: workspace, jobs, catalogue, memory. All else lives in the tab or in a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from testbench.studio.jobs import JobBoard
from testbench.studio.memory import Memory
from testbench.studio.workspace import Workspace

if TYPE_CHECKING:
    from testbench.knit.catalogue import Catalogue

OWN_EFFECTS = "effects.py"


class Studio:
    """One workspace and its jobs.

    Parameters
    ----------
    root : path
        Folder of campaigns.
    """

    def __init__(self, root: str | Path) -> None:
        self.workspace = Workspace(root)
        self.jobs = JobBoard()
        self.memory = Memory()

    @property
    def effects_file(self) -> Path | None:
        """The user's own effects, where the workspace has some."""
        path = self.workspace.root / OWN_EFFECTS
        return path if path.is_file() else None

    def effects_arguments(self) -> list[str]:
        """``--effects FILE`` where the user has some."""
        return ["--effects", str(self.effects_file)] if self.effects_file else []

    def catalogue(self) -> Catalogue:
        """Built-in effects and the user's own.

        Raises
        ------
        UserError
            If the user's file cannot be loaded.
        """
        from testbench.knit.catalogue import load_catalogue

        return load_catalogue(self.effects_file)
