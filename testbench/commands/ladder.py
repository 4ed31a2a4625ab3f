"""``testbench ladder``: the errors, step by step."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects
from testbench.commands._output import show

SUMMARY = "show the errors of a model step by step, down to the noise floor"
EXAMPLE = "testbench ladder model2.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="a model.json")
    add_effects(parser)
    parser.add_argument("--json", action="store_true", help="print the history as JSON")


def run(args: argparse.Namespace) -> int:
    from testbench.api.models.ladder import ladder

    show(ladder(args.model, args.effects), "-" if args.json else None)
    return 0
