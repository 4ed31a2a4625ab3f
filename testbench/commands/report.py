"""``testbench report``: one self-contained page."""

from __future__ import annotations

import argparse

from testbench.commands._arguments import add_effects, positive, shared

SUMMARY = "put recordings, model, diagnosis and compensator into one self-contained HTML page"
EXAMPLE = "testbench report --recording campaign-1 --held-out campaign-2 --model model.json -o report.html"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--recording", action="append", default=[], metavar="R", help="a CSV or a campaign folder; may be repeated"
    )
    parser.add_argument("--held-out", metavar="B", help="the recording that errors are judged on")
    parser.add_argument("--model", metavar="M", help="a model.json with its ladder")
    add_effects(parser)
    parser.add_argument(
        "--diagnosis",
        action="append",
        default=[],
        metavar="D",
        help="the JSON of `testbench diagnose`; repeat it for those that led to each step of the model, oldest first",
    )
    parser.add_argument("--compensator", metavar="SCORE", help="the JSON of `compensation score`")
    parser.add_argument("--commands", metavar="TXT", help="the command lines that led here, one a line")
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L", help="for bare CSVs")
    parser.add_argument("--resistance", action="store_true", help="show the resistance in kΩ, not the conductance")
    parser.add_argument("--title", default="", help="heading of the page")
    parser.add_argument("--format", choices=("html", "md"), default="html", help="html (default) or md")
    parser.add_argument("--figures", metavar="DIR", help="also write every figure there, as PNG and PDF")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to write (default: report.html or report.md)")


def run(args: argparse.Namespace) -> int:
    from gcode.support.files import check_folder, check_place
    from testbench.api.files.reporting import make_report
    from testbench.comparing.numbers import plain

    check_place(args.output)
    if args.figures is not None:
        check_folder(args.figures)
    made = make_report(
        args.recording,
        held_out=args.held_out,
        model=args.model,
        diagnoses=args.diagnosis,
        compensator=args.compensator,
        commands=args.commands,
        title=args.title,
        resistance=args.resistance,
        **shared(args),
    )
    report, *figures = made.write(args.output or f"report.{args.format}", args.format, args.figures)
    print(f"wrote {report} ({plain(report.stat().st_size / 1e6, 2)} MB)")
    if figures:
        print(f"wrote {figures[0].parent} ({len(figures) // 2} figures, each as PNG and PDF)")
    return 0
