"""``gcode check``: refuse a program that is not safe to run, with line numbers and reasons."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from gcode.commands._numbers import ACCELERATION, HIGHEST, JERK, LOWEST, SPEED, number
from gcode.support.console import given

if TYPE_CHECKING:
    from gcode.mach4.check import CheckResult

SUMMARY = "check a program against limits; exit 0 if it may run, 1 if not"
EXAMPLE = "gcode check run-1/program.tap --v-max 5 --a-max 20 --x-min 0 --x-max 7.5"

OF_THE_CONTROLLER = "the controller's own, default: 5 a-max (what the file says of it counts for nothing)"
SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("program", metavar="PROGRAM", help="a Mach4 or plain RS274/NGC file")
    for limit in (SPEED, ACCELERATION, LOWEST, HIGHEST):
        number(parser, *limit, required=True)
    number(parser, *JERK)
    number(parser, "--rate-hz", "rate_hz", "HZ", "rate of the finite differences (default 20)", default=20.0)
    number(parser, "--machine-acceleration", "acceleration_mm_per_s2", "MM/S2", OF_THE_CONTROLLER)
    number(parser, "--rapid", "rapid_mm_per_s", "MM/S", "speed of G0 moves; without it they are refused")
    number(parser, "--max-dwell-s", "longest_dwell_s", "S", "longest dwell; default 120 in files that others made")
    parser.add_argument(
        "--as-foreign", action="store_true", help="do not hold a program of ours against the recipe in its header"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Print problems and statistics; 1 if there are problems."""
    import json

    from gcode.mach4.controller import Machine
    from gcode.mach4.reader import read_text
    from gcode.programs.made_again import check_file
    from gcode.trajectories.trajectory import Limits

    limits = Limits(**given(args, Limits.model_fields))
    own = args.acceleration_mm_per_s2
    machine = None if own is None else Machine(acceleration_mm_per_s2=own)
    result, origin = check_file(
        read_text(args.program),
        limits,
        args.rate_hz,
        machine,
        rapid_mm_per_s=args.rapid_mm_per_s,
        longest_dwell_s=args.longest_dwell_s,
        as_foreign=args.as_foreign,
    )
    if args.json:
        print(json.dumps(result.to_dict() | {"origin": origin.words, "genuine": origin.genuine}, indent=2))
    else:
        _say(args.program, result, origin.words)
    return 0 if result.ok else 1


def _say(program: str, result: CheckResult, origin: str) -> None:
    """Problems, statistics and the verdict, for a person."""
    for problem in result.problems[:SHOWN]:
        print(f"{program}: {problem}")
    if len(result.problems) > SHOWN:
        print(f"... and {len(result.problems) - SHOWN} more (all of them with --json)")
    if result.statistics:
        print("\n".join(result.statistics.lines()))
    print(f"ok: this program may run ({origin})" if result.ok else f"refused: {len(result.problems)} problem(s)")
