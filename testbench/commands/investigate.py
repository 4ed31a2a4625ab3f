"""``testbench investigate``: experiments in turn, each designed on what the ones before left open."""

from __future__ import annotations

import argparse
from typing import Any

from gcode.support.console import given
from testbench.commands._arguments import BOUNDS, add_bounds, add_effects, bounds_of, count, natural, positive, rest

SUMMARY = "run experiments until it is sure what is missing: plan, run, diagnose, design the next motion"
EXAMPLE = (
    "testbench investigate hidden.json -o knit-7 --run-minutes 3 --budget-minutes 30\n"
    "  testbench investigate --port /dev/ttyUSB0 -o knit-8\n"
    "  testbench investigate --resume -o knit-7\n"
    "exit code: 0 one hypothesis is sure, 1 the time is spent, 2 bad input, 130 interrupted (go on with --resume)"
)

# What an investigation keeps as it began.
LIMITS = {*BOUNDS, "max_force_N", "gauge_length_mm"}
AS_BEGUN = {"model", "run_minutes", "fresh", "rest_s", *LIMITS, "most", "trials", "seed", "motion"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "sensor",
        nargs="?",
        metavar="SENSOR",
        help="what hangs in the simulated rig: a model.json or a preset (pes@3)",
    )
    parser.add_argument("--port", metavar="URL", help="a real rig's serial port, in place of SENSOR")
    parser.add_argument(
        "-o", "--output", dest="folder", required=True, metavar="FOLDER", help="where everything is kept"
    )
    parser.add_argument("--resume", action="store_true", help="go on with the investigation in FOLDER, as it began")
    parser.add_argument(
        "--speed",
        type=positive,
        metavar="X",
        help="record the simulated rig over its pseudo-terminal, X times faster than real (default: at once)",
    )
    add_effects(parser)
    parser.add_argument("--model", metavar="M", help="the model.json that something may be missing from")
    parser.add_argument("--run-minutes", type=positive, metavar="T", help="length of a run (default 3)")
    parser.add_argument("--budget-minutes", type=positive, metavar="T", help="time of motion at most (default 30)")
    parser.add_argument("--sure", type=float, metavar="P", help="probability to end at (default 0.95)")
    parser.add_argument("--fresh", action="store_true", help="a fresh specimen for each run (default: one that ages)")
    parser.add_argument("--rest-s", type=rest, metavar="T", help="rest between runs (default 30)")
    add_bounds(parser)
    parser.add_argument(
        "--max-force-n",
        dest="max_force_N",
        type=positive,
        metavar="F",
        help="design no motion that a likely model expects more force of; a real recording stops there, and is then "
        "planned anew with less strain",
    )
    parser.add_argument("--gauge-length-mm", type=positive, metavar="L", help="default 25")
    parser.add_argument("--trials", type=count, metavar="N", help="motions a design weighs (default 24)")
    parser.add_argument("--seed", type=natural, metavar="N", help="of noise and random motion (default 1)")
    parser.add_argument("--repeat", dest="most", type=count, metavar="N", help="effects of a diagnosis (default 2)")
    parser.add_argument(
        "--motion", choices=("designed", "perlin"), help="perlin: random motion, to compare with (default: designed)"
    )
    parser.add_argument("--json", metavar="OUT", help="write the whole investigation here ('-' prints it)")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")
    parser.set_defaults(**dict.fromkeys(AS_BEGUN | {"budget_minutes", "sure"}))  # the public function knows them


def run(args: argparse.Namespace) -> int:
    import json
    import sys

    from gcode.support.files import check_place, write_json
    from testbench.api.experiments.investigating import investigate
    from testbench.api.progress import clear_line
    from testbench.investigating.words import ending_words
    from testbench.rig.acquisition.status_words import terminal
    from testbench.rig.acquisition.stopping import stop_signals

    check_place(args.json)
    _check_resumed(args)
    to_stdout = args.json == "-"
    say = sys.stderr if to_stdout else sys.stdout

    def after_run(text: str) -> None:
        if not args.quiet:
            clear_line()
        print(text, file=say, flush=True)

    with stop_signals() as stopped:
        found = investigate(
            args.sensor,
            args.folder,
            resume=args.resume,
            progress=False if args.quiet else None,
            after_run=after_run,
            status=terminal("recording") if args.port or args.speed else None,
            stopped=stopped,
            **_asked(args),
        )
    if to_stdout:
        print(json.dumps(found.to_dict(), indent=2))
    elif args.json:
        write_json(args.json, found.to_dict())
    print(ending_words(found.state), file=say)
    if not found.state.ended:
        raise KeyboardInterrupt
    return 0 if found.is_sure else 1


def _check_resumed(args: argparse.Namespace) -> None:
    """Refuse what would have no effect on an investigation that goes on."""
    from gcode.support.errors import UserError

    said = sorted(given(args, AS_BEGUN))
    if args.resume and said:
        raise UserError(
            f"{said[0]}: an investigation goes on as it began; with --resume leave it out "
            "(--budget-minutes and --sure can be said anew)"
        )


def _asked(args: argparse.Namespace) -> dict[str, Any]:
    """What the words ask for, as the public function takes it; what they leave out it knows itself."""
    said = {name: value for name, value in vars(args).items() if value is not None}
    names = (AS_BEGUN | {"budget_minutes", "sure"}) & said.keys() - {*BOUNDS, "fresh"}
    asked = {name: said[name] for name in names}
    asked["bounds"] = bounds_of(args)
    asked["specimen"] = "fresh" if args.fresh else "aged"
    return asked | {name: getattr(args, name) for name in ("port", "speed", "effects")}
