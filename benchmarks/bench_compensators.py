"""The tuned compensator against the paper's network on held-out recordings, simulated and measured.

    python benchmarks/bench_compensators.py [--seeds 10] [--sets 21,22] [-j 2] [--campaigns DIR]

Every choice of the tuned one is made on the training recording alone. The campaigns are of numbers that nothing was
developed on. Dead networks count among "all seeds".
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

from compensation.paper import reproduction as ours
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series import score
from compensation.series.preprocessing import TARGETS, Series
from testbench.recording import Recording, read_recording

REAL = Path(__file__).resolve().parents[1] / "../shared/data/real"
STRIP = ("cb7.5_s2_multisine_600s", "cb7.5_s2_multisine_300s_a", "cb7.5_s2_random_sawtooth_a")
HEAD = (
    f"{'sensor':14} {'target':12} {'all seeds':>9} {'dead':>5} {'live':>6} {'best of 5':>9} {'tuned (SD)':>14} "
    f"{'worst':>6} {'- all':>6} {'- live':>6} {'95 % of - live':>15} {'param.':>6}  chosen on the training recording"
)


def simulated(folder: Path, numbers: list[int]) -> Iterator[tuple[str, list[Recording]]]:
    """T, A and B of both presets, from each campaign number."""
    for number in numbers:
        for sensor in ("pes", "lycra"):
            yield f"{sensor} {number}", list(campaigns(folder, sensor, runs=TAB, number=number).values())


def measured() -> Iterator[tuple[str, list[Recording]]]:
    """A strip trained on one motion and tested on two others; another strip, trained on its first part."""
    if not REAL.is_dir():
        return
    strip = REAL / "cb_silicone_strip"
    yield "strip cb7.5", [read_recording(strip / f"{name}.csv", 40.0) for name in STRIP]
    whole = read_recording(strip / "cb10_s1_holds8_speeds_v5.csv", 40.0)
    cut = 0.6 * whole.duration_s
    yield "strip cb10", [whole.between(0.0, cut), whole.between(cut, whole.duration_s)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--sets", default="21,22", help="campaign numbers")
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    parser.add_argument("--sensor", help="only those whose name starts so: pes, lycra, strip")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    sensors = [*simulated(args.campaigns, [int(number) for number in args.sets.split(",")]), *measured()]
    wanted = [(name, recordings) for name, recordings in sensors if name.startswith(args.sensor or "")]
    print(f"mean r2 over the held-out recordings, {args.seeds} seeds of either; 95 %: bootstrap over 60 s blocks")
    print(HEAD)
    rows = (
        delayed(row)(name, ours.prepared(dict(enumerate(recordings)), target), target, args.seeds)
        for name, recordings in wanted
        for target in TARGETS
    )
    for text in Parallel(n_jobs=args.jobs, return_as="generator")(rows):
        print(text, flush=True)
    print("the paper's network has 51 parameters")


def row(name: str, series: dict[int, Series], target: str, seeds: int) -> str:
    """One line of the table."""
    training, *tests = series.values()
    paper = ours.over_seeds(training, tests, target, seeds)
    better = ours.tuned_seeds(training, target, seeds)
    means = np.array([np.mean(ours.scores_of(one, tests)) for one in better])
    every, live, tuned = paper.r2.mean(), paper.live.mean(), means.mean()
    low, high = difference(paper, ours.predictions_of(better, tests), tests)
    recipe = better[0].recipe
    memory = "; ".join(f"{member['history']} L2 {member['l2']:g}" for member in recipe["members"])
    return (
        f"{name:14} {target:12} {every:9.3f} {paper.dead.sum():2}/{seeds:<2} {live:6.3f} "
        f"{paper.best_of(min(5, seeds)).mean():9.3f} {f'{tuned:.3f} ({means.std():.3f})':>14} {means.min():6.3f} "
        f"{tuned - every:+6.3f} {tuned - live:+6.3f} {f'{low:+.3f}..{high:+.3f}':>15} "
        f"{better[0].parameter_count:6}  a = {recipe['factor']:g}, N = {recipe['count']}, "
        f"{tuple(recipe['sizes'])}: {memory}"
    )


def difference(paper: ours.Seeds, better: tuple[np.ndarray, ...], tests: list[Series]) -> tuple[float, float]:
    """95 % interval of mean r2, tuned less the paper's live seeds; both drawn on the same blocks."""
    draws = []
    for part, tuned, published in zip(tests, better, paper.predictions, strict=True):

        def mean(outputs: np.ndarray, part: Series = part) -> np.ndarray:
            return np.mean([score.block_draws(part.truth, output, part.time_s) for output in outputs], axis=0)

        draws.append(mean(tuned) - mean(published[~paper.dead]))
    low, high = np.quantile(np.mean(draws, axis=0), [0.025, 0.975])
    return float(low), float(high)


if __name__ == "__main__":
    main()
