"""Arguments and phrases that several sub-commands share."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError

if TYPE_CHECKING:
    from compensation.model.compensator import TrainedCompensator
    from gcode.support.arrays import FloatArray
    from testbench.recordings.recording import Recording

PICTURES = (".png", ".pdf", ".svg")
# Of r2: so much lost to gain and zero is worth a word.
MUCH = 0.05
DOUBTED = "was this sensor's reference recorded throughout, and without spikes?"
NOTHING_KNOWN = (
    "no sample has a conductance that the training had: is resistance_ohm in ohm, and the sensor one of the kind "
    "that was trained on?"
)


def add_recordings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recordings", nargs="+", metavar="CAMPAIGN", help="campaign folder or recording CSV")


def add_gauge_length(parser: argparse.ArgumentParser, where: str = "where it is known") -> None:
    """The gauge length of recordings that do not say their own."""
    parser.add_argument(
        "--gauge-length-mm",
        type=float,
        metavar="MM",
        help=f"of a bare CSV: unstretched length between the clamps, {where}",
    )


def read_all(args: argparse.Namespace, target: str) -> list[Recording]:
    """Every recording named on the command line; a force that is the target must have been tared."""
    from compensation.series.reading import check_tared, read_signals
    from testbench.recordings.doubts import say_gaps, say_slow

    recordings = [read_signals(path, args.gauge_length_mm) for path in args.recordings]
    for recording in recordings:
        check_tared(recording, target)
        say_slow(recording)
        say_gaps(recording)
    return recordings


def check_long_enough(
    source: str,
    compensator: TrainedCompensator,
    duration_s: float,
    what: str = "long",
    mend: str = "give a longer recording, or train with a smaller --factor or --count",
) -> None:
    """Refuse a recording of which less was recorded than the slowest memory lasts: it is all beginning."""
    if duration_s < compensator.slowest_s:
        raise UserError(
            f"{source}: {duration_s:.1f} s {what}, the compensator's slowest memory has {compensator.slowest_s:.0f} "
            f"s; {mend}"
        )


def say_if_unseen(compensator: TrainedCompensator, source: str, conductance_S: FloatArray) -> None:
    """Warn where no reading is one that the training had: gain and zero are no way from one unit to another."""
    from compensation.model.runtime import ranges_of
    from testbench.recordings.doubts import say_once

    seen, reading = ranges_of(compensator), compensator.scaling_in.apply(conductance_S)
    if ((reading < seen.low) | (reading > seen.high)).all():
        say_once(f"{source}: {NOTHING_KNOWN}")


def check_places(output: str | None, picture: str | None) -> None:
    """Refuse a file that cannot be written, before the work whose result would be lost there."""
    from gcode.support.files import check_place

    if picture and Path(picture).suffix.lower() not in PICTURES:
        raise UserError(f"--plot must end in {', '.join(PICTURES)}, got {picture}")
    check_place(output or None)
    check_place(picture or None)


def score_table(scores: dict[str, Any]) -> str:
    """The table that `train` and `score` print."""
    from compensation.series.score import interval_text

    unit = scores["compensator"]["unit"]
    lines = [
        f"{'recording':40} {'role':9} {'r2 raw':>7} {'rho2':>6} {'r2 after':>8} {'rescaled':>8} {'ordinary':>8} "
        f"{'95 %':>15} {'gain':>6} {unit:>8}"
    ]
    for row in scores["recordings"]:
        lines.append(
            f"{_short(row['source']):40} {row['role']:9} {row['r2_before']:7.3f} {row['rho2_before']:6.3f} "
            f"{row['r2_after']:8.3f} {row['r2_rescaled']:8.3f} {row['r2_ordinary']:8.3f} "
            f"{interval_text(row['r2_after_interval']):>15} {row['gain']:6.3f} {row['rms_error']:8.4f}"
        )
    return "\n".join([*lines, *_below_the_table(scores)])


def _below_the_table(scores: dict[str, Any]) -> list[str]:
    """The mean, what the columns mean, and what a reader of the scores has to know."""
    summary = scores["summary"]
    criterion = f", E = {summary['E']:.4f}" if summary["E"] is not None else ""
    lines = [
        f"mean over {summary['recordings']} {summary['over']}: r2 {summary['r2_after']:.3f}{criterion}",
        "r2 raw: conductance and target standardised per recording (the paper's); rho2: the best straight line; "
        "r2 after: the paper's, in physical units; rescaled: scored as raw is, so that gain and zero are given; "
        "ordinary: an error in level counts in full; "
        f"95 %: bootstrap over blocks of up to 60 s; {scores['compensator']['unit']}: RMS error",
    ]
    if summary["gain"] < 0:
        lines.append(
            f"below the raw signal by {-summary['gain']:.3f} of r2; raw is scored with each recording's own gain "
            "and zero, which nobody knows in use"
        )
    lost = summary["r2_rescaled"] - summary["r2_after"]
    if lost > MUCH:
        lines.append(
            f"{lost:.2f} of r2 is lost to gain and zero, as on another day or specimen: `compensation recalibrate` "
            "mends them with a minute of reference"
        )
    lines += [
        f"{_short(row['source'])}: the prediction hardly follows the reference: {DOUBTED}"
        for row in scores["recordings"]
        if row["r2_rescaled"] <= 0
    ]
    if scores["compensator"]["per_recording_scaling"]:
        lines.append(
            "scaled per recording: the mean and the spread of each recording's own target were used, which no "
            "sensor in use knows"
        )
    return lines


def cross_validation_table(recipe: Mapping[str, Any], unit: str) -> str:
    """What cross-validation found of every method, what it took, and what it promises of that."""
    from compensation.training.folds import GROUPS_FROM

    promise, recordings = recipe["cross_validated"], len(recipe["trained_on"])
    how = "contiguous parts of the training"
    if promise["whole_recordings"]:
        how = "whole recordings" if promise["folds"] == recordings else "groups of whole recordings"
    lines = [f"cross-validated on {promise['folds']} {how}: r2, ordinary r2, RMS error in {unit}"]
    for name, row in recipe["tried"].items():
        mark = _taken(recipe, name)
        lines.append(f"  {name:10} {row['r2']:7.3f} {row['r2_ordinary']:7.3f} {row['rms_error']:8.4f}{mark}")
    likely = promise["r2_interval"]
    span = "{:.3f} to {:.3f}".format(*likely) if likely else "too short for an interval"
    lines.append(f"  expect r2 {promise['r2']:.3f} ({span}); raw {promise['raw_r2']:.3f}")
    if not promise["whole_recordings"]:
        few = (
            "fewer than three recordings"
            if recordings < GROUPS_FROM
            else "recordings of which one outweighs the others"
        )
        lines.append(
            f"  for this motion and day; with the gain and zero of another day or specimen about r2 "
            f"{promise['r2_elsewhere']:.2f}: {few} cannot show it, give more, or `compensation recalibrate`"
        )
    if recordings > 1 and promise["r2"] < promise["raw_r2"]:
        lines.append(
            "  below raw, which is given each recording's own gain and zero: are all recordings of one kind of "
            "sensor, and in the same units?"
        )
    if promise["r2_ordinary"] <= 0:
        lines.append(f"  no better than a constant: {DOUBTED}")
    if recipe["chosen"] == "line":
        lines.append("  nothing is better than a straight line here, so that is what you get")
    return "\n".join(lines)


def _taken(recipe: Mapping[str, Any], name: str) -> str:
    """What a row of that table was taken for."""
    if name == recipe["chosen"]:
        return " <- chosen"
    share = recipe["weights"].get(name, 0.0)
    return f"  {100 * share:.0f} % of it" if share else ""


def _short(source: str) -> str:
    source = source.removesuffix("/recording.csv")
    return source if len(source) <= 40 else "..." + source[-37:]


def whole_numbers(text: str) -> tuple[int, ...]:
    """The whole numbers of ``4,2,2``; none where one of them is something else."""
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        return ()


def parse_sizes(text: str) -> tuple[int, ...]:
    """Hidden layers from ``4,2,2``."""
    from compensation.engines.network import DEEPEST, WIDEST

    sizes = whole_numbers(text)
    if not (1 <= len(sizes) <= DEEPEST and all(1 <= size <= WIDEST for size in sizes)):
        raise UserError(
            f"--hidden must be at most {DEEPEST} whole numbers from 1 to {WIDEST} with commas, such as 4,2,2; "
            f"got {text!r}"
        )
    return sizes


def parse_factors(text: str) -> tuple[float, ...]:
    """Smoothing factors from ``0.5,0.1,0.025,0.0025``."""
    from compensation.memories.ema import given_factors

    try:
        factors = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise UserError(f"--factors must be numbers with commas, such as 0.5,0.1,0.025; got {text!r}") from None
    given_factors(factors)
    return factors


def finish(args: argparse.Namespace, scores: dict[str, Any], note: str, table: bool = True) -> int:
    """Print the score, as a table (unless the note says it all) or as JSON, and draw it where asked."""
    if args.plot:
        from compensation.scoring.pictures import draw_scores

        draw_scores(scores, args.plot)
        note = f"{note}\nwrote {args.plot}".strip()
    shown = score_table(scores) if table else ""
    print(json.dumps(scores) if args.json else "\n".join(filter(None, [shown, note])))
    return 0
