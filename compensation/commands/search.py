"""``compensation search``: the sweep over banks and topologies."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from compensation.commands.common import add_gauge_length, check_places, whole_numbers
from gcode.support.console import processes
from gcode.support.errors import UserError

if TYPE_CHECKING:
    from compensation.search.search_space import Candidate

SUMMARY = "train and rank the paper's 912 candidates (8 smoothing banks x 114 networks); run again to resume"
EXAMPLE = "compensation search campaigns/pes-T campaigns/pes-A campaigns/pes-B --target force -o pes.search.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recordings", nargs="*", metavar="CAMPAIGN", help="training, test A and test B")
    add_gauge_length(parser)
    parser.add_argument("--target", choices=("force", "displacement"), help="what to predict")
    parser.add_argument("-o", "--output", metavar="JSONL", help="results; an interrupted search resumes")
    parser.add_argument(
        "--preset",
        choices=("paper", "fine"),  # of compensation.search.search_space, which is too heavy for --help
        default="paper",
        help="paper (default): the publication's 912; fine: its networks behind banks of finer steps",
    )
    parser.add_argument("--list", action="store_true", help="print the candidates, one `factors;layers` a line")
    parser.add_argument("--seeds", type=int, default=5, metavar="K", help="seeds a candidate (default 5)")
    parser.add_argument(
        "--bases", metavar="A,B,..", help="base sizes of the hidden layers (default 2,3,4,6,8,12,16,32, the paper's)"
    )
    parser.add_argument(
        "--per-recording", action="store_true", help="standardise each recording by itself, as the paper likely did"
    )
    parser.add_argument("--sample", type=int, metavar="N", help="only N of the candidates, spread evenly")
    parser.add_argument("--engine", choices=("fast", "exact", "sklearn"), default="fast", help="default fast")
    parser.add_argument("--workers", type=processes, default=2, metavar="N", help="processes (default 2)")
    parser.add_argument("--backend", choices=("loky", "dask"), default="loky", help="loky (default) or dask")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="dask: a running scheduler, such as tcp://host:8786")
    parser.add_argument("--top", type=int, default=15, metavar="N", help="rows to print (default 15)")
    parser.add_argument("--plot", metavar="PNG", help="write a picture of E")
    parser.add_argument("--json", action="store_true", help="print the ranking as JSON")


def run(args: argparse.Namespace) -> int:
    import json
    from dataclasses import asdict
    from pathlib import Path

    from gcode.support.console import Progress

    chosen = _chosen(args)
    if args.list:
        print("\n".join(map(str, chosen)))
        return 0
    _check(args)
    from compensation.search import search
    from compensation.search.ranking import rank, split_half_agreement

    check_places(args.output, args.plot)
    paths = tuple(str(Path(path).resolve()) for path in args.recordings)
    task = search.Task(paths, args.gauge_length_mm, args.target, args.engine, args.per_recording)
    jobs = [(candidate, seed) for seed in range(args.seeds) for candidate in chosen]
    search.check(task)
    progress = Progress("search", len(jobs))
    rows = search.sweep(task, jobs, args.output, args.workers, args.backend, args.scheduler, progress.step)
    ranking, agreement = rank(rows), split_half_agreement(rows)
    if args.plot:
        from compensation.search.pictures_search import draw_search

        draw_search(ranking, args.plot)
    if args.json:
        print(json.dumps({"ranking": [asdict(row) for row in ranking], "split_half_agreement": agreement}))
        return 0
    print(_table(ranking[: args.top]))
    print(_certainty(ranking, agreement, args.seeds))
    print(f"wrote {args.output}" + (f", {args.plot}" if args.plot else ""))
    return 0


def _chosen(args: argparse.Namespace) -> list[Candidate]:
    from compensation.search import search_space

    if args.sample is not None and args.sample < 1:
        raise UserError(f"--sample must be at least 1, got {args.sample}")
    bases = search_space.BASES if args.bases is None else whole_numbers(args.bases)
    if not bases or not all(2 <= base <= 256 for base in bases):
        raise UserError(
            f"--bases must be whole numbers from 2 to 256 with commas, such as 4,8,16; got {args.bases!r}"
        )
    chosen = search_space.candidates(args.preset, bases)
    return search_space.spread(chosen, args.sample) if args.sample else chosen


def _check(args: argparse.Namespace) -> None:
    if len(args.recordings) != 3:
        raise UserError(f"a search needs 3 campaigns: training, test A and test B; got {len(args.recordings)}")
    for flag, value in (("--target", args.target), ("-o", args.output)):
        if not value:
            raise UserError(f"a search needs {flag}; --list alone prints the candidates")
    for flag, count in (("--seeds", args.seeds), ("--top", args.top)):
        if count < 1:
            raise UserError(f"{flag} must be at least 1, got {count}")
    if args.scheduler and args.backend != "dask":
        raise UserError("--scheduler needs --backend dask")


def _table(ranking) -> str:
    lines = [
        f"{'candidate':24} {'E':>7} {'SD':>7} {'r2 A':>6} {'r2 B':>6} {'rank 95 %':>9} {'first':>6} dead  param."
    ]
    for row in ranking:
        interval = f"{row.rank_low}-{row.rank_high}"
        lines.append(
            f"{row.key:24} {row.E:7.4f} {row.spread:7.4f} {row.r2_A:6.3f} {row.r2_B:6.3f} {interval:>9} "
            f"{row.chance_first:6.0%} {row.dead}/{row.seeds} {row.parameters:6}"
        )
    return "\n".join(lines)


def _certainty(ranking, agreement: float | None, seeds: int) -> str:
    best = ranking[0]
    if seeds < 2:
        return f"{len(ranking)} candidates, {seeds} seed(s): a ranking from one seed is noise; use --seeds 5 or more"
    agree = "" if agreement is None else f"; even and odd seeds agree to rho = {agreement:.2f}"
    rivals = sum(row.rank_low <= best.rank_high for row in ranking[1:])
    return (
        f"{len(ranking)} candidates, {seeds} seeds: the first is first in {best.chance_first:.0%} of the draws; "
        f"{rivals} others cannot be told from it{agree}. "
        "E is taken on A and B, as in the paper: it is a selection on the test set."
    )
