"""``testbench ladder``: the errors, step by step."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects

SUMMARY = "show the errors of a model step by step, down to the noise floor"
EXAMPLE = "testbench ladder model2.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", help="a model.json")
    add_effects(parser)
    parser.add_argument("--json", action="store_true", help="print the history as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the ladder."""
    import json

    from testbench.comparing.tables import ladder_table
    from testbench.fitting.model_file import load_model_file
    from testbench.knit.catalogue import load_catalogue

    file = load_model_file(args.model, load_catalogue(args.effects))
    if args.json:
        print(json.dumps([dict(step) for step in file.history], indent=2))
    else:
        print(ladder_table(file))
    return 0
