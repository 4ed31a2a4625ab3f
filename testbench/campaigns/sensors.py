"""Which knit model a command means: a preset by name, or a model file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from gcode.support.errors import UserError
from testbench.trust import EFFECTS_HELP

if TYPE_CHECKING:
    from testbench.knit.model import KnitModel


def add_sensor_arguments(parser: argparse.ArgumentParser) -> None:
    """``--sensor``, ``--model`` and ``--effects``, the same for every command that simulates."""
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument(
        "--sensor", metavar="NAME", help="preset of a knit: pes or lycra; pes@3: the third specimen of its kind"
    )
    which.add_argument("--model", metavar="FILE", help="model.json to simulate in place of a preset")
    parser.add_argument("--effects", metavar="FILE", help=EFFECTS_HELP)


def add_past_arguments(parser: argparse.ArgumentParser) -> None:
    """``--after`` and ``--rest-s``: what the sensor went through before."""
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


def positive(text: str) -> float:
    """argparse type: a positive, finite number."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a positive number, got {text}")
    return value


def natural(text: str) -> int:
    """argparse type: a whole number, 0 or more."""
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"must be 0 or more, got {text}")
    return value


def rest(text: str) -> float:
    """argparse type: seconds, 0 to a day or so."""
    value = float(text)
    if not 0 <= value <= 1e5:
        raise argparse.ArgumentTypeError(f"must be 0 to 100000 s, got {text}")
    return value


def existing_file(path: str | Path, what: str) -> Path:
    """`path` if it is a file; a `UserError` that says `what` was wanted otherwise."""
    path = Path(path)
    if not path.is_file():
        raise UserError(f"{path}: no such {what}")
    return path
