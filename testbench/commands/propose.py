"""``testbench propose``: a law for what no effect explains, written as an effect."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, add_recording, count
from testbench.commands._output import show

SUMMARY = "when no effect fits: find a law in what the model leaves, and write it down as an effect"
EXAMPLE = "testbench propose campaign-1 --held-out campaign-2 --model model.json -o my_effect.py"
IN_PLACE = {"save_model": "model"}
STEPS_OF_A_LAW = 10  # about as many of the progress line: the growth of the beam, and the refits


def add_arguments(parser: argparse.ArgumentParser) -> None:
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
        "--laws", type=count, default=2, metavar="N", help="at most N laws, one after the other (default 2)"
    )
    parser.add_argument("--plot", metavar="FILE.png", help="the picture (default: beside the effect)")
    parser.add_argument("--save-model", metavar="MODEL", help="write the model with the law put in")
    parser.add_argument("--json", metavar="OUT", help="write the whole result here ('-' prints it)")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")


def run(args: argparse.Namespace) -> int:
    from gcode.support.console import check_apart
    from gcode.support.files import check_place
    from testbench.api.arguments import catalogue_of
    from testbench.api.missing.proposing import check_effect_file, propose
    from testbench.api.progress import Counting, clear_line

    check_place(args.json)
    check_place(args.save_model)
    catalogue = catalogue_of(args.effects)
    output, picture = check_effect_file(args.output, args.plot, catalogue, args.laws)
    args.plot = str(picture)
    check_apart(args)
    tell = False if args.quiet else Counting("proposing", 2 + STEPS_OF_A_LAW * args.laws)
    found = propose(
        args.recording,
        args.held_out,
        model=args.model,
        name=output.stem,
        effects=catalogue,
        most=args.laws,
        gauge_length_mm=args.gauge_length_mm,
        progress=tell,
    )
    if tell:
        clear_line()
    written = [*found.write(output, picture)] if found.is_proposed else []
    if written and args.save_model:
        found.save(args.save_model)
        written.append(args.save_model)
    show(found, args.json)
    if args.json != "-" and written:
        print(f"\nwrote {' and '.join(map(str, written))}\nnext: testbench effects --effects {output} --check")
    elif args.json != "-":
        print("\nno law: no effect, picture or model was written")
    return 0
