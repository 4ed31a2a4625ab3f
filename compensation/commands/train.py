"""``compensation train``: fit scaler, bank and network on one or more recordings."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from compensation.commands.common import add_recordings

if TYPE_CHECKING:
    from compensation.compensator import Compensator
    from compensation.training import Options
    from testbench.recording import Recording

SUMMARY = "Train a compensator on recorded campaigns."
EXAMPLE = "compensation train campaigns/pes-T --target force -o pes.compensator.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recordings(parser)
    parser.add_argument("--target", choices=("force", "displacement"), required=True, help="what to predict")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="compensator to write (JSON)")
    parser.add_argument(
        "--method",
        choices=("paper", "tuned"),
        default="paper",
        help="paper (default): EMA + (4,2,2), best of 5 starts; tuned: better, every choice by cross-validation",
    )
    parser.add_argument(
        "--twin",
        metavar="MODEL",
        help="pre-train on campaigns simulated from this fitted model (testbench fit), finish on one short CAMPAIGN",
    )
    parser.add_argument(
        "--strain",
        type=float,
        default=0.3,
        metavar="X",
        help="twin: largest strain to prepare for (default 0.3)",
    )
    parser.add_argument("--hidden", default="4,2,2", metavar="A,B,..", help="paper: hidden layers (default 4,2,2)")
    parser.add_argument("--factor", type=float, default=2.5, metavar="A", help="paper: factors A^-i (default 2.5)")
    parser.add_argument("--count", type=int, default=7, metavar="N", help="paper: number of filters (default 7)")
    parser.add_argument("--l2", type=float, default=1e-4, help="paper: MLPRegressor's alpha (default 1e-4)")
    parser.add_argument(
        "--restarts",
        type=int,
        default=5,
        metavar="K",
        help="paper: keep the best of K starts (default 5; the publication: 1)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the first start (default 0)")
    parser.add_argument("--irregular", action="store_true", help="use the samples at their own times: no resampling")
    parser.add_argument(
        "--per-recording", action="store_true", help="standardise each recording by itself (needs all of it)"
    )
    parser.add_argument("--engine", default="exact", help="exact (default), fast, or sklearn (the reference)")
    parser.add_argument("--json", action="store_true", help="print the training score as JSON")
    parser.add_argument("--plot", metavar="PNG", help="write a picture of the training score")


def run(args: argparse.Namespace) -> int:
    """Train, save, and show the score on the training recordings."""
    from compensation.commands.common import finish, parse_sizes, read_all
    from compensation.compensator_files import save
    from compensation.scorecard import score_recordings
    from compensation.training import Options

    _check(args)
    options = Options(
        sizes=parse_sizes(args.hidden),
        factor=args.factor,
        count=args.count,
        l2=args.l2,
        seed=args.seed,
        restarts=args.restarts,
        irregular=args.irregular,
        per_recording=args.per_recording,
        engine=args.engine,
    )
    recordings = read_all(args)
    compensator = _from_twin(args, recordings, options) if args.twin else _from_data(args, recordings, options)
    save(args.output, compensator)
    recipe = compensator.recipe
    note = (
        f"a = {recipe['factor']:g}, N = {recipe['count']}, L2 {recipe['l2']:g}, "
        f"hidden layers {tuple(recipe['sizes'])}, {len(compensator.networks)} network(s), "
        f"{compensator.parameter_count} parameters, {recipe['dead_networks']} of {recipe['restarts']} starts dead"
        f"\nwrote {args.output}"
    )
    if recipe["dead_networks"] == recipe["restarts"]:
        note += "\nwarning: the network is dead, its output hardly moves: give another --seed or more --restarts"
    return finish(args, score_recordings(compensator, recordings), note)


def _check(args: argparse.Namespace) -> None:
    from gcode.support.errors import UserError

    if args.restarts < 1:
        raise UserError(f"--restarts must be at least 1, got {args.restarts}")
    if not 0 <= args.l2 < float("inf"):
        raise UserError(f"--l2 must be a number from 0 on, got {args.l2:g}")
    if not 0 <= args.seed < 2**31:
        raise UserError(f"--seed must be from 0 to 2147483647, got {args.seed}")


def _from_data(args: argparse.Namespace, recordings: list[Recording], options: Options) -> Compensator:
    from compensation import tuning
    from compensation.training import train
    from gcode.support.console import Progress

    tuned = args.method == "tuned"
    progress = Progress("training", tuning.steps() if tuned else args.restarts)
    return train(recordings, args.target, options, progress.step, tuned)


def _from_twin(args: argparse.Namespace, recordings: list[Recording], options: Options) -> Compensator:
    from compensation import twin
    from compensation.preprocessing import series_of
    from gcode.support.console import Progress
    from gcode.support.errors import UserError
    from testbench.discrepancy.model_file import load_model_file

    if len(recordings) != 1:
        raise UserError(f"--twin finishes on one short recording, got {len(recordings)}")
    if not 0 < args.strain <= 2:
        raise UserError(f"--strain must be above 0 and at most 2, got {args.strain:g}")
    model = load_model_file(args.twin).model
    measured = series_of(recordings[0], args.target, options.rate_hz)
    gauge_mm = recordings[0].gauge_length_mm
    progress = Progress("training", twin.NETWORKS)
    return twin.train_from_twin(model, measured, args.target, gauge_mm, args.strain, options, progress.step)
