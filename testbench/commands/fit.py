"""``testbench fit``: calibrate a model on a recording."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, add_recording, load_split
from testbench.commands._telling import Telling

SUMMARY = "calibrate the baseline (or a given model) on a recording; write model.json"
EXAMPLE = "testbench fit campaign-1 --held-out campaign-2 -o model.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument("--model", metavar="M", help="start from this model.json instead of the baseline")
    add_effects(parser)
    parser.add_argument("-o", "--output", default="model.json", help="where to write (default: model.json)")


def run(args: argparse.Namespace) -> int:
    """Fit, write, and say what was found."""
    from testbench.comparing.ladder import fitted_file
    from testbench.comparing.tables import errors_line, fit_table
    from testbench.fitting.baseline import starting_baseline
    from testbench.fitting.model_file import load_model_file
    from testbench.knit.catalogue import load_catalogue

    catalogue = load_catalogue(args.effects)
    calibration, held = load_split(args)
    start = load_model_file(args.model, catalogue).model if args.model else starting_baseline(calibration, catalogue)
    file = fitted_file(start, calibration, held, "given model" if args.model else "baseline", progress=Telling())
    Telling()("")
    file.save(args.output)
    print(fit_table(file))
    print(errors_line(file.history[-1]))
    print(f"wrote {args.output}")
    return 0
