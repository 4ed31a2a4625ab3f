"""``gcode generate``: plan a trajectory and write its program."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from gcode.commands._numbers import LIMITS, number
from gcode.support.console import given

if TYPE_CHECKING:
    from gcode.programs.make import Made

SUMMARY = "plan a trajectory and write trajectory.csv, program.tap and trajectory.json"
EXAMPLE = "gcode generate --preset paper-1 --seed 51 --gauge-length-mm 25 -o run-1"
OTHERS = ("seed", "gauge_length_mm", "feed_mode", "duration_s", "machine_acceleration_mm_per_s2")
IN_THE_HEADER = (*OTHERS, *(name for _, name, _, _ in LIMITS))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--preset", metavar="NAME", help="paper-1, paper-2, paper-3 or fast")
    source.add_argument("--spec", metavar="TOML", help="a protocol file (see docs/gcode.md)")
    source.add_argument("--again", metavar="PROGRAM", help="make one of our programs again from its header alone")
    parser.add_argument("--plot", action="store_true", help="write trajectory.png too")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    new = parser.add_argument_group(
        "with --preset or --spec",
        "The first two are needed; what else is left out is as the preset or the spec says.",
    )
    new.add_argument("--seed", type=int, metavar="N", help="0 or more: another seed is another motion")
    number(new, "--gauge-length-mm", "gauge_length_mm", "MM", "sample length between the grips")
    new.add_argument("--feed-mode", choices=("G94", "G93"), help="feed per minute (default) or inverse time")
    for limit in LIMITS:
        number(new, *limit)
    number(new, "--duration-s", "duration_s", "S", "duration of the (one) noise piece")
    number(new, "--machine-acceleration", "machine_acceleration_mm_per_s2", "MM/S2", "default: 5 a-max")


def run(args: argparse.Namespace) -> None:
    """Make, check and write; nothing is written when the check fails."""
    from gcode.programs.make import places

    places(args.output)
    made = _made(args)
    paths = made.write(args.output)
    if args.plot:
        from gcode.programs.plot import write_plot

        paths.append(write_plot(made, paths[0].with_suffix(".png")))
    print(f"{made.spec.name}, seed {made.seed}, gauge length {made.gauge_length_mm:g} mm, as executed:")
    print("\n".join(made.statistics.lines()))
    for note in made.notes():
        print(f"note: {note}")
    for path in paths:
        print(path)


def _made(args: argparse.Namespace) -> Made:
    """What is asked for, of a preset or a spec, or once more from a program's header."""
    from gcode.mach4.reader import load_program
    from gcode.programs.api import generate
    from gcode.programs.make import make_again
    from gcode.support.errors import UserError

    said = given(args, IN_THE_HEADER)
    if args.again:
        if said:
            raise UserError(f"--again makes the program as its header says; leave `{next(iter(said))}` out")
        return make_again(load_program(args.again))
    if args.seed is None or args.gauge_length_mm is None:
        raise UserError("--seed and --gauge-length-mm are needed, e.g. --seed 51 --gauge-length-mm 25")
    return generate(args.preset or Path(args.spec), **said)
