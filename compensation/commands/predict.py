"""``compensation predict``: apply a compensator to a recording; no reference is needed."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from compensation.commands.common import NOTHING_KNOWN, check_long_enough, check_places
from gcode.support.errors import UserError

if TYPE_CHECKING:
    from compensation.model.compensator import TrainedCompensator
    from gcode.support.arrays import IntArray

SUMMARY = "apply a compensator to a recording of resistance; no reference is needed"
EXAMPLE = "compensation predict worn.csv --compensator pes.compensator.json -o compensated.csv"
WORDS = {
    "BAD_READING": "with a resistance that is no positive number: the last value is repeated",
    "BAD_STEP": "with a time that is out of order: the last value is repeated",
    "UNSEEN_READING": "with a conductance that the training did not have: do not rely on them",
    "UNSEEN_HISTORY": "after a history that the training did not have, if only by a little",
}
WHAT_IS_GOOD = "of good samples (a positive resistance, times in order)"
MEND = "mend time_s and resistance_ohm (`testbench import` has --sort and --drop-bad), or give a longer recording"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", metavar="RECORDING", help="campaign folder, or CSV with time_s,resistance_ohm")
    parser.add_argument("--compensator", required=True, metavar="FILE", help="file written by `compensation train`")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="CSV",
        help="time_s, force_N, low_N, high_N (or displacement_mm, ...), status",
    )
    parser.add_argument("--target", choices=("force", "displacement"), help="refuse a compensator of the other")
    parser.add_argument("--unit", choices=("N", "mm"), help="refuse a compensator of another unit")


def run(args: argparse.Namespace) -> int:
    from compensation.model.files import load
    from compensation.model.prediction import predicted
    from compensation.model.runtime import Status
    from compensation.series.preprocessing import TARGETS
    from compensation.series.reading import read_samples, without_reference
    from gcode.support.files import atomic_path
    from testbench.recordings.doubts import say_slow
    from testbench.recordings.recording import recorded_duration_s

    check_places(args.output, None)
    compensator = load(args.compensator)
    _check_target(args, compensator)
    time_s, resistance_ohm = read_samples(args.recording)
    found = predicted(compensator, time_s, resistance_ohm)
    good = found.status & int(Status.BAD_READING | Status.BAD_STEP) == 0  # the others repeat the last value
    told = () if good.all() else (WHAT_IS_GOOD, f"{(~good).sum()} of {len(good)} are faulty: {MEND}")
    check_long_enough(args.recording, compensator, recorded_duration_s(time_s[good]) if good.any() else 0.0, *told)
    say_slow(without_reference(args.recording, time_s[good], resistance_ohm[good]))
    frame = found.to_frame()
    with atomic_path(args.output) as temporary:
        frame.to_csv(temporary, index=False, float_format="%.6f")
    low, high = found.value.min(), found.value.max()
    print(
        f"{len(frame)} samples: {TARGETS[compensator.target][0]} {low:.3f} to {high:.3f} {compensator.unit}",
        *_doubts(found.status),
        *([f"  {NOTHING_KNOWN}"] if (found.status[good] & int(Status.UNSEEN_READING)).all() else []),
        f"wrote {args.output}",
        sep="\n",
    )
    return 0


def _doubts(status: IntArray) -> Iterator[str]:
    """One line for each doubt that the compensator had, with the share of the samples that it holds for."""
    from compensation.model.runtime import Status

    for flag in Status:
        share = float((status & int(flag) != 0).mean())
        if share and flag != Status.STARTING:
            shown = f"{share:.1%}" if share >= 0.0005 else "under 0.1%"
            yield f"  {shown} {WORDS[flag.name or '']} (status {int(flag)})"


def _check_target(args: argparse.Namespace, compensator: TrainedCompensator) -> None:
    """Refuse a compensator of what is not asked for."""
    for flag, wanted, has in (("--target", args.target, compensator.target), ("--unit", args.unit, compensator.unit)):
        if wanted not in (None, has):
            raise UserError(
                f"{args.compensator} gives {compensator.target} in {compensator.unit}, not the {flag} {wanted} that "
                "is asked for; take another compensator, or leave the option out"
            )
