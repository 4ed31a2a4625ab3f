"""Arguments that several sub-commands share."""

from __future__ import annotations

import argparse


def add_recording(parser: argparse.ArgumentParser) -> None:
    """RECORDING, --held-out and --gauge-length-mm."""
    parser.add_argument("recording", help="a CSV, or a campaign folder")
    add_held_out(parser)


def add_held_out(parser: argparse.ArgumentParser) -> None:
    """--held-out and --gauge-length-mm."""
    parser.add_argument(
        "--held-out", metavar="B", help="recording to judge on (default: the last third of RECORDING)"
    )
    parser.add_argument(
        "--gauge-length-mm", type=float, metavar="L", help="needed for a bare CSV; a campaign knows its own"
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """--effects: a user's own effects."""
    from testbench.trust import EFFECTS_HELP

    parser.add_argument("--effects", metavar="FILE.py", help=EFFECTS_HELP)


def add_clamp_play(parser: argparse.ArgumentParser) -> None:
    """Declare the play of the clamps between the two recordings."""
    parser.add_argument(
        "--clamp-play-mm",
        type=float,
        default=0.0,
        metavar="MM",
        help="the sensor was clamped anew for --held-out: the zero of its displacement is free, within so many mm",
    )
