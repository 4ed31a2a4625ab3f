"""``testbench effects``: the catalogue of physical effects."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects

if TYPE_CHECKING:
    from testbench.knit.catalogue import Catalogue

SUMMARY = "list the physical effects, show one's card, check or start your own"
EXAMPLE = "testbench effects stress_relaxation --plot relaxation.png"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="show the card of this effect")
    parser.add_argument(
        "--plot", nargs="?", const="", metavar="FILE.png", help="with NAME: draw data without and with it"
    )
    add_effects(parser)
    parser.add_argument(
        "--check", action="store_true", help="try the rules that every effect keeps (NAME, or all of FILE.py)"
    )
    parser.add_argument("--new", metavar="NAME", help="write a commented template for an effect of your own")
    parser.add_argument("-o", "--output", metavar="FILE.py", help="with --new: where to (default: NAME.py)")
    parser.add_argument("--markdown", action="store_true", help="print the list as a Markdown table")


def run(args: argparse.Namespace) -> int:
    _check(args)
    if args.new:
        return _new(args.new, args.output or f"{args.new}.py")
    from testbench.knit import card
    from testbench.knit.catalogue import load_catalogue

    catalogue = load_catalogue(args.effects)
    if args.check:
        return _rules(catalogue, args.name)
    if args.name is None:
        print(card.catalogue_markdown(catalogue) if args.markdown else card.catalogue_text(catalogue))
        return 0
    print(card.card_text(catalogue[args.name], catalogue))
    if args.plot is not None:
        from testbench.knit.showcase import draw

        output = args.plot or f"{args.name}.png"
        draw(catalogue[args.name], Path(output))
        print(f"\npicture    {output}")
    return 0


def _check(args: argparse.Namespace) -> None:
    """Refuse options that what is asked for has no use for."""
    from gcode.support.errors import UserError

    if args.output and not args.new:
        raise UserError("-o says where --new NAME writes its template; name that as well")
    if args.plot is not None and (args.name is None or args.check):
        raise UserError("--plot draws one effect beside its card: give its NAME, and leave --check out")
    if args.plot:
        from testbench.report.writing.static import check_figure

        check_figure(args.plot)
    if args.markdown and (args.name is not None or args.check):
        raise UserError("--markdown is the list of all effects; leave NAME and --check out")
    if args.new and (args.name or args.check or args.markdown):
        raise UserError("--new writes a template and nothing else; leave NAME, --check and --markdown out")


def _new(name: str, output: str) -> int:
    from testbench.knit.template import write_template

    write_template(name, Path(output))
    print(f"wrote {output}; edit it, then: testbench effects --effects {output} --check")
    return 0


def _rules(catalogue: Catalogue, name: str | None) -> int:
    from testbench.knit.rules import checked

    all_keep = True
    for effect, problems in checked(catalogue, name):
        all_keep &= not problems
        print("\n  ".join([f"{effect}:", *problems]) if problems else f"{effect}: keeps all rules")
    return 0 if all_keep else 1
