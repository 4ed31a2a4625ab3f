"""Arguments that several sub-commands share, and what their words may be."""

from __future__ import annotations

import argparse
from typing import Any

from gcode.support.console import given, whole

natural, count = whole(0), whole(1)  # argparse types


SHARED = ("effects", "gauge_length_mm", "clamp_play_mm", "rest_s", "after", "seed")


def shared(args: argparse.Namespace) -> dict[str, Any]:
    """What was said of the options that many commands have, as the public functions take it."""
    return given(args, [name for name in SHARED if name in args])


def add_recording(parser: argparse.ArgumentParser) -> None:
    """RECORDING, --held-out and --gauge-length-mm."""
    parser.add_argument("recording", metavar="RECORDING", help="a CSV, or a campaign folder")
    add_held_out(parser)


def add_held_out(parser: argparse.ArgumentParser) -> None:
    """--held-out and --gauge-length-mm."""
    parser.add_argument(
        "--held-out", metavar="B", help="recording to judge on (default: the last third of RECORDING)"
    )
    parser.add_argument(
        "--gauge-length-mm", type=positive, metavar="L", help="needed for a bare CSV; a campaign knows its own"
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """--effects: a user's own effects."""
    from testbench.trust import EFFECTS_HELP

    parser.add_argument("--effects", metavar="FILE.py", action=_Once, help=EFFECTS_HELP)


class _Once(argparse.Action):
    """An option that is refused a second time, where the last word would drop the first silently."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(f"{option_string} was given twice; put all classes of your own into one file")
        setattr(namespace, self.dest, values)


def add_clamp_play(parser: argparse.ArgumentParser, of: str = "--held-out") -> None:
    """Declare the play of the clamps between the recording that is fitted on and another one, called `of`."""
    parser.add_argument(
        "--clamp-play-mm",
        type=float,
        default=0.0,
        metavar="MM",
        help=f"the sensor was clamped anew for {of}: the zero of its displacement is free, within so many mm",
    )


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


BOUNDS = ("v_max_mm_per_s", "a_max_mm_per_s2", "strain_max_percent")


def add_bounds(parser: argparse.ArgumentParser) -> None:
    """--v-max, --a-max, --strain-max: what a designed motion keeps."""
    for option, name, default, unit, words in (
        ("--v-max", BOUNDS[0], 10.0, "MM/S", "speed limit"),
        ("--a-max", BOUNDS[1], 20.0, "MM/S2", "acceleration limit"),
        ("--strain-max", BOUNDS[2], 30.0, "%", "largest strain"),
    ):
        told = f"{words} (default {default:g})"
        parser.add_argument(option, dest=name, type=positive, default=default, metavar=unit, help=told)


def bounds_of(args: argparse.Namespace) -> dict[str, float]:
    """What `add_bounds` declared, as the public functions take it; what was not said is left out."""
    return given(args, BOUNDS)


def positive(text: str) -> float:
    """argparse type: a positive, finite number."""
    value = _number(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a positive number, got {text!r}")
    return value


def add_rest(parser: argparse.ArgumentParser, several: str = "") -> None:
    """Declare the rest of one specimen before another recording; `several`: what is said of more than one before."""
    parser.add_argument(
        "--rest-s",
        type=positive,
        metavar="S",
        help=f"{several}--held-out is of the same specimen, so long after the recording (default: of a fresh one)",
    )


def rest(text: str) -> float:
    """argparse type: seconds, 0 to a day or so."""
    value = _number(text)
    if not 0 <= value <= 1e5:
        raise argparse.ArgumentTypeError(f"must be 0 to 100000 s, got {text!r}")
    return value


def _number(text: str) -> float:
    """What the words say; NaN where they are no number."""
    try:
        return float(text)
    except ValueError:
        return float("nan")
