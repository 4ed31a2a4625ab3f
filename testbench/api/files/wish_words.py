"""The import's messages for a person in Python: an option of the command line is a field of `testbench.Wish`."""

from __future__ import annotations

import re
from dataclasses import fields

from testbench.importing.choice import FLAGS, UNIT_FLAGS
from testbench.importing.sheet import Hints

OPTION = re.compile(r"(?<![\w./\\-])--[a-z][a-z0-9-]*")  # a word of its own: a file may be called day--force.csv
FIELDS = {
    "--gauge-length-mm": "gauge_length_mm=...",
    "--rate-hz": "rate_hz=...",
    "--rest-ohm": "r0_ohm=...",
    "--repeat": "repeat=...",
    "--drop-bad": "drop_bad=True",
    "--sort": "sort=True",
    "--time-of": "time_of={'force': ...}",
    "--zero": "zero={'force': ...}",
    "--negate": "negate={'force'}",
    **{f"--{one.name.replace('_', '-')}": f"hints=Hints({one.name}=...)" for one in fields(Hints)},
    **{flag: f"columns={{{role!r}: ...}}" for role, flag in FLAGS.items()},
    **{flag: f"units={{{flag.removeprefix('--').removesuffix('-unit')!r}: ...}}" for flag in UNIT_FLAGS.values()},
}


def in_python(text: str) -> str:
    """A message of the import, and behind it which fields the options are that it names.

    ``say --force-unit (N, kN)`` goes on ``(in Python, of testbench.Wish: --force-unit is units={'force': ...})``.
    """
    named = [f"{flag} is {FIELDS[flag]}" for flag in dict.fromkeys(OPTION.findall(text)) if flag in FIELDS]
    return f"{text} (in Python, of testbench.Wish: {', '.join(named)})" if named else text
