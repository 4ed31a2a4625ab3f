"""``testbench propose``: a law for what no effect explains, written as an effect."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects, add_recording

if TYPE_CHECKING:
    from gcode.support.console import Progress
    from testbench.diagnosis.search import Progress as Tell
    from testbench.proposing import Proposed

SUMMARY = "when no effect fits: find a law in what the model leaves, and write it down as an effect"
EXAMPLE = "testbench propose campaign-1 --held-out campaign-2 --model model.json -o my_effect.py"
STEPS_OF_A_LAW = 10  # about as many of the progress line: the growth of the beam, and the refits


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument("--model", metavar="M", help="the best model.json so far (default: the baseline)")
    add_effects(parser)
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE.py",
        required=True,
        help="write the effect here; its name becomes the effect's",
    )
    parser.add_argument(
        "--laws", type=int, default=2, metavar="N", help="at most N laws, one after the other (default 2)"
    )
    parser.add_argument("--plot", metavar="FILE.png", help="the picture (default: beside the effect)")
    parser.add_argument("--save-model", metavar="MODEL", help="write the model with the law put in")
    parser.add_argument("--json", metavar="OUT", help="write the whole result here ('-' prints it)")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(args: argparse.Namespace) -> int:
    """Propose, print, write."""
    import json

    from gcode.support.console import Progress
    from gcode.support.errors import UserError
    from gcode.support.files import check_place, write_json
    from testbench.api.arguments import recordings_for
    from testbench.fitting.model_file import load_model_file
    from testbench.knit.catalogue import load_catalogue
    from testbench.proposing import propose_law
    from testbench.proposing.words import as_json, proposal_text
    from testbench.proposing.writing import check_name, free_path

    if args.laws < 1:
        raise UserError(f"--laws: must be 1 or more, got {args.laws}")
    check_place(args.json, "--json")
    check_place(args.save_model, "--save-model")
    output = free_path(args.output)
    if output.suffix != ".py":
        raise UserError(f"{output}: an effect is a Python file; give a name like my_effect.py")
    picture = free_path(args.plot or output.with_suffix(".png"))
    check_place(output)
    check_place(picture, "--plot")
    catalogue = load_catalogue(args.effects)
    check_name(output.stem, str(output), catalogue.effects)
    file = load_model_file(args.model, catalogue) if args.model else None
    recording, held, _ = recordings_for(args.model, file, args.recording, args.held_out, args.gauge_length_mm)
    progress = Progress("proposing", 2 + STEPS_OF_A_LAW * args.laws)
    tell = None if args.quiet else _telling(progress)
    found = propose_law(recording, held, file, output.stem, catalogue, tell, args.laws)
    _end_of_progress(bool(tell))
    if args.json == "-":
        print(json.dumps(as_json(found), indent=2))
    else:
        print(proposal_text(found))
    if args.json and args.json != "-":
        write_json(args.json, as_json(found))
    if found.verdict == "proposed":
        _write(found, output, picture, args.save_model, quiet=args.json == "-")
    return 0


def _write(found: Proposed, output: Path, picture: Path, model: str | None, quiet: bool) -> None:
    from gcode.support.files import write_text
    from testbench.proposing.words import story
    from testbench.proposing.writing import file_text
    from testbench.report.proposal_figures import proposal
    from testbench.report.static import write_figure

    write_text(output, file_text(found.laws, found.grid, story(found), output.name))
    write_figure(proposal(found), picture)
    if model:
        found.after.save(model)
    if not quiet:
        print(f"\nwrote {output} and {picture}" + (f" and {model}" if model else ""))
        print(f"next: testbench effects --effects {output} --check")


def _end_of_progress(told: bool) -> None:
    import sys

    if told and sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)


def _telling(progress: Progress) -> Tell:
    """Steps of a progress line whose number is only nearly known beforehand."""

    def tell(text: str) -> None:
        progress.total = max(progress.total, progress.done + 2)
        progress.step(text)

    return tell
