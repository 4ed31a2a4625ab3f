"""``testbench experiment``: the next trajectory, chosen to separate rival hypotheses."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_bounds, add_effects, add_held_out, bounds_of, shared
from testbench.commands._output import show

SUMMARY = "propose the next trajectory: the one that separates two rival models best"
EXAMPLE = "testbench experiment creep.json relaxation.json --strain-max 30 -o next-run --plot next-run.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("models", nargs="*", metavar="MODEL", help="two or more rival model.json")
    parser.add_argument("--diagnosis", metavar="JSON", help="instead: the tied effects of this diagnosis ...")
    parser.add_argument("--fit", metavar="RECORDING", help="... each put in and refitted on this recording")
    add_held_out(parser)
    add_effects(parser)
    add_bounds(parser)
    parser.add_argument("--duration-s", type=float, default=600.0, metavar="S", help="length (default 600)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the random protocols (default 1)")
    parser.add_argument("--temperature", action="store_true", help="the temperature will be measured too")
    parser.add_argument("-o", "--output", metavar="DIR", help="write the best one's program and trajectory here")
    parser.add_argument("--plot", metavar="FILE.png", help="draw the best one and what it would show")
    parser.add_argument("--json", metavar="OUT", help="write the whole ranking here ('-' prints it)")


def run(args: argparse.Namespace) -> int:
    from gcode.programs.make import places
    from gcode.support.errors import UserError
    from gcode.support.files import check_place
    from testbench.api.experiments.designing import next_experiment
    from testbench.api.progress import Telling
    from testbench.design.protocols import MENU
    from testbench.report.writing.static import check_figure

    if args.diagnosis and (args.models or not args.fit):
        raise UserError("experiment: --diagnosis goes with --fit RECORDING and without MODEL files")
    if not args.diagnosis and len(args.models) < 2:
        told = f"give two rival MODEL files, or --diagnosis JSON --fit RECORDING; got {len(args.models)} MODEL"
        raise UserError(f"experiment: {told}")
    check_place(args.json)
    check_figure(args.plot)
    if args.output:
        places(args.output)
    tell = Telling("motion", len(MENU), "imitating on")
    found = next_experiment(
        args.diagnosis or args.models,
        args.fit if args.diagnosis else None,
        args.held_out if args.diagnosis else None,
        bounds={**bounds_of(args), "duration_s": args.duration_s},
        temperature=args.temperature,
        progress=tell,
        **shared(args),
    )
    tell("")
    written = found.program.write(args.output) if args.output else []
    if args.plot:
        found.write_picture(args.plot)
        written.append(args.plot)
    show(found, args.json)
    if args.json != "-":
        for path in written:
            print(f"wrote {path}")
    return 0
