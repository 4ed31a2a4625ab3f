"""How many errors the interval of `compensation train` holds, at nominal 90 %, on sensors that were not trained on.

    python benchmarks/bench_intervals.py [--trained 411,412,413,414] [--tested 415,416,417,418] [--kinds pes,...]

`auto` learns from campaign T of the trained specimens, of all of them together and of each alone, and predicts
campaign A of the tested ones. Of the kinds measured, others, further and unseen it is each pair of
`compensator_cases`, learned from one recording.

    python benchmarks/bench_intervals.py --halves 731,732,733,734,735,736,737,738 [--kinds pes,lycra]

Is the rule itself right, and how much is the luck of four specimens? The ridge of `auto` learns from campaign T of
half of the specimens and predicts that of the others, once for each way of halving them.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
from compensator_cases import RATE_HZ, real
from compensator_options import MEASURED, SIMULATED, add_campaigns, add_kinds, add_specimens
from compensator_rivals import seed_of

from compensation.model.compensator import TrainedCompensator
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series.preprocessing import TARGETS, Series, series_of
from compensation.training.auto import train_automatically
from compensation.training.intervals import of_another
from compensation.training.learners import Ridge, Sums
from compensation.training.options import Options

RIDGE_L2 = 1e-2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_specimens(parser, "--trained", "411,412,413,414", "numbers of the specimens that are learned from")
    add_specimens(parser, "--tested", "415,416,417,418", "numbers of those that are predicted")
    add_kinds(parser, (*SIMULATED, *MEASURED), (*SIMULATED, *MEASURED))
    add_campaigns(parser)
    add_specimens(parser, "--halves", None, "numbers of specimens: the ridge alone, every way of halving them")
    args = parser.parse_args()
    if args.halves:
        _report_halves(args)
        return
    print(f"{'':20} {'learned from':24} share of errors inside: mean (lowest to highest recording)")
    for kind in args.kinds:
        for target in TARGETS:
            rows = _simulated(args, kind, target) if kind in SIMULATED else _measured(kind, target)
            for name, shares in rows:
                told = f"{np.mean(shares):.2f} ({np.min(shares):.2f} to {np.max(shares):.2f}), {len(shares)} pairs"
                print(f"{kind + ' ' + target:20} {name:24} {told}", flush=True)


def _report_halves(args: argparse.Namespace) -> None:
    print(
        f"{'':20} share of errors inside: mean, standard deviation and range over halvings; of them in 0.85 to 0.95"
    )
    for kind in (kind for kind in args.kinds if kind in SIMULATED):
        for target in TARGETS:
            series = [_first(args.campaigns, kind, target, number) for number in args.halves]
            found = np.array(list(_halves(series, target)))
            near = float(np.mean((found >= 0.85) & (found <= 0.95)))
            print(
                f"{kind + ' ' + target:20} {found.mean():.3f}, {found.std():.3f}, "
                f"{found.min():.2f} to {found.max():.2f}; {near:.0%} of {len(found)}",
                flush=True,
            )


def _first(folder: Path, kind: str, target: str, number: int) -> Series:
    return series_of(campaigns(folder, kind, runs=TAB[:1], number=number)[TAB[0]], target, RATE_HZ)


def _halves(series: Sequence[Series], target: str) -> Iterator[float]:
    """Mean share of errors inside over one half, learned from the other, for each way of halving."""
    learner, everyone = Ridge(series, target, Options()), range(len(series))
    owner = np.repeat(everyone, [len(part) for part in series])
    sums = [Sums.of(learner.lessons, owner == number) for number in everyone]

    def errors(trained: Sequence[int], tested: int) -> np.ndarray:
        weights, bias = Sums.total([sums[number] for number in trained]).solved(RIDGE_L2)
        rows = owner == tested
        return learner.lessons.truth[rows] - learner.features[rows] @ weights - bias

    for half in combinations(everyone, len(series) // 2):
        low, high = of_another([errors([other for other in half if other != one], one) for one in half])
        found = [errors(half, one) for one in everyone if one not in half]
        yield float(np.mean([np.mean((low <= error) & (error <= high)) for error in found]))


def _simulated(args: argparse.Namespace, kind: str, target: str) -> Iterator[tuple[str, list[float]]]:
    learned, tests = (
        [
            series_of(campaigns(args.campaigns, kind, runs=runs, number=number)[runs[-1]], target, RATE_HZ)
            for number in numbers
        ]
        for numbers, runs in ((args.trained, TAB[:1]), (args.tested, TAB[:2]))
    )
    yield f"{len(learned)} specimens", _inside(train_automatically(learned, target, Options()), tests)
    alone = [_inside(train_automatically([one], target, Options()), tests) for one in learned]
    yield "one specimen", [share for shares in alone for share in shares]


def _measured(kind: str, target: str) -> Iterator[tuple[str, list[float]]]:
    shares: list[float] = []
    for case in real([kind]):
        if target not in case.targets:
            continue
        learned, tests = case.series(target)
        compensator = train_automatically(learned, target, Options(seed=seed_of(case.name, target)))
        shares += _inside(compensator, tests)
    if shares:
        yield "one recording", shares


def _inside(compensator: TrainedCompensator, tests: Sequence[Series]) -> list[float]:
    """Of each recording, the share of samples whose truth lies between `low` and `high`."""
    low, high = compensator.margins or (-np.inf, np.inf)
    errors = [part.truth - compensator.predict_series(part) for part in tests]
    return [float(np.mean((low <= error) & (error <= high))) for error in errors]


if __name__ == "__main__":
    main()
