"""From the twin: two minutes of measurement with a fitted knit model behind them, and without.

    python benchmarks/bench_twin.py [--sets 21,22,23,11,12] [--trials 5] [-j 2] [--campaigns DIR]

A trial is one specimen (simulated sensors: the first 2 min of T) or one window (measured strip: five windows
of 2 min of its training recording). The baseline model is fitted on those 2 min, as `testbench fit` does. The twin
fits it again with the memories it lacks, simulates campaigns from it and its near kin, and learns from these and from
the 2 min. Beside it: the same from the baseline as it is, and without the 2 min among the lessons. All are scored on
the whole of A and B.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from compensator_options import add_campaigns, add_specimens
from joblib import Parallel, delayed

from compensation.model.compensator import TrainedCompensator
from compensation.paper.paper_campaigns import TAB, campaigns
from compensation.series.preprocessing import TARGETS, series_of
from compensation.series.score import r2
from compensation.training import twin
from compensation.training.options import Options
from compensation.training.training import train_on_series
from compensation.training.tuning import tune
from compensation.training.twin import plausible
from testbench.fitting.baseline import starting_baseline
from testbench.fitting.fit import fit
from testbench.knit.model import KnitModel
from testbench.measurements.coarser import coarser
from testbench.measurements.preparing import prepare
from testbench.recordings.files import read_recording
from testbench.recordings.recording import Recording

STRIP = Path(__file__).resolve().parents[1] / "../shared/data/real/cb_silicone_strip"
STRIP_RUNS = ("cb7.5_s2_multisine_600s", "cb7.5_s2_multisine_300s_a", "cb7.5_s2_random_sawtooth_a")
SHORT_S = 120.0
METHODS = ("best of 5", "tuned", "twin", "baseline twin", "twin alone")


class Trial(NamedTuple):
    """Two minutes to learn from, recordings to be judged on, and the largest strain in them."""

    short: Recording
    tests: list[Recording]
    amplitude: float


def trials(sensor: str, folder: Path, numbers: Sequence[int], count: int) -> Iterator[Trial]:
    """The first `count` trials of one sensor: specimens of these numbers, or windows of the strip."""
    if sensor == "strip":
        long, *tests = (read_recording(STRIP / f"{name}.csv", 40.0) for name in STRIP_RUNS)
        for index in range(count):
            yield Trial(long.between(SHORT_S * index, SHORT_S * (index + 1)), tests, 0.25)
        return
    for number in numbers[:count]:
        long, *tests = campaigns(folder, sensor, runs=TAB, number=number).values()
        yield Trial(long.between(0.0, SHORT_S), tests, 0.3)


def scores(trial: Trial, target: str) -> list[float]:
    """Mean r2 over the tests, in the order of `METHODS`."""
    options = Options()
    measured = series_of(trial.short, target, options.rate_hz)
    tests = [series_of(recording, target, options.rate_hz) for recording in trial.tests]
    measurement = prepare(trial.short)
    model = fit(starting_baseline(measurement), coarser(measurement, 10.0)).model
    own = replace(options, sizes=twin.SIZES, l2=twin.L2, history=twin.HISTORY)

    def from_twin(models: Sequence[KnitModel], share: float = twin.SHARE) -> TrainedCompensator:
        lengths = (target, trial.short.gauge_length_mm, trial.amplitude, options.rate_hz)
        return twin.learned(twin.simulated(models, *lengths), measured, target, own, share=share)

    models = plausible(model, trial.short)
    rivals = [
        train_on_series([measured], target, options),
        tune([measured], target, options),
        from_twin(models),
        from_twin([model] * len(models)),
        from_twin(models, share=0.0),
    ]
    return [float(np.mean([r2(part.truth, one.predict_series(part)) for part in tests])) for one in rivals]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_specimens(parser, "--sets", "21,22,23,11,12", "numbers of the simulated specimens")
    parser.add_argument("--trials", type=int, default=5, choices=range(1, 6))
    add_campaigns(parser)
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("--sensor", choices=("pes", "lycra", "strip"), action="append", help="default: all three")
    args = parser.parse_args()
    print(f"mean r2 over A and B after {SHORT_S:g} s; up to {args.trials} trials: mean (worst), then each")
    print(f"{'sensor':6} {'target':12}" + "".join(f" {name:>16}" for name in METHODS) + "  twin less tuned, each")
    for sensor in args.sensor or ("pes", "lycra", "strip"):
        if sensor == "strip" and not STRIP.is_dir():
            continue
        for target in TARGETS:
            cases = trials(sensor, args.campaigns, args.sets, args.trials)
            found = np.array(Parallel(n_jobs=args.jobs)(delayed(scores)(trial, target) for trial in cases))
            cells = [f"{column.mean():.3f} ({column.min():.3f})" for column in found.T]
            gains = " ".join(f"{gain:+.2f}" for gain in found[:, 2] - found[:, 1])
            print(f"{sensor:6} {target:12}" + "".join(f" {cell:>16}" for cell in cells) + f"  {gains}", flush=True)


if __name__ == "__main__":
    main()
