"""``testbench verify``: does every byte of a campaign agree with its manifest?"""

from __future__ import annotations

import argparse
from pathlib import Path

SUMMARY = "check every file of a campaign against its manifest"
EXAMPLE = "testbench verify pes-1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("campaigns", nargs="+", metavar="CAMPAIGN", help="campaign folder")
    parser.add_argument(
        "--again", action="store_true", help="also make a simulated campaign again and compare every byte"
    )


def run(args: argparse.Namespace) -> int:
    import sys

    from testbench.manifest import problems
    from testbench.remake import differences

    failed = False
    for name in args.campaigns:
        found = problems(Path(name))
        if args.again and not found:
            found = differences(Path(name))
        for problem in found:
            print(problem, file=sys.stderr)
        failed = failed or bool(found)
        if not found:
            print(f"{name}: intact" + (", made again byte for byte" if args.again else ""))
    return int(failed)
