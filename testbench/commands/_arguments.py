"""Arguments and loading that several sub-commands share."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from testbench.fitting.measurement import Measurement
    from testbench.recordings.recording import Recording

BEYOND = 0.02  # of the calibrated range; less is noise


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


def load_recording(path: str, gauge_length_mm: float | None) -> Recording:
    """Read one recording; all that use this need its displacement."""
    from testbench.recordings.checks import check_displacement
    from testbench.recordings.recording import read_recording

    recording = read_recording(path, gauge_length_mm)
    check_displacement(recording)
    return recording


def load_split(args: argparse.Namespace, recording: str | None = None) -> tuple[Measurement, Measurement]:
    """Calibration and held-out measurements from the arguments."""
    from testbench.fitting.measurement import split

    first = load_recording(recording or args.recording, args.gauge_length_mm)
    held = load_recording(args.held_out, args.gauge_length_mm) if args.held_out else None
    parts = split(first, held)
    beyond = beyond_calibration(*parts)
    if beyond:
        print(f"note: {beyond}", file=sys.stderr)
    return parts


def beyond_calibration(calibration: Measurement, held: Measurement) -> str:
    """What to say where the held-out strain leaves the range that was fitted on; empty where it does not."""
    fitted, judged = (part.signals["strain"][part.counts] for part in (calibration, held))
    margin = BEYOND * float(fitted.max() - fitted.min())
    if judged.max() <= fitted.max() + margin and judged.min() >= fitted.min() - margin:
        return ""
    spans = [f"{100 * strain.min():.1f} to {100 * strain.max():.1f} %" for strain in (judged, fitted)]
    return (
        f"{held.recording.source}: the held-out strain, {spans[0]}, leaves the {spans[1]} that was fitted on; "
        "there its errors are those of an extrapolation"
    )
