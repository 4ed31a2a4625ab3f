"""The sweep three ways: scikit-learn's MLPRegressor, the exact compiled engine, the fast one.

    python benchmarks/bench_training.py [--sample 40] [--campaigns DIR]

A spread sample of the 912 candidates is trained on a simulated 23 min PES recording by all three in this process, one
after the other, and timed in CPU seconds: with one worker a core, the same ratio holds on any number of cores.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from compensation import search
from compensation.engines import DEFAULT_L2, ENGINES
from compensation.paper_campaigns import campaigns
from compensation.reproduction import prepared
from compensation.score import r2
from compensation.training import Options, training_arrays, untrained

ORDER = ("fast", "exact", "sklearn")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    recordings = campaigns(args.campaigns, "pes")
    series = prepared({name: recordings[name] for name in "TAB"}, "force")
    everything = search.candidates()
    # An odd stride walks through banks, bases and depths alike.
    sample = [everything[index * len(everything) // args.sample] for index in range(args.sample)]
    for name in ("fast", "exact"):
        ENGINES[name](np.ones((10, 2)), np.ones(10), (2,), 0, DEFAULT_L2)
    seconds = dict.fromkeys(ORDER, 0.0)
    scores: dict[str, list[float]] = {name: [] for name in ORDER}
    differences: list[float] = []
    for candidate in sample:
        options = Options(factor=candidate.factor, count=candidate.count)
        blank = untrained([series["T"]], "force", options)
        features, truth = training_arrays(blank, [series["T"]])
        tests = [
            (
                blank.features(series[name].time_s, series[name].conductance_S),
                blank.scaling_out.apply(series[name].truth),
            )
            for name in "AB"
        ]
        fits = {}
        for name in ORDER:
            begin = time.process_time()
            fits[name] = ENGINES[name](features, truth, candidate.sizes, 0, DEFAULT_L2)
            seconds[name] += time.process_time() - begin
            scores[name].append(float(np.mean([r2(target, fits[name].network(inputs)) for inputs, target in tests])))
        exact, reference = fits["exact"].loss_curve, fits["sklearn"].loss_curve
        shared = min(len(exact), len(reference))
        differences.append(float(np.abs(exact[:shared] - reference[:shared]).max()))
    print(f"{len(sample)} of {len(everything)} candidates, {len(truth)} rows, one start each")
    print(f"{'engine':10} {'CPU s':>8} {'ratio':>7} {'median held-out r2':>20} {'912 would take':>15}")
    for name in reversed(ORDER):
        whole = seconds[name] * len(everything) / len(sample)
        ratio = seconds["sklearn"] / seconds[name]
        print(f"{name:10} {seconds[name]:8.1f} {ratio:6.1f}x {np.median(scores[name]):20.3f} {whole:13.0f} s")
    same = sum(difference < 1e-10 for difference in differences)
    print(f"exact engine's loss curve equal to scikit-learn's to 1e-10 in {same} of {len(sample)} candidates;")
    print(f"largest difference {max(differences):.1e}: rounding grows over a long training of a large network")


if __name__ == "__main__":
    main()
