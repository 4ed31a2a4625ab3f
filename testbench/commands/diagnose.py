"""``testbench diagnose``: what is missing from the model."""

from __future__ import annotations

import argparse

from testbench.api.progress import Telling, clear_line
from testbench.commands._arguments import add_clamp_play, add_effects, add_held_out, add_rest, count, shared
from testbench.commands._output import show

SUMMARY = "say which physical effect the model is missing, with the evidence"
EXAMPLE = "testbench diagnose campaign-1 --held-out campaign-2 --json diagnosis.json"
IN_PLACE = {"output": "model"}
CANDIDATES_OF_A_ROUND, USUAL_ROUNDS = 12, 2  # refits of a round: the best mechanisms, three of them in two laws


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recording",
        nargs="+",
        metavar="RECORDING",
        help="a CSV, or a campaign folder; several are of one specimen, as they were made in turn",
    )
    add_held_out(parser)
    add_rest(parser, "rest between several recordings (default 60); with one, ")
    parser.add_argument("--model", metavar="M", help="diagnose this model.json instead of the baseline")
    add_clamp_play(parser, "--held-out (and for each of several recordings)")
    add_effects(parser)
    parser.add_argument(
        "--repeat", type=count, default=4, metavar="N", help="find at most N effects, one after the other (default 4)"
    )
    parser.add_argument("--json", metavar="OUT", help="write the whole diagnosis here ('-' prints it)")
    parser.add_argument("-o", "--output", metavar="MODEL", help="write the model with what was found put in")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(args: argparse.Namespace) -> int:
    from gcode.support.files import check_place
    from testbench.api.missing.diagnosing import diagnose

    check_place(args.json)
    check_place(args.output)
    tell = False if args.quiet else Refits(min(args.repeat, USUAL_ROUNDS))
    found = diagnose(args.recording, args.held_out, model=args.model, most=args.repeat, progress=tell, **shared(args))
    if tell:
        clear_line()
    if args.output:
        found.save(args.output)
    show(found, args.json)
    return 0


class Refits(Telling):
    """Counts the candidates that are refitted in so many rounds; how many there will be is only nearly known."""

    def __init__(self, rounds: int) -> None:
        super().__init__("candidate", rounds * CANDIDATES_OF_A_ROUND, "refitting with ")

    def __call__(self, text: str) -> None:
        if text.startswith("screening"):
            self.total = max(self.total, self.done + CANDIDATES_OF_A_ROUND)
        super().__call__(text)
