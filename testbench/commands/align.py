"""``testbench align``: the delay and drift between a program and what was recorded of it."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import positive

SUMMARY = "find delay and clock drift between the planned and the recorded displacement, and apply them"
EXAMPLE = "testbench align knit-7 -o knit-7-aligned"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", metavar="RECORDING", help="campaign folder, or a CSV with --program")
    parser.add_argument("--program", metavar="FILE", help="default: the campaign's own")
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L", help="of a bare CSV")
    parser.add_argument(
        "-o", "--output", dest="out", metavar="CAMPAIGN", help="write the recording on the plan's clock"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier result in that folder")


def run(args: argparse.Namespace) -> int:
    import json
    from pathlib import Path

    from testbench.api.bench.aligning import align
    from testbench.campaigns.clearing import check_vacant

    if args.out:
        check_vacant(Path(args.out), args.overwrite, "aligned")
    found = align(args.recording, args.program, gauge_length_mm=args.gauge_length_mm)
    if args.out:
        found.write(args.out, args.overwrite)
    if args.json:
        print(json.dumps(found.to_dict()))
        return 0
    for words in found.words:
        print(f"{args.recording}: {words}")
    if args.out:
        print(f"{args.out}: the recording on the plan's clock, the planned displacement beside it")
    return 0
