"""``testbench record``: a campaign from a serial port."""

from __future__ import annotations

import argparse
from pathlib import Path

from gcode.support.console import given
from testbench.commands._arguments import positive

SUMMARY = "record a campaign from the rig's serial port; --resume continues an interrupted one"
EXAMPLE = "testbench record --port /dev/ttyUSB0 --program program.tap -o knit-7"
AS_BEGUN = ("gauge_length_mm", "specimen", "max_force_N", "max_strain", "baud")  # what --resume does not change


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port", metavar="URL", help="device (/dev/ttyUSB0), socket://HOST:PORT or rfc2217://HOST:PORT"
    )
    parser.add_argument("--program", metavar="FILE", help="Mach4 program that the machine will run")
    parser.add_argument("-o", "--output", dest="campaign", required=True, metavar="CAMPAIGN", help="folder to write")
    parser.add_argument("--resume", action="store_true", help="continue the unfinished recording in CAMPAIGN")
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="default: from the program's header, else 25"
    )
    parser.add_argument("--specimen", metavar="NAME", help="what is in the clamps; kept in the manifest")
    parser.add_argument(
        "--max-force-n", dest="max_force_N", type=positive, metavar="F", help="stop beyond this force"
    )
    parser.add_argument("--max-strain", type=positive, metavar="E", help="stop beyond this strain (0.3: 30 %%)")
    parser.add_argument("--baud", type=int, metavar="B", help="default 115200")
    parser.add_argument(
        "--give-up-s",
        type=positive,
        default=60.0,
        metavar="S",
        help="end when the port stays lost, or the disk full, for so long (default 60)",
    )
    parser.add_argument(
        "--compensator",
        metavar="C",
        help="show what it makes of the resistance beside the force, and keep it in CAMPAIGN/compensated.csv",
    )
    parser.add_argument("--progress-json", action="store_true", help="progress as JSON lines on stdout")


def run(args: argparse.Namespace) -> int:
    import sys

    from gcode.support.errors import UserError
    from testbench.api.bench.capturing import record, resume_recording
    from testbench.campaigns.record import check_as_begun
    from testbench.rig.acquisition.status_words import json_lines, terminal

    said = given(args, AS_BEGUN)
    report = json_lines() if args.progress_json else terminal(f"record {Path(args.campaign).name}")
    if args.resume:
        check_as_begun(Path(args.campaign), said, args.program)
        done = resume_recording(
            args.campaign, args.port, give_up_s=args.give_up_s, compensator=args.compensator, report=report
        )
    elif not args.port or not args.program:
        raise UserError("a new recording needs --port and --program; --resume continues an old one")
    else:
        done = record(
            args.port,
            args.program,
            args.campaign,
            give_up_s=args.give_up_s,
            compensator=args.compensator,
            report=report,
            **said,
        )
    if not args.progress_json:
        print(done)
    if done.ended_well:
        return 0
    print(f"testbench record: {done.status.state}: {done.status.message}", file=sys.stderr)
    return 1
