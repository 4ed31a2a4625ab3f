"""``compensation recalibrate``: fit a compensator to another day or specimen from a minute of reference."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from compensation.commands.common import add_gauge_length, check_places, say_if_unseen
from gcode.support.errors import UserError

if TYPE_CHECKING:
    from compensation.model.compensator import TrainedCompensator
    from compensation.series.preprocessing import Series

SUMMARY = "correct a compensator for another day or specimen, from a minute of reference"
EXAMPLE = "compensation recalibrate pes.compensator.json today.csv --seconds 60 -o today.compensator.json"
IN_PLACE = {"output": "compensator"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("compensator", metavar="COMPENSATOR", help="file written by `compensation train`")
    parser.add_argument("recording", metavar="RECORDING", help="campaign folder or CSV with the reference")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="compensator to write (JSON)")
    parser.add_argument("--seconds", type=float, default=60.0, help="how much of its beginning to use (default 60)")
    parser.add_argument(
        "--rest", action="store_true", help="the sensor rests without load: no reference is needed, it is zero"
    )
    add_gauge_length(parser)


def run(args: argparse.Namespace) -> int:
    from compensation.model.files import load, save
    from compensation.training.recalibration import LEAST_S, reach, recalibrated

    if not LEAST_S <= args.seconds < float("inf"):
        raise UserError(f"--seconds must be a number from {LEAST_S:g} on, got {args.seconds:g}")
    check_places(args.output, None)
    compensator = load(args.compensator)
    part = _reference(args, compensator)
    say_if_unseen(compensator, part.source, part.conductance_S)
    found = recalibrated(compensator, part)
    save(args.output, found)
    note, unit = found.recipe["recalibrated"][-1], compensator.unit
    left_out = note["left_out"]
    far = f", without {left_out} sample(s) beyond {reach(compensator):.3g} {unit}" if left_out else ""
    print(
        f"{note['seconds']:.0f} s of reference{far}: RMS {note['rms_before']:.3f} -> {note['rms_after']:.3f} {unit}\n"
        f"  conductance: gain {note['gain_in']:.3f}, zero {note['shift_in']:+.3f} standard deviations\n"
        f"  {compensator.target}: gain {note['gain_out']:.3f}, zero {note['shift_out']:+.3f} standard deviations\n"
        f"wrote {args.output}"
    )
    return 0


def _reference(args: argparse.Namespace, compensator: TrainedCompensator) -> Series:
    """The first seconds of the recording: its own reference, tared if that is a force, or zero throughout."""
    import numpy as np

    from compensation.series.preprocessing import TARGETS, reference_of, sampled
    from compensation.series.reading import check_tared, read_signals
    from compensation.training.recalibration import end_of_first, reach, recording_at_rest
    from testbench.recordings.doubts import say_gaps

    target, rate_hz = compensator.target, compensator.resampling_hz
    if args.rest:
        recording = recording_at_rest(compensator, args.recording, args.seconds)
        say_gaps(recording)
        return sampled(recording, TARGETS[target][0], rate_hz)
    recording = read_signals(args.recording, args.gauge_length_mm)
    end_s = end_of_first(args.seconds, recording.time_s)
    recording = recording.between(float(recording.time_s[0]), float(np.nextafter(end_s, np.inf)))
    check_tared(recording, target, reach(compensator))
    say_gaps(recording)
    return reference_of(recording, target, rate_hz)
