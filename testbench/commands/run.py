"""``testbench run``: a simulated campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

SUMMARY = "run a program on the simulated rig and write a campaign folder"
EXAMPLE = "testbench run --sensor pes --program program.tap --seed 1 -o pes-1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    from testbench.campaigns.sensors import add_past_arguments, add_sensor_arguments, natural, positive

    add_sensor_arguments(parser)
    parser.add_argument("--program", required=True, metavar="FILE", help="Mach4 program that moves the stage")
    parser.add_argument(
        "--seed", type=natural, default=1, metavar="N", help="of noise and sampling times (default 1)"
    )
    parser.add_argument("-o", dest="campaign", required=True, metavar="CAMPAIGN", help="folder to write")
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="default: from the program's header, else 25"
    )
    add_past_arguments(parser)
    parser.add_argument("--divider-ohm", type=positive, metavar="R", help="reference resistor (default 606000)")
    parser.add_argument("--rate-hz", type=positive, metavar="F", help="mean sampling rate (default 41.5)")
    parser.add_argument("--rate-sd-hz", type=positive, metavar="S", help="its spread (default 14.2)")
    parser.add_argument(
        "--room-swing-c",
        type=positive,
        metavar="T",
        help="room temperature swings by T; adds temperature_C",
    )
    parser.add_argument("--real-time", action="store_true", help="take as long as the real machine would")
    parser.add_argument("--progress-json", action="store_true", help="progress as JSON lines on stdout")
    parser.add_argument("--overwrite", action="store_true", help="replace another simulated campaign in that folder")


def run(args: argparse.Namespace) -> int:
    import sys

    from gcode.support.errors import UserError
    from testbench.campaigns.campaign import matches, simulate_campaign, simulate_live, vacant
    from testbench.campaigns.plan import Plan, programs_before
    from testbench.campaigns.sensors import existing_file, sensor_model
    from testbench.rig.links import real_time
    from testbench.rig.motion import played
    from testbench.rig.progress import json_lines, terminal
    from testbench.rig.signals import stop_signals

    say = sys.stderr if args.progress_json else sys.stdout
    folder, program = Path(args.campaign), existing_file(args.program, "program; make one with `gcode generate`")
    model, sensor = sensor_model(args)
    motion, gauge_length_mm = played(program, args.gauge_length_mm)
    effects = Path(args.effects) if args.effects else None
    past = programs_before(args.after, model, gauge_length_mm, effects)
    plan = Plan(program, model, gauge_length_mm, args.seed, sensor, instruments_of(args), past, args.rest_s, effects)
    if matches(folder, plan):
        print(f"{folder}: already there and intact; not run again", file=say)
        return 0
    if folder.resolve() in {Path(source).resolve() for source in args.after}:
        raise UserError(f"{folder}: cannot replace a campaign that this one comes after; choose another with -o")
    vacant(folder, args.overwrite)
    report = json_lines() if args.progress_json else terminal(f"run {folder.name}")
    if args.real_time:
        with stop_signals() as stopped:
            status = simulate_live(plan, folder, motion, report, real_time, stopped)
    else:
        status = simulate_campaign(plan, folder, motion, report)
    done = f"{status.samples} samples in {status.time_s:.0f} s of motion, {sensor}, seed {args.seed}"
    print(f"{folder}: {done}", file=say)
    if status.state in ("complete", "interrupted"):
        return 0
    print(f"testbench run: {status.state}: {status.message}", file=sys.stderr)
    return 1


def instruments_of(args: argparse.Namespace):
    """The paper's instruments with what the command line changes."""
    from testbench.recordings.instruments import Divider, Instruments, Room, SampleClock

    clock = {"rate_hz": args.rate_hz, "rate_sd_hz": args.rate_sd_hz}
    divider = {"reference_ohm": args.divider_ohm}
    return Instruments(
        clock=SampleClock(**{key: value for key, value in clock.items() if value is not None}),
        divider=Divider(**{key: value for key, value in divider.items() if value is not None}),
        room=Room(swing_C=args.room_swing_c) if args.room_swing_c else None,
    )
