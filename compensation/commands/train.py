"""``compensation train``: fit scaler, bank and network on one or more recordings."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from compensation.commands import common
from gcode.support.console import given
from gcode.support.errors import UserError

if TYPE_CHECKING:
    from compensation.model.compensator import TrainedCompensator
    from compensation.training.options import Options
    from testbench.recordings.recording import Recording

SUMMARY = "train a compensator on one or more recordings, with what cross-validation promises of it"
EXAMPLE = "compensation train campaigns/pes-T --target force -o pes.compensator.json"
# What --method paper is told, and the other methods choose themselves.
OWN_CHOICES = ("hidden", "factors", "factor", "count", "l2", "restarts", "engine")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    common.add_recordings(parser)
    common.add_gauge_length(parser, "which --twin needs")
    parser.add_argument("--target", choices=("force", "displacement"), required=True, help="what to predict")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="compensator to write (JSON)")
    parser.add_argument(
        "--method",
        choices=("auto", "paper", "tuned"),  # of compensation.training.training, which is too heavy for --help
        help="auto (default): ridge, paper and several networks, weighted by cross-validation, or a line; paper: "
        "EMA + (4,2,2), best of 5 starts (the default where an option of its own is given); tuned: 8 networks",
    )
    parser.add_argument(
        "--twin",
        metavar="MODEL",
        help="learn from one short CAMPAIGN and from campaigns simulated from this fitted model (testbench fit)",
    )
    parser.add_argument("--strain", type=float, metavar="X", help="twin: largest strain to prepare for (default 0.3)")
    _add_own_choices(parser)
    parser.add_argument("--seed", type=int, default=0, help="seed of the first start (default 0)")
    parser.add_argument("--irregular", action="store_true", help="use the samples at their own times: no resampling")
    parser.add_argument(
        "--per-recording", action="store_true", help="standardise each recording by itself (needs all of it)"
    )
    parser.add_argument("--json", action="store_true", help="print the training score as JSON")
    parser.add_argument("--plot", metavar="PNG", help="write a picture of the training score")


def _add_own_choices(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--hidden", metavar="A,B,..", help="paper: hidden layers (default 4,2,2)")
    parser.add_argument("--factor", type=float, metavar="A", help="paper: factors A^-i (default 2.5)")
    parser.add_argument("--count", type=int, metavar="N", help="paper: number of filters (default 7)")
    parser.add_argument(
        "--factors", metavar="A,B,..", help="paper: smoothing factors set by hand, such as 0.5,0.1,0.025,0.0025"
    )
    parser.add_argument("--l2", type=float, help="paper: MLPRegressor's alpha (default 1e-4)")
    parser.add_argument(
        "--restarts", type=int, metavar="K", help="paper: keep the best of K starts (default 5; the publication: 1)"
    )
    parser.add_argument(
        "--engine",
        choices=("exact", "fast", "sklearn"),  # of compensation.engines.engine, which is too heavy for --help
        help="paper: exact (default), fast, or sklearn (the reference)",
    )


def run(args: argparse.Namespace) -> int:
    from compensation.model.files import save
    from compensation.scoring.scorecard import score_recordings

    options = _options(args)
    common.check_places(args.output, args.plot)
    recordings = common.read_all(args, "force" if args.twin else args.target)  # a twin is fitted on the force as well
    # Where no method is named, it is the paper's if one of its options is given.
    args.method = args.method or ("paper" if given(args, OWN_CHOICES) or args.per_recording else "auto")
    _check_long_enough(args, options, recordings)
    compensator = _from_twin(args, recordings, options) if args.twin else _from_data(args, recordings, options)
    save(args.output, compensator)
    recipe = compensator.recipe
    note = (
        f"{_bank(recipe)}, L2 {recipe['l2']:g}, {_networks(compensator)}, "
        f"{compensator.parameter_count} parameters, {recipe['dead_networks']} of {recipe['restarts']} starts dead"
        f"\nwrote {args.output}"
    )
    cross_validated = "cross_validated" in recipe
    if cross_validated:
        note = f"{common.cross_validation_table(recipe, compensator.unit)}\n{note}"
    if compensator.is_dead:
        note += "\nwarning: the network is dead, its output hardly moves: give another --seed or more --restarts"
    # Where there is what was predicted unseen, a score of what was learned by heart would only mislead.
    return common.finish(args, score_recordings(compensator, recordings), note, table=not cross_validated)


def _check_long_enough(args: argparse.Namespace, options: Options, recordings: list[Recording]) -> None:
    """A filter that remembers longer than the recording lasts never leaves its initial value.

    The slowest one of `auto`, and of what `tuned` tries first, is as slow as the paper's.
    """
    from testbench.recordings.recording import recorded_duration_s

    longest_s = max(recorded_duration_s(recording.time_s) for recording in recordings)
    if options.slowest_s > longest_s and not args.twin:
        raise UserError(
            f"the slowest filter remembers {options.slowest_s:.0f} s and the longest recording has {longest_s:.0f} "
            "s; record longer, or take --method paper with a smaller --factor or --count"
        )


def _networks(compensator: TrainedCompensator) -> str:
    """How many of which hidden layers: a stack has several kinds."""
    from collections import Counter

    kinds = Counter(network.sizes for network in compensator.networks)
    named = [f"{count} x {sizes}" if sizes else "a linear one" for sizes, count in kinds.items()]
    return f"{len(compensator.networks)} network(s) with hidden layers {', '.join(named)}"


def _bank(recipe) -> str:
    from compensation.memories.ema import smoothing_factors

    alphas = recipe["alphas"]
    if alphas == smoothing_factors(recipe["factor"], recipe["count"]).tolist():
        return f"a = {recipe['factor']:g}, N = {recipe['count']}"
    return f"smoothing factors {', '.join(f'{alpha:g}' for alpha in alphas)}"


def _options(args: argparse.Namespace) -> Options:
    """The options that were given, checked; the others are the paper's."""
    from compensation.training.options import Options

    _check(args)
    own = given(args, OWN_CHOICES)
    if "hidden" in own:
        own["sizes"] = common.parse_sizes(own.pop("hidden"))
    if "factors" in own:
        own["alphas"] = common.parse_factors(own.pop("factors"))
    return Options(seed=args.seed, irregular=args.irregular, per_recording=args.per_recording, **own)


def _check(args: argparse.Namespace) -> None:
    from compensation.training.options import HIGHEST_SEED

    chosen = "--twin" if args.twin else f"--method {args.method}" if args.method in ("auto", "tuned") else ""
    for name in OWN_CHOICES:
        if chosen and getattr(args, name) is not None:
            raise UserError(f"--{name} is for --method paper only: {chosen} makes that choice itself; leave it out")
    if args.factors is not None and (args.factor is not None or args.count is not None):
        raise UserError("--factors sets the smoothing factors by hand; leave out --factor and --count")
    if args.twin and args.method:
        raise UserError("--twin is a method of its own; leave --method out")
    if args.strain is not None and not args.twin:
        raise UserError("--strain says what the twin prepares for; it needs --twin")
    if args.restarts is not None and args.restarts < 1:
        raise UserError(f"--restarts must be at least 1, got {args.restarts}")
    if args.l2 is not None and not 0 <= args.l2 <= 1e6:  # far below it all starts are dead
        raise UserError(f"--l2 must be a number from 0 to 1e6, got {args.l2:g}")
    if not 0 <= args.seed <= HIGHEST_SEED:
        raise UserError(f"--seed must be from 0 to {HIGHEST_SEED}, got {args.seed}")


def _from_data(args: argparse.Namespace, recordings: list[Recording], options: Options) -> TrainedCompensator:
    from compensation.series.preprocessing import apart, series_of
    from compensation.training.training import METHODS, steps
    from gcode.support.console import Progress

    series = [series_of(recording, args.target, options.resampling_hz) for recording in recordings]
    series = apart(series, "give each recording once, or cross-validation would predict it from itself")
    progress = Progress("training", steps(args.method, series, options))
    return METHODS[args.method](series, args.target, options, progress.step)


def _from_twin(args: argparse.Namespace, recordings: list[Recording], options: Options) -> TrainedCompensator:
    from compensation.series.reading import UNKNOWN_LENGTH_MM
    from compensation.training import twin
    from gcode.support.console import Progress
    from testbench.results.model_file import load_model_file

    if len(recordings) != 1:
        raise UserError(f"--twin learns from one short recording, got {len(recordings)}")
    strain = 0.3 if args.strain is None else args.strain
    if not 0 < strain <= 2:
        raise UserError(f"--strain must be above 0 and at most 2, got {strain:g}")
    if args.gauge_length_mm is None and recordings[0].gauge_length_mm == UNKNOWN_LENGTH_MM:
        raise UserError(f"{recordings[0].source}: --twin needs the length between the clamps; add --gauge-length-mm")
    model = load_model_file(args.twin).model
    progress = Progress("training", twin.steps())
    return twin.train_from_twin(model, recordings[0], args.target, strain, options, progress.step)
