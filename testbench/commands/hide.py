"""``testbench hide``: make a case for the diagnosis, its truth sealed."""

from __future__ import annotations

import argparse

from gcode.support.console import given

SUMMARY = "make two recordings of a sensor with an effect hidden in it, the truth sealed apart"
EXAMPLE = "testbench hide --effect stress_relaxation --strength 5 --seed 3 -o case"

WORLDS_HELP = (
    "matched, mismatched (all laws differ from the catalogue's), other_elasticity, bouc_wen, other_contact, "
    "other_drift or carbon_black"
)
MOTIONS_HELP = "perlin, holds, triangles, return_to_zero or mix"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--effect",
        metavar="NAME",
        help="an effect of the catalogue, none, unknown, or several with commas (drawn by seed, and not told)",
    )
    parser.add_argument(
        "--strength",
        type=float,
        default=5.0,
        metavar="X",
        help="RMS of what the sensor's own base laws cannot absorb, over the noise floor (default %(default)g)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="sensor, motion and noise; the same seed, the same files (default: random)",
    )
    parser.add_argument("--world", default="matched", metavar="WORLD", help=f"{WORLDS_HELP} (default %(default)s)")
    parser.add_argument(
        "--minutes", type=float, default=23.0, metavar="T", help="length of each recording (default %(default)g)"
    )
    parser.add_argument(
        "--rate-hz", type=float, default=40.0, metavar="F", help="mean sampling rate (default %(default)g)"
    )
    parser.add_argument(
        "--noise", default="any", metavar="KIND", help="white, ar1, pink or any of them by seed (default %(default)s)"
    )
    parser.add_argument(
        "--protocol",
        default="perlin",
        metavar="KIND",
        help=f"motion: {MOTIONS_HELP} (default %(default)s)",
    )
    parser.add_argument("--force-only", action="store_true", help="record no resistance")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="a new folder for the case")


def run(args: argparse.Namespace) -> None:
    from testbench.api.files.hiding import hide
    from testbench.recordings.channels import FORCE, RESISTANCE

    channels = (FORCE,) if args.force_only else (FORCE, RESISTANCE)
    asked = given(args, ("strength", "seed", "world", "minutes", "rate_hz", "noise", "protocol"))
    print(hide(args.effect, args.output, channels=channels, **asked))
