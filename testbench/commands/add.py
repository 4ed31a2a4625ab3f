"""``testbench add``: put an effect into a model and refit."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from testbench.commands._arguments import add_effects, add_held_out

if TYPE_CHECKING:
    from testbench.fitting.model_file import ModelFile
    from testbench.knit.catalogue import Catalogue

SUMMARY = "add an effect to a model, refit, and put the step on the ladder; --undo takes it back"
EXAMPLE = "testbench add stress_relaxation --model model.json --fit campaign-1 --held-out campaign-2 -o model2.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("effect", nargs="?", help="a name from `testbench effects`")
    parser.add_argument("--model", metavar="M", required=True, help="the model.json to start from")
    parser.add_argument("--fit", metavar="RECORDING", help="the recording to refit on")
    parser.add_argument("--undo", action="store_true", help="take the last step of the ladder back instead")
    add_held_out(parser)
    add_effects(parser)
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="where to write the new model.json")


def run(args: argparse.Namespace) -> int:
    """Add or undo, write, and show the ladder."""
    from gcode.support.errors import UserError
    from gcode.support.files import check_place
    from testbench.comparing.ladder import undo
    from testbench.comparing.tables import ladder_table
    from testbench.fitting.model_file import load_model_file
    from testbench.knit.catalogue import load_catalogue

    check_place(args.output)
    catalogue = load_catalogue(args.effects)
    file = load_model_file(args.model, catalogue)
    if args.undo:
        file = undo(file, catalogue)
    elif not args.effect or not args.fit:
        raise UserError("add needs the name of an EFFECT and --fit RECORDING (or --undo)")
    else:
        file = _added(args, catalogue)
    file.save(args.output)
    print(ladder_table(file))
    print(f"wrote {args.output}")
    return 0


def _added(args: argparse.Namespace, catalogue: Catalogue) -> ModelFile:
    """The model with the effect in it; notes and effects that no longer pay are told."""
    import sys

    from testbench.api.adding import add
    from testbench.comparing.ladder import idle_effects
    from testbench.knit.catalogue import BASELINE

    found = add(
        args.model, args.effect, args.fit, args.held_out, effects=catalogue, gauge_length_mm=args.gauge_length_mm
    )
    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    # A law without a strength (piezoresistance in place of contact) makes a signal that others need.
    laws = {name for name in found.model if not found.model[name].strength}
    optional = set(found.model) - set(BASELINE) - laws - {args.effect}
    for name in idle_effects(found.file, found.calibration, found.held_out, optional):
        print(f"{name} no longer pays now that {args.effect} is in: without it the held-out error hardly rises")
    return found.file
