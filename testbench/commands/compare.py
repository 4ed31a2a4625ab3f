"""``testbench compare``: where a model fails."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, load_recording

SUMMARY = "show a model over a measurement and say where it fails"
EXAMPLE = "testbench compare campaign-2 --model model.json --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("recording", help="a CSV, or a campaign folder")
    parser.add_argument("--model", metavar="M", required=True, help="a model.json")
    parser.add_argument("--gauge-length-mm", type=float, metavar="L", help="for a bare CSV (default: the model's)")
    add_effects(parser)
    parser.add_argument("--json", action="store_true", help="print the whole comparison as JSON")


def run(args: argparse.Namespace) -> int:
    """Compare and print."""
    import json

    from testbench.comparing.compare import compare
    from testbench.comparing.tables import comparison_table
    from testbench.fitting.measurement import prepare
    from testbench.fitting.model_file import check_same_set_up, load_model_file
    from testbench.knit.catalogue import load_catalogue

    file = load_model_file(args.model, load_catalogue(args.effects))
    recording = load_recording(args.recording, args.gauge_length_mm or file.gauge_length_mm or None)
    check_same_set_up(file, recording, args.model)
    measurement = prepare(recording)
    elsewhere = recording.source != file.fitted_on
    result = compare(file.model, measurement, free_offset=elsewhere)
    print(json.dumps(result.to_dict(), indent=2) if args.json else comparison_table(result))
    return 0
