"""``compensation table``: the paper's tables beside ours."""

from __future__ import annotations

import argparse

from gcode.support.errors import UserError

SUMMARY = "print the paper's result tables beside ours, on simulated PES and Lycra campaigns"
EXAMPLE = "compensation table -o table-campaigns --seeds 10 --specimens 10 --engine fast"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="campaigns are kept here and used again")
    parser.add_argument("--seeds", type=int, default=10, metavar="K", help="networks a row (default 10)")
    parser.add_argument(
        "--specimens", type=int, default=1, metavar="K", help="sensors of each kind, means over them (default 1)"
    )
    parser.add_argument("--engine", choices=("exact", "fast"), default="exact", help="default exact")
    parser.add_argument("--sensor", choices=("pes", "lycra"), action="append", help="default: both")
    parser.add_argument(
        "--quick", action="store_true", help="results and transfer only: no tuned row, baselines or other rates"
    )


def run(args: argparse.Namespace) -> int:
    from compensation.paper import tables
    from compensation.paper.paper_campaigns import RUNS, campaigns
    from gcode.support.console import Progress
    from gcode.support.files import make_folder

    if args.seeds < 2:
        raise UserError(f"--seeds must be at least 2 to show a spread, got {args.seeds}")
    if args.specimens < 1:
        raise UserError(f"--specimens must be at least 1, got {args.specimens}")
    folder, sensors = make_folder(args.output), args.sensor or ["pes", "lycra"]
    progress = Progress("campaigns", len(RUNS) * len(sensors) * args.specimens)
    recordings = {
        sensor: [campaigns(folder, sensor, progress.step, number=number) for number in range(args.specimens)]
        for sensor in sensors
    }
    print(tables.trajectories(folder))
    for target in ("force", "displacement"):
        print(tables.results(recordings, target, args.seeds, args.engine, tuned=not args.quick))
    print(tables.transfer(recordings, args.seeds, args.engine))
    if not args.quick:
        print(tables.others(recordings, args.seeds))
    return 0
