"""``testbench record``: a campaign from a serial port."""

from __future__ import annotations

import argparse
from pathlib import Path

from testbench.commands._arguments import existing_file, positive

SUMMARY = "record a campaign from the rig's serial port; --resume continues an interrupted one"
EXAMPLE = "testbench record --port /dev/ttyUSB0 --program program.tap -o knit-7"


def add_arguments(parser: argparse.ArgumentParser) -> None:

    parser.add_argument(
        "--port", metavar="URL", help="device (/dev/ttyUSB0), socket://HOST:PORT or rfc2217://HOST:PORT"
    )
    parser.add_argument("--program", metavar="FILE", help="Mach4 program that the machine will run")
    parser.add_argument("-o", dest="campaign", required=True, metavar="CAMPAIGN", help="folder to write")
    parser.add_argument("--resume", action="store_true", help="continue the unfinished recording in CAMPAIGN")
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="default: from the program's header, else 25"
    )
    parser.add_argument("--specimen", default="", metavar="NAME", help="what is in the clamps; kept in the manifest")
    parser.add_argument(
        "--max-force-n", type=positive, default=float("inf"), metavar="F", help="stop beyond this force"
    )
    parser.add_argument(
        "--max-strain", type=positive, default=float("inf"), metavar="E", help="stop beyond this strain"
    )
    parser.add_argument("--baud", type=int, default=115200, metavar="B", help="default 115200")
    parser.add_argument(
        "--give-up-s",
        type=positive,
        default=60.0,
        metavar="S",
        help="end when a lost port stays away, or a full disk full, for so long (default 60)",
    )
    parser.add_argument(
        "--compensator",
        metavar="C",
        help="show what it makes of the resistance beside the force, and keep it in CAMPAIGN/compensated.csv",
    )
    parser.add_argument("--progress-json", action="store_true", help="progress as JSON lines on stdout")


def run(args: argparse.Namespace) -> int:
    import sys

    from testbench.campaigns.following import live_compensator
    from testbench.campaigns.record import begin, record
    from testbench.rig.progress import as_text, json_lines, terminal
    from testbench.rig.serial_port import SerialLink
    from testbench.rig.signals import stop_signals

    folder = Path(args.campaign)
    job = (_continued(args, folder) if args.resume else _new(args, folder)).prepare()
    live = live_compensator(args.compensator, folder) if args.compensator else None
    link = SerialLink(job.port, job.baud, args.give_up_s)
    try:
        if not args.resume:
            begin(job, folder)
        report = json_lines() if args.progress_json else terminal(f"record {folder.name}")
        with stop_signals() as stopped:
            status = record(job, folder, link, report, stopped, args.resume, follow=live.follow if live else None)
    finally:
        link.close()
        if live is not None:
            live.close()
    if not args.progress_json:
        print(f"{folder}: {status.state}: {as_text(status)}")
    if status.state in ("complete", "interrupted"):
        return 0
    print(f"testbench record: {status.state}: {status.message}", file=sys.stderr)
    return 1


def _new(args: argparse.Namespace, folder: Path):
    from gcode.support.errors import UserError
    from testbench.campaigns.campaign import vacant
    from testbench.campaigns.record import Job
    from testbench.rig.motion import played
    from testbench.rig.ports import stated_port
    from testbench.rig.recorder import Limits

    if not args.port or not args.program:
        raise UserError("a new recording needs --port and --program; --resume continues an old one")
    port = stated_port(args.port)
    vacant(folder)
    program = existing_file(args.program, "program; make one with `gcode generate`")
    _, gauge_length_mm = played(program, args.gauge_length_mm)
    limits = Limits(args.max_force_n, args.max_strain)
    return Job(port, args.baud, program, gauge_length_mm, limits, args.specimen, args.give_up_s)


def _continued(args: argparse.Namespace, folder: Path):
    from testbench.campaigns.record import job_of

    return job_of(folder, args.port, args.give_up_s)
