"""``testbench ladder``: the errors, step by step."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects

SUMMARY = "show the errors of a model step by step, down to the noise floor"
EXAMPLE = "testbench ladder model2.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", help="a model.json")
    add_effects(parser)
    parser.add_argument("--json", action="store_true", help="print the history as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the ladder."""
    import json

    from testbench.api.ladder import ladder

    found = ladder(args.model, args.effects)
    print(json.dumps(found.to_dict(), indent=2) if args.json else found)
    return 0
