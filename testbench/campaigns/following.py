"""A compensator that follows a recording while it is made, found by its entry point (a package above this one)."""

from __future__ import annotations

from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

from gcode.support.errors import UserError
from testbench.rig.protocol.items import Row

GROUP, NAME = "knitbench.live", "compensator"


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
    for point in entry_points(group=GROUP, name=NAME):
        return point.load()(path, folder)
    raise UserError(
        f"{path}: nothing here can run a compensator; install knitbench anew (`make setup`), so that "
        f"its entry point {GROUP} is known"
    )
