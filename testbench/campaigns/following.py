"""What follows a recording while it is made: found by entry point, since this package imports none of it."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

from gcode.support.errors import UserError
from testbench.rig.stream import Row

GROUP, NAME = "knitbench.live", "compensator"


class Live(Protocol):
    """Takes samples (recording time in us, resistance in milliohm) and gives a value in its unit."""

    unit: str

    def take(self, time_us: int, resistance_mohm: int | None) -> float: ...
    def close(self) -> None: ...


@dataclass(frozen=True)
class Following:
    """A `Live` as the recorder calls it."""

    live: Live

    def follow(self, row: Row) -> tuple[float, str]:
        """Value and unit after this row."""
        return self.live.take(row.time_us, row.sample.resistance_mohm), self.live.unit

    def close(self) -> None:
        """Close its file."""
        self.live.close()


def live_compensator(path: str | Path, folder: str | Path) -> Following:
    """The compensator in `path`, ready to follow a recording into `folder`.

    Raises
    ------
    UserError
        If the file is no compensator, or no package that can run one is installed.
    """
    for point in entry_points(group=GROUP, name=NAME):
        return Following(point.load()(path, folder))
    raise UserError(
        f"--compensator {path}: nothing here can run a compensator; install knitbench anew (`make setup`), so that "
        f"its entry point {GROUP} is known"
    )
