"""``testbench fit``: calibrate a model on a recording."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_clamp_play, add_effects, add_recording, add_rest, shared
from testbench.commands._output import show_notes

SUMMARY = "calibrate the baseline (or a given model) on a recording; write model.json"
EXAMPLE = "testbench fit campaign-1 --held-out campaign-2 -o model.json"
IN_PLACE = {"output": "model"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recording(parser)
    parser.add_argument("--model", metavar="M", help="start from this model.json instead of the baseline")
    add_clamp_play(parser)
    add_rest(parser)
    add_effects(parser)
    parser.add_argument(
        "-o", "--output", default="model.json", metavar="MODEL", help="where to write (default: model.json)"
    )


def run(args: argparse.Namespace) -> int:
    from gcode.support.files import check_place
    from testbench.api.models.fitting import fit

    check_place(args.output)
    found = fit(args.recording, args.held_out, model=args.model, **shared(args))
    show_notes(found)
    found.save(args.output)
    print(found)
    print(f"wrote {args.output}")
    return 0
