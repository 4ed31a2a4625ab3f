"""The folder a studio works in: which campaigns are there, whether they are intact, where results are kept."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import read_json
from testbench.recording import Recording, read_recording
from testbench.studio.memory import Memory, stamp

MANIFEST = "datapackage.json"
RESULTS = "results"
MAX_DEPTH = 4
KEPT_RECORDINGS = 4  # 23 min take about 2 MB; hours of recording some 100 MB
KEPT_VERDICTS = 1000


@dataclass(frozen=True)
class Campaign:
    """One campaign folder in the workspace.

    Attributes
    ----------
    name : str
        Path below the workspace, with forward slashes; the studio's deep links use it.
    folder : Path
    origin : str
        ``simulated``, ``recorded`` or ``imported``, as its manifest says; ``""`` when it does not.
    gauge_length_mm : float or None
    status : str
        ``complete``, or how it ended; ``recording`` while it is under way, or when it was killed.
    specimen : str
        Sensor of the simulated rig, or what was said to be in the clamps; may be empty.
    """

    name: str
    folder: Path
    origin: str
    gauge_length_mm: float | None
    status: str = ""
    specimen: str = ""


class Workspace:
    """A folder of campaigns and the results made from them.

    Parameters
    ----------
    root : path
        Made if it does not exist.

    Raises
    ------
    UserError
        If `root` is a file.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root).resolve()
        if self.root.exists() and not self.root.is_dir():
            raise UserError(f"{root}: the studio works in a folder, and this is a file; give the folder it is in")
        self.root.mkdir(parents=True, exist_ok=True)
        self._recordings = Memory(KEPT_RECORDINGS)
        self._verdicts = Memory(KEPT_VERDICTS)

    def campaigns(self) -> list[Campaign]:
        """Every campaign below the root, newest first; a folder whose manifest cannot be read is listed too."""
        found = [path.parent for path in self.root.rglob(MANIFEST) if self._is_ours(path)]
        newest = sorted(found, key=lambda folder: -(folder / MANIFEST).stat().st_mtime)
        return [self._describe(folder) for folder in newest]

    def _is_ours(self, manifest: Path) -> bool:
        parts = manifest.relative_to(self.root).parts
        return len(parts) <= MAX_DEPTH + 1 and parts[0] != RESULTS and not any(part.startswith(".") for part in parts)

    def _describe(self, folder: Path) -> Campaign:
        name = folder.relative_to(self.root).as_posix()
        try:
            made = read_json(folder / MANIFEST, "campaign manifest")["knitbench"]
            words = (str(made.get("status", "")), str(made["recipe"].get("sensor") or ""))
            gauge = made["gauge_length_mm"]
            gauge_mm = None if gauge is None else float(gauge)
            return Campaign(name, folder, str(made.get("origin", "")), gauge_mm, *words)
        except (UserError, AttributeError, KeyError, TypeError, ValueError):
            return Campaign(name, folder, "", None)

    def campaign(self, name: str) -> Campaign:
        """The campaign called `name`.

        Raises
        ------
        UserError
            If there is none, or the name points out of the workspace.
        """
        folder = (self.root / name).resolve()
        if not folder.is_relative_to(self.root) or not (folder / MANIFEST).is_file():
            raise UserError(f"no campaign {name!r} in {self.root}; the list of campaigns shows what is there")
        return self._describe(folder)

    def recording(self, name: str) -> Recording:
        """The recording of a campaign, read once and kept until the file changes."""
        campaign = self.campaign(name)
        path = campaign.folder / "recording.csv"
        return self._recordings.recall(stamp(path), lambda: read_recording(campaign.folder))

    def problems(self, name: str) -> list[str]:
        """What `testbench verify` finds wrong with a campaign; empty when every byte agrees."""
        folder = self.campaign(name).folder
        files = sorted(path for path in folder.iterdir() if path.is_file())
        return self._verdicts.recall(stamp(*files), lambda: _verdict(folder))

    def results(self, name: str) -> Path:
        """Folder for what is made from a campaign (models, diagnoses, compensators), made if needed."""
        folder = self.root / RESULTS / name.replace("/", "__")
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def free_name(self, wanted: str) -> Path:
        """A folder below the root for a new campaign.

        Raises
        ------
        UserError
            If the name is empty, taken, or points out of the workspace.
        """
        folder = (self.root / wanted.strip()).resolve()
        if not wanted.strip() or folder == self.root or not folder.is_relative_to(self.root):
            raise UserError(f"a campaign needs a name that is a folder inside {self.root}, got {wanted!r}")
        if folder.exists():
            raise UserError(f"{wanted}: this name is taken; choose another")
        return folder


def _verdict(folder: Path) -> list[str]:
    from testbench.manifest import problems

    try:
        return problems(folder)
    except UserError as error:
        return [str(error)]
