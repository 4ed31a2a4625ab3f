"""``testbench verify``: does every byte of a campaign agree with its manifest?"""

from __future__ import annotations

import argparse
from pathlib import Path

SUMMARY = "check every file of a campaign, or of a whole data set, against its manifest"
EXAMPLE = "testbench verify pes-1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    from testbench.trust import EFFECTS_HELP

    parser.add_argument("campaigns", nargs="+", metavar="CAMPAIGN", help="campaign folder, or data set")
    parser.add_argument(
        "--again", action="store_true", help="also make a simulated campaign again and compare every byte"
    )
    parser.add_argument("--effects", metavar="FILE", help=f"with --again. {EFFECTS_HELP}")


def run(args: argparse.Namespace) -> int:
    import sys

    from testbench.campaigns.dataset_index import INDEX, index_problems
    from testbench.campaigns.remake import made_again

    failed, effects = False, Path(args.effects) if args.effects else None
    for folder in map(Path, args.campaigns):
        members, found = [folder], list[str]()
        if (folder / INDEX).is_file():
            members, found = index_problems(folder)
        for member in members:
            wrong, note = _problems(member, alone=member == folder), ""
            if args.again and not wrong:
                remade = made_again(member, effects)
                wrong, note = remade.explained(member), ", made again byte for byte"
                note += f" (by other software: {'; '.join(remade.changes)})" if remade.changes else ""
            found += wrong
            if not wrong:
                print(f"{member}: intact{note}")
        for problem in found:
            print(problem, file=sys.stderr)
        failed = failed or bool(found)
    return int(failed)


def _problems(member: Path, alone: bool) -> list[str]:
    """What is wrong with a campaign; in a data set, one that cannot be read at all does not hide the others."""
    from gcode.support.errors import UserError
    from testbench.recordings.manifest import problems

    try:
        return problems(member)
    except UserError as error:
        if alone:
            raise
        return [str(error)]
