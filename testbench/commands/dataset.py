"""``testbench dataset``: thousands of simulated campaigns from one file."""

from __future__ import annotations

import argparse
from pathlib import Path

SUMMARY = "make a data set of simulated campaigns from a TOML file; run again to resume"
EXAMPLE = "testbench dataset knits.toml -o knits"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    from testbench.trust import EFFECTS_HELP

    parser.add_argument("spec", metavar="SPEC.toml", help="sensors, programs and seeds; see docs/recording.md")
    parser.add_argument("-o", dest="out", required=True, metavar="DIR", help="folder for the campaigns")
    parser.add_argument(
        "--backend", choices=["loky", "dask"], default="loky", help="processes here, or a Dask cluster"
    )
    parser.add_argument("--workers", type=int, default=-1, metavar="N", help="processes (default: one a core)")
    parser.add_argument("--effects", metavar="FILE", help=f"the effects that the spec names. {EFFECTS_HELP}")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of the Dask cluster, e.g. tcp://10.0.0.5:8786")


def run(args: argparse.Namespace) -> int:
    import time

    from gcode.support.console import Progress
    from gcode.support.errors import UserError
    from gcode.support.files import make_folder
    from testbench.campaigns.cluster import cluster
    from testbench.campaigns.dataset import OneAtATime, run, tasks_of, write_index
    from testbench.campaigns.dataset_spec import read_spec

    if (args.backend == "dask") != bool(args.scheduler):
        raise UserError("--backend dask and --scheduler ADDRESS belong together")
    spec_path = Path(args.spec)
    spec = read_spec(spec_path)
    out = make_folder(args.out)
    start_s = time.monotonic()
    with OneAtATime(out):
        tasks = tasks_of(spec, spec_path.parent, out, Path(args.effects) if args.effects else None)
        progress = Progress("campaigns", len(tasks))
        with cluster(args.scheduler):
            made, there = run(tasks, args.backend, args.workers, progress.step)
        write_index(out, spec_path, tasks)
    print(f"{out}: {len(tasks)} campaigns: {made} made, {there} there already, {time.monotonic() - start_s:.1f} s")
    return 0
