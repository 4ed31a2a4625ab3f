"""``testbench compare``: where a model fails."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_clamp_play, add_effects, positive, shared
from testbench.commands._output import show, show_notes

SUMMARY = "show a model over a measurement and say where it fails"
EXAMPLE = "testbench compare campaign-2 --model model.json --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", metavar="RECORDING", help="a CSV, or a campaign folder")
    parser.add_argument("--model", metavar="M", required=True, help="a model.json, or a preset such as pes")
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L", help="for a bare CSV (default: the model's)")
    add_clamp_play(parser, of="this recording")
    add_effects(parser)
    parser.add_argument("--json", action="store_true", help="print the whole comparison as JSON")


def run(args: argparse.Namespace) -> int:
    from testbench.api.models.comparing import compare

    found = compare(args.recording, args.model, **shared(args))
    show_notes(found)
    show(found, "-" if args.json else None)
    return 0
