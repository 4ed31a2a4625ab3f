"""``compensation score``: how well a compensator does on other recordings."""

from __future__ import annotations

import argparse

from compensation.commands import common

SUMMARY = "say how well a compensator predicts recordings that it has not seen"
EXAMPLE = "compensation score pes.compensator.json campaigns/pes-A campaigns/pes-B --plot pes.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("compensator", metavar="COMPENSATOR", help="file written by `compensation train`")
    common.add_recordings(parser)
    common.add_gauge_length(parser)
    parser.add_argument("--json", action="store_true", help="print the whole score, traces included, as JSON")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the score as JSON, for report and studio")
    parser.add_argument("--plot", metavar="PNG", help="write a picture: F, G and p over time, zooms, scatter")


def run(args: argparse.Namespace) -> int:
    import json

    from compensation.model.files import load
    from compensation.scoring.scorecard import score_recordings
    from compensation.series.preprocessing import apart, series_of
    from gcode.support.files import write_text
    from testbench.recordings.recording import recorded_duration_s

    common.check_places(args.output, args.plot)
    compensator = load(args.compensator)
    recordings = common.read_all(args, compensator.target)
    series = [series_of(recording, compensator.target, compensator.resampling_hz) for recording in recordings]
    apart(series, "it would count several times; give each once")
    for recording in recordings:
        common.check_long_enough(recording.source, compensator, recorded_duration_s(recording.time_s))
        common.say_if_unseen(compensator, recording.source, recording.conductance_S)
    scores = score_recordings(compensator, recordings)
    scores["compensator"]["file"] = args.compensator
    if args.output:
        write_text(args.output, json.dumps(scores, allow_nan=False) + "\n")
    return common.finish(args, scores, f"wrote {args.output}" if args.output else "")
