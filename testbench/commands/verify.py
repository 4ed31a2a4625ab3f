"""``testbench verify``: does every byte of a campaign agree with its manifest?"""

from __future__ import annotations

import argparse

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

    from testbench.api.files.verifying import VerifiedCampaign, verify

    def tell(campaign: VerifiedCampaign) -> None:
        if campaign.intact:
            print(campaign)

    failed = False
    for folder in args.campaigns:
        found = verify(folder, again=args.again, effects=args.effects, report=tell)
        for problem in found.problems:
            print(problem, file=sys.stderr)
        failed = failed or not found.intact
    return int(failed)
