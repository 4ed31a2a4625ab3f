"""The tuned compensator against the paper's network on held-out recordings, simulated and measured.

    python benchmarks/bench_compensators.py [--seeds 10] [--campaigns DIR]

Every choice of the tuned one is made on the training recording alone. Dead networks count among "all seeds".
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np

from compensation import reproduction as ours
from compensation.paper_campaigns import campaigns
from testbench.recording import read_recording

REAL = Path(__file__).resolve().parents[1] / "../shared/data/real/cb_silicone_strip"
STRIP = {"T": "multisine_600s", "A": "multisine_300s_a", "B": "random_sawtooth_a"}


def sensors(folder: Path) -> dict[str, dict]:
    """Name of the sensor -> its recordings T, A, B."""
    found = {name: {run: campaigns(folder, name)[run] for run in "TAB"} for name in ("pes", "lycra")}
    if REAL.is_dir():
        found["strip (measured)"] = {
            run: read_recording(REAL / f"cb7.5_s2_{name}.csv", 40.0) for run, name in STRIP.items()
        }
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--campaigns", type=Path, default=Path(tempfile.gettempdir()) / "knitbench-bench")
    parser.add_argument("--sensor", help="only the one whose name starts so: pes, lycra, strip")
    args = parser.parse_args()
    args.campaigns.mkdir(parents=True, exist_ok=True)
    print("mean r2 over the held-out A and B; tuned: mean and SD over 3 seeds, interval by 60 s blocks (A | B)")
    print(
        f"{'sensor':17} {'target':12} {'all seeds':>9} {'dead':>5} {'live':>6} {'best of 5':>9} {'tuned':>13} "
        f"{'- all':>6} {'- live':>6} {'param.':>6}  95 %"
    )
    for name, recordings in sensors(args.campaigns).items():
        if args.sensor and not name.startswith(args.sensor):
            continue
        for target in ("force", "displacement"):
            print(row(name, recordings, target, args.seeds), flush=True)
    print("the paper's network has 51 parameters")


def row(name: str, recordings: dict, target: str, seeds: int) -> str:
    """One line of the table."""
    series = ours.prepared(recordings, target)
    tests = [series["A"], series["B"]]
    paper = ours.over_seeds(series["T"], tests, target, seeds)
    better = [ours.tuned(series["T"], target, seed=100 * number) for number in range(3)]
    means = [np.mean(ours.scores_of(one, tests)) for one in better]
    spans = " | ".join(f"{low:.3f}..{high:.3f}" for low, high in ours.intervals_of(better[0], tests))
    every, live, tuned = paper.r2.mean(), paper.live.mean(), float(np.mean(means))
    return (
        f"{name:17} {target:12} {every:9.3f} {paper.dead.sum():2}/{seeds:<2} {live:6.3f} "
        f"{paper.best_of(5).mean():9.3f} "
        f"{tuned:6.3f} ({np.std(means):.3f}) {tuned - every:+6.3f} {tuned - live:+6.3f} "
        f"{better[0].parameter_count:6}  {spans}"
    )


if __name__ == "__main__":
    main()
