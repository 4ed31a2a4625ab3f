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
    parser.add_argument("--effects", metavar="FILE", help="with --again: the campaign's own effects, a program")


def run(args: argparse.Namespace) -> int:
    import sys

    from testbench.manifest import problems
    from testbench.remake import made_again

    failed = False
    for name in args.campaigns:
        found, note = problems(Path(name)), ""
        if args.again and not found:
            remade = made_again(Path(name), Path(args.effects) if args.effects else None)
            found, note = remade.explained(Path(name)), ", made again byte for byte"
            note += f" (by other software: {'; '.join(remade.changes)})" if remade.changes else ""
        for problem in found:
            print(problem, file=sys.stderr)
        failed = failed or bool(found)
        if not found:
            print(f"{name}: intact{note}")
    return int(failed)
