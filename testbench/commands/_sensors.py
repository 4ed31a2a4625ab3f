"""Arguments of the commands that simulate: which sensor, which program, and what it went through before."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects, natural, positive, rest

if TYPE_CHECKING:
    from testbench.knit.model import KnitModel


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


def sensor_model(args: argparse.Namespace) -> tuple[KnitModel, str]:
    """The model that ``--sensor`` or ``--model`` names, and its name.

    Raises
    ------
    UserError
        If there is no such preset, or the file holds no model.
    """
    from testbench.knit.catalogue import load_catalogue, model_from_dict
    from testbench.knit.presets import preset
    from testbench.recordings.stored import read_model

    if args.sensor:
        return preset(args.sensor), args.sensor
    return model_from_dict(read_model(args.model), load_catalogue(args.effects), args.model), Path(args.model).name
