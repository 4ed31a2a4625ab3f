"""``testbench``: run, record, compare, diagnose."""

from __future__ import annotations

from collections.abc import Sequence

from gcode.support import console

COMMANDS: tuple[str, ...] = (
    "run",
    "record",
    "rig",
    "verify",
    "align",
    "dataset",
    "import",
    "effects",
    "fit",
    "compare",
    "hide",
    "diagnose",
    "propose",
    "add",
    "ladder",
    "experiment",
    "investigate",
    "report",
    "studio",
)


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point of the console command ``testbench``."""
    return console.main(
        "testbench",
        "Run or simulate tensile campaigns; find out which physical effect a knit model is missing.",
        "testbench.commands",
        COMMANDS,
        argv,
    )
