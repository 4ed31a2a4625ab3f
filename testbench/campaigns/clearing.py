"""Making room for a campaign: what may be removed from a folder, and what never is."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import drafted_folder
from testbench.campaigns.plan import EFFECTS, PROGRAM
from testbench.recordings import manifest
from testbench.recordings.manifest import CSV, is_campaign, origin_of
from testbench.recordings.stored import EVENTS
from testbench.rig.acquisition.sink import BAD, COMPENSATED, ROOM

_ALL_NAMES = "|".join(
    [*map(re.escape, (manifest.NAME, CSV, PROGRAM, EVENTS, BAD, COMPENSATED, EFFECTS)), r"before-\d+\.tap"]
)
_OUR_NAME = re.compile(rf"{_ALL_NAMES}|\.({_ALL_NAMES})\.[0-9a-f]{{8}}\.\w+|{re.escape(ROOM)}")


def vacant(folder: Path, overwrite: bool = False, origin: str = "simulated") -> None:
    """Make sure that `folder` may be written; remove the files of a campaign of that `origin` if `overwrite`.

    Of no origin ("") is no campaign: whatever is there stays.

    The manifest goes last: what a kill leaves is still known as a campaign, and is removed by the next call.

    Raises
    ------
    UserError
        As `check_vacant`; nothing is removed then.
    """
    check_vacant(folder, overwrite, origin)
    if folder.exists():
        for path in sorted(folder.iterdir(), key=lambda path: path.name == manifest.NAME):
            path.unlink(missing_ok=True)
        folder.rmdir()


@contextmanager
def replaced(folder: Path, overwrite: bool = False, origin: str = "simulated") -> Iterator[Path]:
    """Yield a new folder for a campaign; at the end, it takes the place of an earlier one in `folder`.

    Where the block fails, or the process is killed in it, the earlier one stays as it is.

    Raises
    ------
    UserError
        As `check_vacant`, before the block.
    """
    check_vacant(folder, overwrite, origin)
    with drafted_folder(folder) as draft:
        yield draft
        vacant(folder, overwrite, origin)


def check_vacant(folder: Path, overwrite: bool = False, origin: str = "simulated") -> None:
    """Refuse a folder that `vacant` may not empty.

    Raises
    ------
    UserError
        If it lies in a campaign, or is where this program runs; if something else is there, a campaign of another
        origin, or a file beside a campaign that is none of its own: somebody put it there, and it would be lost.
    """
    if outer := next((one for one in folder.absolute().parents if is_campaign(one)), None):
        raise UserError(f"{folder}: {outer} is a campaign, which holds no others; choose another place")
    if folder.resolve() == Path.cwd():
        raise UserError(f"{folder}: a new folder would take the place of the one that you are in; name one in it")
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    if not folder.is_dir() or not (folder / manifest.NAME).is_file():
        raise UserError(f"{folder}: exists and is not a campaign; choose another place")
    if (there := origin_of(folder)) != origin:
        raise UserError(f"{folder}: holds a campaign that was {there}, which is not overwritten; choose another")
    if not overwrite:
        raise UserError(f"{folder}: holds another campaign; choose another place, or give `overwrite`")
    if strange := sorted(path.name for path in folder.iterdir() if not _ours(path)):
        raise UserError(
            f"{folder}: beside its campaign it holds {strange[0]!r}, which would be lost; move that away, or choose "
            "another place"
        )


def _ours(path: Path) -> bool:
    """Whether it is a file of a campaign, or what a kill left of one that was being written.

    What the manifest lists does not count: a stranger's may list any file.
    """
    return bool(_OUR_NAME.fullmatch(path.name)) and (path.is_symlink() or not path.is_dir())
