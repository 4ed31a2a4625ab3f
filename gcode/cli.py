"""``gcode``: plan motion and write it for the machine."""

from __future__ import annotations

from collections.abc import Sequence

from gcode.support import console

COMMANDS: tuple[str, ...] = ("generate", "check", "play", "fit")


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point of the console command ``gcode``."""
    return console.main(
        "gcode",
        "Plan pseudo-natural single-axis motion and write it for Mach4.",
        "gcode.commands",
        COMMANDS,
        argv,
    )
