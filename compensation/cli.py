"""``compensation``: learn force or strain from the history of the resistance."""

from __future__ import annotations

from collections.abc import Sequence

from gcode.support import console

COMMANDS: tuple[str, ...] = ("train", "score", "predict", "recalibrate", "search", "table", "export")


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point of the console command ``compensation``."""
    return console.main(
        "compensation",
        "Train and score compensators of drift and hysteresis on recorded campaigns.",
        "compensation.commands",
        COMMANDS,
        argv,
    )
