"""``testbench run``: a simulated campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

from gcode.support.console import given
from testbench.commands._arguments import add_simulation_arguments, positive, shared

SUMMARY = "run a program on the simulated rig and write a campaign folder"
EXAMPLE = "testbench run --sensor pes --program program.tap --seed 1 -o pes-1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_simulation_arguments(parser)
    parser.add_argument("-o", "--output", dest="campaign", required=True, metavar="CAMPAIGN", help="folder to write")
    parser.add_argument(
        "--divider-ohm",
        dest="reference_ohm",
        type=positive,
        metavar="R",
        help="reference resistor, best near the sensor's own (default 606000)",
    )
    parser.add_argument("--rate-hz", type=positive, metavar="F", help="mean sampling rate (default 41.5)")
    parser.add_argument("--rate-sd-hz", type=positive, metavar="S", help="its spread (default 14.2 of 41.5)")
    parser.add_argument(
        "--room-swing-c",
        dest="swing_C",
        type=positive,
        metavar="T",
        help="room temperature swings by T; adds temperature_C",
    )
    parser.add_argument("--real-time", action="store_true", help="take as long as the real machine would")
    parser.add_argument("--progress-json", action="store_true", help="progress as JSON lines on stdout")
    parser.add_argument("--overwrite", action="store_true", help="replace another simulated campaign in that folder")


def run(args: argparse.Namespace) -> int:
    import sys

    from gcode.support.files import existing_file
    from testbench.api.bench.running import run as run_campaign
    from testbench.rig.acquisition.status_words import json_lines, terminal

    program = existing_file(args.program, "program; make one with `gcode generate`")
    done = run_campaign(
        args.sensor or args.model,
        program,
        args.campaign,
        instruments=instruments_of(args),
        overwrite=args.overwrite,
        real_time=args.real_time,
        report=json_lines() if args.progress_json else terminal(f"run {Path(args.campaign).name}"),
        **shared(args),
    )
    print(done, file=sys.stderr if args.progress_json else sys.stdout)
    if done.status is None or done.ended_well:
        return 0
    print(f"testbench run: {done.status.state}: {done.status.message}", file=sys.stderr)
    return 1


def instruments_of(args: argparse.Namespace):
    """The paper's instruments with what the command line changes."""
    from testbench.recordings.instruments import Divider, Instruments, Room, SampleClock

    return Instruments(
        clock=SampleClock(**given(args, ("rate_hz", "rate_sd_hz"))),
        divider=Divider(**given(args, ["reference_ohm"])),
        room=Room(swing_C=args.swing_C) if args.swing_C else None,
    )
