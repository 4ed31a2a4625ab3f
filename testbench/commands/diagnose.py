"""``testbench diagnose``: what is missing from the model."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, add_recording, load_recording

SUMMARY = "say which physical effect the model is missing, with the evidence"
EXAMPLE = "testbench diagnose campaign-1 --held-out campaign-2 --json diagnosis.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument("--model", metavar="M", help="diagnose this model.json instead of the baseline")
    add_effects(parser)
    parser.add_argument("--json", metavar="OUT", help="write the whole diagnosis here ('-' prints it)")
    parser.add_argument("-o", "--output", metavar="MODEL", help="write the model with what was found put in")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(args: argparse.Namespace) -> int:
    """Diagnose, print, write."""
    import json
    import sys

    from gcode.support.files import write_json
    from testbench.discrepancy import diagnose
    from testbench.discrepancy.model_file import check_same_set_up, load_model_file
    from testbench.discrepancy.tables import diagnosis_table
    from testbench.knit.catalogue import load_catalogue

    catalogue = load_catalogue(args.effects)
    file = load_model_file(args.model, catalogue) if args.model else None
    gauge_length_mm = args.gauge_length_mm or (file.gauge_length_mm if file else None) or None
    recording = load_recording(args.recording, gauge_length_mm)
    held = load_recording(args.held_out, gauge_length_mm) if args.held_out else None
    if file is not None:
        check_same_set_up(file, recording, args.model)
    tell = None if args.quiet else _teller(sys.stderr.isatty())
    diagnosis = diagnose(recording, held, file.model if file else None, catalogue, tell)
    if tell and sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    if args.output:
        diagnosis.after.save(args.output)
    if args.json == "-":
        print(json.dumps(diagnosis.to_dict(), indent=2))
        return 0
    if args.json:
        write_json(args.json, diagnosis.to_dict())
    print(diagnosis_table(diagnosis))
    return 0


def _teller(live: bool):
    """Progress on stderr: one line redrawn where somebody watches, a line a stage elsewhere."""
    import sys

    def tell(text: str) -> None:
        if not live and text.startswith("screening"):
            return
        print(f"\r\x1b[K{text} ..." if live else f"{text} ...", end="" if live else "\n", file=sys.stderr, flush=True)

    return tell
