"""Arguments of the commands that simulate: which sensor, which program, and what it went through before."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, natural, positive, rest


def add_simulation_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare which sensor it is, which program is played on it, and what it went through before."""
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument(
        "--sensor", metavar="NAME", help="preset of a knit: pes or lycra; pes@3: the third specimen of its kind"
    )
    which.add_argument("--model", metavar="FILE", help="model.json to simulate in place of a preset")
    add_effects(parser)
    parser.add_argument("--program", required=True, metavar="FILE", help="Mach4 program that moves the stage")
    parser.add_argument(
        "--seed", type=natural, default=1, metavar="N", help="of noise and sampling times (default 1)"
    )
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="default: from the program's header, else 25"
    )
    parser.add_argument(
        "--after",
        nargs="+",
        default=[],
        metavar="CAMPAIGN",
        help="earlier campaigns or programs of this sensor, which remembers them (default: never stretched before)",
    )
    parser.add_argument("--rest-s", type=rest, default=600.0, metavar="T", help="rest after each (default 600)")
