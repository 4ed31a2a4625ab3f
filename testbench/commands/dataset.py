"""``testbench dataset``: thousands of simulated campaigns from one file."""

from __future__ import annotations

import argparse

from gcode.support.console import processes

SUMMARY = "make a data set of simulated campaigns from a TOML file; run again to resume"
EXAMPLE = "testbench dataset knits.toml -o knits"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    from testbench.trust import EFFECTS_HELP

    parser.add_argument("spec", metavar="SPEC.toml", help="sensors, programs and seeds; see docs/datasets.md")
    parser.add_argument("-o", "--output", dest="out", required=True, metavar="DIR", help="folder for the campaigns")
    parser.add_argument("--workers", type=processes, default=-1, metavar="N", help="processes (default: one a core)")
    parser.add_argument("--effects", metavar="FILE", help=f"the effects that the spec names. {EFFECTS_HELP}")
    parser.add_argument(
        "--format",
        choices=["csv", "parquet"],
        default="csv",
        help="campaign folders with a CSV each (default); parquet: beside them Parquet files, split by specimen, "
        "with Croissant metadata",
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster that does the work: tcp://HOST:8786"
    )


def run(args: argparse.Namespace) -> int:
    import time

    from testbench.api.files.datasets import dataset

    start_s = time.monotonic()
    made = dataset(
        args.spec,
        args.out,
        format=args.format,
        workers=args.workers,
        scheduler=args.scheduler,
        effects=args.effects,
    )
    if made.parquet_files is not None:
        print(f"{made.folder / 'parquet'}: {made.parquet_files} files written")
    print(f"{made}, {time.monotonic() - start_s:.1f} s")
    return 0
