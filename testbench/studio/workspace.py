"""The folder a studio works in: which campaigns are there, whether they are intact, where results are kept."""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

from gcode.support.errors import UserError
from gcode.support.strict import read_json
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import CSV, MOST_BYTES, problems
from testbench.recordings.manifest import NAME as MANIFEST
from testbench.recordings.recording import Recording
from testbench.studio.memory import Memory, stamp
from testbench.studio.notes import FILE as NOTES

RESULTS = "results"
DELETED = "deleted"  # below results; until they are restored
DELETED_AT = "%Y%m%d-%H%M%S-"
PROGRAMS = "programs"
OWN = (RESULTS, DELETED, "running", "rig", PROGRAMS, NOTES, "paces.json", "effects-file.txt", "effects.py")
MAX_DEPTH = 4
MOST_PART_BYTES = 255
MADE = {"model.json": "fitted", "diagnosis.json": "diagnosed"}
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
    made_s: float = 0.0  # when its manifest was written, in seconds since 1970
    columns: frozenset[str] = frozenset()  # of its recording, as its manifest says


class Workspace:
    """A folder of campaigns and the results made from them.

    Raises
    ------
    UserError
        If `root` is no folder.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root).resolve()
        if not self.root.is_dir():
            why = "this is a file; give the folder it is in" if self.root.exists() else "there is none; make it first"
            raise UserError(f"{root}: the studio works in a folder, and {why}")
        self.kept()
        self._recordings = Memory(KEPT_RECORDINGS)
        self._verdicts = Memory(KEPT_VERDICTS)
        self._known: dict[str, tuple[tuple[int, int], Campaign]] = {}
        self._reading = Lock()

    def campaigns(self) -> list[Campaign]:
        """Every campaign below the root, newest first; a folder whose manifest cannot be read is listed too.

        A manifest is read once and again only when it has changed, so thousands are listed in less than a second.
        Who asks while another thread reads them waits for that one.
        """
        with self._reading:
            found = [self._described(folder, made) for folder, made in holding(MANIFEST, self.root)]
        return sorted(found, key=lambda campaign: (-campaign.made_s, campaign.name))

    def _described(self, folder: str, made: os.stat_result) -> Campaign:
        mark = (made.st_mtime_ns, made.st_size)
        known = self._known.get(folder)
        if known is None or known[0] != mark:
            known = self._known[folder] = (mark, self._describe(folder, made.st_mtime))
        return known[1]

    def _describe(self, folder: str, made_s: float) -> Campaign:
        path = Path(folder)
        name = folder[len(str(self.root)) :].replace(os.sep, "/").strip("/")
        try:
            manifest = read_json(os.path.join(folder, MANIFEST), "campaign manifest", MOST_BYTES)
            made = manifest["knitbench"]
            words = (str(made.get("status", "")), str(made["recipe"].get("sensor") or ""))
            gauge = made["gauge_length_mm"]
            gauge_mm = None if gauge is None else float(gauge)
            return Campaign(name, path, str(made.get("origin", "")), gauge_mm, *words, made_s, _columns(manifest))
        except (OSError, AttributeError, KeyError, TypeError, ValueError):
            return Campaign(name, path, "", None, made_s=made_s)

    def campaign(self, name: str) -> Campaign:
        """The campaign called `name`.

        Raises
        ------
        UserError
            If there is none, or the name points out of the workspace.
        """
        folder = self._inside(name)
        made = _stat_of(folder / MANIFEST) if folder else None
        if folder is None or made is None:
            raise UserError(f"no campaign {name!r} in {self.root}; the list of campaigns shows what is there")
        return self._described(str(folder), made)

    def program(self, name: str = "") -> Path:
        """The folder that a planned program is written to; without a name, the one of all."""
        return self.root / PROGRAMS / name

    def name_of(self, folder: Path) -> str:
        """The name of the campaign in a folder of the workspace, whether it is there yet or not."""
        return folder.relative_to(self.root).as_posix()

    def recording(self, name: str) -> Recording:
        """The recording of a campaign, read once and kept until it or its manifest changes."""
        folder = self.campaign(name).folder
        return self._recordings.recall(stamp(folder / CSV, folder / MANIFEST), lambda: read_recording(folder))

    def problems(self, name: str) -> list[str]:
        """What `testbench verify` finds wrong with a campaign; empty when every byte agrees."""
        folder = self.campaign(name).folder
        files = sorted(path for path in folder.iterdir() if path.is_file())
        return self._verdicts.recall(stamp(*files), lambda: _verdict(folder))

    def results(self, name: str) -> Path:
        """Folder for what is made from a campaign (models, diagnoses, compensators); who writes to it makes it.

        Raises
        ------
        UserError
            If a link leads it out of the workspace, or it can be none.
        """
        if "\0" in name:
            raise UserError(f"no campaign {name!r} in {self.root}; the list of campaigns shows what is there")
        return self.kept(results_name(name))

    def kept(self, *parts: str) -> Path:
        """A place below the results, which the studio writes to.

        Raises
        ------
        UserError
            If a link leads it out of the workspace, which may be a stranger's.
        """
        place = self.root.joinpath(RESULTS, *parts)
        if (real := os.path.realpath(place)) != str(place):
            raise UserError(
                f"{place}: a link leads to {real}; results are written below the workspace only: remove the link"
            )
        return place

    def made(self) -> dict[str, frozenset[str]]:
        """What has been made from each campaign that something was made from: ``fitted``, ``compensated``, ..."""
        found = {}
        with contextlib.suppress(FileNotFoundError), os.scandir(self.root / RESULTS) as entries:
            for entry in entries:
                if entry.is_dir():
                    found[entry.name] = _made_in(entry.path)
        return found

    def free_name(self, wanted: str) -> Path:
        """A folder below the root for a new campaign.

        Raises
        ------
        UserError
            If the name is empty, taken, points out of the workspace, or would not be found or kept there.
        """
        folder = self.untaken(wanted)
        for parent in folder.parents:
            if parent != self.root and parent.is_relative_to(self.root) and (parent / MANIFEST).is_file():
                raise UserError(
                    f"{wanted}: {self.name_of(parent)} is a campaign, which holds no others; choose another"
                )
        if why := _unfit(folder.relative_to(self.root).as_posix()):
            raise UserError(f"{wanted}: {why}; choose another name")
        return folder

    def untaken(self, wanted: str) -> Path:
        """The folder below the root that a campaign of this name would have.

        Raises
        ------
        UserError
            If the name is empty, taken, or points out of the workspace.
        """
        folder = self._inside(wanted.strip())
        if not wanted.strip() or folder is None:
            raise UserError(f"a campaign needs a name that is a folder inside {self.root}, got {wanted!r}")
        with contextlib.suppress(OSError):  # longer than any name that could be there
            if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
                raise UserError(f"{wanted}: this name is taken; choose another")
        return folder

    def _inside(self, name: str) -> Path | None:
        """The folder of this name below the root; None where it is none."""
        with contextlib.suppress(OSError, RuntimeError, ValueError):  # a loop of links; a zero byte
            folder = (self.root / name).resolve()
            if folder != self.root and folder.is_relative_to(self.root):
                return folder
        return None


def _columns(manifest: Mapping[str, Any]) -> frozenset[str]:
    """The columns of the recording that a manifest describes."""
    described = [one.get("schema", {}) for one in manifest.get("resources", ()) if one.get("path") == CSV]
    return frozenset(field["name"] for schema in described for field in schema.get("fields", ()))


def _unfit(name: str) -> str:
    """Why the studio could not handle a campaign of this name; empty where it could."""
    parts = name.split("/")
    if parts[0] in OWN:
        return f"the studio keeps its own things under {parts[0]!r}"
    if any(part.startswith(".") for part in parts):
        return "a name that begins with a dot is hidden, and the list would not show it"
    if len(parts) > MAX_DEPTH:
        return f"campaigns are looked for at most {MAX_DEPTH} folders deep, and this would be {len(parts)}"
    if any(len(os.fsencode(part)) > MOST_PART_BYTES for part in parts):
        return f"a part of it is longer than the {MOST_PART_BYTES} bytes that a file system takes"
    if len(os.fsencode(results_name(name))) > MOST_PART_BYTES - len(time.strftime(DELETED_AT)):
        return "it is too long for the folder of its results"
    return ""


def _stat_of(file: Path | os.DirEntry[str]) -> os.stat_result | None:
    """What is known of a file, of the link itself where that leads nowhere; None where there is none."""
    for follow in (True, False):
        with contextlib.suppress(OSError, ValueError):
            return file.stat(follow_symlinks=follow)
    return None


def holding(name: str, root: Path, depth: int = MAX_DEPTH) -> Iterator[tuple[str, os.stat_result]]:
    """Folders below `root` with a file of this name, and what is known of it; none is hidden, or a result."""
    pending = [(str(root), 0)]
    while pending:
        folder, level = pending.pop()
        with contextlib.suppress(OSError), os.scandir(folder) as entries:
            for entry in entries:
                hidden = entry.name.startswith(".") or (level == 0 and entry.name == RESULTS)
                if entry.name == name and level:
                    if made := _stat_of(entry):
                        yield folder, made
                elif level < depth and not hidden and entry.is_dir(follow_symlinks=False):
                    pending.append((entry.path, level + 1))


def results_name(name: str) -> str:
    """The folder below the results that belongs to a campaign, and to no other: ``a/b`` has ``a__b``.

    An underscore that could be taken for a part of such a pair is written as in an address.
    """
    return re.sub("(?<=[_/])_|_(?=[_/])", "%5F", name.replace("%", "%25")).replace("/", "__")


def _made_in(folder: str) -> frozenset[str]:
    files = set(os.listdir(folder))
    found = {word for file, word in MADE.items() if file in files}
    return frozenset(found | ({"compensated"} if any(file.endswith(".score.json") for file in files) else set()))


def _verdict(folder: Path) -> list[str]:
    try:
        return problems(folder)
    except UserError as error:
        return [str(error)]
