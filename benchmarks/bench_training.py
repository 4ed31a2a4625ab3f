"""The sweep three ways: scikit-learn's MLPRegressor, the exact compiled engine, the fast one.

    python benchmarks/bench_training.py [--sample 40] [-j 2] [--sensor pes] [--target force] [--campaigns DIR]

A spread sample of the 912 candidates is trained on a simulated 23 min recording by all three, one after the other in
the same process, and timed in CPU seconds: with one worker a core, the ratio holds on any number of cores.

Where the exact engine's loss curve leaves scikit-learn's, it is trained once more on features that differ by one
rounding (1 + 2^-52): if that curve leaves as early, the difference is the training's own, not the engine's.
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

import numpy as np
from compensator_options import add_campaigns
from joblib import Parallel, delayed

from compensation.engines.engine import DEFAULT_L2, ENGINES
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.paper.reproduction import prepared
from compensation.search import search_space
from compensation.series.preprocessing import Series
from compensation.series.score import r2
from compensation.training.options import Options
from compensation.training.untrained import training_arrays, untrained

ORDER = ("fast", "exact", "sklearn")
EQUAL = 1e-10


class Result(NamedTuple):
    """One candidate by every engine."""

    key: str
    seconds: dict[str, float]
    r2: dict[str, float]
    epochs: int
    left_at: int | None
    left_at_by_rounding: int | None
    difference: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--sensor", choices=("pes", "lycra"), default="pes")
    parser.add_argument("--target", choices=("force", "displacement"), default="force")
    add_campaigns(parser)
    parser.add_argument("-j", "--jobs", type=int, default=2)
    args = parser.parse_args()
    series = prepared(campaigns(args.campaigns, args.sensor, runs=TAB), args.target)
    everything = search_space.candidates()
    sample = search_space.spread(everything, args.sample)
    begin = time.perf_counter()
    calls = (delayed(compared)(series, args.target, candidate) for candidate in sample)
    results = Parallel(n_jobs=args.jobs)(calls)
    print(f"{len(sample)} of {len(everything)} candidates, {len(series['T'])} rows, one start each", end="; ")
    print(f"{args.sensor}, {args.target}; {time.perf_counter() - begin:.0f} s in {args.jobs} processes")
    report(results, len(everything) / len(sample))


def compared(series: dict[str, Series], target: str, candidate: search_space.Candidate) -> Result:
    """Train one candidate by every engine."""
    for name in ("fast", "exact"):  # compile, or load what was compiled
        ENGINES[name](np.ones((10, 2)), np.ones(10), (2,), 0, DEFAULT_L2)
    blank = untrained([series["T"]], target, Options(alphas=candidate.alphas))
    features, truth = training_arrays(blank, [series["T"]])
    parts = [series[name] for name in "AB"]
    tests = [(blank.features(p.time_s, p.conductance_S), blank.scaling_out.apply(p.truth)) for p in parts]
    fits, seconds = {}, {}
    for name in ORDER:
        begin = time.process_time()
        fits[name] = ENGINES[name](features, truth, candidate.sizes, 0, DEFAULT_L2)
        seconds[name] = time.process_time() - begin
    scores = {name: float(np.mean([r2(y, fit.network(x)) for x, y in tests])) for name, fit in fits.items()}
    exact, reference = fits["exact"].loss_curve, fits["sklearn"].loss_curve
    left_at, difference = departure(exact, reference)
    by_rounding = None
    if left_at is not None:
        rounded = ENGINES["exact"](features * (1 + 2**-52), truth, candidate.sizes, 0, DEFAULT_L2)
        by_rounding, _ = departure(exact, rounded.loss_curve)
    return Result(candidate.key, seconds, scores, len(reference), left_at, by_rounding, difference)


def departure(one: np.ndarray, other: np.ndarray) -> tuple[int | None, float]:
    """First epoch at which two loss curves differ by more than `EQUAL` (None: never), and the largest difference."""
    shared = min(len(one), len(other))
    apart = np.abs(one[:shared] - other[:shared])
    over = np.flatnonzero(apart > EQUAL)
    return (int(over[0]) if len(over) else None), float(apart.max())


def report(results: list[Result], times: float) -> None:
    """Print the ratios, the scores, and how equal the exact engine is."""
    total = {name: sum(result.seconds[name] for result in results) for name in ORDER}
    scores = {name: np.array([result.r2[name] for result in results]) for name in ORDER}
    print(f"{'engine':10} {'CPU s':>8} {'ratio':>7} {'median held-out r2':>20} {'912 would take':>15}")
    for name in reversed(ORDER):
        ratio = total["sklearn"] / total[name]
        print(
            f"{name:10} {total[name]:8.1f} {ratio:6.1f}x {np.median(scores[name]):20.4f} "
            f"{total[name] * times:10.0f} CPU s"
        )
    better = int((scores["fast"] > scores["sklearn"]).sum())
    gain = float(np.median(scores["fast"] - scores["sklearn"]))
    print(f"fast beats sklearn in {better} of {len(results)} candidates; median difference {gain:+.4f}")
    same = sum(result.left_at is None for result in results)
    print(f"exact engine's loss curve equals scikit-learn's to {EQUAL:g} to the end in {same} of {len(results)}")
    for result in results:
        if result.left_at is not None:
            print(
                f"  {result.key}: {result.left_at} of {result.epochs} epochs, then within {result.difference:.0e}; "
                f"one rounding in the features parts the exact engine from itself at epoch "
                f"{result.left_at_by_rounding}"
            )


if __name__ == "__main__":
    main()
