"""``testbench add``: put an effect into a model and refit."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects, add_held_out
from testbench.commands._output import show_notes

if TYPE_CHECKING:
    from testbench.api.models.ladder import Ladder

SUMMARY = "add an effect to a model, refit, and put the step on the ladder; --undo takes it back"
EXAMPLE = "testbench add stress_relaxation --model model.json --fit campaign-1 --held-out campaign-2 -o model2.json"
IN_PLACE = {"output": "model"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("effect", nargs="?", metavar="EFFECT", help="a name from `testbench effects`")
    parser.add_argument("--model", metavar="M", required=True, help="the model.json to start from")
    parser.add_argument("--fit", metavar="RECORDING", help="the recording to refit on")
    parser.add_argument("--undo", action="store_true", help="take the last step of the ladder back instead")
    add_held_out(parser)
    add_effects(parser)
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="where to write the new model.json")


def run(args: argparse.Namespace) -> int:
    from gcode.support.errors import UserError
    from gcode.support.files import check_place
    from testbench.api.models.adding import undo

    check_place(args.output)
    if args.undo and (args.effect or args.fit or args.held_out):
        raise UserError("add --undo takes the last step back, whatever it was: leave EFFECT, --fit, --held-out out")
    if not args.undo and not (args.effect and args.fit):
        raise UserError("add needs the name of an EFFECT and --fit RECORDING (or --undo)")
    ladder = undo(args.model, effects=args.effects) if args.undo else _added(args)
    ladder.file.save(args.output)
    print(ladder)
    print(f"wrote {args.output}")
    return 0


def _added(args: argparse.Namespace) -> Ladder:
    """The ladder with the effect on it; notes, and effects that no longer pay, are told."""
    from testbench.api.models.adding import add, no_longer_pays

    found = add(
        args.model,
        args.effect,
        args.fit,
        args.held_out,
        effects=args.effects,
        gauge_length_mm=args.gauge_length_mm,
    )
    show_notes(found)
    for name in no_longer_pays(found, args.effect):
        print(f"{name} no longer pays now that {args.effect} is in: without it the held-out error hardly rises")
    return found.ladder
