"""``testbench diagnose``: what is missing from the model."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects, add_recording, load_recording

if TYPE_CHECKING:
    from gcode.support.console import Progress

SUMMARY = "say which physical effect the model is missing, with the evidence"
EXAMPLE = "testbench diagnose campaign-1 --held-out campaign-2 --json diagnosis.json"
STEPS_OF_A_ROUND = 14  # about as many of the progress line: the screening, and the refits of the best mechanisms


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument("--model", metavar="M", help="diagnose this model.json instead of the baseline")
    add_effects(parser)
    parser.add_argument(
        "--repeat", type=int, default=4, metavar="N", help="find at most N effects, one after the other (default 4)"
    )
    parser.add_argument("--json", metavar="OUT", help="write the whole diagnosis here ('-' prints it)")
    parser.add_argument("-o", "--output", metavar="MODEL", help="write the model with what was found put in")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(args: argparse.Namespace) -> int:
    """Diagnose, print, write."""
    import json
    import sys

    from gcode.support.console import Progress
    from gcode.support.errors import UserError
    from gcode.support.files import write_json
    from testbench.diagnosis import diagnose
    from testbench.diagnosis.words import diagnosis_table
    from testbench.fitting.model_file import check_same_set_up, load_model_file
    from testbench.knit.catalogue import load_catalogue

    if args.repeat < 1:
        raise UserError(f"--repeat: must be 1 or more, got {args.repeat}")
    catalogue = load_catalogue(args.effects)
    file = load_model_file(args.model, catalogue) if args.model else None
    gauge_length_mm = args.gauge_length_mm or (file.gauge_length_mm if file else None) or None
    recording = load_recording(args.recording, gauge_length_mm)
    held = load_recording(args.held_out, gauge_length_mm) if args.held_out else None
    if file is not None:
        check_same_set_up(file, recording, args.model)
    progress = Progress("diagnosing", 2 + STEPS_OF_A_ROUND)
    tell = None if args.quiet else _telling(progress)
    found = diagnose(recording, held, file.model if file else None, catalogue, tell, args.repeat)
    if tell and sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    if args.output:
        found.after.save(args.output)
    if args.json == "-":
        print(json.dumps(found.to_dict(), indent=2))
        return 0
    if args.json:
        write_json(args.json, found.to_dict())
    print(diagnosis_table(found))
    return 0


def _telling(progress: Progress) -> Callable[[str], None]:
    """Steps of a progress line whose number is only nearly known beforehand."""

    def tell(text: str) -> None:
        progress.total = max(progress.total, progress.done + 2)
        progress.step(text)

    return tell
