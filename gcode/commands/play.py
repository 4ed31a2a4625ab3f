"""``gcode play``: what a look-ahead controller does with a program."""

from __future__ import annotations

import argparse

from gcode.commands._numbers import number
from gcode.support.console import given

SUMMARY = "play a program as a look-ahead controller would and write the executed position over time"
OF_THE_CONTROLLER = "the controller's; default: as the header says, else 100"
EXAMPLE = "gcode play run-1/program.tap -o executed.csv --rate-hz 20"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("program", metavar="PROGRAM", help="a Mach4 or plain RS274/NGC file")
    parser.add_argument("-o", "--output", required=True, metavar="CSV", help="time_s,position_mm")
    number(parser, "--rate-hz", "rate_hz", "HZ", "sample rate of the result (default 20)", default=20.0)
    number(parser, "--acceleration", "acceleration_mm_per_s2", "MM/S2", OF_THE_CONTROLLER)
    number(parser, "--look-ahead", "look_ahead_blocks", "BLOCKS", "default 20, as in Mach4", type=int)
    number(parser, "--corner-speed", "corner_mm_per_s", "MM/S", "step at a reversal (default 0: stop)")
    number(parser, "--rapid", "rapid_mm_per_s", "MM/S", "speed of G0 moves (default 50)")


def run(args: argparse.Namespace) -> None:
    from gcode.mach4.controller import Machine, machine_for, play
    from gcode.mach4.reader import load_program
    from gcode.support.errors import UserError
    from gcode.support.files import PROGRAM_NAMES, check_place

    check_place(args.output)
    if args.output.lower().endswith(PROGRAM_NAMES):
        raise UserError(f"{args.output}: has the name of a program, and a table is written; choose another with -o")
    program = load_program(args.program)
    machine = machine_for(program, **given(args, Machine.model_fields))
    executed = play(program, args.rate_hz, machine)
    executed.write_csv(args.output)
    print(f"executed with {machine.acceleration_mm_per_s2:g} mm/s2:")
    print("\n".join(executed.statistics().lines()))
    print(args.output)
