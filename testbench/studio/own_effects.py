"""The user's own effects: code, which is run only where the user has agreed to it as it is now."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import read_text
from testbench.knit.catalogue import Catalogue, load_catalogue
from testbench.studio.workspace import Workspace
from testbench.trust import is_trusted, trust

FILE = "effects.py"
POINTER = "effects-file.txt"  # below results; one line, the path of the file with own effects
MOST_BYTES = 1 << 20


class OwnEffects:
    """The file of own effects that a workspace uses: its own, `here`, or another that it points to."""

    def __init__(self, workspace: Workspace) -> None:
        self.here, self._workspace = workspace.root / FILE, workspace

    @property
    def _pointer(self) -> Path:
        return self._workspace.kept(POINTER)

    @property
    def path(self) -> Path:
        """Where they are, or would be: in the workspace, or in the file that was pointed to."""
        if self._pointer.is_file():
            return Path(read_text(self._pointer, "name of a file", 4096).strip())
        return self.here

    @property
    def file(self) -> Path | None:
        """Where they are; None where there are none."""
        return self.path if self.path.is_file() else None

    @property
    def runnable(self) -> Path | None:
        """As `file`, where the user agreed to run it as it is now."""
        file = self.file
        return file if file is not None and is_trusted(file) else None

    def agree(self) -> None:
        """The user agrees to run the file as it is now."""
        if self.file is not None:
            trust(self.file)

    def text(self) -> str:
        """What the file says; empty where there is none."""
        return read_text(self.file, "file of effects", MOST_BYTES) if self.file else ""

    def point_to(self, path: Path) -> None:
        """Use those in another file, which the workspace remembers, or those of the workspace again.

        Raises
        ------
        UserError
            If it is no Python file, or not text.
        """
        if path == self.here and not path.exists():
            self._pointer.unlink(missing_ok=True)
            return
        if path.suffix != ".py" or not path.is_absolute() or not path.is_file():
            raise UserError(f"{path}: no such Python file; give the full path of a .py file on this machine")
        read_text(path, "file of effects", MOST_BYTES)
        trust(path)
        make_folder(self._pointer.parent)
        write_text(self._pointer, f"{path.resolve()}\n")

    def arguments(self) -> list[str]:
        """``--effects FILE`` where there are some that may be run."""
        file = self.runnable
        return ["--effects", str(file)] if file else []

    def catalogue(self) -> Catalogue:
        """Built-in effects and those of the user that may be run.

        Raises
        ------
        UserError
            If the file cannot be loaded.
        """
        return load_catalogue(self.runnable)
